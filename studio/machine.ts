// Draws the machine inside the robot at one tick: servos on axles, or servos, cylinders, lines and muscles.
import { at, beside, type Point, Shape, type Station } from "./body.ts";
import { colorOf } from "./dom.ts";
import { type Drive, drivesOf, hasOil } from "./drives.ts";
import { bendsOf, type Robot } from "./robot.ts";

/** Numbers of one tick: joint angles [rad]; angles [rad], pressures [Pa], torques [N m] of the two drives a joint. */
export interface Moment {
  angle: number[];
  angleSet: number[];
  servo: number[];
  servoTarget: number[];
  pump: number[];
  unit: number[];
  torque: number[];
}

const FULL_PRESSURE = 250e3; // Pa: pressure at which the color is full
const BODY_LENGTH = 0.84; // length of the body, fraction of the picture's width
const AXLE_RADIUS = 15; // px, largest radius of a servo on an axle
const MAX_WIDENING = 2.2; // largest factor by which widths are drawn larger
const BODY_HALF = 0.25; // half width of the drawn body, fraction of the picture's height
const NAMES_HEIGHT = 24; // px below the body for the joints' names

export class Machine {
  private readonly shape: Shape;
  private readonly pen: CanvasRenderingContext2D;
  private width = 0;
  private height = 0;
  private stations: Station[] = []; // stations of the bent midline
  private readonly drives: Drive[];

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly robot: Robot,
  ) {
    const pen = canvas.getContext("2d");
    if (pen === null) throw new Error("this browser draws no canvas");
    this.pen = pen;
    this.shape = new Shape(robot);
    this.drives = drivesOf(robot);
  }

  draw(moment: Moment): void {
    const { canvas, pen } = this;
    [this.width, this.height] = [canvas.clientWidth, canvas.clientHeight];
    const ratio = Math.min(2, devicePixelRatio);
    [canvas.width, canvas.height] = [Math.round(this.width * ratio), Math.round(this.height * ratio)];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.font = `12px ${getComputedStyle(canvas).fontFamily}`;
    const bends = bendsOf(this.robot, moment.angle);
    const tip = this.shape.stations({ x: 0, y: 0, heading: 0 }, bends).at(-1) ?? { x: 1, y: 0 };
    const heading = -Math.atan2(tip.y, tip.x); // nose and tail tip at the same height
    const pose = { x: 0, y: 0, heading };
    const heights = this.shape.stations(pose, bends).map(({ y }) => y);
    pose.y = -(Math.min(...heights) + Math.max(...heights)) / 2;
    this.stations = this.shape.stations(pose, bends);
    this.hull();
    const oiled = [...new Set(this.drives.filter(hasOil).map(({ joint }) => joint))];
    for (const drive of this.drives)
      if (hasOil(drive)) this.circuit(drive, oiled.indexOf(drive.joint), oiled.length, moment);
      else this.axle(drive, heading, bends, moment);
    this.names();
  }

  private color(name: string): string {
    return colorOf(this.canvas, name);
  }

  private get scale(): number {
    return (BODY_LENGTH * this.width) / this.shape.length;
  }

  private place(point: Point): [number, number] {
    return [
      (1 - BODY_LENGTH) * 0.4 * this.width + point.x * this.scale,
      (this.height - NAMES_HEIGHT) / 2 - point.y * this.scale,
    ];
  }

  /** A point at a fraction of the length, `side` half widths beside the midline; widths are drawn larger. */
  private on(part: number, side: number): [number, number] {
    const widest = Math.max(...this.stations.map(({ half }) => half));
    const widening = Math.min(MAX_WIDENING, Math.max(1, (BODY_HALF * this.height) / (widest * this.scale)));
    const station = at(this.stations, part);
    return this.place(
      beside({ ...station, half: Math.max(station.half, part < 0.5 ? 0 : 0.18 * widest) }, side * widening),
    );
  }

  /** The fraction of the length at which a link begins. */
  private front(link: number): number {
    return (this.shape.fronts[link] ?? 0) / this.shape.length;
  }

  private hull(): void {
    const { pen } = this;
    const end = this.shape.fin < 1 ? this.shape.fin : 1;
    const parts = Array.from({ length: 61 }, (_, k) => (end * (1 - Math.cos((Math.PI * k) / 60))) / 2);
    pen.beginPath();
    for (const part of parts) pen.lineTo(...this.on(part, at(this.stations, part).half > 0 ? 1 : 0));
    for (const part of parts.reverse()) pen.lineTo(...this.on(part, -1));
    pen.closePath();
    pen.fillStyle = this.color("hull");
    pen.strokeStyle = this.color("back");
    pen.lineWidth = 1.5;
    pen.fill();
    pen.stroke();
    if (end < 1) this.trace([this.on(end, 0), this.on((1 + end) / 2, 0), this.on(1, 0)], this.color("fin"), 5);
  }

  private trace(points: [number, number][], color: string, width: number): void {
    const { pen } = this;
    pen.strokeStyle = color;
    pen.lineWidth = width;
    pen.lineCap = "round";
    pen.lineJoin = "round";
    pen.beginPath();
    for (const point of points) pen.lineTo(...point);
    pen.stroke();
  }

  /** Color of oil at a pressure: blue for suction, orange for pressure, stronger with its size. */
  private oil(pressure: number): string {
    const part = Math.min(1, Math.abs(pressure) / FULL_PRESSURE);
    const end = this.color(pressure < 0 ? "blue" : "orange");
    return `color-mix(in oklab, ${end} ${(100 * part ** 0.7).toFixed(0)}%, ${this.color("oil")})`;
  }

  /** The fractions of the length between which a joint bends. */
  private span(joint: number): [number, number] {
    const links = this.robot.joints[joint]?.links ?? [];
    return [this.front(links[0] ?? 0), Math.min(this.shape.fin, this.front((links.at(-1) ?? 0) + 1))];
  }

  /** Draw the midlines of the joints, and below them the joints' names, shortened to the space that they have. */
  private names(): void {
    const { pen } = this;
    const middles = this.robot.joints.map((_, joint) => {
      const [begin, end] = this.span(joint);
      const parts = [0, 0.25, 0.5, 0.75, 1].map((t) => this.on(begin + t * (end - begin), 0));
      this.trace(parts, this.color("faint"), 1);
      return this.on(
        this.drives.some((drive) => drive.joint === joint && hasOil(drive)) ? (begin + end) / 2 : begin,
        0,
      )[0];
    });
    const nameWidth = Math.min(this.width / 3, ...middles.slice(1).map((x, k) => x - (middles[k] ?? 0))) - 6;
    pen.fillStyle = this.color("ink");
    pen.textAlign = "center";
    this.robot.joints.forEach(({ name }, joint) => {
      let shown = name;
      while (shown.length > 2 && pen.measureText(shown).width > nameWidth) shown = `${shown.slice(0, -2)}…`;
      pen.fillText(shown, middles[joint] ?? 0, this.height - 10);
    });
    pen.textAlign = "left";
  }

  /** Draw a servo whose axle is the joint's: its case in front of the joint, its horn along the bend. */
  private axle({ joint, row }: Drive, heading: number, bends: number[], moment: Moment): void {
    const { pen } = this;
    const link = this.robot.joints[joint]?.links[0] ?? 0;
    const [x, y] = this.on(this.front(link), 0);
    const ahead = bends.slice(0, link).reduce((sum, bend) => sum + bend, heading);
    const radius = Math.min(AXLE_RADIUS, 0.28 * (this.shape.links[link] ?? 0) * this.scale);
    pen.save();
    pen.translate(x, y);
    pen.rotate(-ahead);
    pen.fillStyle = this.color("card");
    pen.strokeStyle = this.color("faint");
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.roundRect(-1.5 * radius, -0.8 * radius, 2.3 * radius, 1.6 * radius, 3);
    pen.fill();
    pen.stroke();
    pen.restore();
    const horn = (angle: number, color: string, width: number): void => {
      const way = ahead + angle;
      const end: [number, number] = [x + 1.9 * radius * Math.cos(way), y - 1.9 * radius * Math.sin(way)];
      this.trace([[x, y], end], this.color(color), width);
    };
    horn(moment.servoTarget[row] ?? 0, "grid", 7);
    horn(moment.servo[row] ?? 0, "ink", 2.5);
    pen.beginPath();
    pen.arc(x, y, 0.3 * radius, 0, 7);
    pen.fillStyle = this.color("ink");
    pen.fill();
  }

  /** Draw servo, cylinder, line and muscle of one side of a joint; `g` is the place of its servo in the head. */
  private circuit({ joint, row: c, side: way }: Drive, g: number, places: number, moment: Moment): void {
    const slot = (0.94 * this.front(1)) / places;
    const [begin, end] = [(g + 0.5) * slot, (g + 0.98) * slot];
    const radius = Math.min(20, 0.16 * slot * this.shape.length * this.scale);
    const across = 0.48 * way;
    this.servo(this.on((g + 0.27) * slot, across), radius, moment.servo[c] ?? 0, moment.servoTarget[c] ?? 0);
    this.cylinder(this.on(begin, across), this.on(end, across), radius, moment.servo[c] ?? 0, moment.pump[c] ?? 0);
    const lane = g === 0 ? 0.66 : 0.26; // lateral place of its oil line: inside the lines that end before it
    this.muscle(joint, way, [end, across], lane, moment.pump[c] ?? 0, moment.unit[c] ?? 0);
  }

  private servo([x, y]: [number, number], radius: number, angle: number, target: number): void {
    const { pen } = this;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 7);
    pen.fillStyle = this.color("card");
    pen.strokeStyle = this.color("faint");
    pen.lineWidth = 1.5;
    pen.fill();
    pen.stroke();
    const horn = (turn: number, color: string, width: number): void =>
      this.trace(
        [
          [x, y],
          [x + radius * Math.sin(turn), y - radius * Math.cos(turn)],
        ],
        color,
        width,
      );
    horn(target, this.color("grid"), 5);
    horn(angle, this.color("ink"), 2.5);
  }

  private cylinder(
    from: [number, number],
    to: [number, number],
    radius: number,
    angle: number,
    pressure: number,
  ): void {
    const { pen } = this;
    const high = 1.1 * radius;
    const [left, top, wide] = [from[0], from[1] - high / 2, to[0] - from[0]];
    const piston = left + wide * (0.45 + 0.4 * Math.sin(angle));
    pen.fillStyle = this.color("card");
    pen.fillRect(left, top, wide, high);
    pen.fillStyle = this.oil(pressure);
    pen.fillRect(piston, top, left + wide - piston, high);
    pen.fillStyle = this.color("ink");
    pen.fillRect(piston - 3, top, 5, high);
    pen.fillRect(left - 4, from[1] - 1, piston - left + 4, 2);
    pen.strokeStyle = this.color("faint");
    pen.lineWidth = 1.5;
    pen.strokeRect(left, top, wide, high);
  }

  /** Draw the oil line from a cylinder and the muscle that it fills. */
  private muscle(joint: number, way: number, from: [number, number], lane: number, pump: number, unit: number): void {
    const [begin, end] = this.span(joint);
    const along = (a: number, b: number, side: (t: number) => number): [number, number][] =>
      Array.from({ length: 9 }, (_, k) => this.on(a + (k / 8) * (b - a), side(k / 8)));
    const [part, across] = from;
    const out = 0.66 * way;
    const line = along(part, begin, (t) => across + (lane * way - across) * Math.min(1, 2 * t));
    this.trace(line, this.oil(pump), 3);
    const muscle = along(begin + 0.006, end - 0.006, () => out);
    this.trace(muscle, this.color("faint"), 12);
    this.trace(muscle, this.oil(unit), 9);
  }
}
