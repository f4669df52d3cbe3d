// A flight at a time between its rows.
import { Quaternion, Vector3 } from "three";
import type { Flight } from "./flight.ts";

export interface Moment {
  row: number; // the last that is not later
  position: Vector3; // of the nose [m]
  attitude: Quaternion; // from nose-to-tail, starboard, up axes
  angles: number[]; // of the joint groups [rad]
  fins: [number, number]; // port, starboard [rad]
}

/** Value at a part between two of four rows: a curve through all of them. */
function through(a: number, b: number, c: number, d: number, t: number): number {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

export function momentOf(flight: Flight, time: number): Moment {
  const row = flight.at(time);
  const next = Math.min(flight.count - 1, row + 1);
  const step = flight.time(next) - flight.time(row);
  const part = step > 0 ? Math.min(1, Math.max(0, (time - flight.time(row)) / step)) : 0;
  const rows = [Math.max(0, row - 1), row, next, Math.min(flight.count - 1, next + 1)] as const;
  const between = (value: (k: number) => number): number => {
    const [a, b, c, d] = rows.map(value) as [number, number, number, number];
    return through(a, b, c, d, part);
  };
  const column = (name: string, i: number): number => {
    const value = between((k) => flight.value(name, k, i));
    return Number.isFinite(value) ? value : 0;
  };
  const place = [0, 1, 2].map((i) => between((k) => flight.position(k)[i] ?? 0));
  return {
    row,
    position: new Vector3().fromArray(place),
    attitude: new Quaternion(...flight.attitude(row)).slerp(new Quaternion(...flight.attitude(next)), part).normalize(),
    angles: Array.from({ length: flight.head.joints }, (_, i) => column("angle", i)),
    fins: [column("fin", 0), column("fin", 1)],
  };
}
