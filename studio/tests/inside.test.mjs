// Inside robots of every kind of drive: what they have is shown, and nothing that they do not have; limits by their names.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { before, test } from "node:test";
import { crowded, lived, open, picture, settled, SIZES, temporary, turn, watchTexts } from "./browser.mjs";

const HYPERTUNA = process.env.HYPERTUNA ?? "hypertuna";
const folder = temporary("inside-");
const run = (...words) => execFileSync(HYPERTUNA, words, { stdio: "ignore" });
const OIL = /\boil\b|kPa|pump|cylinder|muscle|piston|suction/i;
const SERVO = /servo torque/;
const [AXLE, DRUM] = [/servos on the axles/, /tendons/];
const SIZE = { wide: SIZES.wide, phone: SIZES.phone };

before(async () => {
  for (const actuation of ["servo", "hydraulic"])
    for (const links of [3, 5]) {
      const file = join(folder, `${actuation}${links}.toml`);
      run("robot", "new", file, "--links", String(links), "--actuation", actuation);
    }
  run("robot", "new", join(folder, "tendons3.toml"), "--actuation", "tendons");
  run("robot", "new", join(folder, "many.toml"), "--links", "14", "--actuation", "servo"); // one group more than a twin has
  run("robot", "new", join(folder, "supple.toml"), "--tail", "flexible", "--actuation", "servo");
  writeFileSync(join(folder, "mixed3.toml"), mixed());
  for (const name of ["servo3", "servo5", "hydraulic3", "hydraulic5", "mixed3", "tendons3", "supple", "many"])
    run("studio", join(folder, `${name}.toml`), "-o", join(folder, `${name}.html`));
});

/** A robot whose first joint has oil, and whose second has a servo on its axle. */
function mixed() {
  const text = (name) => readFileSync(join(folder, `${name}.toml`), "utf8");
  const second = (name) => /\[\[joints\]\]\nname = "J2".*?(?=\[model\])/s.exec(text(name))[0];
  return text("hydraulic3")
    .replace(second("hydraulic3"), second("servo3"))
    .replace("count = 4", "count = 2")
    .replace('name = "hydraulic3"', 'name = "mixed3"');
}

/** Open a robot's Inside view, and let its twin run for a moment. */
async function inside(name, options = {}) {
  const studio = await open({ file: join(folder, `${name}.html`), ...options });
  await studio.page.locator('[data-view="inside"]').click();
  return studio;
}

async function live(page, until) {
  await page.locator("#inside").getByRole("button", { name: "Go on" }).click();
  await lived(page, until);
  await page.locator("#inside").getByRole("button", { name: "Pause" }).click();
}

/** Frames of a beat in which the machine is drawn to the picture's edge; -1 where nothing is drawn. */
const cut = (page) =>
  page.locator("#inside .machine").evaluate(async (canvas) => {
    const run = [...document.querySelectorAll("#inside button")].find(({ textContent }) => textContent === "Go on");
    run.click();
    const pen = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const drawn = (x, y, wide, high) => {
      const { data } = pen.getImageData(x, y, wide, high);
      return new Uint32Array(data.buffer).some((pixel) => pixel !== 0);
    };
    let edges = 0;
    for (const begin = performance.now(); performance.now() - begin < 1500; ) {
      await new Promise(requestAnimationFrame);
      const { width, height } = Object.assign(pen.canvas, { width: canvas.width, height: canvas.height });
      pen.drawImage(canvas, 0, 0);
      if (!drawn(0, 0, width, height)) return -1;
      const rows = [0, height - 1].map((y) => [0, y, width, 1]);
      const columns = [0, width - 1].map((x) => [x, 0, 1, height]);
      if ([...rows, ...columns].some((strip) => drawn(...strip))) edges++;
    }
    run.click();
    return edges;
  });

/** All that the view says: texts, labels for screen readers, legends. */
const words = (page) =>
  page.locator("#inside").evaluate((room) => {
    const labels = [...room.querySelectorAll("[aria-label]")].map((one) => one.getAttribute("aria-label"));
    return `${room.innerText}\n${labels.join("\n")}`;
  });

