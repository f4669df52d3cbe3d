// Saves files from the File menu: gait, beat, pictures, a short video.
import { part } from "./dom.ts";
import { beatTable, gaitToml } from "./exports.ts";
import { save, savePicture, saveText } from "./files.ts";
import type { Stage } from "./fish.ts";
import * as words from "./quantities.ts";
import { gaitOf, type Robot } from "./robot.ts";
import { lengthOf, Video, videoType } from "./video.ts";
import type { Views } from "./views.ts";

/** The swim that is shown now. */
export interface Shown {
  robot: Robot;
  row: Float64Array;
  values: words.Quantities;
  path: Float64Array;
}

export class Saves {
  private video: Video | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly views: Views,
    private readonly now: () => Shown,
    private readonly say: (sentence: string) => void,
  ) {
    for (const button of document.querySelectorAll<HTMLButtonElement>("[data-save]")) {
      const kind = button.dataset.save ?? "";
      button.addEventListener("click", () => (kind === "video" ? void this.record(button) : this.save(kind)));
      if (kind !== "video" || videoType() !== "") continue;
      button.disabled = true;
      button.textContent = "This browser records no video";
    }
  }

  private get title(): string {
    const { robot, row, values } = this.now();
    return `${robot.robot}, ${words.gaitText(gaitOf(row))}: ${words.digits(values.speed)} m/s`;
  }

  private save(kind: string): void {
    const { robot, row, path } = this.now();
    const name = robot.robot;
    if (kind === "toml") saveText(gaitToml(robot, gaitOf(row)), `${name}-gait.toml`);
    if (kind === "csv") saveText(beatTable(robot, path), `${name}-beat.csv`);
    if (kind === "png") savePicture(part<HTMLCanvasElement>("stage"), this.title, `${name}.png`);
    if (kind === "svg") saveText(this.stage.svg(this.title), `${name}.svg`);
    if (kind !== "chart") return;
    const chart = this.views.svg(this.title);
    if (chart === null) this.say("The view below has no chart to save: Map and Cost over speed have one.");
    else saveText(chart, `${name}-${this.views.view}.svg`);
  }

  /** Record two beats at the picture's tempo, or in real time if it stands still; a second click stops. */
  private async record(button: HTMLButtonElement): Promise<void> {
    if (this.video !== null) {
      this.video.stop();
      return;
    }
    const { robot, row } = this.now();
    const { tempo } = this.stage.shown;
    const label = button.textContent;
    const seconds = lengthOf(row[0] ?? 1, tempo || 1);
    if (tempo === 0) this.stage.show({ tempo: 1 });
    button.textContent = `Stop the video of ${Math.ceil(seconds)} s`;
    try {
      this.video = new Video(part<HTMLCanvasElement>("stage"), seconds);
      const content = await this.video.done;
      save(content, `${robot.robot}.${content.type.replace("video/", "")}`);
    } catch (error) {
      this.say(`No video was saved: ${(error as Error).message}.`);
    }
    if (tempo === 0) this.stage.show({ tempo });
    this.video = null;
    button.textContent = label;
  }
}
