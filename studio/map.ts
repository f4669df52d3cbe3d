// The map view: a quantity over two parameters of the gait, computed on finer and finer grids.
import { Chart, colorAt, ticks } from "./chart.ts";
import { element, inFrame, labeled } from "./dom.ts";
import { Better } from "./interface.ts";
import { digits, meaning, type Quantities, SUMMARY, statusOf } from "./quantities.ts";
import { numbers } from "./hash.ts";
import type { Kept, Page, Subject, View } from "./subject.ts";

const FIRST_INTERVALS = 8; // intervals a side of the first grid
const GRID_COUNT = 4; // number of grids, each with half the interval of the one before
const FINEST_INTERVALS = FIRST_INTERVALS << (GRID_COUNT - 1);
const CHUNK_SIZE = 48; // gaits in one question to the worker: few, so that a knob never waits long
const START_DELAY = 120; // ms without a change before a map begins
const COLORED_SHARE = 0.93; // fraction of the gaits whose values the colors tell apart; above, one color

export class MapView implements View {
  private quantity = "speed";
  private over: [number, number] = [-1, -1]; // indices in the gait's row of the two axes; -1: not chosen yet
  private readonly chart: Chart;
  private readonly choices: Record<"quantity" | "x" | "y", HTMLSelectElement>;
  private readonly note = element("p", "caption");
  private subject: Subject | null = null;
  private row: Float64Array = new Float64Array();
  private size = 0; // intervals a side of the grid that is computed
  private cells = new Map<number, Quantities>(); // quantities by place of the finest grid
  private made = ""; // key of what the map shows: robot, model, axes and the rest of the gait
  private run = 0; // number of the present map; the computation of an older map ends
  private timer = 0;
  private readonly soon = inFrame(() => this.draw());
  private painted: { image: HTMLCanvasElement; low: number; high: number; clipped: boolean; best: number } | null =
    null;

  constructor(
    private readonly panel: HTMLElement,
    private readonly page: Page,
  ) {
    const canvas = element("canvas", "chart");
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "Map: arrow keys move the gait");
    this.choices = { quantity: element("select"), x: element("select"), y: element("select") };
    const { quantity, x, y } = this.choices;
    const head = element("div", "row left");
    head.append(labeled("map of ", quantity), labeled("over ", x), labeled("and ", y));
    head.addEventListener("change", () => this.choose());
    quantity.append(...sought().map(({ label, name }) => new Option(label, name)));
    panel.replaceChildren(head, canvas, this.note);
    this.chart = new Chart(canvas);
    canvas.addEventListener("pointerdown", (event) => this.drag(event));
    canvas.addEventListener("pointermove", (event) => this.hover(event));
    canvas.addEventListener("pointerleave", () => this.tell());
    canvas.addEventListener("keydown", (event) => this.press(event));
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  restore({ map, over }: Kept): void {
    this.quantity = map ?? this.quantity;
    const [x, y] = numbers(over ?? null);
    if (x !== undefined && y !== undefined) this.over = [x, y];
  }

  kept(): Kept {
    return { map: this.quantity, over: this.over.join(",") };
  }

  about(subject: Subject): void {
    const other = this.subject?.robot !== subject.robot;
    this.subject = subject;
    if (!other) return;
    this.run++;
    [this.cells, this.made, this.painted] = [new Map(), "", null];
    this.layOut();
  }

  /** Take the gait of the knobs. */
  at(row: Float64Array): void {
    this.row = row;
    this.soon();
    this.show();
  }

  svg(title: string): string {
    return this.chart.svg(title, () => this.draw());
  }

  refresh(): void {
    this.draw();
  }

  /** Whether small values of the quantity are the best ones. */
  private get least(): boolean {
    return meaning(this.quantity).better === Better.small;
  }

