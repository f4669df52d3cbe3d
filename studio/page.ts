// The page: it keeps the present choice and updates everything that depends on it.
import { Beats } from "./beats.ts";
import { type Factors, known } from "./changes.ts";
import { Choices, type Model } from "./choices.ts";
import { Core, POSE } from "./core.ts";
import { closeOutside, part, say } from "./dom.ts";
import { packedBytes, plainBytes } from "./files.ts";
import { Stage } from "./fish.ts";
import * as hash from "./hash.ts";
import { Knobs } from "./knobs.ts";
import { Beat } from "./motion.ts";
import * as words from "./quantities.ts";
import { Calculator, Latest } from "./questions.ts";
import { Results } from "./results.ts";
import { type Gait, gaitOf, modelOf, type Parameter, parametersOf, type Robot, rowOf } from "./robot.ts";
import { Robots } from "./robots.ts";
import { Saves, type Shown } from "./saves.ts";
import type { Spread } from "./samples.ts";
import { Views } from "./views.ts";

declare const WORKER: string; // script of the worker

// Bytes of a WebAssembly module with one vector instruction: only a browser with SIMD validates it.
const SIMD_PROBE = [
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
];
const ADDRESS_DELAY = 100; // ms from a change to its entry in the address: browsers allow few updates a second
const BODY_DELAY = 150; // ms from a changed body to the update of the map and the other views
const HAS_ADDRESS = location.protocol !== "about:"; // a frame inside a document has no address

/** Data that the page comes with: robots, and the choice to begin with. */
interface Given {
  robots: { name: string; image: string }[];
  start: { robot?: string; gait?: Omit<Gait, "bias"> & { bias?: number[] }; ledger?: string };
}

class Studio {
  private readonly stage = new Stage(part<HTMLCanvasElement>("stage"));
  private readonly knobs = new Knobs(part("knobs"), (index, value) => this.turn(index, value));
  private readonly results = new Results();
  private readonly choices: Choices;
  private readonly views: Views;
  private readonly beats: Beats;
  private robot!: Robot;
  private row: Float64Array = new Float64Array();
  private model = 0;
  private of = "speed"; // quantity whose gradient is shown
  private values: words.Quantities = {};
  private path: Float64Array = new Float64Array();
  private kept = 0; // timer of the address's update
  private shaped = 0; // timer of the update after a changed body
  private readonly latest = new Latest();

  constructor(
    private readonly robots: Robots,
    private readonly live: Calculator,
  ) {
    const page = {
      go: (row: Float64Array) => this.go(row),
      changed: () => this.keep(),
      body: (factors: Factors) => this.setBody(factors),
      certain: (spread: Spread | null) => this.results.certain(spread),
      robot: async (name: string) => (robots.has(name) ? robots.read(name, live) : null),
    };
    this.views = new Views(page, live.another());
    this.choices = new Choices({
      robot: (name) => void this.choose(name),
      gait: (name) => this.goTo(name),
      quantity: (name) => this.setQuantity(name),
      model: (model) => this.setModel(model),
      tempo: (tempo) => this.setTempo(tempo),
      midlines: (shown) => this.setMidlines(shown),
      path: (shown) => this.stage.show({ path: shown }),
    });
    this.beats = new Beats(live, live.another(), {
      numbers: ({ gait }, quantities) => this.showNumbers(gait, words.named(quantities)),
      path: ({ gait }, path) => this.showPath(gait, path),
      gradient: (derivatives) => this.showGradient(derivatives),
      fromRest: (quantities) => this.results.fromRest(this.row, words.named(quantities)),
    });
    const now = (): Shown => ({ robot: this.robot, row: this.row, values: this.values, path: this.path });
    new Saves(this.stage, this.views, now, say);
    this.listen();
  }

  /** Show the robot and the choice of an address; the first robot if it names none. */
  async open(address: Partial<hash.Address>): Promise<void> {
    const { robot, of } = address;
    const { derivatives } = words.core;
    if (of !== undefined && derivatives.includes(of)) this.of = of;
    this.choices.quantities(derivatives, this.of);
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.setTempo(address.tempo ?? (still ? 0 : 1));
    this.setMidlines(still);
    this.views.restore(address.view ?? "", address.kept ?? {});
    const known = this.robots.has(robot);
    if (robot !== undefined && !known)
      say(`The link names the robot "${robot}", which this page does not have: drop its image here to see it.`);
    await this.choose(known ? robot : (this.robots.names[0] ?? ""), address);
    if (this.views.moved) part("views").scrollIntoView(); // the link names a view
  }

