// The page in a frame of another: the docs' front page says light or dark, by its own button.
import assert from "node:assert/strict";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { before, test } from "node:test";
import { chrome, PAGE, settled, temporary, watch } from "./browser.mjs";

const folder = temporary("frame-");
before(async () => {
  const front = readFileSync(new URL("../../docs/index.md", import.meta.url), "utf8");
  const [, block] = /```\{raw\} html\n(.*?)```/s.exec(front); // what stands on the docs' front page
  const button = '<button onclick="document.body.dataset.theme = this.value">';
  writeFileSync(join(folder, "index.html"), `<!doctype html><body data-theme="auto">${button}</button>${block}</body>`);
  copyFileSync(PAGE, join(folder, "studio.html"));
});

test("the button of the docs turns the studio light and dark", async () => {
  const context = await chrome.newContext({ colorScheme: "dark", reducedMotion: "reduce" });
  const page = await context.newPage();
  const faults = watch(page);
  await page.goto(`file://${folder}/index.html`);
  const frame = page.frame({ url: /studio\.html/ });
  await settled(frame);
  const shows = (theme) => frame.waitForFunction((theme) => document.documentElement.dataset.theme === theme, theme);
  const says = (theme) =>
    page.evaluate((theme) => {
      document.body.dataset.theme = theme;
    }, theme);
  await shows("dark"); // as the system has it
  await says("light");
  await shows("light");
  await page.emulateMedia({ colorScheme: "light" });
  await says("dark");
  await shows("dark");
  await says("auto");
  await shows("light");
  await page.emulateMedia({ colorScheme: "dark" });
  await shows("dark");
  assert.deepEqual(faults, []);
  await context.close();
});

test("a page that the studio does not stand in changes nothing", async () => {
  const context = await chrome.newContext({ colorScheme: "light" });
  const page = await context.newPage();
  await page.goto(`file://${folder}/studio.html`);
  await settled(page);
  await page.evaluate(() => postMessage({ theme: "dark" }, "*"));
  await page.waitForTimeout(200);
  assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "light");
  await context.close();
});
