// The geometry of a mission: the corners of its course, and the box around it.
import type { Flight, Mission } from "./flight.ts";

export type Point = readonly [number, number, number]; // east, north, up [m]

/** Corners of the course: start, waypoints, home [m]; each at the depth of the leg that leads there. */
export function cornersOf(mission: Mission): Point[] {
  const { waypoints, start, home } = mission;
  const [first, last] = [waypoints[0]?.[2] ?? 0, waypoints.at(-1)?.[2] ?? 0];
  const corners = waypoints.map(([x, y, depth]): Point => [x, y, -depth]);
  return [[...start, -first], ...corners, ...(mission.stay ? [] : [[...home, -last] as const])];
}

/** The box that the picture shows [m]: its floor is the ground, its top the surface. */
export interface Extent {
  low: Point;
  high: Point;
}

export function extentOf(flight: Flight): Extent {
  const { mission } = flight.head;
  const [low, high] = [
    [Infinity, Infinity],
    [-Infinity, -Infinity],
  ] as [[number, number], [number, number]];
  const track = Array.from({ length: Math.ceil(flight.count / 50) }, (_, k) => flight.position(50 * k));
  for (const place of [mission.start, mission.home, ...mission.waypoints, ...mission.fence, ...track])
    for (const k of [0, 1] as const) {
      low[k] = Math.min(low[k], place[k]);
      high[k] = Math.max(high[k], place[k]);
    }
  const border = Math.max(3, 0.06 * Math.hypot(high[0] - low[0], high[1] - low[1]));
  return {
    low: [low[0] - border, low[1] - border, -mission.bottom],
    high: [high[0] + border, high[1] + border, 0],
  };
}
