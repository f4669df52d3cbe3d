// The views below the fish: a map, cost over speed, published gaits.
import type { Quantities } from "./quantities.ts";
import type { Calculator } from "./questions.ts";
import type { Parameter, Robot } from "./robot.ts";

export interface Page {
  go(row: Float64Array): void;
  say(sentence: string): void;
  changed(): void;
}

export class Views {
  view = "map";
  over: [number, number] = [0, 1];
  constructor(private readonly page: Page) {}
  start(_background: Calculator, _names: { quantities: string[]; derivatives: string[] }): void {
    void this.page;
  }
  restore(_view: string | undefined, _over: [number, number] | undefined): void {}
  async about(
    _robot: Robot,
    _parameters: Parameter[],
    _model: number,
    _of: string,
    _image: () => Promise<Uint8Array>,
  ): Promise<void> {}
  at(_row: Float64Array, _values: Quantities): void {}
  refresh(): void {}
}
