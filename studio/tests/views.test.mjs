// The views below the fish: a map to click on, searches that end where the program's do, published gaits to swim.
import assert from "node:assert/strict";
import { test } from "node:test";
import { choose, hypertuna, knobs, link, lived, numbers, open, says, setting, settled, turn } from "./browser.mjs";

const FRAME = 50; // ms, of a machine with other work to do: 17 on a free one

/** Open the page at a view. */
async function at(view, hash = "#robot=hypertuna") {
  const studio = await open({ hash });
  await studio.page.locator(`[data-view="${view}"]`).click();
  await settled(studio.page);
  return studio;
}

/** Wait until a search has ended; return its sentence. */
async function ended(page) {
  const status = page.locator("#front [role=status]");
  await says(page, "#front [role=status]", /ended|No search|No gait/, 120_000);
  await settled(page);
  return status.textContent();
}

test("a click on the map goes there, and the map tells the number that the gait has", async () => {
  const { page, close } = await at("map");
  const canvas = page.locator("#map canvas");
  const box = await canvas.boundingBox();
  const middle = { x: box.width / 2, y: box.height / 2 };
  await page.waitForSelector('#map[aria-busy="false"]'); // its finest grid
  let told = "";
  while (!/m\/s$/.test(told)) {
    // until no frame that was still to be drawn covers it
    await canvas.hover({ position: { x: middle.x + 1, y: middle.y } });
    await canvas.hover({ position: middle });
    told = (await page.locator("#map .caption").textContent()).trim();
  }
  const [, hertz, angle, speed] = /^([\d.]+) Hz, (−?[\d.]+) deg: speed (−?[\d.]+) m\/s$/.exec(told.replace(/ /g, " "));
  await canvas.click({ position: middle });
  await settled(page);
  const set = await setting(page);
  assert.ok(Math.abs(set.frequency - Number(hertz)) < 0.01, told);
  assert.ok(Math.abs(set["phase-1"] - Number(angle.replace("−", "-"))) < 0.1, told);
  assert.equal(set["amplitude-0"], 16);
  assert.ok(Math.abs((await numbers(page)).speed - Number(speed.replace("−", "-"))) < 0.03, told); // nearest of a grid
  await canvas.press("ArrowRight");
  await settled(page);
  assert.ok((await setting(page)).frequency > set.frequency);
  await close();
});

test("knobs answer while a map is computed", async (context) => {
  const { page, close } = await at("map");
  const begin = performance.now();
  for (let k = 0; k < 10; k++) await turn(page, "amplitude-0", 6 + k);
  const each = (performance.now() - begin) / 10;
  context.diagnostic(`knob to numbers beside a map, by the test's own clock: ${each.toFixed(0)} ms`);
  assert.ok(each < 1000);
  const frames = await page.evaluate(async () => {
    document.querySelector('[data-tempo="1"]').click();
    const times = [];
    while (times.length < 60) times.push(await new Promise(requestAnimationFrame));
    return times.slice(1).map((time, k) => time - times[k]);
  });
  const median = frames.sort((a, b) => a - b)[frames.length >> 1];
  context.diagnostic(`frames beside a map: ${(1000 / median).toFixed(0)} a second`);
  assert.ok(median < FRAME, `${median} ms`);
  await close();
});

test("the maximum speed is the program's", async (context) => {
  const { page, close } = await at("front");
  await choose(page, "[data-gaits]", "unoptimised-0.3");
  await page.getByRole("button", { name: "Maximum speed" }).click();
  context.diagnostic(await ended(page));
  const native = hypertuna("optimize", "--maximize", "speed");
  const { speed, status } = await numbers(page);
  assert.equal(status, "settled");
  assert.ok(Math.abs(speed / native.speed_m_s - 1) < 1e-4, `${speed}, but ${native.speed_m_s}`);
  await close();
});

