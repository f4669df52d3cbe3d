// Open a log in a worker of its own, within a time.
import type { Log } from "./log.ts";
import type { Read } from "./reader.ts";

const PATIENCE = 60; // s
const MAX_FILE = 2 ** 28; // bytes: two days of a mission

/** Read a log; rejects with a sentence where it is none. */
export function openLog(script: string, name: string, content: Uint8Array): Promise<Log> {
  if (content.length > MAX_FILE) {
    const size = Math.round(content.length / 2 ** 20);
    return Promise.reject(new Error(`${name} must have at most ${MAX_FILE / 2 ** 20} MB, but is ${size} MB.`));
  }
  const address = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  const worker = new Worker(address);
  return new Promise<Log>((resolve, reject) => {
    const fail = (reason: string): void => reject(new Error(`${name} cannot be read: ${reason}.`));
    const late = setTimeout(() => fail(`it takes more than ${PATIENCE} s`), 1000 * PATIENCE);
    worker.onerror = (event) => {
      event.preventDefault();
      fail(event.message || "the reader ended");
    };
    worker.onmessage = ({ data }: MessageEvent<Read>) => {
      clearTimeout(late);
      if ("log" in data) resolve(data.log);
      else reject(new Error(data.fault));
    };
    worker.postMessage({ name, content });
  }).finally(() => {
    worker.terminate();
    URL.revokeObjectURL(address);
  });
}
