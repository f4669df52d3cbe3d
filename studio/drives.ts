// What moves the joints, by the core's rows of numbers: two a joint, of which a servo on the axle has the first alone.
import type { Robot } from "./robot.ts";

export interface Drive {
  name: string;
  joint: number;
  row: number;
  side: -1 | 0 | 1; // oil on the right or the left; 0: a servo on the axle
}

export function drivesOf({ joints }: Robot): Drive[] {
  return joints.flatMap(({ name, direct }, joint): Drive[] =>
    direct
      ? [{ name, joint, row: 2 * joint, side: 0 }]
      : [
          { name: `${name} left`, joint, row: 2 * joint, side: 1 },
          { name: `${name} right`, joint, row: 2 * joint + 1, side: -1 },
        ],
  );
}

export const hasOil = ({ side }: Drive): boolean => side !== 0;
export const onAxle = ({ side }: Drive): boolean => side === 0;
