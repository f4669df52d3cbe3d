// Plots traces over time with uPlot: the legend shows values under the pointer, a click on a name hides its trace.
import uPlot from "uplot";
import { colorOf, element } from "./dom.ts";
import { digits } from "./quantities.ts";

const HEIGHT = 230; // px, height without the legend

export interface Trace {
  name: string;
  color: string; // name of a color of the page's theme
  dashed: boolean;
}

export class TimePlot {
  readonly element = element("div", "timeplot");
  private plot: uPlot | null = null;
  private data: number[][] = [];
  private window = 4; // s, time that is shown

  constructor(
    private readonly label: string,
    private readonly unit: string,
    private readonly traces: Trace[],
    private readonly reach: readonly [number, number], // range that the axis shows at least
  ) {
    this.element.setAttribute("role", "img");
    this.element.setAttribute("aria-label", `${label} over time`);
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  /** Show values of the traces at these times [s]; the time axis covers the last `window` seconds. */
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

  /** The range of an axis with values from `low` to `high`: at least `reach`, with a margin. */
  private axisRange(low: number, high: number): [number, number] {
    const [least, most] = [Math.min(this.reach[0], low), Math.max(this.reach[1], high)];
    const margin = 0.08 * (most - least);
    return [least - margin, most + margin];
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
        y: { range: (_, low, high) => this.axisRange(low, high) },
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
