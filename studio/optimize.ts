// Searches for the best gait with exact gradients, within the optimizer's limits.
import type { Computed, Subject } from "./subject.ts";

export interface Goal {
  quantity: "speed" | "cost_of_transport"; // "speed": the largest; "cost_of_transport": the least
  speed: number | null; // speed to swim at [m/s]; null: any
}

export interface Found {
  row: Float64Array;
  computed: Computed;
  cut?: boolean; // whether its search ended at the largest number of steps
}

/** Called after each accepted step; the search ends if it returns false. */
export type Watch = (found: Found, step: number) => Promise<boolean>;

/** Largest number of steps of a search. */
export const MAX_STEPS = 60;
const MAX_HALVINGS = 14; // most halvings of a step in the line search
const LEAST_GAIN = 1e-7; // a search ends when the merit gains less in a step
const SPEED_ERROR = 1e-7; // relative error at which a required speed counts as reached
const FIRST_STEP = 0.15; // largest coordinate of the first step, fraction of the limits' width
const MAX_CORRECTION = 0.3; // largest change of the speed's relative error that one step asks for

/** A point of the search: value to minimize, error of the speed, and their gradients in the unit box. */
interface Place {
  u: Float64Array; // free parameters, each scaled to 0 to 1
  value: number;
  gradient: Float64Array;
  error: number; // relative error of the speed
  errorGradient: Float64Array;
  found: Found;
}

/** The free parameters of a robot as a unit box. */
export class Box {
  readonly free: { index: number; low: number; width: number }[];

  constructor(private readonly subject: Subject) {
    this.free = subject.parameters.flatMap(({ index, free, limits, size }) =>
      free && limits !== null ? [{ index, low: limits[0] * size, width: (limits[1] - limits[0]) * size }] : [],
    );
  }

  /** The gait at a point of the box; parameters that are not free are those of `base`. */
  row(u: ArrayLike<number>, base: Float64Array): Float64Array {
    const row = base.slice();
    this.free.forEach(({ index, low, width }, k) => {
      row[index] = low + (u[k] ?? 0) * width;
    });
    return row;
  }

  /** The point of a gait, clamped to the box. */
  point(row: ArrayLike<number>): Float64Array {
    return Float64Array.from(this.free, ({ index, low, width }) => clamp(((row[index] ?? 0) - low) / width));
  }

  /** A gait at the lower limit of each parameter; from it, parameters that are not free keep their value. */
  get base(): Float64Array {
    return Float64Array.from(this.subject.parameters, ({ limits, size }) => (limits?.[0] ?? 0) * size);
  }

  /** Points spread over the box by a Halton sequence. */
  spread(count: number): Float64Array[] {
    const bases = primes(this.free.length);
    return Array.from({ length: count }, (_, k) => Float64Array.from(bases, (base) => radicalInverse(k + 1, base)));
  }
}

/** Sequential quadratic programming with BFGS from a point; null if the gait there does not settle ahead. */
export async function search(
  subject: Subject,
  goal: Goal,
  start: ArrayLike<number>,
  watch: Watch,
): Promise<Found | null> {
  const box = new Box(subject);
  const at = (u: Float64Array): Promise<Place | null> => evaluate(subject, box, goal, u);
  let here = await at(Float64Array.from(start));
  if (here === null) return null;
  if (!(await watch(here.found, 0))) return here.found;
  let hessian = identity(here.u.length, Math.max(...here.gradient.map(Math.abs), 1e-12) / FIRST_STEP);
  let weight = 0; // weight of the speed's error in the merit function
  let going = true;
  for (let step = 1; going && step <= MAX_STEPS; step++) {
    const { move, multiplier } = quadratic(here, hessian);
    weight = Math.max(weight, 1.5 * Math.abs(multiplier));
    const next = await lineSearch(here, move, weight, at);
    going = next !== null;
    if (next === null) break;
    const gain = merit(here, weight) - merit(next, weight);
    const lagrangian = (place: Place): Float64Array =>
      place.gradient.map((value, k) => value + multiplier * (place.errorGradient[k] ?? 0));
    hessian = updated(hessian, minus(next.u, here.u), minus(lagrangian(next), lagrangian(here)));
    here = next;
    const goes = await watch(here.found, step);
    going = goes && (gain > LEAST_GAIN || Math.abs(here.error) >= SPEED_ERROR);
  }
  return { ...here.found, cut: going };
}

