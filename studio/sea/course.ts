// What a mission is made of, in space: water, ground, fence, legs, waypoints, home.
import {
  BufferAttribute,
  BufferGeometry,
  CircleGeometry,
  type Color,
  DoubleSide,
  Group,
  Line,
  LineBasicMaterial,
  LineDashedMaterial,
  LineLoop,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  RingGeometry,
  Vector3,
} from "three";
import { ticks } from "../chart.ts";
import type { Flight, Mission, Place } from "./flight.ts";
import { cornersOf, type Extent, extentOf } from "./geometry.ts";
import { dispose, type Label, type Space } from "./scene.ts";

const LABELED = 24; // waypoints at most that have labels
const EDGE = 0.12; // part of the area at whose edge water and ground fade

export class Course {
  readonly group = new Group();
  readonly extent: Extent;
  readonly step: number; // m of the grid
  private readonly mission: Mission;
  private readonly labels: Label[] = [];
  private readonly ahead: Line; // legs that are still to fly

  constructor(
    private readonly space: Space,
    flight: Flight,
  ) {
    const { mission } = flight.head;
    this.mission = mission;
    this.extent = extentOf(flight);
    const { low, high } = this.extent;
    this.step = gridStep(Math.max(high[0] - low[0], high[1] - low[1]));
    this.ground();
    this.water();
    if (mission.fence.length > 0) this.fence();
    this.ahead = this.legs();
    mission.waypoints.forEach((point, k) => this.waypoint(point, k));
    this.home();
    this.scale();
  }

  /** Show the legs from where the robot is to the waypoint of a leg, and on from there. */
  go(at: Vector3, leg: number, mode: string): void {
    const corners = cornersOf(this.mission).map((place) => new Vector3(...place));
    const count = this.mission.waypoints.length;
    const next = mode === "home" ? count + 1 : mode === "done" ? corners.length : Math.min(leg, count) + 1;
    const points = next < corners.length ? [at, ...corners.slice(next)] : [];
    this.ahead.geometry.dispose();
    this.ahead.geometry = new BufferGeometry().setFromPoints(points);
    this.ahead.computeLineDistances();
    this.ahead.visible = points.length > 1;
  }

  remove(): void {
    this.space.unlabel(this.labels);
    dispose(this.group);
  }

  // --- parts

  private label(text: string, x: number, y: number, z: number, style = ""): void {
    const label = this.space.label(text, style);
    label.place.set(x, y, z);
    this.labels.push(label);
  }