  // --- what is chosen

  private async choose(name: string, address: Partial<hash.Address> = {}): Promise<void> {
    if (!this.robots.has(name)) return;
    const robot = await this.latest.of(this.robots.read(name, this.live));
    if (robot === null) return;
    this.robot = this.robots.changed(robot, known(robot, address.body ?? {}));
    this.model = Math.max(0, modelOf(this.robot, address.water ?? "", address.joints ?? ""));
    const parameters = parametersOf(this.robot);
    const given = address.gait && rowOf(address.gait);
    const fits = given?.length === parameters.length;
    if (given !== undefined && !fits) say(`The link's gait does not fit ${name}: its own first gait is shown.`);
    const first = this.robot.gaits[0];
    this.row = given !== undefined && fits ? given : first ? rowOf(first) : middle(parameters);
    this.layOut(parameters);
    this.changed();
    await this.inform();
  }

  private turn(index: number, value: number): void {
    this.row = this.row.slice();
    this.row[index] = value;
    this.changed();
  }

  private go(row: Float64Array): void {
    this.row = row.slice();
    this.changed();
  }

  private goTo(name: string): void {
    const gait = this.robot.gaits.find((known) => known.name === name);
    if (gait !== undefined) this.go(rowOf(gait));
  }

  private changed(): void {
    this.knobs.show(this.row);
    this.views.set(this.row);
    this.keep();
    void this.beats.request(
      { robot: this.robot.key, model: this.model, gait: this.row },
      this.robots.image(this.robot),
    );
  }

  private setBody(factors: Factors): void {
    this.robot = this.robots.changed(this.robot, factors);
    this.views.shape(this.robot);
    this.changed();
    clearTimeout(this.shaped);
    this.shaped = window.setTimeout(() => void this.inform(), BODY_DELAY);
  }

  private setModel(model: Model): void {
    this.model = Math.max(0, modelOf(this.robot, model.water, model.joints));
    this.choices.models(this.robot, model);
    this.changed();
    void this.inform();
  }

  private setQuantity(name: string): void {
    this.of = name;
    this.changed();
    void this.inform();
  }

  private setTempo(tempo: number): void {
    this.stage.show({ tempo });
    this.choices.tempo(tempo);
    if (this.robot !== undefined) this.keep();
  }

  private setMidlines(midlines: boolean): void {
    this.stage.show({ midlines });
    this.choices.midlines(midlines);
  }

  /** Tell the views the robot, the model and the gait. */
  private async inform(): Promise<void> {
    await this.views.about(this.robot, this.model, (robot) => this.robots.image(robot));
    this.views.at(this.row, this.values);
  }

  // --- the address

  /** Write the present choice to the address, soon. */
  private keep(): void {
    clearTimeout(this.kept);
    this.kept = window.setTimeout(() => this.write(), ADDRESS_DELAY);
  }

  private write(): void {
    clearTimeout(this.kept);
    const { robot, of } = this;
    const { view, kept } = this.views;
    const model = robot.models[this.model] ?? { water: "", joints: "" };
    const shown = { of, view, tempo: this.stage.shown.tempo, kept };
    const address = { robot: robot.robot, gait: gaitOf(this.row), ...model, ...shown, body: robot.factors ?? {} };
    if (HAS_ADDRESS) history.replaceState(null, "", hash.written(address));
  }

