// The state of a flight at a time between two rows, by interpolation.
import { Quaternion, Vector3 } from "three";
import type { Flight } from "./flight.ts";

export interface Moment {
  row: number; // the last row that is not later
  exact: number; // row plus the fraction of the way to the next row
  position: Vector3; // place of the nose: east, north, up [m]
  attitude: Quaternion; // turns the body's axes (nose to tail, starboard, up) into the world's
  angles: number[]; // angles of the joint groups [rad]
  fins: [number, number]; // angles of the port and starboard fins [rad]
}

/** Interpolate between the middle two of four rows: a Catmull-Rom curve. */
function through(a: number, b: number, c: number, d: number, t: number): number {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/** Value of a column at a fractional row. */
function between(flight: Flight, row: number, value: (k: number) => number): number {
  const first = Math.floor(row);
  const near = (k: number): number => value(Math.min(flight.count - 1, Math.max(0, first + k)));
  return through(near(-1), near(0), near(1), near(2), row - first);
}

/** Place of the nose at a fractional row [m]. */
export function placeOf(flight: Flight, row: number): [number, number, number] {
  const part = (i: number): number => between(flight, row, (k) => flight.position(k)[i] ?? 0);
  return [part(0), part(1), part(2)];
}

export function momentOf(flight: Flight, time: number): Moment {
  const first = flight.at(time);
  const next = Math.min(flight.count - 1, first + 1);
  const step = flight.time(next) - flight.time(first);
  const part = step > 0 ? Math.min(1, Math.max(0, (time - flight.time(first)) / step)) : 0;
  const column = (name: string, i: number): number => {
    const value = between(flight, first + part, (k) => flight.value(name, k, i));
    return Number.isFinite(value) ? value : 0;
  };
  return {
    row: first,
    exact: first + part,
    position: new Vector3(...placeOf(flight, first + part)),
    attitude: new Quaternion(...flight.attitude(first))
      .slerp(new Quaternion(...flight.attitude(next)), part)
      .normalize(),
    angles: Array.from({ length: flight.head.joints }, (_, i) => column("angle", i)),
    fins: [column("fin", 0), column("fin", 1)],
  };
}
