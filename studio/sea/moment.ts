// A flight at a time between its rows.
import { Quaternion, Vector3 } from "three";
import type { Flight } from "./flight.ts";

export interface Moment {
  row: number; // the last that is not later
  exact: number; // with the part on the way to the next
  position: Vector3; // of the nose [m]
  attitude: Quaternion; // from nose-to-tail, starboard, up axes
  angles: number[]; // of the joint groups [rad]
  fins: [number, number]; // port, starboard [rad]
}

/** Value at a part between two of four rows: a curve through all of them. */
function through(a: number, b: number, c: number, d: number, t: number): number {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/** Value at a part between rows. */
function between(flight: Flight, row: number, value: (k: number) => number): number {
  const first = Math.floor(row);
  const near = (k: number): number => value(Math.min(flight.count - 1, Math.max(0, first + k)));
  return through(near(-1), near(0), near(1), near(2), row - first);
}

/** Place of the nose at a part between rows [m]. */
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
