// A table of the bends of joints and hinges, and of the pressures or torques that move them.
import { element } from "./dom.ts";
import { drivesOf, ofKinds } from "./drives.ts";
import type { Moment } from "./machine.ts";
import { DEGREE, type Robot } from "./robot.ts";

interface Column {
  label: string;
  value: (moment: Moment, joint: number) => number | undefined;
  decimals: number;
}

export class JointTable {
  readonly element = element("table", "joints");
  private readonly cells: HTMLElement[][] = []; // cells of the table by joint and column
  private readonly columns: Column[];

  constructor(robot: Robot) {
    this.columns = columnsOf(robot);
    const head = element("tr");
    head.append(element("th", "", "joint"), ...this.columns.map(({ label }) => element("th", "", label)));
    this.element.append(head);
    const hinges = robot.hinges.map((link) => ({ name: `hinge of ${robot.links[link]?.name ?? link}` }));
    for (const { name } of [...robot.joints, ...hinges]) {
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

/** Columns for the bends and for the numbers of the robot's drives. */
function columnsOf(robot: Robot): Column[] {
  const drives = drivesOf(robot);
  const bend = (numbers: (moment: Moment) => number[]): Column["value"] => {
    return (moment, joint) => {
      const angle = numbers(moment)[joint]; // a hinge has no commanded angle
      return angle === undefined ? undefined : angle / DEGREE;
    };
  };
  const moved = ofKinds(robot, ({ numbers }) => numbers).map(({ label, numbers, side, size, decimals }): Column => {
    const rows = new Map(drives.filter((drive) => drive.side === side).map(({ joint, row }) => [joint, row]));
    const value: Column["value"] = (moment, joint) =>
      rows.has(joint) ? (moment[numbers][rows.get(joint) ?? 0] ?? 0) / size : undefined;
    return { label, value, decimals };
  });
  return [
    { label: "bend [deg]", value: bend(({ angle }) => angle), decimals: 1 },
    { label: "asked for [deg]", value: bend(({ angleSet }) => angleSet), decimals: 1 },
    ...moved,
  ];
}
