// Reads MCAP files: the messages of all whole chunks, each checked by its checksum, even if the file was cut short.
import { crc32 } from "@foxglove/crc";
import { McapStreamReader, type McapTypes } from "@mcap/core";
import { decompress } from "fzstd";

export const METADATA = "hypertuna"; // name of the metadata record that describes a log
const ENDING = "hypertuna-end"; // name of the metadata record at the end of a log
const MAGIC = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a]; // first bytes of an MCAP file
// Largest unpacked size of a file, against zip bombs: logs of missions shrink only to a third.
const [MAX_CHUNK, MAX_UNPACKED, MAX_RATIO] = [4 << 20, 4 << 20, 30]; // bytes; bytes for each byte of the file
const DATA_END = 13; // bytes of the record that ends the chunks

/** Messages of a file, up to its end or its first fault. */
export interface Messages {
  times: Map<string, number[]>; // times of the messages, by topic [s]
  contents: Map<string, Uint8Array[]>; // contents of the messages, by topic
  metadata: Record<string, string> | null; // the record that describes the log
  chunks: number; // number of whole chunks
  fault: string; // description of the first fault; empty for a sound file
}

/** Whether a file begins with the magic bytes of MCAP. */
export function isMcap(content: Uint8Array): boolean {
  return MAGIC.every((byte, k) => content[k] === byte);
}

/** Read the messages of all whole chunks; `name` returns the name under which a message is stored. */
export function messagesOf(content: Uint8Array, name: (topic: string, data: Uint8Array) => string): Messages {
  const messages: Messages = { times: new Map(), contents: new Map(), metadata: null, chunks: 0, fault: "" };
  const reader = new McapStreamReader({ includeChunks: true, decompressHandlers: { zstd: unpacked } });
  const topics = new Map<number, string>();
  let bytesLeft = MAX_UNPACKED + MAX_RATIO * content.length;
  let chunk: McapTypes.Message[] | null = null; // messages of the chunk that is read
  const close = (): void => {
    if (chunk === null) return;
    for (const message of chunk) keep(messages, name(topics.get(message.channelId) ?? "", message.data), message);
    messages.chunks++;
    chunk = null;
  };
  try {
    reader.append(content);
    for (let record = reader.nextRecord(); record !== undefined; record = reader.nextRecord()) {
      if (record.type === "Chunk") {
        close();
        bytesLeft -= Number(record.uncompressedSize);
        if (record.uncompressedSize > MAX_CHUNK || bytesLeft < 0) throw new Fault("it unpacks to much more than a log");
        if (record.compression === "" && record.records.length !== Number(record.uncompressedSize))
          throw new Fault("the size of a chunk is wrong");
        chunk = [];
      } else if (record.type === "Message") chunk?.push(record);
      else if (record.type === "Channel") topics.set(record.id, record.topic);
      else if (record.type !== "Schema" && record.type !== "Unknown") close();
      if (record.type === "Metadata") describe(messages, record);
      if (record.type === "DataEnd")
        checkSum(content.subarray(0, content.length - reader.bytesRemaining() - DATA_END), record);
    }
    close();
    if (!reader.done())
      messages.fault = tooLong(content, reader.bytesRemaining()) ? "damaged (a record is too long)" : "cut short";
  } catch (error) {
    // a damaged file may raise anything in the reader
    messages.fault = `damaged (${reason(error)})`;
  }
  return messages;
}

/** Whether the unfinished record states a size larger than the file. */
function tooLong(content: Uint8Array, rest: number): boolean {
  const begin = content.length - rest;
  return rest > 8 && new DataView(content.buffer, content.byteOffset).getBigUint64(begin + 1, true) > content.length;
}

class Fault extends Error {}

function reason(error: unknown): string {
  if (error instanceof Fault) return error.message;
  const text = error instanceof Error ? error.message : "";
  if (text.includes("CRC")) return "a checksum is wrong";
  const [, behind] = /(\d+) bytes remaining after/.exec(text) ?? [];
  return behind === undefined ? "a record cannot be read" : `${behind} bytes behind its end`;
}

function keep(messages: Messages, topic: string, { logTime, data }: McapTypes.Message): void {
  const [times, contents] = [messages.times.get(topic) ?? [], messages.contents.get(topic) ?? []];
  times.push(Number(logTime) / 1e9);
  contents.push(data);
  messages.times.set(topic, times);
  messages.contents.set(topic, contents);
}

function describe(messages: Messages, { name, metadata }: McapTypes.Metadata): void {
  if (name === METADATA) messages.metadata = Object.fromEntries(metadata);
  if (name !== ENDING || messages.metadata === null) return;
  for (const [key, value] of metadata) if (key !== "record") messages.metadata[key] = value;
}

/** Check the checksum over all bytes before the end of the chunks. */
function checkSum(content: Uint8Array, { dataSectionCrc: sum }: McapTypes.DataEnd): void {
  if (sum !== 0 && crc32(content) !== sum) throw new Fault("a checksum is wrong");
}

/** Unpack a chunk; its content must have the size that the chunk states. */
function unpacked(packed: Uint8Array, size: bigint): Uint8Array {
  const target = new Uint8Array(Number(size));
  const data = decompress(packed, target);
  if (data.length !== target.length) throw new Fault("the size of a chunk is wrong");
  return data;
}
