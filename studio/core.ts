// Calls the C interface, hosts/hypertuna.h, of the core in WebAssembly.
import { CORE, type Functions, START } from "./interface.ts";

const BEAT_STEPS = CORE.beat_steps;
/** Numbers in a row of a path before its bends: time, x, y and heading. */
export const POSE = 4;

const FAULT_ROOM = 512; // bytes for a sentence of the core

interface Exports extends Functions {
  memory: WebAssembly.Memory;
  malloc(size: number): number;
  free(place: number): void;
  _initialize?(): void;
}

/** Stubs for the system calls that the C library imports but the core never makes: a page has no files. */
function withoutSystem(module: WebAssembly.Module): WebAssembly.Imports {
  const imports: Record<string, Record<string, () => number>> = {};
  for (const { module: library, name } of WebAssembly.Module.imports(module)) {
    imports[library] ??= {};
    imports[library][name] = () => 0;
  }
  return imports;
}

/** The entry of a quantity in the core's table. */
export interface Meaning {
  name: string;
  label: string;
  unit: string;
  shown: number; // 2 if a summary shows it
  better: number; // one of `Better`
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
      better: wasm.ht_quantity_better(k),
    }));
  }

  static async start(module: WebAssembly.Module): Promise<Core> {
    const instance = await WebAssembly.instantiate(module, withoutSystem(module));
    return new Core(instance.exports as unknown as Exports);
  }

  /** Read a robot's image; throws the core's sentence if it is not one. */
  read(image: Uint8Array): CoreRobot {
    const robot = this.made(image, (place, fault) => this.wasm.ht_robot_read(place, image.length, fault, FAULT_ROOM));
    return new CoreRobot(this.wasm, robot, this);
  }

  /** Start a robot's twin from rest, in still water without a bottom. */
  twin(robot: CoreRobot): CoreTwin {
    const start = new Uint8Array(START.size);
    new DataView(start.buffer).setFloat64(START.bottom, Number.POSITIVE_INFINITY, true);
    const twin = this.made(start, (place, fault) => this.wasm.ht_twin_create(robot.place, place, fault, FAULT_ROOM));
    return new CoreTwin(this.wasm, twin, this);
  }

  /** Start a flight of a mission; `seed` scatters current and satellites, 0 leaves them as the mission has them. */
  fly(robot: CoreRobot, mission: number, seed: number): CoreTwin {
    const twin = this.made(new Uint8Array(), (_, fault) =>
      this.wasm.ht_twin_fly(robot.place, mission, seed, fault, FAULT_ROOM),
    );
    return new CoreTwin(this.wasm, twin, this);
  }

  /** Copy `bytes` to the core's memory and return the handle that `make` creates; throws the core's refusal. */
  private made(bytes: Uint8Array, make: (place: number, fault: number) => number): number {
    const { wasm } = this;
    const place = wasm.malloc(bytes.length + FAULT_ROOM);
    new Uint8Array(wasm.memory.buffer).set(bytes, place);
    const made = make(place, place + bytes.length);
    const sentence = made === 0 ? this.text(place + bytes.length) : "";
    wasm.free(place);
    if (made === 0) throw new Error(sentence);
    return made;
  }

  /** The core's verdict, in words, on a gait with this frequency [Hz] and these quantities. */
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

  /** Read a zero-terminated text from the core's memory. */
  text(place: number): string {
    const bytes = new Uint8Array(this.wasm.memory.buffer, place);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }
}

/** A robot in the core's memory. */
export class CoreRobot {
  readonly text: string;
  private readonly numbers: number; // numbers in a gait's row
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

  /** Quantities of gaits, one row per gait; `follow` also simulates the start from rest. */
  swim(model: number, gaits: Float64Array, follow: boolean): Float64Array {
    const count = gaits.length / this.numbers;
    return this.with(gaits, count * this.core.quantities.length, (from, to) =>
      this.wasm.ht_swim(this.place, model, from, count, follow ? 1 : 0, to),
    );
  }

  /** Derivatives of the quantities with respect to a gait's numbers, one row per quantity. */
  gradient(model: number, gait: Float64Array): Float64Array {
    return this.with(gait, this.core.derivatives.length * this.numbers, (from, to) =>
      this.wasm.ht_gradient(this.place, model, from, to),
    );
  }

  /** One settled beat: rows of time, x, y and heading of the nose, and the bend in front of each link. */
  path(model: number, gait: Float64Array): Float64Array {
    return this.with(gait, (BEAT_STEPS + 1) * (POSE + this.links), (from, to) =>
      this.wasm.ht_path(this.place, model, from, BEAT_STEPS, to),
    );
  }

  /** Call the core with the numbers `given`; returns the `count` numbers that it writes. */
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

/** A column of the twin's record, which has a row for each tick. */
export interface Column {
  name: string;
  width: number;
}

/** A twin in the core's memory: it simulates the whole robot, from command to wake. */
export class CoreTwin {
  readonly columns: Column[] = [];
  readonly width: number; // numbers in a row of the record

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

  /** Command a gait from now on, with level fins; `armed` lets the actuators move. */
  command(gait: Float64Array, armed: boolean): void {
    const { wasm } = this;
    const place = wasm.malloc(8 * gait.length + 16);
    new Float64Array(wasm.memory.buffer, place, gait.length + 2).set([...gait, 0, 0]);
    wasm.ht_twin_command(this.twin, place, place + 8 * gait.length, armed ? 1 : 0);
    wasm.free(place);
  }

  /** Give sensor channels `first` to `last` a fault of kind `kind` from now on; 0 mends them. */
  break(kind: number, first: number, last: number): void {
    this.wasm.ht_twin_break(this.twin, kind, first, last);
  }

  /** Simulate control ticks; returns `count` rows, one per `every` ticks, or fewer if the twin ends. */
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
