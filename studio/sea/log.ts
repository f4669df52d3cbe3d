// Reads logs of missions, which `hypertuna mission FILE -o x.mcap` writes, into rows; errors are worded as in Python.
import type { Column } from "../core.ts";
import type { Head, Mission, Place, Waypoint } from "./flight.ts";
import { isMcap, type Messages, messagesOf } from "./mcap.ts";

export interface Log {
  head: Head;
  columns: Column[];
  rows: Float64Array;
  sentence: string; // a sentence on whether the file is whole, and how far it was read
}

const DEGREE = Math.PI / 180;
const RECORD_AGAIN = "record the log again";
const UNREAD_TOPICS = ["/servos", "/hydraulics", "/command", "/status", "/sensors"]; // not shown, but their times count
const FRAMES = { "/tf robot": "attitude", "/tf estimate": "attitude_estimated" }; // columns of the transforms

/** A quantity in JSON messages of a log: its topic, the unit in its key, the factor to SI, and its parts. */
interface Source {
  name: string;
  topic: string;
  unit: string;
  size: number;
  parts: readonly string[] | "joint";
}

const [PLANE, AXIS, FIN, ONE] = [["x", "y"], ["x", "y", "z"], ["port", "starboard"], []] as const;
const SOURCES: Source[] = [
  { name: "velocity", topic: "/motion", unit: "m_s", size: 1, parts: AXIS },
  { name: "position_estimated", topic: "/estimate", unit: "m", size: 1, parts: PLANE },
  { name: "depth_estimated", topic: "/estimate", unit: "m", size: 1, parts: ONE },
  { name: "speed_estimated", topic: "/estimate", unit: "m_s", size: 1, parts: ONE },
  { name: "position_error", topic: "/estimate", unit: "m", size: 1, parts: ONE },
  { name: "mode", topic: "/mode", unit: "", size: 1, parts: ONE },
  { name: "reasons", topic: "/mode", unit: "", size: 1, parts: ONE },
  { name: "leg", topic: "/mode", unit: "", size: 1, parts: ONE },
  { name: "angle", topic: "/joints", unit: "deg", size: DEGREE, parts: "joint" },
  { name: "fin", topic: "/fins", unit: "deg", size: DEGREE, parts: FIN },
  { name: "battery_voltage", topic: "/battery", unit: "v", size: 1, parts: ONE },
  { name: "power", topic: "/battery", unit: "w", size: 1, parts: ONE },
  { name: "energy", topic: "/battery", unit: "wh", size: 3600, parts: ONE },
  { name: "charge_left", topic: "/battery", unit: "", size: 1, parts: ONE },
];

/** Bad input: names the key, the rule as a verb phrase, the present value and the correction. */
class InputError extends Error {
  constructor(rule: string, { key = "", value = "", fix = "" }: { key?: string; value?: string; fix?: string }) {
    super(`${key === "" ? "" : `: ${key}`} ${rule}${value && `, but is ${value}`}${fix && `: ${fix}`}.`);
  }
}

/** Read a log; throws a sentence that says why a file cannot be read. */
export function readLog(file: string, content: Uint8Array): Log {
  try {
    return read(content);
  } catch (error) {
    if (error instanceof InputError) throw new Error(`${file}${error.message}`);
    throw error;
  }
}

function read(content: Uint8Array): Log {
  if (!isMcap(content)) {
    throw new InputError("must be an MCAP file", { value: "something else", fix: "give a .mcap file" });
  }
  const messages = messagesOf(content, nameOf);
  const metadata = messages.metadata ?? {};
  if ("link" in metadata) {
    const fix =
      "open it in Foxglove, or read it by log info, identify or joint fit; the robot's card has the black box";
    throw new InputError("must be a log of a mission or a black box", { value: "a log of the radio", fix });
  }
  if (metadata.record === undefined) {
    const cut = messages.fault && `, and it is ${messages.fault}`;
    throw new InputError(`must be a hypertuna log: it lacks the header${cut}`, { fix: "give another file" });
  }
  const header = headerOf(metadata.record);
  const { columns, rows, end } = rowsOf(messages, header);
  const read = `${messages.chunks} whole chunks are read, up to ${Number(end.toPrecision(4))} s`;
  const sentence = messages.fault
    ? `The log is ${messages.fault}: ${read}.`
    : "The log is whole; all checksums are right.";
  const head: Head = { ...header, title: `${header.mission.name}, log`, joints: header.joints.length };
  return { head, columns, rows, sentence };
}

