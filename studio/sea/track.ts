// The track in space: what is flown, thick and colored; what a log has beyond it, faint; what the robot believes.
import { BufferAttribute, BufferGeometry, Color, Group, Line, LineBasicMaterial, SRGBColorSpace } from "three";
import { Line2 } from "three/addons/lines/Line2.js";
import { LineGeometry } from "three/addons/lines/LineGeometry.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { type By, colorOf, rangeOf } from "./colors.ts";
import type { Flight } from "./flight.ts";
import { dispose, type Space } from "./scene.ts";

const POINTS = 5000; // of the drawn track at most
const WIDTH = 3; // px

/** A thin line of which the first part is drawn. */
class Thin {
  readonly line: Line<BufferGeometry, LineBasicMaterial>;

  constructor(color: Color, opacity: number) {
    this.line = new Line(new BufferGeometry(), new LineBasicMaterial({ color, transparent: true, opacity }));
    this.line.frustumCulled = false;
  }

  set(points: Float32Array): void {
    this.line.geometry.dispose();
    this.line.geometry = new BufferGeometry();
    this.line.geometry.setAttribute("position", new BufferAttribute(points, 3));
  }

  until(count: number): void {
    this.line.geometry.setDrawRange(0, count);
  }
}

export class Track {
  readonly group = new Group();
  private readonly flown: Line2;
  private readonly whole: Thin;
  private readonly believed: Thin;
  private readonly shadow: Thin;
  private rows: number[] = []; // that are drawn

  constructor(
    private readonly space: Space,
    private readonly flight: Flight,
    private readonly by: By,
  ) {
    this.flown = new Line2(new LineGeometry(), new LineMaterial({ linewidth: WIDTH, vertexColors: true }));
    this.flown.frustumCulled = false;
    this.whole = new Thin(space.color("sea-leg"), 0.35);
    this.believed = new Thin(space.color("sea-believed"), 0.8);
    this.shadow = new Thin(space.color("ink"), 0.22);
    this.group.add(this.flown, this.whole.line, this.shadow.line);
    if (flight.true && flight.has("position_estimated")) this.group.add(this.believed.line);
    this.grow();
  }

  /** Take the rows that have come. */
  grow(): void {
    const { flight } = this;
    const every = Math.max(1, Math.ceil(flight.count / POINTS));
    this.rows = [];
    for (let k = 0; k < flight.count; k += every) this.rows.push(k);
    if (this.rows.length < 2) return;
    const points = Float32Array.from(this.rows.flatMap((k) => flight.position(k)));
    const range = rangeOf(flight, this.by);
    const known = new Map<string, readonly number[]>();
    const named = (name: string): readonly number[] => {
      const channels = known.get(name) ?? this.space.color(name).toArray();
      known.set(name, channels);
      return channels;
    };
    const colors = this.rows.flatMap((k) => {
      const channels = colorOf(flight, this.by, k, range, named);
      const [r = 0, g = 0, b = 0] = channels;
      return this.by === "mode" ? [r, g, b] : new Color().setRGB(r, g, b, SRGBColorSpace).toArray();
    });
    this.flown.geometry.dispose();
    this.flown.geometry = new LineGeometry();
    this.flown.geometry.setPositions(points);
    this.flown.geometry.setColors(colors);
    this.whole.set(points);
    const ground = -flight.head.mission.bottom + 0.005;
    this.shadow.set(points.map((value, k) => (k % 3 === 2 ? ground : value)));
    if (this.believed.line.parent !== null)
      this.believed.set(Float32Array.from(this.rows.flatMap((k) => flight.believed(k))));
  }

  /** Draw what is flown until a row. */
  until(row: number): void {
    const every = (this.rows[1] ?? 1) - (this.rows[0] ?? 0);
    const count = Math.floor(row / every);
    this.flown.geometry.instanceCount = Math.max(0, count);
    this.flown.visible = count > 0;
    this.believed.until(count + 1);
    this.shadow.until(count + 1);
  }

  remove(): void {
    dispose(this.group);
  }
}
