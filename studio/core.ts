// The core in WebAssembly: calls of the C interface, hosts/hypertuna.h.

/** Runge-Kutta steps of a beat. */
export const STEPS = 128;

const FAULT_ROOM = 512; // bytes of a sentence
const START_SIZE = 64; // bytes of an ht_start
const START_BOTTOM = 56; // place of its depth of the bottom

interface Exports {
  memory: WebAssembly.Memory;
  malloc(size: number): number;
  free(place: number): void;
  _initialize?(): void;
  ht_robot_read(image: number, size: number, fault: number, room: number): number;
  ht_robot_free(robot: number): void;
  ht_robot_text(robot: number, size: number): number;
  ht_robot_groups(robot: number): number;
  ht_robot_links(robot: number): number;
  ht_quantity(index: number): number;
  ht_quantity_label(index: number): number;
  ht_quantity_unit(index: number): number;
  ht_quantity_shown(index: number): number;
  ht_verdict(gait: number, quantities: number, text: number, room: number): void;
  ht_derivative(index: number): number;
  ht_swim(robot: number, model: number, gaits: number, count: number, follow: number, quantities: number): void;
  ht_gradient(robot: number, model: number, gait: number, derivatives: number): void;
  ht_twin_create(robot: number, start: number, fault: number, room: number): number;
  ht_twin_fly(robot: number, mission: number, seed: number, fault: number, room: number): number;
  ht_twin_free(twin: number): void;
  ht_twin_command(twin: number, gait: number, fins: number, armed: number): void;
  ht_twin_break(twin: number, kind: number, first: number, last: number): void;
  ht_twin_advance(twin: number, ticks: number): number;
  ht_twin_column(twin: number, index: number, width: number): number;
  ht_twin_read(twin: number, row: number): void;
  ht_path(robot: number, model: number, gait: number, steps: number, rows: number): void;
}

/** Functions of the system that the core's library names and never needs: there are no files in a page. */
function withoutSystem(module: WebAssembly.Module): WebAssembly.Imports {
  const imports: Record<string, Record<string, () => number>> = {};
  for (const { module: room, name } of WebAssembly.Module.imports(module)) {
    imports[room] ??= {};
    imports[room][name] = () => 0;
  }
  return imports;
}

/** What the core's table says of a quantity. */
export interface Meaning {
  name: string;
  label: string;
  unit: string;
  shown: number; // 2 where a summary shows it
}

/** One instance of the core. */
export class Core {
  readonly meanings: Meaning[];
  readonly quantities: string[];
  readonly derivatives: string[];

  private constructor(private readonly wasm: Exports) {
    wasm._initialize?.();
    this.quantities = this.names(wasm.ht_quantity);
    this.derivatives = this.names(wasm.ht_derivative);
    this.meanings = this.quantities.map((name, k) => ({
      name,
      label: this.text(wasm.ht_quantity_label(k)),
      unit: this.text(wasm.ht_quantity_unit(k)),
      shown: wasm.ht_quantity_shown(k),
    }));
  }

  static async start(module: WebAssembly.Module): Promise<Core> {
    const instance = await WebAssembly.instantiate(module, withoutSystem(module));
    return new Core(instance.exports as unknown as Exports);
  }

  /** Read a robot's image; throws the core's sentence where it is none. */
  read(image: Uint8Array): CoreRobot {
    const { wasm } = this;
    const place = wasm.malloc(image.length + FAULT_ROOM);
    new Uint8Array(wasm.memory.buffer).set(image, place);
    const fault = place + image.length;
    const robot = wasm.ht_robot_read(place, image.length, fault, FAULT_ROOM);
    const sentence = robot === 0 ? this.text(fault) : "";
    wasm.free(place);
    if (robot === 0) throw new Error(sentence);
    return new CoreRobot(wasm, robot, this);
  }

  /** Start a robot's twin from rest, in the plane of still water. */
  twin(robot: CoreRobot): CoreTwin {
    const { wasm } = this;
    const start = wasm.malloc(START_SIZE + FAULT_ROOM);
    new Uint8Array(wasm.memory.buffer, start, START_SIZE).fill(0);
    new DataView(wasm.memory.buffer).setFloat64(start + START_BOTTOM, Number.POSITIVE_INFINITY, true);
    const fault = start + START_SIZE;
    const twin = wasm.ht_twin_create(robot.place, start, fault, FAULT_ROOM);
    const sentence = twin === 0 ? this.text(fault) : "";
    wasm.free(start);
    if (twin === 0) throw new Error(sentence);
    return new CoreTwin(wasm, twin, this);
  }

  /** Start a flight: a mission of the robot, with the scatter of a seed. */
  fly(robot: CoreRobot, mission: number, seed: number): CoreTwin {
    const { wasm } = this;
    const fault = wasm.malloc(FAULT_ROOM);
    const twin = wasm.ht_twin_fly(robot.place, mission, seed, fault, FAULT_ROOM);
    const sentence = twin === 0 ? this.text(fault) : "";
    wasm.free(fault);
    if (twin === 0) throw new Error(sentence);
    return new CoreTwin(wasm, twin, this);
  }

