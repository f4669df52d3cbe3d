// The Sea view: missions that are flown and logs that are dropped, in space or, without WebGL, from above.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { before, test } from "node:test";
import { McapWriter } from "@mcap/core";
import { crowded, link, LOOKS, open, picture, redrawn, temporary, watchTexts } from "./browser.mjs";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const HYPERTUNA = process.env.HYPERTUNA ?? "hypertuna";
const FLOWN = 40; // s of the log

const folder = temporary("studio-sea-");
const log = join(folder, "box.mcap");

before(async () => {
  // the mission is given up after this time: exit code 1
  spawnSync(HYPERTUNA, ["mission", "box", "--duration", String(FLOWN), "-o", log]);
});

/** Open the page at the Sea view; `flat` takes WebGL away. */
async function sea({ flat = false, robot = "hypertuna", ...options } = {}) {
  const opened = await open({ hash: `#robot=${robot}`, ...options });
  if (flat) {
    await opened.page.evaluate(() => {
      const { getContext } = HTMLCanvasElement.prototype;
      HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
        return kind.startsWith("webgl") ? null : getContext.call(this, kind, ...more);
      };
    });
  }
  await opened.page.locator('[data-view="sea"]').click();
  return opened;
}

/** Wait until some seconds of the flight are there. */
async function flown(page, seconds) {
  await page.waitForFunction(
    (seconds) => Number(document.querySelector('#sea input[type="range"]')?.max) >= seconds,
    seconds,
    { timeout: 120_000 },
  );
}

/** Labels of the picture that stand over others or beyond its edge; one of those that must be seen, where it is not. */
function covered(page, must) {
  return page.locator("#sea .sea-space").evaluate((room, must) => {
    const shown = [...room.querySelectorAll(".sea-label, .sea-north, .sea-bar")].filter(
      (one) => !one.hidden && one.style.visibility !== "hidden",
    );
    const boxes = shown.map((one) => one.getBoundingClientRect());
    const edge = room.getBoundingClientRect();
    const beyond = (a) => a.left < edge.left || a.right > edge.right || a.top < edge.top || a.bottom > edge.bottom;
    const meet = (a, b) =>
      a.left < b.right - 0.5 && b.left < a.right - 0.5 && a.top < b.bottom - 0.5 && b.top < a.bottom - 0.5;
    const bad = shown.filter((_, k) => beyond(boxes[k]) || boxes.some((box, i) => i !== k && meet(box, boxes[k])));
    const names = shown.map(({ textContent }) => textContent);
    return [...bad.map(({ textContent }) => textContent), ...must.filter((name) => !names.includes(name))];
  }, must);
}

/** Go to a time of the flight. */
async function scrub(page, seconds) {
  await page.locator('#sea input[type="range"]').evaluate((slider, to) => {
    slider.value = String(to);
    slider.dispatchEvent(new Event("input"));
  }, seconds);
  await redrawn(page);
}

/** Seconds of the flight that pass while it plays at 5 x for 2 s, and those due: of a late frame 0.1 s count. */
function played(page) {
  return page.locator('#sea input[type="range"]').evaluate(async (slider) => {
    const frame = () => new Promise(requestAnimationFrame);
    const start = await frame();
    const begin = slider.valueAsNumber;
    let [before, due] = [start, 0];
    while (before - start < 2000) {
      const now = await frame();
      due += 5 * Math.min(0.1, (now - before) / 1000);
      before = now;
    }
    return { passed: slider.valueAsNumber - begin, due };
  });
}

/** Drop a file on the page. */
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

async function dropped(page, name, bytes) {
  await drop(page, name, bytes);
  await page.waitForFunction(
    (name) => document.querySelector("#sea .sea-note")?.textContent.startsWith(`${name}: `),
    name,
  );
  return page.locator("#sea .sea-note").textContent();
}

const tiles = (page) => page.locator("#sea .sea-facts > div").evaluateAll((all) => all.map((one) => one.textContent));
const look = (page) => page.locator("#sea .sea-space").screenshot();

test("the block of the view is unpacked when it is first opened", async (context) => {
  const { page, close } = await open({ hash: "#robot=hypertuna" });
  assert.equal(await page.evaluate(() => "SeaRoom" in globalThis), false);
  const begin = performance.now();
  await page.locator('[data-view="sea"]').click();
  await page.locator("#sea .sea-canvas").waitFor();
  context.diagnostic(`open after ${(performance.now() - begin).toFixed(0)} ms`);
  assert.equal(await page.evaluate(() => "SeaRoom" in globalThis), true);
  await close();
});

