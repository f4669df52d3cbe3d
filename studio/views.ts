// The views below the fish: a map, cost over speed, published gaits; one is shown at a time.
import { FrontView } from "./front.ts";
import { InsideView } from "./inside.ts";
import { MapView } from "./map.ts";
import type { Quantities } from "./quantities.ts";
import type { Calculator } from "./questions.ts";
import { type Parameter, parametersOf, type Robot } from "./robot.ts";
import { type Page, Subject } from "./subject.ts";
import { TourView } from "./tour.ts";

const NAMES = ["map", "front", "paper", "inside", "about"];

export class Views {
  view = "map";
  readonly map: MapView;
  private readonly front: FrontView;
  private readonly tour: TourView;
  private readonly inside: InsideView;
  private calculator: Calculator | null = null;
  private names: { quantities: string[]; derivatives: string[] } = { quantities: [], derivatives: [] };
  private more: (() => Promise<Calculator>) | null = null; // makes another worker
  private image: () => Promise<Uint8Array> = async () => new Uint8Array();
  private readonly loaded = new Set<string>();
  private row: Float64Array = new Float64Array();

  constructor(private readonly page: Page) {
    this.map = new MapView(room("map"), page);
    this.front = new FrontView(room("front"), page);
    this.tour = new TourView(room("paper"), page);
    this.inside = new InsideView(room("inside"), (robot) => this.another(robot));
    for (const name of NAMES) tab(name).addEventListener("click", () => this.choose(name));
    room("views").addEventListener("keydown", (event) => this.press(event));
    this.show();
  }

  /** Compute from now on, beside the knobs. */
  start(
    calculator: Calculator,
    names: { quantities: string[]; derivatives: string[] },
    more: () => Promise<Calculator>,
  ): void {
    [this.calculator, this.names, this.more] = [calculator, names, more];
  }

  /** Show a view; one that does not exist is left out. */
  restore(view: string): void {
    if (NAMES.includes(view)) this.view = view;
    this.show();
  }

  /** Turn to a robot and a model. */
  async about(robot: Robot, model: number, image: () => Promise<Uint8Array>): Promise<void> {
    const { calculator } = this;
    if (calculator === null) return;
    this.image = image;
    this.inside.about(robot);
    if (!this.loaded.has(robot.robot)) {
      await calculator.ask({ kind: "load", robot: robot.robot, image: await image() });
      this.loaded.add(robot.robot);
    }
    const parameters: Parameter[] = parametersOf(robot);
    const subject = new Subject(robot, parameters, model, calculator, this.names);
    this.map.about(subject);
    await Promise.all([this.front.about(subject), this.tour.about(subject)]);
    this.tour.at(this.row);
  }

  /** Follow the knobs. */
  at(row: Float64Array, values: Quantities): void {
    this.row = row;
    this.map.at(row);
    this.front.at(row, values);
    this.tour.at(row);
    this.inside.at(row);
  }

  /** Draw again, in the colors of the page's theme. */
  refresh(): void {
    this.map.refresh();
    this.front.refresh();
  }

  /** A worker of its own for the twin, with a robot. */
  private async another(robot: Robot): Promise<Calculator> {
    if (this.more === null) throw new Error("the page has not started");
    const calculator = await this.more();
    await calculator.ask({ kind: "load", robot: robot.robot, image: await this.image() });
    return calculator;
  }

  private choose(name: string): void {
    this.view = name;
    this.show();
    this.page.changed();
  }

  private show(): void {
    for (const name of NAMES) {
      const shown = name === this.view;
      room(name).hidden = !shown;
      tab(name).setAttribute("aria-selected", String(shown));
      tab(name).tabIndex = shown ? 0 : -1;
    }
    this.refresh();
    this.map.renew();
  }

  /** Arrow keys go from tab to tab. */
  private press(event: KeyboardEvent): void {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (way === undefined || (event.target as HTMLElement).getAttribute("role") !== "tab") return;
    const next = NAMES[(NAMES.indexOf(this.view) + way + NAMES.length) % NAMES.length] ?? "map";
    this.choose(next);
    tab(next).focus();
  }
}

function room(id: string): HTMLElement {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no ${id}`);
  return found;
}

const tab = (name: string): HTMLElement => room(`tab-${name}`);
