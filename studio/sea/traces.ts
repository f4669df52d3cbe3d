// Plots depth, speed, error of position and charge over time; a click sets the player to that time.
import { Chart } from "../chart.ts";
import { element } from "../dom.ts";
import type { Range } from "../robot.ts";
import type { Flight } from "./flight.ts";
import { speedOf } from "./words.ts";

interface Series {
  name: string;
  color: string;
  dashed?: boolean;
  value: (flight: Flight, k: number) => number;
}

interface Plot {
  title: string;
  label: string;
  series: Series[];
  range: (flight: Flight, values: Range) => Range;
}

const PLOTS: Plot[] = [
  {
    title: "Depth",
    label: "depth [m]",
    series: [
      { name: "true", color: "blue", value: (flight, k) => (flight.true ? flight.depth(k) : Number.NaN) },
      { name: "believed", color: "orange", dashed: true, value: (flight, k) => flight.value("depth_estimated", k) },
    ],
    range: (_, [, high]) => [Math.max(0.5, 1.15 * high), -0.05 * Math.max(0.5, high)],
  },
  {
    title: "Speed through the water",
    label: "speed [m/s]",
    series: [
      { name: "true", color: "blue", value: (flight, k) => (flight.true ? speedOf(flight, k) : Number.NaN) },
      { name: "believed", color: "orange", dashed: true, value: (flight, k) => flight.value("speed_estimated", k) },
    ],
    range: (_, [low, high]) => [Math.min(0, low), Math.max(0.1, 1.15 * high)],
  },
  {
    title: "Error of the believed place",
    label: "error [m]",
    series: [
      { name: "error", color: "blue", value: (flight, k) => flight.error(k) },
      {
        name: "2 standard deviations",
        color: "orange",
        dashed: true,
        value: (flight, k) => 2 * flight.value("position_error", k),
      },
    ],
    range: (_, [, high]) => [0, Math.max(1, 1.15 * high)],
  },
  {
    title: "Charge left",
    label: "charge [%]",
    series: [{ name: "charge", color: "green", value: (flight, k) => 100 * flight.value("charge_left", k) }],
    range: (_, [low, high]) => [Math.max(0, Math.floor(low - 1)), Math.min(100, Math.ceil(high + 0.5))],
  },
];

/** A plot, with a vertical line at the player's time. */
class Trace {
  readonly box = element("div", "sea-trace");
  private readonly chart: Chart;
  private readonly line = element("div", "sea-time");
  private drawn = "";

  constructor(
    private readonly plot: Plot,
    go: (time: number) => void,
  ) {
    const canvas = element("canvas", "chart");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${plot.title} over time`);
    const title = element("p", "sea-title", plot.title);
    for (const { name, color, dashed } of plot.series.length > 1 ? plot.series : []) {
      const key = element("span", dashed ? "sea-key dashed" : "sea-key", name);
      key.style.setProperty("--key", `var(--${color})`);
      title.append(key);
    }
    const frame = element("div", "sea-frame");
    frame.append(canvas, this.line);
    this.box.append(title, frame);
    this.chart = new Chart(canvas);
    const scrub = (event: PointerEvent): void => {
      if (event.buttons === 1) go(this.chart.value(event.offsetX, event.offsetY)[0]);
    };
    canvas.addEventListener("pointerdown", scrub);
    canvas.addEventListener("pointermove", scrub);
  }

  draw(flight: Flight, until: number): void {
    const { chart, plot } = this;
    const state = `${flight.head.title} ${flight.count} ${until} ${chart.canvas.clientWidth} ${chart.color("ink")}`;
    if (state === this.drawn || flight.count < 2) return;
    const rows = rowsOf(flight, Math.max(100, chart.canvas.clientWidth));
    const data = plot.series.map(({ value }) => rows.map((k) => value(flight, k)));
    const finite = data.flat().filter(Number.isFinite);
    const values = [
      finite.reduce((a, b) => Math.min(a, b), Infinity),
      finite.reduce((a, b) => Math.max(a, b), 0),
    ] as const;
    const x = { label: "time [s]", range: [flight.begin, until] as const };
    if (!chart.begin(x, { label: plot.label, range: plot.range(flight, values) })) return;
    this.drawn = state;
    chart.axes(true);
    plot.series.forEach(({ color, dashed }, s) => {
      const series = data[s] ?? [];
      if (!series.some(Number.isFinite)) return;
      const { pen } = chart;
      pen.strokeStyle = chart.color(color);
      pen.setLineDash(dashed ? [5, 3] : []);
      pen.lineWidth = 1.75;
      const known = rows.flatMap((k, i) => (Number.isFinite(series[i]) ? [[k, series[i] ?? 0] as const] : []));
      chart.stroke(known.map(([k, value]) => chart.place(flight.time(k), value)));
      pen.setLineDash([]);
    });
  }

  mark(time: number): void {
    const { chart, line } = this;
    const [x] = chart.place(time, 0);
    line.style.transform = `translateX(${x}px)`;
    line.style.top = `${chart.inside.y}px`;
    line.style.height = `${chart.inside.height}px`;
  }
}

/** Rows to draw: about two per pixel. */
function rowsOf(flight: Flight, pixels: number): number[] {
  const every = Math.max(1, Math.floor(flight.count / (2 * pixels)));
  const rows: number[] = [];
  for (let k = 0; k < flight.count; k += every) rows.push(k);
  return rows;
}

export class Traces {
  readonly element = element("div", "traces sea-traces");
  private readonly all: Trace[];

  constructor(go: (time: number) => void) {
    this.all = PLOTS.map((plot) => new Trace(plot, go));
    this.element.append(...this.all.map(({ box }) => box));
  }

  draw(flight: Flight, until: number): void {
    for (const trace of this.all) trace.draw(flight, until);
  }

  mark(time: number): void {
    for (const trace of this.all) trace.mark(time);
  }
}
