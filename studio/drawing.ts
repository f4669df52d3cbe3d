// The robot from the side and from above, with handles that are dragged: lengths, the tail's height, masses.
import { at, type Point, Shape } from "./body.ts";
import { digits } from "./quantities.ts";
import type { BodyKnob, Robot } from "./robot.ts";

const SVG = "http://www.w3.org/2000/svg";
const GAP = 20; // px around the views
const GRIP = 7; // px, of a handle
const STEPS = 60; // of an outline
const PULL = 120; // px of a drag that multiply a mass by e
const NUDGE = 0.01; // of a factor, by an arrow key
const LARGEST = 0.075; // radius of the heaviest link's circle, body lengths

interface Handle {
  knob: BodyKnob;
  group: SVGGElement;
}

interface Scale {
  size: number; // px per m
  side: number; // px from the top to the axis, of each view
  above: number;
  height: number;
}

/** Factor that a drag makes of the one before; a drag is in px to the right and up. */
type Drag = (knob: BodyKnob, before: number, right: number, up: number) => number;

export class Drawing {
  readonly svg = made("svg", { class: "drawing", role: "group", "aria-label": "Body with handles" });
  private handles: Handle[] = [];
  private robot: Robot | null = null;
  private scale: Scale = { size: 1, side: 0, above: 0, height: 0 };
  private dragged = false;

  /** `turned` hears of a knob's factor. */
  constructor(private readonly turned: (knob: BodyKnob, factor: number) => void) {
    new ResizeObserver(() => this.fit()).observe(this.svg);
  }

  /** Show a robot; the handles are those of its knobs. */
  show(robot: Robot): void {
    const other = this.robot?.robot !== robot.robot || this.robot.body !== robot.body;
    this.robot = robot;
    if (other) this.layOut(robot);
    if (other || !this.dragged) this.fit();
    else this.draw();
  }

  private layOut(robot: Robot): void {
    this.handles = robot.body.knobs
      .filter(({ name }) => /^(length|mass)-\d+$|^fin$/.test(name))
      .map((knob) => ({ knob, group: this.handle(knob) }));
  }

  private handle(knob: BodyKnob): SVGGElement {
    const group = made("g", { class: "handle", tabindex: "0", role: "slider", "aria-label": knob.label });
    group.dataset.handle = knob.name;
    group.append(made("title", {}), made("circle", { r: "18", class: "reach" }), made("circle", { r: String(GRIP) }));
    group.addEventListener("pointerdown", (event) => this.drag(event, knob));
    group.addEventListener("keydown", (event) => this.press(event, knob));
    return group;
  }

  private factor(knob: BodyKnob): number {
    return this.robot?.factors?.[knob.name] ?? 1;
  }

  private drag(event: PointerEvent, knob: BodyKnob): void {
    const { svg } = this;
    const [x, y, before] = [event.clientX, event.clientY, this.factor(knob)];
    const follow = ({ clientX, clientY }: PointerEvent): void =>
      this.turned(knob, this.pulled(knob, before, clientX - x, y - clientY));
    const stop = (): void => {
      svg.removeEventListener("pointermove", follow);
      this.dragged = false;
      this.fit();
    };
    event.preventDefault();
    (event.currentTarget as SVGGElement).focus();
    this.dragged = true;
    svg.setPointerCapture(event.pointerId);
    svg.addEventListener("pointermove", follow);
    for (const end of ["pointerup", "pointercancel"] as const) svg.addEventListener(end, stop, { once: true });
  }

  private pulled: Drag = (knob, before, right, up) => {
    const { size } = this.scale;
    if (knob.name.startsWith("mass")) return before * Math.exp(up / PULL);
    if (knob.name === "fin") return before + (2 * up) / (size * this.tall(this.robot?.described ?? this.robot));
    return before + right / (size * knob.value);
  };

  private press(event: KeyboardEvent, knob: BodyKnob): void {
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    const [low, high] = knob.range;
    const end = { Home: low, End: high }[event.key];
    if (way === undefined && end === undefined) return;
    event.preventDefault();
    this.turned(knob, end ?? this.factor(knob) + (way ?? 0) * NUDGE);
  }

  /** Height of the tail's end [m]. */
  private tall(robot: Robot | null): number {
    return robot?.tail.edge_height ?? robot?.links.at(-1)?.height ?? 0.1;
  }

  /** Choose the scale so that both views fit, with room to draw the body longer. */
  private fit(): void {
    const { robot, svg } = this;
    const width = svg.clientWidth;
    if (robot === null || width === 0) return;
    const length = 1.06 * Math.max(robot.length, robot.described?.length ?? 0);
    const size = (width - 2 * GAP) / length;
    const tallest = Math.max(this.tall(robot), ...robot.links.map(({ height }) => height ?? 0));
    const wide = Math.max(2 * LARGEST * robot.length, ...robot.links.map(({ width }) => width ?? 0), reach(robot));
    const side = GAP + 12 + (size * tallest) / 2;
    const above = side + (size * tallest) / 2 + 56 + (size * wide) / 2;
    this.scale = { size, side, above, height: above + (size * wide) / 2 + GAP };
    this.draw();
  }

