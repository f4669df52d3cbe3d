// The view of published gaits: the published numbers of the robot's named gaits beside the computed ones.
import { button, element, fact } from "./dom.ts";
import { digits, gaitText, type Quantities, statusOf, verdict } from "./quantities.ts";
import { Latest } from "./questions.ts";
import { type NamedGait, type Published, type Robot, rowOf } from "./robot.ts";
import type { Page, Subject, View } from "./subject.ts";
import { ledgerNote, verdictsOn, wordOn } from "./verdicts.ts";

const KINDS: Record<string, string> = {
  measured: "measured on the robot",
  target: "a target of the optimizer, not a measurement",
  simulated: "simulated by the authors",
};
const ELECTRICAL = "It includes servos and pump: this page computes the mechanical power of the joints.";

export class TourView implements View {
  private subject: Subject | null = null;
  private row: Float64Array = new Float64Array();
  private cards = new Map<string, HTMLElement>();
  private readonly latest = new Latest();

  constructor(
    private readonly panel: HTMLElement,
    private readonly page: Page,
  ) {}

  async about(_: Subject, subject: Subject): Promise<void> {
    if (this.subject?.robot === subject.robot && this.subject.model === subject.model) return;
    this.subject = subject;
    const { gaits, models, robot } = subject.robot;
    const found = await this.latest.of(subject.sweep(gaits.map(rowOf)));
    if (found === null) return;
    const own = models[0];
    const now = models[subject.model];
    const known = gaits.some(({ published }) => Object.keys(published).length > 0);
    const intro = known
      ? `What the authors published of ${robot}'s gaits, beside what is computed here with ${now?.water} water and ${now?.joints} joints.`
      : `The gaits of ${robot}'s file. None of their numbers is published there.`;
    const other =
      subject.model === 0 ? "" : ` The robot's own model is ${own?.water} water with ${own?.joints} joints.`;
    const list = element("div", "cards");
    this.cards = new Map(gaits.map((gait, k) => [gait.name, this.card(subject.robot, gait, found[k] ?? {})]));
    list.append(...this.cards.values());
    const note = known ? ledgerNote(subject.robot) : null;
    const sum = summary(subject.robot, subject.model, found);
    this.panel.replaceChildren(
      element("p", "intro", `${intro}${other} ${sum}`),
      ...(note === null ? [] : [note]),
      list,
    );
    this.at(this.row);
  }

  /** Mark the card of the gait that the knobs have. */
  at(row: Float64Array): void {
    this.row = row;
    for (const gait of this.subject?.robot.gaits ?? []) {
      const same = rowOf(gait).every((value, k) => Math.abs(value - (row[k] ?? 0)) < 1e-9);
      this.cards.get(gait.name)?.setAttribute("aria-current", String(same));
    }
  }

  private card(robot: Robot, gait: NamedGait, values: Quantities): HTMLElement {
    const card = element("article", "card");
    const show = button("Use this gait", () => this.page.go(rowOf(gait)));
    show.dataset.gait = gait.name;
    show.setAttribute("aria-label", `Use this gait: ${gait.name}`);
    const head = element("div", "row");
    head.append(element("h3", "", gait.name), show);
    card.append(head, element("p", "caption", gaitText(gait)));
    if (statusOf(values) !== "settled") card.append(element("p", "", verdict(values, gait.frequency)));
    const entries = Object.entries(gait.published);
    for (const [quantity, published] of entries)
      card.append(comparison(robot, this.subject?.model ?? 0, quantity, published, values));
    if (entries.length === 0) {
      card.append(
        element("p", "", `Computed: ${digits(values.speed)} m/s at ${digits(values.cost_of_transport)} J/(kg m).`),
      );
    }
    return card;
  }
}

/** A sentence with the count of each verdict, measurements apart from targets of the optimizer. */
function summary(robot: Robot, model: number, found: Quantities[]): string {
  const counts = new Map<string, Map<string, number>>();
  robot.gaits.forEach((gait, k) => {
    for (const [quantity, published] of Object.entries(gait.published)) {
      const word = wordOn(robot, published, model, computedOf(robot, quantity, found[k] ?? {}));
      if (word === null) continue;
      const kind = published.kind === "measured" ? "Of what was measured" : "Of targets of the optimizer";
      const words = counts.get(kind) ?? new Map<string, number>();
      counts.set(kind, words.set(word, (words.get(word) ?? 0) + 1));
    }
  });
  return [...counts]
    .map(([kind, words]) => `${kind}: ${[...words].map(([word, count]) => `${count} ${word}`).join(", ")}.`)
    .join(" ");
}

/** A published number beside the computed one, with the deviation in words and the ledger's verdict. */
function comparison(
  robot: Robot,
  model: number,
  quantity: string,
  published: Published,
  values: Quantities,
): HTMLElement {
  const box = element("div", "compared");
  const number = `${digits(published.value)} ${published.unit}`;
  const label = quantity.replace(/_bl$/, "").replaceAll("_", " ");
  const kind = KINDS[published.kind] ?? published.kind;
  const computed = computedOf(robot, quantity, values);
  if (computed === null) {
    box.append(
      element(
        "p",
        "",
        `${label}: published ${number}, ${kind}. ${quantity.startsWith("electrical") ? ELECTRICAL : "Not computed here."}`,
      ),
    );
  } else {
    const part = computed / published.value - 1;
    const off =
      Math.abs(part) < 5e-4 ? "the same" : `${digits(100 * Math.abs(part), 2)} % ${part > 0 ? "above" : "below"}`;
    const row = element("dl", "pair");
    row.append(
      fact(number, `${label} published`),
      fact(`${digits(computed)} ${published.unit}`, "computed"),
      fact(off, "deviation"),
    );
    box.append(row, element("p", "caption", `Published: ${kind}.`));
  }
  box.append(element("p", "caption", published.source), verdictsOn(robot, published, model, computed));
  return box;
}

function computedOf(robot: Robot, quantity: string, values: Quantities): number | null {
  if (quantity === "turn_radius_bl") return (values.turn_radius ?? Number.NaN) / robot.length;
  return values[quantity] ?? null;
}
