// Reads and writes a robot's image: columns of numbers in the layout of hosts/image.hpp.
import { IMAGE } from "./interface.ts";

const ENTRY_SIZE = 12; // bytes of a column's entry: rows, width and length of its name

export interface Column {
  name: string;
  rows: number;
  width: number;
  values: Float64Array;
}

/** The numbers of an image by name of the column, row by row. */
export type Columns = Map<string, Float64Array>;

/** Read the columns of an image that the core has accepted; nothing is checked here. */
export function columnsOf(image: Uint8Array): Column[] {
  const view = new DataView(image.buffer, image.byteOffset, image.byteLength);
  const size = (place: number): number => view.getUint32(place, true);
  const [count, names, text] = [size(IMAGE.columns), size(IMAGE.names), size(IMAGE.text)];
  let name = IMAGE.size + ENTRY_SIZE * count;
  let first = Math.ceil((name + names + text) / 8) * 8;
  return Array.from({ length: count }, (_, k) => {
    const entry = IMAGE.size + ENTRY_SIZE * k;
    const [rows, width, length] = [size(entry), size(entry + 4), size(entry + 8)];
    const letters = image.subarray(name, name + length);
    const end = first + 8 * rows * width;
    const values = new Float64Array(image.slice(first, end).buffer);
    [name, first] = [name + length, end];
    return { name: new TextDecoder().decode(letters), rows, width, values };
  });
}

/** Write columns as an image without text; the start of the header is copied from another image. */
export function imageOf(header: Uint8Array, columns: Column[]): Uint8Array {
  const names = columns.map(({ name }) => new TextEncoder().encode(name));
  const text = new TextEncoder().encode("{}");
  const letters = names.reduce((sum, { length }) => sum + length, 0);
  const numbers = columns.reduce((sum, { values }) => sum + values.length, 0);
  let name = IMAGE.size + ENTRY_SIZE * columns.length;
  let first = Math.ceil((name + letters + text.length) / 8) * 8;
  const made = new Uint8Array(first + 8 * numbers);
  const view = new DataView(made.buffer);
  made.set(header.subarray(0, IMAGE.checksum));
  const sizes = { columns: columns.length, names: letters, text: text.length, numbers };
  for (const part of ["columns", "names", "text", "numbers"] as const) view.setUint32(IMAGE[part], sizes[part], true);
  made.set(text, name + letters);
  columns.forEach(({ rows, width, values }, k) => {
    const word = names[k] ?? new Uint8Array();
    [rows, width, word.length].forEach((size, part) => {
      view.setUint32(IMAGE.size + ENTRY_SIZE * k + 4 * part, size, true);
    });
    made.set(word, name);
    made.set(new Uint8Array(values.buffer, values.byteOffset, values.byteLength), first);
    [name, first] = [name + word.length, first + values.byteLength];
  });
  view.setUint32(IMAGE.checksum, crc32(made.subarray(IMAGE.columns)), true);
  return made;
}

const CRC = Uint32Array.from({ length: 256 }, (_, byte) => {
  let crc = byte;
  for (let bit = 0; bit < 8; bit++) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  return crc;
});

/** CRC-32 (IEEE 802.3), as in zlib. */
function crc32(bytes: Uint8Array): number {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = (crc >>> 8) ^ (CRC[(crc ^ byte) & 255] ?? 0);
  return ~crc >>> 0;
}
