// The tabs and views below the fish, of which one is shown; a new view is an entry of VIEWS.
import { BodyView } from "./bodyview.ts";
import { element, part } from "./dom.ts";
import { FrontView } from "./front.ts";
import { InsideView } from "./inside.ts";
import { MapView } from "./map.ts";
import type { Quantities } from "./quantities.ts";
import { type Calculator, Latest } from "./questions.ts";
import { parametersOf, type Robot } from "./robot.ts";
import type { ImageLoader } from "./robots.ts";
import { Follower, Samples } from "./samples.ts";
import { SeaView } from "./sea.ts";
import { type Another, type Kept, type Page, Subject, type View } from "./subject.ts";
import { TourView } from "./tour.ts";

/** Name of the view, title of its tab, and function that makes the view in its tabPanel. */
const VIEWS: [string, string, (panel: HTMLElement, page: Page, another: Another) => View][] = [
  ["map", "Map", (panel, page) => new MapView(panel, page)],
  ["front", "Cost over speed", (panel, page) => new FrontView(panel, page)],
  ["body", "Body", (panel, page) => new BodyView(panel, page)],
  ["paper", "Published gaits", (panel, page) => new TourView(panel, page)],
  ["inside", "Inside", (panel, _, another) => new InsideView(panel, another)],
  ["sea", "Sea", (panel, page, another) => new SeaView(panel, page, another)],
  ["about", "About", () => ({})],
];

interface Tab {
  name: string;
  button: HTMLElement;
  panel: HTMLElement;
  view: View;
}

export class Views {
  private readonly tabs: Tab[];
  private chosen: Tab;
  private image: (robot: Robot) => ImageLoader = () => async () => new Uint8Array();
  private row: Float64Array = new Float64Array();
  private readonly samples: Samples;
  private readonly follower: Follower;
  private subject: Subject | null = null;
  private readonly latest = new Latest();

  /** The views compute with `calculator`, beside the knobs' own. */
  constructor(
    private readonly page: Page,
    private readonly calculator: Calculator,
  ) {
    this.samples = new Samples(calculator.another(), (robot) => this.image(robot));
    this.follower = new Follower(this.samples, (spread) => {
      for (const { view } of this.tabs) view.certain?.(spread);
      page.certain(spread);
    });
    this.tabs = VIEWS.map(([name, title, make]) => {
      const [button, panel] = tabPanel(name, title);
      return { name, button, panel, view: make(panel, page, (robot) => this.another(robot)) };
    });
    this.chosen = this.tabs[0] as Tab;
    for (const tab of this.tabs) tab.button.addEventListener("click", () => this.choose(tab));
    part("views").addEventListener("keydown", (event) => this.press(event));
    this.show();
  }

  /** Name of the view that is shown. */
  get view(): string {
    return this.chosen.name;
  }

  /** Whether another view than the first is shown. */
  get moved(): boolean {
    return this.chosen !== this.tabs[0];
  }

  /** Show the view of an address, with its values; an unknown name is ignored. */
  restore(name: string, kept: Kept): void {
    for (const { view } of this.tabs) view.restore?.(kept);
    this.chosen = this.tabs.find((tab) => tab.name === name) ?? this.chosen;
    this.show();
  }

  /** The values of all views that the address keeps. */
  get kept(): Kept {
    return Object.assign({}, ...this.tabs.map(({ view }) => view.kept?.()));
  }

  /** Give the views another robot or model. */
  async about(robot: Robot, model: number, image: (robot: Robot) => ImageLoader): Promise<void> {
    const { calculator, samples } = this;
    this.image = image;
    for (const { view } of this.tabs) view.turnTo?.(robot);
    const both = [...new Set([robot, robot.described ?? robot])];
    const loaded = await this.latest.of(Promise.all(both.map((one) => calculator.load(one.key, image(one)))));
    if (loaded === null) return;
    const parameters = parametersOf(robot);
    const subjects = both.map((one) => new Subject(one, parameters, model, calculator, samples));
    const [subject, described = subject] = subjects as [Subject, Subject?];
    this.subject = subject;
    await Promise.all(this.tabs.map(({ view }) => view.about?.(subject, described)));
    this.follow();
  }

  private follow(): void {
    const { subject, row } = this;
    if (subject !== null && row.length === subject.parameters.length)
      void this.follower.request(subject.robot, subject.model, row);
  }

  /** Give the views a body while it is being changed. */
  shape(robot: Robot): void {
    for (const { view } of this.tabs) view.shape?.(robot);
  }

  /** Give the views the knobs' gait at once: a search must not undo a turn of a knob while quantities are computed. */
  set(row: Float64Array): void {
    for (const { view } of this.tabs) view.set?.(row);
  }

  /** Give the views the knobs' gait with its quantities. */
  at(row: Float64Array, values: Quantities): void {
    this.row = row;
    for (const { view } of this.tabs) view.at?.(row, values);
    this.follow();
  }

  /** Show a log of a mission. */
  log(name: string, content: Uint8Array): void {
    const tab = this.tabs.find(({ view }) => view.open);
    if (tab === undefined) return;
    this.choose(tab);
    tab.view.open?.(name, content);
  }

  /** Draw again, in the colors of the page's theme. */
  refresh(): void {
    for (const { view } of this.tabs) view.refresh?.();
  }

  private async another(robot: Robot): Promise<Calculator> {
    const calculator = this.calculator.another();
    await calculator.load(robot.key, this.image(robot));
    return calculator;
  }

  /** The chart of the shown view, as SVG text; null if it has none. */
  svg(title: string): string | null {
    return this.chosen.view.svg?.(title) ?? null;
  }

  private choose(tab: Tab): void {
    this.chosen = tab;
    this.show();
    this.page.changed();
    // scroll to a view that lies below the window
    if (part("views").getBoundingClientRect().top > 0.4 * innerHeight) part("views").scrollIntoView();
  }

  private show(): void {
    for (const tab of this.tabs) {
      const shown = tab === this.chosen;
      tab.panel.hidden = !shown;
      tab.button.setAttribute("aria-selected", String(shown));
      tab.button.tabIndex = shown ? 0 : -1;
    }
    this.refresh();
    this.chosen.view.show?.();
  }

  /** Arrow keys choose the tab before or after. */
  private press(event: KeyboardEvent): void {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (way === undefined || (event.target as HTMLElement).getAttribute("role") !== "tab") return;
    const next = this.tabs.at((this.tabs.indexOf(this.chosen) + way) % this.tabs.length) ?? this.chosen;
    this.choose(next);
    next.button.focus();
  }
}

/** Make the tab of a view and its tabPanel; the tabPanel is the page's element of this name if it has one. */
function tabPanel(name: string, title: string): [HTMLElement, HTMLElement] {
  const button = element("button", "", title);
  Object.assign(button, { type: "button", role: "tab", id: `tab-${name}` });
  button.setAttribute("aria-controls", name);
  button.dataset.view = name;
  const panel = document.getElementById(name) ?? element("div");
  Object.assign(panel, { id: name, role: "tabpanel" });
  panel.setAttribute("aria-labelledby", button.id);
  part("tabs").append(button);
  part("views").append(panel);
  return [button, panel];
}
