// Files: a robot image is opened, anything else is refused in a sentence; what is saved is read by the program.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { appendFileSync, cpSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { choose, hypertuna, numbers, open, settled, temporary, told } from "./browser.mjs";

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
const folder = temporary("studio-");
const image = join(folder, "minnow.robot");

before(async () => {
  execFileSync(process.env.HYPERTUNA ?? "hypertuna", ["robot", "image", `${ROOT}examples/minnow.toml`, "-o", image]);
});

/** Drop a file on the page, and wait for what it makes of it. */
async function drop(page, name, bytes) {
  await page.evaluate(
    ([name, letters]) => {
      const content = Uint8Array.from(atob(letters), (letter) => letter.charCodeAt(0));
      const files = new DataTransfer();
      files.items.add(new File([content], name));
      document.dispatchEvent(new DragEvent("drop", { dataTransfer: files, bubbles: true, cancelable: true }));
    },
    [name, Buffer.from(bytes).toString("base64")],
  );
}

test("a robot image that is dropped swims", async () => {
  const { page, close } = await open();
  await drop(page, "minnow.robot", readFileSync(image));
  await page.waitForFunction(() => document.querySelector("#robot").value === "minnow");
  await settled(page);
  const native = hypertuna("swim", "--robot", `${ROOT}examples/minnow.toml`, "--gait", "cruise");
  assert.ok(Math.abs((await numbers(page)).speed / native.speed_m_s - 1) < 1e-10);
  assert.equal(await told(page), "");
  await close();
});

test("a robot image that is chosen in the dialog swims", async () => {
  const { page, close } = await open();
  await page.locator("[data-open]").setInputFiles(image);
  await page.waitForFunction(() => document.querySelector("#robot").value === "minnow");
  await settled(page);
  assert.equal((await numbers(page)).status, "settled");
  await close();
});

test("files that are no robot image are refused in a sentence, and the fish swims on", async () => {
  const { page, close } = await open();
  const good = readFileSync(image);
  const before = await numbers(page);
  const turned = Buffer.from(good);
  turned[good.length >> 1] ^= 1;
  const version = Buffer.from(good);
  version[8] = 9;
  const bad = {
    "empty.robot": [],
    "text.toml": Buffer.from('name = "minnow"\n'),
    "page.html": Buffer.from("<script>document.title = 'broken'</script>"),
    "half.robot": good.subarray(0, good.length >> 1),
    "turned.robot": turned,
    "version.robot": version,
    "large.robot": Buffer.alloc(17 * 2 ** 20),
  };
  for (const [name, bytes] of Object.entries(bad)) {
    await drop(page, name, bytes);
    await page.waitForFunction((name) => document.querySelector('[role="alert"]').textContent.startsWith(name), name);
    const sentence = await told(page);
    assert.match(sentence, /\.$/, sentence);
    assert.doesNotMatch(sentence, /undefined|NaN|RangeError|TypeError/, sentence);
  }
  assert.deepEqual(await numbers(page), before);
  assert.equal(await page.title(), "hypertuna studio");
  await drop(page, "minnow.robot", good);
  await page.waitForFunction(() => document.querySelector("#robot").value === "minnow");
  assert.equal(await told(page), "");
  await close();
});

async function saved(page, kind) {
  const waiting = page.waitForEvent("download");
  await page.locator(`[data-save="${kind}"]`).evaluate((button) => button.click());
  const file = await waiting;
  const path = join(folder, file.suggestedFilename());
  await file.saveAs(path);
  return path;
}

test("a saved gait goes into the robot's file and swims alike", async () => {
  const { page, close } = await open({ hash: "#robot=hypertuna" });
  await choose(page, "[data-gaits]", "turning");
  const text = readFileSync(await saved(page, "toml"), "utf8");
  const robot = join(folder, "mine.toml");
  cpSync(`${ROOT}robots/hypertuna.toml`, robot);
  appendFileSync(robot, `\n${text}`);
  const native = hypertuna("swim", "--robot", robot, "--gait", "studio");
  const shown = await numbers(page);
  assert.ok(Math.abs(shown.speed / native.speed_m_s - 1) < 1e-9);
  assert.ok(Math.abs(shown.turn_radius / native.turn_radius_m - 1) < 1e-8);
  await close();
});

test("a saved beat is a table of its steps, a saved picture a picture", async () => {
  const { page, close } = await open();
  const table = readFileSync(await saved(page, "csv"), "utf8")
    .trim()
    .split("\n");
  assert.match(table[0], /^time_s,x_m,y_m,heading_deg,bend_I_deg,bend_II_deg$/);
  assert.equal(table.length, 130);
  assert.ok(table.slice(1).every((line) => line.split(",").every((cell) => Number.isFinite(Number(cell)))));
  const { speed } = await numbers(page);
  const [first, last] = [table[1], table.at(-1)].map((line) => line.split(",").map(Number));
  const distance = Math.hypot(last[1] - first[1], last[2] - first[2]);
  assert.ok(Math.abs(distance / (last[0] - first[0]) / speed - 1) < 1e-6);
  assert.equal(
    readFileSync(await saved(page, "png"))
      .subarray(1, 4)
      .toString(),
    "PNG",
  );
  await close();
});
