// A drawing of the robot from the side and from above, with handles to drag its lengths, tail height and masses.
import { at, between, curve, Shape } from "./body.ts";
import { digits } from "./quantities.ts";
import type { BodyKnob, Robot } from "./robot.ts";

const SVG = "http://www.w3.org/2000/svg";
const GAP = 20; // px around the views
const SIDE_BY_SIDE_WIDTH = 720; // px: from this width on, the two views stand side by side
const TITLE_HEIGHT = 20; // px above a view
const HANDLE_RADIUS = 7; // px, radius of a handle
const OUTLINE_POINTS = 60; // points of an outline
const MASS_DRAG = 120; // px: a drag of this length multiplies a mass by e
const KEY_STEP = 0.01; // change of a factor by an arrow key
const HANDLE_DISTANCE = 46; // px from the body to the handles of the lengths
const NOWHERE = { left: 0, top: 0 };
const MAX_MASS_RADIUS = 0.075; // radius of the heaviest link's circle, body lengths

interface Handle {
  knob: BodyKnob;
  group: SVGGElement;
}

/** Position of the nose in a view [px]. */
interface Axis {
  left: number;
  top: number;
}

interface Scale {
  size: number; // px per m
  side: Axis;
  above: Axis;
  height: number; // px of the drawing
}

/** Maps the factor before a drag to the one after it; the drag is given in px to the right and up. */
type Drag = (knob: BodyKnob, before: number, right: number, up: number) => number;

export class Drawing {
  readonly svg = made("svg", { class: "drawing", role: "group", "aria-label": "Body with handles" });
  private handles: Handle[] = [];
  private robot: Robot | null = null;
  private scale: Scale = { size: 1, side: NOWHERE, above: NOWHERE, height: 0 };
  private dragged = false;

  /** `turned` is called with the new factor of a knob. */
  constructor(private readonly turned: (knob: BodyKnob, factor: number) => void) {
    new ResizeObserver(() => this.fit()).observe(this.svg);
  }