// --- the header

interface Header extends Omit<Head, "title" | "joints"> {
  columns: string[];
  joints: string[];
}

function headerOf(text: string): Header {
  try {
    const given = fields(JSON.parse(text));
    const said = (name: string) => ({ name, text: name.replaceAll("_", " ") });
    return {
      robot: string(given.robot),
      columns: strings(given.columns),
      joints: strings(given.joints),
      modes: strings(given.modes).map(said),
      reasons: strings(given.reasons).map(said),
      mission: missionOf(string(given.name), fields(given.mission)),
    };
  } catch {
    throw new InputError("must have a header in hypertuna's format", { key: "record", fix: RECORD_AGAIN });
  }
}

/** Values of keys that a header leaves out of its mission; the same as in the Python program. */
const LEFT_OUT = {
  start: [0, 0],
  home: [0, 0],
  home_radius: 3,
  fence: [],
  bottom: 20,
  depth_max: 5,
  current: [0, 0],
  stay: false,
};

function missionOf(name: string, written: Record<string, unknown>): Mission {
  const given: Record<string, unknown> = { ...LEFT_OUT, ...written };
  const waypoints = list(given.waypoints).map((row) => numbers(list(row).slice(0, 5), 5) as unknown as Waypoint);
  const place = (value: unknown): Place => numbers(value, 2) as unknown as Place;
  if (waypoints.length === 0 || typeof given.stay !== "boolean") throw new TypeError();
  return {
    name,
    waypoints,
    start: place(given.start),
    home: place(given.home),
    home_radius: number(given.home_radius),
    fence: list(given.fence).map(place),
    bottom: number(given.bottom),
    depth_max: number(given.depth_max),
    current: place(given.current),
    stay: given.stay,
  };
}

// Checked casts of parsed JSON; they throw if a value is of another type.

function fields(value: unknown): Record<string, unknown> {
  if (typeof value !== "object" || value === null || Array.isArray(value)) throw new TypeError();
  return value as Record<string, unknown>;
}

function list(value: unknown): unknown[] {
  if (!Array.isArray(value)) throw new TypeError();
  return value;
}

function number(value: unknown): number {
  if (typeof value !== "number" || !Number.isFinite(value)) throw new TypeError();
  return value;
}

function string(value: unknown): string {
  if (typeof value !== "string") throw new TypeError();
  return value;
}

const strings = (value: unknown): string[] => list(value).map(string);

function numbers(value: unknown, count: number): number[] {
  const row = list(value).map(number);
  if (row.length !== count) throw new TypeError();
  return row;
}

// --- the rows

function rowsOf(messages: Messages, header: Header): { columns: Column[]; rows: Float64Array; end: number } {
  const known = new Set(header.columns);
  const frames = Object.entries(FRAMES).filter(([, name]) => known.has(name));
  const sources = SOURCES.filter(({ name }) => known.has(name));
  const topics = [...new Set([...frames.map(([topic]) => topic), ...sources.map(({ topic }) => topic)])];
  const complete = [...topics, ...UNREAD_TOPICS.filter((topic) => messages.times.has(topic))]; // each has every time
  const count = Math.min(...complete.map((topic) => messages.times.get(topic)?.length ?? 0));
  if (frames.length === 0 || count === 0) {
    const rule = `has no time that all topics have${messages.fault && `: it is ${messages.fault}`}`;
    const key = topics.find((topic) => !messages.times.get(topic)?.length) ?? "/tf";
    throw new InputError(rule, { key, fix: "give another file" });
  }
  const times = (messages.times.get(topics[0] ?? "") ?? []).slice(0, count);
  if (times.some((time, k) => k > 0 && time <= (times[k - 1] ?? 0))) {
    throw new InputError("must be at least one finite time, in increasing order", {
      key: "time",
      fix: "give them in s",
    });
  }
  const table = new Table(count, times);
  try {
    for (const [topic, name] of frames) table.pose(messages.contents.get(topic) ?? [], name);
    for (const topic of topics) {
      const own = sources.filter((source) => source.topic === topic);
      if (own.length > 0) table.json(messages.contents.get(topic) ?? [], own, header.joints);
    }
  } catch {
    throw new InputError("must have messages in hypertuna's format", { key: "topics", fix: RECORD_AGAIN });
  }
  return { columns: table.columns, rows: table.rows(), end: times.at(-1) ?? 0 };
}

