// The Sea view: what it stands on, three.js and a reader of logs, is unpacked when it is first opened.
import { part } from "./dom.ts";
import { packedBytes } from "./files.ts";
import type { Robot } from "./robot.ts";
import type { Needs, SeaRoom } from "./sea/view.ts";

export class SeaView {
  private sea: Promise<SeaRoom> | null = null;
  private robot: Robot | null = null;

  constructor(
    private readonly room: HTMLElement,
    private readonly needs: Needs,
  ) {}

  /** Turn to a robot. */
  about(robot: Robot): void {
    this.robot = robot;
    if (!this.room.hidden) this.show();
  }

  /** The view is shown from now on. */
  show(): void {
    const { robot } = this;
    if (robot !== null) void this.unpacked().then((sea) => sea.about(robot));
  }

  /** Open a log of a mission. */
  async open(name: string, content: Uint8Array): Promise<void> {
    await (await this.unpacked()).open(name, content);
  }

  /** Draw again, in the colors of the page's theme. */
  refresh(): void {
    void this.sea?.then((sea) => sea.refresh());
  }

  private unpacked(): Promise<SeaRoom> {
    this.sea ??= this.unpack();
    return this.sea;
  }

  private async unpack(): Promise<SeaRoom> {
    const script = document.createElement("script");
    script.textContent = new TextDecoder().decode(await packedBytes(part("sea-block").textContent ?? ""));
    document.head.append(script);
    const { SeaRoom: Room } = globalThis as unknown as { SeaRoom: typeof SeaRoom };
    return new Room(this.room, this.needs);
  }
}
