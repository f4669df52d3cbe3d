// The page's address holds everything that it shows: #robot=hypertuna&frequency=6&amplitude=16,25&phase=0,40
import { plain } from "./quantities.ts";
import { DEGREE, type Gait, KINDS } from "./robot.ts";

export interface Address {
  robot: string;
  gait: Gait;
  water: string;
  joints: string;
  of: string; // quantity whose gradient is shown
  view: string;
  tempo: number; // tempo of the picture: 1: real time, 0: stands still
  kept: Record<string, string>; // keys and values that the views store
  body: Record<string, number>; // factors on the robot's body, by name of the knob
}

export function written(address: Address): string {
  const { robot, gait, water, joints, of, view, tempo, kept, body } = address;
  const parts: Record<string, string> = { robot, frequency: String(plain(gait.frequency)) };
  for (const kind of KINDS) parts[kind] = gait[kind].map((angle) => plain(angle / DEGREE)).join(",");
  Object.assign(parts, { water, joints, of, view, tempo: String(tempo) }, kept);
  const factors = Object.entries(body);
  if (factors.length > 0) parts.body = factors.map(([name, factor]) => `${name}:${factor}`).join(",");
  const safe = (value: string): string => encodeURIComponent(value).replaceAll("%2C", ",").replaceAll("%3A", ":");
  return `#${Object.entries(parts)
    .map(([key, value]) => `${key}=${safe(value)}`)
    .join("&")}`;
}

/** Read an address; a key that is missing or misspelled is absent from the result. */
export function read(hash: string): Partial<Address> {
  const parts = new URLSearchParams(hash.replace(/^#/, ""));
  const address: Partial<Address> = { kept: Object.fromEntries(parts) };
  for (const key of ["robot", "water", "joints", "of", "view"] as const) {
    const value = parts.get(key);
    if (value !== null) address[key] = value;
  }
  const gait = gaitIn(parts);
  if (gait !== null) address.gait = gait;
  const [tempo] = numbers(parts.get("tempo"));
  if (tempo !== undefined) address.tempo = Math.min(1, Math.max(0, tempo));
  const factors = (parts.get("body") ?? "").split(",").map((part) => part.split(":"));
  const validFactors = factors.filter(([name, factor]) => name !== "" && Number(factor) > 0);
  if (validFactors.length > 0)
    address.body = Object.fromEntries(validFactors.map(([name, factor]) => [name, Number(factor)]));
  return address;
}

function gaitIn(parts: URLSearchParams): Gait | null {
  const [frequency] = numbers(parts.get("frequency"));
  const [amplitude, phase, bias] = KINDS.map((kind) => numbers(parts.get(kind)).map((angle) => angle * DEGREE));
  if (frequency === undefined || frequency <= 0 || !amplitude || !phase || !bias || amplitude.length === 0) return null;
  return { frequency, amplitude, phase, bias: bias.length ? bias : amplitude.map(() => 0) };
}

/** Numbers separated by commas; none if one of them is misspelled. */
export function numbers(text: string | null): number[] {
  if (text === null || text === "") return [];
  const values = text.split(",").map(Number);
  return values.every(Number.isFinite) ? values : [];
}
