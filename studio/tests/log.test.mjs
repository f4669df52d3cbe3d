// A page that comes with a mission's log, as `hypertuna studio LOG.mcap -o` writes it: the Sea view plays it.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { before, test } from "node:test";
import { open, temporary } from "./browser.mjs";

const PROGRAM = process.env.HYPERTUNA ?? "hypertuna";
const folder = temporary("log-");
const [log, page] = [join(folder, "box.mcap"), join(folder, "box.html")];

before(async () => {
  const record = "from hypertuna.mission.log import write_log; from voyage import voyage";
  const tests = new URL("../../tests", import.meta.url).pathname;
  const code = `import sys; sys.path.insert(0, "${tests}"); ${record}; write_log(voyage(60), "${log}")`;
  execFileSync(process.env.PYTHON ?? "python", ["-c", code]);
  execFileSync(PROGRAM, ["studio", log, "-o", page]);
});

test("the page opens at the log that it comes with", async () => {
  assert.ok(existsSync(page));
  const { page: studio, close } = await open({ file: page });
  await studio.waitForFunction(() => /box\.mcap: The log is whole/.test(document.querySelector("#sea").textContent));
  assert.equal(await studio.locator("#tab-sea").getAttribute("aria-selected"), "true");
  assert.ok(
    await studio.evaluate(() => document.querySelector("#views").getBoundingClientRect().top < innerHeight / 2),
  );
  await close();
});
