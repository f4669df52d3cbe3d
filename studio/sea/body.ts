// The robot in three dimensions: a body lofted from its links' widths and heights, turning fins, a bending tail.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  Group,
  Mesh,
  MeshLambertMaterial,
  type Object3D,
  SphereGeometry,
} from "three";
import { at, between, curve, Shape, type Station } from "../body.ts";
import { bendsOf, type Robot } from "../robot.ts";

const SECTION_POINTS = 20; // points around a section of the body
const EDGE_POINTS = 12; // points along a fin's edges
const CHORD_POINTS = 3; // points between a fin's two edges

export interface Paint {
  back: Color;
  flank: Color;
  fin: Color;
  eye: Color;
}

type Place = [number, number, number];

/** A surface through rows of points that can be moved. */
class Sheet {
  readonly mesh: Mesh<BufferGeometry, MeshLambertMaterial>;
  private readonly points: Float32Array;

  constructor(
    private readonly rows: number,
    private readonly columns: number,
    closed: boolean,
    material: MeshLambertMaterial,
  ) {
    this.points = new Float32Array(3 * rows * columns);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(this.points, 3));
    const faces: number[] = [];
    for (let i = 0; i + 1 < rows; i++)
      for (let j = 0; j + (closed ? 0 : 1) < columns; j++) {
        const [a, b] = [i * columns + j, i * columns + ((j + 1) % columns)];
        faces.push(a, b, a + columns, b, b + columns, a + columns);
      }
    geometry.setIndex(faces);
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
  }

  /** Move each point to `place` of its row and column. */
  shape(place: (row: number, column: number) => Place): void {
    for (let i = 0; i < this.rows; i++)
      for (let j = 0; j < this.columns; j++) this.points.set(place(i, j), 3 * (i * this.columns + j));
    const { geometry } = this.mesh;
    geometry.computeVertexNormals();
    for (const name of ["position", "normal"]) geometry.getAttribute(name).needsUpdate = true;
  }

  /** Color the points by their height above the body's middle, from `low` below to `high` above. */
  shade(high: Color, low: Color): void {
    const colors = new Float32Array(this.points.length);
    for (let i = 0; i < this.rows; i++)
      for (let j = 0; j < this.columns; j++) {
        const rise = Math.sin((2 * Math.PI * j) / this.columns);
        const mixed = low.clone().lerp(high, Math.min(1, Math.max(0, 0.35 + 0.9 * rise)));
        mixed.toArray(colors, 3 * (i * this.columns + j));
      }
    this.mesh.geometry.setAttribute("color", new BufferAttribute(colors, 3));
  }
}

/** The robot at true size [m]; its nose is the origin, x runs to the tail, y to starboard, z up. */
export class Body {
  readonly model: Object3D = new Group();
  readonly length: number;
  private readonly shape: Shape;
  private readonly skin: MeshLambertMaterial;
  private readonly web: MeshLambertMaterial;
  private readonly dark: MeshLambertMaterial;
  private readonly hull: Sheet;
  private readonly lobes: Sheet[] = [];
  private readonly ridge: Sheet | null;
  private readonly fins: Sheet[] = [];
  private readonly eyes: Mesh[] = [];

