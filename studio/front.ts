// The view of cost over speed: named gaits, the gait of the knobs, the least cost at each speed, and its search.
import { drawBand, drawBars, usable } from "./band.ts";
import { Chart } from "./chart.ts";
import { button, element, inFrame } from "./dom.ts";
import { Box, type Found, type Goal, MAX_STEPS, search, type Watch } from "./optimize.ts";
import { digits, gaitText, type Quantities } from "./quantities.ts";
import { Latest } from "./questions.ts";
import { gaitOf, type NamedGait, rowOf } from "./robot.ts";
import { type Spread, spreadWords } from "./samples.ts";
import type { Page, Subject, View } from "./subject.ts";

const START_COUNT = 6; // starts of a search: the knobs' gait, and points spread over the limits
const SPEED_COUNT = 14; // speeds of the front at which the least cost is sought
const STEP_PAUSE = 120; // ms between two steps of a search that is shown on the fish
const TOLERANCE = 1e-3; // results count as the same below this relative difference

export class FrontView implements View {
  private readonly chart: Chart;
  private readonly status = element("p", "caption");
  private readonly note = element("p", "caption");
  private readonly speed = element("input");
  private readonly cancel = button("Cancel", () => {
    this.stop("The search was cancelled: the knobs are at its last step.");
  });
  private readonly buttons: HTMLButtonElement[];
  private subject: Subject | null = null;
  private row: Float64Array = new Float64Array();
  private values: Quantities = {};
  private named: { gait: NamedGait; values: Quantities }[] = [];
  private front: Found[] = [];
  private spreads: { named: Spread[]; front: Spread[]; knobs: Spread | null } = { named: [], front: [], knobs: null };
  private trace: Quantities[] = []; // quantities of the gait after each step of the search
  private made: Set<string> | null = null; // rows of the gaits that the search has set on the knobs
  private run = 0; // number of the present search; a search with an older number ends
  private readonly latest = new Latest();
  private readonly soon = inFrame(() => this.draw());

  constructor(
    private readonly panel: HTMLElement,
    private readonly page: Page,
  ) {
    const canvas = element("canvas", "chart");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "Cost of transport over speed");
    const fastest = button("Maximum speed", () => void this.optimize({ quantity: "speed", speed: null }));
    const cheapest = button("Least cost at", () => {
      void this.optimize({ quantity: "cost_of_transport", speed: this.speed.valueAsNumber });
    });
    const front = button("Least cost at all speeds", () => void this.all());
    this.buttons = [fastest, cheapest, front];
    Object.assign(this.speed, { type: "number", step: "any", min: "0" });
    this.speed.setAttribute("aria-label", "speed [m/s] to swim at least cost");
    const field = element("span", "field");
    field.append(this.speed, element("span", "unit", "m/s"));
    const head = element("div", "row left");
    head.append(element("span", "choice", "optimize"), fastest, cheapest, field, front, this.cancel);
    this.status.setAttribute("role", "status");
    this.cancel.disabled = true;
    panel.replaceChildren(head, canvas, this.note, this.status);
    this.chart = new Chart(canvas);
    canvas.addEventListener("click", (event) => this.pick(event));
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /** Take another robot, or another model of the same robot. */
  async about(subject: Subject): Promise<void> {
    const before = this.subject;
    this.subject = subject;
    if (before?.robot === subject.robot && before.model === subject.model) return;
    this.stop("");
    [this.front, this.trace, this.named] = [[], [], []];
    this.spreads = { named: [], front: [], knobs: null };
    const free = subject.parameters.some((parameter) => parameter.free);
    for (const button of this.buttons) button.disabled = !free;
    if (!free) this.status.textContent = "The robot's file has no [gait_bounds] to optimize within.";
    const { gaits } = subject.robot;
    const found = await this.latest.of(subject.sweep(gaits.map(rowOf)));
    if (found === null) return;
    this.named = gaits.map((gait, k) => ({ gait, values: found[k] ?? {} }));
    const fastest = Math.max(0, ...this.named.map(({ values }) => values.speed ?? 0).filter(Number.isFinite));
    this.speed.value = String(Number((0.7 * fastest).toPrecision(1)));
    this.draw();
    void this.spread();
  }

