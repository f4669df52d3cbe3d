// Controls that play a flight: a button, a slider over its time, a tempo.
import { element, labeled, selection } from "../dom.ts";
import type { Flight } from "./flight.ts";
import { clock, spoken } from "./words.ts";

const TEMPI = [0.5, 1, 2, 5, 10, 20, 50];
const KEY_STEP = 5; // s that an arrow key goes forward or back

export class Player {
  readonly element = element("div", "sea-player");
  time = 0;
  tempo = 5;
  private playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  private readonly button = element("button", "sea-play");
  private readonly slider = element("input");
  private readonly text = element("output", "sea-clock");
  private flight: Flight | null = null;
  private complete = true;

  /** `changed` is called when the time has changed. */
  constructor(private readonly changed: () => void) {
    const { button, slider } = this;
    button.type = "button";
    button.addEventListener("click", () => this.play(!this.playing));
    Object.assign(slider, { type: "range", min: "0", step: "0.1" });
    slider.setAttribute("aria-label", "Time of the flight");
    slider.addEventListener("input", () => this.go(slider.valueAsNumber));
    slider.addEventListener("keydown", (event) => this.press(event));
    const tempi = TEMPI.map((times): [string, number] => [`${times} x`, times]);
    const tempo = selection(tempi, this.tempo, (times) => {
      this.tempo = Number(times);
    });
    this.element.append(button, slider, this.text, labeled("tempo ", tempo));
    this.name();
  }

  /** Play another flight from its start; `complete`: no more rows of it will come. */
  set(flight: Flight, complete: boolean): void {
    [this.flight, this.complete, this.time] = [flight, complete, flight.begin];
    this.show();
  }

  /** Take new rows of the flight; `complete`: no more will come. */
  grow(complete: boolean): void {
    this.complete = complete;
    if (this.flight !== null && this.time < this.flight.begin) this.time = this.flight.begin;
    this.show();
  }

  go(time: number): void {
    const { flight } = this;
    if (flight === null) return;
    this.time = Math.min(flight.end, Math.max(flight.begin, time));
    this.show();
    this.changed();
  }

  /** Advance the player by seconds of the screen. */
  pass(seconds: number): void {
    const { flight } = this;
    if (flight === null || !this.playing || flight.count < 2) return;
    if (this.time >= flight.end) {
      if (this.complete) this.play(false);
      return;
    }
    this.go(this.time + this.tempo * seconds);
  }

  private play(on: boolean): void {
    const { flight } = this;
    if (on && flight !== null && this.complete && this.time >= flight.end) this.go(flight.begin);
    this.playing = on;
    this.name();
  }

  private name(): void {
    this.button.textContent = this.playing ? "Pause" : "Play";
  }

  private press(event: KeyboardEvent): void {
    const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -6, PageUp: 6 }[event.key];
    if (way !== undefined) this.go(this.time + KEY_STEP * way);
    else if (event.key === " ") this.play(!this.playing);
    else return;
    event.preventDefault();
  }

  private show(): void {
    const { flight, slider } = this;
    if (flight === null) return;
    slider.min = String(flight.begin);
    slider.max = String(flight.end);
    slider.value = String(this.time);
    const part = (this.time - flight.begin) / Math.max(1e-9, flight.end - flight.begin);
    slider.style.setProperty("--at", String(part));
    const end = `${clock(flight.end)}${this.complete ? "" : " …"}`;
    this.text.textContent = `${clock(this.time)} / ${end}`;
    if (flight.count > 0)
      slider.setAttribute("aria-valuetext", `${clock(this.time)}: ${spoken(flight, flight.at(this.time))}`);
  }
}
