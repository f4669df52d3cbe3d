// Calls into the core in WebAssembly for a program at the other end of the pipe, a line of JSON each:
// node serve_core.mjs CORE.wasm. Arguments are numbers or base64 of memory, which comes back as the call left it.
import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";

const wasi = new Proxy({}, { get: () => () => 0 });
const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]), { wasi_snapshot_preview1: wasi });
const core = instance.exports;
core._initialize();
const bytes = (at, size) => Buffer.from(core.memory.buffer, at, size);

function call(name, given) {
  const taken = given.map((value) => {
    if (typeof value === "number") return { value };
    const from = Buffer.from(value, "base64"), at = core.malloc(from.length + 1);
    bytes(at, from.length).set(from);
    return { value: at, size: from.length };
  });
  const result = core[name](...taken.map(({ value }) => value)) ?? 0;
  const memory = taken.map(({ value, size }) => (size === undefined ? null : bytes(value, size).toString("base64")));
  for (const { value, size } of taken) if (size !== undefined) core.free(value);
  return { result, memory };
}

const read = (at, size) => bytes(at, size ?? new Uint8Array(core.memory.buffer).indexOf(0, at) - at).toString("base64");
const work = { call, read: (at, size) => ({ memory: read(at, size ?? undefined) }) };
for await (const line of createInterface({ input: process.stdin })) {
  const { ask, with: given } = JSON.parse(line);
  process.stdout.write(`${JSON.stringify(work[ask](...given))}\n`);
}
