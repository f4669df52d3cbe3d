// The twin live: the whole robot from command to wake, with the controller that the robot flies.
import { Chart } from "./chart.ts";
import type { Column } from "./core.ts";
import { element } from "./dom.ts";
import { Machine, type Moment } from "./machine.ts";
import { digits } from "./quantities.ts";
import type { Broken, Calculator } from "./questions.ts";
import { DEGREE, type Robot } from "./robot.ts";

const WINDOW = 4; // s of the traces
const MOST = 120; // ticks in one question
const WAYS = ["stuck", "open", "spikes", "not a number"]; // of a sensor to fail, in the core's order
const HELD = 0.5; // s for which a condition is still shown
const COLORS = ["blue", "orange", "green", "sky"];
const SIDES = ["left", "right"];

export class InsideView {
  private readonly body = element("div");
  private readonly note = element("p", "intro");
  private calculator: Calculator | null = null;
  private robot: Robot | null = null;
  private started: Robot | null = null;
  private row: Float64Array = new Float64Array();
  private columns: Column[] = [];
  private places = new Map<string, number>();
  private history: Float64Array[] = []; // rows of the last seconds
  private ticks = 0;
  private owed = 0; // ticks that are due
  private before = 0;
  private asking = false;
  private running = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  private armed = true;
  private speed = 1;
  private way = 0;
  private broken: Broken[] = [];
  private parts: { machine: Machine; bends: Chart; pressures: Chart; facts: HTMLElement; guard: HTMLElement } | null =
    null;

  /** `more` makes a worker with the robot loaded: the twin has one of its own. */
  constructor(
    private readonly room: HTMLElement,
    private readonly more: (robot: Robot) => Promise<Calculator>,
  ) {
    room.replaceChildren(this.note, this.body);
    requestAnimationFrame((now) => this.frame(now));
  }

  about(robot: Robot): void {
    this.robot = robot;
    if (this.started !== robot) this.started = null;
  }

  at(row: Float64Array): void {
    this.row = row;
  }

  // --- running

  /** Start the twin where the view is shown for the first time. */
  private async start(robot: Robot): Promise<void> {
    this.started = robot;
    this.asking = false;
    this.body.replaceChildren();
    this.parts = null;
    if (robot.twin === null) {
      this.note.textContent = `The file of ${robot.robot} has no controller, so that it has no twin: its joints move as the gait asks.`;
      return;
    }
    this.note.textContent =
      "The whole robot from rest, live: the controller on board, servos, cylinders, oil, muscles, tail, and water by the robot's own law. The knobs command it; break a sensor and see what the controller does about it.";
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
    this.owed = 1; // the first tick is shown even where nothing moves
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
    [this.history, this.ticks, this.owed, this.broken] = [[], 0, 0, []];
    for (const chip of this.body.querySelectorAll(".chip")) chip.setAttribute("aria-pressed", "false");
  }

  private frame(now: number): void {
    requestAnimationFrame((later) => this.frame(later));
    const passed = Math.min(0.1, (now - this.before) / 1000);
    this.before = now;
    const { robot } = this;
    if (this.room.hidden || robot === null) return;
    if (this.started !== robot) void this.start(robot);
    if (this.parts === null || robot.twin === null || !this.running) return;
    this.owed = Math.min(MOST, this.owed + passed * this.speed * robot.twin.rate);
    if (!this.asking && this.owed >= 1) void this.advance(robot.twin.rate);
  }

  private async advance(rate: number): Promise<void> {
    const { calculator } = this;
    if (calculator === null) return;
    this.asking = true;
    const { history } = this;
    const ticks = Math.floor(this.owed);
    this.owed -= ticks;
    const broken = this.broken.splice(0);
    const { rows } = await calculator.ask({ kind: "tick", gait: this.row, armed: this.armed, broken, ticks });
    this.asking = false;
    if (history !== this.history) return; // it was started again
    const width = this.columns.reduce((sum, column) => sum + column.width, 0);
    for (let k = 0; k < rows.length; k += width) this.history.push(rows.subarray(k, k + width));
    this.ticks += rows.length / width;
    this.history.splice(0, Math.max(0, this.history.length - WINDOW * rate));
    if (rows.length < ticks * width) this.fail();
    this.draw(rate);
  }

