// What the page knows of a robot: the text of its image. SI units and radians.
import type { Mission, Said } from "./sea/flight.ts";

export type Range = readonly [number, number];

/** What the ledger says of a published number that a model computes. */
export interface Verdict {
  model: string;
  class: string; // of the computed number: a prediction, or why it could not have come out otherwise
  computed: number | null;
  verdict: string;
  seeds: readonly [number, number] | null; // of the noise: how many agree, of how many
  note: string;
}

export interface Published {
  id: string; // in the ledger
  verdicts: Verdict[]; // stored ones; none for a robot that the ledger is not of
  value: number;
  unit: string;
  kind: string; // "measured", "target", ...
  source: string;
}

export interface Gait {
  frequency: number; // Hz
  amplitude: number[]; // rad, of each joint group, as phase and bias
  phase: number[];
  bias: number[];
}

export interface NamedGait extends Gait {
  name: string;
  published: Record<string, Published>; // by quantity
}

/** A range of each parameter of a gait. */
interface Ranges {
  frequency: Range;
  amplitude: Range[]; // of each joint group, as phase and bias
  phase: Range[];
  bias: Range[];
}

/** How a number follows a factor: by its power; by a term of a sum, of a power and a size; by a value at each step. */
export type Law = readonly [number] | readonly [number, number] | readonly [readonly number[]];

/** What may be changed of a body: a factor on values of the robot's file. */
export interface BodyKnob {
  name: string;
  label: string;
  unit: string;
  value: number; // that the factor multiplies
  range: Range; // of the factor
  steps?: number[]; // the factors that it may have
  keys: { key: string; at: number; power?: number; sum?: number }[]; // in the file, and where they stand in its text
  columns: Record<string, (readonly [number, ...Law])[]>; // of the image: place and law
  facts: Record<string, Law>; // of this text, by path
  twin?: boolean; // whether the twin follows
}

export interface Robot {
  made_by: string; // program and version
  robot: string;
  description: string;
  fit: string | null; // what its coefficients were fitted to, where they were
  length: number; // m
  mass: number; // kg
  links: { name: string; length: number; width: number | null; height: number | null; mass: number; com: number }[];
  tail: { edge_height: number | null }; // m: height of the caudal fin where the last link is one
  fins: { x: number; y: number; z: number; span: number; chord: number } | null; // pectoral fins [m]
  joints: { name: string; links: number[]; share: number[]; drive: "hydraulic" | "servo" | "tendons" }[];
  hinges: number[]; // passive ones, by the link behind each
  models: { water: string; joints: string }[]; // the robot's own choice first
  limits: Ranges | null; // that the optimizer searches
  ranges: Ranges; // that the knobs reach
  gaits: NamedGait[];
  ledger: {
    marks: Record<string, string>; // by verdict
    classes: Record<string, string>; // what they mean
    models: Record<string, { water: string; joints: string }>; // those that the page has, too
  } | null; // where verdicts are stored
  body: { knobs: BodyKnob[] };
  source: string; // the robot's file
  samples?: { count: number; seed: number; speed_factors?: number[] }; // of the fit; with factors, of the estimates
  key: string; // under which workers know its image
  described?: Robot; // of a changed body: what its file says
  factors?: Record<string, number>; // of a changed body, by knob
  twin: {
    rate: number; // control ticks a second
    channels: Record<string, readonly [number, number]>; // first and last of each sensor's
    conditions: { name: string; place: string; text: string }[]; // of the controller's status, by bit
    losses: { name: string; place: string; text: string }[]; // that add up to the servos' power
  } | null;
  no_twin?: string; // why there is none, the end of a sentence
  missions: Mission[]; // that its pilot can fly
  pilot: { modes: Said[]; reasons: Said[]; endings: Said[] } | null;
}

const CHANGED = "~"; // in the key of a robot with a changed body, between the robot's and a number

/** A new key for a robot with a changed body. */
export const changedKey = (robot: Robot, count: number): string => `${robot.key}${CHANGED}${count}`;

/** The robot that a key is of; "" where its body is as described. */
export const bodyOf = (key: string): string => (key.includes(CHANGED) ? (key.split(CHANGED)[0] ?? "") : "");

/** Whether two keys name the same robot, with any body. */
export const sameRobot = (a: string | undefined, b: string | undefined): boolean =>
  a?.split(CHANGED)[0] === b?.split(CHANGED)[0];

/** What swims: a robot by one of its models, and its gait as a row of numbers, or several rows. */
export interface Swimmer {
  robot: string;
  model: number;
  gait: Float64Array;
}

export const KINDS = ["amplitude", "phase", "bias"] as const;
export type Kind = (typeof KINDS)[number];

/** The kinds of angles of a gait that turns, or of one that has no bias. */
export const kindsOf = ({ bias }: Gait): Kind[] =>
  KINDS.filter((kind) => kind !== "bias" || bias.some((angle) => angle !== 0));

export const DEGREE = Math.PI / 180;

/** A gait as a row of numbers, as the core takes it: [Hz], [rad]. */
export function rowOf(gait: Gait): Float64Array {
  return Float64Array.of(gait.frequency, ...gait.amplitude, ...gait.phase, ...gait.bias);
}

export function gaitOf(row: ArrayLike<number>): Gait {
  const [frequency = 1, ...angles] = Array.from(row);
  const groups = angles.length / 3;
  const part = (k: number): number[] => angles.slice(k * groups, (k + 1) * groups);
  return { frequency, amplitude: part(0), phase: part(1), bias: part(2) };
}

/** Bend in front of each link: a joint group's angle is shared by its links; those of hinges follow the groups'. */
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

/** One number of a gait: what a knob turns. */
export interface Parameter {
  index: number; // in the row
  knob: string; // its name on the page: "amplitude-0"
  label: string;
  kind: Kind | "frequency";
  joint: string | null; // name of the joint group
  unit: "Hz" | "deg";
  size: number; // of the unit [Hz or rad]
  range: Range; // in the unit
  limits: Range | null; // of the optimizer, in the unit
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

/** Place of a pair of water law and joint model; -1 where the robot has none. */
export function modelOf(robot: Robot, water: string, joints: string): number {
  return robot.models.findIndex((model) => model.water === water && model.joints === joints);
}

/** Read a robot's text. */
export function robotOf(text: string): Robot {
  const robot = JSON.parse(text) as Robot;
  const { ranges, ledger, joints } = robot;
  if (ranges === undefined || ledger === undefined || joints.some(({ drive }) => drive === undefined))
    throw new Error("the image is of an older program: write it anew with `hypertuna robot image`");
  robot.body ??= { knobs: [] }; // of an older program
  robot.key = robot.robot;
  return robot;
}
