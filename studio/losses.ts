// Shows where the twin's electrical power goes, from battery to water: mean of a beat, one bar for each place.
import { element } from "./dom.ts";
import { ofKinds } from "./drives.ts";
import { digits } from "./quantities.ts";
import type { Robot } from "./robot.ts";

const OTHER_LOADS = "converter and electronics"; // power of the battery that the servos do not take
const COLORS = ["pink", "orange", "green", "sky", "blue"];
const LEAST_SHOWN = 5e-3; // a power below this fraction of the battery's is shown as 0

interface Row {
  element: HTMLElement;
  lost: HTMLElement; // bar from the power lost before this place to the power lost after it
  power: HTMLElement;
  named: Map<string, HTMLElement>; // numbers by name of the loss, except a loss named like its place
}

export class Losses {
  readonly element = element("div", "losses");
  private readonly title = element("p", "caption");
  private readonly places: string[]; // places in the order of the power's path
  private readonly rows: Row[];
  private readonly losses: { name: string; place: string; text: string }[];

  constructor(robot: Robot) {
    this.losses = robot.twin?.losses ?? [];
    this.places = ["battery", ...new Set(this.losses.map(({ place }) => place))];
    const own = ["battery", ...ofKinds(robot, ({ places }) => places)];
    this.rows = this.places.map((place, k) => {
      const [row, track] = [element("div", "loss"), element("span", "track")];
      const [lost, power, parts] = [element("i"), element("b"), element("small")];
      lost.style.background = `var(--${COLORS[k]})`;
      track.append(lost);
      row.append(element("span", "", place), track, power, parts);
      const named = new Map(this.names(place).map((name) => [name, element("span")]));
      for (const [name, number] of named) {
        const part = element("span", "part", `${name} `); // of constant width: line breaks stay
        part.append(number);
        parts.append(part);
      }
      row.hidden = !own.includes(place);
      return { element: row, lost, power, named };
    });
    this.element.append(this.title, ...this.rows.map(({ element }) => element));
  }

  private names(place: string): string[] {
    const own = this.losses.filter((one) => one.place === place && one.name !== place).map(({ name }) => name);
    return place === "battery" ? [OTHER_LOADS, ...own] : own;
  }

  /** Show means of a beat: `mean` gives that of a column of the record, `drawn` is the battery's power [W]. */
  show(mean: (name: string) => number, drawn: number): void {
    const powers = this.losses.map(({ name, place }) => ({ name, place, power: mean(`loss_${name}`) }));
    const servos = powers.reduce((sum, { power }) => sum + power, 0);
    powers.unshift({ name: OTHER_LOADS, place: "battery", power: drawn - servos });
    this.title.textContent = `Where the ${digits(drawn, 3)} W from the battery go, means of a beat [W]`;
    let before = 0;
    this.rows.forEach((row, k) => {
      const local = powers.filter(({ place }) => place === this.places[k]);
      const sum = local.reduce((all, { power }) => all + power, 0);
      row.element.hidden &&= Math.abs(sum) < 1e-9; // a place without any loss, as a hinge without oil
      row.lost.style.left = `${percent(before, drawn)}%`;
      row.lost.style.width = `${percent(sum, drawn)}%`;
      put(row.power, shown(sum, 3, drawn));
      for (const { name, power } of local) {
        const number = row.named.get(name);
        if (number) put(number, shown(power, 2, drawn));
      }
      before += Math.max(0, sum);
    });
  }
}

const percent = (part: number, whole: number): number => 100 * Math.min(1, Math.max(0, whole > 0 ? part / whole : 0));

const shown = (power: number, count: number, drawn: number): string =>
  Math.abs(power) < LEAST_SHOWN * drawn ? "0" : digits(power, count);

function put(place: HTMLElement, text: string): void {
  if (place.textContent !== text) place.textContent = text;
}