  private layOut(): void {
    const parameters = this.subject?.parameters ?? [];
    const [a, b] = this.over;
    const known = a !== b && Math.min(a, b) >= 0 && Math.max(a, b) < parameters.length;
    const free = parameters.filter(({ free }) => free).map(({ index }) => index);
    const last = free.findLast((k) => parameters[k]?.kind === "phase") ?? free.at(-1) ?? 1;
    if (!known) this.over = [free[0] ?? 0, last];
    if (!sought().some(({ name }) => name === this.quantity)) this.quantity = "speed";
    for (const [axis, key] of (["x", "y"] as const).entries()) {
      this.choices[key].replaceChildren(...parameters.map(({ label, index }) => new Option(label, String(index))));
      this.choices[key].value = String(this.over[axis]);
    }
    this.choices.quantity.value = this.quantity;
  }

  private choose(): void {
    const { quantity, x, y } = this.choices;
    const before = this.over;
    this.quantity = quantity.value;
    this.painted = null;
    this.over = [Number(x.value), Number(y.value)];
    if (this.over[0] === this.over[1]) {
      this.over = before[0] === this.over[0] ? [before[1], this.over[1]] : [this.over[0], before[0]];
      [x.value, y.value] = [String(this.over[0]), String(this.over[1])];
    }
    this.page.changed();
    this.draw();
    this.show();
  }

  // --- computing

