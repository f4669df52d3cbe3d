// A robot as the page knows it: the text of its image. SI units and radians.
import type { Mission, Said } from "./sea/flight.ts";

export type Range = readonly [number, number];

/** The ledger's verdict on a published number that a model computes. */
export interface Verdict {
  model: string;
  class: string; // class of the computed number: a prediction, or the reason why it had to agree
  computed: number | null;
  verdict: string;
  seeds: readonly [number, number] | null; // seeds of the noise: how many agree, how many there are
  note: string;
}

export interface Published {
  id: string; // identifier in the ledger
  verdicts: Verdict[]; // stored verdicts; none if the ledger does not cover this robot
  value: number;
  unit: string;
  kind: string; // "measured", "target", ...
  source: string;
}

export interface Gait {
  frequency: number; // Hz
  amplitude: number[]; // rad, one per joint group; so are phase and bias
  phase: number[];
  bias: number[];
}

export interface NamedGait extends Gait {
  name: string;
  published: Record<string, Published>; // published numbers by quantity
}

/** Ranges of the parameters of a gait. */
interface Ranges {
  frequency: Range;
  amplitude: Range[]; // one range per joint group; so for phase and bias
  phase: Range[];
  bias: Range[];
}

/** How a number follows a factor: a power of it; a term (power, size) of a sum; or a value for each step. */
export type Law = readonly [number] | readonly [number, number] | readonly [readonly number[]];

/** A knob of the body: a factor that multiplies values of the robot's file. */
export interface BodyKnob {
  name: string;
  label: string;
  unit: string;
  value: number; // the described value
  range: Range; // limits of the factor
  steps?: number[]; // the only factors that it may have
  keys: { key: string; at: number; power?: number; sum?: number }[]; // keys of the file, at offset `at`
  columns: Record<string, (readonly [number, ...Law])[]>; // columns of the image: indices and how their numbers follow
  facts: Record<string, Law>; // facts of this text by path, and how they follow
  twin?: boolean; // whether the twin's model follows the factor
}

export interface Robot {
  made_by: string; // program and version
  robot: string;
  description: string;
  fit: string | null; // data that its coefficients were fitted to; null without a fit
  length: number; // m
  mass: number; // kg
  links: { name: string; length: number; width: number | null; height: number | null; mass: number; com: number }[];
  tail: { edge_height: number | null }; // m: height of the caudal fin; null if the last link is not a fin
  fins: { x: number; y: number; z: number; span: number; chord: number } | null; // pectoral fins [m]
  joints: { name: string; links: number[]; share: number[]; drive: "hydraulic" | "servo" | "tendons" }[];
  hinges: number[]; // passive hinges, each by the index of the link behind it
  models: { water: string; joints: string }[]; // the robot's own model comes first
  limits: Ranges | null; // limits of the optimizer's search
  ranges: Ranges; // ranges of the knobs
  gaits: NamedGait[];
  ledger: {
    marks: Record<string, string>; // sign of each verdict
    classes: Record<string, string>; // meaning of each class
    models: Record<string, { water: string; joints: string }>; // the ledger's models that the page has too
  } | null; // null if no verdicts are stored
  body: { knobs: BodyKnob[] };
  source: string; // text of the robot's file
  samples?: { count: number; seed: number; speed_factors?: number[] }; // of a fit; with speed factors, of estimates
  key: string; // name under which workers know its image
  described?: Robot; // for a changed body: the robot as its file describes it
  factors?: Record<string, number>; // for a changed body: its factors by name of the knob
  twin: {
    rate: number; // control ticks per second
    channels: Record<string, readonly [number, number]>; // first and last channel of each sensor
    conditions: { name: string; place: string; text: string }[]; // conditions of the controller's status, by bit
    losses: { name: string; place: string; text: string }[]; // losses that add up to the servos' power
  } | null;
  no_twin?: string; // why there is no twin, as the end of a sentence
  missions: Mission[]; // missions that its pilot can fly
  pilot: { modes: Said[]; reasons: Said[]; endings: Said[] } | null;
}

const CHANGED = "~"; // stands in the key of a robot with a changed body, between the robot's key and a number

/** A new key for a robot with a changed body. */
export const changedKey = (robot: Robot, count: number): string => `${robot.key}${CHANGED}${count}`;

/** The robot of a key with a changed body; "" for a key with the body as described. */
export const bodyOf = (key: string): string => (key.includes(CHANGED) ? (key.split(CHANGED)[0] ?? "") : "");

