// The Sea view: a live mission or a log in three dimensions, and beside it what the robot does and believes.
import { element } from "../dom.ts";
import type { Calculator } from "../questions.ts";
import type { Robot } from "../robot.ts";
import { type By, modeColor } from "./colors.ts";
import { Controls, type Handlers } from "./controls.ts";
import { Flight, type Said } from "./flight.ts";
import { Live } from "./live.ts";
import { openLog } from "./open.ts";
import { Picture } from "./picture.ts";
import { Plan } from "./plan.ts";
import { Player } from "./player.ts";
import { draws } from "./scene.ts";
import { Traces } from "./traces.ts";
import { facts, spoken, why } from "./words.ts";

declare const LOG_WORKER: string; // script of the worker that reads logs

const HELP =
  "Drag to turn, with two fingers or the right button to move; the wheel zooms once the picture is clicked. Keys: arrows, with Shift to move, + and −.";
const REDRAW_INTERVAL = 0.7; // s between two drawings of a flight that still grows

/** The functions of the page that the view may call. */
export interface Needs {
  /** Make a calculator with a robot loaded, for a flight. */
  another(robot: Robot): Promise<Calculator>;
  /** Find a robot of the page by its name. */
  robot(name: string): Promise<Robot | null>;
  /** Return the chosen mission and seed, at first those of the link; `chosen` takes another choice. */
  flight(): string;
  chosen(flight: string): void;
}

/** A log that is open. */
interface Shown {
  title: string;
  flight: Flight;
  body: Robot | null;
  note: string;
}

export class SeaRoom {
  private readonly picture: Picture | null; // the three-dimensional picture; null without WebGL
  private readonly drawing: Picture | Plan;
  private readonly player = new Player(() => this.show());
  private readonly traces = new Traces((time) => this.player.go(time));
  private readonly controls: Controls;
  private readonly shown = element("div"); // everything that shows a flight
  private readonly note = element("p", "sea-note");
  private readonly alert = element("p", "sea-alert");
  private readonly facts = element("dl", "facts sea-facts");
  private readonly reasons = element("p", "guard");
  private readonly spoken = element("p", "sea-spoken");
  private readonly legend = element("p", "sea-legend");
  private robot: Robot | null = null;
  private flight: Flight | null = null;
  private live: Live | null = null;
  private started = ""; // the request that was made last
  private log: Shown | null = null; // the log that was opened last
  private opened = 0; // number of logs that were given
  private by: By = "mode";
  private before = 0;
  private drawn = 0; // s, time of the last drawing
  private grown = false;

  constructor(
    private readonly panel: HTMLElement,
    private readonly needs: Needs,
  ) {
    this.picture = draws() ? new Picture(() => this.press()) : null;
    this.drawing = this.picture ?? new Plan();
    this.controls = new Controls(this.heard(), this.picture !== null);
    this.layOut();
    requestAnimationFrame((now) => this.frame(now));
  }

  /** Take a robot of the page: fly its first mission, unless a log is shown. */
  about(robot: Robot): void {
    if (this.robot === robot) return;
    this.robot = robot;
    const kept = this.log !== null && this.flight === this.log.flight;
    this.controls.list(robot.missions);
    if (this.log !== null) this.controls.logged(this.log.title, kept);
    if (!kept) this.start(robot);
  }

  /** Open a log and show it. */
  async open(name: string, content: Uint8Array): Promise<void> {
    const turn = ++this.opened;
    const before = this.note.textContent;
    this.say("");
    this.note.textContent = `Reading ${name} …`;
    try {
      const log = await openLog(LOG_WORKER, name, content);
      const body = await this.needs.robot(log.head.robot);
      if (this.opened !== turn) return;
      const pilot = body?.pilot ?? this.robot?.pilot;
      const head = {
        ...log.head,
        modes: said(log.head.modes, pilot?.modes),
        reasons: said(log.head.reasons, pilot?.reasons),
      };
      const flight = new Flight(head, log.columns);
      flight.append(log.rows);
      const without = body === null ? ` This page has no robot ${log.head.robot}: an arrow stands for it.` : "";
      this.log = { title: name, flight, body, note: `${name}: ${log.sentence}${without}` };
      this.controls.logged(name, true);
      this.play(this.log);
    } catch (error) {
      if (this.opened !== turn) return;
      this.note.textContent = before;
      this.say((error as Error).message);
    }
  }

