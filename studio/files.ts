// Reads the files that the page contains, and saves files from it.
import { colorOf } from "./dom.ts";

/** Decode base64 text to bytes. */
export function plainBytes(text: string): Uint8Array<ArrayBuffer> {
  const letters = atob(text.trim());
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
  return bytes;
}

/** Decode base64 text and unpack its gzip content. */
export async function packedBytes(text: string): Promise<Uint8Array<ArrayBuffer>> {
  const stream = new Blob([plainBytes(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export function save(content: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

export function saveText(text: string, name: string): void {
  const type = name.endsWith(".svg") ? "image/svg+xml" : "text/plain";
  save(new Blob([text], { type }), name);
}

/** Save a canvas with a line of text in its upper left corner. */
export function savePicture(canvas: HTMLCanvasElement, text: string, name: string): void {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext("2d");
  if (pen === null) return;
  const unit = canvas.width / canvas.clientWidth;
  pen.drawImage(canvas, 0, 0);
  pen.font = `${13 * unit}px system-ui, sans-serif`;
  pen.fillStyle = colorOf(canvas, "ink");
  pen.fillText(text, 16 * unit, 26 * unit);
  copy.toBlob((content) => content && save(content, name));
}