  /** Show a robot with a handle for each of its knobs. */
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
    group.append(
      made("title", {}),
      made("circle", { r: "18", class: "reach" }),
      made("circle", { r: String(HANDLE_RADIUS) }),
    );
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
    if (knob.name.startsWith("mass")) return before * Math.exp(up / MASS_DRAG);
    if (knob.name === "fin") return before + (2 * up) / (size * this.tall(this.robot?.described ?? this.robot));
    return before + right / (size * knob.value);
  };

  private press(event: KeyboardEvent, knob: BodyKnob): void {
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    const [low, high] = knob.range;
    const end = { Home: low, End: high }[event.key];
    if (way === undefined && end === undefined) return;
    event.preventDefault();
    this.turned(knob, end ?? this.factor(knob) + (way ?? 0) * KEY_STEP);
  }

  /** Height of the tail's trailing edge [m]. */
  private tall(robot: Robot | null): number {
    return robot?.tail.edge_height ?? robot?.links.at(-1)?.height ?? 0.1;
  }

  /** Choose the scale so that both views fit, with space for a longer body. */
  private fit(): void {
    const { robot, svg } = this;
    const width = svg.clientWidth;
    if (robot === null || width === 0) return;
    const beside = width >= SIDE_BY_SIDE_WIDTH;
    const viewWidth = beside ? width / 2 : width;
    const size = (viewWidth - 2 * GAP) / (1.06 * Math.max(robot.length, robot.described?.length ?? 0));
    const body = Math.max(...robot.links.map(({ height }) => height ?? 0));
    const high = (size * Math.max(this.tall(robot), body)) / 2;
    const low = Math.max(high, (size * body) / 2 + HANDLE_DISTANCE);
    const wide = (size * this.wide(robot)) / 2;
    const under = Math.max(
      wide,
      (size * Math.max(...robot.links.map(({ width }) => width ?? 0))) / 2 + HANDLE_DISTANCE,
    );
    const half = beside ? Math.max(high, wide) : high;
    const side = { left: GAP, top: TITLE_HEIGHT + GAP + half };
    const above = {
      left: GAP + (beside ? viewWidth : 0),
      top: beside ? side.top : side.top + low + GAP + TITLE_HEIGHT + wide,
    };
    this.scale = { size, side, above, height: Math.max(side.top + low, above.top + under) + GAP };
    this.draw();
  }

  private draw(): void {
    const { robot, svg, scale } = this;
    if (robot === null) return;
    svg.setAttribute("height", String(Math.ceil(scale.height)));
    const shape = new Shape(robot);
    const joints = shape.fronts;
    const parts = [...this.views(robot, joints, shape), ...this.masses(robot, joints), ...this.place(robot, joints)];
    const held: Element[] = this.handles.map(({ group }) => group);
    for (const old of [...svg.children]) if (!held.includes(old)) old.remove();
    svg.prepend(...parts);
    for (const group of held) if (group.parentNode !== svg) svg.append(group);
  }

  /** The body from the side and from above, with lines at its joints. */
  private views(robot: Robot, joints: number[], shape: Shape): SVGElement[] {
    const { side, above, size } = this.scale;
    const on = (axis: Axis, style: string, points: Pair[]): SVGElement =>
      closed(
        points.map(([x, y]) => this.at(axis, x, y)),
        style,
      );
    const straight = shape.stations({ x: 0, y: 0, heading: 0 }, robot.links.map(zero));
    const lines = joints.slice(1, -1).flatMap((x) => {
      const halves: [Axis, number][] = [
        [side, profileHalf(robot, joints, x)],
        [above, at(straight, x / robot.length).half],
      ];
      return halves.map(([axis, half]) => line(this.at(axis, x, half), this.at(axis, x, -half), "joint"));
    });
    return [
      text("from the side", [GAP, TITLE_HEIGHT]),
      text("from above; circles are masses", [
        above.left,
        Math.max(TITLE_HEIGHT, above.top - (size * this.wide(robot)) / 2 - 10),
      ]),
      on(side, "flank", profile(robot, joints)),
      ...(robot.tail.edge_height === null ? [] : [on(side, "tail", tailFin(robot, shape))]),
      ...pectorals(robot).map((plate) => on(above, "tail", plate)),
      on(above, "flank", mirrored(straight.map(({ x, half }): Pair => [x, half]))),
      ...lines,
    ];
  }

  private at(axis: Axis, x: number, y: number): Pair {
    const { size } = this.scale;
    return [axis.left + size * x, axis.top - size * y];
  }

  private wide(robot: Robot): number {
    return Math.max(2 * MAX_MASS_RADIUS * robot.length, ...robot.links.map(({ width }) => width ?? 0), reach(robot));
  }

  private masses(robot: Robot, joints: number[]): SVGElement[] {
    return robot.links.map(({ mass }, i) => {
      const [x, y] = this.center(robot, joints, i);
      return made("circle", { cx: String(x), cy: String(y), r: String(this.radius(robot, mass)), class: "mass" });
    });
  }

  private center(robot: Robot, joints: number[], i: number): Pair {
    return this.at(this.scale.above, (joints[i] ?? 0) + (robot.links[i]?.com ?? 0), 0);
  }

  /** Radius of a mass's circle [px]; the circle's area is proportional to the mass. */
  private radius(robot: Robot, mass: number): number {
    const { links, length } = robot.described ?? robot;
    return this.scale.size * MAX_MASS_RADIUS * length * Math.sqrt(mass / Math.max(...links.map((link) => link.mass)));
  }

  /** Move the handles to their values; returns the lines that connect them to the body. */
  private place(robot: Robot, joints: number[]): SVGElement[] {
    const { size, side, above } = this.scale;
    const half = (of: "height" | "width"): number => (size * Math.max(...robot.links.map((link) => link[of] ?? 0))) / 2;
    const leads: SVGElement[] = [];
    for (const { knob, group } of this.handles) {
      const [kind, number] = knob.name.split("-");
      const i = Number(number ?? robot.links.length - 1);
      const row = 14 + 18 * (i % 2);
      let [x, y]: Pair = [side.left + size * (joints[i + 1] ?? 0), side.top + half("height") + row];
      if (kind === "fin") y = side.top - (size * this.tall(robot)) / 2;
      if (kind === "mass") [x, y] = [this.center(robot, joints, i)[0], above.top + half("width") + row];
      if (kind !== "fin") leads.push(line([x, (kind === "mass" ? above : side).top], [x, y], "lead"));
      const factor = this.factor(knob);
      const words = `${digits(knob.value * factor)} ${knob.unit}`;
      group.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
      group.classList.toggle("changed", factor !== 1);
      group.setAttribute("aria-valuemin", String(knob.value * knob.range[0]));
      group.setAttribute("aria-valuemax", String(knob.value * knob.range[1]));
      group.setAttribute("aria-valuenow", String(knob.value * factor));
      group.setAttribute("aria-valuetext", words);
      group.firstElementChild?.replaceChildren(`${knob.label}: ${words}`);
    }
    return leads;
  }
}

