// Places of labels: each beside its point, none over another.

/** What a label covers [px]. */
export interface Box {
  left: number;
  top: number;
  wide: number;
  high: number;
}

/** Kinds of labels, the first ones placed first; `gap` from the point [px], `within` where it may stand on the point. */
const KINDS: Record<string, { gap: number; within?: boolean }> = {
  stop: { gap: 2, within: true },
  number: { gap: 4 },
  robot: { gap: 14 },
  home: { gap: 8 },
  believed: { gap: 8 },
  faint: { gap: 6 },
};
const REACHES = [1, 2.5, 4]; // of the gap
// Aside and down, in halves of the label: beside the point, above and below it, then across.
const WAYS = [
  [1, 0],
  [-1, 0],
  [0, -1],
  [0, 1],
  [1, -1],
  [1, 1],
  [-1, -1],
  [-1, 1],
] as const;

/** Rank of a kind of label: lower ones are placed before. */
export const rankOf = (kind: string): number => Object.keys(KINDS).indexOf(kind);

const meet = (a: Box, b: Box): boolean =>
  a.left < b.left + b.wide && b.left < a.left + a.wide && a.top < b.top + b.high && b.top < a.top + a.high;

const inside = (a: Box, room: Box): boolean =>
  a.left >= room.left &&
  a.top >= room.top &&
  a.left + a.wide <= room.left + room.wide &&
  a.top + a.high <= room.top + room.high;

/**
 * Find a place in a room for a label of a size beside a point: one that meets none of those taken, and is taken then;
 * null where there is none. `last` is the way that was found before: it is kept while it is free.
 */
export function place(
  kind: string,
  [x, y]: readonly [number, number],
  [wide, high]: readonly [number, number],
  taken: Box[],
  room: Box,
  last = 0,
): { box: Box; way: number } | null {
  const { gap, within = false } = KINDS[kind] ?? { gap: 8 };
  const near = REACHES.flatMap((reach) => WAYS.map(([aside, down]) => [aside, down, reach] as const));
  const ways = within ? [[0, 0, 0] as const, ...near] : near;
  for (const way of [last, ...ways.keys()]) {
    const [aside = 0, down = 0, reach = 1] = ways[way] ?? [];
    const box = {
      left: x + aside * (reach * gap + wide / 2) - wide / 2,
      top: y + down * (reach * gap + high / 2) - high / 2,
      ...{ wide, high },
    };
    if (!inside(box, room) || taken.some((other) => meet(box, other))) continue;
    taken.push(box);
    return { box, way };
  }
  return null;
}
