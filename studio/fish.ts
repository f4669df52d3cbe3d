// The picture: the robot from above in its water, to scale, with the path of its tail.
import { at, beside, type Point, Shape, type Station, scatter } from "./body.ts";
import { colorOf } from "./dom.ts";
import { type Beat, Motion } from "./motion.ts";
import type { Robot } from "./robot.ts";
import { drawing, group, pathFor } from "./svg.ts";

const PATH_POINTS = 32; // points of the tail's path per beat
const MIDLINES = 12; // midlines drawn over a beat
const SHADING_LAYERS = 15; // nested outlines that shade the body
const TRAIL_LENGTH = 9; // length of the tail's path that is kept, body lengths
const TRAIL_STEP = 0.01; // least distance between kept points of the path, body lengths
const FIN_HALF = 0.004; // half thickness of an upright fin seen from above, body lengths
const SPECK_SPACING = 0.17; // distance between specks in the water, body lengths
const PICTURE_WIDTH = 2.7; // width of the picture, body lengths
const PHONE_WIDTH = 2.0; // width of the picture on a phone, body lengths
const PHONE_LIMIT = 560; // px: a page narrower than this is a phone's

export interface Shown {
  tempo: number; // 1: real time, 0: stands still
  midlines: boolean;
  path: boolean;
}

export class Stage {
  readonly shown: Shown = { tempo: 1, midlines: false, path: true };
  private readonly motion = new Motion();
  private pen: CanvasRenderingContext2D;
  private robot: Robot | null = null;
  private shape: Shape | null = null;
  private trail: Point[] = [];
  private camera: Point = { x: 0, y: 0 };
  private before = 0;
  private stale = true;
  private wide = 0; // width of the canvas, CSS px

  constructor(private readonly canvas: HTMLCanvasElement) {
    const pen = canvas.getContext("2d");
    if (pen === null) throw new Error("this browser draws no canvas");
    this.pen = pen;
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
    requestAnimationFrame((now) => this.frame(now));
  }

  /** Show a settled beat of a robot from now on. */
  swim(robot: Robot, beat: Beat): void {
    if (this.robot?.robot !== robot.robot) {
      this.motion.beat = null;
      this.trail = [];
    }
    if (this.robot !== robot) {
      this.robot = robot;
      this.shape = new Shape(robot);
    }
    const first = this.motion.beat === null;
    this.motion.change(beat);
    if (first) this.camera = this.target();
    this.stale = true;
  }

  /** Change what is shown, or the tempo. */
  show(shown: Partial<Shown>): void {
    Object.assign(this.shown, shown);
    this.stale = true;
  }

  /** Draw again, in the colors of the page's theme. */
  refresh(): void {
    this.stale = true;
  }

  /** The picture as SVG. */
  svg(title: string): string {
    const { pen, canvas } = this;
    return drawing(canvas.width, canvas.height, title, (svg) => {
      this.pen = svg;
      this.draw();
      this.pen = pen;
    });
  }

  private color(name: string): string {
    return colorOf(this.canvas, name);
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    this.wide = clientWidth;
    const ratio = Math.min(2, devicePixelRatio);
    this.canvas.width = Math.max(1, Math.round(clientWidth * ratio));
    this.canvas.height = Math.max(1, Math.round(clientHeight * ratio));
    this.stale = true;
  }

  private frame(now: number): void {
    const passed = Math.min(0.1, (now - this.before) / 1000);
    this.before = now;
    const { tempo } = this.shown;
    if (this.motion.beat !== null && (tempo > 0 || this.stale)) {
      this.advance(passed);
      this.draw();
      this.stale = tempo === 0 && this.motion.unsettled;
    }
    requestAnimationFrame((later) => this.frame(later));
  }

