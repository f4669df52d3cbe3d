// A robot's image in the page: its columns of numbers, and the image with some of them changed. Layout: hosts/image.hpp.

const HEADER = 32; // bytes: magic, version, checksum, sizes
const COVERED = 16; // the checksum is of all from here on
const ENTRY = 12; // bytes of a column's rows, width and length of name

/** Numbers of an image by column, one after another. */
export type Columns = Map<string, Float64Array>;

interface Layout {
  columns: { name: string; first: number; count: number }[];
  entries: Uint8Array; // of the columns, and their names
  numbers: Float64Array;
}

/** Read where the numbers are; the core has refused what is no image. */
function layoutOf(image: Uint8Array): Layout {
  const view = new DataView(image.buffer, image.byteOffset, image.byteLength);
  const size = (k: number): number => view.getUint32(COVERED + 4 * k, true);
  const [columns, names, text, numbers] = [size(0), size(1), size(2), size(3)];
  const head = HEADER + ENTRY * columns;
  const start = Math.ceil((head + names + text) / 8) * 8;
  let [name, first] = [head, 0];
  const list = Array.from({ length: columns }, (_, k) => {
    const entry = (part: number): number => view.getUint32(HEADER + ENTRY * k + 4 * part, true);
    const [count, length] = [entry(0) * entry(1), entry(2)];
    const column = { name: new TextDecoder().decode(image.subarray(name, name + length)), first, count };
    [name, first] = [name + length, first + count];
    return column;
  });
  const data = new Float64Array(image.slice(start, start + 8 * numbers).buffer);
  return { columns: list, entries: image.subarray(HEADER, head + names), numbers: data };
}

/** The numbers of an image by column. */
export function columnsOf(image: Uint8Array): Columns {
  const { columns, numbers } = layoutOf(image);
  return new Map(columns.map(({ name, first, count }) => [name, numbers.subarray(first, first + count)]));
}

/** An image with other numbers in some columns, each as long as before, and without its text. */
export function edited(image: Uint8Array, changed: Columns): Uint8Array {
  const { columns, entries, numbers } = layoutOf(image);
  for (const { name, first, count } of columns) {
    const values = changed.get(name);
    if (values?.length === count) numbers.set(values, first);
  }
  const text = new TextEncoder().encode("{}");
  const start = Math.ceil((HEADER + entries.length + text.length) / 8) * 8;
  const made = new Uint8Array(start + numbers.byteLength);
  made.set(image.subarray(0, HEADER));
  made.set(entries, HEADER);
  made.set(text, HEADER + entries.length);
  made.set(new Uint8Array(numbers.buffer), start);
  const view = new DataView(made.buffer);
  view.setUint32(COVERED + 8, text.length, true);
  view.setUint32(COVERED - 4, crc32(made.subarray(COVERED)), true);
  return made;
}

const CRC = Uint32Array.from({ length: 256 }, (_, byte) => {
  let crc = byte;
  for (let bit = 0; bit < 8; bit++) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  return crc;
});

/** CRC-32 (IEEE 802.3), as zlib has it. */
export function crc32(bytes: Uint8Array): number {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = (crc >>> 8) ^ (CRC[(crc ^ byte) & 255] ?? 0);
  return ~crc >>> 0;
}