for (const [name, oil, axles, drums] of [
  ["servo3", false, true, false],
  ["servo5", false, true, false],
  ["hydraulic3", true, false, false],
  ["hydraulic5", true, false, false],
  ["mixed3", true, true, false],
  ["tendons3", false, false, true],
])
  for (const [size, viewport] of Object.entries(SIZE))
    test(`${name}, ${size}: it shows the drives that the robot has, and no text over another`, async () => {
      const { page, close } = await inside(name, { viewport });
      await page.locator("#inside .machine").waitFor();
      await watchTexts(page, ".machine");
      await live(page, 2.5);
      assert.deepEqual(await crowded(page, ".machine", name.endsWith("5") ? 4 : 2), []);
      const text = await words(page);
      assert.equal(OIL.test(text), oil, text);
      assert.equal(SERVO.test(text), axles || drums, text);
      assert.equal(AXLE.test(text), axles, text);
      assert.equal(DRUM.test(text), drums, text);
      const plots = await page.locator("#inside .timeplot").evaluateAll((all) => all.map(({ ariaLabel }) => ariaLabel));
      const wanted = ["bend", ...(oil ? ["pressure"] : []), ...(axles || drums ? ["torque of the servo"] : [])];
      assert.deepEqual(
        plots,
        wanted.map((one) => `${one} over time`),
      );
      // each trace of a legend has a style of its own
      for (const legend of await page.locator("#inside .u-legend").all()) {
        const styles = await legend
          .locator(".u-marker")
          .evaluateAll((all) => all.map(({ style }) => style.border).filter((border) => border !== ""));
        assert.ok(styles.length > 0);
        assert.equal(new Set(styles).size, styles.length, styles.join("; "));
      }
      // the table says of every joint what moves it
      const rows = await page
        .locator("#inside .joints tr")
        .evaluateAll((all) => all.map((row) => [...row.children].map(({ textContent }) => textContent)));
      const [head, ...joints] = rows;
      assert.equal(head.includes("oil, left [kPa]"), oil);
      assert.ok(
        joints.every((row) => row.slice(1).filter((cell) => /\d/.test(cell)).length >= 3),
        rows.join("\n"),
      );
      // the losses add up to what the battery gives, and name what the robot has
      const losses = page.locator("#inside .losses");
      const given = Number.parseFloat(/[\d.]+(?= W)/.exec(await losses.locator("p").innerText())[0]);
      const lost = (await losses.locator("b:visible").allInnerTexts()).map((text) => Number(text.replace("−", "-")));
      const sum = lost.reduce((all, one) => all + one, 0);
      assert.ok(given > 0 && Math.abs(sum - given) < 0.02 * given, `${lost} W of ${given} W`);
      const places = await losses.locator(".loss:visible > span:first-child").allInnerTexts();
      assert.deepEqual(
        [places.includes("oil"), places.includes("servos"), places.includes("water")],
        [oil, true, true],
      );
      // the caption of the fish above stays in its picture
      const [frame, caption] = await Promise.all(
        ["#picture", "#caption"].map((part) => page.locator(part).boundingBox()),
      );
      assert.ok(frame.y <= caption.y && caption.y + caption.height <= frame.y + frame.height, `at ${caption.y} px`);
      await picture(page, `inside-${name}-${size}`);
      await close();
    });

for (const [name, limit] of [
  ["servo3", "joint J1, J2: the joint was asked to bend further than it reaches."],
  ["mixed3", "joint J2: the joint was asked to bend further than it reaches."],
])
  test(`${name}: the limit of a servo's amplitude is its largest bend, not a pressure`, async () => {
    const { page, close } = await inside(name);
    for (const joint of [0, 1]) await turn(page, `amplitude-${joint}`, "max");
    await page.locator("#inside .machine").waitFor();
    await live(page, 2);
    assert.equal(await cut(page), 0);
    for (const joint of [0, 1]) await turn(page, `bias-${joint}`, "max");
    await live(page, 4.5);
    assert.equal(await cut(page), 0);
    const told = (await page.locator("#inside .guard").textContent()).split("\n");
    assert.ok(told.includes(limit), told.join("\n"));
    assert.ok(!told.some((line) => /pressure/.test(line) && /J2/.test(line)), told.join("\n"));
    if (name === "servo3") assert.ok(!/pressure|pump/.test(told.join()), told.join("\n"));
    await close();
  });

test("a robot without a twin says why, and has all other views", async () => {
  const { page, close } = await inside("many");
  await page.getByText("many has no twin: it has 13 joint groups, and the twin takes at most 12.").waitFor();
  assert.equal(await page.locator("#inside canvas").count(), 0);
  const views = await page.locator("[data-view]").evaluateAll((tabs) => tabs.map(({ dataset }) => dataset.view));
  for (const view of views.filter((name) => name !== "inside")) {
    await page.locator(`[data-view="${view}"]`).click();
    await settled(page);
    assert.ok((await page.locator(`#${view}`).innerText()).length > 10, view);
  }
  await close();
});

test("hinges stand below the joints, bend with the water, and nothing is asked of them", async () => {
  const { page, close } = await inside("supple");
  await live(page, 1.2);
  const rows = await page.evaluate(() =>
    [...document.querySelectorAll("#inside table.joints tr")]
      .slice(1)
      .map((row) => [...row.children].map((cell) => cell.textContent)),
  );
  assert.deepEqual(
    rows.map(([name]) => name),
    ["J1", "hinge of fin 1", "hinge of fin 2", "hinge of fin 3"],
  );
  for (const [name, bend, asked] of rows.slice(1)) {
    assert.ok(Math.abs(Number(bend.replace("\u2212", "-"))) > 0, `${name} is straight: ${bend}`);
    assert.equal(asked, "–");
  }
  await close();
});
