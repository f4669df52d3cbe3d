// Places labels beside their points, so that none covers another.

/** The rectangle that a label covers [px]. */
export interface Box {
  left: number;
  top: number;
  wide: number;
  high: number;
}

/** Kinds of labels in the order of placing; `gap` to the point [px]; `within`: may cover the point. */
const KINDS: Record<string, { gap: number; within?: boolean }> = {
  stop: { gap: 2, within: true },
  number: { gap: 4 },
  robot: { gap: 14 },
  home: { gap: 8 },
  believed: { gap: 8 },
  faint: { gap: 6 },
};
const DISTANCES = [1, 2.5, 4]; // distances to try, times the gap
// Directions to try (aside, down): beside the point, above and below it, then across.
const DIRECTIONS = [
  [1, 0],
  [-1, 0],
  [0, -1],
  [0, 1],
  [1, -1],
  [1, 1],
  [-1, -1],
  [-1, 1],
] as const;

/** Rank of a kind of label: lower ranks are placed first. */
export const rankOf = (kind: string): number => Object.keys(KINDS).indexOf(kind);

const meet = (a: Box, b: Box): boolean =>
  a.left < b.left + b.wide && b.left < a.left + a.wide && a.top < b.top + b.high && b.top < a.top + a.high;

const inside = (a: Box, bounds: Box): boolean =>
  a.left >= bounds.left &&
  a.top >= bounds.top &&
  a.left + a.wide <= bounds.left + bounds.wide &&
  a.top + a.high <= bounds.top + bounds.high;

/**
 * Find a place within `bounds` for a label beside its point, which covers none of the boxes in `taken`, and add it to
 * them; null if there is none. `last` is the direction that was found before: it is tried first.
 */
export function place(
  kind: string,
  [x, y]: readonly [number, number],
  [wide, high]: readonly [number, number],
  taken: Box[],
  bounds: Box,
  last = 0,
): { box: Box; way: number } | null {
  const { gap, within = false } = KINDS[kind] ?? { gap: 8 };
  const near = DISTANCES.flatMap((reach) => DIRECTIONS.map(([aside, down]) => [aside, down, reach] as const));
  const ways = within ? [[0, 0, 0] as const, ...near] : near;
  for (const way of [last, ...ways.keys()]) {
    const [aside = 0, down = 0, reach = 1] = ways[way] ?? [];
    const box = {
      left: x + aside * (reach * gap + wide / 2) - wide / 2,
      top: y + down * (reach * gap + high / 2) - high / 2,
      ...{ wide, high },
    };
    if (!inside(box, bounds) || taken.some((other) => meet(box, other))) continue;
    taken.push(box);
    return { box, way };
  }
  return null;
}
