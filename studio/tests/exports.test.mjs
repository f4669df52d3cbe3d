// Pictures, charts and videos that the page saves: complete files that others can open.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, statSync } from "node:fs";
import { before, test } from "node:test";
import { chrome, open, PAGE, settled, SHOTS, told } from "./browser.mjs";

before(async () => {
  mkdirSync(SHOTS, { recursive: true });
});

/** Click in the File menu, which closes then. */
async function choose(page, kind) {
  await page.locator(".menu summary").click();
  await page.locator(`[data-save="${kind}"]`).click();
  assert.equal(await page.locator(".menu[open]").count(), 0);
}

/** Click in the File menu; return where the saved file lies. */
async function saved(page, kind) {
  const [download] = await Promise.all([page.waitForEvent("download"), choose(page, kind)]);
  const file = `${SHOTS}/${download.suggestedFilename()}`;
  await download.saveAs(file);
  return file;
}

/** Read a drawing as XML: faults, and how many of each element a named group holds. */
function drawing(page, text) {
  return page.evaluate((text) => {
    const read = new DOMParser().parseFromString(text, "image/svg+xml");
    const groups = [...read.querySelectorAll("g[id]")].map((group) => [group.id, group.querySelectorAll("*").length]);
    const numbers = [...read.querySelectorAll("[d]")].map((path) => path.getAttribute("d")).join(" ");
    return {
      fault: read.querySelector("parsererror")?.textContent ?? "",
      title: read.querySelector("title")?.textContent,
      groups: Object.fromEntries(groups),
      paths: read.querySelectorAll("path").length,
      texts: [...read.querySelectorAll("text")].map((one) => one.textContent),
      images: read.querySelectorAll('image[href^="data:image/png;base64,"]').length,
      clean: !/NaN|undefined|Infinity|rgba|#[0-9a-f]{8}"/.test(text) && numbers.length > 0,
    };
  }, text);
}

test("the picture is saved as SVG: fish, path, midlines and scale in named groups", async () => {
  const { page, close } = await open({ hash: "#robot=hypertuna&tempo=1" });
  await page.waitForFunction(() => document.querySelector("#stage") !== null);
  await page.waitForTimeout(1500); // a tail's path
  await page.locator("#midlines").check();
  const text = readFileSync(await saved(page, "svg"), "utf8");
  const read = await drawing(page, text);
  assert.equal(read.fault, "");
  assert.match(read.title, /^hypertuna, 6 Hz, amplitude 16, 25 deg, phase 0, 40 deg: 0\.5775 m\/s$/);
  assert.ok(read.clean, "a number or a color that readers of SVG do not know");
  assert.equal(read.groups.midlines, 12);
  assert.ok(read.groups.path > 5 && read.groups.fish > 20 && read.groups.water > 50, JSON.stringify(read.groups));
  assert.deepEqual(read.texts, ["100 mm"]);
  await page.locator("#path").uncheck();
  assert.equal((await drawing(page, readFileSync(await saved(page, "svg"), "utf8"))).groups.path, 0); // as shown
  await close();
});

test("from above the upright tail fin is a line, the level fins are seen whole", async () => {
  const { page, close } = await open({
    hash: "#robot=hypertuna&frequency=2&amplitude=0.1,0.1&phase=0,0&tempo=0",
  });
  const svg = readFileSync(await saved(page, "svg"), "utf8");
  const fins = await page.evaluate((svg) => {
    const drawn = new DOMParser().parseFromString(svg, "image/svg+xml").documentElement;
    document.body.append(drawn);
    const shape = (path) => {
      const { x, width, height } = path.getBBox();
      return { front: x, end: x + width, wide: width, high: height };
    };
    const all = [...drawn.querySelectorAll("#fish path")];
    const color = getComputedStyle(document.documentElement).getPropertyValue("--fin").trim();
    const length = Math.max(...all.map((path) => shape(path).wide));
    const fins = all.filter((path) => path.getAttribute("fill") === color).map(shape);
    const end = Math.max(...all.map((path) => shape(path).end));
    return fins.map(({ end: own, high, wide }) => ({ behind: (end - own) / length, high: high / length, wide }));
  }, svg);
  assert.equal(fins.length, 4, JSON.stringify(fins)); // dorsal, caudal, two pectoral
  const tail = fins.filter(({ behind }) => behind < 0.1);
  assert.equal(tail.length, 1);
  assert.ok(tail[0].high < 0.02 && tail[0].wide > 0, JSON.stringify(tail));
  assert.equal(fins.filter(({ high }) => high > 0.08).length, 2);
  await close();
});

