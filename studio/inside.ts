// The view of the live twin: the whole robot from command to wake, with the controller that it has on board.
import type { Column } from "./core.ts";
import { twinFollows } from "./changes.ts";
import { button, element, fact, labeled, selection } from "./dom.ts";
import { drivesOf, ofKinds } from "./drives.ts";
import { FaultKind } from "./interface.ts";
import { JointTable } from "./jointtable.ts";
import { Losses } from "./losses.ts";
import { Machine, type Moment } from "./machine.ts";
import { digits, type Quantities } from "./quantities.ts";
import type { Broken, Calculator } from "./questions.ts";
import type { Robot } from "./robot.ts";
import type { Another, View } from "./subject.ts";
import { TwinPlots } from "./twinplots.ts";

const HISTORY = 4; // s: rows of this last time are kept, which is more than a beat
const MAX_TICKS = 200; // most ticks that the worker is asked for at once
// Faults of a sensor, with their labels.
type Fault = Exclude<keyof typeof FaultKind, "none">;
const FAULTS: Record<Fault, string> = {
  stuck: "stuck",
  open: "open",
  spike: "spikes",
  nan: "NaN",
  drift: "drifts",
  shift: "shifted",
  clogged: "clogged",
};
const SLOW_FRACTION = 0.8; // below this fraction of the chosen tempo the page says that it is slow
const CONDITION_TIME = 0.5; // s for which a condition is still shown after it ended
const LOSS_INTERVAL = 8; // drawings from one update of the losses to the next
const TEMPOS = [0.1, 1, 5, 20, 50];

interface Parts {
  machine: Machine;
  table: JointTable;
  plots: TwinPlots;
  losses: Losses;
  facts: HTMLElement;
  guard: HTMLElement;
}

export class InsideView implements View {
  private readonly body = element("div");
  private readonly note = element("p", "intro");
  private calculator: Calculator | null = null;
  private robot: Robot | null = null;
  private started: Robot | null = null;
  private beat = Number.NaN; // speed of the settled beat of the knobs [m/s]
  private row: Float64Array = new Float64Array(); // gait of the knobs
  private columns: Column[] = [];
  private places = new Map<string, number>(); // index of each column's first number in a row
  private history: Float64Array[] = []; // rows of the record of the last seconds
  private ticks = 0;
  private due = 0; // ticks that are due but not yet asked for
  private before = 0;
  private asking = false;
  private stale = false; // whether rows have come that are not drawn yet
  private drawn = 0; // number of drawings
  private pace = Number.NaN; // measured speed of the twin's time relative to real time
  private noted = { at: 0, ticks: 0 }; // last time [ms] and tick at which the pace was measured
  private running = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  private armed = true;
  private speed = 1; // chosen tempo
  private kind: number = FaultKind.stuck; // kind of the next fault
  private broken: Broken[] = []; // faults to send with the next ticks
  private parts: Parts | null = null;

  /** `more` makes a worker with the robot loaded; the twin computes in its own worker. */
  constructor(
    private readonly panel: HTMLElement,
    private readonly more: Another,
  ) {
    panel.replaceChildren(this.note, this.body);
    requestAnimationFrame((now) => this.frame(now));
  }

  turnTo(robot: Robot): void {
    const described = robot.described ?? robot;
    this.robot = twinFollows(described, robot.factors ?? {}) ? robot : described;
    if (this.started !== this.robot) this.started = null;
  }

  at(row: Float64Array, values: Quantities): void {
    this.row = row;
    this.beat = values.speed ?? Number.NaN;
  }

  /** Draw again, in the colors of the page's theme. */
  refresh(): void {
    this.parts?.plots.refresh();
  }

  // --- running

  /** Start the twin of a robot when the view first shows it. */
  private async start(robot: Robot): Promise<void> {
    this.started = robot;
    this.asking = false;
    this.body.replaceChildren();
    this.parts = null;
    if (robot.twin === null) {
      const why = robot.no_twin ?? "its file has no controller";
      this.note.textContent = `${robot.robot} has no twin: ${why}. Its joints move as the gait asks.`;
      return;
    }
    this.note.textContent = `The whole robot from rest, live: the controller on board, ${machinery(robot)}, tail, and water by the robot's own law. The knobs command it; break a sensor and see what the controller does about it. A second click mends the sensor.`;
    this.calculator?.end();
    this.calculator = null;
    const calculator = await this.more(robot);
    if (this.started !== robot) {
      calculator.end();
      return;
    }
    this.calculator = calculator;
    await this.restart();
    if (this.started !== robot) return;
    this.layOut(robot);
    this.due = 1; // the first tick is shown even where nothing moves
    await this.advance(robot.twin.rate);
  }

