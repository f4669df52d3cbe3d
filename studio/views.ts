// The views below the fish: a map, cost over speed, published gaits; one is shown at a time.
import { BodyView } from "./bodyview.ts";
import { twinFollows } from "./changes.ts";
import { part } from "./dom.ts";
import { FrontView } from "./front.ts";
import { InsideView } from "./inside.ts";
import { MapView } from "./map.ts";
import type { Quantities } from "./quantities.ts";
import type { Calculator, Names } from "./questions.ts";
import { type Parameter, parametersOf, type Robot } from "./robot.ts";
import type { Image } from "./robots.ts";
import { Follower, Samples } from "./samples.ts";
import { SeaView } from "./sea.ts";
import { type Page, Subject } from "./subject.ts";
import { TourView } from "./tour.ts";

const NAMES = ["map", "front", "body", "paper", "inside", "sea", "about"];

export class Views {
  view = "map";
  readonly map: MapView;
  private readonly front: FrontView;
  private readonly tour: TourView;
  private readonly inside: InsideView;
  readonly sea: SeaView;
  private readonly body: BodyView;
  private image: (robot: Robot) => Image = () => async () => new Uint8Array();
  private row: Float64Array = new Float64Array();
  private readonly samples: Samples;
  private readonly follower: Follower;
  private subject: Subject | null = null;

  /** Compute with a calculator of their own, beside the knobs. */
  constructor(
    private readonly page: Page,
    private readonly calculator: Calculator,
    private readonly names: Names,
  ) {
    this.samples = new Samples(calculator.another(), names, (robot) => this.image(robot));
    this.follower = new Follower(this.samples, (spread) => {
      this.front.certain(spread);
      page.certain(spread);
    });
    this.map = new MapView(part("map"), page);
    this.front = new FrontView(part("front"), page);
    this.tour = new TourView(part("paper"), page);
    this.body = new BodyView(part("body"), (factors) => page.body(factors));
    this.inside = new InsideView(part("inside"), (robot) => this.another(robot));
    this.sea = new SeaView(part("sea"), page, (robot) => this.another(robot));
    for (const name of NAMES) tab(name).addEventListener("click", () => this.choose(name));
    part("views").addEventListener("keydown", (event) => this.press(event));
    this.show();
  }

  /** Show a view; one that does not exist is left out. */
  restore(view: string): void {
    if (NAMES.includes(view)) this.view = view;
    this.show();
  }

  /** Turn to a robot and a model. */
  async about(robot: Robot, model: number, image: (robot: Robot) => Image): Promise<void> {
    const { calculator } = this;
    this.image = image;
    const described = robot.described ?? robot;
    this.inside.about(twinFollows(described, robot.factors ?? {}) ? robot : described);
    this.sea.about(described);
    await Promise.all([robot, described].map((one) => calculator.load(one.key, image(one))));
    const parameters: Parameter[] = parametersOf(robot);
    const subject = new Subject(robot, parameters, model, calculator, this.names, this.samples);
    const before =
      robot === described ? subject : new Subject(described, parameters, model, calculator, this.names, this.samples);
    this.body.about(before);
    this.subject = subject;
    this.map.about(subject);
    await Promise.all([this.front.about(subject), this.tour.about(before)]);
    this.tour.at(this.row);
    this.follow();
  }

  private follow(): void {
    const { subject, row } = this;
    if (subject !== null && row.length === subject.parameters.length)
      void this.follower.want(subject.robot, subject.model, row);
  }

  /** Follow a body while it is changed. */
  shape(robot: Robot): void {
    this.body.show(robot);
  }

  /** Take the knobs' gait at once: a search must not turn back what was turned while its numbers were computed. */
  set(row: Float64Array): void {
    this.front.set(row);
  }

  /** Follow the knobs. */
  at(row: Float64Array, values: Quantities): void {
    this.row = row;
    this.map.at(row);
    this.front.show(values);
    this.body.at(row, values);
    this.tour.at(row);
    this.inside.at(row, values);
    this.follow();
  }

  /** Show a log of a mission. */
  log(name: string, content: Uint8Array): void {
    this.choose("sea");
    this.sea.open(name, content);
  }

  /** Draw again, in the colors of the page's theme. */
  refresh(): void {
    this.map.refresh();
    this.front.refresh();
    this.inside.refresh();
    this.sea.refresh();
  }

  /** A calculator of its own for the twin, with a robot. */
  private async another(robot: Robot): Promise<Calculator> {
    const calculator = this.calculator.another();
    await calculator.load(robot.key, this.image(robot));
    return calculator;
  }

  /** The chart that is shown, as SVG; null where the view has none. */
  svg(title: string): string | null {
    return { map: this.map, front: this.front }[this.view]?.svg(title) ?? null;
  }

  private choose(name: string): void {
    this.view = name;
    this.show();
    this.page.changed();
    // a view that lies below the window comes into it
    if (part("views").getBoundingClientRect().top > 0.4 * innerHeight) part("views").scrollIntoView();
  }

  private show(): void {
    for (const name of NAMES) {
      const shown = name === this.view;
      part(name).hidden = !shown;
      tab(name).setAttribute("aria-selected", String(shown));
      tab(name).tabIndex = shown ? 0 : -1;
    }
    this.refresh();
    this.map.renew();
    if (this.view === "sea") this.sea.show();
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

const tab = (name: string): HTMLElement => part(`tab-${name}`);
