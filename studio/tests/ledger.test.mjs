// Published gaits: the ledger's stored verdicts in words, none of the page's own, and links to the ledger's rows.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { open, PAGE, temporary, watch } from "./browser.mjs";

const STORED = JSON.parse(readFileSync(new URL("../../data/published/verdicts.json", import.meta.url), "utf8"));
const WORDS = {
  ...Object.fromEntries(Object.keys(STORED.marks).map((name) => [name, name])),
  "not-computed": "not computed",
};
const OWN = "joint bandwidth"; // the ledger's name of the robot's own model

const folder = temporary("ledger-");

/** Open the page at the published gaits. */
async function published(options = {}) {
  const studio = await open({ hash: "#robot=hypertuna&view=paper", ...options });
  await studio.page.locator("#paper .card").first().waitFor();
  return studio;
}

/** The verdict and the text of a gait's first comparison. */
async function judged(page, gait) {
  const card = page.locator("#paper .card").filter({ has: page.getByRole("heading", { name: gait, exact: true }) });
  const box = card.locator(".compared").first();
  const first = box.locator(".verdict").first();
  return { box, verdict: await first.getAttribute("data-verdict"), text: (await first.textContent()).trim() };
}

test("each gait has the ledger's stored verdict, with a mark and a word", async () => {
  const { page, close } = await published();
  let seen = 0;
  for (const { id, model, verdict } of STORED.entries) {
    const gait = /^speed\/(.*-(?:0\.\d|max))$/.exec(id)?.[1];
    if (gait === undefined || gait.includes("change") || gait.includes("error") || model !== OWN) continue;
    const found = await judged(page, gait);
    assert.equal(found.verdict, verdict, gait);
    assert.ok(found.text.startsWith(`${STORED.marks[verdict]}${WORDS[verdict]}`), found.text);
    assert.match(await found.box.textContent(), new RegExp(`${id} in the ledger`));
    seen++;
  }
  assert.equal(seen, 8);
  const open = ({ id, model, verdict }) => verdict === "undetermined" && model === "twin" && /^speed.*\d$/.test(id);
  const { id, computed, seeds } = STORED.entries.find(open);
  const { box } = await judged(page, id.replace("speed/", ""));
  await box.locator("summary").click();
  const said = `undetermined in the model “twin”: ${computed.toPrecision(3)} m/s, ${seeds.join(" of ")} seeds agree`;
  assert.ok((await box.textContent()).includes(said), said);
  assert.match(await page.locator("#paper").textContent(), /hypertuna paper -o demo/);
  assert.equal(await page.locator("#paper a").count(), 0); // nothing to link to
  await close();
});

test("a model that the ledger has not, and a changed robot, have no verdict", async () => {
  const { page, close } = await published();
  await page.locator('[data-joints="ideal"]').click();
  await page.waitForFunction(() => /ideal joints\./.test(document.querySelector("#paper .intro").textContent));
  assert.equal((await judged(page, "unoptimised-max")).verdict, "deviates"); // ideal joints are a model of the ledger
  await page.locator('[data-water="strip"]').click();
  await page.waitForFunction(() => /strip water/.test(document.querySelector("#paper .intro").textContent));
  assert.equal((await judged(page, "unoptimised-max")).verdict, "none");
  assert.match((await judged(page, "unoptimised-max")).text, /no verdict on this model/);
  await close();

  const heavier = join(folder, "heavier.html");
  const robot = readFileSync(new URL("../../robots/hypertuna.toml", import.meta.url), "utf8");
  writeFileSync(join(folder, "heavier.toml"), robot.replace("mass_kg = 3.3", "mass_kg = 3.5"));
  execFileSync(process.env.HYPERTUNA ?? "hypertuna", ["studio", join(folder, "heavier.toml"), "-o", heavier]);
  const other = await published({ file: heavier });
  const { verdict, text } = await judged(other.page, "unoptimised-max");
  assert.equal(verdict, "none");
  assert.match(text, /no verdict: the ledger has none of this robot as it is here/);
  await other.close();
});

test("inside the ledger's page a verdict leads to the row of its number", async () => {
  const { page: context } = await open();
  const studio = readFileSync(PAGE, "utf8").replace('"start":{}', '"start":{"ledger":""}');
  assert.match(studio, /"ledger":""/);
  const quoted = studio.replaceAll("&", "&amp;").replaceAll('"', "&quot;");
  const rows =
    '<details><summary>speed</summary><p id="number-speed-unoptimised-max">speed/unoptimised-max</p></details>';
  const host = join(folder, "host.html");
  writeFileSync(host, `<!doctype html><iframe style="width:100%;height:900px" srcdoc="${quoted}"></iframe>${rows}`);
  const page = await context.context().newPage();
  const faults = watch(page);
  await page.goto(`file://${host}`);
  const frame = page.frameLocator("iframe");
  await frame.locator("#tab-paper").click();
  await frame.getByRole("link", { name: "speed/unoptimised-max in the ledger" }).click();
  await page.waitForURL(/host\.html#number-speed-unoptimised-max$/);
  assert.ok(await page.locator("#number-speed-unoptimised-max").isVisible()); // unfolded
  assert.deepEqual(faults, []);
  await context.context().close();
});
