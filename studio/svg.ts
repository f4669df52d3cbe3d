// A pen that writes SVG: it has those methods of a canvas that the page uses, so that plots can be saved for papers.

const short = (value: number): string => String(Math.round(100 * value) / 100);
const point = (x: number, y: number): string => `${short(x)} ${short(y)}`;
const COLOR_PARSER = document.createElement("canvas").getContext("2d") as CanvasRenderingContext2D; // reads CSS colors
const escaped = (text: string): string =>
  text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;").replaceAll('"', "&quot;");

/** A path that collects SVG path commands. */
export class SvgPath {
  commands: string[] = [];

  private go(command: string): void {
    // on a canvas, too, a line that comes first only moves
    this.commands.push(this.commands.length === 0 ? command.replace(/^L/, "M") : command);
  }

  moveTo(x: number, y: number): void {
    this.commands.push(`M${point(x, y)}`);
  }

  lineTo(x: number, y: number): void {
    this.go(`L${point(x, y)}`);
  }

  quadraticCurveTo(x1: number, y1: number, x: number, y: number): void {
    this.commands.push(`Q${point(x1, y1)} ${point(x, y)}`);
  }

  closePath(): void {
    this.commands.push("Z");
  }

  arc(x: number, y: number, radius: number, from: number, to: number): void {
    this.ellipse(x, y, radius, radius, 0, from, to);
  }

  ellipse(x: number, y: number, rx: number, ry: number, turn: number, from: number, to: number): void {
    const at = (angle: number): [number, number] => {
      const [a, b] = [rx * Math.cos(angle), ry * Math.sin(angle)];
      return [x + a * Math.cos(turn) - b * Math.sin(turn), y + a * Math.sin(turn) + b * Math.cos(turn)];
    };
    const whole = Math.abs(to - from) >= 2 * Math.PI;
    const end = whole ? from + 2 * Math.PI : to;
    this.go(`L${point(...at(from))}`);
    const shape = `A${point(rx, ry)} ${short((turn * 180) / Math.PI)}`;
    for (const angle of [(from + end) / 2, end])
      this.commands.push(`${shape} 0 ${end > from ? 1 : 0} ${point(...at(angle))}`);
    if (whole) this.closePath();
  }

  rect(x: number, y: number, width: number, height: number): void {
    this.commands.push(`M${point(x, y)}h${short(width)}v${short(height)}h${short(-width)}Z`);
  }
}

class Shade {
  stops: string[] = [];
  constructor(readonly id: string) {}

  addColorStop(offset: number, color: string): void {
    this.stops.push(`<stop offset="${offset}" stop-color="${escaped(color)}"/>`);
  }

  toString(): string {
    return `url(#${this.id})`;
  }
}

type Matrix = [number, number, number, number, number, number];

/** The initial state of a pen: that of a canvas, and dashes, transform and clip path. */
const INITIAL = {
  ...{ fillStyle: "#000" as string | Shade, strokeStyle: "#000" as string | Shade, lineWidth: 1 },
  ...{ lineCap: "butt", lineJoin: "miter", globalAlpha: 1, font: "12px sans-serif", textAlign: "left" },
  ...{ dash: [] as number[], matrix: [1, 0, 0, 1, 0, 0] as Matrix, clipped: "" },
};
type State = typeof INITIAL;

/** The SVG text of what `draw` draws with the pen, on a canvas of this size. */
export function drawing(
  width: number,
  height: number,
  title: string,
  draw: (pen: CanvasRenderingContext2D) => void,
): string {
  const pen = new SvgPen(width, height);
  draw(pen as unknown as CanvasRenderingContext2D);
  return pen.text(title);
}

/** A new path that fits the pen: for a canvas or for SVG. */
export function pathFor(pen: unknown): Path2D {
  return pen instanceof SvgPen ? (new SvgPath() as unknown as Path2D) : new Path2D();
}

/** Name the group of what the pen draws from now on, until the next name; without effect on a canvas. */
export function group(pen: unknown, name: string): void {
  if (pen instanceof SvgPen) pen.group(name);
}

interface SvgPen extends State {}
class SvgPen extends SvgPath {
  private readonly parts: string[] = [];
  private readonly defs: string[] = [];
  private readonly stack: State[] = [];
  private shades: { shade: Shade; head: string; tail: string }[] = [];
  private groups = 0;

  constructor(
    private readonly width: number,
    private readonly height: number,
  ) {
    super();
    Object.assign(this, INITIAL);
  }

  /** The SVG text of the drawing, with a title. */
  text(title: string): string {
    const shades = this.shades.map(({ shade, head, tail }) => `${head}${shade.stops.join("")}${tail}`);
    return [
      `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${point(this.width, this.height)}" width="${short(this.width)}" height="${short(this.height)}">`,
      `<title>${escaped(title)}</title>`,
      `<defs>${[...shades, ...this.defs].join("")}</defs>`,
      ...this.parts,
      ...Array.from({ length: this.groups }, () => "</g>"),
      "</svg>",
      "",
    ].join("\n");
  }

  /** Begin a named group; it ends at the next name. */
  group(name: string): void {
    this.parts.push(`${this.groups > 0 ? "</g>\n" : ""}<g id="${escaped(name)}">`);
    this.groups = 1;
  }

  // --- state

  save(): void {
    const kept = Object.keys(INITIAL).map((key) => [key, this[key as keyof State]]);
    this.stack.push(Object.fromEntries(kept) as State);
  }