  /** A level plane that fades at its edges. */
  private plane(z: number, color: Color, opacity: number): Mesh {
    const { low, high } = this.extent;
    const [wide, long] = [high[0] - low[0], high[1] - low[1]];
    const geometry = new PlaneGeometry(wide / (1 - 2 * EDGE), long / (1 - 2 * EDGE), 32, 32);
    const places = geometry.getAttribute("position");
    const colors = new Float32Array(4 * places.count);
    for (let k = 0; k < places.count; k++) {
      const [u, v] = [geometry.getAttribute("uv").getX(k), geometry.getAttribute("uv").getY(k)];
      const edge = Math.min(u, 1 - u, v, 1 - v) / EDGE;
      colors.set([color.r, color.g, color.b, opacity * smooth(edge)], 4 * k);
    }
    geometry.setAttribute("color", new BufferAttribute(colors, 4));
    const material = new MeshBasicMaterial({
      vertexColors: true,
      transparent: true,
      side: DoubleSide,
      depthWrite: false,
    });
    const mesh = new Mesh(geometry, material);
    mesh.position.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, z);
    this.group.add(mesh);
    return mesh;
  }

  private water(): void {
    this.plane(0, this.space.color("sea-water"), 0.3).renderOrder = 5;
  }

  private ground(): void {
    const { low, high } = this.extent;
    const bottom = -this.mission.bottom;
    this.plane(bottom - 0.01, this.space.color("sea-ground"), 1).renderOrder = -3;
    const points: Vector3[] = [];
    for (const x of ticks([low[0], high[0]], (high[0] - low[0]) / this.step))
      points.push(new Vector3(x, low[1], bottom), new Vector3(x, high[1], bottom));
    for (const y of ticks([low[1], high[1]], (high[1] - low[1]) / this.step))
      points.push(new Vector3(low[0], y, bottom), new Vector3(high[0], y, bottom));
    const lines = new LineSegments(
      new BufferGeometry().setFromPoints(points),
      new LineBasicMaterial({ color: this.space.color("sea-grid"), transparent: true, opacity: 0.7 }),
    );
    lines.renderOrder = -2;
    this.group.add(lines);
  }

  private fence(): void {
    const { fence, bottom } = this.mission;
    const color = this.space.color("sea-fence");
    const at = ([x, y]: Place, z: number): Vector3 => new Vector3(x, y, z);
    for (const z of [0, -bottom]) {
      const line = new LineLoop(
        new BufferGeometry().setFromPoints(fence.map((corner) => at(corner, z))),
        new LineBasicMaterial({ color, transparent: true, opacity: z === 0 ? 1 : 0.5 }),
      );
      this.group.add(line);
    }
    const sides = fence.flatMap((corner, k) => {
      const next = fence[(k + 1) % fence.length] ?? corner;
      const [a, b, c, d] = [at(corner, 0), at(next, 0), at(corner, -bottom), at(next, -bottom)];
      return [a, b, c, b, d, c];
    });
    const wall = new Mesh(
      new BufferGeometry().setFromPoints(sides),
      new MeshBasicMaterial({ color, transparent: true, opacity: 0.07, side: DoubleSide, depthWrite: false }),
    );
    wall.renderOrder = 4;
    this.group.add(wall);
    const corner = fence[0];
    if (corner !== undefined) this.label("fence", corner[0], corner[1], 0, "faint");
  }

  private legs(): Line {
    const color = this.space.color("sea-leg");
    const whole = new Line(
      new BufferGeometry().setFromPoints(cornersOf(this.mission).map((place) => new Vector3(...place))),
      new LineBasicMaterial({ color, transparent: true, opacity: 0.3 }),
    );
    const { low, high } = this.extent;
    const dash = Math.hypot(high[0] - low[0], high[1] - low[1]) / 120;
    const ahead = new Line(
      new BufferGeometry(),
      new LineDashedMaterial({ color, dashSize: dash, gapSize: 0.7 * dash }),
    );
    ahead.frustumCulled = false;
    this.group.add(whole, ahead);
    return ahead;
  }

  /** A waypoint: the circle within which it is reached, on a pole from the ground to the surface. */
  private waypoint([x, y, depth, , radius]: Mission["waypoints"][number], k: number): void {
    const color = this.space.color("sea-leg");
    const pole = new Line(
      new BufferGeometry().setFromPoints([new Vector3(x, y, -this.mission.bottom), new Vector3(x, y, 0)]),
      new LineBasicMaterial({ color, transparent: true, opacity: 0.35 }),
    );
    this.group.add(pole, this.ring(x, y, -depth, radius, color));
    const every = Math.ceil(this.mission.waypoints.length / LABELED);
    if (k % every === 0) this.label(String(k + 1), x, y, -depth, "stop");
  }

  private home(): void {
    const [x, y] = this.mission.home;
    this.group.add(this.ring(x, y, 0, this.mission.home_radius, this.space.color("sea-home")));
    this.label("home", x, y, 0, "home");
  }

  private ring(x: number, y: number, z: number, radius: number, color: Color): Group {
    const group = new Group();
    const disc = new Mesh(
      new CircleGeometry(radius, 48),
      new MeshBasicMaterial({ color, transparent: true, opacity: 0.14, side: DoubleSide, depthWrite: false }),
    );
    const edge = new Mesh(
      new RingGeometry(0.96 * radius, radius, 48),
      new MeshBasicMaterial({ color, transparent: true, opacity: 0.9, side: DoubleSide, depthWrite: false }),
    );
    [disc.renderOrder, edge.renderOrder] = [1, 2];
    group.add(disc, edge);
    group.position.set(x, y, z);
    return group;
  }

  /** Depths at a corner. */
  private scale(): void {
    const { low, high } = this.extent;
    const [x, y] = [high[0], low[1]];
    const { bottom } = this.mission;
    const pole = new Line(
      new BufferGeometry().setFromPoints([new Vector3(x, y, -bottom), new Vector3(x, y, 0)]),
      new LineBasicMaterial({ color: this.space.color("faint") }),
    );
    this.group.add(pole);
    this.label("surface", x, y, 0, "faint");
    this.label(`bottom, ${Number(bottom.toPrecision(3))} m`, x, y, -bottom, "faint");
  }
}

function gridStep(size: number): number {
  const power = 10 ** Math.floor(Math.log10(size / 10));
  return ([1, 2, 5, 10].find((step) => step * power * 14 >= size) ?? 10) * power;
}

const smooth = (part: number): number => {
  const t = Math.min(1, Math.max(0, part));
  return t * t * (3 - 2 * t);
};
