// The body: every knob to its ends, by sliders, numbers, handles and keys; what follows it; links, reset, the saved file.
import assert from "node:assert/strict";
import { readFileSync, copyFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { test } from "node:test";
import { hypertuna, link, lived, numbers, open, picture, settled, SIZES, temporary } from "./browser.mjs";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const folder = temporary("studio-");

/** Open the page at the body. */
async function body(hash = "", options = {}) {
  const studio = await open({ hash: `#robot=hypertuna&view=body${hash}`, ...options });
  await studio.page.locator("#body .gains dt").first().waitFor();
  return studio;
}

/** Turn a knob of the body to a factor, or to its "min" or "max". */
async function turn(page, knob, factor) {
  await page.locator(`[data-body="${knob}"]`).evaluate((input, to) => {
    input.value = to in input ? input[to] : String(to);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }, factor);
  await settled(page);
}

/** Factors of the knobs that are changed, as the address has them. */
async function factors(page) {
  const text = new URLSearchParams((await link(page)).slice(1)).get("body");
  return text === null ? {} : Object.fromEntries(text.split(",").map((part) => part.split(":")));
}

/** Gains beside the described robot in percent, once they are computed. */
async function gains(page) {
  await page.waitForFunction(() =>
    [...document.querySelectorAll("#body [data-gain]")].every(({ dataset }) => dataset.value !== "NaN"),
  );
  const shown = await page.locator("#body [data-gain]").evaluateAll((all) => all.map(({ dataset }) => dataset));
  return Object.fromEntries(shown.map(({ gain, value }) => [gain, Number(value)]));
}

/** Save the changed robot; returns the path of the file. */
async function saved(page) {
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: "Save the robot (TOML)" }).click(),
  ]);
  const path = join(folder, download.suggestedFilename());
  copyFileSync(await download.path(), path);
  return path;
}

test("each knob goes to its ends, and the robot swims there", async () => {
  const { page, close } = await body();
  const knobs = await page.locator("[data-body]").evaluateAll((all) => all.map(({ dataset }) => dataset.body));
  assert.equal(knobs.length, 18);
  const { speed: before } = await numbers(page);
  for (const knob of knobs) {
    const speeds = [];
    for (const end of ["min", "max"]) {
      await turn(page, knob, end);
      speeds.push((await numbers(page)).speed);
    }
    assert.ok(
      speeds.every((speed) => speed > 0),
      `${knob}: ${speeds}`,
    );
    assert.equal(speeds[0] === speeds[1], knob === "silicone", `${knob}: ${speeds}`); // it acts in the twin
    await page.locator(`#body .knob:has([data-body="${knob}"]) button`).click();
    assert.equal((await numbers(page)).speed, before, `${knob} was reset`);
  }
  await close();
});