  private advance(passed: number): void {
    const { tempo } = this.shown;
    // in small steps, so that the tail's path is smooth even at few frames per second
    const parts = Math.max(1, Math.ceil(passed * tempo * (this.motion.beat?.frequency ?? 1) * PATH_POINTS));
    for (let k = 0; k < parts; k++) {
      this.motion.advance((passed * tempo) / parts, passed / parts);
      if (tempo > 0) this.leave();
    }
    const target = this.target();
    const part = tempo === 0 ? 1 : -Math.expm1(-passed / 0.25);
    this.camera = {
      x: this.camera.x + part * (target.x - this.camera.x),
      y: this.camera.y + part * (target.y - this.camera.y),
    };
  }

  /** Add the tail tip to its path, and drop points that are too far behind. */
  private leave(): void {
    const tip = this.stations().at(-1);
    if (tip === undefined || this.shape === null) return;
    const last = this.trail.at(-1);
    if (last !== undefined && distance(last, tip) < TRAIL_STEP * this.shape.length) return;
    this.trail.push({ x: tip.x, y: tip.y });
    const far = TRAIL_LENGTH * this.shape.length;
    while (this.trail.length > 2 && distance(this.trail[0] ?? tip, tip) > far) this.trail.shift();
    if (this.trail.length > 3000) this.trail.shift();
  }

  /** The point that the camera follows: the middle of the body on its mean path [m]. */
  private target(): Point {
    const { x, y, heading } = this.motion.mean;
    const half = 0.5 * (this.shape?.length ?? 1);
    return { x: x + half * Math.cos(heading), y: y + half * Math.sin(heading) };
  }

  private stations(): Station[] {
    const { pose, bends } = this.motion.now();
    return this.shape?.stations(pose, bends) ?? [];
  }

  // --- drawing

  private get scale(): number {
    const wide = this.wide < PHONE_LIMIT ? PHONE_WIDTH : PICTURE_WIDTH;
    return this.canvas.width / (wide * (this.shape?.length ?? 1));
  }

  /** Place on the canvas [px] of a point in the water [m]. */
  private place(point: Point): [number, number] {
    const { scale, camera, canvas } = this;
    return [canvas.width / 2 + (point.x - camera.x) * scale, canvas.height / 2 - (point.y - camera.y) * scale];
  }

  private line(points: Iterable<Point>): Path2D {
    const path = pathFor(this.pen);
    for (const point of points) path.lineTo(...this.place(point));
    return path;
  }

  private draw(): void {
    const { shape, robot } = this;
    if (shape === null || robot === null) return;
    const { pen } = this;
    const stations = this.stations();
    group(pen, "water");
    this.water(shape.length);
    group(pen, "path");
    if (this.shown.path) this.paths(shape.length);
    group(pen, "fish");
    this.shadow(stations, shape.length);
    if (robot.fins !== null) this.pectoral(stations, robot.fins, shape.length);
    this.body(stations, shape);
    group(pen, "midlines");
    if (this.shown.midlines) this.midlines(shape);
    group(pen, "scale");
    this.scaleBar(shape.length);
  }

  private water(length: number): void {
    const { pen, canvas, camera, scale } = this;
    const shade = pen.createRadialGradient(
      canvas.width * 0.5,
      canvas.height * 0.35,
      0,
      canvas.width * 0.5,
      canvas.height * 0.5,
      canvas.width * 0.75,
    );
    shade.addColorStop(0, this.color("water-high"));
    shade.addColorStop(1, this.color("water-low"));
    pen.fillStyle = shade;
    pen.fillRect(0, 0, canvas.width, canvas.height);
    // specks that rest in the water, one in each cell of a grid
    const cell = SPECK_SPACING * length;
    const [wide, high] = [canvas.width / scale / 2, canvas.height / scale / 2];
    pen.fillStyle = this.color("speck");
    for (let i = Math.floor((camera.x - wide) / cell); i <= (camera.x + wide) / cell; i++)
      for (let j = Math.floor((camera.y - high) / cell); j <= (camera.y + high) / cell; j++) {
        const [a, b, c] = [scatter(i, j, 1), scatter(i, j, 2), scatter(i, j, 3)];
        const [x, y] = this.place({ x: (i + a) * cell, y: (j + b) * cell });
        pen.globalAlpha = 0.15 + 0.5 * c * c;
        pen.beginPath();
        pen.arc(x, y, scale * length * (0.0018 + 0.0028 * c), 0, 7);
        pen.fill();
      }
    pen.globalAlpha = 1;
  }