  /** Show the interval of most samples at the knobs' gait. */
  certain(spread: Spread | null): void {
    this.spreads.knobs = spread;
    this.draw();
  }

  /** Compute the intervals of most samples for the named gaits and the gaits of least cost. */
  private async spread(): Promise<void> {
    const { subject, front, named } = this;
    if (subject === null) return;
    const rows = [...named.map(({ gait }) => rowOf(gait)), ...front.map(({ row }) => row)];
    const found = (await subject.spreads(rows)) ?? [];
    if (subject !== this.subject || front !== this.front || found.length === 0) return;
    this.spreads.named = found.slice(0, named.length);
    this.spreads.front = found.slice(named.length);
    this.draw();
  }

  /** Take the gait of the knobs; its quantities arrive later by `at`. */
  set(row: Float64Array): void {
    this.row = row;
    if (this.made !== null && !this.made.has(String(row))) this.stop("Stopped, because a knob was turned.");
  }

  /** Take the quantities of the knobs' gait. */
  at(_: Float64Array, values: Quantities): void {
    this.values = values;
    this.soon();
  }

  svg(title: string): string {
    return this.chart.svg(title, () => this.draw());
  }

  refresh(): void {
    this.draw();
  }

  // --- searching

  private begin(): number {
    this.cancel.disabled = false;
    for (const button of this.buttons) button.disabled = true;
    return ++this.run;
  }

  private stop(sentence: string): void {
    this.run++;
    this.made = null;
    this.cancel.disabled = true;
    for (const button of this.buttons) button.disabled = false;
    this.status.textContent = sentence;
  }

  /** Search from the gait of the knobs, shown step by step; then from other starts. */
  private async optimize(goal: Goal): Promise<void> {
    const { subject } = this;
    if (subject === null) return;
    if (goal.speed !== null && !(goal.speed > 0)) {
      this.status.textContent = "Give the speed to swim at least cost, in m/s, greater than 0.";
      return;
    }
    const run = this.begin();
    const box = new Box(subject);
    const begun = this.row;
    this.trace = [];
    this.made = new Set([String(begun)]);
    const starts = [box.point(this.row), ...box.spread(START_COUNT - 1)];
    const ends: Found[] = [];
    for (const [k, start] of starts.entries()) {
      const watched = ends.length === 0 ? this.watched(goal, run) : this.counted(run, k);
      const end = await search(subject, goal, start, watched);
      if (run !== this.run) return;
      if (end !== null && reaches(end, goal)) ends.push(end);
    }
    this.finish(goal, ends, starts.length);
    if (ends.length === 0) this.page.go(begun);
  }

  private finish(goal: Goal, ends: Found[], count: number): void {
    const best = ends.reduce<Found | null>((a, b) => (a === null || score(b, goal) < score(a, goal) ? b : a), null);
    if (best === null) {
      this.stop(
        goal.speed === null
          ? "No gait within the limits settles ahead."
          : `No search reached ${digits(goal.speed)} m/s within the limits: ask for less.`,
      );
      return;
    }
    const least = score(best, goal);
    const same = ends.filter((end) => score(end, goal) <= least + TOLERANCE * Math.abs(least)).length;
    const { speed, cost_of_transport: cost } = best.computed.values;
    const cut = ends.filter((end) => end.cut === true).length;
    const short = cut === 0 ? "" : ` (${cut} ${cut === 1 ? "was" : "were"} cut off after ${MAX_STEPS} steps)`;
    this.stop(
      `All ${count} gradient searches have ended, ${same} of them at the best value${short}: ${digits(speed)} m/s at ${digits(cost)} J/(kg m), ${gaitText(gaitOf(best.row))}.`,
    );
    this.made = null;
    this.page.go(best.row);
  }

  /** Returns a watcher that shows each step on the fish, slowly enough for the eye. */
  private watched(goal: Goal, run: number): Watch {
    const aim = goal.speed === null ? "maximum speed" : `least cost at ${digits(goal.speed)} m/s`;
    return async ({ row, computed }, step) => {
      if (run !== this.run) return false;
      this.trace.push(computed.values);
      const { speed, cost_of_transport: cost } = computed.values;
      this.status.textContent = `Searching ${aim}, step ${step}: ${digits(speed)} m/s at ${digits(cost)} J/(kg m).`;
      this.made?.add(String(row));
      this.page.go(row);
      await new Promise((resolve) => setTimeout(resolve, STEP_PAUSE));
      return run === this.run;
    };
  }