test("the saved file swims as the page, marks what changed and keeps the rest", async () => {
  const { page, close } = await body();
  await turn(page, "length-7", 1.2);
  await turn(page, "mass-0", 0.9);
  await turn(page, "fin", 1.4);
  const path = await saved(page);
  const text = readFileSync(path, "utf8");
  assert.match(path, /hypertuna-changed\.toml$/);
  assert.match(text, /^length_m = 0\.5378 {2}# changed from 0\.520$/m);
  assert.match(text, /^length_m {8}= \[.*0\.1068\] {2}# \[7\] changed from 0\.089$/m);
  assert.match(text, /^# HyperTuna: hydraulically powered/);
  const { speed, mechanical_power: power, cost_of_transport: cost } = await numbers(page);
  for (const water of ["lumped", "strip"]) {
    if (water === "strip") await page.locator('[data-water="strip"]').click();
    const here = water === "strip" ? await numbers(page) : { speed, mechanical_power: power, cost_of_transport: cost };
    const native = hypertuna("swim", "--robot", path, "--gait", "unoptimised-max", "--water", water);
    for (const [ours, theirs] of [
      [here.speed, native.speed_m_s],
      [here.mechanical_power, native.mechanical_power_w],
      [here.cost_of_transport, native.cost_of_transport_j_per_kg_m ?? native.cost_of_transport],
    ])
      assert.ok(Math.abs(ours / theirs - 1) < 1e-10, `${water}: ${ours} and ${theirs}`);
  }
  const gain = await gains(page);
  const described = hypertuna("swim", "--robot", "hypertuna", "--gait", "unoptimised-max", "--water", "strip");
  const changed = hypertuna("swim", "--robot", path, "--gait", "unoptimised-max", "--water", "strip");
  assert.ok(Math.abs(gain.speed - 100 * (changed.speed_m_s / described.speed_m_s - 1)) < 1e-7);
  await close();
});

test("a link keeps the body; reset takes it back", async () => {
  const { page, close } = await body();
  await turn(page, "length-7", 1.2);
  await turn(page, "mass-0", "min");
  assert.deepEqual(await factors(page), { "length-7": "1.2", "mass-0": "0.6" });
  const there = await numbers(page);
  const hash = await link(page);
  const again = await open({ hash });
  assert.deepEqual(await numbers(again.page), there);
  assert.deepEqual(await factors(again.page), { "length-7": "1.2", "mass-0": "0.6" });
  await again.close();
  await page.getByRole("button", { name: "Reset all" }).click();
  await settled(page);
  assert.deepEqual(await factors(page), {});
  assert.ok(await page.getByRole("button", { name: "Reset all" }).isDisabled());
  const odd = await body("&body=length-7:99,tusk:2,mass-0:x,fin:-1,length-6:1");
  assert.deepEqual(await factors(odd.page), { "length-7": "1.6" });
  await odd.close();
  await close();
});

test("handles are dragged and pressed, numbers typed", async () => {
  const { page, close } = await body();
  await page.locator(".drawing").scrollIntoViewIfNeeded();
  const drag = async (name, right, down) => {
    const box = await page.locator(`[data-handle="${name}"] circle:not(.reach)`).boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2 + right, box.y + box.height / 2 + down, { steps: 5 });
    await page.mouse.up();
    await settled(page);
  };
  await drag("length-7", 8, 0);
  await drag("fin", 0, -6);
  await drag("mass-0", 0, 12);
  const dragged = await factors(page);
  assert.ok(dragged["length-7"] > 1.05 && dragged.fin > 1.05 && dragged["mass-0"] < 0.95, JSON.stringify(dragged));
  const handle = page.locator('[data-handle="length-0"]');
  await handle.focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("PageDown");
  assert.equal((await factors(page))["length-0"], "0.91");
  assert.equal(await handle.getAttribute("aria-valuetext"), "0.2557 m");
  await page.keyboard.press("End");
  assert.equal((await factors(page))["length-0"], "1.6");
  const typed = page.getByLabel("mass of L7 [kg]");
  await typed.fill("0.06");
  await typed.press("Enter");
  await settled(page);
  assert.equal((await factors(page))["mass-7"], String(0.06 / 0.049));
  assert.match(readFileSync(await saved(page), "utf8"), /^mass_kg {9}= \[.*0\.06\] {2}#/m);
  await close();
});

test("map, cost over speed and twin follow; published gaits are the described robot's", async () => {
  const { page, close } = await body("&body=length-7:1.3,mass-7:1.4");
  const { speed } = await numbers(page);
  await page.locator('[data-view="paper"]').click();
  const described = await open({ hash: "#robot=hypertuna&view=paper" });
  const words = async (at) => at.locator("#paper .card").first().textContent();
  assert.equal(await words(page), await words(described.page));
  await described.close();
  await page.locator('[data-view="inside"]').click();
  await page.locator("#inside").getByRole("button", { name: "Go on" }).click();
  await lived(page, 1);
  assert.ok(speed > 0);
  await close();
});

test("another robot has knobs of its own", async () => {
  const { page, close } = await body("&robot=rexeel");
  await page.locator("#robot").selectOption("rexeel");
  await settled(page);
  assert.equal(await page.locator("[data-body]").count(), 13);
  assert.match(await page.locator("#body [role=status]").textContent(), /as the file describes it/);
  await close();
});

for (const [size, viewport] of [
  ["wide", SIZES.wide],
  ["phone", SIZES.phone],
])
  for (const colorScheme of ["light", "dark"])
    test(`${size}, ${colorScheme}: the changed body is read by everyone`, async () => {
      const { page, close } = await body("&body=length-7:1.2,mass-0:0.9,fin:1.3", { viewport, colorScheme });
      await gains(page);
      await picture(page, `${size}-${colorScheme}-body-changed`);
      await page.addScriptTag({ content: AXE });
      const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
      const serious = violations.filter(({ impact }) => ["serious", "critical"].includes(impact));
      assert.deepEqual(
        serious.flatMap(({ id, nodes }) => nodes.map(({ target }) => `${id}: ${target}`)),
        [],
      );
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `${wide} px wider than the window`);
      await close();
    });
