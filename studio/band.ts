// How uncertainty is drawn in the plot of cost over speed: a band around a line of gaits, bars through single gaits.
import type { Chart } from "./chart.ts";
import { type Quantities, statusOf } from "./quantities.ts";
import type { Spread } from "./samples.ts";

/** Whether the gait settles, swims ahead, and has a finite cost of transport. */
export function usable(values: Quantities): boolean {
  const { speed = Number.NaN, cost_of_transport: cost = Number.NaN } = values;
  return statusOf(values) === "settled" && speed > 0 && Number.isFinite(cost);
}

/** Draw the band between the lower and the upper ends of the costs, along a line of gaits. */
export function drawBand(chart: Chart, spreads: Spread[], gaits: Quantities[]): void {
  const side = (end: 0 | 1): [number, number][] =>
    spreads.flatMap(({ intervals }, k) => {
      const [cost, speed] = [intervals.cost_of_transport?.[end] ?? Number.NaN, gaits[k]?.speed];
      return speed === undefined || !Number.isFinite(cost) ? [] : [chart.place(speed, cost)];
    });
  const { pen } = chart;
  pen.fillStyle = chart.color("green");
  pen.globalAlpha = 0.2;
  pen.beginPath();
  for (const point of [...side(0), ...side(1).reverse()]) pen.lineTo(...point);
  pen.fill();
  pen.globalAlpha = 1;
}

/** Draw bars through a gait's point: its interval of speed and its interval of cost. */
export function drawBars(chart: Chart, { intervals }: Spread, values: Quantities, color: string): void {
  if (!usable(values)) return;
  const { speed = 0, cost_of_transport: cost = 0 } = values;
  const [slow, fast] = intervals.speed ?? [speed, speed];
  const [cheap, dear] = intervals.cost_of_transport ?? [cost, cost];
  const { pen } = chart;
  pen.strokeStyle = chart.color(color);
  pen.globalAlpha = 0.8;
  pen.lineWidth = 1.5;
  chart.stroke([chart.place(slow, cost), chart.place(fast, cost)]);
  chart.stroke([chart.place(speed, cheap), chart.place(speed, dear)]);
  pen.globalAlpha = 1;
}