  private counted(run: number, k: number): Watch {
    return async () => {
      if (run === this.run) this.status.textContent = `Searching from other starts: ${k + 1} of ${START_COUNT}.`;
      return run === this.run;
    };
  }

  /** Compute the front: the maximum speed, then the least cost at lower and lower speeds, each from the one before. */
  private async all(): Promise<void> {
    const { subject } = this;
    if (subject === null) return;
    const run = this.begin();
    this.front = [];
    const box = new Box(subject);
    const go: Watch = async () => run === this.run;
    const fast: Goal = { quantity: "speed", speed: null };
    const [own, ...others] = [box.point(this.row), ...box.spread(2)];
    let best: Found | null = null;
    for (const start of [own, ...others]) {
      if (start === undefined) continue;
      const end = await search(subject, fast, start, go);
      if (end !== null && (best === null || score(end, fast) < score(best, fast))) best = end;
    }
    const top = best?.computed.values.speed;
    if (run !== this.run) return;
    if (best === null || top === undefined) {
      this.stop("No gait within the limits settles ahead.");
      return;
    }
    this.front = [best];
    let last: Found = best;
    for (let k = SPEED_COUNT - 1; k >= 1; k--) {
      this.status.textContent = `Least cost at each speed: ${SPEED_COUNT - k} of ${SPEED_COUNT - 1}.`;
      const goal: Goal = { quantity: "cost_of_transport", speed: (top * k) / SPEED_COUNT };
      const end = await search(subject, goal, box.point(last.row), go);
      if (run !== this.run) return;
      if (end === null || !reaches(end, goal)) continue;
      last = end;
      this.front.push(end);
      this.draw();
    }
    void this.spread();
    this.stop(
      `The line is the least cost of ${this.front.length} speeds, up to ${digits(top)} m/s. Click a point to swim it.`,
    );
  }

  // --- drawing

  private draw(): void {
    const { chart } = this;
    if (this.panel.hidden) return;
    const points = [
      ...this.named.map(({ values }) => values),
      ...this.front.map(({ computed }) => computed.values),
      this.values,
    ];
    const shown = points.filter(usable);
    const published = this.named.map(({ gait }) => gait.published.speed?.value ?? 0);
    const { spreads } = this;
    const certain = [...spreads.named, ...spreads.front, ...(spreads.knobs === null ? [] : [spreads.knobs])];
    const ends = (name: string): number[] =>
      certain.map(({ intervals }) => intervals[name]?.[1] ?? 0).filter(Number.isFinite);
    const most = (values: number[]): number => 1.08 * Math.max(1e-6, ...values);
    const x = most([...shown.map(({ speed = 0 }) => speed), ...published, ...ends("speed")]);
    const y = most(shown.map(({ cost_of_transport: cost = 0 }) => cost).concat(ends("cost_of_transport")));
    const cost = { label: "cost of transport [J/(kg m)]", range: [0, y] as const };
    if (!chart.begin({ label: "speed [m/s]", range: [0, x] }, cost)) return;
    chart.axes(true);
    const { named, front, knobs } = spreads;
    const least = this.front.map(({ computed }) => computed.values);
    drawBand(chart, front, least);
    named.forEach((spread, k) => drawBars(chart, spread, this.named[k]?.values ?? {}, "blue"));
    if (knobs !== null) drawBars(chart, knobs, this.values, "ink");
    this.drawFront();
    this.drawTrace();
    this.drawNamed();
    const drawn = certain[0]?.of === "estimates" ? "Bars" : "Band and bars";
    this.note.textContent = certain[0] === undefined ? "" : `${drawn}: ${spreadWords(certain[0])}.`;
    if (usable(this.values)) chart.ring(...this.placed(this.values));
    this.legend();
  }

  private placed({ speed = 0, cost_of_transport: cost = 0 }: Quantities): [number, number] {
    return [speed, cost];
  }