  /** If the view is shown, begin a new map when the robot, the model, the axes or the rest of the gait changed. */
  show(): void {
    const { subject, over, row } = this;
    if (subject === null || this.panel.hidden || row.length !== subject.parameters.length) return;
    const rest = Array.from(row).filter((_, k) => !over.includes(k));
    const key = JSON.stringify([subject.robot.key, subject.model, over, rest]);
    if (key === this.made) return;
    this.made = key;
    this.panel.ariaBusy = "true";
    this.run++;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.compute(subject, row.slice(), this.run), START_DELAY);
  }

  private async compute(subject: Subject, row: Float64Array, run: number): Promise<void> {
    const cells = new Map<number, Quantities>();
    for (let level = 0; level < GRID_COUNT; level++) {
      const stride = FINEST_INTERVALS / (FIRST_INTERVALS << level);
      const places = grid(stride).filter((place) => !cells.has(place));
      for (let k = 0; k < places.length; k += CHUNK_SIZE) {
        const chunk = places.slice(k, k + CHUNK_SIZE);
        const found = await subject.sweep(chunk.map((place) => this.gaitAt(place, row, subject)));
        if (run !== this.run) return;
        chunk.forEach((place, i) => {
          cells.set(place, found[i] ?? {});
        });
      }
      [this.cells, this.size, this.painted] = [cells, FINEST_INTERVALS / stride, null];
      this.soon();
    }
    this.panel.ariaBusy = "false";
  }

  /** The gait at a place of the finest grid; parameters that are not an axis are those of `base`. */
  private gaitAt(place: number, base: Float64Array, subject: Subject): Float64Array {
    const row = base.slice();
    const steps = [place % (FINEST_INTERVALS + 1), Math.floor(place / (FINEST_INTERVALS + 1))];
    this.over.forEach((k, axis) => {
      const { range, size } = subject.parameters[k] ?? { range: [0, 0], size: 0 };
      row[k] = (range[0] + ((steps[axis] ?? 0) / FINEST_INTERVALS) * (range[1] - range[0])) * size;
    });
    return row;
  }

  // --- drawing

  private get parts(): [number, number] {
    const part = (k: number): number => (this.row[k] ?? 0) / (this.subject?.parameters[k]?.size ?? 1);
    return [part(this.over[0]), part(this.over[1])];
  }

  private draw(): void {
    const { chart, subject } = this;
    const [x, y] = [subject?.parameters[this.over[0]], subject?.parameters[this.over[1]]];
    if (x === undefined || y === undefined || this.panel.hidden) return;
    chart.right = 88;
    const axis = (p: typeof x) => ({ label: `${p.label} [${p.unit}]`, range: p.range });
    if (!chart.begin(axis(x), axis(y))) return;
    const { pen } = chart;
    const box = chart.inside;
    pen.fillStyle = chart.color("grid");
    pen.fillRect(box.x, box.y, box.width, box.height);
    if (this.cells.size > 0) this.paint();
    chart.axes(false);
    chart.ring(...this.parts);
    this.tell();
  }

  /** The lowest and the highest value that the colors show; `clipped` if larger values exist. */
  private reach(): { low: number; high: number; clipped: boolean } {
    const values = [...this.cells.values()].filter(settled).map((cell) => cell[this.quantity] ?? Number.NaN);
    const sorted = values.filter(Number.isFinite).sort((a, b) => a - b);
    const [low = 0, most = 1] = [sorted[0], sorted.at(-1)];
    const clipped = this.least && most > 3 * (sorted[Math.floor(COLORED_SHARE * sorted.length)] ?? most);
    const high = clipped ? (sorted[Math.floor(COLORED_SHARE * sorted.length)] ?? most) : most;
    return { low, high: high > low ? high : low + 1, clipped };
  }

  /** An image with the cells' colors, and the place of the best cell. */
  private colored(): NonNullable<MapView["painted"]> {
    const { size, quantity } = this;
    const { low, high, clipped } = this.reach();
    const data = new ImageData(size + 1, size + 1);
    for (let j = 0; j <= size; j++)
      for (let i = 0; i <= size; i++) {
        const cell = this.cells.get(
          ((j * FINEST_INTERVALS) / size) * (FINEST_INTERVALS + 1) + (i * FINEST_INTERVALS) / size,
        );
        const value = cell?.[quantity];
        if (cell === undefined || value === undefined || !settled(cell) || !Number.isFinite(value)) continue;
        data.data.set([...colorAt((value - low) / (high - low)), 255], 4 * ((size - j) * (size + 1) + i));
      }
    const image = element("canvas");
    [image.width, image.height] = [size + 1, size + 1];
    image.getContext("2d")?.putImageData(data, 0, 0);
    return { image, low, high, clipped, best: this.best() };
  }

  private paint(): void {
    const { chart, size } = this;
    this.painted ??= this.colored();
    const { image, low, high, clipped, best } = this.painted;
    const { pen } = chart;
    const box = chart.inside;
    const [cellX, cellY] = [box.width / size, box.height / size];
    pen.save();
    pen.beginPath();
    pen.rect(box.x, box.y, box.width, box.height);
    pen.clip();
    pen.imageSmoothingQuality = "high";
    pen.drawImage(image, box.x - cellX / 2, box.y - cellY / 2, box.width + cellX, box.height + cellY);
    pen.restore();
    this.bar(low, high, clipped);
    this.cross(best);
  }

  /** Draw the color bar, with values. */
  private bar(low: number, high: number, clipped: boolean): void {
    const { chart } = this;
    const { pen } = chart;
    const box = chart.inside;
    const left = box.x + box.width + 16;
    const shade = pen.createLinearGradient(0, box.y + box.height, 0, box.y);
    for (let k = 0; k <= 8; k++) shade.addColorStop(k / 8, `rgb(${colorAt(k / 8).join(",")})`);
    pen.fillStyle = shade;
    pen.fillRect(left, box.y, 12, box.height);
    pen.fillStyle = chart.color("faint");
    const marks = ticks([low, high], 4).map((mark) => ({ mark, text: digits(mark, 3) }));
    const shown = clipped ? [...marks, { mark: high, text: `≥ ${digits(high, 2)}` }] : marks;
    let above = Number.NEGATIVE_INFINITY;
    for (const { mark, text } of shown.reverse()) {
      const y = box.y + box.height * (1 - (mark - low) / (high - low));
      if (y < above + 16) continue;
      above = y;
      pen.fillRect(left + 12, y, 4, 1);
      pen.fillText(text, left + 20, y + 4);
    }
  }

  /** Place of the best settled gait that swims ahead; -1 if there is none. */
  private best(): number {
    const sign = this.least ? -1 : 1;
    let [most, place] = [Number.NEGATIVE_INFINITY, -1];
    for (const [at, cell] of this.cells) {
      const value = sign * (cell[this.quantity] ?? Number.NaN);
      if (settled(cell) && (cell.speed ?? 0) > 1e-3 && value > most) [most, place] = [value, at];
    }
    return place;
  }

  private cross(place: number): void {
    const { subject } = this;
    if (subject === null || place < 0) return;
    const row = this.gaitAt(place, this.row, subject);
    const [x, y] = this.over.map((k) => (row[k] ?? 0) / (subject.parameters[k]?.size ?? 1));
    const [left, top] = this.chart.place(x ?? 0, y ?? 0);
    const { pen } = this.chart;
    for (const [color, width] of [
      ["#0d1b24", 4],
      ["#ffffff", 2],
    ] as const) {
      pen.strokeStyle = color;
      pen.lineWidth = width;
      for (const side of [-1, 1])
        this.chart.stroke([
          [left - 5, top - 5 * side],
          [left + 5, top + 5 * side],
        ]);
    }
  }

  /** Show `text`, or else what the map shows. */
  private tell(text = ""): void {
    const { label, unit } = meaning(this.quantity);
    const best = this.least ? "least" : "largest";
    this.note.textContent =
      text ||
      `${label}${unit === "" ? "" : ` [${unit}]`} of settled gaits; ring: the knobs, cross: the ${best} on the map. Gray: not settled. Click or drag to go there.`;
  }

  // --- events

  private go(x: number, y: number): void {
    const row = this.row.slice();
    this.over.forEach((k, axis) => {
      row[k] = (axis === 0 ? x : y) * (this.subject?.parameters[k]?.size ?? 1);
    });
    this.page.go(row);
  }

  private drag(event: PointerEvent): void {
    this.chart.canvas.setPointerCapture(event.pointerId);
    this.go(...this.chart.value(event.offsetX, event.offsetY));
  }

  private hover(event: PointerEvent): void {
    const [x, y] = this.chart.value(event.offsetX, event.offsetY);
    if (event.buttons === 1) this.go(x, y);
    const { size } = this;
    const [a, b] = this.over.map((k) => this.subject?.parameters[k]);
    if (a === undefined || b === undefined || size === 0) return;
    const step = (value: number, [low, high]: readonly [number, number]): number =>
      (Math.round(((value - low) / (high - low)) * size) * FINEST_INTERVALS) / size;
    const cell = this.cells.get(step(y, b.range) * (FINEST_INTERVALS + 1) + step(x, a.range));
    const { label, unit } = meaning(this.quantity);
    const value =
      cell === undefined || !settled(cell) ? "not settled" : `${label} ${digits(cell[this.quantity])} ${unit}`;
    this.tell(`${digits(x)} ${a.unit}, ${digits(y)} ${b.unit}: ${value}`);
  }

  private press(event: KeyboardEvent): void {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key];
    if (way === undefined) return;
    event.preventDefault();
    const moved = this.parts.map((value, k) => {
      const [low, high] = this.subject?.parameters[this.over[k] ?? 0]?.range ?? [0, 1];
      return Math.min(high, Math.max(low, value + ((way[k] ?? 0) * (high - low)) / 64));
    });
    this.go(moved[0] ?? 0, moved[1] ?? 0);
  }
}

/** Quantities that a map may show: those of which a small or a large value is better. */
const sought = () => SUMMARY.filter(({ better }) => better !== Better.neither);

const settled = (cell: Quantities): boolean => statusOf(cell) === "settled";

/** Places of the finest grid that a square grid with this stride has, row by row. */
function grid(stride: number): number[] {
  const places: number[] = [];
  for (let j = 0; j <= FINEST_INTERVALS; j += stride)
    for (let i = 0; i <= FINEST_INTERVALS; i += stride) places.push(j * (FINEST_INTERVALS + 1) + i);
  return places;
}
