// Pages that the studio stands in, in a frame that may be as high as what is in it: they come to rest, and are seen whole.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { chrome, FEW, PAGE, picture, settled, temporary } from "./browser.mjs";

const WIDTHS = FEW ? [390, 1440] : [390, 900, 1440];
const HYPERTUNA = process.env.HYPERTUNA ?? "hypertuna";
const PYTHON = process.env.PYTHON ?? "python";
const folder = temporary("frames-");
const read = (file) => readFileSync(new URL(`../../docs/${file}`, import.meta.url), "utf8");

// The docs' front page, as far as it frames the studio; a notebook's cell; another's page as high as what it frames.
const PAGES = {
  "docs.html": () => {
    const [, block] = /```\{raw\} html\n(.*?)```/s.exec(read("index.md"));
    return `<style>${read("_static/site.css")}</style><body data-theme="auto"><p>front</p>${block}<p>below</p></body>`;
  },
  "notebook.html": () =>
    execFileSync(PYTHON, ["-c", 'import hypertuna as ht; print(ht.studio("hypertuna", height=500)._repr_html_())'], {
      encoding: "utf8",
      maxBuffer: 2 ** 26,
    }),
  "other.html": () => `<iframe style="width: 100%; border: 0" src="studio.html"></iframe><p>below</p><script>
document.querySelector("iframe").addEventListener("load", ({ target }) => {
  const { documentElement: page } = target.contentDocument;
  setInterval(() => { target.style.height = page.scrollHeight + "px"; }, 50);
});
</script>`,
};

let server;
let at;
before(async () => {
  copyFileSync(PAGE, join(folder, "studio.html"));
  for (const [name, page] of Object.entries(PAGES)) writeFileSync(join(folder, name), `<!doctype html>${page()}`);
  execFileSync(HYPERTUNA, ["paper", "-o", join(folder, "demo")], { stdio: "ignore" });
  // served, since pages of files may not look into a frame
  server = createServer((request, answer) => {
    const name = request.url.slice(1);
    if (name !== "studio.html" && !(name in PAGES)) return answer.writeHead(404).end();
    answer.setHeader("Content-Type", "text/html; charset=utf-8");
    answer.end(readFileSync(join(folder, name)));
  });
  await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
  at = `http://127.0.0.1:${server.address().port}`;
});
after(async () => {
  server.close();
});

/** Open a page of the folder, with its frame's fish. */
async function opened(name, width, height = 900) {
  const page = await chrome.newPage({ viewport: { width, height } });
  page.setDefaultTimeout(60_000);
  await page.goto(name.startsWith("demo") ? `file://${folder}/${name}` : `${at}/${name}`);
  const frame = await (await page.waitForSelector("iframe")).contentFrame();
  await settled(frame);
  return { page, frame };
}

const heightOf = (page) => page.evaluate(() => document.documentElement.scrollHeight);

for (const name of ["demo/index.html", ...Object.keys(PAGES)])
  for (const width of WIDTHS)
    test(`${name}, ${width} px wide: it is as high after 5 s as after 1 s`, async (context) => {
      const { page, frame } = await opened(name, width);
      await page.waitForTimeout(1000);
      const first = await heightOf(page);
      await page.waitForTimeout(4000);
      assert.equal(await heightOf(page), first);
      context.diagnostic(`${first} px`);
      const { wide, high } = await frame.evaluate(() => {
        const { scrollWidth, scrollHeight } = document.documentElement;
        return { wide: scrollWidth - innerWidth, high: scrollHeight - innerHeight };
      });
      assert.ok(wide <= 0, `${wide} px beyond the frame`);
      if (name !== "notebook.html") assert.ok(high <= 0, `${high} px below the frame's end`);
      await page.close();
    });

for (const width of WIDTHS)
  test(`no view in a frame ${width} px wide depends on the frame's height`, async () => {
    const { page, frame } = await opened("notebook.html", width);
    await frame.evaluate(() => document.querySelector('[data-tempo="0"]').click());
    const views = await frame.locator("[data-view]").evaluateAll((tabs) => tabs.map(({ dataset }) => dataset.view));
    for (const view of views) {
      await frame.locator(`[data-view="${view}"]`).click();
      await settled(frame);
      const heights = [];
      for (const high of [300, 900, 4000]) {
        await page.locator("iframe").evaluate((one, high) => {
          one.style.height = `${high}px`;
        }, high);
        await page.waitForTimeout(500);
        await settled(frame);
        heights.push(await frame.evaluate(() => document.body.offsetHeight));
      }
      assert.deepEqual(new Set(heights).size, 1, `${view}: ${heights}`);
    }
    await page.close();
  });

for (const width of WIDTHS)
  test(`the demo page, ${width} px wide, is read to its end, and every picture is seen`, async (context) => {
    const { page } = await opened("demo/index.html", width);
    await page.mouse.move(width / 2, 450); // a frame under the pointer must not keep the wheel
    for (let [before, now] = [-1, 0]; before !== now; ) {
      before = now;
      await page.mouse.wheel(0, 800);
      for (let k = 0; k < 40 && now === before; k++) {
        await page.waitForTimeout(25);
        now = await page.evaluate(() => scrollY);
      }
    }
    const foot = await page.locator("footer").boundingBox();
    assert.ok(foot.y >= 0 && foot.y + foot.height <= 901, `the footer is at ${foot.y} px of the window`);
    const pictures = await page.locator("figure svg, img, iframe").all();
    for (const one of pictures) {
      await one.scrollIntoViewIfNeeded();
      const seen = await one.evaluate((element) => {
        const { left, top, width, height } = element.getBoundingClientRect();
        const middle = document.elementFromPoint(
          left + width / 2,
          Math.min(innerHeight - 1, Math.max(0, top + height / 2)),
        );
        const drawn = element.tagName === "svg" ? element.getBBox().width * element.getBBox().height : width * height;
        const loaded = element.tagName !== "IMG" || (element.complete && element.naturalWidth > 0);
        const whole = left >= 0 && left + width <= document.documentElement.clientWidth + 1;
        const visible = element.checkVisibility({ opacityProperty: true, visibilityProperty: true });
        const there = element.contains(middle) || element.parentElement.contains(middle);
        return { size: Math.min(width, height), drawn, loaded, whole, visible, there };
      });
      const name = await one.evaluate((element) => element.closest("[id]")?.id ?? element.tagName);
      assert.ok(seen.size > 20 && seen.drawn > 0, `${name}: ${JSON.stringify(seen)}`);
      assert.ok(seen.loaded && seen.whole && seen.visible && seen.there, `${name}: ${JSON.stringify(seen)}`);
    }
    context.diagnostic(`${pictures.length} pictures`);
    assert.ok(pictures.length > 20, `${pictures.length} pictures`);
    await picture(page, `demo-${width}`);
    await page.close();
  });
