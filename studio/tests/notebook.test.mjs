// A notebook's cell that ends with ht.studio(...): its output swims in a frame of the notebook's page.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { chrome, numbers, settled, temporary, watch } from "./browser.mjs";

const PYTHON = process.env.PYTHON ?? "python";
const folder = temporary("notebook-");
const CELL = 'import hypertuna as ht\nht.studio("hypertuna", "optimised-0.3", height=500)';
// Run the cell by a kernel; write its output as JSON.
const RUN = `
import json, sys
import nbformat
from nbclient import NotebookClient
cell = nbformat.v4.new_code_cell(${JSON.stringify(CELL)})
NotebookClient(nbformat.v4.new_notebook(cells=[cell]), timeout=120, kernel_name="python3").execute()
(output,) = cell.outputs
json.dump(output["data"], sys.stdout)
`;
const lacking = spawnSync(PYTHON, ["-c", "import ipykernel, nbclient, nbformat"]).status !== 0;

test("the fish swims in a notebook", { skip: lacking && "needs ipykernel, nbclient and nbformat" }, async () => {
  const done = spawnSync(PYTHON, ["-c", RUN], { encoding: "utf8", maxBuffer: 2 ** 26 });
  assert.equal(done.status, 0, done.stderr);
  const output = JSON.parse(done.stdout);
  assert.match(output["text/plain"], /^Studio of hypertuna at 2\.13 Hz/);
  const file = join(folder, "notebook.html");
  const shown = JSON.stringify(output["text/html"]).replaceAll("<", "\\u003c");
  // as notebooks show an output: by innerHTML, which runs no script outside the frame
  writeFileSync(
    file,
    `<!doctype html><div id="cell"></div><script>document.getElementById("cell").innerHTML = ${shown};</script>`,
  );
  const page = await chrome.newPage({ viewport: { width: 1000, height: 800 } });
  const faults = watch(page);
  await page.goto(`file://${file}`);
  const frame = await (await page.waitForSelector("iframe")).contentFrame();
  await settled(frame);
  assert.equal(await page.locator("iframe").evaluate((one) => one.clientHeight), 500);
  assert.equal(await frame.locator("[data-gaits]").inputValue(), "optimised-0.3");
  assert.ok(Math.abs((await numbers(frame)).speed - 0.28996) < 1e-4);
  const picture = () => frame.locator("#stage").evaluate((stage) => stage.toDataURL());
  const first = await picture();
  await page.waitForTimeout(300);
  assert.notEqual(await picture(), first); // it moves
  assert.deepEqual(faults, []);
  await page.close();
});
