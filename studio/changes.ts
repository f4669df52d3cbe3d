// A changed body: factors on values of the robot's file, and the numbers of its image that change with them.
//
// The image says how each number v follows the factors f: (v + sum of s (f^q - 1)) times the product of f^p.
import { type Columns, columnsOf, imageOf } from "./image.ts";
import type { BodyKnob, Law, Robot } from "./robot.ts";

/** Factors by the name of their knob; a factor that is left out is 1. */
export type Factors = Record<string, number>;

/** The value that a number takes under these factors, each with its law. */
function follow(value: number, laws: readonly (readonly [number, Law, BodyKnob?])[]): number {
  let [sum, product] = [value, 1];
  for (const [factor, [power], knob] of laws)
    if (typeof power !== "number") sum = power[knob?.steps?.indexOf(factor) ?? -1] ?? Number.NaN;
  for (const [factor, [power, size]] of laws) {
    if (typeof power !== "number") continue;
    if (size === undefined) product *= factor ** power;
    else sum += size * (factor ** power - 1);
  }
  return sum * product;
}

const changed = (robot: Robot, factors: Factors): [BodyKnob, number][] =>
  robot.body.knobs.flatMap((knob) => {
    const factor = factors[knob.name] ?? 1;
    return factor === 1 ? [] : [[knob, factor] as [BodyKnob, number]];
  });

/** The image of a robot with a changed body. */
export function changedImage(image: Uint8Array, robot: Robot, factors: Factors): Uint8Array {
  const columns = columnsOf(image).filter(({ name }) => !name.startsWith("samples."));
  const changed = changedColumns(new Map(columns.map(({ name, values }) => [name, values])), robot, factors);
  return imageOf(
    image,
    columns.map((column) => ({ ...column, values: changed.get(column.name) ?? column.values })),
  );
}

/** Only those columns of the image that these factors change, with their new values. */
export function changedColumns(columns: Columns, robot: Robot, factors: Factors): Columns {
  const laws = new Map<string, Map<number, [number, Law, BodyKnob][]>>();
  for (const [knob, factor] of changed(robot, factors)) {
    for (const [pattern, rows] of Object.entries(knob.columns)) {
      for (const name of matching(pattern, columns)) {
        const column = laws.get(name) ?? new Map<number, [number, Law, BodyKnob][]>();
        laws.set(name, column);
        for (const [place, ...law] of rows) column.set(place, [...(column.get(place) ?? []), [factor, law, knob]]);
      }
    }
  }
  const made: Columns = new Map();
  for (const [name, column] of laws) {
    const values = columns.get(name)?.slice();
    if (values === undefined) continue;
    for (const [place, list] of column) values[place] = follow(values[place] ?? Number.NaN, list);
    made.set(name, values);
  }
  return made;
}

/** Names of the columns that match a pattern: `models.*.length` matches that column of every model. */
function matching(pattern: string, columns: Columns): string[] {
  const [head, tail] = pattern.split("*.");
  if (tail === undefined) return [pattern];
  return [...columns.keys()].filter(
    (name) => name.startsWith(head ?? "") && name.split(".").slice(2).join(".") === tail,
  );
}

/** The page's record of a robot whose body is changed by factors. */
export function changedRobot(robot: Robot, factors: Factors, key: string): Robot {
  const { length, mass, links, tail, fins } = robot;
  const body = structuredClone({ length, mass, links, tail, fins });
  const laws = new Map<string, [number, Law][]>();
  for (const [knob, factor] of changed(robot, factors))
    for (const [place, law] of Object.entries(knob.facts)) laws.set(place, [...(laws.get(place) ?? []), [factor, law]]);
  for (const [place, list] of laws) {
    const path = place.split(".");
    const last = path.pop() ?? "";
    let table = body as unknown as Record<string, unknown>;
    for (const name of path) table = table[name] as Record<string, unknown>;
    table[last] = follow(table[last] as number, list);
  }
  return { ...robot, ...body, key, described: robot, factors };
}

/** The factors for which the robot has a knob, limited to the knobs' ranges; factors of 1 are left out. */
export function known(robot: Robot, factors: Factors): Factors {
  const kept: Factors = {};
  for (const knob of robot.body.knobs) {
    const factor = within(knob, factors[knob.name] ?? 1);
    if (factor !== 1) kept[knob.name] = factor;
  }
  return kept;
}

/** The nearest factor that the knob allows. */
export function within({ range: [low, high], steps }: BodyKnob, factor: number): number {
  const near = steps?.toSorted((a, b) => Math.abs(a - factor) - Math.abs(b - factor))[0];
  return near ?? Math.min(high, Math.max(low, factor));
}

/** Whether the twin's model follows every knob that is changed. */
export function twinFollows(robot: Robot, factors: Factors): boolean {
  return changed(robot, factors).every(([knob]) => knob.twin !== false);
}

// --- the robot's file

const NUMBER = /[+-]?[\d_]+(?:\.[\d_]+)?(?:[eE][+-]?\d+)?/y;

interface Edit {
  at: number; // offset in the source text
  key: string;
  value: number;
  before: string;
}

/** The values of the robot's file that these factors change, in the order of the file. */
function edits(robot: Robot, factors: Factors): Edit[] {
  const found = new Map<string, { at: number; laws: [number, Law][] }>();
  for (const [knob, factor] of changed(robot, factors)) {
    for (const { key, at, power, sum } of knob.keys) {
      const law: Law = power === undefined ? [1, sum ?? 0] : [power];
      const { laws } = found.get(key) ?? { laws: [] };
      found.set(key, { at, laws: [...laws, [factor, law]] });
    }
  }
  const list = [...found].map(([key, { at, laws }]) => {
    NUMBER.lastIndex = at;
    const before = NUMBER.exec(robot.source)?.[0] ?? "";
    return { at, key, before, value: follow(Number(before.replaceAll("_", "")), laws) };
  });
  return list.sort((a, b) => a.at - b.at);
}

/** A number in TOML: 14 digits, more than any measurement has, without the rounding noise of the last ones. */
function real(value: number): string {
  const text = String(Number(value.toPrecision(14)));
  return Number.isInteger(Number(text)) && !text.includes("e") ? `${text}.0` : text;
}

/** The robot's file (TOML) with the changed values; a comment on each line keeps the old one. */
export function changedToml(robot: Robot, factors: Factors): string {
  const { source } = robot;
  const list = edits(robot, factors);
  let [text, done] = ["", 0];
  list.forEach(({ at, before, value }, k) => {
    text += source.slice(done, at) + real(value);
    done = at + before.length;
    const end = (source.indexOf("\n", at) + source.length + 1) % (source.length + 1);
    if ((list[k + 1]?.at ?? source.length) < end) return; // another change follows on this line
    const line = list.filter(({ at: other }) => other > source.lastIndexOf("\n", at) && other <= at);
    const place = (name: string): string => /\[\d+\]$/.exec(name)?.[0] ?? "";
    const marks = line.map((one) => `${place(one.key)} changed from ${one.before}`.trim()).join(", ");
    const rest = source.slice(done, end).replace(/\r$/, "");
    text += `${rest.trimEnd()}${rest.includes("#") ? "; " : "  # "}${marks}`;
    done = end - (source[end - 1] === "\r" ? 1 : 0);
  });
  return text + source.slice(done);
}