  private draw(): void {
    const { robot, svg, scale } = this;
    if (robot === null) return;
    const { size, side, above, height } = scale;
    svg.setAttribute("height", String(Math.ceil(height)));
    const joints = [0];
    for (const { length } of robot.links) joints.push((joints.at(-1) ?? 0) + length);
    const shape = new Shape(robot);
    const place = (x: number, y: number, axis: number): [number, number] => [GAP + size * x, axis - size * y];
    const parts: SVGElement[] = [
      text("from the side", GAP, 12, "label"),
      text("from above; circles are masses", GAP, above - size * 0.5 * this.wide(robot) - 8, "label"),
    ];
    parts.push(
      closed(
        profile(robot, joints).map(([x, y]) => place(x, y, side)),
        "flank",
      ),
    );
    const fin = tailFin(robot, shape);
    if (fin.length > 0)
      parts.push(
        closed(
          fin.map(([x, y]) => place(x, y, side)),
          "tail",
        ),
      );
    parts.push(
      ...pectorals(robot).map((plate) =>
        closed(
          plate.map(([x, y]) => place(x, y, above)),
          "tail",
        ),
      ),
    );
    parts.push(
      closed(
        plan(robot, shape).map(([x, y]) => place(x, y, above)),
        "flank",
      ),
    );
    joints.slice(1, -1).forEach((x, k) => {
      for (const [axis, half] of [
        [side, profileHalf(robot, joints, x)],
        [above, at(shape.stations({ x: 0, y: 0, heading: 0 }, []), x / robot.length).half],
      ] as const)
        parts.push(line(place(x, half, axis), place(x, -half, axis), `joint${k % 2}`));
    });
    this.masses(robot, joints, parts);
    this.place(robot, joints, parts);
    const held = this.handles.map(({ group }) => group);
    for (const old of [...svg.children]) if (!held.includes(old as SVGGElement)) old.remove();
    svg.prepend(...parts);
    for (const group of held) if (group.parentNode !== svg) svg.append(group);
  }

  private wide(robot: Robot): number {
    return Math.max(2 * LARGEST * robot.length, ...robot.links.map(({ width }) => width ?? 0), reach(robot));
  }

  private masses(robot: Robot, joints: number[], parts: SVGElement[]): void {
    robot.links.forEach((link, i) => {
      const [x, y] = this.center(robot, joints, i);
      parts.push(
        made("circle", { cx: String(x), cy: String(y), r: String(this.radius(robot, link.mass)), class: "mass" }),
      );
    });
  }

  private center(robot: Robot, joints: number[], i: number): Point2 {
    const { size, above } = this.scale;
    return [GAP + size * ((joints[i] ?? 0) + (robot.links[i]?.com ?? 0)), above];
  }

  /** Radius of a mass's circle [px], whose area is as the mass. */
  private radius(robot: Robot, mass: number): number {
    const heaviest = Math.max(...(robot.described ?? robot).links.map((link) => link.mass));
    return this.scale.size * LARGEST * (robot.described ?? robot).length * Math.sqrt(mass / heaviest);
  }

  /** Put the handles where their values are, with the lines that lead to them. */
  private place(robot: Robot, joints: number[], parts: SVGElement[]): void {
    const { size, side } = this.scale;
    const low = side + (size * Math.max(...robot.links.map(({ height }) => height ?? 0))) / 2 + 14;
    for (const { knob, group } of this.handles) {
      const [kind, number] = knob.name.split("-");
      const i = Number(number ?? robot.links.length - 1);
      let [x, y]: Point2 = [GAP + size * (joints[i + 1] ?? 0), low + 18 * (i % 2)];
      if (kind === "length") parts.push(line([x, side], [x, y], "lead"));
      if (kind === "fin") [x, y] = [x, side - (size * this.tall(robot)) / 2];
      if (kind === "mass") {
        const [cx, cy] = this.center(robot, joints, i);
        [x, y] = [cx, cy - this.radius(robot, robot.links[i]?.mass ?? 0)];
      }
      const factor = this.factor(knob);
      group.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
      group.classList.toggle("changed", factor !== 1);
      group.setAttribute("aria-valuemin", String(knob.value * knob.range[0]));
      group.setAttribute("aria-valuemax", String(knob.value * knob.range[1]));
      group.setAttribute("aria-valuenow", String(knob.value * factor));
      group.setAttribute("aria-valuetext", `${digits(knob.value * factor)} ${knob.unit}`);
      const title = group.querySelector("title");
      if (title !== null) title.textContent = `${knob.label}: ${digits(knob.value * factor)} ${knob.unit}`;
    }
  }
}