const merit = (place: Place, weight: number): number => place.value + weight * Math.abs(place.error);

async function evaluate(subject: Subject, box: Box, goal: Goal, u: Float64Array): Promise<Place | null> {
  const row = box.row(u, box.base);
  const computed = await subject.swim(row);
  const { speed = Number.NaN, cost_of_transport: cost = Number.NaN } = computed.values;
  if (!computed.settled || !(speed > 0) || !(cost > 0)) return null;
  const gradient = (quantity: string, scale: number): Float64Array => {
    const rates = computed.rates(quantity);
    return Float64Array.from(box.free, ({ index, width }) => scale * (rates[index] ?? 0) * width);
  };
  const fast = goal.quantity === "speed";
  const place = {
    u,
    value: fast ? -speed : Math.log(cost),
    gradient: fast ? gradient("speed", -1) : gradient("cost_of_transport", 1 / cost),
    error: goal.speed === null ? 0 : speed / goal.speed - 1,
    errorGradient: gradient("speed", goal.speed === null ? 0 : 1 / goal.speed),
    found: { row, computed },
  };
  return Number.isFinite(place.value + dot(place.gradient, place.gradient)) ? place : null;
}

/** The move that minimizes the quadratic model in the box and corrects the speed; active-set method. */
function quadratic(here: Place, hessian: number[][]): { move: Float64Array; multiplier: number } {
  const n = here.u.length;
  const low = here.u.map((value) => -value);
  const high = here.u.map((value) => 1 - value);
  const wanted = Math.min(MAX_CORRECTION, Math.max(-MAX_CORRECTION, -here.error));
  const held = new Set<number>();
  const released = new Set<number>();
  let move = new Float64Array(n);
  let multiplier = 0;
  for (let round = 0; round < 4 * n; round++) {
    ({ move, multiplier } = newton(here, hessian, held, move, wanted));
    const beyond = (k: number): number => Math.max((low[k] ?? 0) - (move[k] ?? 0), (move[k] ?? 0) - (high[k] ?? 0));
    const worst = largest(n, (k) => (held.has(k) ? Number.NEGATIVE_INFINITY : beyond(k)));
    if (beyond(worst) > 1e-12 && !held.has(worst)) {
      move[worst] = Math.min(high[worst] ?? 0, Math.max(low[worst] ?? 0, move[worst] ?? 0));
      held.add(worst);
      continue;
    }
    // how strongly a coordinate that is held at an end is pulled into the box
    const inward = (k: number): number => {
      const pull = (here.gradient[k] ?? 0) + dot(hessian[k] ?? [], move) + multiplier * (here.errorGradient[k] ?? 0);
      return (move[k] ?? 0) === (low[k] ?? 0) ? -pull : pull;
    };
    const freed = largest(n, (k) => (held.has(k) && !released.has(k) ? inward(k) : Number.NEGATIVE_INFINITY));
    if (!held.has(freed) || released.has(freed) || inward(freed) <= 1e-12) break;
    held.delete(freed);
    released.add(freed);
  }
  return { move: move.map((value, k) => Math.min(high[k] ?? 0, Math.max(low[k] ?? 0, value))), multiplier };
}

/** Newton's step of the coordinates that are not held; it also reduces the error of the speed. */
function newton(
  here: Place,
  hessian: number[][],
  held: Set<number>,
  before: Float64Array,
  wanted: number,
): { move: Float64Array<ArrayBuffer>; multiplier: number } {
  const move = new Float64Array(before);
  const free = [...move.keys()].filter((k) => !held.has(k));
  const matrix = free.map((i) => free.map((j) => hessian[i]?.[j] ?? 0));
  const fixed = (values: ArrayLike<number>): number =>
    [...held].reduce((sum, k) => sum + (values[k] ?? 0) * (move[k] ?? 0), 0);
  const down = solve(
    matrix,
    free.map((k) => -(here.gradient[k] ?? 0) - fixed(hessian[k] ?? [])),
  );
  const normal = free.map((k) => here.errorGradient[k] ?? 0);
  const across = solve(matrix, normal);
  const stiffness = dot(normal, across);
  const multiplier = stiffness > 1e-12 ? (dot(normal, down) + fixed(here.errorGradient) - wanted) / stiffness : 0;
  free.forEach((k, i) => {
    move[k] = (down[i] ?? 0) - multiplier * (across[i] ?? 0);
  });
  return { move, multiplier };
}