  restore(): void {
    Object.assign(this, this.stack.pop());
  }

  setLineDash(dash: number[]): void {
    this.dash = dash;
  }

  private multiply([a, b, c, d, e, f]: Matrix): void {
    const [g, h, i, j, k, l] = this.matrix;
    this.matrix = [g * a + i * b, h * a + j * b, g * c + i * d, h * c + j * d, g * e + i * f + k, h * e + j * f + l];
  }

  translate(x: number, y: number): void {
    this.multiply([1, 0, 0, 1, x, y]);
  }

  rotate(angle: number): void {
    this.multiply([Math.cos(angle), Math.sin(angle), -Math.sin(angle), Math.cos(angle), 0, 0]);
  }

  scale(x: number, y: number): void {
    this.multiply([x, 0, 0, y, 0, 0]);
  }

  setTransform(a: number, b: number, c: number, d: number, e: number, f: number): void {
    this.matrix = [a, b, c, d, e, f];
  }

  // --- shapes

  beginPath(): void {
    this.commands = [];
  }

  clip(): void {
    const id = `clip-${this.defs.length}`;
    this.defs.push(`<clipPath id="${id}"><path d="${this.commands.join("")}"${this.transform()}/></clipPath>`);
    this.clipped = ` clip-path="url(#${id})"`;
  }

  fill({ commands }: SvgPath = this): void {
    this.add(`<path d="${commands.join("")}" ${this.paint("fill", this.fillStyle)}`);
  }

  stroke({ commands }: SvgPath = this): void {
    if (commands.length > 0) this.add(`<path d="${commands.join("")}" fill="none" ${this.line()}`);
  }

  fillRect(x: number, y: number, width: number, height: number): void {
    this.add(`<rect ${box(x, y, width, height)} ${this.paint("fill", this.fillStyle)}`);
  }

  strokeRect(x: number, y: number, width: number, height: number): void {
    this.add(`<rect ${box(x, y, width, height)} fill="none" ${this.line()}`);
  }

  fillText(text: string, x: number, y: number): void {
    const anchor = { center: "middle", right: "end", end: "end" }[this.textAlign] ?? "start";
    const style = `style="font: ${escaped(this.font)}" text-anchor="${anchor}"`;
    this.add(`<text x="${short(x)}" y="${short(y)}" ${style} ${this.paint("fill", this.fillStyle)}`, escaped(text));
  }

  /** Embed a picture as PNG. */
  drawImage(image: HTMLCanvasElement, x: number, y: number, width: number, height: number): void {
    this.add(`<image ${box(x, y, width, height)} preserveAspectRatio="none" href="${image.toDataURL("image/png")}"`);
  }

  createLinearGradient(x1: number, y1: number, x2: number, y2: number): Shade {
    return this.shade("linearGradient", `x1="${x1}" y1="${y1}" x2="${x2}" y2="${y2}"`);
  }

  createRadialGradient(x1: number, y1: number, _: number, x2: number, y2: number, radius: number): Shade {
    return this.shade("radialGradient", `fx="${x1}" fy="${y1}" cx="${x2}" cy="${y2}" r="${radius}"`);
  }

  private shade(kind: string, where: string): Shade {
    const shade = new Shade(`shade-${this.shades.length}`);
    const head = `<${kind} id="${shade.id}" gradientUnits="userSpaceOnUse" ${where}>`;
    this.shades.push({ shade, head, tail: `</${kind}>` });
    return shade;
  }

  /** SVG attributes of a color: readers of SVG know neither #rrggbbaa nor rgb(r g b / a). */
  private paint(kind: "fill" | "stroke", style: string | Shade): string {
    if (style instanceof Shade) return `${kind}="${style}"`;
    COLOR_PARSER.fillStyle = style;
    const [, r, g, b, alpha] = /rgba\((\d+), (\d+), (\d+), ([\d.]+)\)/.exec(COLOR_PARSER.fillStyle) ?? [];
    return alpha === undefined
      ? `${kind}="${COLOR_PARSER.fillStyle}"`
      : `${kind}="rgb(${r},${g},${b})" ${kind}-opacity="${alpha}"`;
  }

  private line(): string {
    const { strokeStyle, lineWidth, lineCap, lineJoin, dash } = this;
    const dashed = dash.length === 0 ? "" : ` stroke-dasharray="${dash.map(short).join(" ")}"`;
    const width = `stroke-width="${short(lineWidth)}" stroke-linecap="${lineCap}" stroke-linejoin="${lineJoin}"`;
    return `${this.paint("stroke", strokeStyle)} ${width}${dashed}`;
  }

  private transform(): string {
    const { matrix } = this;
    const plain = matrix.join() === "1,0,0,1,0,0";
    return plain ? "" : ` transform="matrix(${matrix.map((value) => Number(value.toFixed(6))).join(" ")})"`;
  }

  private add(head: string, content = ""): void {
    const { globalAlpha, clipped } = this;
    const alpha = globalAlpha === 1 ? "" : ` opacity="${short(globalAlpha)}"`;
    const tag = /^<(\w+)/.exec(head)?.[1] ?? "g";
    const part = `${head}${alpha}${this.transform()}>${content}</${tag}>`;
    this.parts.push(clipped === "" ? part : `<g${clipped}>${part}</g>`);
  }
}

const box = (x: number, y: number, width: number, height: number): string =>
  `x="${short(x)}" y="${short(y)}" width="${short(width)}" height="${short(height)}"`;