  /** Draw the path of the tail tip, fading with age, and the mean path of the nose. */
  private paths(length: number): void {
    const { pen, scale, trail } = this;
    pen.lineCap = "butt";
    pen.lineJoin = "round";
    pen.strokeStyle = this.color("sky");
    pen.lineWidth = Math.max(1.2, 0.006 * length * scale);
    const group = Math.ceil(trail.length / 24);
    for (let k = 0; k + 1 < trail.length; k += group) {
      pen.globalAlpha = 0.6 * ((k + group) / trail.length) ** 1.5;
      pen.stroke(this.line(trail.slice(k, k + group + 1)));
    }
    pen.globalAlpha = 0.55;
    pen.strokeStyle = this.color("faint");
    pen.lineWidth = Math.max(1, 0.002 * length * scale);
    pen.setLineDash([6, 6].map((dash) => dash * Math.max(1, scale * length * 0.002)));
    pen.stroke(this.meanPath(length));
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }

  private meanPath(length: number): Path2D {
    const { center, base, mean } = this.motion;
    if (center !== null) {
      const path = pathFor(this.pen);
      path.arc(...this.place(center), distance(center, base) * this.scale, 0, 7);
      return path;
    }
    const way = this.motion.beat?.step ?? { x: 1, y: 0 };
    const angle = Math.atan2(way.y, way.x) + base.heading;
    const far = 3 * length;
    const end = (side: number): Point => ({
      x: mean.x + side * far * Math.cos(angle),
      y: mean.y + side * far * Math.sin(angle),
    });
    return this.line([end(0.05), end(1)]);
  }

  /** Draw the midlines of a beat, in the frame that follows the mean motion. */
  private midlines(shape: Shape): void {
    const { pen, motion } = this;
    pen.strokeStyle = this.color("ink");
    pen.lineWidth = Math.max(1, 0.0022 * shape.length * this.scale);
    pen.globalAlpha = 0.45;
    for (let k = 0; k < MIDLINES; k++) {
      const { pose, bends } = motion.ghost(k / MIDLINES);
      pen.stroke(this.line(shape.stations(pose, bends)));
    }
    pen.globalAlpha = 1;
  }

  private outline(stations: readonly Station[], side: number, lean: number): Path2D {
    const near = stations.map((station) => beside(station, side + lean));
    const far = stations.map((station) => beside(station, lean - side)).reverse();
    const path = this.line([...near, ...far]);
    path.closePath();
    return path;
  }

  private shadow(stations: readonly Station[], length: number): void {
    const { pen, scale } = this;
    pen.save();
    pen.translate(0.03 * length * scale, 0.05 * length * scale);
    pen.fillStyle = this.color("shadow");
    for (let wide = 1.16; wide > 0.5; wide -= 0.1) pen.fill(this.outline(stations, wide, 0));
    pen.restore();
  }

  /** Draw the body, shaded by nested outlines that lean towards the light. */
  private body(stations: readonly Station[], shape: Shape): void {
    const { pen } = this;
    const [flank, back] = [this.color("flank"), this.color("back")];
    for (let k = 0; k < SHADING_LAYERS; k++) {
      const t = k / (SHADING_LAYERS - 1);
      pen.fillStyle = mixed(flank, back, Math.min(1, 1.1 * t ** 0.9));
      pen.fill(this.outline(stations, Math.sqrt(1 - t * t * 0.97), 0.1 * t));
    }
    this.gloss(stations);
    if (shape.fin < 1) for (const part of [0.32, shape.fin]) this.blade(stations, part, part < 0.5 ? 0.5 : 1, shape);
    this.eyes(stations, shape.length);
  }

