// Describes a flight in words and numbers.
import { digits } from "../quantities.ts";
import type { Flight } from "./flight.ts";

const MEAN_ROWS = 5; // rows before and after a row, for a mean over about a second

/** A time [s] as minutes:seconds. */
export function clock(seconds: number): string {
  const whole = Math.floor(Math.max(0, seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

/** Speed through the water [m/s], mean over about a second, as the nose swings with the beat. */
export function speedOf(flight: Flight, k: number): number {
  let [sum, count] = [0, 0];
  for (let row = Math.max(0, k - MEAN_ROWS); row <= Math.min(flight.count - 1, k + MEAN_ROWS); row++) {
    sum += flight.speed(row);
    count++;
  }
  return sum / count;
}

/** The pilot's present task. */
export function task(flight: Flight, k: number): string {
  const { waypoints, home } = flight.head.mission;
  const { name, text } = flight.mode(k);
  const leg = flight.value("leg", k);
  const [x, y] = flight.position(k);
  const away = ([east, north]: readonly number[]): string =>
    `${digits(Math.hypot((east ?? 0) - x, (north ?? 0) - y), 3)} m away`;
  const point = waypoints[leg];
  if (name === "transit" && point !== undefined) return `to waypoint ${leg + 1} of ${waypoints.length}, ${away(point)}`;
  if (name === "home") return `on the way home, ${away(home)}`;
  return text;
}

/** The pilot's reasons, one line each. */
export function why(flight: Flight, k: number): string {
  const reasons = flight.reasons(k).map(({ name, text }) => {
    const said = name.replaceAll("_", " ");
    return text === "" || text === said ? `${said}.` : `${said}: ${text}.`;
  });
  return reasons.length === 0 ? "The pilot reports no fault and no limit." : reasons.join("\n");
}

const DEGREE = Math.PI / 180;

/** Heading (clockwise from north), pitch (nose up) and roll (starboard down) [deg]. */
export function angles(flight: Flight, k: number): [number, number, number] {
  const [x, y, z, w] = flight.attitude(k);
  // the body's axes: x from nose to tail, y to starboard
  const [north, east, up] = [2 * (x * y + w * z), 1 - 2 * (y * y + z * z), 2 * (x * z - w * y)];
  const side = 2 * (y * z + w * x);
  const high = 1 - 2 * (x * x + y * y);
  const heading = Math.atan2(-east, -north) / DEGREE;
  return [(heading + 360) % 360, Math.asin(Math.max(-1, Math.min(1, -up))) / DEGREE, Math.atan2(-side, high) / DEGREE];
}

const tilt = (angle: number): string => `${Math.round(angle) + 0}°`.replace("-", "−");

export interface Fact {
  value: string;
  label: string;
}

export function facts(flight: Flight, k: number): Fact[] {
  const error = flight.error(k);
  const spread = flight.value("position_error", k);
  const charge = flight.value("charge_left", k);
  const said = flight.mode(k).name;
  return [
    { value: said === "" ? "–" : said, label: task(flight, k) },
    { value: `${flight.depth(k).toFixed(2)} m`, label: `depth, of ${digits(flight.head.mission.bottom, 3)} m` },
    { value: `${speedOf(flight, k).toFixed(2).replace("-", "−")} m/s`, label: "speed through the water" },
    {
      value: `${angles(flight, k)[0].toFixed(0)}°`,
      label: `heading from north; pitch ${tilt(angles(flight, k)[1])}, roll ${tilt(angles(flight, k)[2])}`,
    },
    {
      value: `± ${digits(2 * spread, 2)} m`,
      label: Number.isNaN(error)
        ? "believed place, 2 standard deviations"
        : `believed place, 2 standard deviations; off by ${digits(error, 2)} m`,
    },
    {
      value: Number.isNaN(charge) ? "–" : `${(100 * charge).toFixed(1)} %`,
      label: `charge left; ${digits(flight.value("power", k), 2)} W`,
    },
  ];
}

/** A sentence for readers who do not see the picture. */
export function spoken(flight: Flight, k: number): string {
  const { name, robot } = { name: flight.head.mission.name, robot: flight.head.robot };
  return `${robot} on the mission ${name}: ${flight.mode(k).name}, ${task(flight, k)}, depth ${digits(flight.depth(k), 2)} m`;
}
