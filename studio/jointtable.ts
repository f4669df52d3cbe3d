// Bends of the joints in numbers, and what moves them: pressures of oil, torques of servos.
import { element } from "./dom.ts";
import { type Drive, drivesOf, hasOil, onAxle } from "./drives.ts";
import type { Moment } from "./machine.ts";
import { DEGREE, type Robot } from "./robot.ts";

interface Column {
  label: string;
  value: (moment: Moment, joint: number) => number | undefined;
  decimals: number;
}

export class JointTable {
  readonly element = element("table", "joints");
  private readonly cells: HTMLElement[][] = []; // by joint
  private readonly columns: Column[];

  constructor(robot: Robot) {
    this.columns = columnsOf(drivesOf(robot));
    const head = element("tr");
    head.append(element("th", "", "joint"), ...this.columns.map(({ label }) => element("th", "", label)));
    this.element.append(head);
    for (const { name } of robot.joints) {
      const row = element("tr");
      this.cells.push(this.columns.map(() => element("td")));
      row.append(element("th", "", name), ...(this.cells.at(-1) ?? []));
      this.element.append(row);
    }
  }

  show(moment: Moment): void {
    this.cells.forEach((row, joint) => {
      row.forEach((cell, k) => {
        const { value, decimals } = this.columns[k] ?? { value: () => 0, decimals: 0 };
        const text = value(moment, joint)?.toFixed(decimals).replace("-", "−") ?? "–";
        if (cell.textContent !== text) cell.textContent = text;
      });
    });
  }
}

/** Columns of what the robot has: no pressures without oil, no torques without servos on axles. */
function columnsOf(drives: Drive[]): Column[] {
  const of = (side: number, numbers: (moment: Moment) => number[], size: number): Column["value"] => {
    const rows = new Map(drives.filter((drive) => drive.side === side).map(({ joint, row }) => [joint, row]));
    return (moment, joint) => (rows.has(joint) ? (numbers(moment)[rows.get(joint) ?? 0] ?? 0) / size : undefined);
  };
  const bend = (numbers: (moment: Moment) => number[]): Column["value"] => {
    return (moment, joint) => (numbers(moment)[joint] ?? 0) / DEGREE;
  };
  const unit = ({ unit }: Moment): number[] => unit;
  return [
    { label: "bend [deg]", value: bend(({ angle }) => angle), decimals: 1 },
    { label: "asked for [deg]", value: bend(({ angleSet }) => angleSet), decimals: 1 },
    ...(drives.some(hasOil)
      ? [
          { label: "oil, left [kPa]", value: of(1, unit, 1e3), decimals: 0 },
          { label: "oil, right [kPa]", value: of(-1, unit, 1e3), decimals: 0 },
        ]
      : []),
    ...(drives.some(onAxle)
      ? [{ label: "servo torque [N\u00a0m]", value: of(0, ({ torque }) => torque, 1), decimals: 3 }]
      : []),
  ];
}
