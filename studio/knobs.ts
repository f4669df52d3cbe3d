// The knobs: a slider, a number field and the exact gradient for each parameter of a gait.
import { element } from "./dom.ts";
import { digits, plain } from "./quantities.ts";
import type { Parameter, Range } from "./robot.ts";

/** A slider and a number field with a unit, below a label. */
export class Slider {
  readonly row = element("div", "knob");
  readonly range = element("input");
  readonly number = element("input");
  readonly field = element("span", "field");

  constructor(
    id: string,
    label: string,
    private readonly unit: string,
    [low, high]: Range,
    step = "any",
  ) {
    const title = element("label", "", label);
    title.htmlFor = id;
    Object.assign(this.range, { type: "range", id, step, min: String(low), max: String(high) });
    Object.assign(this.number, { type: "number", step: "any", ariaLabel: `${label} [${unit}]` });
    this.field.append(this.number, element("span", "unit", unit));
    this.row.append(title, this.field, this.range);
  }

  /** Set the slider to `place` and the number field to `value`. */
  show(place: number, value: number): void {
    const { range, number } = this;
    const [low, high] = [Number(range.min), Number(range.max)];
    range.value = String(place);
    range.style.setProperty("--at", String((place - low) / (high - low)));
    range.ariaValueText = `${digits(value)} ${this.unit}`;
    if (document.activeElement !== number) number.value = String(Number(value.toPrecision(5)));
  }
}

interface Knob {
  parameter: Parameter;
  slider: Slider;
  gradient: HTMLElement;
}

export class Knobs {
  private knobs: Knob[] = [];

  /** `turned` is called with the index in the gait's row and the new value in SI units. */
  constructor(
    private readonly panel: HTMLElement,
    private readonly turned: (index: number, value: number) => void,
  ) {}

  /** Make the knobs of a robot: those that the optimizer may change first, the others folded. */
  layOut(parameters: Parameter[]): void {
    const open = parameters.filter(({ free, kind }) => free || (kind !== "bias" && kind !== "phase"));
    const folded = parameters.filter((parameter) => !open.includes(parameter));
    this.knobs = [];
    this.panel.replaceChildren(...this.groups(open));
    if (folded.length === 0) return;
    const more = element("details", "more");
    more.append(element("summary", "", "Turn: bias of the joints; phase of the first"), ...this.groups(folded));
    this.panel.append(more);
  }

  /** Show a gait. */
  show(row: ArrayLike<number>): void {
    for (const { parameter, slider } of this.knobs) {
      const value = plain((row[parameter.index] ?? 0) / parameter.size);
      const [low, high] = parameter.range;
      slider.range.min = String(Math.min(low, value));
      slider.range.max = String(Math.max(high, value));
      slider.show(value, value);
    }
    const turned = this.knobs.some(({ parameter }) => parameter.kind === "bias" && (row[parameter.index] ?? 0) !== 0);
    const more = this.panel.querySelector("details");
    if (turned && more !== null) more.open = true;
  }

  /** Show the derivatives of a quantity with respect to each parameter [unit per Hz or rad]. */
  gradient(derivatives: ArrayLike<number>, unit: string): void {
    const reach = this.knobs.map(({ parameter }) => {
      const [low, high] = parameter.range;
      return Math.abs((derivatives[parameter.index] ?? 0) * parameter.size * (high - low));
    });
    const most = Math.max(...reach.filter(Number.isFinite));
    this.knobs.forEach(({ parameter, gradient }, k) => {
      const value = (derivatives[parameter.index] ?? Number.NaN) * parameter.size;
      const noise = !((reach[k] ?? 0) > 1e-9 * most);
      const shown = noise && Number.isFinite(value) ? 0 : value;
      const sign = shown > 0 ? "+" : "";
      gradient.textContent = `${sign}${digits(shown, 3)}${unit === "" ? "" : ` ${unit}`} per ${parameter.unit}`;
      gradient.dataset.way = shown > 0 ? "up" : shown < 0 ? "down" : "none";
    });
  }

  private groups(parameters: Parameter[]): HTMLElement[] {
    return parameters.map((parameter) => this.knob(parameter));
  }

  private knob(parameter: Parameter): HTMLElement {
    const { knob: name, label, unit, limits } = parameter;
    const id = `knob-${name}`;
    const slider = new Slider(id, label, unit, parameter.range);
    const { row, range, number } = slider;
    range.dataset.knob = name;
    const gradient = element("output", "gradient");
    gradient.htmlFor.add(id);
    if (limits !== null && parameter.free) range.title = `${limits[0]} to ${limits[1]} ${unit} when optimized`;
    row.append(gradient);
    range.addEventListener("input", () => this.turned(parameter.index, range.valueAsNumber * parameter.size));
    number.addEventListener("input", () => this.type(parameter, number.valueAsNumber));
    // a number typed beyond the range is set to the nearer end
    number.addEventListener("change", () => {
      const [low, high] = parameter.range;
      const typed = number.valueAsNumber;
      if (!(low <= typed && typed <= high))
        number.value = String(typed > high ? high : typed < low ? low : range.value);
      this.type(parameter, number.valueAsNumber);
    });
    number.title = `${parameter.range[0]} to ${parameter.range[1]} ${unit}`;
    this.knobs.push({ parameter, slider, gradient });
    return row;
  }

  /** Take a typed number, limited to the knob's range. */
  private type(parameter: Parameter, value: number): void {
    if (Number.isNaN(value)) return;
    const [low, high] = parameter.range;
    this.turned(parameter.index, Math.min(high, Math.max(low, value)) * parameter.size);
  }
}
