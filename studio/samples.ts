// Uncertainty of a fit or of estimates: a gait computed with each sample of the coefficients, and its intervals.
import { changedColumns, type Factors } from "./changes.ts";
import { type Column, columnsOf, imageOf } from "./image.ts";
import { core, named, type Quantities, statusOf } from "./quantities.ts";
import type { Calculator } from "./questions.ts";
import type { Robot } from "./robot.ts";
import type { ImageLoader } from "./robots.ts";

export const INTERVAL = [0.05, 0.95] as const; // fractions of the samples below the two ends of an interval
const OWN_PREFIX = "models.0."; // prefix of columns of the robot's own model, to which the samples belong
const SAMPLE_PREFIX = "samples."; // prefix of columns with samples of coefficients

/** Intervals of a gait's quantities over the samples that settle. */
export interface Spread {
  of: "fit" | "estimates";
  settled: number; // number of samples that settle
  count: number;
  intervals: Record<string, readonly [number, number]>;
}

/** An image of the robot's own model for each sample of the coefficients, with factors on its body. */
export function sampledImages(image: Uint8Array, described: Robot, factors: Factors): Uint8Array[] {
  const columns = columnsOf(image);
  const own = columns.filter(({ name }) => name.startsWith(OWN_PREFIX));
  const samples = new Map(
    columns
      .filter(({ name }) => name.startsWith(SAMPLE_PREFIX))
      .map((one) => [OWN_PREFIX + one.name.slice(SAMPLE_PREFIX.length), one]),
  );
  return Array.from({ length: described.samples?.count ?? 0 }, (_, k) => {
    const drawn = own.map((column): Column => {
      const { values, width } = samples.get(column.name) ?? { values: null, width: 0 };
      return values === null ? column : { ...column, values: values.slice(k * width, (k + 1) * width) };
    });
    const changed = changedColumns(new Map(drawn.map(({ name, values }) => [name, values])), described, factors);
    return imageOf(
      image,
      drawn.map((column) => ({ ...column, values: changed.get(column.name) ?? column.values })),
    );
  });
}

/** Quantile of some numbers, with linear interpolation between them. */
export function quantile(numbers: readonly number[], part: number): number {
  const sorted = [...numbers].sort((a, b) => a - b);
  const place = part * (sorted.length - 1);
  const [low = Number.NaN, high = low] = [sorted[Math.floor(place)], sorted[Math.ceil(place)]];
  return low + (place % 1) * (high - low);
}

/** The intervals of a gait's samples; with estimates, `factors` of the speed carry the water law's error. */
export function spreadOf(samples: Quantities[], quantities: readonly string[], factors?: readonly number[]): Spread {
  const scaled = samples.map((values, k) => ({ ...values, speed: (values.speed ?? Number.NaN) * (factors?.[k] ?? 1) }));
  const settled = scaled.filter((values) => statusOf(values) === "settled" && Number.isFinite(values.speed));
  const interval = (name: string): readonly [number, number] => {
    const numbers = settled.map((values: Quantities) => values[name] ?? Number.NaN);
    return [quantile(numbers, INTERVAL[0]), quantile(numbers, INTERVAL[1])];
  };
  return {
    of: factors === undefined ? "fit" : "estimates",
    settled: settled.length,
    count: samples.length,
    intervals: Object.fromEntries(quantities.map((name) => [name, interval(name)])),
  };
}

/** Computes spreads of gaits in its own worker. */
export class Samples {
  private loaded = ""; // key of the robot whose samples are loaded
  private last: Promise<unknown> = Promise.resolve(); // the last question; questions wait for each other

  constructor(
    private readonly calculator: Calculator,
    private readonly image: (robot: Robot) => ImageLoader,
  ) {}

  /** Spreads of gaits with a robot's own model; null for another model, and for a robot without samples. */
  of(robot: Robot, model: number, rows: Float64Array[]): Promise<Spread[] | null> {
    const count = robot.samples?.count;
    if (count === undefined || model !== 0 || rows.length === 0) return Promise.resolve(null);
    const answer = this.last.then(() => this.ask(robot, count, rows));
    this.last = answer.catch(() => null);
    return answer;
  }

  private async ask(robot: Robot, count: number, rows: Float64Array[]): Promise<Spread[]> {
    const { calculator } = this;
    if (this.loaded !== robot.key) {
      const described = robot.described ?? robot;
      const images = sampledImages(await this.image(described)(), described, robot.factors ?? {});
      await calculator.ask({ kind: "samples", robot: robot.key, images });
      this.loaded = robot.key;
    }
    const gaits = Float64Array.from(rows.flatMap((row) => [...row]));
    const { quantities } = await calculator.ask({ kind: "spread", robot: robot.key, gaits });
    const factors = robot.samples?.speed_factors;
    return rows.map((_, k) => {
      const samples = Array.from({ length: count }, (_, sample) => named(quantities, sample * rows.length + k));
      return factors === undefined ? spreadOf(samples, core.quantities) : spreadOf(samples, ["speed"], factors);
    });
  }
}

/** Computes the spread of the knobs' gait; if knobs are turned meanwhile, only the last gait is computed next. */
export class Follower {
  private wanted: { robot: Robot; model: number; row: Float64Array } | null = null;
  private running = false;

  constructor(
    private readonly samples: Samples,
    private readonly listener: (spread: Spread | null) => void,
  ) {}

  async request(robot: Robot, model: number, row: Float64Array): Promise<void> {
    this.wanted = { robot, model, row };
    if (this.running) return;
    this.running = true;
    try {
      for (let now = null; now !== this.wanted; ) {
        now = this.wanted;
        const spreads = await this.samples.of(now.robot, now.model, [now.row]);
        if (now.robot.robot === this.wanted.robot.robot) this.listener(spreads?.[0] ?? null);
      }
    } finally {
      this.running = false;
    }
  }
}

/** The meaning of the intervals, in words. */
export function spreadWords({ of, settled, count }: Spread): string {
  const some = settled === count ? `${count}` : `the ${settled} of ${count}`;
  const what = of === "fit" ? "the fit" : "the estimates in the robot's file and of the water law's error";
  return `5 to 95 % of ${some} samples ${settled === count ? "" : "that settle "}of ${what}`;
}