/** A table whose columns are filled one after another. */
class Table {
  readonly columns: Column[] = [{ name: "time", width: 1 }];
  private readonly values: Float64Array[] = [];

  constructor(
    private readonly count: number,
    times: number[],
  ) {
    this.values.push(Float64Array.from(times));
  }

  private add(name: string, width: number): Float64Array {
    const values = new Float64Array(this.count * width);
    this.columns.push({ name, width });
    this.values.push(values);
    return values;
  }

  /** Read numbers of JSON messages into columns. */
  json(contents: Uint8Array[], sources: Source[], joints: string[]): void {
    const decoder = new TextDecoder();
    const keys = sources.map(({ name, parts, unit }) => {
      const names = parts === "joint" ? joints.map((joint) => joint.replace(/[^\p{L}\p{N}_]/gu, "_")) : parts;
      const whole = (part: string): string => [name, part, unit].filter((text) => text !== "").join("_");
      return parts !== "joint" && names.length === 0 ? [whole("")] : names.map(whole);
    });
    const columns = sources.map(({ name }, s) => this.add(name, keys[s]?.length ?? 1));
    for (let k = 0; k < this.count; k++) {
      const message = fields(JSON.parse(decoder.decode(contents[k])));
      sources.forEach(({ size }, s) => {
        const row = keys[s] ?? [];
        row.forEach((key, part) => columns[s]?.set([number(message[key]) * size], k * row.length + part));
      });
    }
  }

  /** Read transforms into columns: the attitude in hypertuna's body axes, and the position of the true one. */
  pose(contents: Uint8Array[], name: string): void {
    const place = name === "attitude" ? this.add("position", 3) : null;
    const turn = this.add(name, 4);
    for (let k = 0; k < this.count; k++) {
      const parts = new Map(protobuf(contents[k] ?? new Uint8Array()));
      place?.set(doubles(parts.get(4), 3), 3 * k);
      const [x = 0, y = 0, z = 0, w = 0] = doubles(parts.get(5), 4);
      turn.set([-z, y, -x, w], 4 * k); // w, x, y, z: half a turn about z from forward-left-up
    }
  }

  rows(): Float64Array {
    const width = this.columns.reduce((sum, column) => sum + column.width, 0);
    const rows = new Float64Array(this.count * width);
    let at = 0;
    this.columns.forEach(({ width: own }, c) => {
      const values = this.values[c] ?? new Float64Array();
      for (let k = 0; k < this.count; k++) rows.set(values.subarray(k * own, (k + 1) * own), k * width + at);
      at += own;
    });
    return rows;
  }
}

/** Fields 1 to `count` of a protobuf message of doubles; fields that are 0 are absent from the message. */
function doubles(content: Uint8Array | undefined, count: number): number[] {
  if (content === undefined) throw new TypeError();
  const values = new Array<number>(count).fill(0);
  for (const [field, bytes] of protobuf(content)) {
    if (bytes.length !== 8 || field < 1 || field > count) throw new TypeError();
    values[field - 1] = number(new DataView(bytes.buffer, bytes.byteOffset, 8).getFloat64(0, true));
  }
  return values;
}

/** Number and content of the fields of a protobuf message: doubles, and texts or messages below 128 bytes. */
function* protobuf(content: Uint8Array): Generator<[number, Uint8Array]> {
  for (let at = 0; at + 1 < content.length; ) {
    const [tag = 0, next = 0] = [content[at], content[at + 1]];
    const [begin, size] = tag % 8 === 1 ? [at + 1, 8] : [at + 2, next];
    if ((tag % 8 !== 1 && tag % 8 !== 2) || size > 127 || begin + size > content.length) return;
    yield [tag >> 3, content.subarray(begin, begin + size)];
    at = begin + size;
  }
}

/** Name of a message: its topic; for a transform also its child frame. */
function nameOf(topic: string, content: Uint8Array): string {
  if (topic !== "/tf") return topic;
  return `/tf ${new TextDecoder().decode(new Map(protobuf(content)).get(3))}`;
}
