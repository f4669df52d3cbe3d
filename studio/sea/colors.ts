// Colors of a track by the pilot's mode, depth or speed, distinct to every kind of color vision.
import { colorAt } from "../chart.ts";
import type { Flight } from "./flight.ts";

export const BY = ["mode", "depth", "speed"] as const;
export type By = (typeof BY)[number];

/** Names of colors in the style sheet, by mode. */
const MODES: Record<string, string> = {
  transit: "sea-transit",
  surface: "sea-surface",
  home: "sea-home",
  hold: "sea-hold",
};
const OTHER = "faint"; // color of the other modes: idle, done, ended

export const modeColor = (mode: string): string => MODES[mode] ?? OTHER;

/** Range of the depth [m] or speed [m/s] that the colors of a track cover. */
export function rangeOf(flight: Flight, by: By): [number, number] {
  if (by === "depth") return [0, Math.max(0.5, ...flight.head.mission.waypoints.map(([, , depth]) => 1.1 * depth))];
  return [0, Math.max(0.1, ...flight.head.mission.waypoints.map(([, , , speed]) => 1.1 * speed))];
}

/** Color of a row as channels from 0 to 1; `named` gives the channels of a color of the style sheet. */
export function colorOf(
  flight: Flight,
  by: By,
  k: number,
  range: readonly [number, number],
  named: (name: string) => readonly number[],
): readonly number[] {
  if (by === "mode") return named(modeColor(flight.mode(k).name));
  const value = by === "depth" ? flight.depth(k) : flight.speed(k);
  return colorAt((value - range[0]) / (range[1] - range[0])).map((channel) => channel / 255);
}