  private drawFront(): void {
    const { chart } = this;
    const points = this.front.map(({ computed }) => chart.place(...this.placed(computed.values)));
    chart.pen.strokeStyle = chart.color("green");
    chart.pen.fillStyle = chart.color("green");
    chart.pen.lineWidth = 2;
    chart.stroke(points);
    for (const [x, y] of points) this.dot(x, y, 3);
  }

  private drawTrace(): void {
    const { chart } = this;
    chart.pen.strokeStyle = chart.color("ink");
    chart.pen.lineWidth = 1.5;
    chart.pen.setLineDash([3, 3]);
    chart.stroke(this.trace.filter(usable).map((values) => chart.place(...this.placed(values))));
    chart.pen.setLineDash([]);
  }

  /** Draw computed gaits as dots, published speeds as diamonds at the computed cost, filled if measured. */
  private drawNamed(): void {
    const { chart } = this;
    const { pen } = chart;
    for (const { gait, values } of this.named) {
      if (!usable(values)) continue;
      const [x, y] = chart.place(...this.placed(values));
      const { speed } = gait.published;
      if (speed !== undefined) {
        const [there] = chart.place(speed.value, 0);
        pen.strokeStyle = pen.fillStyle = chart.color("orange");
        pen.lineWidth = 1.5;
        chart.stroke([
          [x, y],
          [there, y],
        ]);
        this.diamond(there, y, speed.kind === "measured");
      }
      pen.fillStyle = chart.color("blue");
      this.dot(x, y, 5);
    }
  }

  private dot(x: number, y: number, size: number): void {
    const { pen } = this.chart;
    pen.beginPath();
    pen.arc(x, y, size, 0, 7);
    pen.fill();
  }

  private diamond(x: number, y: number, filled: boolean): void {
    const { chart } = this;
    const { pen } = chart;
    pen.beginPath();
    for (const quarter of [0, 1, 2, 3])
      pen.lineTo(x + 5 * Math.sin((quarter * Math.PI) / 2), y - 5 * Math.cos((quarter * Math.PI) / 2));
    pen.closePath();
    pen.fillStyle = chart.color(filled ? "orange" : "paper");
    pen.fill();
    pen.stroke();
  }

  private legend(): void {
    const { chart } = this;
    const published = this.named.some(({ gait }) => gait.published.speed !== undefined);
    const lines: [string, string, (x: number, y: number) => void][] = [
      ["named gait, computed", "blue", (x, y) => this.dot(x, y, 5)],
    ];
    if (published) {
      lines.push(["published speed, measured", "orange", (x, y) => this.diamond(x, y, true)]);
      lines.push(["published speed, target", "orange", (x, y) => this.diamond(x, y, false)]);
    }
    if (this.front.length > 0) lines.push(["least cost, computed", "green", (x, y) => this.dot(x, y, 3)]);
    const box = chart.inside;
    lines.forEach(([text, color, mark], k) => {
      const [x, y] = [box.x + 16, box.y + 16 + 18 * k];
      chart.pen.fillStyle = chart.color(color);
      chart.pen.strokeStyle = chart.color("orange");
      chart.pen.lineWidth = 1.5;
      mark(x, y - 4);
      chart.pen.fillStyle = chart.color("faint");
      chart.pen.fillText(text, x + 12, y);
    });
  }

  /** Set the knobs to the gait whose point is nearest to a click. */
  private pick(event: MouseEvent): void {
    const gaits = [
      ...this.named.map(({ gait, values }) => ({ row: rowOf(gait), values })),
      ...this.front.map(({ row, computed }) => ({ row, values: computed.values })),
    ].filter(({ values }) => usable(values));
    const far = gaits.map(({ values }) => {
      const [x, y] = this.chart.place(...this.placed(values));
      return Math.hypot(x - event.offsetX, y - event.offsetY);
    });
    const nearest = far.indexOf(Math.min(...far));
    const gait = gaits[nearest];
    if (gait !== undefined && (far[nearest] ?? 0) < 24) this.page.go(gait.row);
  }
}

/** The value that the search minimizes. */
function score({ computed }: Found, goal: Goal): number {
  const value = computed.values[goal.quantity] ?? Number.NaN;
  return goal.quantity === "speed" ? -value : value;
}

function reaches({ computed }: Found, goal: Goal): boolean {
  return goal.speed === null || Math.abs((computed.values.speed ?? 0) / goal.speed - 1) < 1e-3;
}