test("a mission that is flown in the page is the one that the program's log has", async () => {
  const { page, close } = await sea();
  await flown(page, FLOWN - 1);
  const moments = [5, 20.5, FLOWN - 2];
  const live = [];
  for (const time of moments) {
    await scrub(page, time);
    live.push(await tiles(page));
  }
  assert.notDeepEqual(live[0], live[1]);
  await dropped(page, "box.mcap", readFileSync(log));
  for (const [k, time] of moments.entries()) {
    await scrub(page, time);
    assert.deepEqual(await tiles(page), live[k], `at ${time} s`);
  }
  await close();
});

test("a link keeps mission and seed; the log that was open is chosen again", async () => {
  const { page, close } = await sea();
  const missions = page.locator('#sea label:has-text("mission") select');
  await missions.selectOption({ label: "transect" });
  await page.locator('#sea label:has-text("seed") input').fill("2");
  await page.locator('#sea label:has-text("seed") input').press("Enter");
  await page.waitForFunction(() => /^transect: .*seed 2/.test(document.querySelector("#sea .sea-note").textContent));
  const hash = await link(page);
  assert.match(hash, /flight=transect:2/);
  const again = await open({ hash });
  await flown(again.page, 1);
  assert.match(await again.page.locator("#sea .sea-note").textContent(), /^transect: .*seed 2/);
  await again.close();
  await dropped(page, "box.mcap", readFileSync(log));
  await missions.selectOption({ label: "lake" });
  await page.waitForFunction(() => /^lake: /.test(document.querySelector("#sea .sea-note").textContent));
  await missions.selectOption({ label: "box.mcap" });
  await flown(page, FLOWN - 1);
  assert.match(await page.locator("#sea .sea-note").textContent(), /^box\.mcap: The log is whole/);
  await close();
});

test("scrubbing moves the robot; keys turn the picture; the robot is followed", async () => {
  const { page, close } = await sea();
  await dropped(page, "box.mcap", readFileSync(log));
  const pictures = [await look(page)];
  const changes = async (what) => {
    await redrawn(page);
    const now = await look(page);
    assert.ok(!now.equals(pictures.at(-1)), what);
    pictures.push(now);
  };
  await scrub(page, 10);
  await changes("scrubbed");
  await page.getByRole("button", { name: "follow" }).click();
  await changes("followed");
  await scrub(page, 10.2);
  await changes("bent");
  const canvas = page.locator("#sea .sea-canvas");
  for (const key of ["ArrowLeft", "ArrowUp", "Shift+ArrowLeft", "+", "-"]) {
    await canvas.press(key);
    await changes(key);
  }
  await page.getByRole("button", { name: "overview" }).click();
  await changes("overview");
  await scrub(page, FLOWN - 2);
  await changes("scrubbed to the end");
  await page.locator('#sea label:has-text("track by") select').selectOption("depth");
  await changes("by depth");
  await page.locator("#sea [data-depths]").selectOption("10");
  await changes("depths");
  const said = await canvas.getAttribute("aria-label");
  await scrub(page, 4); // in the dip of its first beats
  assert.notEqual(await canvas.getAttribute("aria-label"), said);
  assert.match(said, /hypertuna on the mission box: \w+, .*depth/);
  await close();
});

test("it plays at its tempo, and stands still for those who want less motion", async () => {
  const { page, close } = await sea({ reducedMotion: "no-preference" });
  await dropped(page, "box.mcap", readFileSync(log));
  const { passed, due } = await played(page);
  assert.ok(Math.abs(passed - due) < 0.7, `${passed} s, ${due} s are due`); // the slider's step and a frame
  await page.locator('#sea label:has-text("tempo") select').selectOption("50");
  await page.getByRole("button", { name: "Play" }).waitFor(); // it has come to its end
  await close();
  const still = await sea();
  await dropped(still.page, "box.mcap", readFileSync(log));
  await still.page.waitForTimeout(500);
  assert.ok((await still.page.locator('#sea input[type="range"]').evaluate((slider) => slider.valueAsNumber)) < 0.2);
  await still.close();
});

/** An MCAP file with records of metadata. */
async function mcap(metadata) {
  const parts = [];
  let size = 0n;
  const writable = {
    position: () => size,
    write: async (bytes) => {
      parts.push(bytes.slice());
      size += BigInt(bytes.length);
    },
  };
  const writer = new McapWriter({ writable });
  await writer.start({ profile: "", library: "test" });
  for (const [name, facts] of Object.entries(metadata)) {
    await writer.addMetadata({ name, metadata: new Map(Object.entries(facts)) });
  }
  await writer.end();
  return Buffer.concat(parts);
}