  /** The verdict on a gait of a frequency with these quantities, in words. */
  verdict(frequency: number, quantities: number[]): string {
    const place = this.wasm.malloc(8 * (1 + quantities.length) + FAULT_ROOM);
    const text = place + 8 * (1 + quantities.length);
    new Float64Array(this.wasm.memory.buffer, place, 1 + quantities.length).set([frequency, ...quantities]);
    this.wasm.ht_verdict(place, place + 8, text, FAULT_ROOM);
    const sentence = this.text(text);
    this.wasm.free(place);
    return sentence;
  }

  private names(name: (index: number) => number): string[] {
    const names: string[] = [];
    for (let place = name(0); place !== 0; place = name(names.length)) names.push(this.text(place));
    return names;
  }

  /** A text that ends with a zero. */
  text(place: number): string {
    const bytes = new Uint8Array(this.wasm.memory.buffer, place);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }
}

/** A robot in the core's memory. */
export class CoreRobot {
  readonly text: string;
  private readonly numbers: number; // of a gait
  private readonly links: number;

  constructor(
    private readonly wasm: Exports,
    readonly place: number,
    private readonly core: Core,
  ) {
    const size = wasm.malloc(4);
    const text = wasm.ht_robot_text(place, size);
    const length = new DataView(wasm.memory.buffer).getUint32(size, true);
    this.text = new TextDecoder().decode(new Uint8Array(wasm.memory.buffer, text, length).slice());
    wasm.free(size);
    this.numbers = 1 + 3 * wasm.ht_robot_groups(place);
    this.links = wasm.ht_robot_links(place);
  }

  free(): void {
    this.wasm.ht_robot_free(this.place);
  }

  /** Quantities of settled gaits, a row each. */
  swim(model: number, gaits: Float64Array, follow: boolean): Float64Array {
    const count = gaits.length / this.numbers;
    return this.with(gaits, count * this.core.quantities.length, (from, to) =>
      this.wasm.ht_swim(this.place, model, from, count, follow ? 1 : 0, to),
    );
  }

  /** Derivatives of quantities by a gait's numbers, a row per quantity. */
  gradient(model: number, gait: Float64Array): Float64Array {
    return this.with(gait, this.core.derivatives.length * this.numbers, (from, to) =>
      this.wasm.ht_gradient(this.place, model, from, to),
    );
  }

  /** Rows of time, x, y and heading of the nose, and the bend in front of each link, over a beat. */
  path(model: number, gait: Float64Array): Float64Array {
    return this.with(gait, (STEPS + 1) * (4 + this.links), (from, to) =>
      this.wasm.ht_path(this.place, model, from, STEPS, to),
    );
  }

  /** Call the core with numbers, and return those that it writes. */
  private with(given: Float64Array, count: number, call: (from: number, to: number) => void): Float64Array {
    const from = this.wasm.malloc(8 * (given.length + count));
    const to = from + 8 * given.length;
    new Float64Array(this.wasm.memory.buffer, from, given.length).set(given);
    call(from, to);
    const written = new Float64Array(this.wasm.memory.buffer, to, count).slice();
    this.wasm.free(from);
    return written;
  }
}

/** A column of what a tick of the twin saw. */
export interface Column {
  name: string;
  width: number;
}

/** A twin in the core's memory: the whole robot from command to wake. */
export class CoreTwin {
  readonly columns: Column[] = [];
  readonly width: number; // of a row

  constructor(
    private readonly wasm: Exports,
    private readonly twin: number,
    core: Core,
  ) {
    const width = wasm.malloc(4);
    for (let name = 1; name !== 0; ) {
      name = wasm.ht_twin_column(twin, this.columns.length, width);
      const count = new DataView(wasm.memory.buffer).getInt32(width, true);
      if (name !== 0) this.columns.push({ name: core.text(name), width: count });
    }
    wasm.free(width);
    this.width = this.columns.reduce((sum, column) => sum + column.width, 0);
  }

  free(): void {
    this.wasm.ht_twin_free(this.twin);
  }

  /** From now on: a gait, with the fins level. */
  command(gait: Float64Array, armed: boolean): void {
    const { wasm } = this;
    const place = wasm.malloc(8 * gait.length + 16);
    new Float64Array(wasm.memory.buffer, place, gait.length + 2).set([...gait, 0, 0]);
    wasm.ht_twin_command(this.twin, place, place + 8 * gait.length, armed ? 1 : 0);
    wasm.free(place);
  }

  /** Give sensor channels a fault of a kind from now on; 0 is none. */
  break(kind: number, first: number, last: number): void {
    this.wasm.ht_twin_break(this.twin, kind, first, last);
  }

  /** Make control ticks; returns `count` rows, one after each `every` of them: fewer where the twin ends. */
  advance(count: number, every = 1): Float64Array {
    const { wasm, width } = this;
    const rows = new Float64Array(count * width);
    const place = wasm.malloc(8 * width);
    let made = 0;
    for (let ticks = every; made < count && ticks === every; ) {
      ticks = wasm.ht_twin_advance(this.twin, every);
      if (ticks === 0) break;
      wasm.ht_twin_read(this.twin, place);
      rows.set(new Float64Array(wasm.memory.buffer, place, width), made * width);
      made++;
    }
    wasm.free(place);
    return rows.slice(0, made * width);
  }
}