  /** Draw again, in the colors of the page's theme. */
  refresh(): void {
    this.drawing.refresh();
    this.paint();
    this.show();
  }

  // live flights and logs

  /** Fly the mission and seed of the link, or else the first mission. */
  private start(robot: Robot): void {
    const [name, seed] = this.needs.flight().split(":");
    const mission = Math.max(
      0,
      robot.missions.findIndex((known) => known.name === name),
    );
    void this.fly(mission, Number(seed) || 0);
  }

  private async fly(mission: number, seed: number): Promise<void> {
    const { robot } = this;
    const asked = `${robot?.robot} ${mission} ${seed} ${performance.now()}`;
    this.started = asked;
    this.say("");
    this.live?.stop();
    this.live = null;
    this.controls.flown(mission, seed);
    if (robot === null || robot.missions.length === 0 || robot.pilot === null) {
      this.note.textContent = `The file of ${robot?.robot ?? "the robot"} has no pilot, so that it flies no mission: choose another robot, or drop a log of a mission (.mcap) here.`;
      this.flight = null;
      this.shown.hidden = true;
      return;
    }
    const { name, text } = robot.missions[mission] ?? { name: "", text: "" };
    const scatter = seed === 0 ? "" : `; current and satellites as seed ${seed} scatters them`;
    this.note.textContent = `${name}: ${text}${scatter}. The pilot on board chooses the gaits, not the knobs.`;
    try {
      const calculator = await this.needs.another(robot);
      const live = await Live.start(calculator, robot, mission, seed);
      if (this.started !== asked) return live.stop();
      this.live = live;
      this.set(live.flight, robot, false);
      await live.run(() => this.grow(live));
    } catch (error) {
      this.say(`The mission cannot be flown: ${(error as Error).message}.`);
    }
  }

  /** Show a log. */
  private play({ title, flight, body, note }: Shown): void {
    this.started = title;
    this.live?.stop();
    this.live = null;
    this.note.textContent = note;
    this.set(flight, body, true);
  }

  private set(flight: Flight, robot: Robot | null, complete: boolean): void {
    this.flight = flight;
    this.shown.hidden = false;
    this.drawing.set(flight, robot);
    this.player.set(flight, complete);
    this.press();
    this.paint();
    this.drawn = 0;
    this.show();
  }

  private grow(live: Live): void {
    if (live !== this.live) return;
    this.grown = true;
    this.player.grow(live.over);
    if (live.over && live.ending !== "") {
      this.note.textContent += ` At its end: ${live.ending}.`;
    }
  }

  private say(sentence: string): void {
    this.alert.textContent = sentence;
    this.alert.hidden = sentence === "";
  }

  // --- time

  private frame(now: number): void {
    requestAnimationFrame((later) => this.frame(later));
    const passed = Math.min(0.1, (now - this.before) / 1000);
    this.before = now;
    if (this.panel.hidden || this.flight === null) return;
    if (this.grown && now / 1000 - this.drawn > REDRAW_INTERVAL) {
      this.grown = false;
      this.drawn = now / 1000;
      this.drawing.grow();
      this.show();
    }
    this.player.pass(passed);
    this.traces.draw(this.flight, Math.max(1, this.flight.end));
    this.traces.mark(this.player.time);
    this.drawing.draw();
  }

