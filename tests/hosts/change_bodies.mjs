// Changed bodies as the studio's page makes them, for a program at the other end of the pipe: for each line of JSON with
// image (base64), robot (its text) and factors, a line with the changed image, the file as TOML and the text's numbers.
import { createRequire } from "node:module";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const studio = fileURLToPath(new URL("../../studio/", import.meta.url));
const { build } = createRequire(`${studio}package.json`)("esbuild");
const options = { entryPoints: [`${studio}changes.ts`], bundle: true, write: false, format: "esm", logLevel: "error" };
const { outputFiles } = await build(options);
const code = Buffer.from(outputFiles[0].contents).toString("base64");
const { changedImage, changedRobot, changedToml } = await import(`data:text/javascript;base64,${code}`);

for await (const line of createInterface({ input: process.stdin })) {
  const { image, robot, factors } = JSON.parse(line);
  const changed = changedImage(new Uint8Array(Buffer.from(image, "base64")), robot, factors);
  const { length, mass, links, tail, fins } = changedRobot(robot, factors, "changed");
  const answer = {
    image: Buffer.from(changed).toString("base64"),
    toml: changedToml(robot, factors),
    body: { length, mass, links, tail, fins },
  };
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}
