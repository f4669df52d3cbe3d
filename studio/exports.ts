// Writes a gait and a beat to files, with the names and units of hypertuna's robot files and tables.
import { POSE } from "./core.ts";
import { plain } from "./quantities.ts";
import { DEGREE, type Gait, kindsOf, type Robot } from "./robot.ts";

/** A gait as a table of a robot's file, `[gaits.studio]`. */
export function gaitToml(robot: Robot, gait: Gait): string {
  const real = (value: number): string => (Number.isInteger(value) ? value.toFixed(1) : String(value));
  const angles = kindsOf(gait).map(
    (kind) => `${kind}_deg = [${gait[kind].map((angle) => real(plain(angle / DEGREE))).join(", ")}]`,
  );
  return [
    `# A gait of ${robot.robot}: goes into the robot's file; \`hypertuna swim --robot FILE --gait studio\` swims it.`,
    "[gaits.studio]",
    `frequency_hz = ${real(plain(gait.frequency))}`,
    ...angles,
    "",
  ].join("\n");
}

/** A beat as CSV: place and heading of the nose, bend of each joint group; with hinges, the bend at each link. */
export function beatTable(robot: Robot, path: Float64Array): string {
  const width = POSE + robot.links.length;
  const each = robot.links.slice(1).map(({ name }, link) => ({ name, links: [link + 1] }));
  const joints = robot.hinges.length ? each : robot.joints;
  const names = ["time_s", "x_m", "y_m", "heading_deg", ...joints.map(({ name }) => `bend_${name}_deg`)];
  const lines = [names.join(",")];
  for (let k = 0; k < path.length; k += width) {
    const [time, x, y, heading = 0, ...bends] = path.subarray(k, k + width);
    const groups = joints.map(({ links }) => links.reduce((sum, link) => sum + (bends[link] ?? 0), 0));
    lines.push([time, x, y, ...[heading, ...groups].map((angle) => angle / DEGREE)].join(","));
  }
  return `${lines.join("\n")}\n`;
}
