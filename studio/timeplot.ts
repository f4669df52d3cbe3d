// Traces over time, by uPlot: values under the pointer in the legend, a series hidden by a click on its name.
import uPlot from "uplot";
import { colorOf, element } from "./dom.ts";
import { digits } from "./quantities.ts";

const HEIGHT = 230; // px, without the legend

export interface Trace {
  name: string;
  color: string; // name of one of the page's colors
  dashed: boolean;
}

export class TimePlot {
  readonly element = element("div", "timeplot");
  private plot: uPlot | null = null;
  private data: number[][] = [];
  private window = 4; // s

  constructor(
    private readonly label: string,
    private readonly unit: string,
    private readonly traces: Trace[],
    private readonly reach: readonly [number, number], // that the axis has at least
  ) {
    this.element.setAttribute("role", "img");
    this.element.setAttribute("aria-label", `${label} over time`);
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  /** Show values of the traces at times, over a window that ends with the last time. */
  set(times: number[], values: number[][], window: number): void {
    this.data = [times, ...values];
    this.window = window;
    this.plot?.setData(this.data as uPlot.AlignedData);
  }

  /** Draw again, in the colors of the page's theme. */
  refresh(): void {
    this.plot?.destroy();
    this.plot = null;
    this.resize();
  }

  /** What an axis covers that has values from low to high, with some room. */
  private room(low: number, high: number): [number, number] {
    const [least, most] = [Math.min(this.reach[0], low), Math.max(this.reach[1], high)];
    const room = 0.08 * (most - least);
    return [least - room, most + room];
  }

  private resize(): void {
    const { clientWidth: width } = this.element;
    if (width === 0) return;
    if (this.plot === null) this.plot = this.made(width);
    else if (width !== this.plot.width) this.plot.setSize({ width, height: HEIGHT });
  }

  private made(width: number): uPlot {
    const color = (name: string): string => colorOf(this.element, name);
    const font = `12px ${getComputedStyle(this.element).fontFamily}`;
    const ink = { stroke: color("faint"), font, labelFont: font, ticks: { show: false } };
    const grid = { stroke: color("grid"), width: 1 };
    const value = (_: uPlot, at: number | null): string => (at === null ? "–" : `${digits(at, 3)} ${this.unit}`);
    const series = this.traces.map(({ name, color: named, dashed }) => ({
      ...{ label: name, stroke: color(named), width: dashed ? 1 : 1.75, points: { show: false }, value },
      ...(dashed ? { dash: [4, 3] } : {}),
    }));
    const dash = (_: uPlot, k: number): string => (this.traces[k - 1]?.dashed ? "dashed" : "solid");
    const options: uPlot.Options = {
      ...{ width, height: HEIGHT, pxAlign: false, legend: { markers: { width: 2, dash } } },
      cursor: { drag: { x: false, y: false }, y: false },
      scales: {
        x: { time: false, range: (_, __, last) => [Math.max(0, last - this.window), Math.max(this.window, last)] },
        y: { range: (_, low, high) => this.room(low, high) },
      },
      axes: [
        { ...ink, grid, label: "time [s]", labelSize: 18, size: 26, gap: 2 },
        { ...ink, grid, label: `${this.label} [${this.unit}]`, labelSize: 18, size: 44, gap: 4 },
      ],
      series: [{ label: "time", value: (_, at) => (at === null ? "–" : `${at.toFixed(2)} s`) }, ...series],
    };
    return new uPlot(options, this.data as uPlot.AlignedData, this.element);
  }
}
