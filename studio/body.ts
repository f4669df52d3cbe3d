// The shape of a robot: its midline through the joints, and its outline from the links' widths.
import type { Robot } from "./robot.ts";

export interface Point {
  x: number;
  y: number;
}

/** A place on the midline: position, direction from nose to tail [rad], half thickness [m], part of the length. */
export interface Station extends Point {
  angle: number;
  half: number;
  part: number;
}

const STATIONS = 64;
const FLAT = 0.6; // width over height of a section where the description has no width
const BLADE = 0.006; // half thickness of a fin, body lengths

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

/** Value between points (x, y) of rising x, constant beyond them. */
export function between(xs: readonly number[], ys: readonly number[], x: number): number {
  let k = 1;
  while (k < xs.length - 1 && (xs[k] ?? 0) < x) k++;
  const [x0 = 0, x1 = 1, y0 = 0, y1 = y0] = [xs[k - 1], xs[k], ys[k - 1], ys[k]];
  const part = Math.min(1, Math.max(0, (x - x0) / (x1 - x0)));
  return y0 + part * (y1 - y0);
}

/** A quadratic Bezier curve in a plane. */
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

/** What of a body does not change while it swims. */
export class Shape {
  readonly links: number[]; // lengths [m]
  readonly fronts = [0]; // of the links, and the body's end [m]
  readonly length: number; // m
  readonly fin: number; // part of the length where the caudal fin begins; 1 without one
  readonly middles: number[]; // of links [m]
  private readonly parts: number[];
  private readonly halves: number[]; // of thickness at the stations [m]

  constructor(robot: Robot) {
    this.links = robot.links.map((link) => link.length);
    for (const length of this.links) this.fronts.push((this.fronts.at(-1) ?? 0) + length);
    this.length = this.fronts.at(-1) ?? 0;
    this.middles = this.links.map((length, k) => (this.fronts[k] ?? 0) + length / 2);
    this.fin = robot.tail.edge_height === null ? 1 : 1 - (0.85 * (this.links.at(-1) ?? 0)) / this.length;
    this.parts = Array.from({ length: STATIONS + 1 }, (_, k) => (1 - Math.cos((Math.PI * k) / STATIONS)) / 2);
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
    let before = 0;
    let last = directions[0] ?? 0;
    return this.parts.map((part, k) => {
      const here = between(this.middles, directions, part * this.length);
      const step = part * this.length - before;
      x += step * Math.cos((here + last) / 2);
      y += step * Math.sin((here + last) / 2);
      [before, last] = [part * this.length, here];
      return { x, y, angle: here, half: this.halves[k] ?? 0, part };
    });
  }

  /** Ratio of each link's width to the streamlined body's there: the drawn body is as wide as the links. */
  private fullness(robot: Robot): number[] {
    const ratios = robot.links.map((link, k) => {
      const width = link.width ?? FLAT * (link.height ?? this.length / 6);
      const places = [0.1, 0.3, 0.5, 0.7, 0.9].map((t) => ((this.fronts[k] ?? 0) + t * link.length) / this.length);
      return width / 2 / (places.reduce((sum, place) => sum + this.section(place), 0) / places.length);
    });
    const last = ratios.length - 1;
    if (last > 0) ratios[last] = Math.min(ratios[last] ?? 0, ratios[last - 1] ?? 0);
    return ratios;
  }

  /** Part of the length at which the streamlined body ends: a fin goes on from there. */
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

  /** Half thickness of the caudal fin, sharp at its end. */
  private blade(part: number): number {
    return this.fin < 1 ? BLADE * this.length * (1 - part) ** 0.5 * 1.6 : 0;
  }
}

/** Point beside a station: `side` half thicknesses to the left of the way from nose to tail. */
export function beside(station: Station, side: number): Point {
  const reach = side * station.half;
  return { x: station.x - reach * Math.sin(station.angle), y: station.y + reach * Math.cos(station.angle) };
}

/** Station at a part of the length. */
export function at(stations: readonly Station[], part: number): Station {
  let k = 1;
  while (k < stations.length - 1 && (stations[k]?.part ?? 1) < part) k++;
  const [a, b] = [stations[k - 1], stations[k]];
  if (a === undefined || b === undefined) throw new Error("a body has stations");
  const t = (part - a.part) / (b.part - a.part);
  const mix = (p: number, q: number): number => p + t * (q - p);
  return { x: mix(a.x, b.x), y: mix(a.y, b.y), angle: mix(a.angle, b.angle), half: mix(a.half, b.half), part };
}

/** A number from 0 to 1 that belongs to a cell of the water. */
export function scatter(i: number, j = 0, salt = 0): number {
  let h = Math.imul(i, 374761393) + Math.imul(j, 668265263) + Math.imul(salt, 1274126177);
  h = Math.imul(h ^ (h >>> 13), 1274126177);
  return ((h ^ (h >>> 16)) >>> 0) / 2 ** 32;
}