  private async restart(): Promise<void> {
    const { robot, calculator } = this;
    if (robot === null || calculator === null) return;
    const { columns } = await calculator.ask({ kind: "twin", robot: robot.key });
    this.columns = columns;
    let place = 0;
    for (const { name, width } of columns) {
      this.places.set(name, place);
      place += width;
    }
    [this.history, this.ticks, this.due, this.broken] = [[], 0, 0, []];
    [this.pace, this.noted] = [Number.NaN, { at: performance.now(), ticks: 0 }];
    this.parts?.plots.clear();
    for (const chip of this.body.querySelectorAll(".chip")) chip.setAttribute("aria-pressed", "false");
  }

  private frame(now: number): void {
    requestAnimationFrame((later) => this.frame(later));
    const passed = Math.min(0.1, (now - this.before) / 1000);
    this.before = now;
    const { robot } = this;
    if (this.panel.hidden || !this.running) this.noted = { at: now, ticks: this.ticks };
    if (this.panel.hidden || robot === null) return;
    if (this.started !== robot) void this.start(robot);
    if (this.parts === null || robot.twin === null) return;
    const { rate } = robot.twin;
    if (this.stale) this.draw(rate);
    this.stale = false;
    if (!this.running) return;
    this.due = Math.min(MAX_TICKS, this.due + passed * this.speed * rate);
    this.measure(now, rate);
    if (!this.asking) void this.advance(rate);
  }

  /** Simulate the ticks that are due, and those that become due meanwhile. */
  private async advance(rate: number): Promise<void> {
    const { calculator, history } = this;
    const width = this.columns.reduce((sum, column) => sum + column.width, 0);
    const at = (name: string): number => this.places.get(name) ?? -1;
    this.asking = true;
    while (calculator !== null && this.due >= 1) {
      const ticks = Math.floor(this.due);
      this.due -= ticks;
      const broken = this.broken.splice(0);
      const { rows } = await calculator.ask({ kind: "tick", gait: this.row, armed: this.armed, broken, ticks });
      if (history !== this.history) break; // the twin was started again
      for (let k = 0; k < rows.length; k += width) {
        const row = rows.subarray(k, k + width);
        history.push(row);
        this.parts?.plots.add(++this.ticks / rate, row, at);
      }
      history.splice(0, Math.max(0, history.length - HISTORY * rate));
      this.stale = true;
      if (rows.length < ticks * width) this.fail();
    }
    this.asking = false;
  }

  /** Measure once a second how fast the twin's time runs. */
  private measure(now: number, rate: number): void {
    const { at, ticks } = this.noted;
    if (now - at < 1000) return;
    this.pace = ((this.ticks - ticks) / rate / (now - at)) * 1000;
    this.noted = { at: now, ticks: this.ticks };
  }

  private fail(): void {
    this.running = false;
    this.due = 0;
    this.note.textContent = "The twin left what a robot can do and was stopped: start it again with a smaller gait.";
  }

  // --- drawing

  /** The numbers of a column in a row of the record. */
  private of(row: Float64Array, name: string): number[] {
    const place = this.places.get(name);
    const width = this.columns.find((column) => column.name === name)?.width ?? 0;
    return place === undefined ? [] : Array.from(row.subarray(place, place + width));
  }

  private draw(rate: number): void {
    const { parts } = this;
    const last = this.history.at(-1);
    if (parts === null || last === undefined) return;
    const get = (name: string): number[] => this.of(last, name);
    const moment: Moment = {
      angle: get("angle"),
      angleSet: get("angle_set"),
      servo: get("servo_angle"),
      servoTarget: get("servo_target"),
      pump: get("pump_pressure"),
      unit: get("unit_pressure"),
      torque: get("servo_torque"),
    };
    parts.machine.draw(moment);
    parts.table.show(moment);
    if (this.drawn++ % 2 === 0 || !this.running) parts.plots.draw(this.speed); // every second drawing
    this.tell(parts, rate);
  }

  /** Show how the robot swims, and what the controller does about faults and limits. */
  private tell({ facts, guard, losses }: Parts, rate: number): void {
    const beat = Math.max(1, Math.round(rate / (this.row[0] ?? 1)));
    const rows = this.history.slice(-beat);
    const mean = (name: string): number =>
      rows.reduce((sum, row) => sum + this.of(row, name).reduce((a, b) => a + b, 0), 0) / Math.max(1, rows.length);
    if (this.drawn % LOSS_INTERVAL === 1 || !this.running)
      losses.show(mean, mean("battery_voltage") * mean("battery_current"));
    const slow = this.pace < SLOW_FRACTION * this.speed ? `, at ${digits(this.pace, 2)} x: no faster here` : "";
    const values = [
      [`${digits(this.ticks / rate, 3)} s`, `time from rest${slow}`],
      [`${digits(-mean("surge"), 3)} m/s`, "speed, mean of a beat"],
      [`${digits(this.beat, 3)} m/s`, "speed of the settled beat above"],
      [`${digits(mean("power"), 3)} W`, "electrical power"],
      [`${digits(mean("battery_voltage"), 4)} V`, "battery voltage"],
    ];
    facts.replaceChildren(...values.map(([value = "", label = ""]) => fact(value, label)));
    const sentences = this.conditions(rate);
    const text = sentences.length
      ? sentences.join("\n")
      : "The controller reports nothing: no limit acts, no sensor has failed.";
    if (guard.textContent === text) return;
    guard.textContent = text;
    guard.dataset.quiet = String(sentences.length === 0);
  }

