// The robots of the page: those it came with and those that were opened in it.
import { packedBytes } from "./files.ts";
import type { Calculator } from "./questions.ts";
import { type Robot, robotOf } from "./robot.ts";

const MAX_IMAGE = 2 ** 24; // bytes

export type Image = () => Promise<Uint8Array>;

export class Robots {
  private readonly images = new Map<string, Image>();
  private readonly known = new Map<string, Robot>();

  constructor(packed: { name: string; image: string }[]) {
    for (const { name, image } of packed) this.images.set(name, () => packedBytes(image));
  }

  get names(): string[] {
    return [...this.images.keys()];
  }

  has(name: string | undefined): name is string {
    return name !== undefined && this.images.has(name);
  }

  image(name: string): Image {
    const image = this.images.get(name);
    if (image === undefined) throw new Error(`the page has no robot ${name}`);
    return image;
  }

  /** What the page knows of a robot, which the calculator has loaded then. */
  async read(name: string, calculator: Calculator): Promise<Robot> {
    const robot = this.known.get(name) ?? robotOf(await calculator.load(name, this.image(name)));
    robot.robot = name;
    this.known.set(name, robot);
    return robot;
  }

  /** Add a robot under a name that no other has. */
  add(name: string, image: Uint8Array): string {
    let free = name;
    for (let k = 2; this.images.has(free); k++) free = `${name} (${k})`;
    this.images.set(free, async () => image);
    return free;
  }

  /** Add the robot of a file; throws a sentence where the file holds none. */
  async open(file: File, calculator: Calculator): Promise<string> {
    if (file.size > MAX_IMAGE) throw new Error("it is too large for a robot image");
    const image = new Uint8Array(await file.arrayBuffer());
    const { text } = await calculator.ask({ kind: "load", robot: "", image });
    return this.add(robotOf(text).robot, image);
  }
}
