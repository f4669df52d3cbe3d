// The three-dimensional track: flown part thick and colored, rest of a log faint; and the track that the robot
// believes.
import { BufferAttribute, BufferGeometry, Color, Group, Line, LineBasicMaterial, SRGBColorSpace } from "three";
import { Line2 } from "three/addons/lines/Line2.js";
import { LineGeometry } from "three/addons/lines/LineGeometry.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { type By, colorOf, rangeOf } from "./colors.ts";
import type { Flight } from "./flight.ts";
import { placeOf } from "./moment.ts";
import { dispose, type Space } from "./scene.ts";

const MAX_POINTS = 8000; // largest number of points of the drawn track
const POINTS_PER_ROW = 3; // most points per row of the flight: a beat has few rows
const LINE_WIDTH = 3; // px, width of the flown track

/** A thin line; `until` limits it to its first points. */
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
  private step = 1; // rows of the flight per point

  constructor(
    private readonly space: Space,
    private readonly flight: Flight,
    private readonly by: By,
  ) {
    this.flown = new Line2(
      new LineGeometry(),
      new LineMaterial({ linewidth: LINE_WIDTH, vertexColors: true, fog: true }),
    );
    this.flown.frustumCulled = false;
    this.whole = new Thin(space.color("sea-leg"), 0.35);
    this.believed = new Thin(space.color("sea-believed"), 0.8);
    this.shadow = new Thin(space.color("ink"), 0.22);
    this.group.add(this.flown, this.whole.line, this.shadow.line);
    if (flight.true && flight.has("position_estimated")) this.group.add(this.believed.line);
    this.grow();
  }

  /** Take new rows of the flight. */
  grow(): void {
    const { flight } = this;
    const last = flight.count - 1;
    if (last < 1) return;
    this.step = Math.max(1 / POINTS_PER_ROW, flight.count / MAX_POINTS);
    this.step = this.step < 1 ? 1 / Math.floor(1 / this.step) : Math.ceil(this.step);
    const rows = Array.from({ length: Math.floor(last / this.step) + 1 }, (_, k) => k * this.step);
    const points = Float32Array.from(rows.flatMap((row) => placeOf(flight, row)));
    this.flown.geometry.dispose();
    this.flown.geometry = new LineGeometry();
    this.flown.geometry.setPositions(points);
    this.flown.geometry.setColors(this.colors(rows));
    this.whole.set(points);
    const ground = -flight.head.mission.bottom + 0.005;
    this.shadow.set(points.map((value, k) => (k % 3 === 2 ? ground : value)));
    if (this.believed.line.parent !== null)
      this.believed.set(Float32Array.from(rows.flatMap((row) => flight.believed(Math.round(row)))));
  }

  private colors(rows: number[]): number[] {
    const { flight } = this;
    const range = rangeOf(flight, this.by);
    const known = new Map<string, readonly number[]>();
    const named = (name: string): readonly number[] => {
      const channels = known.get(name) ?? this.space.color(name).toArray();
      known.set(name, channels);
      return channels;
    };
    return rows.flatMap((row) => {
      const channels = colorOf(flight, this.by, Math.round(row), range, named);
      const [r = 0, g = 0, b = 0] = channels;
      return this.by === "mode" ? [r, g, b] : new Color().setRGB(r, g, b, SRGBColorSpace).toArray();
    });
  }

  /** Draw the track up to a row, which may be fractional. */
  until(row: number): void {
    const count = Math.floor(row / this.step);
    this.flown.geometry.instanceCount = Math.max(0, count);
    this.flown.visible = count > 0;
    this.believed.until(count + 1);
    this.shadow.until(count + 1);
  }

  remove(): void {
    dispose(this.group);
  }
}
