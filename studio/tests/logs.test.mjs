// Damaged logs of missions: each is read as far as it is whole, or refused in a sentence; none hangs the reader.
// STUDIO_LOGS is the number of them, STUDIO_LOGS_FOLDER where they are kept with what was told of each.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { Worker } from "node:worker_threads";
import { damagedLogs, readerScript } from "./damage.mjs";

const COUNT = Number(process.env.STUDIO_LOGS ?? 90);
const KEPT = process.env.STUDIO_LOGS_FOLDER;
const CHUNK = 6; // opcode
const LIMIT = 20_000; // ms for one log
const SENTENCE = /^[^\n]+\.$/;
const STRAY = /undefined|NaN|TypeError|RangeError|SyntaxError|\[object|Unexpected|JSON/;

const folder = mkdtempSync(join(tmpdir(), "studio-logs-"));
const log = join(folder, "box.mcap");
let thread;

before(async () => {
  const words = ["mission", "box", "--duration", "12", "-o", log];
  try {
    execFileSync(process.env.HYPERTUNA ?? "hypertuna", words, { stdio: "pipe" });
  } catch (error) {
    assert.equal(error.status, 1); // the mission is given up after this time
  }
  const script = join(folder, "log.mjs");
  await readerScript(fileURLToPath(new URL("../", import.meta.url)), script);
  thread = new Worker(new URL("reading.mjs", import.meta.url), {
    workerData: { script: pathToFileURL(script).href },
    resourceLimits: { maxOldGenerationSizeMb: 512 },
  });
  await heard();
});
after(async () => {
  await thread.terminate();
  rmSync(folder, { recursive: true });
});

/** What the thread says next, within the time that it has. */
function heard() {
  return new Promise((resolve, reject) => {
    const late = setTimeout(() => reject(new Error("the reader hangs")), LIMIT);
    const end = (done) => (value) => {
      clearTimeout(late);
      thread.removeAllListeners("message").removeAllListeners("error");
      done(value);
    };
    thread.once("message", end(resolve));
    thread.once("error", end(reject));
  });
}

async function read(name, bytes) {
  const told = heard();
  thread.postMessage({ name, bytes });
  return told;
}

test("a whole log is read whole", async () => {
  const { rows, finite, sentence } = await read("box.mcap", new Uint8Array(readFileSync(log)));
  assert.equal(sentence, "The log is whole; all checksums are right.");
  assert.ok(rows >= 119 && finite, `${rows}`);
});

/** Places in a log where its chunks end. */
function chunkEnds(content) {
  const ends = [];
  for (let at = 8; at < content.length - 8; ) {
    const end = at + 9 + Number(content.readBigUInt64LE(at + 1));
    if (content[at] === CHUNK) ends.push(end);
    at = end;
  }
  return ends;
}

test("a log that is cut where a chunk ends is read up to there", async () => {
  const content = readFileSync(log);
  const ends = chunkEnds(content);
  assert.ok(ends.length >= 4, `${ends}`);
  for (const [k, end] of ends.entries())
    for (const [cut, chunks] of [
      [end, k + 1],
      [end - 1, k],
    ]) {
      const { sentence } = await read("cut.mcap", new Uint8Array(content.subarray(0, cut)));
      const told = chunks === 0 ? /^cut\.mcap: .* cut short/ : new RegExp(`cut short: ${chunks} whole chunks are read`);
      assert.match(sentence, told, `cut at ${cut}`);
    }
});

test(`${COUNT} damaged logs are read as far as they are whole, or refused in a sentence`, async (context) => {
  const content = readFileSync(log);
  const told = [];
  const counts = { whole: 0, part: 0, refused: 0 };
  let longest = 0;
  for await (const { name, bytes } of damagedLogs(content, COUNT, 1)) {
    if (KEPT !== undefined) writeFileSync(join(KEPT, name), bytes);
    const begin = performance.now();
    const answer = await read(name, bytes).catch((error) => assert.fail(`${name}: ${error.message}`));
    longest = Math.max(longest, performance.now() - begin);
    told.push(answer);
    assert.match(answer.sentence, SENTENCE, name);
    assert.doesNotMatch(answer.sentence, STRAY, name);
    assert.ok(answer.finite, `${name}: numbers that are none`);
    if (answer.rows === 0) assert.ok(answer.sentence.startsWith(name), answer.sentence);
    counts[answer.rows === 0 ? "refused" : answer.sentence.includes("whole;") ? "whole" : "part"]++;
  }
  context.diagnostic(`${JSON.stringify(counts)}, longest ${longest.toFixed(0)} ms`);
  assert.ok(Math.min(...Object.values(counts)) > 0.05 * COUNT, JSON.stringify(counts));
  if (KEPT !== undefined) writeFileSync(join(KEPT, "told.json"), JSON.stringify(told));
});