/** Whether two keys name the same robot, whatever its body. */
export const sameRobot = (a: string | undefined, b: string | undefined): boolean =>
  a?.split(CHANGED)[0] === b?.split(CHANGED)[0];

/** A swim to compute: a robot, one of its models, and a gait as a row of numbers, or several rows. */
export interface Swimmer {
  robot: string;
  model: number;
  gait: Float64Array;
}

export const KINDS = ["amplitude", "phase", "bias"] as const;
export type Kind = (typeof KINDS)[number];

/** The kinds of angles of a gait; bias only if it is not zero. */
export const kindsOf = ({ bias }: Gait): Kind[] =>
  KINDS.filter((kind) => kind !== "bias" || bias.some((angle) => angle !== 0));

export const DEGREE = Math.PI / 180;

/** A gait as a row of numbers in the core's order: frequency [Hz], angles [rad]. */
export function rowOf(gait: Gait): Float64Array {
  return Float64Array.of(gait.frequency, ...gait.amplitude, ...gait.phase, ...gait.bias);
}

export function gaitOf(row: ArrayLike<number>): Gait {
  const [frequency = 1, ...angles] = Array.from(row);
  const groups = angles.length / 3;
  const part = (k: number): number[] => angles.slice(k * groups, (k + 1) * groups);
  return { frequency, amplitude: part(0), phase: part(1), bias: part(2) };
}

/** Bend in front of each link [rad]: its share of its joint group's angle, plus the angle of a hinge there. */
export function bendsOf({ links, joints, hinges }: Robot, angles: ArrayLike<number>): number[] {
  const bends = links.map(() => 0);
  joints.forEach(({ links, share }, group) => {
    links.forEach((link, k) => {
      bends[link] = (share[k] ?? 0) * (angles[group] ?? 0);
    });
  });
  hinges.forEach((link, d) => {
    bends[link] = (bends[link] ?? 0) + (angles[joints.length + d] ?? 0);
  });
  return bends;
}

/** A parameter of a gait, which one knob sets. */
export interface Parameter {
  index: number; // index in the gait's row
  knob: string; // name of its knob on the page, such as "amplitude-0"
  label: string;
  kind: Kind | "frequency";
  joint: string | null; // name of the joint group; null for the frequency
  unit: "Hz" | "deg";
  size: number; // size of the unit [Hz or rad]
  range: Range; // range of the knob, in the unit
  limits: Range | null; // limits of the optimizer, in the unit
  free: boolean; // whether the optimizer may change it
}

/** The parameters of a robot's gaits, in the order of the row. */
export function parametersOf(robot: Robot): Parameter[] {
  const angles = KINDS.flatMap((kind) => robot.joints.map((_, group) => ({ kind, group })));
  return [{ kind: "frequency" as const, group: 0 }, ...angles].map(({ kind, group }, index) => {
    const size = kind === "frequency" ? 1 : DEGREE;
    const range = (ranges: Ranges): Range => {
      const [low, high] = (kind === "frequency" ? ranges.frequency : ranges[kind][group]) ?? [0, 0];
      return [rounded(low / size), rounded(high / size)];
    };
    const limits = robot.limits && range(robot.limits);
    const joint = robot.joints[group]?.name ?? "";
    return {
      index,
      knob: kind === "frequency" ? kind : `${kind}-${group}`,
      label: kind === "frequency" ? kind : `${kind} of joint ${joint}`,
      kind,
      joint: kind === "frequency" ? null : joint,
      unit: kind === "frequency" ? "Hz" : "deg",
      size,
      range: range(robot.ranges),
      limits,
      free: limits !== null && limits[0] < limits[1],
    };
  });
}

const rounded = (value: number): number => Math.round(1e9 * value) / 1e9;

/** Index of the model with this water law and joint model; -1 if the robot has none. */
export function modelOf(robot: Robot, water: string, joints: string): number {
  return robot.models.findIndex((model) => model.water === water && model.joints === joints);
}

/** Parse the text of a robot's image. */
export function robotOf(text: string): Robot {
  const robot = JSON.parse(text) as Robot;
  const { ranges, ledger, joints } = robot;
  if (ranges === undefined || ledger === undefined || joints.some(({ drive }) => drive === undefined))
    throw new Error("the image is of an older program: write it anew with `hypertuna robot image`");
  robot.body ??= { knobs: [] }; // images of older programs have none
  robot.key = robot.robot;
  return robot;
}
