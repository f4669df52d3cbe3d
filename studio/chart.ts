// A plot on a canvas: a frame with axes, in the page's colors.
import { colorOf } from "./dom.ts";
import { digits } from "./quantities.ts";
import type { Range } from "./robot.ts";
import { drawing } from "./svg.ts";

/** Colors of rising lightness, distinct in gray and to every kind of color vision, as in hypertuna's figures. */
const SEQUENCE = ["#4059A8", "#1F80BF", "#22A39B", "#7FB24A", "#E3A63C"];

export interface Axis {
  label: string;
  range: Range;
}

/** Red, green and blue (0 to 255) of the color at a fraction of the sequence, 0 to 1. */
export function colorAt(part: number): [number, number, number] {
  const place = Math.min(1, Math.max(0, part)) * (SEQUENCE.length - 1);
  const k = Math.min(SEQUENCE.length - 2, Math.floor(place));
  const channel = (color: string, i: number): number => Number.parseInt(color.slice(1 + 2 * i, 3 + 2 * i), 16);
  const mix = (i: number): number => {
    const [a, b] = [channel(SEQUENCE[k] ?? "#000000", i), channel(SEQUENCE[k + 1] ?? "#000000", i)];
    return Math.round(a + (place - k) * (b - a));
  };
  return [mix(0), mix(1), mix(2)];
}

/** The next larger number of the form 1, 2 or 5 times a power of ten. */
export function roundUp(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return ([1, 2, 5, 10].find((size) => size * power >= value) ?? 10) * power;
}

/** Round numbers within a range, about `count` of them. */
export function ticks(range: Range, count = 5): number[] {
  const [low, high] = [Math.min(...range), Math.max(...range)]; // an axis may point down
  const raw = (high - low) / count;
  if (!(raw > 0) || !Number.isFinite(raw)) return [];
  const step = roundUp(raw);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, k) =>
    Number(((first + k) * step).toPrecision(12)),
  );
}

/** A canvas with the frame of a plot; lengths are in CSS pixels. */
export class Chart {
  pen: CanvasRenderingContext2D;
  width = 0;
  height = 0;
  left = 56;
  right = 16;
  private x: Axis = { label: "", range: [0, 1] };
  private y: Axis = { label: "", range: [0, 1] };
  readonly top = 12;
  readonly bottom = 44;

  constructor(readonly canvas: HTMLCanvasElement) {
    const pen = canvas.getContext("2d");
    if (pen === null) throw new Error("this browser draws no canvas");
    this.pen = pen;
  }

  /** The drawing that `draw` makes on this canvas, as SVG text. */
  svg(title: string, draw: () => void): string {
    const { canvas, pen } = this;
    const text = drawing(canvas.width, canvas.height, title, (svg) => {
      this.pen = svg;
      svg.fillStyle = this.color("paper");
      svg.fillRect(0, 0, canvas.width, canvas.height);
      draw();
      this.pen = pen;
    });
    draw(); // the canvas was cleared
    return text;
  }

  color(name: string): string {
    return colorOf(this.canvas, name);
  }

  /** Clear the canvas and set its axes; false where the canvas is not shown. */
  begin(x: Axis, y: Axis): boolean {
    const { canvas, pen } = this;
    [this.width, this.height] = [canvas.clientWidth, canvas.clientHeight];
    if (this.width === 0) return false;
    const ratio = Math.min(2, devicePixelRatio);
    [canvas.width, canvas.height] = [Math.round(this.width * ratio), Math.round(this.height * ratio)];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.font = `12px ${getComputedStyle(canvas).fontFamily}`;
    [this.x, this.y] = [x, y];
    return true;
  }

  get inside(): { x: number; y: number; width: number; height: number } {
    const { left, top } = this;
    return { x: left, y: top, width: this.width - left - this.right, height: this.height - top - this.bottom };
  }

  place(x: number, y: number): [number, number] {
    const box = this.inside;
    const part = (value: number, [low, high]: Range): number => (value - low) / (high - low);
    return [box.x + part(x, this.x.range) * box.width, box.y + (1 - part(y, this.y.range)) * box.height];
  }

  /** Values (x, y) at a place on the canvas [px], limited to the axes. */
  value(left: number, top: number): [number, number] {
    const box = this.inside;
    const inside = (part: number, [low, high]: Range): number => low + Math.min(1, Math.max(0, part)) * (high - low);
    return [inside((left - box.x) / box.width, this.x.range), inside(1 - (top - box.y) / box.height, this.y.range)];
  }

  axes(grid: boolean): void {
    const { pen } = this;
    const box = this.inside;
    pen.lineWidth = 1;
    pen.strokeStyle = this.color("grid");
    pen.fillStyle = this.color("faint");
    pen.textAlign = "center";
    for (const tick of ticks(this.x.range, Math.max(3, box.width / 90))) {
      const [x] = this.place(tick, 0);
      pen.fillText(digits(tick), x, box.y + box.height + 16);
      if (grid)
        this.stroke([
          [x, box.y],
          [x, box.y + box.height],
        ]);
    }
    pen.textAlign = "right";
    for (const tick of ticks(this.y.range, Math.max(3, box.height / 56))) {
      const [, y] = this.place(0, tick);
      pen.fillText(digits(tick), box.x - 6, y + 4);
      if (grid)
        this.stroke([
          [box.x, y],
          [box.x + box.width, y],
        ]);
    }
    pen.fillStyle = this.color("ink");
    pen.textAlign = "center";
    pen.fillText(this.x.label, box.x + box.width / 2, this.height - 8);
    pen.save();
    pen.translate(12, box.y + box.height / 2);
    pen.rotate(-Math.PI / 2);
    pen.fillText(this.y.label, 0, 0);
    pen.restore();
    pen.textAlign = "left";
  }

  stroke(points: [number, number][]): void {
    this.pen.beginPath();
    for (const point of points) this.pen.lineTo(...point);
    this.pen.stroke();
  }

  /** Draw a ring around the point of the knobs' gait. */
  ring(x: number, y: number): void {
    const { pen } = this;
    const [left, top] = this.place(x, y);
    for (const [color, width] of [
      ["paper", 5],
      ["ink", 2],
    ] as const) {
      pen.strokeStyle = this.color(color);
      pen.lineWidth = width;
      pen.beginPath();
      pen.arc(left, top, 8, 0, 7);
      pen.stroke();
    }
  }
}
