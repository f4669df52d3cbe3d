// Quantities of a swim, with the labels and digits of the command line.
import type { Core, Meaning } from "./core.ts";
import { BeatStatus, Better, CORE } from "./interface.ts";
import { DEGREE, type Gait, kindsOf, type Robot } from "./robot.ts";

export const MAIN = ["speed", "mechanical_power", "cost_of_transport"]; // compared, with uncertainty
const STILL_SPEED = 1e-3; // m/s: below this speed a direction means little

export type Quantities = Record<string, number>;

/** The core, whose table gives labels and units. */
export let core: Core;
/** The quantities that `hypertuna swim` prints, in its order. */
export let SUMMARY: readonly Meaning[] = [];

export function learn(from: Core): void {
  core = from;
  // A quantity with the label of the one before it is the same in another unit.
  SUMMARY = core.meanings.filter(({ label, shown }, k) => shown === 2 && label !== core.meanings[k - 1]?.label);
}

const STATUSES = Object.keys(BeatStatus);

export function meaning(name: string): Meaning {
  const other = { name, label: name, unit: "", shown: 0, better: Better.neither };
  return core.meanings.find((known) => known.name === name) ?? other;
}

/** The quantities of row `k` of the core's answer, by name. */
export function named(rows: ArrayLike<number>, k = 0): Quantities {
  const { quantities } = core;
  return Object.fromEntries(quantities.map((name, i) => [name, rows[k * quantities.length + i] ?? Number.NaN]));
}

/** Derivatives of a quantity with respect to the numbers of a gait. */
export function ratesOf(derivatives: Float64Array, quantity: string): Float64Array {
  const [count, place] = [derivatives.length / core.derivatives.length, core.derivatives.indexOf(quantity)];
  return derivatives.subarray(place * count, (place + 1) * count);
}

export function statusOf(values: Quantities): string {
  return STATUSES[values.status ?? 3] ?? "diverged";
}

export function turns(values: Quantities, robot: Robot): boolean {
  return (values.turn_radius ?? Number.NaN) < CORE.nearly_straight * robot.length;
}

/** A number with `count` digits, as the command line writes it; a dash if there is none. */
export function digits(value: number | undefined, count = 4): string {
  if (value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value < 0 ? "−∞" : "∞";
  const size = Math.abs(value);
  const text =
    size !== 0 && (size < 1e-4 || size >= 10 ** count)
      ? exponent(value, count - 1)
      : String(Number(value.toPrecision(count)));
  return text.replace("-", "−");
}

function exponent(value: number, decimals: number): string {
  const [head = "", power = "0"] = value.toExponential(decimals).split("e");
  const mantissa = decimals > 1 ? String(Number(head)) : head;
  const size = Math.abs(Number(power)).toString().padStart(2, "0");
  return `${mantissa}e${Number(power) < 0 ? "-" : "+"}${size}`;
}

/** The verdict on a gait with this frequency [Hz], in a sentence of `hypertuna swim`. */
export function verdict(values: Quantities, frequency: number): string {
  const numbers = core.quantities.map((name) => values[name] ?? Number.NaN);
  return core.verdict(frequency, numbers);
}

/** ", tail first" for a gait that swims backward; "" otherwise. */
export function backward(values: Quantities): string {
  return statusOf(values) === "settled" && (values.speed ?? 0) < -STILL_SPEED ? ", tail first" : "";
}

/** A sentence on where the start from rest leads; `values` were computed with `follow`. */
export function fromRest(values: Quantities): string {
  if (statusOf(values) !== "settled") return "";
  if (values.arrived === 1) return ` From rest the robot reaches this motion in ${values.approach_beats} beats.`;
  return " A start from rest does not lead to this motion.";
}

const shortest = (value: number): string => String(Number(value.toPrecision(4)));

/** A gait in a line, such as "6 Hz, amplitude 16, 25 deg, phase 0, 40 deg". */
export function gaitText(gait: Gait): string {
  const angles = kindsOf(gait).map(
    (kind) => `${kind} ${gait[kind].map((angle) => shortest(angle / DEGREE)).join(", ")} deg`,
  );
  return [`${shortest(gait.frequency)} Hz`, ...angles].join(", ");
}

/** A number without the rounding noise of its conversion from radians. */
export const plain = (value: number): number => Number(value.toPrecision(12));

/** The command line that computes the same swim. */
export function command(robot: Robot, model: { water: string; joints: string }, gait: Gait): string {
  const own = robot.models[0];
  const options = [
    `--robot ${robot.factors === undefined ? robot.robot : `${robot.robot}-changed.toml`}`,
    `--frequency ${plain(gait.frequency)}`,
    ...kindsOf(gait).map((kind) => `--${kind} ${gait[kind].map((angle) => plain(angle / DEGREE)).join(",")}`),
    ...(model.water === own?.water ? [] : [`--water ${model.water}`]),
    ...(model.joints === own?.joints ? [] : [`--joints ${model.joints}`]),
  ];
  return `hypertuna swim ${options.join(" ")}`;
}