type Pair = [number, number];

const zero = (): number => 0;

/** Distance between the tips of the two pectoral fins [m]. */
function reach(robot: Robot): number {
  return robot.fins === null ? 0 : 2 * (robot.fins.y + robot.fins.span / 2);
}

/** Half height of the body at a place [m]: interpolated between the links' heights, round at the nose. */
function profileHalf(robot: Robot, joints: number[], x: number): number {
  const last = robot.links.length - 1;
  const ends = robot.tail.edge_height === null ? last : last - 1; // the caudal fin is drawn separately
  const middles = robot.links.slice(0, ends + 1).map(({ length }, i) => (joints[i] ?? 0) + length / 2);
  const heights = robot.links.map(({ height }) => height ?? 0);
  const nose = Math.min(1, x / (0.16 * robot.length));
  const round = Math.sqrt(Math.max(0, 1 - (1 - nose) ** 2));
  const fin =
    robot.tail.edge_height === null
      ? 1
      : Math.min(1, Math.max(0, (robot.length - x) / (robot.links[last]?.length ?? 1)));
  return (round * Math.sqrt(fin) * between(middles, heights, x)) / 2;
}

function profile(robot: Robot, joints: number[]): Pair[] {
  const xs = Array.from(
    { length: OUTLINE_POINTS + 1 },
    (_, k) => (robot.length * (1 - Math.cos((Math.PI * k) / OUTLINE_POINTS))) / 2,
  );
  const upper = xs.map((x): Pair => [x, profileHalf(robot, joints, x)]);
  return mirrored(upper);
}

/** The caudal fin from the side: a crescent as high as its trailing edge. */
function tailFin(robot: Robot, shape: Shape): Pair[] {
  const height = robot.tail.edge_height;
  if (height === null) return [];
  const root = robot.length * (shape.fin + 0.1 * (1 - shape.fin));
  const long = robot.length - root;
  const edge = (...points: [Pair, Pair, Pair]): Pair[] =>
    Array.from({ length: 12 }, (_, k) => curve(...points, k / 11));
  const upper = [
    ...edge([root, 0.03 * height], [root + 0.35 * long, 0.3 * height], [root + long, height / 2]),
    ...edge([root + long, height / 2], [root + 0.68 * long, 0.22 * height], [root + 0.72 * long, 0]),
  ];
  return mirrored(upper);
}

/** A closed outline from its upper half. */
function mirrored(upper: Pair[]): Pair[] {
  return [...upper, ...upper.map(([x, y]): Pair => [x, -y]).reverse()];
}

function pectorals(robot: Robot): Pair[][] {
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

function closed(points: Pair[], style: string): SVGPathElement {
  const path = points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");
  return made("path", { d: `M${path}Z`, class: style });
}

function line([x1, y1]: Pair, [x2, y2]: Pair, style: string): SVGLineElement {
  return made("line", { x1: String(x1), y1: String(y1), x2: String(x2), y2: String(y2), class: style });
}

function text(words: string, [x, y]: Pair): SVGTextElement {
  const element = made("text", { x: String(x), y: String(y), class: "label" });
  element.textContent = words;
  return element;
}