test("the least cost at a speed is the program's", async (context) => {
  const { page, close } = await at("front");
  await page.getByLabel("speed [m/s] to swim at least cost").fill("0.4");
  await page.getByRole("button", { name: "Least cost at", exact: true }).click();
  context.diagnostic(await ended(page));
  const native = hypertuna("optimize", "--speed", "0.4");
  const { speed, cost_of_transport: cost } = await numbers(page);
  assert.ok(Math.abs(speed - 0.4) < 1e-4, `${speed}`);
  assert.ok(Math.abs(cost / native.cost_of_transport_j_per_kg_m - 1) < 1e-3, `${cost}`);
  await close();
});

test("a speed that no gait reaches is told, and a search can be stopped", async () => {
  const { page, close } = await at("front");
  await page.getByLabel("speed [m/s] to swim at least cost").fill("9");
  await page.getByRole("button", { name: "Least cost at", exact: true }).click();
  assert.match(await ended(page), /No search reached 9 m\/s/);
  await page.getByRole("button", { name: "Least cost at all speeds" }).click();
  await page.getByRole("button", { name: "Cancel" }).click();
  await page.waitForFunction(() => /cancel/.test(document.querySelector("#front [role=status]").textContent));
  await turn(page, "frequency", 3);
  assert.equal((await setting(page)).frequency, 3);
  await close();
});

test("a search that fails gives the knobs back; one that is overtaken leaves them", async () => {
  const { page, close } = await at("front");
  const before = await setting(page);
  await page.locator('#front input[type="number"]').fill("0.9");
  await page.getByRole("button", { name: "Least cost at", exact: true }).click();
  assert.match(await ended(page), /No search reached 0.9 m\/s/);
  await settled(page);
  assert.deepEqual(await setting(page), before);
  await page.getByRole("button", { name: "Maximum speed" }).click();
  await turn(page, "frequency", 2);
  await page.waitForFunction(() => /Stopped/.test(document.querySelector("#front").textContent));
  await page.waitForTimeout(500);
  assert.equal((await setting(page)).frequency, 2);
  await close();
});

test("a knob that is turned while the page is slow stays where it was turned", async () => {
  const { page, close } = await at("front");
  await page.evaluate(() => {
    const { postMessage } = Worker.prototype;
    Worker.prototype.postMessage = function (message) {
      const late = ["swim", "path", "gradient"].includes(message.question.kind); // of the knobs, not of the search
      setTimeout(() => postMessage.call(this, message), late ? 1000 : 0);
    };
  });
  await page.getByRole("button", { name: "Maximum speed" }).click();
  await page.waitForFunction(() => /step 1/.test(document.querySelector("#front [role=status]").textContent));
  await turn(page, "frequency", 2);
  assert.match(await page.locator("#front [role=status]").textContent(), /Stopped/);
  assert.equal((await setting(page)).frequency, 2);
  await close();
});