  /** Sentences on the controller's conditions of the last moments, with the places where they held. */
  private conditions(rate: number): string[] {
    const { robot } = this;
    if (robot === null || robot.twin === null) return [];
    const { conditions } = robot.twin;
    const recent = this.history.slice(-Math.ceil(CONDITION_TIME * rate));
    const where = conditions.map((_, k) => recent.reduce((bits, row) => bits | (this.of(row, "status_at")[k] ?? 0), 0));
    return conditions.flatMap(({ place, text }, k) => {
      const bits = where[k] ?? 0;
      if (bits === 0) return [];
      const names = new Set(placesOf(robot, place).filter((_, i) => (bits >> i) & 1));
      return [`${names.size > 0 ? `${place} ${[...names].join(", ")}: ` : ""}${text}.`];
    });
  }

  // --- layout

  private layOut(robot: Robot): void {
    const canvas = element("canvas", "machine");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `In the robot: ${machinery(robot)}`);
    const facts = element("dl", "facts");
    const guard = element("p", "guard");
    guard.setAttribute("role", "status");
    const [table, plots, losses] = [new JointTable(robot), new TwinPlots(robot), new Losses(robot)];
    const [colors, dashed] = [ofKinds(robot, ({ colors }) => [colors]), ofKinds(robot, ({ dashed }) => [dashed])];
    const text = `Widths of the body are drawn larger.${colors.join("")} Dashed traces: of bends, what the controller asks for${dashed.join("")}.`;
    const caption = element("p", "caption", text);
    const { element: bends } = table;
    this.body.replaceChildren(
      this.controls(),
      canvas,
      bends,
      caption,
      facts,
      losses.element,
      this.sensors(robot),
      guard,
      plots.element,
    );
    this.parts = { machine: new Machine(canvas, robot), table, plots, losses, facts, guard };
  }

  private controls(): HTMLElement {
    const row = element("div", "row left");
    const run = button(this.running ? "Pause" : "Go on", () => {
      this.running = !this.running;
      run.textContent = this.running ? "Pause" : "Go on";
    });
    const again = button("Start again", () => {
      this.running = true;
      run.textContent = "Pause";
      void this.restart();
    });
    const tempos = TEMPOS.map((times): [string, number] => [`${times} x`, times]);
    const speed = selection(tempos, this.speed, (times) => {
      [this.speed, this.pace] = [Number(times), Number.NaN];
    });
    const armed = element("label", "check");
    const box = element("input");
    Object.assign(box, { type: "checkbox", checked: true });
    box.addEventListener("change", () => {
      this.armed = box.checked;
    });
    armed.append(box, " armed");
    row.append(run, again, labeled("tempo ", speed), armed);
    return row;
  }

  /** A button for each sensor: a click breaks the sensor, another mends it. */
  private sensors(robot: Robot): HTMLElement {
    const channels = Object.entries(robot.twin?.channels ?? {});
    const single = channels.filter(([name]) => !channels.some(([other]) => other.startsWith(`${name}-`)));
    const box = element("div", "row left");
    const faults = Object.entries(FAULTS).map(([name, label]): [string, number] => [label, FaultKind[name as Fault]]);
    const kind = selection(faults, this.kind, (value) => {
      this.kind = Number(value);
    });
    box.append(labeled("break a sensor: ", kind));
    for (const [name, [first, last]] of single) {
      const chip = button(name.replaceAll("-", " "), () => {
        const breaks = chip.getAttribute("aria-pressed") !== "true";
        chip.setAttribute("aria-pressed", String(breaks));
        this.broken.push({ kind: breaks ? this.kind : FaultKind.none, first, last });
      });
      chip.className = "chip";
      chip.setAttribute("aria-pressed", "false");
      box.append(chip);
    }
    return box;
  }
}

/** What moves a robot's joints, in words of the page. */
const machinery = (robot: Robot): string => ofKinds(robot, ({ words }) => [words]).join(", ");

/** Names of the places that the bits of a condition stand for, lowest bit first. */
function placesOf(robot: Robot, place: string): string[] {
  const joints = robot.joints.map(({ name }) => name);
  if (place === "joint") return joints;
  if (place === "robot") return [];
  const rows = joints.flatMap((name) => [name, name]);
  for (const { name, row } of drivesOf(robot)) rows[row] = name;
  return [...rows, "fin 1", "fin 2"];
}
