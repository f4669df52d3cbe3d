// A thread that reads logs one by one, with the reader of the page.
import { parentPort, workerData } from "node:worker_threads";

const { readLog } = await import(workerData.script);

parentPort.on("message", ({ name, bytes }) => {
  try {
    const { rows, columns, sentence } = readLog(name, bytes);
    const width = columns.reduce((sum, column) => sum + column.width, 0);
    const finite = rows.every(Number.isFinite);
    parentPort.postMessage({ name, rows: rows.length / width, finite, sentence });
  } catch (error) {
    parentPort.postMessage({ name, rows: 0, finite: true, sentence: error.message, kind: error.constructor.name });
  }
});
parentPort.postMessage("ready");
