// Draws a flight in three dimensions: its course, its track, the robot at true size, and where it believes that it is.
import {
  BufferGeometry,
  CircleGeometry,
  Color,
  ConeGeometry,
  DoubleSide,
  Group,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  Vector3,
} from "three";
import type { Robot } from "../robot.ts";
import { Body } from "./body.ts";
import type { By } from "./colors.ts";
import { circle, Course } from "./course.ts";
import type { Flight } from "./flight.ts";
import { type Moment, momentOf } from "./moment.ts";
import { dispose, type Label, Space } from "./scene.ts";
import { Specks } from "./specks.ts";
import { Track } from "./track.ts";

const ARROW_SIZE = 22; // px: a robot shorter than two of these gets an arrow of this size
const FOLLOW_DISTANCE = 4.2; // distance of the camera that follows the robot, body lengths
const STRETCHES = [1, 2, 5, 10, 20]; // factors by which depths can be drawn larger
const MIN_FLATNESS = 0.14; // least depth of the drawn water over the size of the area

export type Sight = "overview" | "follow";

export class Picture {
  readonly space = new Space();
  sight: Sight | null = "overview"; // null after the camera was moved by hand
  private readonly world = new Group(); // everything whose depths are drawn larger
  private readonly fish = new Group();
  private readonly arrow: Mesh;
  private readonly spread = new Group(); // circle of two standard deviations around the believed place
  private readonly plumb: Line;
  private readonly specks = new Specks();
  private readonly name: Label;
  private readonly guess: Label;
  private body: Body | null = null;
  private flight: Flight | null = null;
  private course: Course | null = null;
  private track: Track | null = null;
  private by: By = "mode";
  private last = new Vector3(); // place of the robot when it was drawn last
  private leg = "";

  get element(): HTMLElement {
    return this.space.element;
  }

  get canvas(): HTMLCanvasElement {
    return this.space.canvas;
  }

  constructor(changed: () => void) {
    const { space } = this;
    space.scene.add(this.world, this.fish, this.specks.points);
    this.arrow = new Mesh(new ConeGeometry(0.42, 1.3, 20).rotateZ(Math.PI / 2), new MeshBasicMaterial());
    this.plumb = new Line(new BufferGeometry(), new LineBasicMaterial({ transparent: true, opacity: 0.35 }));
    this.plumb.frustumCulled = false;
    const disc = new MeshBasicMaterial({ transparent: true, opacity: 0.16, side: DoubleSide, depthWrite: false });
    this.spread.add(new Mesh(new CircleGeometry(1, 96), disc), circle(1, new Color(), 0.9));
    this.fish.add(this.arrow);
    this.world.add(this.spread, this.plumb);
    this.name = space.label("", "robot");
    this.guess = space.label("believed", "believed");
    space.resized = () => {
      if (this.sight === "overview") this.overview();
    };
    space.moved = () => {
      if (this.sight === "overview") this.sight = null;
      changed();
    };
  }

  /** Show a flight, with the body of its robot if the page knows the robot. */
  set(flight: Flight, robot: Robot | null): void {
    this.flight = flight;
    if (this.body !== null) dispose(this.body.model);
    this.body = robot === null ? null : new Body(robot);
    if (this.body !== null) this.fish.add(this.body.model);
    this.name.box.textContent = flight.head.robot;
    this.space.stretch = this.fitting();
    this.sight = "overview";
    this.refresh();
    this.overview();
  }

  /** Draw everything again, in the colors of the page's theme. */
  refresh(): void {
    const { flight, space } = this;
    if (flight === null) return;
    this.course?.remove();
    this.track?.remove();
    this.course = new Course(space, flight);
    this.track = new Track(space, flight, this.by);
    this.world.add(this.course.group, this.track.group);
    this.leg = "";
    const color = (name: string) => space.color(name);
    this.body?.paint({ back: color("back"), flank: color("flank"), fin: color("fin"), eye: color("eye") });
    (this.arrow.material as MeshBasicMaterial).color = color("sea-robot");
    (this.plumb.material as LineBasicMaterial).color = color("ink");
    this.specks.paint(color("speck"));
    for (const part of this.spread.children) {
      (part as Mesh<BufferGeometry, MeshBasicMaterial>).material.color = color("sea-believed");
    }
    space.renew();
  }

  color(by: By): void {
    this.by = by;
    this.track?.remove();
    if (this.flight === null) return;
    this.track = new Track(this.space, this.flight, by);
    this.world.add(this.track.group);
    this.space.renew();
  }

