// The Sea view's frame: it unpacks three.js and the reader of logs when the view is first opened.
import { part } from "./dom.ts";
import { packedBytes } from "./files.ts";
import type { Robot } from "./robot.ts";
import type { SeaRoom } from "./sea/view.ts";
import type { Another, Kept, Page, View } from "./subject.ts";

export class SeaView implements View {
  private flight = ""; // chosen mission and seed, such as "lake:3"
  private sea: Promise<SeaRoom> | null = null;
  private robot: Robot | null = null;

  /** `another` makes a calculator with a robot loaded; each flight has its own. */
  constructor(
    private readonly panel: HTMLElement,
    private readonly page: Page,
    private readonly another: Another,
  ) {}

  restore({ flight }: Kept): void {
    this.flight = flight ?? "";
  }

  kept(): Kept {
    return this.flight === "" ? {} : { flight: this.flight };
  }

  /** Take a robot, as its file describes it. */
  turnTo(robot: Robot): void {
    this.robot = robot.described ?? robot;
    if (!this.panel.hidden) this.show();
  }

  show(): void {
    const { robot } = this;
    if (robot !== null) this.with((sea) => sea.about(robot));
  }

  open(name: string, content: Uint8Array): void {
    this.with((sea) => sea.open(name, content));
  }

  refresh(): void {
    if (this.sea !== null) this.with((sea) => sea.refresh());
  }

  private with(use: (sea: SeaRoom) => unknown): void {
    this.sea ??= this.unpack();
    this.sea.then(use).catch((error: Error) => {
      this.panel.textContent = `The Sea view could not be opened: ${error.message}.`;
    });
  }

  private async unpack(): Promise<SeaRoom> {
    const script = document.createElement("script");
    script.textContent = new TextDecoder().decode(await packedBytes(part("sea-block").textContent ?? ""));
    document.head.append(script);
    const { SeaRoom: LoadedRoom } = globalThis as unknown as { SeaRoom: typeof SeaRoom };
    return new LoadedRoom(this.panel, {
      another: this.another,
      robot: this.page.robot,
      flight: () => this.flight,
      chosen: (flight) => {
        this.flight = flight;
        this.page.changed();
      },
    });
  }
}
