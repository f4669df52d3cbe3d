// Where the robot is while it swims: settled beats one after another, without jumps where the gait changes.
import type { Point } from "./body.ts";
import { POSE } from "./core.ts";

const EASE = 0.12; // s in which the drawn body follows a changed gait
const ALIGN = 0.8; // s in which a straight path turns to the left of the picture

export interface Pose extends Point {
  heading: number; // of the head's axis from nose to tail, counter-clockwise from x [rad]
}

/** A settled beat: rows of time, x, y, heading, bends. */
export class Beat {
  readonly count: number;
  readonly step: Pose; // from the first to the last row
  readonly mean: number; // heading over the beat [rad]
  readonly sway: Point; // mean place of the nose beside the straight way from the first to the last row

  constructor(
    readonly rows: Float64Array,
    readonly width: number,
    readonly frequency: number, // Hz
    readonly straight: boolean,
  ) {
    this.count = rows.length / width - 1;
    const [first, last] = [this.row(0), this.row(this.count)];
    this.step = {
      x: this.of(last, 1) - this.of(first, 1),
      y: this.of(last, 2) - this.of(first, 2),
      heading: this.of(last, 3) - this.of(first, 3),
    };
    this.mean = this.average(3, this.step.heading);
    const sway = { x: this.average(1, this.step.x), y: this.average(2, this.step.y) };
    this.sway = { x: sway.x - this.of(first, 1), y: sway.y - this.of(first, 2) };
  }

  /** Pose of the nose from the beat's start, and the bends, at a part of the beat. */
  at(part: number): { pose: Pose; bends: number[] } {
    const place = part * this.count;
    const k = Math.min(this.count - 1, Math.floor(place));
    const [a, b, t] = [this.row(k), this.row(k + 1), place - k];
    const value = (column: number): number => this.of(a, column) + t * (this.of(b, column) - this.of(a, column));
    const first = this.row(0);
    return {
      pose: { x: value(1) - this.of(first, 1), y: value(2) - this.of(first, 2), heading: value(3) },
      bends: Array.from({ length: this.width - POSE }, (_, link) => value(POSE + link)),
    };
  }

  /** Mean of a column over the beat, without its drift. */
  private average(column: number, drift: number): number {
    let sum = 0;
    for (let k = 0; k < this.count; k++) sum += this.of(this.row(k), column) - (k / this.count) * drift;
    return sum / this.count;
  }

  private row(k: number): number {
    return k * this.width;
  }

  private of(row: number, column: number): number {
    return this.rows[row + column] ?? 0;
  }
}

/** The point `by` turned by an angle, from `from`. */
function moved(from: Point, angle: number, by: Point): Point {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return { x: from.x + c * by.x - s * by.y, y: from.y + s * by.x + c * by.y };
}

export class Motion {
  beat: Beat | null = null;
  phase = 0; // part of the beat
  base: Pose = { x: 0, y: 0, heading: 0 }; // of the beat's start
  private rest: number[] = []; // what the drawn heading and bends are still off

  /** Go on with another beat at the same phase and place. */
  change(beat: Beat): void {
    const before = this.beat === null ? null : this.now();
    const old = this.beat;
    this.beat = beat;
    if (before === null || old === null) {
      this.base = { x: 0, y: 0, heading: -beat.mean };
      this.rest = [];
      return;
    }
    this.base.heading += old.mean - beat.mean;
    const { pose } = beat.at(this.phase);
    const nose = moved({ x: 0, y: 0 }, this.base.heading, pose);
    Object.assign(this.base, { x: before.pose.x - nose.x, y: before.pose.y - nose.y });
    this.rest = [];
    const after = this.now();
    const same = after.bends.length === before.bends.length;
    const bends = same ? after.bends.map((bend, k) => (before.bends[k] ?? 0) - bend) : [];
    this.rest = same ? [before.pose.heading - after.pose.heading, ...bends] : [];
  }

  /** Let time pass [s of the motion, s on the screen]. */
  advance(seconds: number, shown: number): void {
    const { beat } = this;
    if (beat === null) return;
    this.phase += seconds * beat.frequency;
    for (; this.phase >= 1; this.phase -= 1) {
      const heading = this.base.heading + beat.step.heading;
      this.base = { ...moved(this.base, this.base.heading, beat.step), heading };
    }
    const kept = Math.exp(-shown / EASE);
    this.rest = this.rest.map((off) => off * kept);
    if (beat.straight) this.align(-Math.expm1(-seconds / ALIGN));
  }

  /** Pose of the nose and bends as they are drawn. */
  now(): { pose: Pose; bends: number[] } {
    if (this.beat === null) throw new Error("no beat yet");
    const { pose, bends } = this.beat.at(this.phase);
    const place = moved(this.base, this.base.heading, pose);
    const heading = this.base.heading + pose.heading + (this.rest[0] ?? 0);
    return { pose: { ...place, heading }, bends: bends.map((bend, k) => bend + (this.rest[k + 1] ?? 0)) };
  }

  /** Where the nose would be without its sway, and the direction of the body. */
  get mean(): Pose {
    if (this.beat === null) return this.base;
    const { step, mean, sway } = this.beat;
    const way = { x: sway.x + step.x * this.phase, y: sway.y + step.y * this.phase };
    return {
      ...moved(this.base, this.base.heading, way),
      heading: this.base.heading + mean + step.heading * this.phase,
    };
  }

  /** Whether the drawn body still follows a change. */
  get unsettled(): boolean {
    return this.rest.some((off) => Math.abs(off) > 1e-3);
  }

  /** Pose and bends at a part of the beat, as if the robot were there in its beat now. */
  ghost(part: number): { pose: Pose; bends: number[] } {
    if (this.beat === null) throw new Error("no beat yet");
    const { pose, bends } = this.beat.at(part);
    const { step, sway: middle } = this.beat;
    const turned = this.base.heading + (this.phase - part) * step.heading;
    const sway = { x: pose.x - part * step.x - middle.x, y: pose.y - part * step.y - middle.y };
    const { x, y } = this.mean;
    return { pose: { ...moved({ x, y }, turned, sway), heading: turned + pose.heading }, bends };
  }

  /** Center of the turn; null on a straight path. */
  get center(): Point | null {
    if (this.beat === null || this.beat.straight) return null;
    const { x, y, heading } = this.beat.step;
    // c / (1 - e^(i d)) for the chord c of a turn by d
    const [re, im] = [1 - Math.cos(heading), -Math.sin(heading)];
    const size = re * re + im * im;
    return moved(this.base, this.base.heading, { x: (x * re + y * im) / size, y: (y * re - x * im) / size });
  }

  /** Turn about the nose so that the mean heading comes nearer to the picture's. */
  private align(part: number): void {
    if (this.beat === null) return;
    const error = Math.atan2(
      Math.sin(this.base.heading + this.beat.mean),
      Math.cos(this.base.heading + this.beat.mean),
    );
    const { pose } = this.beat.at(this.phase);
    const nose = moved(this.base, this.base.heading, pose);
    const heading = this.base.heading - part * error;
    const offset = moved({ x: 0, y: 0 }, heading, pose);
    this.base = { x: nose.x - offset.x, y: nose.y - offset.y, heading };
  }
}
