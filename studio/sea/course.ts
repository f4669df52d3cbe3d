// Draws a mission in three dimensions: water, ground, fence, legs, waypoints, home.
import {
  BackSide,
  BufferGeometry,
  CircleGeometry,
  type Color,
  DoubleSide,
  Float32BufferAttribute,
  FrontSide,
  Group,
  Line,
  LineBasicMaterial,
  LineDashedMaterial,
  LineLoop,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  Vector3,
} from "three";
import { roundUp, ticks } from "../chart.ts";
import type { Flight, Mission, Place } from "./flight.ts";
import { cornersOf, type Extent, extentOf } from "./geometry.ts";
import { dispose, type Label, type Space } from "./scene.ts";

const MAX_LABELS = 24; // largest number of waypoints with labels

export class Course {
  readonly group = new Group();
  readonly extent: Extent;
  readonly step: number; // m, distance between lines of the grid
  private readonly mission: Mission;
  private readonly labels: Label[] = [];
  private fine: LineSegments | null = null; // finer lines on the ground, for a near camera
  private readonly ahead: Line; // legs that are still to fly

  constructor(
    private readonly space: Space,
    flight: Flight,
  ) {
    const { mission } = flight.head;
    this.mission = mission;
    this.extent = extentOf(flight);
    const { low, high } = this.extent;
    this.step = roundUp(Math.max(high[0] - low[0], high[1] - low[1]) / 14);
    this.ground();
    this.water();
    if (mission.fence.length > 0) this.fence();
    this.ahead = this.legs();
    mission.waypoints.forEach((point, k) => this.waypoint(point, k));
    this.home();
    this.scale();
  }

  /** Show the legs that are still to fly, from the robot's place to the waypoint of leg `leg` and on from there. */
  go(at: Vector3, leg: number, mode: string): void {
    const corners = cornersOf(this.mission).map((place) => new Vector3(...place));
    const count = this.mission.waypoints.length;
    const next =
      mode === "home" ? count + 1 : mode === "done" || mode === "ended" ? corners.length : Math.min(leg, count) + 1;
    const points = next < corners.length ? [at, ...corners.slice(next)] : [];
    this.ahead.geometry.dispose();
    this.ahead.geometry = new BufferGeometry().setFromPoints(points);
    this.ahead.computeLineDistances();
    this.ahead.visible = points.length > 1;
  }

  /** Show the finer grid if the camera is near. */
  near(distance: number): void {
    const near = distance < 3 * this.step;
    if (this.fine !== null) this.fine.visible = near;
    this.space.grid = near ? this.step / 10 : this.step;
  }

  remove(): void {
    this.space.unlabel(this.labels);
    dispose(this.group);
  }

  // --- parts

  private label(text: string, x: number, y: number, z: number, kind: string): void {
    const label = this.space.label(text, kind);
    label.place.set(x, y, z);
    this.labels.push(label);
  }