type Point2 = [number, number];

/** How far the pectoral fins reach, both sides together [m]. */
function reach(robot: Robot): number {
  return robot.fins === null ? 0 : 2 * (robot.fins.y + robot.fins.span / 2);
}

/** Half height of the body at a place [m]: between the links' heights, round at the nose. */
function profileHalf(robot: Robot, joints: number[], x: number): number {
  const last = robot.links.length - 1;
  const ends = robot.tail.edge_height === null ? last : last - 1; // a fin is drawn by itself
  const middles = robot.links.map(({ length }, i) => (joints[i] ?? 0) + length / 2);
  let k = 0;
  while (k < ends && (middles[k] ?? 0) < x) k++;
  const [a, b] = [Math.max(0, k - 1), k];
  const [xa, xb] = [middles[a] ?? 0, middles[b] ?? 0];
  const [ha, hb] = [robot.links[a]?.height ?? 0, robot.links[b]?.height ?? 0];
  const t = xb === xa ? 0 : Math.min(1, Math.max(0, (x - xa) / (xb - xa)));
  const nose = Math.min(1, x / (0.16 * robot.length));
  const round = Math.sqrt(Math.max(0, 1 - (1 - nose) ** 2));
  const fin =
    robot.tail.edge_height === null
      ? 1
      : Math.min(1, Math.max(0, (robot.length - x) / (robot.links[last]?.length ?? 1)));
  return (round * Math.sqrt(fin) * (ha + t * (hb - ha))) / 2;
}

function profile(robot: Robot, joints: number[]): Point2[] {
  const xs = Array.from({ length: STEPS + 1 }, (_, k) => (robot.length * (1 - Math.cos((Math.PI * k) / STEPS))) / 2);
  const upper = xs.map((x): Point2 => [x, profileHalf(robot, joints, x)]);
  return [...upper, ...upper.map(([x, y]): Point2 => [x, -y]).reverse()];
}

/** The caudal fin from the side: a crescent as high as its trailing edge. */
function tailFin(robot: Robot, shape: Shape): Point2[] {
  const height = robot.tail.edge_height;
  if (height === null) return [];
  const root = robot.length * (shape.fin + 0.1 * (1 - shape.fin));
  const long = robot.length - root;
  const curve = (from: Point2, bend: Point2, to: Point2): Point2[] =>
    Array.from({ length: 12 }, (_, k) => {
      const t = k / 11;
      const mix = (i: 0 | 1): number => (1 - t) ** 2 * from[i] + 2 * t * (1 - t) * bend[i] + t * t * to[i];
      return [mix(0), mix(1)];
    });
  const upper = [
    ...curve([root, 0.03 * height], [root + 0.35 * long, 0.3 * height], [root + long, height / 2]),
    ...curve([root + long, height / 2], [root + 0.68 * long, 0.22 * height], [root + 0.72 * long, 0]),
  ];
  return [...upper, ...upper.map(([x, y]): Point2 => [x, -y]).reverse()];
}

function plan(robot: Robot, shape: Shape): Point2[] {
  const straight = robot.links.map(() => 0);
  const stations = shape.stations({ x: 0, y: 0, heading: 0 }, straight);
  const upper = stations.map(({ x, half }): Point2 => [x, half]);
  return [...upper, ...upper.map(([x, y]): Point2 => [x, -y]).reverse()];
}

function pectorals(robot: Robot): Point2[][] {
  const { fins } = robot;
  if (fins === null) return [];
  const [root, tip] = [fins.y - fins.span / 2, fins.y + fins.span / 2];
  return [1, -1].map((side) => [
    [fins.x - fins.chord / 2, side * root * 0.8],
    [fins.x, side * tip],
    [fins.x + fins.chord * 0.8, side * tip],
    [fins.x + fins.chord / 2, side * root * 0.8],
  ]);
}

function made<K extends keyof SVGElementTagNameMap>(
  name: K,
  attributes: Record<string, string>,
): SVGElementTagNameMap[K] {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
}

function closed(points: Point2[], style: string): SVGPathElement {
  const path = points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");
  return made("path", { d: `M${path}Z`, class: style });
}

function line([x1, y1]: readonly [number, number], [x2, y2]: readonly [number, number], style: string): SVGLineElement {
  return made("line", { x1: String(x1), y1: String(y1), x2: String(x2), y2: String(y2), class: style });
}

function text(words: string, x: number, y: number, style: string): SVGTextElement {
  const element = made("text", { x: String(x), y: String(y), class: style });
  element.textContent = words;
  return element;
}

export type { Point };
