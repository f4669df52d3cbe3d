// Quantities of a swim in the words and digits of the command line.
import { DEGREE, type Gait, KINDS, type Robot } from "./robot.ts";

const SLOW = 1e-3; // m/s below which a direction means little

export type Quantities = Record<string, number>;

export interface Meaning {
  name: string;
  label: string;
  unit: string;
}

/** What `hypertuna swim` prints, in its order. */
export const SUMMARY: Meaning[] = [
  { name: "speed", label: "speed", unit: "m/s" },
  { name: "mechanical_power", label: "mechanical power", unit: "W" },
  { name: "cost_of_transport", label: "cost of transport", unit: "J/(kg m)" },
  { name: "strouhal", label: "Strouhal number", unit: "" },
  { name: "stride_length", label: "stride length", unit: "BL per beat" },
  { name: "efficiency", label: "efficiency", unit: "" },
  { name: "tail_excursion", label: "tail excursion, peak to peak", unit: "m" },
  { name: "turn_rate", label: "turn rate, counter-clockwise", unit: "rad/s" },
  { name: "turn_radius", label: "turn radius", unit: "m" },
];

const MORE: Meaning[] = [
  { name: "torque_peak", label: "peak torque", unit: "N m" },
  { name: "rate_peak", label: "peak rate", unit: "rad/s" },
  { name: "mechanical_power_positive", label: "mechanical power positive", unit: "W" },
  { name: "cost_of_transport_positive", label: "cost of transport positive", unit: "J/(kg m)" },
  { name: "power_to_water", label: "power to water", unit: "W" },
];

const STRAIGHT = 1e3; // body lengths: a larger turning radius is not shown
const STATUSES = ["settled", "unsettled", "unstable", "diverged"];

export function meaning(name: string): Meaning {
  return [...SUMMARY, ...MORE].find((known) => known.name === name) ?? { name, label: name, unit: "" };
}

/** Names and values of a row. */
export function named(names: readonly string[], row: ArrayLike<number>): Quantities {
  return Object.fromEntries(names.map((name, k) => [name, row[k] ?? Number.NaN]));
}

export function statusOf(values: Quantities): string {
  return STATUSES[values.status ?? 3] ?? "diverged";
}

export function turns(values: Quantities, robot: Robot): boolean {
  return (values.turn_radius ?? Number.NaN) < STRAIGHT * robot.length;
}

/** A number with four digits, as the command line writes it; a dash where there is none. */
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

const percent = (value: number, count: number): string => `${Number((100 * value).toPrecision(count))} %`;

/** The verdict as a sentence, as `hypertuna swim` says it. */
export function verdict(values: Quantities): string {
  const { spectral_radius: radius = 0, distance_to_settled: distance = 0, beats = 0 } = values;
  const off = exponent(distance, 1);
  switch (statusOf(values)) {
    case "settled":
      return `The gait is settled: consecutive beats agree to ${off} of the distance traveled; ${decay(radius)}.`;
    case "unstable":
      return `The gait is periodic but unstable: a disturbance grows ${growth(radius)} each beat, so the robot will not stay in it.`;
    case "unsettled":
      return `The gait is unsettled after ${beats} beats: it is still off by ${off} of the distance traveled in a beat.`;
    default:
      return `The gait diverged within ${beats} beats: its speeds grew beyond all bounds.`;
  }
}

function growth(radius: number): string {
  return radius < 2 ? `by ${percent(radius - 1, 2)}` : `to ${Number(radius.toPrecision(3))} times its size`;
}

function decay(radius: number): string {
  const loss = 1 - radius;
  if (loss < 1e-4) return "a disturbance hardly decays";
  if (loss < 0.05) return `a disturbance decays slowly, by ${percent(loss, 2)} each beat`;
  return `a disturbance decays by ${(100 * loss).toFixed(0)} % each beat`;
}

/** A robot that goes the other way. */
export function backward(values: Quantities): string {
  return statusOf(values) === "settled" && (values.speed ?? 0) < -SLOW ? ", tail first" : "";
}

/** Body that turns by more than half a circle in a beat. */
export function spin(values: Quantities, frequency: number): string {
  const turn = (values.turn_rate ?? 0) / frequency;
  if (!(Math.abs(turn) > Math.PI) || statusOf(values) === "diverged") return "";
  const angle = Math.abs(turn / DEGREE).toFixed(0);
  return ` It spins: ${angle} deg a beat, more than half a circle, is no path with a speed.`;
}

/** Where a start from rest leads, of quantities with `follow`. */
export function fromRest(values: Quantities): string {
  if (statusOf(values) !== "settled") return "";
  if (values.arrived === 1) return ` From rest the robot reaches this motion in ${values.approach_beats} beats.`;
  return " A start from rest does not lead to this motion.";
}

const shortest = (value: number): string => String(Number(value.toPrecision(4)));

/** A gait in a line: "6 Hz, amplitude 16, 25 deg, phase 0, 40 deg". */
export function gaitText(gait: Gait): string {
  const kinds = gait.bias.some((angle) => angle !== 0) ? KINDS : KINDS.slice(0, 2);
  const angles = kinds.map((kind) => `${kind} ${gait[kind].map((angle) => shortest(angle / DEGREE)).join(", ")} deg`);
  return [`${shortest(gait.frequency)} Hz`, ...angles].join(", ");
}

/** A number without the noise of its conversion from radians. */
export const plain = (value: number): number => Number(value.toPrecision(12));

/** The command that swims the same. */
export function command(robot: Robot, model: { water: string; joints: string }, gait: Gait): string {
  const kinds = gait.bias.some((angle) => angle !== 0) ? KINDS : KINDS.slice(0, 2);
  const own = robot.models[0];
  const options = [
    `--robot ${robot.factors === undefined ? robot.robot : `${robot.robot}-changed.toml`}`,
    `--frequency ${plain(gait.frequency)}`,
    ...kinds.map((kind) => `--${kind} ${gait[kind].map((angle) => plain(angle / DEGREE)).join(",")}`),
    ...(model.water === own?.water ? [] : [`--water ${model.water}`]),
    ...(model.joints === own?.joints ? [] : [`--joints ${model.joints}`]),
  ];
  return `hypertuna swim ${options.join(" ")}`;
}
