// The worker that reads a log beside the page.
import { type Log, readLog } from "./log.ts";

/** The request to the worker: a file; its answer is a `Read`. */
export interface File {
  name: string;
  content: Uint8Array;
}
export type Read = { log: Log } | { fault: string };

self.onmessage = ({ data }: MessageEvent<File>): void => {
  let read: Read;
  try {
    read = { log: readLog(data.name, data.content) };
  } catch (error) {
    read = { fault: error instanceof Error ? error.message : String(error) };
  }
  self.postMessage(read);
};
