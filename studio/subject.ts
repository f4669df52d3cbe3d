// The interface of the views below the fish, and the robot, model and gait that they compute with.
import { named, type Quantities, ratesOf, statusOf } from "./quantities.ts";
import type { Factors } from "./changes.ts";
import type { Calculator } from "./questions.ts";
import type { Parameter, Robot } from "./robot.ts";
import type { Samples, Spread } from "./samples.ts";

/** The functions of the page that a view may call. */
export interface Page {
  go(row: Float64Array): void; // sets the knobs to a gait
  robot(name: string): Promise<Robot | null>; // finds a robot of the page
  changed(): void; // tells that something the address keeps has changed
  body(factors: Factors): void; // sets factors on the robot's body
  certain(spread: Spread | null): void; // shows the intervals of the knobs' gait; null without samples
}

/** Makes a calculator with a robot loaded, in a worker beside the page's. */
export type Another = (robot: Robot) => Promise<Calculator>;

/** A view below the fish, with its own tab; the page calls the methods that it has. */
export interface View {
  turnTo?(robot: Robot): void; // takes another robot, or another body of it
  shape?(robot: Robot): void; // takes a body while it is being changed
  about?(subject: Subject, described: Subject): unknown; // takes the robot with its model, and the robot of its file
  set?(row: Float64Array): void; // takes the knobs' gait at once, before its quantities
  at?(row: Float64Array, values: Quantities): void; // takes the knobs' gait with its quantities
  certain?(spread: Spread | null): void; // takes the intervals of the knobs' gait
  show?(): void; // the view is shown from now on
  refresh?(): void; // draws again after a change of the page's theme
  open?(name: string, content: Uint8Array): void; // opens a log of a mission
  restore?(kept: Kept): void; // takes the values that an address holds
  kept?(): Kept; // returns the values that the address keeps
  svg?(title: string): string; // the view's chart
}

/** Values of an address, by key. */
export type Kept = Record<string, string>;

/** A computed gait with derivatives of its quantities. */
export interface Computed {
  values: Quantities;
  settled: boolean;
  rates(quantity: string): Float64Array; // derivatives with respect to the gait's numbers
}

export class Subject {
  constructor(
    readonly robot: Robot,
    readonly parameters: Parameter[],
    readonly model: number,
    private readonly calculator: Calculator,
    private readonly samples: Samples,
  ) {}

  /** The intervals of most samples for each gait; null without samples. */
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
