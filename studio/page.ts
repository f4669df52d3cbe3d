// The page: what is chosen, what is computed from it, and where it is shown.

import { beatTable, gaitToml } from "./exports.ts";
import { packedBytes, savePicture, saveText } from "./files.ts";
import { Stage } from "./fish.ts";
import * as hash from "./hash.ts";
import { element, Knobs } from "./knobs.ts";
import { Beat } from "./motion.ts";
import * as words from "./quantities.ts";
import { Calculator } from "./questions.ts";
import { gaitOf, modelOf, type Parameter, parametersOf, type Robot, robotOf, rowOf } from "./robot.ts";
import { Views } from "./views.ts";

declare const WORKER: string; // script of the worker

const SIMD = [
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
];
const QUIET = 250; // ms without a turned knob before a start from rest is followed
const KEPT = 100; // ms after which a change is in the address: browsers allow few changes a second
const LINKED = location.protocol !== "about:"; // a page inside a document's frame has no address
const MAX_IMAGE = 2 ** 24; // bytes

interface Listed {
  image: () => Promise<Uint8Array>;
  robot?: Robot;
}

/** The element of the page with an id. */
function part<E extends HTMLElement = HTMLElement>(id: string): E {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no ${id}`);
  return found as E;
}

class Studio {
  private readonly stage = new Stage(part<HTMLCanvasElement>("stage"));
  private readonly knobs = new Knobs(part("knobs"), (index, value) => this.turn(index, value));
  private readonly robots = new Map<string, Listed>();
  private readonly views: Views;
  private live!: Calculator;
  private quantities: string[] = [];
  private derivatives: string[] = [];
  private robot!: Robot;
  private parameters: Parameter[] = [];
  private row: Float64Array = new Float64Array();
  private model = 0;
  private of = "speed";
  private values: words.Quantities = {};
  private rates: Float64Array = new Float64Array(); // derivatives of the last beat
  private path: Float64Array = new Float64Array();
  private busy = false;
  private stale = false;
  private kept = 0; // timer of the address
  private quiet = 0; // timer of the start from rest

  constructor(private readonly module: WebAssembly.Module) {
    this.views = new Views({
      go: (row) => this.go(row),
      changed: () => this.keep(),
    });
    this.listen();
  }

  /** Show the first robot; everything else comes after its first stroke. */
  async open(given: { robots: { name: string; image: string }[]; start: Start }): Promise<void> {
    for (const { name, image } of given.robots) this.robots.set(name, { image: () => packedBytes(image) });
    const script = URL.createObjectURL(new Blob([WORKER], { type: "text/javascript" }));
    this.live = new Calculator(script);
    const names = await this.live.ask({ kind: "start", module: this.module });
    [this.quantities, this.derivatives] = [names.quantities, names.derivatives];
    const address = { ...fromStart(given.start), ...hash.read(location.hash) };
    this.layOutChoices(address);
    const first = given.robots[0]?.name ?? "";
    if (address.robot !== undefined && !this.robots.has(address.robot)) {
      this.say(
        `The link names the robot "${address.robot}", which this page does not have: drop its image here to see it.`,
      );
    }
    await this.choose(this.robots.has(address.robot ?? "") ? (address.robot ?? first) : first, address);
    const more = async (): Promise<Calculator> => {
      const calculator = new Calculator(script);
      await calculator.ask({ kind: "start", module: this.module });
      return calculator;
    };
    this.views.start(await more(), names, more);
    await this.inform();
  }

  // --- what is chosen

  private async choose(name: string, address: Partial<hash.Address> = {}): Promise<void> {
    const listed = this.robots.get(name);
    if (listed === undefined) return;
    if (listed.robot === undefined) {
      const { text } = await this.live.ask({ kind: "load", robot: name, image: await listed.image() });
      listed.robot = { ...robotOf(text), robot: name };
    }
    this.robot = listed.robot;
    this.parameters = parametersOf(this.robot);
    const model = modelOf(this.robot, address.water ?? "", address.joints ?? "");
    this.model = Math.max(0, model);
    const fits = address.gait !== undefined && rowOf(address.gait).length === this.parameters.length;
    if (address.gait !== undefined && !fits)
      this.say(`The link's gait does not fit ${name}: its own first gait is shown.`);
    const first = this.robot.gaits[0] ?? middle(this.parameters);
    this.row = rowOf(fits && address.gait !== undefined ? address.gait : first);
    this.layOutRobot();
    await this.inform();
    await this.update();
  }

  private turn(index: number, value: number): void {
    this.row[index] = value;
    this.changed();
  }

  private go(row: Float64Array): void {
    this.row = row.slice();
    this.changed();
  }

  private changed(): void {
    this.knobs.show(this.row);
    this.keep();
    void this.update();
  }

  /** Keep what is chosen in the address. */
  private keep(): void {
    clearTimeout(this.kept);
    this.kept = window.setTimeout(() => this.write(), KEPT);
  }

  private write(): void {
    clearTimeout(this.kept);
    const { water, joints } = this.robot.models[this.model] ?? { water: "", joints: "" };
    const { view, map } = this.views;
    const tempo = this.stage.shown.tempo;
    const address = {
      robot: this.robot.robot,
      gait: gaitOf(this.row),
      water,
      joints,
      of: this.of,
      view,
      tempo,
      map: map.quantity,
      over: map.over,
    };
    if (LINKED) history.replaceState(null, "", hash.written(address));
  }

  // --- what is computed

  /** Compute the beat of the knobs; while one is computed, only the last turn waits. */
  private async update(follow = false): Promise<void> {
    clearTimeout(this.quiet);
    this.stale = true;
    if (this.busy) return;
    this.busy = true;
    document.documentElement.dataset.busy = "1";
    let followed = false;
    for (let next = follow; this.stale; next = false) {
      this.stale = false;
      followed = next;
      const { robot, model } = this;
      const gait = this.row.slice();
      const beat = await this.live.ask({ kind: "beat", robot: robot.robot, model, gait, follow: followed });
      if (robot !== this.robot) continue;
      this.values = words.named(this.quantities, beat.quantities);
      this.path = beat.path;
      this.show(gait, followed);
      if (this.stale || followed) continue; // the next numbers come before this gradient
      const { derivatives } = await this.live.ask({ kind: "gradient", robot: robot.robot, model, gait });
      if (robot !== this.robot) continue;
      this.rates = derivatives;
      this.showGradient();
    }
    this.busy = false;
    document.documentElement.dataset.busy = "0";
    if (!followed) this.quiet = window.setTimeout(() => void this.update(true), QUIET);
  }

  /** Tell the views what they are about. */
  private async inform(): Promise<void> {
    const listed = this.robots.get(this.robot.robot);
    if (listed === undefined) return;
    await this.views.about(this.robot, this.model, listed.image);
    this.views.at(this.row, this.values);
  }

  // --- what is shown

  private show(row: Float64Array, followed: boolean): void {
    const { robot, values } = this;
    const gait = gaitOf(row);
    const status = words.statusOf(values);
    if (this.path.every(Number.isFinite)) {
      const beat = new Beat(this.path, this.path.length / 129, gait.frequency, !words.turns(values, robot));
      this.stage.swim(robot, beat);
    }
    this.showNumbers();
    const sentence = words.verdict(values) + words.spin(values, gait.frequency);
    const box = part("status");
    box.textContent = sentence + (followed ? words.fromRest(values) : "");
    box.dataset.status = status;
    part("swum").textContent = `${robot.robot}, ${words.gaitText(gait)}`;
    part("numbers").textContent = ["speed", "mechanical_power", "cost_of_transport"]
      .map((name) => `${words.digits(values[name], 3)} ${words.meaning(name).unit}`)
      .join(" · ");
    const { water, joints } = robot.models[this.model] ?? { water: "", joints: "" };
    part("command").textContent = words.command(robot, { water, joints }, gait);
    this.showGait();
    this.views.at(row, values);
    if (document.documentElement.dataset.ready !== "1") {
      document.documentElement.dataset.ready = "1";
      performance.mark("first-fish");
    }
  }

  private showNumbers(): void {
    const { robot, values } = this;
    const turning = words.turns(values, robot);
    for (const { name } of words.SUMMARY) {
      const box = part("facts").querySelector<HTMLElement>(`[data-quantity="${name}"]`);
      if (box === null) continue;
      box.dataset.value = String(values[name]);
      box.textContent = words.digits(values[name]);
      const tile = box.closest("div");
      if (tile !== null) tile.hidden = name.startsWith("turn_") && !turning;
    }
    const second = document.getElementById("speed_bl");
    if (second !== null) second.textContent = `${words.digits(values.speed_bl)} BL/s`;
  }

  private showGradient(): void {
    const place = this.derivatives.indexOf(this.of);
    const count = this.parameters.length;
    this.knobs.gradient(this.rates.subarray(place * count, (place + 1) * count), words.meaning(this.of).unit);
  }

  /** Mark the named gait that the knobs are at. */
  private showGait(): void {
    const choice = part<HTMLSelectElement>("gait");
    const known = this.robot.gaits.find((gait) =>
      rowOf(gait).every((value, k) => Math.abs(value - (this.row[k] ?? 0)) < 1e-9),
    );
    choice.value = known?.name ?? "";
  }

  private say(sentence: string): void {
    const box = part("alert");
    box.textContent = sentence;
    box.hidden = sentence === "";
  }

  // --- choices

  private layOutChoices(address: Partial<hash.Address>): void {
    const quantity = part<HTMLSelectElement>("of");
    for (const name of this.derivatives) quantity.append(new Option(words.meaning(name).label, name));
    if (address.of !== undefined && this.derivatives.includes(address.of)) this.of = address.of;
    quantity.value = this.of;
    this.listRobots();
    part("facts").replaceChildren(...words.SUMMARY.map(tile));
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.setTempo(address.tempo ?? (still ? 0 : 1));
    this.setMidlines(still);
    if (address.map !== undefined) this.views.map.quantity = address.map;
    if (address.over !== undefined) this.views.map.over = address.over;
    this.views.restore(address.view ?? "map");
  }

  private listRobots(): void {
    const choice = part<HTMLSelectElement>("robot");
    choice.replaceChildren(...[...this.robots.keys()].map((name) => new Option(name, name)));
    for (const option of choice.options) option.dataset.robot = option.value;
  }

  private layOutRobot(): void {
    const { robot } = this;
    part<HTMLSelectElement>("robot").value = robot.robot;
    const gaits = robot.gaits.map(({ name }) => new Option(name, name));
    for (const option of gaits) option.dataset.gait = option.value;
    const own = new Option("as the knobs are", "");
    own.hidden = true;
    part("gait").replaceChildren(own, ...gaits);
    this.knobs.layOut(this.parameters);
    this.knobs.show(this.row);
    this.layOutModels();
    const fit = robot.fit === null ? "" : ` Its coefficients are a fit: ${robot.fit}.`;
    part("made").textContent = `${robot.description}.${fit} Its image was written by ${robot.made_by}.`;
    part("robot").title = robot.description + fit;
    this.keep();
  }

  private layOutModels(): void {
    const { robot } = this;
    const now = robot.models[this.model] ?? { water: "", joints: "" };
    for (const kind of ["water", "joints"] as const) {
      const names = [...new Set(robot.models.map((model) => model[kind]))];
      const buttons = names.map((name) => {
        const button = element("button", "", name);
        button.type = "button";
        button.dataset[kind] = name;
        button.setAttribute("aria-pressed", String(now[kind] === name));
        button.addEventListener("click", () => this.setModel({ ...now, [kind]: name }));
        return button;
      });
      part(kind).replaceChildren(element("legend", "", kind === "water" ? "water law" : "joints"), ...buttons);
    }
  }

  private setModel(choice: { water: string; joints: string }): void {
    this.model = Math.max(0, modelOf(this.robot, choice.water, choice.joints));
    this.layOutModels();
    this.changed();
    void this.inform();
  }

  private setTempo(tempo: number): void {
    this.stage.shown.tempo = tempo;
    for (const button of part("tempo").querySelectorAll<HTMLElement>("[data-tempo]")) {
      button.setAttribute("aria-pressed", String(Number(button.dataset.tempo) === tempo));
    }
  }

  private setMidlines(shown: boolean): void {
    part<HTMLInputElement>("midlines").checked = shown;
    this.stage.shown.midlines = shown;
    this.stage.refresh();
  }

  // --- events

  private listen(): void {
    part("robot").addEventListener("change", (event) => void this.choose((event.target as HTMLSelectElement).value));
    part("gait").addEventListener("change", (event) => this.goTo((event.target as HTMLSelectElement).value));
    part("of").addEventListener("change", (event) => {
      this.of = (event.target as HTMLSelectElement).value;
      this.showGradient();
      this.keep();
      void this.inform();
    });
    part("tempo").addEventListener("click", (event) => {
      const { tempo } = (event.target as HTMLElement).dataset;
      if (tempo === undefined) return;
      this.setTempo(Number(tempo));
      this.keep();
    });
    part("midlines").addEventListener("change", (event) =>
      this.setMidlines((event.target as HTMLInputElement).checked),
    );
    part("path").addEventListener("change", (event) => {
      this.stage.shown.path = (event.target as HTMLInputElement).checked;
      this.stage.refresh();
    });
    part("copy").hidden = !LINKED;
    part("copy").addEventListener("click", () => void this.copy());
    part("theme").addEventListener("click", () => this.setTheme());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolor());
    addEventListener("hashchange", () => this.goBack());
    for (const button of document.querySelectorAll<HTMLElement>("[data-save]")) {
      button.addEventListener("click", () => this.save(button.dataset.save ?? ""));
    }
    document.querySelector<HTMLInputElement>("[data-open]")?.addEventListener("change", (event) => {
      void this.take((event.target as HTMLInputElement).files?.[0]);
    });
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      void this.take(event.dataTransfer?.files[0]);
    });
  }

  private goTo(name: string): void {
    const gait = this.robot.gaits.find((known) => known.name === name);
    if (gait !== undefined) this.go(rowOf(gait));
  }

  /** Follow a link of the same page. */
  private goBack(): void {
    const address = hash.read(location.hash);
    if (address.robot !== undefined) void this.choose(address.robot, address);
  }

  private async copy(): Promise<void> {
    const button = part("copy");
    this.write();
    try {
      await navigator.clipboard.writeText(location.href);
      button.textContent = "Copied";
    } catch {
      this.say(`This browser copies nothing for a page: the link is ${location.href}`);
    }
    setTimeout(() => {
      button.textContent = "Copy link";
    }, 1500);
  }

  private setTheme(): void {
    const root = document.documentElement;
    const dark = root.dataset.theme
      ? root.dataset.theme === "dark"
      : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    this.recolor();
  }

  private recolor(): void {
    this.stage.refresh();
    this.views.refresh();
  }

  // --- files

  private save(kind: string): void {
    const { robot } = this;
    const gait = gaitOf(this.row);
    if (kind === "toml") saveText(gaitToml(robot, gait), `${robot.robot}-gait.toml`);
    if (kind === "csv") saveText(beatTable(robot, this.path), `${robot.robot}-beat.csv`);
    if (kind === "png") {
      const { speed } = this.values;
      const text = `${robot.robot}, ${words.gaitText(gait)}: ${words.digits(speed)} m/s`;
      savePicture(part<HTMLCanvasElement>("stage"), text, `${robot.robot}.png`);
    }
  }

  /** Open a robot image that was dropped or chosen. */
  private async take(file: File | undefined): Promise<void> {
    if (file === undefined) return;
    this.say("");
    try {
      if (file.size > MAX_IMAGE) throw new Error("it is too large for a robot image");
      const image = new Uint8Array(await file.arrayBuffer());
      const { text } = await this.live.ask({ kind: "load", robot: `${file.name} `, image });
      const robot = robotOf(text);
      const name = this.robots.has(robot.robot) ? `${robot.robot} (${file.name})` : robot.robot;
      this.robots.set(name, { image: async () => image });
      this.listRobots();
      await this.choose(name);
    } catch (error) {
      this.say(`${file.name}: ${(error as Error).message}. \`hypertuna robot image NAME -o FILE\` writes one.`);
    }
  }
}