  /** A horizontal rectangle over the area. */
  private plane(z: number, color: Color, opacity: number): Mesh {
    const { low, high } = this.extent;
    const mesh = new Mesh(
      new PlaneGeometry(high[0] - low[0], high[1] - low[1]),
      new MeshBasicMaterial({ color, opacity, transparent: opacity < 1, side: DoubleSide, depthWrite: opacity === 1 }),
    );
    mesh.position.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, z);
    this.group.add(mesh);
    return mesh;
  }

  private lines(points: Vector3[], color: Color, opacity: number): LineSegments {
    const material = new LineBasicMaterial({ color, opacity, transparent: true });
    const lines = new LineSegments(new BufferGeometry().setFromPoints(points), material);
    this.group.add(lines);
    return lines;
  }

  /** Draw the surface and the sides of the block of water. */
  private water(): void {
    const color = this.space.color("sea-water");
    const { low, high } = this.extent;
    this.plane(0, color, 0.17).renderOrder = 5;
    const corners = [
      [low[0], low[1]],
      [high[0], low[1]],
      [high[0], high[1]],
      [low[0], high[1]],
    ] as const;
    const edge = ([x, y]: readonly [number, number], z: number): Vector3 => new Vector3(x, y, z);
    const [faces, colors, edges]: [Vector3[], number[], Vector3[]] = [[], [], []];
    corners.forEach((corner, k) => {
      const next = corners[(k + 1) % 4] ?? corner;
      const [a, b, c, d] = [edge(corner, 0), edge(next, 0), edge(corner, low[2]), edge(next, low[2])];
      faces.push(a, c, b, b, c, d); // faces point outward
      for (const depth of [0, 1, 0, 0, 1, 1]) colors.push(color.r, color.g, color.b, depth === 0 ? 0.34 : 0.1);
      edges.push(a, b, a, c);
    });
    const geometry = new BufferGeometry().setFromPoints(faces);
    geometry.setAttribute("color", new Float32BufferAttribute(colors, 4));
    for (const [side, opacity, order] of [
      [BackSide, 1, -1],
      [FrontSide, 0.35, 6],
    ] as const) {
      const material = new MeshBasicMaterial({
        vertexColors: true,
        transparent: true,
        opacity,
        side,
        depthWrite: false,
      });
      const sides = new Mesh(geometry, material);
      sides.renderOrder = order;
      this.group.add(sides);
    }
    this.lines(edges, color, 0.8);
  }

  private ground(): void {
    const { low, high } = this.extent;
    const bottom = -this.mission.bottom;
    this.plane(bottom - 0.002, this.space.color("sea-ground"), 1).renderOrder = -3;
    const lines = (step: number, opacity: number): LineSegments => {
      const points: Vector3[] = [];
      for (const x of ticks([low[0], high[0]], (high[0] - low[0]) / step))
        points.push(new Vector3(x, low[1], bottom), new Vector3(x, high[1], bottom));
      for (const y of ticks([low[1], high[1]], (high[1] - low[1]) / step))
        points.push(new Vector3(low[0], y, bottom), new Vector3(high[0], y, bottom));
      const drawn = this.lines(points, this.space.color("sea-grid"), opacity);
      drawn.renderOrder = -2;
      return drawn;
    };
    lines(this.step, 0.6);
    this.fine = lines(this.step / 10, 0.3);
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

  /** Draw a waypoint: the circle in which it counts as reached, on a pole from ground to surface. */
  private waypoint([x, y, depth, , radius]: Mission["waypoints"][number], k: number): void {
    const color = this.space.color("sea-leg");
    const pole = new Line(
      new BufferGeometry().setFromPoints([new Vector3(x, y, -this.mission.bottom), new Vector3(x, y, 0)]),
      new LineBasicMaterial({ color, transparent: true, opacity: 0.35 }),
    );
    this.group.add(pole, this.ring(x, y, -depth, radius, color));
    const every = Math.ceil(this.mission.waypoints.length / MAX_LABELS);
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
    disc.renderOrder = 1;
    group.add(disc, circle(radius, color, 0.9));
    group.position.set(x, y, z);
    return group;
  }

  /** Draw a scale of depths at a corner. */
  private scale(): void {
    const { low, high } = this.extent;
    const [x, y] = [high[0], low[1]];
    const { bottom } = this.mission;
    const size = 0.012 * Math.hypot(high[0] - low[0], high[1] - low[1]);
    const marks: Vector3[] = [];
    const depths = ticks([0, bottom], 2).filter((depth) => depth > 0 && depth < 0.7 * bottom);
    for (const depth of [0, ...depths, bottom]) {
      marks.push(new Vector3(x, y, -depth), new Vector3(x + size, y, -depth));
      const text = depth === 0 ? "surface" : `${Number(depth.toPrecision(3))} m${depth === bottom ? ", bottom" : ""}`;
      this.label(text, x + size, y, -depth, "faint");
    }
    this.lines(marks, this.space.color("faint"), 1);
  }
}

/** A horizontal circle around the origin. */
export function circle(radius: number, color: Color, opacity: number): LineLoop {
  const points = Array.from({ length: 96 }, (_, k) => {
    const turn = (2 * Math.PI * k) / 96;
    return new Vector3(radius * Math.cos(turn), radius * Math.sin(turn), 0);
  });
  const material = new LineBasicMaterial({ color, transparent: true, opacity });
  return new LineLoop(new BufferGeometry().setFromPoints(points), material);
}
