// Damage logs: bytes, blocks and ends of the file, and with right checksums texts, numbers and order of its messages.
import { McapStreamReader, McapWriter } from "@mcap/core";
import { build } from "esbuild";
import { decompress } from "fzstd";

/** Numbers from 0 to 1 that are the same for a seed: mulberry32. */
export function randomOf(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let h = Math.imul(state ^ (state >>> 15), state | 1);
    h ^= h + Math.imul(h ^ (h >>> 7), h | 61);
    return ((h ^ (h >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** Bundle the reader of logs; returns its script. */
export async function readerScript(folder, outfile) {
  await build({
    absWorkingDir: folder,
    entryPoints: ["sea/log.ts"],
    bundle: true,
    format: "esm",
    target: "es2022",
    outfile,
    logLevel: "error",
  });
}

/** Records of a log: its metadata, channels and messages. */
function recordsOf(content) {
  const handlers = { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) };
  const reader = new McapStreamReader({ decompressHandlers: handlers });
  reader.append(content);
  const [metadata, channels, messages] = [[], new Map(), []];
  for (let record = reader.nextRecord(); record; record = reader.nextRecord()) {
    if (record.type === "Metadata") metadata.push(record);
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type === "Message") messages.push(record);
  }
  return { metadata, channels, messages };
}

/** Write records as a log with right checksums. */
async function written({ metadata, channels, messages }) {
  const parts = [];
  let size = 0n;
  const writable = {
    position: () => size,
    write: async (bytes) => {
      parts.push(bytes.slice());
      size += BigInt(bytes.length);
    },
  };
  const writer = new McapWriter({ writable, chunkSize: 20_000 });
  await writer.start({ profile: "hypertuna", library: "damage" });
  for (const record of metadata.slice(0, 1)) await writer.addMetadata(record);
  const ids = new Map();
  for (const [id, channel] of channels) {
    const { topic, messageEncoding, metadata } = channel;
    ids.set(id, await writer.registerChannel({ topic, messageEncoding, metadata, schemaId: 0 }));
  }
  for (const message of messages) await writer.addMessage({ ...message, channelId: ids.get(message.channelId) });
  for (const record of metadata.slice(1)) await writer.addMetadata(record);
  await writer.end();
  return Buffer.concat(parts);
}

const NASTY = ["null", "-1", "1e999", '"x"', "[]", "{}", "NaN", "1e308", "true", "", "0", "-0", "9007199254740993"];

/** A kind of damage: the content, random numbers, and the log's records. */
const KINDS = {
  async flip(content, random) {
    const spoiled = Buffer.from(content);
    for (let k = 0; k < 1 + random() * 8; k++) spoiled[Math.floor(random() * spoiled.length)] ^= 1 << (random() * 8);
    return spoiled;
  },
  async cut(content, random) {
    return content.subarray(0, Math.floor(random() * content.length));
  },
  async blank(content, random) {
    const spoiled = Buffer.from(content);
    const at = Math.floor(random() * spoiled.length);
    return spoiled.fill(random() < 0.5 ? 0 : 255, at, at + Math.floor(random() * 3000));
  },
  async splice(content, random) {
    const [a, b, c] = [0, 0, 0].map(() => Math.floor(random() * content.length));
    return Buffer.concat([
      content.subarray(0, a),
      content.subarray(Math.min(b, c), Math.max(b, c)),
      content.subarray(a),
    ]);
  },
  async noise(content, random) {
    const bytes = Buffer.from(Array.from({ length: Math.floor(random() * 5000) }, () => random() * 256));
    return random() < 0.5 ? bytes : Buffer.concat([content.subarray(0, 8), bytes]);
  },
  async header(_, random, records) {
    const [head, ...rest] = records.metadata;
    const text = head.metadata.get("record");
    const at = Math.floor(random() * text.length);
    const nasty = NASTY[Math.floor(random() * NASTY.length)];
    const number = [...text.matchAll(/-?\d+(\.\d+)?|"\w*"|\[\]|true|false/g)];
    const spot = number[Math.floor(random() * number.length)];
    const spoiled =
      random() < 0.7
        ? text.slice(0, spot.index) + nasty + text.slice(spot.index + spot[0].length)
        : text.slice(0, at) + text.slice(at + Math.floor(random() * 40));
    return written({
      ...records,
      metadata: [{ ...head, metadata: new Map([...head.metadata, ["record", spoiled]]) }, ...rest],
    });
  },
  async message(_, random, records) {
    const messages = [...records.messages];
    for (let k = 0; k < 1 + random() * 3; k++) {
      const at = Math.floor(random() * messages.length);
      let data = Buffer.from(messages[at].data);
      if (data[0] === 0x7b && random() < 0.7) {
        const nasty = NASTY[Math.floor(random() * NASTY.length)];
        const fields = data.toString().split(", ");
        const field = Math.floor(random() * fields.length);
        fields[field] = fields[field].replace(/: .*/, `: ${nasty}`);
        data = Buffer.from(fields.join(", "));
      } else data[Math.floor(random() * data.length)] ^= 1 << (random() * 8);
      messages[at] = { ...messages[at], data };
    }
    return written({ ...records, messages });
  },
  async order(_, random, records) {
    const messages = [...records.messages];
    const at = Math.floor(random() * messages.length);
    const way = random();
    if (way < 0.3) messages.splice(at, 1 + Math.floor(random() * 200));
    else if (way < 0.6) messages.splice(at, 0, ...messages.slice(0, 40));
    else messages[at] = { ...messages[at], logTime: BigInt(Math.floor(random() * 2 ** 53)) * (way < 0.8 ? 1n : 1000n) };
    return written({ ...records, messages });
  },
  async topic(_, random, records) {
    const channels = new Map(records.channels);
    const [id, channel] = [...channels][Math.floor(random() * channels.size)];
    channels.set(id, { ...channel, topic: random() < 0.5 ? "/other" : "/tf" });
    return written({ ...records, channels });
  },
};

/** Yield damaged logs, each with its name. */
export async function* damagedLogs(content, count, seed) {
  const records = recordsOf(content);
  const kinds = Object.entries(KINDS);
  for (let k = 0; k < count; k++) {
    const random = randomOf(1_000_003 * seed + k);
    const [kind, damage] = kinds[k % kinds.length];
    yield { name: `${kind}-${k}.mcap`, bytes: new Uint8Array(await damage(content, random, records)) };
  }
}