interface Start {
  robot?: string;
  gait?: { frequency: number; amplitude: number[]; phase: number[]; bias?: number[] };
}

function fromStart(start: Start): Partial<hash.Address> {
  const { robot, gait } = start;
  return {
    ...(robot === undefined ? {} : { robot }),
    ...(gait === undefined ? {} : { gait: { ...gait, bias: gait.bias ?? gait.amplitude.map(() => 0) } }),
  };
}

/** A gait in the middle of the knobs, for a robot without gaits. */
function middle(parameters: Parameter[]): ReturnType<typeof gaitOf> {
  return gaitOf(
    parameters.map(({ kind, range: [low, high], size }) => (kind === "bias" ? 0 : ((low + high) / 2) * size)),
  );
}

function tile({ name, label, unit }: words.Meaning): HTMLElement {
  const box = element("div");
  const number = element("dt");
  number.dataset.quantity = name;
  const text = element("dd", "", label);
  if (unit !== "") text.append(" ", element("span", "unit", `[${unit}]`));
  if (name === "speed") {
    const second = element("span", "second");
    second.id = "speed_bl";
    text.append(second);
  }
  box.append(number, text);
  return box;
}

/** Say in a sentence why there is no fish. */
function cannot(sentence: string): void {
  const box = part("alert");
  box.textContent = sentence;
  box.hidden = false;
  document.documentElement.dataset.busy = "0";
}

async function main(): Promise<void> {
  if (window.parent !== window) document.documentElement.dataset.framed = "1";
  if (typeof WebAssembly !== "object" || typeof DecompressionStream !== "function") {
    cannot(
      "The studio computes with WebAssembly, which this browser does not have or does not allow: a browser of 2023 or later shows it.",
    );
    return;
  }
  if (!WebAssembly.validate(new Uint8Array(SIMD))) {
    cannot(
      "The studio computes with the vector instructions of WebAssembly (SIMD), which this browser does not have: a browser of 2023 or later shows it.",
    );
    return;
  }
  try {
    const module = await WebAssembly.compile(await packedBytes(part("core").textContent ?? ""));
    await new Studio(module).open(JSON.parse(part("robots").textContent ?? ""));
  } catch (error) {
    cannot(`The studio could not start: ${(error as Error).message}.`);
  }
}

void main();
