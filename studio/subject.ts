// What the views below the fish are about, and how they compute: robot, model and gait, in a worker of their own.
import { named, type Quantities, ratesOf, statusOf } from "./quantities.ts";
import type { Factors } from "./changes.ts";
import type { Calculator } from "./questions.ts";
import type { Parameter, Robot } from "./robot.ts";
import type { Samples, Spread } from "./samples.ts";

/** What a view asks of the page. */
export interface Page {
  go(row: Float64Array): void;
  robot(name: string): Promise<Robot | null>; // of the page
  changed(): void; // something that the address keeps
  body(factors: Factors): void; // factors on the robot's body
  certain(spread: Spread | null): void; // of the gait of the knobs, where the robot has samples
}

/** Makes a calculator of its own with a robot, in a worker beside the page's. */
export type Another = (robot: Robot) => Promise<Calculator>;

/** A view below the fish, of a tab each: what it hears of. */
export interface View {
  turnTo?(robot: Robot): void; // to another robot, or another body of it
  shape?(robot: Robot): void; // a body while it is changed
  about?(subject: Subject, described: Subject): unknown; // the robot with its model, and the one of its file
  set?(row: Float64Array): void; // the knobs' gait, at once
  at?(row: Float64Array, values: Quantities): void; // the same with its numbers
  certain?(spread: Spread | null): void; // of the knobs' gait
  show?(): void; // it is shown from now on
  refresh?(): void; // the colors of the page's theme
  open?(name: string, content: Uint8Array): void; // a log of a mission
  restore?(kept: Kept): void; // what an address says
  kept?(): Kept; // what the address keeps
  svg?(title: string): string; // its chart
}

/** Parts of an address, by key. */
export type Kept = Record<string, string>;

/** A settled gait with derivatives. */
export interface Computed {
  values: Quantities;
  settled: boolean;
  rates(quantity: string): Float64Array; // by the gait's numbers
}

export class Subject {
  constructor(
    readonly robot: Robot,
    readonly parameters: Parameter[],
    readonly model: number,
    private readonly calculator: Calculator,
    private readonly samples: Samples,
  ) {}

  /** Where most samples lie, of each gait; null without samples. */
  spreads(rows: Float64Array[]): Promise<Spread[] | null> {
    return this.samples.of(this.robot, this.model, rows);
  }

  async swim(row: Float64Array): Promise<Computed> {
    const { robot, model } = this;
    const answer = await this.calculator.ask({ kind: "point", robot: robot.key, model, gait: row });
    const values = named(answer.quantities);
    return {
      values,
      settled: statusOf(values) === "settled",
      rates: (quantity) => ratesOf(answer.derivatives, quantity),
    };
  }

  async sweep(rows: Float64Array[]): Promise<Quantities[]> {
    const { robot, model } = this;
    const gait = Float64Array.from(rows.flatMap((row) => [...row]));
    const { quantities } = await this.calculator.ask({ kind: "swim", robot: robot.key, model, gait, follow: false });
    return rows.map((_, k) => named(quantities, k));
  }
}
