// Shows the quantities of a beat, its status in words, and the command that swims it.
import type { Meaning } from "./core.ts";
import { element, part } from "./dom.ts";
import * as words from "./quantities.ts";
import { gaitOf, type Robot } from "./robot.ts";
import { type Spread, spreadWords } from "./samples.ts";

export class Results {
  private readonly note = element("p", "caption");
  private values: words.Quantities = {};
  private spread: Spread | null = null;

  constructor() {
    part("facts").replaceChildren(...words.SUMMARY.map(tile));
    part("facts").after(this.note);
    this.note.hidden = true;
  }

  /** Show the quantities of a gait that were computed with model `model` of the robot. */
  show(robot: Robot, model: number, row: Float64Array, values: words.Quantities): void {
    const gait = gaitOf(row);
    const turning = words.turns(values, robot);
    for (const { name } of words.SUMMARY) {
      const box = part("facts").querySelector<HTMLElement>(`[data-quantity="${name}"]`);
      if (box === null) continue;
      box.dataset.value = String(values[name]);
      box.textContent = words.digits(values[name]);
      const tile = box.closest("div");
      if (tile !== null) tile.hidden = name.startsWith("turn_") && !turning;
    }
    part("speed_bl").textContent = `${words.digits(values.speed_bl)} BL/s`;
    const body = robot.factors === undefined ? "" : ", changed body";
    part("swum").textContent = `${robot.robot}${body}, ${words.gaitText(gait)}${words.backward(values)}`;
    part("command").textContent = words.command(robot, robot.models[model] ?? { water: "", joints: "" }, gait);
    this.say(values, gait.frequency, "");
    this.values = values;
    this.showIntervals();
  }

  /** Add to the status where the start from rest leads. */
  fromRest(row: Float64Array, values: words.Quantities): void {
    this.say(values, row[0] ?? 1, words.fromRest(values));
  }

  /** Show the intervals in which most samples lie; null hides them. */
  certain(spread: Spread | null): void {
    this.spread = spread;
    this.showIntervals();
  }

  private showIntervals(): void {
    const estimates = this.spread?.of === "estimates";
    const spread = estimates && words.statusOf(this.values) !== "settled" ? null : this.spread;
    let band = ""; // interval of the speed by the estimates
    for (const box of part("facts").querySelectorAll<HTMLElement>("[data-interval]")) {
      const [low, high] = spread?.intervals[box.dataset.interval ?? ""] ?? [Number.NaN, Number.NaN];
      box.hidden = Number.isNaN(low) || Number.isNaN(high);
      [box.dataset.low, box.dataset.high] = [String(low), String(high)];
      const ends = [words.digits(low, 3), words.digits(high, 3)];
      box.textContent = ends.join(" – ");
      if (estimates && !box.hidden) band = ` (${ends.join(" to ")} by the estimates)`;
    }
    const [speed, ...others] = words.MAIN.map(
      (name) => `${words.digits(this.values[name], 3)} ${words.meaning(name).unit}`,
    );
    part("numbers").textContent = [`${speed}${band}`, ...others].join(" · ");
    this.note.hidden = spread === null;
    this.note.textContent = spread === null ? "" : `Small number${estimates ? "" : "s"}: ${spreadWords(spread)}.`;
  }

  private say(values: words.Quantities, frequency: number, more: string): void {
    const box = part("status");
    box.textContent = words.verdict(values, frequency) + more;
    box.dataset.status = words.statusOf(values);
  }
}

function tile({ name, label, unit }: Meaning): HTMLElement {
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
  const interval = element("span", "second interval");
  interval.dataset.interval = name;
  interval.hidden = true;
  if (words.MAIN.includes(name)) text.append(interval);
  box.append(number, text);
  return box;
}
