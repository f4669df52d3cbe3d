// Plots the twin's bends, and the pressures or torques that move its joints, over the last seconds.
import { element } from "./dom.ts";
import { drivesOf, ofKinds } from "./drives.ts";
import { DEGREE, type Robot } from "./robot.ts";
import { TimePlot, type Trace } from "./timeplot.ts";

const WINDOW = 4; // s: time that is shown; more at a high tempo
const MAX_WINDOW = 6; // s: longest time that is shown: more beats cannot be told apart and take long to draw
const CALM_TEMPO = 5; // tempo up to which the window stays at its shortest
const COLORS = ["blue", "orange", "green", "pink"]; // colors of the joints' traces

interface Column {
  trace: Trace;
  name: string; // name of the column in the twin's record
  part: number; // index within the column
  scale: number;
}

interface Kind {
  label: string;
  unit: string;
  columns: Column[];
  reach: readonly [number, number];
}

interface Shown {
  plot: TimePlot;
  columns: Column[];
  values: number[][];
}

export class TwinPlots {
  readonly element = element("div", "traces");
  private readonly times: number[] = [];
  private readonly shown: Shown[];

  constructor(robot: Robot) {
    this.shown = kindsOf(robot).map(({ label, unit, columns, reach }) => {
      const traces = columns.map(({ trace }) => trace);
      return { plot: new TimePlot(label, unit, traces, reach), columns, values: columns.map(() => []) };
    });
    this.element.append(...this.shown.map(({ plot }) => plot.element));
  }

  /** Add one row of the record; `at` gives the index of a column's first number. */
  add(time: number, row: Float64Array, at: (name: string) => number): void {
    this.times.push(time);
    for (const { columns, values } of this.shown)
      columns.forEach(({ name, part, scale }, k) => values[k]?.push((row[at(name) + part] ?? 0) * scale));
  }

  clear(): void {
    this.times.length = 0;
    for (const { values } of this.shown) for (const column of values) column.length = 0;
  }

  /** Draw the last seconds; at a higher tempo, more of them. */
  draw(tempo: number): void {
    const old = this.times.findIndex((time) => time >= (this.times.at(-1) ?? 0) - MAX_WINDOW);
    if (old > 0)
      for (const column of [this.times, ...this.shown.flatMap(({ values }) => values)]) column.splice(0, old);
    const window = Math.min(MAX_WINDOW, WINDOW * Math.max(1, tempo / CALM_TEMPO));
    for (const { plot, values } of this.shown) plot.set(this.times, values, window);
  }

  /** Draw again, in the colors of the page's theme. */
  refresh(): void {
    for (const { plot } of this.shown) plot.refresh();
  }
}

/** The plots of a robot: bends, and the numbers of its drives. */
function kindsOf(robot: Robot): Kind[] {
  const color = (joint: number): string => COLORS[joint % COLORS.length] ?? "ink";
  const drives = drivesOf(robot);
  const bends = robot.joints.flatMap(({ name }, k) => [
    { trace: { name: `joint ${name}`, color: color(k), dashed: false }, name: "angle", part: k, scale: 1 / DEGREE },
    { trace: { name: `${name} set`, color: color(k), dashed: true }, name: "angle_set", part: k, scale: 1 / DEGREE },
  ]);
  const moved = ofKinds(robot, ({ plots }) => plots).map((plot): Kind => {
    const columns = drives
      .filter(({ kind }) => kind.plots.includes(plot))
      .map(({ name, joint, row, side }) => {
        const trace = { name, color: color(joint), dashed: side < 0 };
        return { trace, name: plot.name, part: row, scale: plot.scale };
      });
    return { ...plot, columns };
  });
  return [{ label: "bend", unit: "deg", columns: bends, reach: [-5, 5] }, ...moved];
}
