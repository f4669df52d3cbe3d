// What the studio's page makes of a robot's image, for a program at the other end of the pipe, a line of JSON each:
// change: an image, its robot (the text) and factors; returns the image, the file and the text's numbers of the body.
// sample: the same; returns the images of the samples. spread: quantities of samples; returns where most lie.
import { createRequire } from "node:module";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const studio = fileURLToPath(new URL("../../studio/", import.meta.url));
const { build } = createRequire(`${studio}package.json`)("esbuild");
const contents = ["changes", "samples"].map((name) => `export * from "./${name}.ts";`).join("\n");
const entry = { stdin: { contents, resolveDir: studio, loader: "ts" } };
const { outputFiles } = await build({ ...entry, bundle: true, write: false, format: "esm", logLevel: "error" });
const code = Buffer.from(outputFiles[0].contents).toString("base64");
const page = await import(`data:text/javascript;base64,${code}`);

const bytes = (text) => new Uint8Array(Buffer.from(text, "base64"));
const text = (made) => Buffer.from(made).toString("base64");
const work = {
  change(image, robot, factors) {
    const { length, mass, links, tail, fins } = page.changedRobot(robot, factors, "changed");
    return {
      image: text(page.changedImage(bytes(image), robot, factors)),
      toml: page.changedToml(robot, factors),
      body: { length, mass, links, tail, fins },
    };
  },
  sample: (image, robot, factors) => page.sampledImages(bytes(image), robot, factors).map(text),
  spread: (samples, quantities, factors) => page.spreadOf(samples, quantities, factors ?? undefined),
};
for await (const line of createInterface({ input: process.stdin })) {
  const { ask, with: given } = JSON.parse(line);
  process.stdout.write(`${JSON.stringify(work[ask](...given))}\n`);
}
