// The kinds of drive that move joints: what the page writes and plots for each.
import type { Robot } from "./robot.ts";

/** A column of the table of joints: one number of each drive on one side. */
interface Numbers {
  label: string;
  numbers: "unit" | "torque"; // field of `Moment` that holds the numbers
  side: Drive["side"];
  size: number;
  decimals: number;
}

/** A plot of one number of each drive over time. */
interface Plot {
  label: string;
  unit: string;
  name: string; // name of the column in the twin's record
  scale: number;
  reach: readonly [number, number];
}

interface Kind {
  words: string;
  servos: { end: string; side: Drive["side"] }[]; // servos of a joint; the core stores two numbers per joint
  numbers: Numbers[];
  plots: Plot[];
  places: string[]; // where the drive loses power
  colors: string; // sentence of the caption that explains the colors
  dashed: string;
}

/** A servo that moves a joint. */
export interface Drive {
  kind: Kind;
  name: string;
  joint: number;
  row: number;
  side: -1 | 0 | 1; // -1: oil on the right, 1: on the left, 0: a servo that turns the joint
}

const pressure = { numbers: "unit", size: 1e3, decimals: 0 } as const;
const AXLE: Kind = {
  words: "servos on the axles",
  servos: [{ end: "", side: 0 }],
  numbers: [{ label: "servo torque [N\u00a0m]", numbers: "torque", side: 0, size: 1, decimals: 3 }],
  plots: [{ label: "torque of the servo", unit: "N m", name: "servo_torque", scale: 1, reach: [-1e-3, 1e-3] }],
  places: ["servos", "water"],
  colors: "",
  dashed: "",
};
const KINDS: Record<Robot["joints"][number]["drive"], Kind> = {
  hydraulic: {
    words: "pump servos, cylinders, oil lines, muscles",
    servos: [
      { end: " left", side: 1 },
      { end: " right", side: -1 },
    ],
    numbers: [
      { label: "oil, left [kPa]", side: 1, ...pressure },
      { label: "oil, right [kPa]", side: -1, ...pressure },
    ],
    plots: [{ label: "pressure", unit: "kPa", name: "unit_pressure", scale: 1e-3, reach: [0, 10] }],
    places: ["servos", "oil", "joints", "water"],
    colors: " Orange: oil under pressure; blue: suction.",
    dashed: "; of pressures, the right side",
  },
  servo: AXLE,
  tendons: { ...AXLE, words: "servos on drums, which bend the joints by tendons" },
};

export function drivesOf({ joints }: Robot): Drive[] {
  return joints.flatMap(({ name, drive }, joint) => {
    const kind = KINDS[drive];
    return kind.servos.map(({ end, side }, k) => ({ kind, name: name + end, joint, row: 2 * joint + k, side }));
  });
}

/** The parts (numbers, plots, ...) of all kinds of drive that the robot has, without repeats. */
export function ofKinds<T>({ joints }: Robot, part: (kind: Kind) => readonly T[]): T[] {
  const own = Object.entries(KINDS).filter(([name]) => joints.some(({ drive }) => drive === name));
  return [...new Set(own.flatMap(([, kind]) => part(kind)))];
}

export const hasOil = ({ side }: Drive): boolean => side !== 0;