async function lineSearch(
  here: Place,
  move: Float64Array,
  weight: number,
  at: (u: Float64Array) => Promise<Place | null>,
): Promise<Place | null> {
  const change = dot(here.gradient, move) - weight * Math.min(MAX_CORRECTION, Math.abs(here.error));
  if (!(change < -1e-14)) return null;
  for (let size = 1, tries = 0; tries < MAX_HALVINGS; size /= 2, tries++) {
    const next = await at(here.u.map((value, k) => clamp(value + size * (move[k] ?? 0))));
    if (next !== null && merit(next, weight) <= merit(here, weight) + 1e-4 * size * change) return next;
  }
  return null;
}

/** BFGS update, damped so that the matrix stays positive definite (Powell, 1978). */
function updated(hessian: number[][], step: Float64Array, change: Float64Array): number[][] {
  const along = hessian.map((row) => row.reduce((sum, value, k) => sum + value * (step[k] ?? 0), 0));
  const curve = dot(step, along);
  if (!(curve > 0)) return hessian;
  const seen = dot(step, change);
  const damping = seen >= 0.2 * curve ? 1 : (0.8 * curve) / (curve - seen);
  const y = along.map((value, k) => damping * (change[k] ?? 0) + (1 - damping) * value);
  const sy = dot(step, y);
  return hessian.map((row, i) =>
    row.map((value, j) => value - ((along[i] ?? 0) * (along[j] ?? 0)) / curve + ((y[i] ?? 0) * (y[j] ?? 0)) / sy),
  );
}

/** Solve a symmetric positive definite system by Cholesky factorization. */
function solve(matrix: number[][], right: number[]): number[] {
  const n = right.length;
  const lower = matrix.map((row) => row.slice());
  const of = (i: number, j: number): number => lower[i]?.[j] ?? 0;
  for (let i = 0; i < n; i++)
    for (let j = 0; j <= i; j++) {
      let sum = of(i, j);
      for (let k = 0; k < j; k++) sum -= of(i, k) * of(j, k);
      const row = lower[i];
      if (row !== undefined) row[j] = i === j ? Math.sqrt(Math.max(sum, 1e-300)) : sum / of(j, j);
    }
  const x = right.slice();
  for (let i = 0; i < n; i++) {
    for (let k = 0; k < i; k++) x[i] = (x[i] ?? 0) - of(i, k) * (x[k] ?? 0);
    x[i] = (x[i] ?? 0) / of(i, i);
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let k = i + 1; k < n; k++) x[i] = (x[i] ?? 0) - of(k, i) * (x[k] ?? 0);
    x[i] = (x[i] ?? 0) / of(i, i);
  }
  return x;
}

const clamp = (value: number): number => Math.min(1, Math.max(0, value));
const dot = (a: ArrayLike<number>, b: ArrayLike<number>): number =>
  Array.from(a).reduce((sum, value, k) => sum + value * (b[k] ?? 0), 0);
const minus = (a: Float64Array, b: Float64Array): Float64Array => a.map((value, k) => value - (b[k] ?? 0));
/** The index below `n` at which `value` is largest. */
function largest(n: number, value: (k: number) => number): number {
  let best = 0;
  for (let k = 1; k < n; k++) if (value(k) > value(best)) best = k;
  return best;
}

const identity = (n: number, size: number): number[][] =>
  Array.from({ length: n }, (_, i) => Array.from({ length: n }, (_, j) => (i === j ? size : 0)));

/** The first `count` prime numbers. */
function primes(count: number): number[] {
  const found: number[] = [];
  for (let n = 2; found.length < count; n++) if (found.every((prime) => n % prime !== 0)) found.push(n);
  return found;
}

/** The radical inverse: digits of `count` in a base, mirrored behind the point. */
function radicalInverse(count: number, base: number): number {
  let [value, digit] = [0, 1 / base];
  for (let rest = count; rest > 0; rest = Math.floor(rest / base), digit /= base) value += (rest % base) * digit;
  return value;
}
