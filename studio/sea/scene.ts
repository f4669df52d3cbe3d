// The three-dimensional scene: canvas, camera, light, labels; drawn only when something has changed. z is up.
import {
  type BufferGeometry,
  Color,
  DirectionalLight,
  Fog,
  HemisphereLight,
  type Material,
  type Object3D,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { colorOf, element } from "../dom.ts";
import { type Box, place, rankOf } from "./labels.ts";

const FIELD_OF_VIEW = 40; // deg, vertical field of view of the camera
const KEY_TURN = Math.PI / 24; // rad that an arrow key turns the picture
const KEY_ZOOM = 1.15; // zoom factor of a key
const LABELS_WIDTH = 84; // px, width that is left for the labels of depths
const VISIBILITY = 40; // m, least distance that one sees through the water

/** A text beside a point of the scene. */
export interface Label {
  box: HTMLElement;
  place: Vector3;
  kind: string;
  way: number; // direction in which it was placed last
}

/** The least and largest x, then the least and largest y. */
function edges(places: Vector3[]): [number, number, number, number] {
  const [xs, ys] = [places.map(({ x }) => x), places.map(({ y }) => y)];
  return [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
}

/** Whether this browser has WebGL 2. */
export function draws(): boolean {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

export class Space {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.05, 5000);
  readonly controls: OrbitControls;
  readonly canvas = element("canvas", "sea-canvas");
  readonly element = element("div", "sea-space");
  stretch = 1; // factor by which depths are drawn larger
  grid = 0; // m between grid lines of the ground
  moved: () => void = () => {}; // called when the camera is moved by hand
  resized: () => void = () => {};
  private readonly renderer: WebGLRenderer;
  private readonly over = element("div", "sea-labels");
  private readonly compass = element("div", "sea-north");
  private readonly bar = element("div", "sea-bar");
  private readonly haze = new Fog(0xffffff);
  private labels: Label[] = [];
  private stale = true;

  constructor() {
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.over.setAttribute("aria-hidden", "true");
    this.compass.innerHTML = '<svg viewBox="-20 -20 40 40"><path d="M0-15 5 6 0 3-5 6Z"/></svg><span>N</span>';
    this.over.append(this.compass, this.bar);
    this.element.append(this.canvas, this.over);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.maxPolarAngle = 0.96 * Math.PI;
    this.controls.enableZoom = false; // the wheel scrolls the page until the picture is chosen
    this.controls.zoomToCursor = false;
    this.controls.addEventListener("change", () => this.renew());
    this.controls.addEventListener("start", () => this.moved());
    this.canvas.addEventListener("focus", () => this.zoomable(true));
    this.canvas.addEventListener("blur", () => this.zoomable(false));
    this.canvas.addEventListener("pointerdown", () => this.canvas.focus({ preventScroll: true }));
    this.canvas.addEventListener("keydown", (event) => this.press(event));
    const sun = new DirectionalLight(0xffffff, 1.6);
    sun.position.set(-0.4, -0.6, 1);
    this.scene.fog = this.haze;
    this.scene.add(new HemisphereLight(0xffffff, 0x8fa6b5, 1.7), sun);
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  /** Request a drawing at the next frame. */
  renew(): void {
    this.stale = true;
  }

  /** Draw if something has changed. */
  draw(): void {
    if (!this.stale || this.element.clientWidth === 0) return;
    this.stale = false;
    const far = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(0.01, far / 200);
    this.camera.far = 40 * far + 400;
    this.camera.updateProjectionMatrix();
    this.haze.color.copy(this.color("sea-low"));
    [this.haze.near, this.haze.far] = [2 * far, Math.max(VISIBILITY, 14 * far)];
    this.renderer.render(this.scene, this.camera);
    this.orient(far);
    this.put();
  }

  /** Let the camera look at a point from a direction, at a distance [m]. */
  look(target: Vector3, from: Vector3, distance: number): void {
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(from.normalize(), distance);
    this.controls.update();
    this.renew();
  }

  /** Let the camera look from a direction so that all points are in the picture. */
  fit(places: Vector3[], from: Vector3): void {
    const middle = new Vector3();
    for (const place of places) middle.addScaledVector(place, 1 / places.length);
    const labels = Math.min(0.6, (2 * LABELS_WIDTH) / Math.max(1, this.element.clientWidth)); // fraction of the width
    const tangent = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const size = Math.max(...places.map((place) => place.distanceTo(middle)));
    for (let distance = 1.4 * size; distance < 12 * size; distance *= 1.04) {
      this.look(middle, from, distance);
      this.camera.updateMatrixWorld();
      const [left, right, low, high] = edges(places.map((place) => place.clone().project(this.camera)));
      // center the points, a little left of the middle to leave space for the labels of depths
      const tall = distance * tangent;
      const [aside, up] = [0, 1].map((axis) => new Vector3().setFromMatrixColumn(this.camera.matrix, axis));
      if (aside === undefined || up === undefined) return;
      middle.addScaledVector(aside, ((left + right + labels) / 2) * tall * this.camera.aspect);
      middle.addScaledVector(up, ((low + high) / 2) * tall);
      if (right - left < 1.9 - labels && high - low < 1.84) return this.look(middle, from, distance);
    }
  }

  zoom(by: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(by);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.moved();
    this.renew();
  }

  /** Pixels per meter at a distance from the camera [m]. */
  scale(distance: number): number {
    return this.element.clientHeight / (2 * distance * Math.tan((FIELD_OF_VIEW * Math.PI) / 360));
  }

  /** Add a text at a point; the label's `place` may be moved later. */
  label(text: string, kind: string): Label {
    const label = { box: element("span", `sea-label ${kind}`, text), place: new Vector3(), kind, way: 0 };
    this.over.append(label.box);
    this.labels.push(label);
    this.labels.sort((a, b) => rankOf(a.kind) - rankOf(b.kind));
    return label;
  }

  unlabel(labels: Label[]): void {
    for (const { box } of labels) box.remove();
    this.labels = this.labels.filter((label) => !labels.includes(label));
  }

  color(name: string): Color {
    return new Color(colorOf(this.element, name));
  }

  private zoomable(on: boolean): void {
    this.controls.enableZoom = on;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.resized();
    this.renew();
    this.draw();
  }

  /** Place the labels beside their points, none over another; labels without space are hidden. */
  private put(): void {
    const bounds = { left: 0, top: 0, wide: this.element.clientWidth, high: this.element.clientHeight };
    const taken = [boxOf(this.compass), boxOf(this.bar)];
    const sizes = this.labels.map(({ box }) => [box.offsetWidth, box.offsetHeight] as const);
    this.labels.forEach((label, k) => {
      const { box, kind, way } = label;
      const seen = label.place
        .clone()
        .setZ(label.place.z * this.stretch)
        .project(this.camera);
      const point = [((seen.x + 1) / 2) * bounds.wide, ((1 - seen.y) / 2) * bounds.high] as const;
      const found = seen.z > 1 || box.hidden ? null : place(kind, point, sizes[k] ?? [0, 0], taken, bounds, way);
      box.style.visibility = found === null ? "hidden" : "visible";
      if (found === null) return;
      label.way = found.way;
      box.style.transform = `translate(${found.box.left.toFixed(1)}px, ${found.box.top.toFixed(1)}px)`;
    });
  }

  /** Update the north arrow, and the scale bar: a round length at the distance of the point that is looked at. */
  private orient(far: number): void {
    const way = new Vector3().subVectors(this.controls.target, this.camera.position);
    const bearing = Math.atan2(way.x, way.y); // clockwise from north
    this.compass.style.setProperty("--turned", `${-bearing}rad`);
    const scale = this.scale(far);
    const power = 10 ** Math.floor(Math.log10(120 / scale));
    const length = Math.max(...[1, 2, 5].map((step) => step * power).filter((step) => step * scale <= 120));
    this.bar.style.width = `${length * scale}px`;
    const size = length >= 1 ? `${length} m` : `${Math.round(1000 * length)} mm`;
    const text = `${size}, grid ${this.grid} m`;
    if (this.bar.textContent !== text) this.bar.textContent = text;
  }

  /** Arrow keys turn the picture, or move it with Shift; plus and minus zoom. */
  private press(event: KeyboardEvent): void {
    const [way, rise] =
      { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key] ?? [];
    if (way !== undefined && rise !== undefined) {
      if (event.shiftKey) this.controls.pan(40 * way, 40 * rise);
      else {
        this.controls.rotateLeft(KEY_TURN * way);
        this.controls.rotateUp(KEY_TURN * rise);
      }
      this.moved();
    } else if (event.key === "+" || event.key === "=") this.zoom(1 / KEY_ZOOM);
    else if (event.key === "-") this.zoom(KEY_ZOOM);
    else return;
    event.preventDefault();
  }
}

const boxOf = ({ offsetLeft: left, offsetTop: top, offsetWidth: wide, offsetHeight: high }: HTMLElement): Box => ({
  ...{ left, top, wide, high },
});

/** Free the memory of drawn objects, and remove them from the scene. */
export function dispose(object: Object3D): void {
  object.traverse((one) => {
    const { geometry, material } = one as { geometry?: BufferGeometry; material?: Material };
    geometry?.dispose();
    material?.dispose();
  });
  object.removeFromParent();
}
