// Uncertainty of a fit or of estimates: intervals beside the numbers are Python's, and are drawn in cost over speed.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { join } from "node:path";
import { test } from "node:test";
import { choose, hypertuna, numbers, open, picture, says, settled, SIZES, temporary, turn } from "./browser.mjs";

const SWIMS = `
import json, sys
import numpy as np
import hypertuna as ht
from hypertuna.identification.coefficients import sample_robots
from hypertuna.identification.image import SAMPLES, SEED
robot = ht.load("rexeel")
gait = ht.Gait.from_degrees(frequency=0.7, amplitude=(10,) * 5, phase=(0, 50.4, 100.8, 151.2, 201.6))
swims = [ht.swim(one, gait) for one in sample_robots(robot, SAMPLES, SEED)]
names = ("speed", "mechanical_power", "cost_of_transport")
print(json.dumps({name: np.quantile([getattr(s, name) for s in swims], (0.05, 0.95)).tolist() for name in names}))
`;

/** Intervals that are shown, by quantity. */
async function intervals(page) {
  const shown = await page
    .locator("#facts [data-interval]")
    .evaluateAll((all) => all.map((box) => ({ hidden: box.hidden, ...box.dataset })));
  return Object.fromEntries(
    shown.filter(({ hidden }) => !hidden).map((one) => [one.interval, [Number(one.low), Number(one.high)]]),
  );
}

/** Wait until another interval of the speed is shown. */
function others(page, low) {
  const other = (low) => Number(document.querySelector('[data-interval="speed"]').dataset.low) !== low;
  return page.waitForFunction(other, low);
}

/** Number of points of the canvas that are of a color, painted with an opacity of at most `most` of 255. */
function painted(page, color, most) {
  return page.locator("#front canvas").evaluate(
    (canvas, [color, most]) => {
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
      copy.drawImage(canvas, 0, 0);
      const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
      const alike = (k) => color.every((part, i) => Math.abs(data[k + i] - part) < 8);
      let count = 0;
      for (let k = 0; k < data.length; k += 4) if (data[k + 3] > 40 && data[k + 3] <= most && alike(k)) count++;
      return count;
    },
    [color, most],
  );
}

test("the intervals beside the numbers are those of Python's samples", async () => {
  const { page, close } = await open({ hash: "#robot=rexeel" });
  const before = await page.waitForFunction(() => document.querySelector('[data-interval="speed"]').dataset.low > 0);
  await before.dispose();
  const was = (await intervals(page)).speed[0];
  await turn(page, "frequency", 0.7);
  await others(page, was);
  const program = process.env.PYTHON ?? "python";
  const native = JSON.parse(execFileSync(program, ["-c", SWIMS], { encoding: "utf8" }));
  const shown = await intervals(page);
  for (const [name, ends] of Object.entries(native))
    ends.forEach((end, k) => {
      assert.ok(Math.abs(shown[name][k] / end - 1) < 1e-9, `${name}: ${shown[name]}, but ${ends}`);
    });
  const tile = page.locator('[data-interval="speed"]');
  assert.match(await tile.textContent(), /^0\.\d+ – 0\.\d+$/);
  assert.equal(
    await page.locator("#facts + .caption").textContent(),
    "Small numbers: 5 to 95 % of 64 samples of the fit.",
  );
  await close();
});

test("bars and band are drawn around the gaits and the least cost; other robots have none", async () => {
  const { page, close } = await open({ hash: "#robot=rexeel&view=front" });
  const note = page.locator("#front .caption").first();
  await page.waitForFunction(() => /64 samples/.test(document.querySelector("#front .caption").textContent));
  const bars = [0, 0x72, 0xb2];
  await page.getByRole("button", { name: "Least cost at all speeds" }).click();
  await says(page, "#front [role=status]", /The line is/, 120_000);
  const band = [0, 0x87, 0x5f];
  for (let k = 0; k < 40 && (await painted(page, band, 60)) <= 500; k++) await page.waitForTimeout(500);
  await picture(page, "front-of-a-fit");
  assert.ok((await painted(page, band, 60)) > 500, "a band is painted");
  assert.ok((await painted(page, bars, 210)) > 30, "bars are painted");
  await page.locator("#robot").selectOption("hypertuna");
  await settled(page);
  await page.waitForFunction(() => document.querySelector("#front .caption").textContent === "");
  assert.equal(await note.textContent(), "");
  assert.deepEqual(await intervals(page), {});
  assert.equal(await painted(page, band, 60), 0);
  await close();
});

test("a changed body has intervals of its own", async () => {
  const { page, close } = await open({ hash: "#robot=rexeel&view=body" });
  await page.waitForFunction(() => document.querySelector('[data-interval="speed"]').dataset.low > 0);
  const was = (await intervals(page)).speed;
  await page.locator('[data-body="length-5"]').evaluate((input) => {
    input.value = input.max;
    input.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await others(page, was[0]);
  await choose(page, "#robot", "rexeel-theory");
  await page.waitForFunction(() => document.querySelector('[data-interval="speed"]').hidden);
  await close();
});

for (const [size, viewport] of Object.entries({ laptop: { width: 1280, height: 900 }, phone: SIZES.phone })) {
  test(`the band of a robot with estimates is that of hypertuna swim and follows the knobs: ${size}`, async () => {
    const folder = temporary("band-");
    const [robot, file] = [join(folder, "fish.toml"), join(folder, "fish.html")];
    execFileSync(process.env.HYPERTUNA ?? "hypertuna", ["robot", "new", robot, "--links", "3"]);
    hypertuna("studio", robot, "-o", file);
    const { page, close } = await open({ file, viewport });
    const shown = page.locator('[data-interval="speed"]');
    const agrees = async (...words) => {
      const { speed_m_s: speed, band } = hypertuna("swim", "--robot", robot, "--gait", "cruise", ...words);
      const near = (a, b) => Math.abs(a / b - 1) < 1e-3; // swim has fewer steps of a beat for the band
      await page.waitForFunction(
        (low) => Math.abs(document.querySelector('[data-interval="speed"]').dataset.low / low - 1) < 1e-3,
        band.low_m_s,
      );
      assert.ok(near((await intervals(page)).speed[1], band.high_m_s));
      assert.ok(near((await numbers(page)).speed, speed));
      const [low, high] = (await shown.textContent()).split(" – ");
      const line = await page.locator("#numbers").textContent();
      assert.match(line, /^[\d.]+ m\/s \([\d.]+ to [\d.]+ by the estimates\) · [\d.]+ W · [\d.]+ J\/\(kg m\)$/);
      assert.ok(line.includes(`(${low} to ${high} by`));
    };
    await agrees();
    await turn(page, "frequency", 1.1);
    await agrees("--frequency", "1.1");
    assert.deepEqual(Object.keys(await intervals(page)), ["speed"]); // the law's error of the others is not known
    assert.match(await page.locator("#facts + .caption").textContent(), /128 samples of the estimates/);
    const room = await shown.evaluate(
      (box) => box.closest("div").getBoundingClientRect().right - box.getBoundingClientRect().right,
    );
    assert.ok(room > 0, "the tile holds the interval");
    await picture(page, `band-${size}`);
    await choose(page, "#robot", "hypertuna");
    await page.waitForFunction(() => document.querySelector('[data-interval="speed"]').hidden);
    assert.doesNotMatch(await page.locator("#numbers").textContent(), /estimates/);
    await close();
  });
}
