// The shape of a robot: its midline through the joints, and its outline from the links' widths.
import type { Robot } from "./robot.ts";

export interface Point {
  x: number;
  y: number;
}

/** A point of the midline: place [m], direction from nose to tail [rad], half thickness [m], fraction of length. */
export interface Station extends Point {
  angle: number;
  half: number;
  part: number;
}

const STATION_COUNT = 64;
const WIDTH_RATIO = 0.6; // width over height of a link whose width the description leaves out
const FIN_HALF = 0.006; // half thickness of the caudal fin, body lengths

/** Thickness of a streamlined body over its length: a NACA four-digit section with a closed end. */
function section(part: number): number {
  const t = Math.min(1, Math.max(0, part));
  return 0.2969 * Math.sqrt(t) - 0.126 * t - 0.3516 * t ** 2 + 0.2843 * t ** 3 - 0.1036 * t ** 4;
}

/** Thickness of a slender body that has no fin at its end: a round nose, a long trunk, a tail that tapers. */
function slender(part: number): number {
  const nose = Math.min(1, part / 0.14);
  const tail = Math.max(0, (part - 0.5) / 0.5);
  return 0.17 * Math.sqrt(1 - (1 - nose) ** 2) * Math.sqrt(Math.max(0, 1 - tail ** 2.2));
}

/** Linear interpolation between points (x, y) with rising x; constant beyond the ends. */
export function between(xs: readonly number[], ys: readonly number[], x: number): number {
  let k = 1;
  while (k < xs.length - 1 && (xs[k] ?? 0) < x) k++;
  const [x0 = 0, x1 = 1, y0 = 0, y1 = y0] = [xs[k - 1], xs[k], ys[k - 1], ys[k]];
  const part = Math.min(1, Math.max(0, (x - x0) / (x1 - x0)));
  return y0 + part * (y1 - y0);
}

/** Point of a quadratic Bezier curve in the plane; `t` runs from 0 to 1. */
export function curve(
  from: readonly number[],
  bend: readonly number[],
  to: readonly number[],
  t: number,
): [number, number] {
  const mix = (k: number): number =>
    (1 - t) ** 2 * (from[k] ?? 0) + 2 * t * (1 - t) * (bend[k] ?? 0) + t * t * (to[k] ?? 0);
  return [mix(0), mix(1)];
}

/** The geometry of a body that stays the same while it swims. */
export class Shape {
  readonly links: number[]; // lengths of the links [m]
  readonly fronts = [0]; // place where each link begins, and where the body ends [m from the nose]
  readonly length: number; // length of the body [m]
  readonly fin: number; // fraction of the length at which the caudal fin begins; 1 without a fin
  readonly middles: number[]; // middles of the links [m from the nose]
  private readonly parts: number[]; // fractions of the length at the stations
  private readonly halves: number[]; // half thicknesses at the stations [m]

  constructor(robot: Robot) {
    this.links = robot.links.map((link) => link.length);
    for (const length of this.links) this.fronts.push((this.fronts.at(-1) ?? 0) + length);
    this.length = this.fronts.at(-1) ?? 0;
    this.middles = this.links.map((length, k) => (this.fronts[k] ?? 0) + length / 2);
    this.fin = robot.tail.edge_height === null ? 1 : 1 - (0.85 * (this.links.at(-1) ?? 0)) / this.length;
    this.parts = Array.from({ length: STATION_COUNT + 1 }, (_, k) => (1 - Math.cos((Math.PI * k) / STATION_COUNT)) / 2);
    this.halves = this.parts.map((part) => this.half(part, this.fullness(robot)));
  }

  /** The midline of a body whose nose is at `pose`, with a bend [rad] in front of each link. */
  stations(pose: Point & { heading: number }, bends: ArrayLike<number>): Station[] {
    let angle = pose.heading;
    const directions = this.links.map((_, k) => {
      angle += bends[k] ?? 0;
      return angle;
    });
    let { x, y } = pose;
    let lastPlace = 0;
    let lastDirection = directions[0] ?? 0;
    return this.parts.map((part, k) => {
      const direction = between(this.middles, directions, part * this.length);
      const step = part * this.length - lastPlace;
      x += step * Math.cos((direction + lastDirection) / 2);
      y += step * Math.sin((direction + lastDirection) / 2);
      [lastPlace, lastDirection] = [part * this.length, direction];
      return { x, y, angle: direction, half: this.halves[k] ?? 0, part };
    });
  }

  /** Ratio of each link's width to that of the streamlined section, so that the drawn body is as wide. */
  private fullness(robot: Robot): number[] {
    const ratios = robot.links.map((link, k) => {
      const width = link.width ?? WIDTH_RATIO * (link.height ?? this.length / 6);
      const places = [0.1, 0.3, 0.5, 0.7, 0.9].map((t) => ((this.fronts[k] ?? 0) + t * link.length) / this.length);
      return width / 2 / (places.reduce((sum, place) => sum + this.section(place), 0) / places.length);
    });
    const last = ratios.length - 1;
    if (last > 0) ratios[last] = Math.min(ratios[last] ?? 0, ratios[last - 1] ?? 0);
    return ratios;
  }

  /** Fraction of the length at which the streamlined body ends; a caudal fin continues behind it. */
  private get end(): number {
    return this.fin < 1 ? 0.5 + this.fin / 2 : 1;
  }

  private section(part: number): number {
    return this.fin < 1 ? section(part / this.end) : slender(part);
  }

  private half(part: number, fullness: number[]): number {
    const body = this.section(part) * between(this.middles, fullness, Math.min(part, this.fin) * this.length);
    return part < this.fin ? body : Math.max(part < this.end ? body : 0, this.blade(part));
  }

  /** Half thickness of the caudal fin [m], sharp at its trailing edge. */
  private blade(part: number): number {
    return this.fin < 1 ? FIN_HALF * this.length * (1 - part) ** 0.5 * 1.6 : 0;
  }
}

/** Point beside a station: `side` half thicknesses to the left of the direction from nose to tail. */
export function beside(station: Station, side: number): Point {
  const reach = side * station.half;
  return { x: station.x - reach * Math.sin(station.angle), y: station.y + reach * Math.cos(station.angle) };
}

/** Station at a fraction of the length, interpolated between its neighbors. */
export function at(stations: readonly Station[], part: number): Station {
  let k = 1;
  while (k < stations.length - 1 && (stations[k]?.part ?? 1) < part) k++;
  const [a, b] = [stations[k - 1], stations[k]];
  if (a === undefined || b === undefined) throw new Error("a body has stations");
  const t = (part - a.part) / (b.part - a.part);
  const mix = (p: number, q: number): number => p + t * (q - p);
  return { x: mix(a.x, b.x), y: mix(a.y, b.y), angle: mix(a.angle, b.angle), half: mix(a.half, b.half), part };
}

/** A pseudorandom number from 0 to 1 for cell (i, j) of a grid; `salt` chooses another sequence. */
export function scatter(i: number, j = 0, salt = 0): number {
  let h = Math.imul(i, 374761393) + Math.imul(j, 668265263) + Math.imul(salt, 1274126177);
  h = Math.imul(h ^ (h >>> 13), 1274126177);
  return ((h ^ (h >>> 16)) >>> 0) / 2 ** 32;
}