  /** Draw a dorsal or caudal fin from above: a thin blade between two fractions of the length, sharp at its ends. */
  private blade(stations: readonly Station[], front: number, end: number, shape: Shape): void {
    const { pen } = this;
    const side = (way: number): Point[] =>
      Array.from({ length: 13 }, (_, k) => {
        const half = FIN_HALF * shape.length * Math.sin((Math.PI * k) / 12) ** 0.5;
        return beside({ ...at(stations, front + (k / 12) * (end - front)), half }, way);
      });
    const path = this.line([...side(1), ...side(-1).reverse()]);
    path.closePath();
    pen.fillStyle = this.color("fin");
    pen.fill(path);
  }

  /** Draw the light along the back. */
  private gloss(stations: readonly Station[]): void {
    const { pen } = this;
    const lit = stations.filter(({ part }) => part > 0.03 && part < 0.7);
    pen.fillStyle = "#ffffff";
    for (const side of [0.16, 0.1, 0.05]) {
      pen.globalAlpha = 0.07;
      const near = lit.map((station) => beside(station, -0.42 - side));
      const far = lit.map((station) => beside(station, -0.42 + side)).reverse();
      pen.fill(this.line([...near, ...far]));
    }
    pen.globalAlpha = 1;
  }

  private eyes(stations: readonly Station[], length: number): void {
    const { pen, scale } = this;
    const head = at(stations, 0.075);
    for (const side of [-0.82, 0.82]) {
      const [x, y] = this.place(beside(head, side));
      pen.fillStyle = this.color("eye");
      pen.beginPath();
      pen.ellipse(x, y, 0.0105 * length * scale, 0.0065 * length * scale, -head.angle, 0, 7);
      pen.fill();
    }
  }

  private pectoral(
    stations: readonly Station[],
    fin: { x: number; y: number; span: number; chord: number },
    length: number,
  ): void {
    const { pen } = this;
    pen.fillStyle = this.color("fin");
    pen.globalAlpha = 0.8;
    for (const side of [-1, 1]) {
      const on = (along: number, across: number): [number, number] => {
        const station = at(stations, (fin.x + along) / length);
        return this.place(beside({ ...station, half: 1 }, side * across));
      };
      const [root, tip, chord] = [fin.y - fin.span / 2, fin.y + fin.span / 2, fin.chord];
      const path = pathFor(this.pen);
      path.moveTo(...on(-0.55 * chord, root * 0.85));
      path.quadraticCurveTo(...on(-0.3 * chord, root + 0.75 * fin.span), ...on(0.75 * chord, tip));
      path.quadraticCurveTo(...on(0.35 * chord, root + 0.3 * fin.span), ...on(0.35 * chord, root * 0.85));
      path.closePath();
      pen.fill(path);
    }
    pen.globalAlpha = 1;
  }

  /** Draw a scale bar of 1, 2 or 5 times a power of ten, at most a fifth of the body. */
  private scaleBar(length: number): void {
    const { pen, canvas, scale } = this;
    const power = 10 ** Math.floor(Math.log10(length / 5));
    const bar = Math.max(...[1, 2, 5].map((step) => step * power).filter((step) => step <= length / 5));
    const unit = canvas.width / this.wide;
    const [x, y] = [16 * unit, canvas.height - 18 * unit];
    pen.fillStyle = this.color("ink");
    pen.fillRect(x, y, bar * scale, 2 * unit);
    pen.font = `${12 * unit}px system-ui, sans-serif`;
    pen.fillText(`${Math.round(bar * 1000)} mm`, x + bar * scale + 8 * unit, y + 5 * unit);
  }
}

const distance = (a: Point, b: Point): number => Math.hypot(a.x - b.x, a.y - b.y);

/** Mix two colors of the form #rrggbb; `part` is the fraction of the second. */
function mixed(a: string, b: string, part: number): string {
  const channel = (color: string, k: number): number => Number.parseInt(color.slice(1 + 2 * k, 3 + 2 * k), 16);
  const parts = [0, 1, 2].map((k) => Math.round(channel(a, k) + part * (channel(b, k) - channel(a, k))));
  return `rgb(${parts.join(",")})`;
}
