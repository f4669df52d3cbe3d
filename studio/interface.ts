// Written by make/interface.py from hosts/hypertuna.h and the core's lists.

export interface Functions {
  ht_robot_read(image: number, size: number, fault: number, room: number): number;
  ht_robot_free(robot: number): void;
  ht_robot_text(robot: number, size: number): number;
  ht_robot_groups(robot: number): number;
  ht_robot_links(robot: number): number;
  ht_quantity(index: number): number;
  ht_quantity_label(index: number): number;
  ht_quantity_unit(index: number): number;
  ht_quantity_shown(index: number): number;
  ht_quantity_better(index: number): number;
  ht_derivative(index: number): number;
  ht_swim(robot: number, model: number, gaits: number, count: number, follow: number, quantities: number): void;
  ht_verdict(gait: number, quantities: number, text: number, room: number): void;
  ht_gradient(robot: number, model: number, gait: number, derivatives: number): void;
  ht_path(robot: number, model: number, gait: number, steps: number, rows: number): void;
  ht_twin_create(robot: number, start: number, fault: number, room: number): number;
  ht_twin_fly(robot: number, mission: number, seed: number, fault: number, room: number): number;
  ht_twin_free(twin: number): void;
  ht_twin_command(twin: number, gait: number, fins: number, armed: number): void;
  ht_twin_break(twin: number, kind: number, first: number, last: number): void;
  ht_twin_advance(twin: number, ticks: number): number;
  ht_twin_column(twin: number, index: number, width: number): number;
  ht_twin_read(twin: number, row: number): void;
}

/** Places in structs, and their sizes [bytes]; numbers of the core; members of its enumerations. */
export const START = { sea: 0, seed: 8, speed: 16, depth: 24, heading: 32, current: 40, bottom: 56, size: 64 };
export const IMAGE = { magic: 0, version: 8, checksum: 12, columns: 16, names: 20, text: 24, numbers: 28, size: 32 };
export const CORE = { beat_steps: 128, nearly_straight: 1000 };
export const FaultKind = { none: 0, stuck: 1, open: 2, spike: 3, nan: 4, drift: 5, shift: 6, clogged: 7 };
export const BeatStatus = { settled: 0, unsettled: 1, unstable: 2, diverged: 3, unresolved: 4 };
export const Better = { neither: 0, large: 1, small: 2 };
