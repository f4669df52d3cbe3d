// The robots of the page: those that it came with and those that were opened in it.
import { packedBytes } from "./files.ts";
import type { Calculator } from "./questions.ts";
import { changedImage, changedRobot, type Factors } from "./changes.ts";
import { changedKey, type Robot, robotOf } from "./robot.ts";

const MAX_IMAGE = 2 ** 24; // bytes

/** Reads the bytes of a robot's image when they are first needed. */
export type ImageLoader = () => Promise<Uint8Array>;

export class Robots {
  private readonly images = new Map<string, ImageLoader>();
  private bodies = 0; // number of changed bodies so far
  private readonly known = new Map<string, Robot>();

  constructor(packed: { name: string; image: string }[]) {
    for (const { name, image } of packed) {
      let bytes: Promise<Uint8Array> | null = null;
      this.images.set(name, () => (bytes ??= packedBytes(image)));
    }
  }

  get names(): string[] {
    return [...this.images.keys()];
  }

  has(name: string | undefined): name is string {
    return name !== undefined && this.images.has(name);
  }

  image(robot: Robot): ImageLoader {
    const { described, factors } = robot;
    const image = this.images.get(robot.robot);
    if (image === undefined) throw new Error(`the page has no robot ${robot.robot}`);
    if (described === undefined || factors === undefined) return image;
    return async () => changedImage(await image(), described, factors);
  }

  /** A robot with factors on its body; without factors, the described robot. */
  changed(robot: Robot, factors: Factors): Robot {
    const described = robot.described ?? robot;
    if (Object.keys(factors).length === 0) return described;
    return changedRobot(described, factors, changedKey(described, ++this.bodies));
  }

  /** Read a robot of the page, and load its image in the calculator. */
  async read(name: string, calculator: Calculator): Promise<Robot> {
    const image = this.images.get(name);
    if (image === undefined) throw new Error(`the page has no robot ${name}`);
    const robot = this.known.get(name) ?? robotOf(await calculator.load(name, image));
    [robot.robot, robot.key] = [name, name];
    this.known.set(name, robot);
    return robot;
  }

  /** Add a robot, under another name if this one is taken; returns the name. */
  add(name: string, image: Uint8Array): string {
    let free = name;
    for (let k = 2; this.images.has(free); k++) free = `${name} (${k})`;
    this.images.set(free, async () => image);
    return free;
  }

  /** Add the robot of an image file; returns its name, or throws a sentence if the file holds no robot. */
  async open(file: File, calculator: Calculator): Promise<string> {
    if (file.size > MAX_IMAGE) throw new Error("it is too large for a robot image");
    const image = new Uint8Array(await file.arrayBuffer());
    const { text } = await calculator.ask({ kind: "load", robot: "", image });
    return this.add(robotOf(text).robot, image);
  }
}
