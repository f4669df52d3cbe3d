// What the page computes is what the program computes; every knob turns to its ends; a link brings all of it back.
import assert from "node:assert/strict";
import { before, test } from "node:test";
import { choose, hypertuna, knobs, link, numbers, open, setting, settled, told, turn } from "./browser.mjs";

const KEYS = {
  speed: "speed_m_s",
  mechanical_power: "mechanical_power_w",
  cost_of_transport: "cost_of_transport_j_per_kg_m",
  strouhal: "strouhal",
  stride_length: "stride_length",
  efficiency: "efficiency",
  tail_excursion: "tail_excursion_m",
};

let studio;
before(async () => {
  studio = await open();
});

/** Assert that the page shows what the program prints. */
async function asNative(page, ...words) {
  const [shown, native] = [await numbers(page), hypertuna("swim", ...words)];
  assert.equal(shown.status, native.status);
  for (const [name, key] of Object.entries(KEYS)) near(shown[name], native[key], `${words.join(" ")}: ${name}`);
  if (native.turn_radius_m !== null && native.turn_radius_m < 100)
    near(shown.turn_radius, native.turn_radius_m, `${words.join(" ")}: turn_radius`, 1e-8);
  const sentence = await page.locator("[data-status]").textContent();
  assert.equal(steady(sentence.split(" From rest")[0]), steady(native.status_text.split(" From rest")[0]));
}

function near(shown, native, what, relative = 1e-10) {
  assert.ok(Math.abs(shown - native) <= relative * Math.abs(native), `${what}: ${shown}, but ${native}`);
}

/** A sentence without what is rounding error alone. */
const steady = (text) => text.replace(/\d(\.\d+)?e-(0[7-9]|1\d)/g, "0");

const options = (page, list) =>
  page.locator(`${list} option`).evaluateAll((all) => all.map(({ value }) => value).filter((value) => value !== ""));

test("the numbers of every robot's named gaits are the program's", async () => {
  const { page, faults } = studio;
  const robots = await options(page, "#robot");
  assert.deepEqual(robots, ["hypertuna", "rexeel", "rexeel-theory"]);
  let compared = 0;
  for (const robot of robots) {
    await choose(page, "#robot", robot);
    for (const gait of await options(page, "[data-gaits]")) {
      await choose(page, "[data-gaits]", gait);
      await asNative(page, "--robot", robot, "--gait", gait);
      compared++;
    }
  }
  assert.ok(compared >= 13);
  assert.deepEqual(faults, []);
});

test("the numbers of every water law and joint model are the program's", async () => {
  const { page, close } = await open({ hash: "#robot=hypertuna" });
  await choose(page, "[data-gaits]", "optimised-0.4");
  for (const water of ["lumped", "strip", "elongated"])
    for (const joints of ["ideal", "bandwidth"]) {
      await page.locator(`[data-water="${water}"]`).click();
      await page.locator(`[data-joints="${joints}"]`).click();
      await settled(page);
      const model = ["--water", water, "--joints", joints];
      await asNative(page, "--robot", "hypertuna", "--gait", "optimised-0.4", ...model);
    }
  await close();
});

test("every knob of every robot turns to its ends, and the page goes on", async () => {
  const { page, close } = await open();
  let turned = 0;
  for (const robot of await options(page, "#robot")) {
    await choose(page, "#robot", robot);
    for (const knob of await knobs(page)) {
      const before = (await setting(page))[knob];
      for (const end of ["min", "max", before]) {
        await turn(page, knob, end);
        const { status, ...values } = await numbers(page);
        assert.ok(["settled", "unsettled", "unstable", "diverged"].includes(status), status);
        if (status === "settled" && end === before)
          assert.ok(Object.values(values).every((value) => !Number.isNaN(value)));
        assert.doesNotMatch(
          await page.locator("main").textContent(),
          /NaN|undefined|Infinity/,
          `${robot}: ${knob} at ${end}`,
        );
        turned++;
      }
    }
  }
  assert.ok(turned >= 3 * (7 + 16 + 16));
  await close();
});