  constructor(private readonly robot: Robot) {
    this.shape = new Shape(robot);
    this.length = this.shape.length;
    this.skin = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide });
    this.web = new MeshLambertMaterial({ side: DoubleSide, transparent: true, opacity: 0.9 });
    this.dark = new MeshLambertMaterial();
    const rest = this.shape.stations({ x: 0, y: 0, heading: 0 }, []);
    this.hull = new Sheet(rest.length, SECTION_POINTS, true, this.skin);
    this.model.add(this.hull.mesh);
    const blade = (): Sheet => {
      const sheet = new Sheet(EDGE_POINTS, CHORD_POINTS, false, this.web);
      this.model.add(sheet.mesh);
      return sheet;
    };
    if (this.shape.fin < 1) this.lobes = [blade(), blade()];
    this.ridge = this.shape.fin < 1 ? blade() : null;
    if (robot.fins !== null) this.fins = [blade(), blade()];
    for (let k = 0; k < 2; k++) {
      const eye = new Mesh(new SphereGeometry(0.011 * this.length, 10, 8), this.dark);
      this.eyes.push(eye);
      this.model.add(eye);
    }
    this.bend([], [0, 0]);
  }

  /** Take the colors of the page's theme. */
  paint({ back, flank, fin, eye }: Paint): void {
    this.hull.shade(back, flank);
    this.web.color = fin;
    this.dark.color = eye;
  }

  /** Bend the joint groups [rad], and turn the port and starboard fins [rad, positive with the leading edge up]. */
  bend(angles: ArrayLike<number>, fins: readonly [number, number]): void {
    const stations = this.shape.stations({ x: 0, y: 0, heading: 0 }, bendsOf(this.robot, angles));
    this.hull.shape((i, j) => this.around(stations[i], (2 * Math.PI * j) / SECTION_POINTS));
    this.lobes.forEach((sheet, k) => this.lobe(sheet, stations, k === 0 ? 1 : -1));
    if (this.ridge !== null) this.back(this.ridge, stations);
    this.fins.forEach((sheet, k) => this.fin(sheet, k === 0 ? -1 : 1, fins[k] ?? 0));
    const head = at(stations, 0.075);
    this.eyes.forEach((eye, k) => {
      eye.position.set(head.x, (k === 0 ? -0.9 : 0.9) * head.half, 0.15 * this.high(head));
    });
  }

  /** Half height of the body at a station [m]: its half width, times the link's ratio of height to width there. */
  private high({ part, half }: Station): number {
    const ratios = this.robot.links.map(({ width, height }) => (width && height ? height / width : 1.6));
    return half * between(this.shape.middles, ratios, part * this.length);
  }

  private around(station: Station | undefined, turn: number): Place {
    if (station === undefined) return [0, 0, 0];
    const side = station.half * Math.cos(turn);
    return [
      station.x - side * Math.sin(station.angle),
      station.y + side * Math.cos(station.angle),
      this.high(station) * Math.sin(turn),
    ];
  }

  /** Shape one lobe of the caudal fin, upper (1) or lower (-1): a crescent. */
  private lobe(sheet: Sheet, stations: readonly Station[], side: number): void {
    const height = this.robot.tail.edge_height ?? 0;
    const root = this.shape.fin + 0.12 * (1 - this.shape.fin);
    sheet.shape((i, j) => {
      const t = i / (EDGE_POINTS - 1);
      const front = curve([0, 0.04], [0.35, 0.55], [1, 1], t);
      const end = curve([0.68, 0], [0.62, 0.45], [1, 1], t);
      const s = j / (CHORD_POINTS - 1);
      const { x, y } = at(stations, root + (front[0] + s * (end[0] - front[0])) * (1 - root));
      return [x, y, ((front[1] + s * (end[1] - front[1])) * side * height) / 2];
    });
  }

  /** Shape the dorsal fin: a thin blade on the back. */
  private back(sheet: Sheet, stations: readonly Station[]): void {
    sheet.shape((i, j) => {
      const t = i / (EDGE_POINTS - 1);
      const front = curve([0, 0], [0.55, 0.03], [0.9, 0.085], t);
      const end = curve([1, 0], [0.78, 0.02], [0.9, 0.085], t);
      const s = j / (CHORD_POINTS - 1);
      const station = at(stations, 0.32 + 0.18 * (front[0] + s * (end[0] - front[0])));
      const foot = 0.96 * this.high(station);
      return [station.x, station.y, foot + (front[1] + s * (end[1] - front[1])) * this.length];
    });
  }

  /** Shape a pectoral fin, port (-1) or starboard (1), turned about the axis through its root [rad]. */
  private fin(sheet: Sheet, side: number, angle: number): void {
    const { fins } = this.robot;
    if (fins === null) return;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    sheet.shape((i, j) => {
      const t = i / (EDGE_POINTS - 1);
      const [lead, tail] = [-0.35 + 0.5 * t * t, 0.65 - 0.05 * t - 0.15 * t * t];
      const along = fins.chord * (lead + (j / (CHORD_POINTS - 1)) * (tail - lead));
      return [fins.x + along * c, side * (fins.y + (t - 0.5) * fins.span), fins.z - along * s];
    });
  }
}
