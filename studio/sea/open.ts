// Opens a log in its own worker, within a time limit.
import type { Log } from "./log.ts";
import type { Read } from "./reader.ts";

const TIME_LIMIT = 60; // s, time limit of reading a log
const MAX_FILE = 2 ** 28; // largest file in bytes: two days of a mission

/** Read a log; rejects with a sentence if the file is not one. */
export function openLog(script: string, name: string, content: Uint8Array): Promise<Log> {
  if (content.length > MAX_FILE) {
    const size = Math.round(content.length / 2 ** 20);
    return Promise.reject(new Error(`${name} must have at most ${MAX_FILE / 2 ** 20} MB, but is ${size} MB.`));
  }
  const address = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  const worker = new Worker(address);
  return new Promise<Log>((resolve, reject) => {
    const fail = (reason: string): void => reject(new Error(`${name} cannot be read: ${reason}.`));
    const late = setTimeout(() => fail(`it takes more than ${TIME_LIMIT} s`), 1000 * TIME_LIMIT);
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
