// Shows the ledger's stored verdicts on a published number; the page judges nothing itself.
import { element } from "./dom.ts";
import { digits } from "./quantities.ts";
import type { Published, Robot, Verdict } from "./robot.ts";

const TOLERANCE = 1e-6; // numbers are the same below this relative difference, as the ledger stores rounded ones
const AGREES = ["reproduced", "agrees", "holds"];
const worded = (verdict: string): string => verdict.replaceAll("-", " ");

/** The verdicts on a published number, with the verdict on the number that the page computes first. */
export function verdictsOn(robot: Robot, published: Published, model: number, computed: number | null): HTMLElement {
  const box = element("div", "judged");
  if (robot.ledger === null || published.verdicts.length === 0) {
    box.append(line("none", "–", "no verdict", ": the ledger has none of this robot as it is here"));
    return box;
  }
  const own = computed === null ? null : ownOf(robot, published.verdicts, model, computed);
  if (own !== null) box.append(verdictText(robot, own));
  else if (computed !== null) box.append(line("none", "–", "no verdict", " on this model, which is not the ledger's"));
  const others = published.verdicts.filter((one) => one !== own);
  if (computed === null && others.length <= 2)
    box.append(...others.map((one) => verdictText(robot, one, published.unit)));
  else if (others.length > 0) box.append(folded(robot, others, published.unit));
  box.append(place(published.id));
  return box;
}

/** The ledger's verdict, in words, on a number that the page computes; null if it has none. */
export function wordOn(robot: Robot, published: Published, model: number, computed: number | null): string | null {
  if (robot.ledger === null || computed === null) return null;
  const own = ownOf(robot, published.verdicts, model, computed);
  return own === null ? null : worded(own.verdict);
}

/** The verdict on the page's model, if the ledger computed the same number with that model. */
function ownOf(robot: Robot, verdicts: Verdict[], model: number, computed: number): Verdict | null {
  const now = robot.models[model];
  const own = verdicts.find((one) => {
    const choice = robot.ledger?.models[one.model];
    return choice !== undefined && choice.water === now?.water && choice.joints === now.joints;
  });
  const same = own?.computed != null && Math.abs(computed - own.computed) <= TOLERANCE * Math.abs(own.computed);
  return own !== undefined && same ? own : null;
}

/** One verdict in words: with a unit, on another model's number; without, on the number above it. */
function verdictText(robot: Robot, one: Verdict, unit: string | null = null): HTMLElement {
  const reason = robot.ledger?.classes[one.class] ?? one.class;
  const number = unit === null || one.computed === null ? "" : `: ${digits(one.computed, 3)} ${unit}`;
  const model = unit === null ? "" : ` in the model “${one.model}”${number}`;
  const worth =
    one.verdict === "reproduced"
      ? ": a prediction within the tolerance that was fixed beforehand"
      : one.verdict === "agrees"
        ? `, which proves little: ${reason}`
        : "";
  const seeds = one.seeds === null || one.seeds[0] === null ? "" : `, ${one.seeds[0]} of ${one.seeds[1]} seeds agree`;
  const text = line(one.verdict, mark(robot, one), worded(one.verdict), `${model}${seeds}${worth}`);
  if (unit !== null && one.note !== "") text.append(element("span", "note", `${one.note}.`));
  return text;
}

/** The verdicts on other models: their counts, in a line that unfolds them. */
function folded(robot: Robot, others: Verdict[], unit: string): HTMLElement {
  const counts = Object.keys(robot.ledger?.marks ?? {}).flatMap((verdict) => {
    const count = others.filter((one) => one.verdict === verdict).length;
    return count === 0 ? [] : [`${robot.ledger?.marks[verdict]} ${count} ${word(verdict, count)}`];
  });
  const box = element("details", "others");
  const models = others.length === 1 ? "1 more model" : `${others.length} more models`;
  box.append(element("summary", "", `${models}: ${counts.join(", ")}`));
  box.append(...others.map((one) => verdictText(robot, one, unit)));
  return box;
}

function word(verdict: string, count: number): string {
  return count > 1 && ["agrees", "holds", "deviates"].includes(verdict) ? verdict.slice(0, -1) : worded(verdict);
}

function line(verdict: string, mark: string, word: string, rest: string): HTMLElement {
  const text = element("p", "verdict");
  text.dataset.verdict = verdict;
  const sign = element("span", "mark", mark);
  sign.ariaHidden = "true";
  text.append(sign, element("strong", AGREES.includes(verdict) ? "good" : "", word), `${rest}.`);
  return text;
}

const mark = (robot: Robot, one: Verdict): string => robot.ledger?.marks[one.verdict] ?? "–";

/** The number's place in the ledger: a link if the page knows the ledger's address. */
function place(id: string): HTMLElement {
  const text = element("p", "caption");
  const { ledger } = document.documentElement.dataset;
  if (ledger === undefined) {
    text.append(element("code", "", id), " in the ledger");
    return text;
  }
  const link = element("a", "", `${id} in the ledger`);
  link.href = `${ledger}#number-${id.toLowerCase().replace(/[^a-z0-9]+/g, "-")}`;
  link.target = "_top";
  text.append(link);
  return text;
}

/** A note on the meaning of the marks, and on how to write the ledger's page if there is none. */
export function ledgerNote(robot: Robot): HTMLElement | null {
  if (robot.ledger === null) return null;
  const text = element("p", "caption");
  const marks = Object.entries(robot.ledger.marks).map(([verdict, sign]) => `${sign} ${worded(verdict)}`);
  text.append(`The verdicts are the ledger's, by rules that were fixed beforehand: ${marks.join(", ")}. Only a `);
  text.append("prediction counts as reproduced. ");
  if (document.documentElement.dataset.ledger === undefined)
    text.append(element("code", "", "hypertuna paper -o demo"), " writes the ledger of all numbers as a page.");
  return text;
}