test("logs that are none, cut or damaged are told in the program's sentences, and the flight goes on", async () => {
  const { page, close } = await sea();
  const whole = readFileSync(log);
  const turned = Buffer.from(whole);
  let chunk = 8; // of MCAP: records of an opcode and a length; a chunk's checksum follows its times and size
  while (chunk < whole.length / 2 || whole[chunk] !== 6) chunk += 9 + Number(whole.readBigUInt64LE(chunk + 1));
  turned[chunk + 33] ^= 1;
  const bad = {
    "empty.mcap": Buffer.alloc(0),
    "text.mcap": Buffer.from("a text\n"),
    "start.mcap": whole.subarray(0, 300),
    "foreign.mcap": await mcap({}),
    "radio.mcap": await mcap({ hypertuna: { link: "1" } }),
    "header.mcap": await mcap({ hypertuna: { record: "{}" } }),
  };
  for (const [name, bytes] of Object.entries(bad)) {
    await drop(page, name, bytes);
    const alert = page.locator("#sea .sea-alert");
    await page.waitForFunction((name) => document.querySelector("#sea .sea-alert").textContent.startsWith(name), name);
    const path = join(folder, name);
    writeFileSync(path, bytes);
    const output = ["-o", join(folder, "none.csv")]; // info reads logs of the radio, too
    const { stderr, status } = spawnSync(HYPERTUNA, ["log", "to-csv", path, ...output], { encoding: "utf8" });
    assert.equal(status, 2, stderr);
    const native = stderr.replaceAll(/\s+/g, " ").replace("error: ", "").replaceAll(`${folder}/`, "").trim();
    const plain = (text) => text.replace(/\(.*?\)/, "()"); // of what is damaged each has its own words
    assert.equal(plain(await alert.textContent()), plain(native));
  }
  await flown(page, 1); // the mission before is still there
  assert.match(await dropped(page, "cut.mcap", whole.subarray(0, whole.length >> 1)), /cut short: \d+ whole chunks/);
  assert.equal(await page.locator("#sea .sea-alert").isVisible(), false);
  assert.match(
    await dropped(page, "turned.mcap", turned),
    /damaged \(a checksum is wrong\): \d+ whole chunks are read/,
  );
  assert.match(await dropped(page, "box.mcap", whole), /The log is whole; all checksums are right\./);
  await close();
});

test("without WebGL it says so, and shows the track from above and depth over time", async () => {
  const { page, close } = await sea({ flat: true });
  await page.getByText("draws nothing in space").waitFor();
  await dropped(page, "box.mcap", readFileSync(log));
  await watchTexts(page, ".sea-canvas");
  await scrub(page, 5);
  assert.deepEqual(await crowded(page, ".sea-canvas", 6), []);
  const first = await look(page);
  await scrub(page, FLOWN - 2);
  assert.ok(!(await look(page)).equals(first));
  const colors = await page.locator("#sea .sea-canvas").evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  });
  assert.ok(colors > 50, `${colors} colors`);
  assert.equal(await page.getByRole("button", { name: "follow" }).count(), 0);
  await picture(page, "wide-light-sea-flat");
  await close();
});

test("a robot without a pilot flies no mission, in a sentence; a log is shown all the same", async () => {
  const { page, close } = await sea({ robot: "rexeel" });
  await page.getByText("The file of rexeel has no pilot").waitFor();
  await dropped(page, "box.mcap", readFileSync(log));
  await flown(page, FLOWN - 1);
  await close();
});

for (const { size, viewport, colorScheme } of LOOKS) {
  test(`${size}, ${colorScheme}: nothing is cut off, nobody is shut out`, async () => {
    const { page, close } = await sea({ viewport, colorScheme });
    await dropped(page, "box.mcap", readFileSync(log));
    await scrub(page, 20);
    await page.addScriptTag({ content: AXE });
    for (const sight of ["overview", "follow"]) {
      await page.getByRole("button", { name: sight }).click();
      await page.waitForTimeout(300);
      await picture(page, `${size}-${colorScheme}-sea-${sight}`);
      const must = sight === "overview" ? ["hypertuna", "home", "believed", "1", "2", "3", "4"] : [];
      for (const time of [0, 7, 14, 20, FLOWN - 2]) {
        await scrub(page, time);
        assert.deepEqual(await covered(page, must), [], `${sight}, ${time} s`);
      }
    }
    const { violations } = await page.evaluate(() => globalThis.axe.run("#sea", { resultTypes: ["violations"] }));
    const serious = violations.filter(({ impact }) => ["serious", "critical"].includes(impact));
    assert.deepEqual(
      serious.flatMap(({ id, nodes }) => nodes.map(({ target }) => `${id}: ${target}`)),
      [],
    );
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${wide} px beyond the window`);
    await close();
  });
}
