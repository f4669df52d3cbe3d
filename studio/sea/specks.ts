// Specks that rest in the water around the robot and show how it moves.
import { BufferAttribute, BufferGeometry, type Color, Points, PointsMaterial, type Vector3 } from "three";
import { scatter } from "../body.ts";

const COUNT = 240; // number of specks
const CUBE_SIZE = 6; // m, side of the cube around the robot that holds the specks

export class Specks {
  readonly points: Points<BufferGeometry, PointsMaterial>;
  private readonly home = Float32Array.from({ length: 3 * COUNT }, (_, k) => CUBE_SIZE * scatter(k + 1));
  private readonly places = new Float32Array(3 * COUNT);

  constructor() {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(this.places, 3));
    const material = new PointsMaterial({
      size: 2,
      sizeAttenuation: false,
      transparent: true,
      opacity: 0.5,
      depthWrite: false,
    });
    this.points = new Points(geometry, material);
    this.points.frustumCulled = false;
  }

  paint(color: Color): void {
    this.points.material.color = color;
  }

  /** Keep the specks near a point [m], between ground and surface. */
  around({ x, y, z }: Vector3, bottom: number): void {
    const middle = [x, y, z];
    for (let k = 0; k < this.places.length; k++) {
      const own = middle[k % 3] ?? 0;
      const off = (((((this.home[k] ?? 0) - own) % CUBE_SIZE) + 1.5 * CUBE_SIZE) % CUBE_SIZE) - CUBE_SIZE / 2;
      this.places[k] = k % 3 === 2 ? Math.min(0, Math.max(bottom, own + off)) : own + off;
    }
    this.points.geometry.getAttribute("position").needsUpdate = true;
  }
}