  /** Follow a link within the page. */
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
      say(`This browser copies nothing for a page: the link is ${location.href}`);
    }
    setTimeout(() => {
      button.textContent = "Copy link";
    }, 1500);
  }

  // --- what is shown

  private layOut(parameters: Parameter[]): void {
    const { robot } = this;
    this.views.shape(robot);
    this.choices.robots(this.robots.names, robot.robot);
    this.choices.gaits(robot.gaits.map(({ name }) => name));
    this.choices.models(robot, robot.models[this.model] ?? { water: "", joints: "" });
    this.knobs.layOut(parameters);
    this.results.certain(null); // remove the intervals of the robot before
    const fit = robot.fit === null ? "" : ` Its coefficients are a fit: ${robot.fit}.`;
    part("made").textContent = `${robot.description}.${fit} Its image was written by ${robot.made_by}.`;
    part("robot").title = robot.description + fit;
  }

  private showNumbers(row: Float64Array, values: words.Quantities): void {
    this.values = values;
    this.results.show(this.robot, this.model, row, values);
    this.choices.gait(this.robot, row);
    this.views.at(row, values);
  }

  private showPath(row: Float64Array, path: Float64Array): void {
    this.path = path;
    if (path.every(Number.isFinite)) {
      const straight = !words.turns(this.values, this.robot);
      this.stage.swim(this.robot, new Beat(path, POSE + this.robot.links.length, row[0] ?? 1, straight));
    }
    if (document.documentElement.dataset.ready === "1") return;
    document.documentElement.dataset.ready = "1";
    performance.mark("first-fish");
  }

  private showGradient(derivatives: Float64Array): void {
    this.knobs.gradient(words.ratesOf(derivatives, this.of), words.meaning(this.of).unit);
  }

  private recolor(): void {
    this.stage.refresh();
    this.views.refresh();
  }

  // --- events

  private listen(): void {
    part("copy").hidden = !HAS_ADDRESS;
    part("copy").addEventListener("click", () => void this.copy());
    part("theme").addEventListener("click", () => {
      const { dataset } = document.documentElement;
      dataset.theme = dataset.theme === "dark" ? "light" : "dark";
      dataset.chosen = "";
    });
    new MutationObserver(() => this.recolor()).observe(document.documentElement, { attributeFilter: ["data-theme"] });
    addEventListener("hashchange", () => this.goBack());
    closeOutside(document.querySelector<HTMLDetailsElement>(".menu"));
    document.querySelector<HTMLInputElement>("[data-open]")?.addEventListener("change", (event) => {
      void this.take((event.target as HTMLInputElement).files?.[0]);
    });
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      void this.take(event.dataTransfer?.files[0]);
    });
  }

  // --- files

  /** Open a robot image or a log that was dropped or chosen. */
  async take(file: File | undefined): Promise<void> {
    if (file === undefined) return;
    say("");
    try {
      if (/\.mcap$/i.test(file.name)) return this.views.log(file.name, new Uint8Array(await file.arrayBuffer()));
      await this.choose(await this.robots.open(file, this.live));
    } catch (error) {
      const fix = /\.toml$/i.test(file.name)
        ? `A robot's file opens by \`hypertuna studio ${file.name}\`.`
        : "`hypertuna robot image NAME -o FILE` writes one.";
      say(`${file.name}: ${(error as Error).message}. ${fix}`);
    }
  }
}

/** The choice that the page begins with, in the form of an address. */
function fromStart({ robot, gait }: Given["start"]): Partial<hash.Address> {
  return {
    ...(robot === undefined ? {} : { robot }),
    ...(gait === undefined ? {} : { gait: { ...gait, bias: gait.bias ?? gait.amplitude.map(() => 0) } }),
  };
}

/** A gait with each knob in the middle of its range, for a robot without named gaits. */
function middle(parameters: Parameter[]): Float64Array {
  return Float64Array.from(parameters, ({ kind, range: [low, high], size }) =>
    kind === "bias" ? 0 : ((low + high) / 2) * size,
  );
}

/** A sentence on why this browser cannot run the studio; "" if it can. */
function unfit(): string {
  if (typeof WebAssembly !== "object" || typeof DecompressionStream !== "function")
    return "The studio computes with WebAssembly, which this browser does not have or does not allow: a browser of 2023 or later shows it.";
  if (!WebAssembly.validate(new Uint8Array(SIMD_PROBE)))
    return "The studio computes with the vector instructions of WebAssembly (SIMD), which this browser does not have: a browser of 2023 or later shows it.";
  return "";
}

async function open(): Promise<void> {
  const given = JSON.parse(part("robots").textContent ?? "") as Given;
  const { ledger } = given.start; // address of the ledger's page, for links
  if (ledger !== undefined) document.documentElement.dataset.ledger = ledger;
  const script = URL.createObjectURL(new Blob([WORKER], { type: "text/javascript" }));
  const module = await WebAssembly.compile(await packedBytes(part("core").textContent ?? ""));
  words.learn(await Core.start(module));
  const studio = new Studio(new Robots(given.robots), new Calculator(script, module));
  await studio.open({ ...fromStart(given.start), ...hash.read(location.hash) });
  const log = document.getElementById("log"); // a log that the page contains
  if (log === null) return;
  await studio.take(new File([plainBytes(log.textContent ?? "")], log.dataset.name ?? "log.mcap"));
  part("views").scrollIntoView();
}

async function main(): Promise<void> {
  let sentence = unfit();
  if (sentence === "")
    await open().catch((error: Error) => {
      sentence = `The studio could not start: ${error.message}.`;
    });
  if (sentence === "") return;
  say(sentence);
  document.documentElement.dataset.busy = "0";
}

void main();
