// The view of the body: sliders that multiply the robot's lengths, masses, tail area and springs by a factor each.
import type { Factors } from "./changes.ts";
import { changedToml, twinFollows, within } from "./changes.ts";
import { button, element } from "./dom.ts";
import { Drawing } from "./drawing.ts";
import { saveText } from "./files.ts";
import { Slider } from "./knobs.ts";
import { digits, MAIN, meaning, plain, type Quantities } from "./quantities.ts";
import type { BodyKnob, Robot } from "./robot.ts";
import type { Page, Subject, View } from "./subject.ts";

const GROUPS: [RegExp, string][] = [
  [/^length/, "Lengths"],
  [/^mass/, "Masses"],
  [/^fin/, "Tail"],
  [/./, "Stiffness"],
];
const INTRO =
  "Drag the handles, or use the sliders. A longer link keeps its mass and the volume that it displaces, and its areas grow; a heavier one keeps its volume. Coefficients of the water stay as they were identified for the described body, and laws differ in what they make of another one: compare them.";

interface Row {
  knob: BodyKnob;
  slider: Slider;
  mark: HTMLElement;
  reset: HTMLButtonElement;
}

export class BodyView implements View {
  private readonly drawing: Drawing;
  private readonly gains = element("dl", "facts gains");
  private readonly list = element("div", "knobs-of-body");
  private readonly note = element("p", "caption");
  private readonly buttons: Record<"reset" | "save", HTMLButtonElement>;
  private rows: Row[] = [];
  private robot: Robot | null = null; // the robot with its changed body, as shown
  private described: Subject | null = null;
  private row: Float64Array = new Float64Array();
  private values: Quantities = {};
  private before: { of: string; values: Quantities } = { of: "", values: {} }; // described robot
  private asking = false;

  constructor(
    private readonly panel: HTMLElement,
    private readonly page: Page,
  ) {
    this.drawing = new Drawing((knob, factor) => this.turn(knob, rounded(factor)));
    const reset = button("Reset all", () => page.body({}));
    this.buttons = { reset, save: button("Save the robot (TOML)", () => this.save()) };
    const head = element("div", "row left");
    head.append(this.buttons.reset, this.buttons.save);
    this.note.setAttribute("role", "status");
    panel.replaceChildren(element("p", "intro", INTRO), this.gains, this.drawing.svg, head, this.note, this.list);
  }

  /** Show a robot, as described or with a changed body. */
  shape(robot: Robot): void {
    const other = this.robot?.body !== robot.body || this.robot.robot !== robot.robot;
    this.robot = robot;
    if (other) this.layOut(robot);
    this.drawing.show(robot);
    const factors = robot.factors ?? {};
    for (const { knob, slider, mark, reset } of this.rows) {
      const factor = factors[knob.name] ?? 1;
      slider.show(factor, plain(knob.value * factor));
      mark.textContent = factor === 1 ? "" : signed(100 * (factor - 1));
      mark.title = `described: ${digits(knob.value)} ${knob.unit}`;
      reset.hidden = factor === 1;
    }
    const count = Object.keys(factors).length;
    for (const button of Object.values(this.buttons)) button.disabled = count === 0;
    this.tell(robot, factors, count);
    this.compare();
  }

  /** Compare with `described`, the robot as its file describes it. */
  about(_: Subject, described: Subject): void {
    this.described = described;
    this.compare();
  }

  /** Take the gait of the knobs, and its quantities with the body that is shown. */
  at(row: Float64Array, values: Quantities): void {
    [this.row, this.values] = [row, values];
    this.compare();
  }

  private tell(robot: Robot, factors: Factors, count: number): void {
    const twin = robot.twin === null ? "" : twinFollows(robot, factors) ? TWIN : NO_TWIN;
    this.note.textContent =
      robot.body.knobs.length === 0
        ? "The image does not say how its numbers follow the body: write it anew with `hypertuna robot image`."
        : count === 0
          ? "The body is as the file describes it."
          : `${count} ${count === 1 ? "value is" : "values are"} changed: the fish, its numbers, map and cost over speed follow.${twin} Published gaits and flights at sea are of the robot as described.`;
  }

