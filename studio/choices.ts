// The choices beside the knobs: robot, gait, model, quantity of the gradient, tempo.
import { button, element, part } from "./dom.ts";
import { meaning } from "./quantities.ts";
import { type Robot, rowOf } from "./robot.ts";

export interface Model {
  water: string;
  joints: string;
}

/** Handlers, called when a choice changes. */
export interface Chosen {
  robot(name: string): void;
  gait(name: string): void;
  quantity(name: string): void;
  model(model: Model): void;
  tempo(tempo: number): void;
  midlines(shown: boolean): void;
  path(shown: boolean): void;
}

export class Choices {
  constructor(private readonly chosen: Chosen) {
    const listen = (id: string, tell: (value: string) => void): void =>
      part(id).addEventListener("change", (event) => tell((event.target as HTMLSelectElement).value));
    listen("robot", (name) => chosen.robot(name));
    listen("gait", (name) => chosen.gait(name));
    listen("of", (name) => chosen.quantity(name));
    part("tempo").addEventListener("click", (event) => {
      const { tempo } = (event.target as HTMLElement).dataset;
      if (tempo !== undefined) chosen.tempo(Number(tempo));
    });
    for (const name of ["midlines", "path"] as const) {
      const box = part<HTMLInputElement>(name);
      box.addEventListener("change", () => chosen[name](box.checked));
    }
  }

  quantities(names: string[], now: string): void {
    const list = part<HTMLSelectElement>("of");
    list.replaceChildren(...names.map((name) => new Option(meaning(name).label, name)));
    list.value = now;
  }

  robots(names: string[], now: string): void {
    list("robot", names).value = now;
  }

  gaits(names: string[]): void {
    const own = new Option("custom", "");
    own.hidden = true;
    list("gait", names).prepend(own);
  }

  /** Select the named gait that the knobs have, or "custom" where none fits. */
  gait(robot: Robot, row: Float64Array): void {
    const known = robot.gaits.find((gait) => rowOf(gait).every((value, k) => Math.abs(value - (row[k] ?? 0)) < 1e-9));
    part<HTMLSelectElement>("gait").value = known?.name ?? "";
  }

  models(robot: Robot, now: Model): void {
    for (const kind of ["water", "joints"] as const) {
      const names = [...new Set(robot.models.map((model) => model[kind]))];
      const buttons = names.map((name) => {
        const choice = button(name, () => this.chosen.model({ ...now, [kind]: name }));
        choice.dataset[kind] = name;
        choice.setAttribute("aria-pressed", String(now[kind] === name));
        return choice;
      });
      part(kind).replaceChildren(element("legend", "", kind === "water" ? "water law" : "joints"), ...buttons);
    }
  }

  tempo(now: number): void {
    for (const button of part("tempo").querySelectorAll<HTMLElement>("[data-tempo]")) {
      button.setAttribute("aria-pressed", String(Number(button.dataset.tempo) === now));
    }
  }

  midlines(shown: boolean): void {
    part<HTMLInputElement>("midlines").checked = shown;
  }
}

function list(id: string, names: string[]): HTMLSelectElement {
  const found = part<HTMLSelectElement>(id);
  found.replaceChildren(...names.map((name) => new Option(name, name)));
  return found;
}