  /** Show the flight at the player's time. */
  private show(): void {
    const { flight, player } = this;
    if (flight === null || flight.count === 0) return;
    const k = flight.at(player.time);
    this.drawing.show(player.time);
    const tiles = facts(flight, k);
    if (this.facts.childElementCount !== tiles.length) {
      this.facts.replaceChildren(
        ...tiles.map(() => {
          const box = element("div");
          box.append(element("dt"), element("dd"));
          return box;
        }),
      );
    }
    tiles.forEach(({ value, label }, i) => {
      const [number, text] = this.facts.children[i]?.children ?? [];
      if (number !== undefined && number.textContent !== value) number.textContent = value;
      if (text !== undefined && text.textContent !== label) text.textContent = label;
    });
    const reasons = why(flight, k);
    if (this.reasons.textContent !== reasons) this.reasons.textContent = reasons;
    this.reasons.dataset.quiet = String(flight.reasons(k).length === 0);
    const heard = `${flight.mode(k).name}: ${flight.mode(k).text}`;
    if (this.spoken.textContent !== heard) this.spoken.textContent = heard;
    this.drawing.canvas.ariaLabel = spoken(flight, k);
  }

  // --- layout

  private layOut(): void {
    this.alert.setAttribute("role", "alert");
    this.alert.hidden = true;
    this.reasons.setAttribute("role", "status");
    this.spoken.setAttribute("role", "status");
    const beside = element("div", "sea-beside");
    beside.append(this.facts, this.reasons, this.spoken);
    const stage = element("div", "sea-stage");
    const help = element("p", "caption sea-help", HELP);
    help.id = "sea-help";
    help.hidden = this.picture === null;
    this.picture?.canvas.setAttribute("aria-describedby", help.id);
    stage.append(this.drawing.element, this.legend, this.player.element);
    const both = element("div", "sea-both");
    both.append(stage, beside);
    stage.append(help);
    const plain = element(
      "p",
      "caption",
      "This browser draws nothing in space (it has no WebGL): the flight is shown from above, its depth below.",
    );
    plain.hidden = this.picture !== null;
    this.shown.append(plain, both, this.traces.element);
    this.shown.hidden = true;
    this.panel.replaceChildren(this.controls.element, this.note, this.alert, this.shown);
  }

  private heard(): Handlers {
    return {
      mission: (place, seed) => {
        this.opened++; // a log that is still being read is dropped
        this.needs.chosen(`${this.robot?.missions[place]?.name}:${seed}`);
        void this.fly(place, seed);
      },
      log: () => this.log && this.play(this.log),
      file: async (file) => this.open(file.name, new Uint8Array(await file.arrayBuffer())),
      by: (by) => {
        this.by = by;
        this.drawing.color(by);
        this.paint();
        this.show();
      },
      sight: (sight) => {
        this.picture?.see(sight);
        this.press();
        this.show();
      },
      zoom: (by) => this.picture?.space.zoom(by),
      stretch: (times) => {
        this.picture?.deepen(times);
        this.show();
      },
    };
  }

  /** Mark the chosen camera. */
  private press(): void {
    if (this.picture !== null) this.controls.seen(this.picture.sight, this.picture.space.stretch);
  }

  /** Write the legend of the track's colors. */
  private paint(): void {
    const { flight, legend } = this;
    if (flight === null) return;
    const key = (name: string, color: string): HTMLElement => {
      const box = element("span", "sea-key", name);
      box.style.setProperty("--key", `var(--${color})`);
      return box;
    };
    const believed = flight.true ? [key("believed place", "sea-believed")] : [];
    if (this.by === "mode") {
      const names = ["transit", "surface", "home", "hold"];
      legend.replaceChildren(...names.map((name) => key(name, modeColor(name))), ...believed);
    } else {
      const scale = element("span", "sea-scale", this.by === "depth" ? "surface to depth" : "slow to fast");
      legend.replaceChildren(scale, ...believed);
    }
  }
}

/** The names of a log, with the page's sentences for those that it knows. */
function said(names: Said[], known: Said[] = []): Said[] {
  return names.map((one) => known.find(({ name }) => name === one.name) ?? one);
}