for (const late of ["page", "views"])
  test(`a robot that loads slowly does not overtake one that was chosen after it: in the ${late}`, async () => {
    const { page, close } = await at("paper");
    await page.evaluate((late) => {
      const { postMessage } = Worker.prototype;
      let loads = 0; // of rexeel, the first by the page
      Worker.prototype.postMessage = function (message) {
        const { kind, robot } = message.question;
        const slow = kind === "load" && robot === "rexeel" && (loads++ === 0) === (late === "page");
        setTimeout(() => postMessage.call(this, message), slow ? 1000 : 0);
      };
    }, late);
    await page.locator("#robot").selectOption("rexeel");
    if (late === "views") await page.waitForSelector('[data-knob="amplitude-4"]', { state: "attached" });
    await page.locator("#robot").selectOption("hypertuna");
    await page.waitForTimeout(2500);
    await settled(page);
    assert.equal(await page.locator("#robot").inputValue(), "hypertuna");
    assert.equal((await knobs(page)).length, 7);
    assert.match(await page.locator("#paper .intro").textContent(), /hypertuna's gaits/);
    await close();
  });

test("a published gait swims from its card, with what was published of it", async () => {
  const { page, close } = await at("paper");
  const card = page.locator("#paper .card").filter({ hasText: "unoptimised-max" });
  await card.waitFor();
  assert.match(await card.textContent(), /0\.56 m\/s/);
  assert.match(await card.textContent(), /0\.5775 m\/s/);
  assert.match(await card.textContent(), /measured on the robot/);
  const heading = page.getByRole("heading", { name: "unoptimised-0.4", exact: true });
  const target = page.locator("#paper .card").filter({ has: heading });
  assert.match(await target.textContent(), /not a measurement/);
  await target.getByRole("button").click();
  await settled(page);
  assert.equal(await page.locator("[data-gaits]").inputValue(), "unoptimised-0.4");
  assert.equal((await setting(page)).frequency, 3);
  await choose(page, "#robot", "rexeel");
  await page.waitForFunction(() => /rexeel/.test(document.querySelector("#paper").textContent));
  assert.doesNotMatch(await page.locator("#paper").textContent(), /published \d/);
  await close();
});

test("arrow keys go from view to view, and the link keeps the view", async () => {
  const { page, close } = await at("map");
  await page.locator('[data-view="map"]').focus();
  await page.keyboard.press("ArrowRight");
  assert.equal(await page.locator('[data-view="front"]').getAttribute("aria-selected"), "true");
  const again = await open({ hash: await link(page) });
  assert.ok(await again.page.locator("#front").isVisible());
  await again.close();
  await close();
});

/** Text and label of the twin's numbers. */
function facts(page) {
  return page
    .locator("#inside .facts > div")
    .evaluateAll((all) =>
      Object.fromEntries(all.map((one) => [one.querySelector("dd").textContent, one.querySelector("dt").textContent])),
    );
}

test("the twin swims as the program's, and its controller tells what it does about a broken sensor", async (context) => {
  const { page, close } = await open({ hash: "#robot=hypertuna", reducedMotion: "no-preference" });
  await choose(page, "[data-gaits]", "optimised-0.3");
  await page.locator('[data-view="inside"]').click();
  await page.locator('#inside label:has-text("tempo") select').selectOption("20");
  await lived(page, 20);
  const native = hypertuna("twin", "--gait", "optimised-0.3", "--duration", "20");
  const now = await facts(page);
  context.diagnostic(JSON.stringify(now));
  const near = (label, wanted, part) =>
    assert.ok(Math.abs(parseFloat(now[label]) / wanted - 1) < part, `${label}: ${now[label]}, but ${wanted}`);
  near("speed, mean of a beat", native.speed_m_s, 0.02);
  near("electrical power", native.electrical_power_w, 0.05);
  const guard = page.locator("#inside .guard");
  assert.match(await guard.textContent(), /reports nothing|limit|servo/);
  await page.locator('#inside label:has-text("break a sensor") select').selectOption("open");
  await page.getByRole("button", { name: "bend I", exact: true }).click();
  await says(page, "#inside .guard", /joint I: the bend sensor's reading is not plausible\./);
  await page.getByRole("button", { name: "bend I", exact: true }).click();
  await page.waitForFunction(() => !/bend sensor/.test(document.querySelector("#inside .guard").textContent));
  await page.getByRole("button", { name: "Start again" }).click();
  await page.waitForFunction(() => parseFloat(document.querySelector("#inside .facts dt").textContent) < 20);
  await page.getByRole("button", { name: "Pause", exact: true }).click();
  await close();
});

test("a robot without a twin says why, in a sentence", async () => {
  const { page, close } = await at("inside", "#robot=rexeel");
  await says(page, "#inside", /rexeel has no twin: its file has no controller\./);
  await choose(page, "#robot", "hypertuna");
  await page.getByRole("button", { name: "bend I", exact: true }).waitFor();
  await choose(page, "#robot", "rexeel");
  await says(page, "#inside", /rexeel has no twin: its file has no controller\./);
  await close();
});
