// The robot in space: a body lofted from widths and heights of its links, fins that turn, a tail that bends.
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

const AROUND = 20; // points of a section
const ALONG = 12; // of a fin's edges
const ACROSS = 3; // between them

export interface Paint {
  back: Color;
  flank: Color;
  fin: Color;
  eye: Color;
}

type Place = [number, number, number];

/** A sheet of points in rows, which move with the body. */
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

  /** Move the points. */
  shape(place: (row: number, column: number) => Place): void {
    for (let i = 0; i < this.rows; i++)
      for (let j = 0; j < this.columns; j++) this.points.set(place(i, j), 3 * (i * this.columns + j));
    const { geometry } = this.mesh;
    geometry.computeVertexNormals();
    for (const name of ["position", "normal"]) geometry.getAttribute(name).needsUpdate = true;
  }

  /** Color the points by how far they are above the middle, -1 to 1. */
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

/** The robot at true size; its nose is the origin, x runs to the tail, y to starboard, z up. */
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
    this.hull = new Sheet(rest.length, AROUND, true, this.skin);
    this.model.add(this.hull.mesh);
    const blade = (): Sheet => {
      const sheet = new Sheet(ALONG, ACROSS, false, this.web);
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

  /** Colors of the page's theme. */
  paint({ back, flank, fin, eye }: Paint): void {
    this.hull.shade(back, flank);
    this.web.color = fin;
    this.dark.color = eye;
  }

  /** Bend the joint groups [rad], and turn the port and the starboard fin [rad, leading edge up]. */
  bend(angles: ArrayLike<number>, fins: readonly [number, number]): void {
    const stations = this.shape.stations({ x: 0, y: 0, heading: 0 }, bendsOf(this.robot, angles));
    this.hull.shape((i, j) => this.around(stations[i], (2 * Math.PI * j) / AROUND));
    this.lobes.forEach((sheet, k) => this.lobe(sheet, stations, k === 0 ? 1 : -1));
    if (this.ridge !== null) this.back(this.ridge, stations);
    this.fins.forEach((sheet, k) => this.fin(sheet, k === 0 ? -1 : 1, fins[k] ?? 0));
    const head = at(stations, 0.075);
    this.eyes.forEach((eye, k) => {
      eye.position.set(head.x, (k === 0 ? -0.9 : 0.9) * head.half, 0.15 * this.high(head));
    });
  }

  /** Half height of the body at a station: as much more than its half width as the link's there. */
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

  /** One lobe of the caudal fin, up (1) or down (-1): a crescent. */
  private lobe(sheet: Sheet, stations: readonly Station[], side: number): void {
    const height = this.robot.tail.edge_height ?? 0;
    const root = this.shape.fin + 0.12 * (1 - this.shape.fin);
    sheet.shape((i, j) => {
      const t = i / (ALONG - 1);
      const front = curve([0, 0.04], [0.35, 0.55], [1, 1], t);
      const end = curve([0.68, 0], [0.62, 0.45], [1, 1], t);
      const s = j / (ACROSS - 1);
      const { x, y } = at(stations, root + (front[0] + s * (end[0] - front[0])) * (1 - root));
      return [x, y, ((front[1] + s * (end[1] - front[1])) * side * height) / 2];
    });
  }

  /** The dorsal fin: a thin blade on the back. */
  private back(sheet: Sheet, stations: readonly Station[]): void {
    sheet.shape((i, j) => {
      const t = i / (ALONG - 1);
      const front = curve([0, 0], [0.55, 0.03], [0.9, 0.085], t);
      const end = curve([1, 0], [0.78, 0.02], [0.9, 0.085], t);
      const s = j / (ACROSS - 1);
      const station = at(stations, 0.32 + 0.18 * (front[0] + s * (end[0] - front[0])));
      const foot = 0.96 * this.high(station);
      return [station.x, station.y, foot + (front[1] + s * (end[1] - front[1])) * this.length];
    });
  }

  /** A pectoral fin, port (-1) or starboard (1), turned about the axis through its root. */
  private fin(sheet: Sheet, side: number, angle: number): void {
    const { fins } = this.robot;
    if (fins === null) return;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    sheet.shape((i, j) => {
      const t = i / (ALONG - 1);
      const [lead, tail] = [-0.35 + 0.5 * t * t, 0.65 - 0.05 * t - 0.15 * t * t];
      const along = fins.chord * (lead + (j / (ACROSS - 1)) * (tail - lead));
      return [fins.x + along * c, side * (fins.y + (t - 0.5) * fins.span), fins.z - along * s];
    });
  }
}
