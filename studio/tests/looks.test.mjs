// How the page looks and reads: two sizes, light and dark, for keys and screen readers; pictures are kept for eyes.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { test } from "node:test";
import { choose, lived, LOOKS, open, picture, settled } from "./browser.mjs";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const SERIOUS = ["serious", "critical"];

/** Faults for people who do not see or use a mouse, a line each. */
async function barriers(page) {
  if (!(await page.evaluate(() => "axe" in globalThis))) await page.addScriptTag({ content: AXE });
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  return violations
    .filter(({ impact }) => SERIOUS.includes(impact))
    .flatMap(({ id, nodes }) => nodes.map(({ target }) => `${id}: ${target}`));
}

/** Wait until a fish is drawn: a picture of many colors. */
async function drawn(page) {
  await page.waitForFunction(async () => {
    const image = new Image();
    image.src = document.querySelector("#stage").toDataURL();
    await image.decode();
    const copy = new OffscreenCanvas(image.width, image.height).getContext("2d", { willReadFrequently: true });
    copy.drawImage(image, 0, 0);
    const { data } = copy.getImageData(0, 0, image.width, image.height);
    return new Set(new Uint32Array(data.buffer)).size > 20;
  });
}

/** Let the twin run for a moment: it stands still where less motion is wanted. */
async function live(page) {
  await page.locator("#inside").getByRole("button", { name: "Go on" }).click();
  await lived(page, 1.5);
  await page.locator("#inside").getByRole("button", { name: "Pause" }).click();
}

for (const { size, viewport, colorScheme } of LOOKS) {
  test(`${size}, ${colorScheme}: nothing is cut off, nobody is shut out`, async () => {
    const { page, close } = await open({ viewport, colorScheme, hash: "#robot=hypertuna" });
    await drawn(page);
    await picture(page, `${size}-${colorScheme}-gait`);
    assert.deepEqual(await barriers(page), []);
    for (const view of await page
      .locator("[data-view]")
      .evaluateAll((tabs) => tabs.map(({ dataset }) => dataset.view))) {
      await page.locator(`[data-view="${view}"]`).click();
      await settled(page);
      await page.waitForTimeout(500); // maps are drawn as they are computed
      if (view === "inside") await live(page);
      await picture(page, `${size}-${colorScheme}-${view}`);
      assert.deepEqual(await barriers(page), [], view);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `${view}: ${wide} px beyond the window`);
    }
    await choose(page, "#robot", "rexeel");
    await drawn(page);
    await picture(page, `${size}-${colorScheme}-rexeel`);
    await close();
  });
}

test("the fish swims, and stands still for those who want less motion", async () => {
  for (const [reducedMotion, moves] of [
    ["no-preference", true],
    ["reduce", false],
  ]) {
    const { page, close } = await open({ reducedMotion });
    const look = () => page.locator("#stage").evaluate((canvas) => canvas.toDataURL());
    await page.waitForTimeout(300);
    const first = await look();
    await page.waitForTimeout(300);
    assert.equal((await look()) !== first, moves, reducedMotion);
    await close();
  }
});

test("every control is reached by the Tab key and has a name", async () => {
  const { page, close } = await open();
  const controls = await page.locator("button:visible, select:visible, input:visible, summary:visible").count();
  const reached = new Set();
  for (let k = 0; k < 3 * controls; k++) {
    await page.keyboard.press("Tab");
    reached.add(
      await page.evaluate(() => {
        const at = document.activeElement;
        return [...document.querySelectorAll("*")].indexOf(at);
      }),
    );
  }
  const shut = await page.locator("button, select, input, summary").evaluateAll(
    (all, reached) =>
      all
        .filter((one) => one.checkVisibility() && !reached.includes([...document.querySelectorAll("*")].indexOf(one)))
        .filter((one) => one.tabIndex >= 0)
        .map((one) => one.outerHTML.slice(0, 80)),
    [...reached],
  );
  assert.deepEqual(shut, []);
  await close();
});
