// What the tests share: a browser, the page opened from its file, and what one does and reads on it.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after } from "node:test";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
export const PAGE = process.env.STUDIO_PAGE ?? `${ROOT}data/studio/studio.html`;
export const SHOTS = `${ROOT}build/studio/shots`;
export const SIZES = {
  wide: { width: 1440, height: 1000 },
  tablet: { width: 1024, height: 800 },
  phone: { width: 390, height: 844 },
};
/** With STUDIO_FEW=1 (`.ci/run`, but for `whole`), looks are tested at fewer sizes. */
export const FEW = process.env.STUDIO_FEW === "1";
const ALL_LOOKS = Object.entries(SIZES).flatMap(([size, viewport]) =>
  ["light", "dark"].map((colorScheme) => ({ size, viewport, colorScheme })),
);
export const LOOKS = FEW
  ? ALL_LOOKS.filter(({ size, colorScheme }) => ["wide light", "phone dark"].includes(`${size} ${colorScheme}`))
  : ALL_LOOKS;
const PATIENCE = 60_000; // ms: a busy machine of a tenth of the speed passes

/** The browser of the machine. */
export const chrome = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"],
});
after(() => chrome.close());

/** Make a folder that goes when the tests of a file have ended. */
export function temporary(name) {
  const folder = mkdtempSync(join(tmpdir(), name));
  after(() => rmSync(folder, { recursive: true }));
  return folder;
}

/**
 * Open the page from its file and wait for the first fish.
 * What it says and asks for is in `faults`, messages of the console and requests to anywhere but itself: `close` finds none.
 */
export async function open({ hash = "", file = PAGE, ...options } = {}) {
  const context = await chrome.newContext({ viewport: SIZES.wide, reducedMotion: "reduce", ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  const faults = watch(page);
  await page.goto(`file://${file}${hash}`);
  await settled(page);
  const close = async () => {
    assert.deepEqual(faults, []);
    await context.close();
  };
  return { page, faults, close };
}

/** Note what a page must not do. */
export function watch(page) {
  const faults = [];
  page.on("console", (message) => {
    if (message.text().includes("GPU stall due to ReadPixels")) return; // of pictures that are drawn without a GPU
    if (["error", "warning"].includes(message.type())) faults.push(`console: ${message.text()}`);
  });
  page.on("pageerror", (error) => faults.push(`error: ${error.stack}`));
  page.on("request", (request) => {
    const { protocol } = new URL(request.url());
    if (!["file:", "blob:", "data:"].includes(protocol)) faults.push(`request: ${request.url()}`);
  });
  return faults;
}

/** Wait until a fish is shown and no answer is outstanding. */
export async function settled(page) {
  await page.waitForSelector('html[data-ready="1"][data-busy="0"]', { state: "attached" });
}

/** Wait until an element of the page says what a pattern matches. */
export function says(page, element, { source }, timeout = PATIENCE) {
  const match = ([element, source]) => new RegExp(source).test(document.querySelector(element)?.textContent);
  return page.waitForFunction(match, [element, source], { timeout });
}

/** Wait until the twin inside has run for some seconds of its own time. */
export function lived(page, seconds) {
  const reached = (seconds) => parseFloat(document.querySelector("#inside .facts dt")?.textContent) >= seconds;
  return page.waitForFunction(reached, seconds, { timeout: 2 * PATIENCE });
}

/** Wait until the page has drawn what it was told before, however long its frames take. */
export async function redrawn(page) {
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** Turn a knob to a value in its unit, or to its "min" or "max". */
export async function turn(page, knob, value) {
  await page.locator(`[data-knob="${knob}"]`).evaluate((input, to) => {
    for (let room = input.closest("details"); room; room = room.parentElement.closest("details")) room.open = true;
    input.value = to === "min" || to === "max" ? input[to] : String(to);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }, value);
  await settled(page);
}

/** Names of all knobs. */
export function knobs(page) {
  return page.locator("[data-knob]").evaluateAll((inputs) => inputs.map((input) => input.dataset.knob));
}

/** Values of all knobs, in their units. */
export function setting(page) {
  return page
    .locator("[data-knob]")
    .evaluateAll((inputs) => Object.fromEntries(inputs.map((input) => [input.dataset.knob, Number(input.value)])));
}

/** The page's numbers in SI units by name, and its status. */
export async function numbers(page) {
  await settled(page);
  return page.evaluate(() => {
    const shown = [...document.querySelectorAll("[data-quantity]")];
    const values = shown.map(({ dataset }) => [dataset.quantity, Number(dataset.value)]);
    return { ...Object.fromEntries(values), status: document.querySelector("[data-status]").dataset.status };
  });
}

/** What the address of the page holds, which it writes a moment after the last change. */
export async function link(page) {
  await settled(page);
  await page.waitForTimeout(1000);
  return page.evaluate(() => location.hash);
}

/** Choose an option of a list of the page. */
export async function choose(page, list, value) {
  await page.locator(list).selectOption(value);
  await settled(page);
}

/** The sentence of an error, "" where there is none. */
export function told(page) {
  return page.locator('[role="alert"]').evaluate((box) => (box.hidden ? "" : box.textContent.trim()));
}

/** Keep a picture of the page for eyes. */
export async function picture(page, name) {
  mkdirSync(SHOTS, { recursive: true });
  await page.screenshot({ path: `${SHOTS}/${name}.png`, fullPage: true });
}

/** From now on, note the texts that are in the last drawing of a canvas. */
export function watchTexts(page, canvas) {
  return page.evaluate((canvas) => {
    const { prototype } = CanvasRenderingContext2D;
    const { fillText, setTransform } = prototype;
    globalThis.written = [];
    prototype.setTransform = function (...numbers) {
      if (this.canvas.matches(canvas)) globalThis.written = []; // a drawing begins
      return setTransform.apply(this, numbers);
    };
    prototype.fillText = function (text, x, y) {
      const { width } = this.measureText(text);
      const left = x - { center: 0.5, right: 1 }[this.textAlign] * width || x;
      const upright = this.getTransform().b === 0;
      if (this.canvas.matches(canvas) && upright) globalThis.written.push({ text, left, right: left + width, y });
      return fillText.call(this, text, x, y);
    };
  }, canvas);
}

/** Texts in the last drawing of a canvas that meet others or its edge; fewer texts than `least` are a fault, too. */
export function crowded(page, canvas, least) {
  return page.evaluate(
    ([canvas, least]) => {
      const { clientWidth, clientHeight } = document.querySelector(canvas);
      const out = ({ left, right, y }) => left < 0 || right > clientWidth || y < 0 || y > clientHeight;
      const meet = (a, b) => a.left < b.right && b.left < a.right && Math.abs(a.y - b.y) < 12;
      const { written } = globalThis;
      if (written.length < least) return [`${written.length} texts`];
      return written.filter((one, k) => out(one) || written.some((other, i) => i !== k && meet(one, other)));
    },
    [canvas, least],
  );
}

/** Run the program; return its JSON object. */
export function hypertuna(...words) {
  const program = process.env.HYPERTUNA ?? "hypertuna";
  return JSON.parse(execFileSync(program, [...words, "--json"], { encoding: "utf8", maxBuffer: 2 ** 26 }));
}