  private fail(): void {
    this.running = false;
    this.note.textContent = "The twin left what a robot can do and was stopped: start it again with a smaller gait.";
  }

  // --- what a tick saw

  /** Numbers of a column in a row. */
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
    };
    parts.machine.draw(moment);
    const names = this.robot?.joints.map(({ name }) => name) ?? [];
    this.trace(
      parts.bends,
      "bend [deg]",
      [
        ["angle_set", true],
        ["angle", false],
      ],
      1 / DEGREE,
      names,
      rate,
    );
    const circuits = names.flatMap((name) => SIDES.map((side) => `${name} ${side}`));
    this.trace(parts.pressures, "pressure [kPa]", [["unit_pressure", false]], 1e-3, circuits, rate);
    this.tell(parts, rate);
  }

  /** Traces of columns over the last seconds: dashed what was asked for. */
  private trace(
    chart: Chart,
    label: string,
    series: [string, boolean][],
    scale: number,
    names: string[],
    rate: number,
  ): void {
    const data = series.map(([name]) => this.history.map((row) => this.of(row, name).map((value) => value * scale)));
    const values = data.flat(2);
    const [low, high] = [Math.min(0, ...values), Math.max(1, ...values)];
    const now = this.ticks / rate;
    const room = 0.12 * (high - low);
    const y = { label, range: [low - room, high + room] as const };
    if (!chart.begin({ label: "time [s]", range: [Math.max(0, now - WINDOW), Math.max(WINDOW, now)] }, y)) return;
    chart.axes(true);
    series.forEach(([, dashed], s) => {
      chart.pen.setLineDash(dashed ? [4, 3] : []);
      chart.pen.lineWidth = dashed ? 1 : 1.75;
      names.forEach((_, g) => {
        chart.pen.strokeStyle = chart.color(COLORS[g % COLORS.length] ?? "ink");
        const first = this.ticks - this.history.length + 1;
        chart.stroke((data[s] ?? []).map((row, k) => chart.place((first + k) / rate, row[g] ?? 0)));
      });
    });
    chart.pen.setLineDash([]);
    names.forEach((name, g) => {
      chart.pen.fillStyle = chart.color(COLORS[g % COLORS.length] ?? "ink");
      chart.pen.fillText(name, chart.inside.x + 8 + 64 * g, chart.inside.y + 12);
    });
  }

  /** Say how it swims, and what the controller does about faults and limits. */
  private tell({ facts, guard }: { facts: HTMLElement; guard: HTMLElement }, rate: number): void {
    const beat = Math.max(1, Math.round(rate / (this.row[0] ?? 1)));
    const rows = this.history.slice(-beat);
    const mean = (name: string): number =>
      rows.reduce((sum, row) => sum + this.of(row, name).reduce((a, b) => a + b, 0), 0) / Math.max(1, rows.length);
    const values = [
      [`${digits(this.ticks / rate, 3)} s`, "time from rest"],
      [`${digits(-mean("surge"), 3)} m/s`, "speed, mean of a beat"],
      [`${digits(mean("power"), 3)} W`, "electrical power"],
      [`${digits(mean("battery_voltage"), 4)} V`, "battery voltage"],
    ];
    facts.replaceChildren(
      ...values.map(([value = "", label = ""]) => {
        const box = element("div");
        box.append(element("dt", "", value), element("dd", "", label));
        return box;
      }),
    );
    const sentences = this.conditions(rate);
    const text = sentences.length
      ? sentences.join("\n")
      : "The controller reports nothing: no limit acts, no sensor has failed.";
    if (guard.textContent === text) return;
    guard.textContent = text;
    guard.dataset.quiet = String(sentences.length === 0);
  }

  /** Conditions that held within the last moments, with where. */
  private conditions(rate: number): string[] {
    const { robot } = this;
    if (robot === null || robot.twin === null) return [];
    const recent = this.history.slice(-Math.ceil(HELD * rate));
    const where = robot.twin.conditions.map((_, k) =>
      recent.reduce((bits, row) => {
        const held = ((this.of(row, "status")[0] ?? 0) >> k) & 1;
        return held ? bits | (1 << 30) | (this.of(row, "status_at")[k] ?? 0) : bits;
      }, 0),
    );
    return robot.twin.conditions.flatMap(({ place, text }, k) => {
      const bits = where[k] ?? 0;
      if (bits === 0) return [];
      const names = this.named(robot, place).filter((_, i) => (bits >> i) & 1);
      return [`${names.length ? `${place} ${names.join(", ")}: ` : ""}${text}.`];
    });
  }

  private named(robot: Robot, place: string): string[] {
    const joints = robot.joints.map(({ name }) => name);
    if (place === "joint") return joints;
    return place === "robot" ? [] : joints.flatMap((name) => SIDES.map((side) => `${name} ${side}`));
  }

  // --- layout

  private layOut(robot: Robot): void {
    const canvas = element("canvas", "machine");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "Servos, cylinders, oil lines and muscles of the robot");
    const facts = element("dl", "facts");
    const guard = element("p", "guard");
    guard.setAttribute("role", "status");
    const traces = element("div", "traces");
    const [bends, pressures] = [element("canvas", "chart"), element("canvas", "chart")];
    traces.append(bends, pressures);
    const caption = element(
      "p",
      "caption",
      "Widths of the body are drawn larger. Orange: oil under pressure; blue: suction. Traces: dashed what the controller asks for.",
    );
    this.body.replaceChildren(this.controls(), canvas, caption, facts, this.sensors(robot), guard, traces);
    this.parts = {
      machine: new Machine(canvas, robot),
      bends: new Chart(bends),
      pressures: new Chart(pressures),
      facts,
      guard,
    };
  }

  private controls(): HTMLElement {
    const row = element("div", "row left");
    const run = element("button", "", this.running ? "Pause" : "Go on");
    run.addEventListener("click", () => {
      this.running = !this.running;
      run.textContent = this.running ? "Pause" : "Go on";
    });
    const again = element("button", "", "Start again");
    again.addEventListener("click", () => {
      this.running = true;
      run.textContent = "Pause";
      void this.restart();
    });
    const speed = element("select");
    for (const times of [0.1, 1, 5, 20]) speed.append(new Option(`${times} x`, String(times)));
    speed.value = String(this.speed);
    speed.addEventListener("change", () => {
      this.speed = Number(speed.value);
    });
    const tempo = element("label", "choice", "tempo ");
    tempo.append(speed);
    const armed = element("label", "check");
    const box = element("input");
    Object.assign(box, { type: "checkbox", checked: true });
    box.addEventListener("change", () => {
      this.armed = box.checked;
    });
    armed.append(box, " armed");
    row.append(run, again, tempo, armed);
    for (const button of [run, again]) button.type = "button";
    return row;
  }

  /** Sensors that break by a click, and mend by another. */
  private sensors(robot: Robot): HTMLElement {
    const channels = Object.entries(robot.twin?.channels ?? {});
    const single = channels.filter(([name]) => !channels.some(([other]) => other.startsWith(`${name}-`)));
    const box = element("div", "row left");
    const way = element("select");
    WAYS.forEach((name, k) => {
      way.append(new Option(name, String(k + 1)));
    });
    way.value = String(this.way + 1);
    way.addEventListener("change", () => {
      this.way = Number(way.value) - 1;
    });
    const label = element("label", "choice", "break a sensor: ");
    label.append(way);
    box.append(label);
    for (const [name, [first, last]] of single) {
      const chip = element("button", "chip", name.replaceAll("-", " "));
      chip.type = "button";
      chip.setAttribute("aria-pressed", "false");
      chip.addEventListener("click", () => {
        const breaks = chip.getAttribute("aria-pressed") !== "true";
        chip.setAttribute("aria-pressed", String(breaks));
        this.broken.push({ way: breaks ? this.way + 1 : 0, first, last });
      });
      box.append(chip);
    }
    return box;
  }
}