test("the ends of the knobs are those of the robot's gaits", async () => {
  const { page, close } = await open();
  const ends = await page
    .locator("[data-knob]")
    .evaluateAll((all) => Object.fromEntries(all.map((one) => [one.dataset.knob, [Number(one.min), Number(one.max)]])));
  assert.deepEqual(ends.frequency, [0.1, 6]);
  assert.deepEqual(ends["amplitude-1"], [0, 25]);
  assert.deepEqual(ends["phase-1"], [-180, 200]); // of the gait "turning"
  assert.deepEqual(ends["bias-0"], [-16, 16]);
  await close();
});

test("a link brings robot, gait and model back", async () => {
  const { page, close } = await open({ hash: "#robot=hypertuna" });
  await page.locator('[data-water="strip"]').click();
  const wanted = { frequency: 3.217, "amplitude-0": 11.3, "amplitude-1": 19.9, "phase-1": 77.7, "bias-1": 4.2 };
  for (const [knob, value] of Object.entries(wanted)) await turn(page, knob, value);
  const [there, hash] = [await numbers(page), await link(page)];
  const again = await open({ hash });
  const here = await numbers(again.page);
  assert.equal(here.status, there.status);
  for (const name of Object.keys(KEYS)) near(here[name], there[name], name);
  const set = await setting(again.page);
  for (const [knob, value] of Object.entries(wanted)) assert.ok(Math.abs(set[knob] - value) < 1e-6, knob);
  assert.equal(await link(again.page), hash);
  const angles = ["--amplitude", "11.3,19.9", "--phase", "0,77.7", "--bias", "0,4.2"];
  await asNative(again.page, "--robot", "hypertuna", "--water", "strip", "--frequency", "3.217", ...angles);
  await again.close();
  await close();
});

for (const hash of [
  "#robot=nemo",
  "#frequency=x&amplitude=1",
  "#robot=rexeel&frequency=1&amplitude=1,2&phase=0,0",
  "#frequency=-3&amplitude=1,1&phase=0,0",
  "#frequency=1e999",
  "#%E0%A4%A",
  "#over=99,-1&view=none&of=none&tempo=9",
]) {
  test(`a wrong link shows a fish all the same: ${hash}`, async () => {
    const { page, close } = await open({ hash });
    assert.equal((await numbers(page)).status, "settled");
    if (hash.includes("nemo")) assert.match(await told(page), /nemo/);
    await close();
  });
}

test("keys turn a knob, and typing sets it", async () => {
  const { page, close } = await open();
  const before = await numbers(page);
  await page.locator('[data-knob="frequency"]').focus();
  for (let k = 0; k < 5; k++) await page.keyboard.press("ArrowLeft");
  await settled(page);
  const after = await numbers(page);
  assert.ok(after.speed < before.speed);
  await page.locator('.knob:has([data-knob="frequency"]) input[type="number"]').fill("2.5");
  await settled(page);
  assert.equal((await setting(page)).frequency, 2.5);
  await close();
});

test("what is typed beyond a knob's range becomes its end", async () => {
  const { page, close } = await open({ hash: "#robot=hypertuna" });
  const field = page.locator('.knob:has([data-knob="frequency"]) input[type="number"]');
  for (const [typed, kept] of [
    ["20", 6],
    ["-3", 0.1],
  ]) {
    await field.fill(typed);
    await field.press("Enter");
    await settled(page);
    assert.equal(Number(await field.inputValue()), kept);
    assert.equal((await setting(page)).frequency, kept);
  }
  await close();
});

test("the gradient beside a knob is the change of the number", async () => {
  const { page, close } = await open({ hash: "#robot=hypertuna" });
  await choose(page, "[data-gaits]", "optimised-0.3");
  const shown = await page.locator('.knob:has([data-knob="frequency"]) .gradient').textContent();
  const [, number, unit] = /([+−-]?[\d.]+)\s*(.*)/.exec(shown);
  assert.equal(unit, "m/s per Hz");
  const speeds = [];
  for (const frequency of [2.129, 2.131]) {
    await turn(page, "frequency", frequency);
    speeds.push((await numbers(page)).speed);
  }
  near(Number(number.replace("−", "-")), (speeds[1] - speeds[0]) / 0.002, "speed over frequency", 5e-3);
  await close();
});
