// The robot's motion in the picture: settled beats one after another, without jumps when the gait changes.
import type { Point } from "./body.ts";
import { POSE } from "./core.ts";

const EASE_TIME = 0.12; // s: time constant with which the drawn body follows a changed gait
const ALIGN_TIME = 0.8; // s: time constant with which a straight path turns to the left of the picture

export interface Pose extends Point {
  heading: number; // direction of the head's axis from nose to tail, counter-clockwise from x [rad]
}

/** A settled beat: rows of time, x, y, heading, bends. */
export class Beat {
  readonly count: number;
  readonly step: Pose; // motion from the first to the last row [m, rad]
  readonly mean: number; // mean heading over the beat [rad]
  readonly sway: Point; // mean place of the nose relative to the straight line from first to last row [m]

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

  /** Pose of the nose relative to the beat's start, and the bends, at a fraction of the beat. */
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

  /** Mean of a column over the beat, after subtraction of its drift. */
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

/** The point `from`, moved by the vector `by` after a turn of that vector by `angle`. */
function moved(from: Point, angle: number, by: Point): Point {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return { x: from.x + c * by.x - s * by.y, y: from.y + s * by.x + c * by.y };
}

export class Motion {
  beat: Beat | null = null;
  phase = 0; // fraction of the beat that has passed
  base: Pose = { x: 0, y: 0, heading: 0 }; // pose of the beat's start in the picture
  private offsets: number[] = []; // differences of the drawn heading and bends from the beat's; they decay

  /** Continue with another beat at the same phase and place. */
  change(beat: Beat): void {
    const before = this.beat === null ? null : this.now();
    const old = this.beat;
    this.beat = beat;
    if (before === null || old === null) {
      this.base = { x: 0, y: 0, heading: -beat.mean };
      this.offsets = [];
      return;
    }
    this.base.heading += old.mean - beat.mean;
    const { pose } = beat.at(this.phase);
    const nose = moved({ x: 0, y: 0 }, this.base.heading, pose);
    Object.assign(this.base, { x: before.pose.x - nose.x, y: before.pose.y - nose.y });
    this.offsets = [];
    const after = this.now();
    const same = after.bends.length === before.bends.length;
    const bends = same ? after.bends.map((bend, k) => (before.bends[k] ?? 0) - bend) : [];
    this.offsets = same ? [before.pose.heading - after.pose.heading, ...bends] : [];
  }

  /** Advance the motion by `seconds`, while `shown` seconds pass on the screen. */
  advance(seconds: number, shown: number): void {
    const { beat } = this;
    if (beat === null) return;
    this.phase += seconds * beat.frequency;
    for (; this.phase >= 1; this.phase -= 1) {
      const heading = this.base.heading + beat.step.heading;
      this.base = { ...moved(this.base, this.base.heading, beat.step), heading };
    }
    const kept = Math.exp(-shown / EASE_TIME);
    this.offsets = this.offsets.map((off) => off * kept);
    if (beat.straight) this.align(-Math.expm1(-seconds / ALIGN_TIME));
  }

  /** Pose of the nose, and bends, as drawn now. */
  now(): { pose: Pose; bends: number[] } {
    if (this.beat === null) throw new Error("no beat yet");
    const { pose, bends } = this.beat.at(this.phase);
    const place = moved(this.base, this.base.heading, pose);
    const heading = this.base.heading + pose.heading + (this.offsets[0] ?? 0);
    return { pose: { ...place, heading }, bends: bends.map((bend, k) => bend + (this.offsets[k + 1] ?? 0)) };
  }

  /** Place of the nose without its sway, and the mean direction of the body. */
  get mean(): Pose {
    if (this.beat === null) return this.base;
    const { step, mean, sway } = this.beat;
    const way = { x: sway.x + step.x * this.phase, y: sway.y + step.y * this.phase };
    return {
      ...moved(this.base, this.base.heading, way),
      heading: this.base.heading + mean + step.heading * this.phase,
    };
  }

  /** Whether the drawn body still eases towards a changed gait. */
  get unsettled(): boolean {
    return this.offsets.some((off) => Math.abs(off) > 1e-3);
  }

  /** Pose and bends at another fraction of the beat, moved to the robot's mean place now. */
  ghost(part: number): { pose: Pose; bends: number[] } {
    if (this.beat === null) throw new Error("no beat yet");
    const { pose, bends } = this.beat.at(part);
    const { step, sway: middle } = this.beat;
    const frameHeading = this.base.heading + (this.phase - part) * step.heading;
    const sway = { x: pose.x - part * step.x - middle.x, y: pose.y - part * step.y - middle.y };
    const { x, y } = this.mean;
    return { pose: { ...moved({ x, y }, frameHeading, sway), heading: frameHeading + pose.heading }, bends };
  }

  /** Center of the turning circle; null on a straight path. */
  get center(): Point | null {
    if (this.beat === null || this.beat.straight) return null;
    const { x, y, heading } = this.beat.step;
    // c / (1 - e^(i d)) for a turn by d with chord c
    const [re, im] = [1 - Math.cos(heading), -Math.sin(heading)];
    const size = re * re + im * im;
    return moved(this.base, this.base.heading, { x: (x * re + y * im) / size, y: (y * re - x * im) / size });
  }

  /** Turn the path about the nose, so that the mean heading approaches the picture's. */
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
