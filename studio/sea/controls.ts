// The choices of the Sea view: mission and seed, a log, colors of the track, camera.
import { button, element, labeled, selection } from "../dom.ts";
import { BY, type By } from "./colors.ts";
import type { Mission } from "./flight.ts";
import { type Sight, STRETCHES } from "./picture.ts";

const MAX_SEED = 2 ** 32 - 1;
const LOG = "log"; // value of the log's entry in the list of missions
const ZOOM_FACTOR = 1.4; // zoom factor of a button

/** Handlers, called when a choice changes. */
export interface Handlers {
  mission(place: number, seed: number): void;
  log(): void; // the open log is chosen again
  file(file: File): void;
  by(by: By): void;
  sight(sight: Sight): void;
  zoom(by: number): void;
  stretch(times: number): void;
}

export class Controls {
  readonly element = element("div", "row left");
  private readonly missions = element("select");
  private readonly seed = element("input");
  private readonly sights = element("div", "switch");
  private readonly stretch = selection(
    STRETCHES.map((times) => [`x ${times}`, times]),
    1,
    (times) => this.heard.stretch(Number(times)),
  );

  /** `space`: whether the picture is three-dimensional, with cameras to choose. */
  constructor(
    private readonly heard: Handlers,
    space: boolean,
  ) {
    const { missions, seed } = this;
    missions.addEventListener("change", () => this.pick());
    Object.assign(seed, { type: "number", min: "0", step: "1", value: "0" });
    seed.title = "0: the mission as it stands; others scatter current and satellites";
    seed.addEventListener("change", () => this.pick());
    this.element.append(labeled("mission ", missions), labeled("seed ", seed), this.opener(), this.colors());
    if (space) this.element.append(this.cameras());
  }

  /** List a robot's missions. */
  list(missions: Mission[]): void {
    this.missions.replaceChildren(...missions.map(({ name }, k) => new Option(name, String(k))));
    this.missions.disabled = missions.length === 0;
    this.seed.disabled = missions.length === 0;
  }

  /** Show the mission and the seed that are flown. */
  flown(place: number, seed: number): void {
    this.missions.value = String(place);
    this.seed.value = String(seed);
  }

  /** Add an open log to the list, chosen or not. */
  logged(title: string, chosen: boolean): void {
    for (const option of this.missions.querySelectorAll(`[value="${LOG}"]`)) option.remove();
    this.missions.append(new Option(title, LOG, false, chosen));
    this.missions.disabled = false;
  }

  /** Mark the chosen camera; null if it was moved by hand. */
  seen(sight: Sight | null, stretch: number): void {
    for (const button of this.sights.querySelectorAll("button")) {
      button.setAttribute("aria-pressed", String(button.dataset.sight === sight));
    }
    this.stretch.value = String(stretch);
  }

  private pick(): void {
    const { value } = this.missions;
    const seed = Math.min(MAX_SEED, Math.max(0, Math.floor(this.seed.valueAsNumber || 0)));
    if (value === LOG) this.heard.log();
    else this.heard.mission(Number(value), seed);
  }

  private opener(): HTMLElement {
    const input = element("input");
    Object.assign(input, { type: "file", accept: ".mcap" });
    input.addEventListener("change", () => {
      const [file] = input.files ?? [];
      if (file !== undefined) this.heard.file(file);
      input.value = "";
    });
    const label = element("label", "button", "Open a log …");
    label.append(input);
    return label;
  }

  private colors(): HTMLElement {
    const names = BY.map((name): [string, By] => [name, name]);
    return labeled(
      "track by ",
      selection(names, BY[0], (name) => this.heard.by(name as By)),
    );
  }

  private cameras(): HTMLElement {
    const row = element("div", "row left sea-cameras");
    for (const sight of ["overview", "follow"] as const) {
      const choice = button(sight, () => this.heard.sight(sight));
      choice.dataset.sight = sight;
      this.sights.append(choice);
    }
    this.sights.setAttribute("role", "group");
    this.sights.setAttribute("aria-label", "Camera");
    const zoom = element("div", "switch");
    zoom.setAttribute("role", "group");
    zoom.setAttribute("aria-label", "Zoom");
    for (const [text, name, by] of [
      ["+", "Zoom in", 1 / ZOOM_FACTOR],
      ["−", "Zoom out", ZOOM_FACTOR],
    ] as const) {
      const nearer = button(text, () => this.heard.zoom(by));
      nearer.setAttribute("aria-label", name);
      zoom.append(nearer);
    }
    this.stretch.dataset.depths = "";
    row.append(this.sights, zoom, labeled("vertical scale ", this.stretch));
    return row;
  }
}
