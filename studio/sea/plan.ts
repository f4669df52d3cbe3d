// Draws the flight from above, for browsers without WebGL.
import { Chart } from "../chart.ts";
import { element } from "../dom.ts";
import { type By, colorOf, rangeOf } from "./colors.ts";
import { cornersOf, extentOf } from "./geometry.ts";
import type { Flight, Place } from "./flight.ts";
import { type Box, place, rankOf } from "./labels.ts";

const MAX_POINTS = 2000; // largest number of points of the drawn track
const TEXT_HEIGHT = 14; // px, height of a line of text

export class Plan {
  readonly element = element("div", "sea-space");
  readonly canvas = element("canvas", "sea-canvas");
  private readonly chart: Chart;
  private flight: Flight | null = null;
  private by: By = "mode";
  private time = 0;
  private stale = true;
  private labels: { text: string; kind: string; point: [number, number]; color: string }[] = [];

  constructor() {
    this.canvas.setAttribute("role", "img");
    this.element.append(this.canvas);
    this.chart = new Chart(this.canvas);
    new ResizeObserver(() => this.refresh()).observe(this.element);
  }

  set(flight: Flight, _: unknown): void {
    this.flight = flight;
    this.refresh();
  }

  refresh(): void {
    this.stale = true;
  }

  grow(): void {
    this.refresh();
  }

  color(by: By): void {
    this.by = by;
    this.refresh();
  }

  show(time: number): void {
    this.time = time;
    this.refresh();
  }

  draw(): void {
    const { flight, chart } = this;
    if (!this.stale || flight === null || flight.count === 0 || this.element.clientWidth === 0) return;
    this.stale = false;
    if (!this.begin(flight)) return;
    chart.axes(true);
    this.labels = [];
    this.course(flight);
    this.track(flight);
    this.robot(flight);
    this.write();
  }

  /** Write the labels so that none covers another. */
  private write(): void {
    const { pen, inside } = this.chart;
    const bounds = { left: inside.x, top: inside.y, wide: inside.width, high: inside.height };
    const taken: Box[] = [];
    pen.textAlign = "left";
    for (const { text, kind, point, color } of this.labels.sort((a, b) => rankOf(a.kind) - rankOf(b.kind))) {
      const found = place(kind, point, [pen.measureText(text).width, TEXT_HEIGHT], taken, bounds);
      pen.fillStyle = this.chart.color(color);
      if (found !== null) pen.fillText(text, found.box.left, found.box.top + TEXT_HEIGHT - 3);
    }
  }

  /** Set axes with equal scales around everything that is to be seen. */
  private begin(flight: Flight): boolean {
    const { chart } = this;
    const { low, high } = extentOf(flight);
    const [wide, tall] = [this.element.clientWidth - 72, this.element.clientHeight - 56];
    const scale = Math.max((high[0] - low[0]) / wide, (high[1] - low[1]) / tall);
    const around = (k: 0 | 1, size: number): [number, number] => {
      const middle = (low[k] + high[k]) / 2;
      return [middle - (scale * size) / 2, middle + (scale * size) / 2];
    };
    return chart.begin({ label: "east [m]", range: around(0, wide) }, { label: "north [m]", range: around(1, tall) });
  }

  private line(places: Iterable<readonly number[]>): void {
    this.chart.stroke([...places].map(([x = 0, y = 0]) => this.chart.place(x, y)));
  }

  private ring([x, y]: Place, radius: number, text: string, kind: string, color: string): void {
    const { pen } = this.chart;
    const [left, top] = this.chart.place(x, y);
    pen.strokeStyle = this.chart.color(color);
    const [edge] = this.chart.place(x + radius, y);
    pen.beginPath();
    pen.arc(left, top, Math.max(2, edge - left), 0, 7);
    pen.stroke();
    this.labels.push({ text, kind, point: [left, top], color });
  }

  private course(flight: Flight): void {
    const { chart } = this;
    const { pen } = chart;
    const { mission } = flight.head;
    const [corner] = mission.fence;
    pen.lineWidth = 1.5;
    pen.strokeStyle = chart.color("sea-fence");
    if (corner !== undefined) this.line([...mission.fence, corner]);
    pen.strokeStyle = chart.color("sea-leg");
    pen.setLineDash([6, 4]);
    this.line(cornersOf(mission));
    pen.setLineDash([]);
    mission.waypoints.forEach(([x, y, , , radius], k) => this.ring([x, y], radius, String(k + 1), "number", "sea-leg"));
    this.ring(mission.home, mission.home_radius, "home", "home", "sea-home");
  }

  private track(flight: Flight): void {
    const { chart, by } = this;
    const { pen } = chart;
    const last = flight.at(this.time);
    const every = Math.max(1, Math.ceil(flight.count / MAX_POINTS));
    const range = rangeOf(flight, by);
    const rows = Array.from({ length: Math.ceil(flight.count / every) }, (_, k) => k * every);
    pen.lineWidth = 1;
    pen.strokeStyle = chart.color("grid");
    this.line(rows.map((k) => flight.position(k)));
    pen.lineWidth = 2.5;
    const parse = (name: string): readonly number[] => {
      pen.fillStyle = chart.color(name);
      const hex = String(pen.fillStyle);
      return [1, 3, 5].map((i) => Number.parseInt(hex.slice(i, i + 2), 16) / 255);
    };
    let [color, from] = ["", 0];
    const flown = rows.filter((k) => k <= last);
    flown.forEach((k, i) => {
      const [r = 0, g = 0, b = 0] = colorOf(flight, by, k, range, parse);
      const own = `rgb(${[r, g, b].map((channel) => Math.round(255 * channel)).join(",")})`;
      if ((own === color || i === 0) && i < flown.length - 1) {
        color = own;
        return;
      }
      pen.strokeStyle = color === "" ? own : color;
      this.line(flown.slice(from, i + 1).map((row) => flight.position(row)));
      [color, from] = [own, i];
    });
  }

  private robot(flight: Flight): void {
    const { chart } = this;
    const { pen } = chart;
    const k = flight.at(this.time);
    const [x, y] = flight.position(k);
    const [east, north] = flight.believed(k);
    if (flight.true && Number.isFinite(east)) {
      this.ring([east, north], 2 * flight.value("position_error", k), "believed", "believed", "sea-believed");
    }
    const [left, top] = chart.place(x, y);
    const [qx, qy, qz, qw] = flight.attitude(k);
    const heading = Math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)) + Math.PI; // heading of the head
    pen.save();
    pen.translate(left, top);
    pen.rotate(-heading);
    pen.fillStyle = chart.color("sea-robot");
    pen.beginPath();
    for (const [ahead, side] of [
      [11, 0],
      [-7, 6],
      [-7, -6],
    ] as const)
      pen.lineTo(ahead, side);
    pen.fill();
    pen.restore();
  }
}