  private turn(knob: BodyKnob, factor: number): void {
    const kept = within(knob, factor);
    const factors = { ...this.robot?.factors, [knob.name]: kept };
    if (kept === 1) delete factors[knob.name];
    this.page.body(factors);
  }

  private save(): void {
    const { robot } = this;
    if (robot?.described !== undefined && robot.factors !== undefined)
      saveText(changedToml(robot.described, robot.factors), `${robot.robot}-changed.toml`);
  }

  // --- comparison with the described robot

  private compare(): void {
    if (this.panel.hidden) return;
    void this.ask();
    const before = this.before.of === this.wanted() ? this.before.values : {};
    const changed = this.robot?.factors !== undefined;
    this.gains.replaceChildren(
      ...MAIN.map((name) => {
        const { label, unit } = meaning(name);
        const box = element("div");
        const [now, then] = [this.values[name] ?? Number.NaN, before[name] ?? Number.NaN];
        const gain = 100 * (now / then - 1);
        const number = element("dt", "", changed ? signed(gain) : digits(now));
        number.dataset.gain = name;
        number.dataset.value = String(gain);
        const words = changed ? `${label}: ${digits(now)}, described ${digits(then)} ` : `${label}, described `;
        const text = element("dd", "", words);
        text.append(element("span", "unit", `[${unit}]`));
        box.append(number, text);
        return box;
      }),
    );
  }

  private wanted(): string {
    const { described, row } = this;
    return described === null ? "" : [described.robot.key, described.model, ...row].join(" ");
  }

  /** Compute the described robot's quantities at the gait of the knobs. */
  private async ask(): Promise<void> {
    const { described, row } = this;
    if (described === null || this.asking || row.length !== described.parameters.length) return;
    const of = this.wanted();
    if (of === this.before.of) return;
    this.asking = true;
    try {
      const [values] = await described.sweep([row]);
      this.before = { of, values: values ?? {} };
    } finally {
      this.asking = false;
    }
    this.compare();
  }

  // --- rows

  private layOut(robot: Robot): void {
    this.rows = [];
    const left = new Set(robot.body.knobs);
    const groups = GROUPS.flatMap(([pattern, title]) => {
      const knobs = [...left].filter(({ name }) => pattern.test(name));
      for (const knob of knobs) left.delete(knob);
      if (knobs.length === 0) return [];
      const box = element("section", "group");
      box.append(element("h3", "", title), ...knobs.map((knob) => this.knobRow(knob)));
      return [box];
    });
    this.list.replaceChildren(...groups);
  }

  private knobRow(knob: BodyKnob): HTMLElement {
    const step = knob.steps === undefined ? "any" : "0.1";
    const slider = new Slider(`body-${knob.name}`, knob.label, knob.unit, knob.range, step);
    const { row, range, number, field } = slider;
    range.dataset.body = knob.name;
    const mark = element("output", "mark");
    const reset = button("↺", () => this.turn(knob, 1));
    reset.title = "Reset";
    reset.setAttribute("aria-label", `Reset ${knob.label}`);
    field.prepend(mark, reset);
    range.addEventListener("input", () => this.turn(knob, rounded(range.valueAsNumber)));
    number.addEventListener("change", () => {
      if (!Number.isNaN(number.valueAsNumber)) this.turn(knob, number.valueAsNumber / knob.value);
    });
    this.rows.push({ knob, slider, mark, reset });
    return row;
  }
}

const TWIN = " Inside, the twin has the changed body, and on board the controller of the robot as described.";
const NO_TWIN = " Inside, the twin is that of the robot as described: it does not follow one of these values.";

/** Round a factor that was dragged, not typed. */
const rounded = (factor: number): number => Number(factor.toFixed(4));

/** Text of a change in percent, with its sign. */
const signed = (percent: number): string => `${digits(percent, 3).replace(/^(?=\d)/, "+")} %`;