  grow(): void {
    this.track?.grow();
    this.space.renew();
  }

  /** Set the factor by which depths are drawn larger than lengths. */
  deepen(stretch: number): void {
    this.space.stretch = stretch;
    if (this.sight === "overview") this.overview();
    this.space.renew();
  }

  see(sight: Sight): void {
    this.sight = sight;
    if (sight === "overview") this.overview();
    else this.space.look(this.last, new Vector3(0.75, -0.75, 0.4), FOLLOW_DISTANCE * (this.body?.length ?? 1));
  }

  /** Show the flight at a time [s]. */
  show(time: number): void {
    const { flight } = this;
    if (flight === null || flight.count === 0) return;
    const moment = momentOf(flight, time);
    this.world.scale.z = this.space.stretch;
    this.track?.until(moment.exact);
    this.place(moment);
    this.believe(flight, moment.row);
    const leg = `${flight.value("leg", moment.row)} ${flight.mode(moment.row).name} ${Math.floor(moment.row / 10)}`;
    if (leg !== this.leg) {
      this.leg = leg;
      this.course?.go(moment.position, flight.value("leg", moment.row), flight.mode(moment.row).name);
    }
    this.space.renew();
  }

  /** Draw if something has changed. */
  draw(): void {
    this.size();
    this.space.draw();
  }

  // --- parts

  private place({ position, attitude, angles, fins }: Moment): void {
    const shown = new Vector3(position.x, position.y, position.z * this.space.stretch);
    if (this.sight === "follow") {
      const { camera, controls } = this.space;
      const step = shown.clone().sub(controls.target);
      camera.position.add(step);
      controls.target.copy(shown);
      controls.update();
    }
    this.last.copy(shown);
    this.fish.position.copy(shown);
    this.fish.quaternion.copy(attitude);
    this.body?.bend(angles, fins);
    const bottom = -(this.flight?.head.mission.bottom ?? 0);
    const ends = [new Vector3(position.x, position.y, 0), new Vector3(position.x, position.y, bottom)];
    this.plumb.geometry.setFromPoints(ends);
    this.specks.around(shown, bottom * this.space.stretch);
    this.name.place.copy(position);
  }

  private believe(flight: Flight, row: number): void {
    const [x, y, z] = flight.believed(row);
    const error = flight.value("position_error", row);
    const known = flight.true && Number.isFinite(x) && Number.isFinite(error);
    this.spread.visible = known;
    this.guess.box.hidden = !known;
    if (!known) return;
    this.spread.position.set(x, y, z);
    const radius = Math.max(0.02, 2 * error);
    this.spread.scale.set(radius, radius, 1);
    this.guess.place.set(x, y - radius, z);
  }

  /** Show an arrow of constant size on the screen if the robot is too small to see. */
  private size(): void {
    const { space, fish, body } = this;
    const scale = space.scale(space.camera.position.distanceTo(fish.position));
    const length = body?.length ?? 0;
    this.arrow.visible = length * scale < 2 * ARROW_SIZE;
    this.arrow.scale.setScalar(ARROW_SIZE / scale);
    this.specks.points.visible = !this.arrow.visible && body !== null;
    this.course?.near(space.camera.position.distanceTo(space.controls.target));
    const [disc] = this.spread.children;
    if (disc !== undefined) disc.visible = this.spread.scale.x * scale < 0.45 * space.element.clientHeight;
    this.name.box.hidden = length * scale > 3 * ARROW_SIZE;
  }

  private overview(): void {
    if (this.course === null) return;
    const { low, high } = this.course.extent;
    const corners = [low, high].flatMap(([x]) =>
      [low, high].flatMap(([, y]) => [low, high].map(([, , z]) => new Vector3(x, y, z * this.space.stretch))),
    );
    this.space.fit(corners, new Vector3(0.32, -0.9, 0.62));
  }

  /** The least factor for depths with which the water of a wide area is deep enough to see. */
  private fitting(): number {
    const { mission } = this.flight?.head ?? {};
    if (mission === undefined) return 1;
    const places = [mission.start, mission.home, ...mission.waypoints, ...mission.fence];
    const span = (k: number): number =>
      Math.max(...places.map((p) => p[k] ?? 0)) - Math.min(...places.map((p) => p[k] ?? 0));
    const size = Math.max(span(0), span(1), 1);
    return STRETCHES.find((stretch) => (stretch * mission.bottom) / size >= MIN_FLATNESS) ?? 20;
  }
}

export { STRETCHES };
