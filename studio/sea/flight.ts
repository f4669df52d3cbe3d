// A flight, live or from a log: rows of what the robot did and believed, ten per second.

import type { Column } from "../core.ts";

/** A waypoint: east, north, depth on the way there [m], speed [m/s], radius in which it counts as reached [m]. */
export type Waypoint = readonly [number, number, number, number, number];
export type Place = readonly [number, number]; // east, north [m]

export interface Mission {
  name: string;
  text?: string; // the mission's purpose, in a line
  waypoints: Waypoint[];
  start: Place;
  home: Place;
  home_radius: number; // m
  fence: Place[]; // corners; empty without a fence
  bottom: number; // m, depth of the ground
  depth_max: number; // m
  current: Place; // current at the surface, east and north [m/s]
  stay: boolean; // whether the robot surfaces at the last waypoint instead of going home
}

/** A name in the program, with the sentence that explains it. */
export interface Said {
  name: string;
  text: string;
}

/** The part of a flight that does not change while it lasts. */
export interface Head {
  title: string; // such as "box, seed 0", or the name of a log
  robot: string;
  mission: Mission;
  modes: Said[];
  reasons: Said[]; // reasons, by bit
  joints: number; // number of joint groups
}

export class Flight {
  count = 0; // number of rows
  private rows = new Float64Array();
  private readonly width: number;
  private readonly places = new Map<string, { place: number; width: number }>();

  constructor(
    readonly head: Head,
    columns: Column[],
  ) {
    let place = 0;
    for (const { name, width } of columns) {
      this.places.set(name, { place, width });
      place += width;
    }
    this.width = place;
  }

  /** Append rows of numbers. */
  append(rows: Float64Array): void {
    const used = this.count * this.width;
    if (used + rows.length > this.rows.length) {
      const larger = new Float64Array(Math.max(used + rows.length, 2 * this.rows.length));
      larger.set(this.rows);
      this.rows = larger;
    }
    this.rows.set(rows, used);
    this.count += rows.length / this.width;
  }

  has(name: string): boolean {
    return this.places.has(name);
  }

  /** Number `part` of a column in row `k`; NaN if there is none. */
  value(name: string, k: number, part = 0): number {
    const found = this.places.get(name);
    if (found === undefined || part >= found.width || k < 0 || k >= this.count) return Number.NaN;
    return this.rows[k * this.width + found.place + part] ?? Number.NaN;
  }

  /** Time of a row [s]. */
  time(k: number): number {
    return this.value("time", k);
  }

  get begin(): number {
    return this.count === 0 ? 0 : this.time(0);
  }

  get end(): number {
    return this.count === 0 ? 0 : this.time(this.count - 1);
  }

  /** The last row that is not later than a time [s]. */
  at(time: number): number {
    let [low, high] = [0, this.count - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time(middle) <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  // values of live flights and logs: the true one if it is known

  /** Whether the true motion is known; a log of the robot itself has only its estimate. */
  get true(): boolean {
    return this.has("position");
  }

  /** East, north and up of the nose [m]. */
  position(k: number): [number, number, number] {
    return this.true
      ? [this.value("position", k, 0), this.value("position", k, 1), this.value("position", k, 2)]
      : this.believed(k);
  }

  /** Place of the nose in the robot's estimate: east, north, up [m]. */
  believed(k: number): [number, number, number] {
    const place = (part: number): number => this.value("position_estimated", k, part);
    return [place(0), place(1), -this.value("depth_estimated", k)];
  }

  /** Unit quaternion x, y, z, w that turns the body's axes (nose to tail, starboard, up) into the world's. */
  attitude(k: number): [number, number, number, number] {
    const name = this.true ? "attitude" : "attitude_estimated";
    const part = (i: number): number => this.value(name, k, i);
    return [part(1), part(2), part(3), part(0)];
  }

  depth(k: number): number {
    return -this.position(k)[2];
  }

  /** Speed through the water, ahead positive [m/s]. */
  speed(k: number): number {
    return this.has("velocity") ? -this.value("velocity", k, 0) : this.value("speed_estimated", k);
  }

  /** Horizontal distance between the believed and the true place [m]; NaN if either is unknown. */
  error(k: number): number {
    if (!this.true) return Number.NaN;
    const [a, b] = [this.position(k), this.believed(k)];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  }

  mode(k: number): Said {
    return this.head.modes[this.value("mode", k)] ?? { name: "", text: "" };
  }

  reasons(k: number): Said[] {
    const bits = this.value("reasons", k);
    return this.head.reasons.filter((_, bit) => Math.floor(bits / 2 ** bit) % 2 === 1);
  }
}