test("an SVG shows what the canvas shows", async () => {
  const { page, close } = await open({ hash: "#robot=hypertuna&tempo=0" });
  const svg = readFileSync(await saved(page, "svg"), "utf8");
  const far = await page.evaluate(async (svg) => {
    const stage = document.querySelector("#stage");
    const pixels = (source) => {
      const copy = document.createElement("canvas");
      [copy.width, copy.height] = [stage.width, stage.height];
      const pen = copy.getContext("2d");
      pen.drawImage(source, 0, 0);
      return pen.getImageData(0, 0, copy.width, copy.height).data;
    };
    const image = new Image();
    image.src = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
    await image.decode();
    const [drawn, written] = [pixels(stage), pixels(image)];
    let differing = 0;
    for (let k = 0; k < drawn.length; k++) if (Math.abs(drawn[k] - written[k]) > 32) differing++;
    return differing / drawn.length;
  }, svg);
  assert.ok(far < 0.005, `${(100 * far).toFixed(2)} % of the pixels differ`);
  await close();
});

test("charts are saved as SVG, a map with its colors as a picture in it", async () => {
  const { page, close } = await open({ hash: "#robot=hypertuna&view=map" });
  await page.waitForTimeout(1500);
  const map = await drawing(page, readFileSync(await saved(page, "chart"), "utf8"));
  assert.equal(map.fault, "");
  assert.equal(map.images, 1);
  assert.ok(map.clean);
  assert.ok(map.texts.includes("frequency [Hz]"), map.texts.join("|"));
  await page.locator("#tab-front").click();
  await settled(page);
  const front = await drawing(page, readFileSync(await saved(page, "chart"), "utf8"));
  assert.equal(front.fault, "");
  assert.ok(front.clean);
  assert.ok(front.texts.includes("cost of transport [J/(kg m)]"), front.texts.join("|"));
  assert.ok(front.paths > 20);
  await page.locator("#tab-paper").click();
  await choose(page, "chart");
  assert.match(await told(page), /has no chart to save/);
  await close();
});

test("a video of two beats and 3 s at least, which plays", async (context) => {
  const { page, close } = await open({ hash: "#robot=hypertuna&tempo=1" });
  const began = performance.now();
  const file = await saved(page, "video");
  const seconds = (performance.now() - began) / 1000;
  assert.ok(file.endsWith("hypertuna.webm"), file);
  const bytes = readFileSync(file);
  assert.equal(bytes.subarray(0, 4).toString("hex"), "1a45dfa3"); // of Matroska
  const played = await page.evaluate(async (content) => {
    const video = document.createElement("video");
    video.muted = true;
    video.src = `data:video/webm;base64,${content}`;
    await new Promise((resolve, reject) => {
      video.onloadeddata = resolve;
      video.onerror = () => reject(new Error(video.error.message));
    });
    const end = new Promise((resolve) => {
      video.onended = resolve;
    });
    video.playbackRate = 4;
    await video.play();
    await end;
    return {
      length: video.currentTime,
      wide: video.videoWidth,
      frames: video.getVideoPlaybackQuality().totalVideoFrames,
    };
  }, bytes.toString("base64"));
  context.diagnostic(`${statSync(file).size} bytes, ${played.length.toFixed(2)} s, made in ${seconds.toFixed(1)} s`);
  assert.ok(played.length >= 3 && played.length < 4, JSON.stringify(played));
  assert.ok(played.frames > 5, JSON.stringify(played));
  assert.equal(played.wide, await page.locator("#stage").evaluate((stage) => stage.width));
  assert.equal(await page.locator('[data-save="video"]').textContent(), "Save two beats (video)");
  await close();
});

test("a browser that records nothing says so", async () => {
  const context = await chrome.newContext();
  await context.addInitScript(() => {
    delete globalThis.MediaRecorder;
  });
  const page = await context.newPage();
  await page.goto(`file://${PAGE}`);
  await settled(page);
  const button = page.locator('[data-save="video"]');
  assert.equal(await button.textContent(), "This browser records no video");
  assert.ok(await button.isDisabled());
  await context.close();
});
