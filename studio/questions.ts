// What the page asks a worker, and how it asks.

import type { Column } from "./core.ts";

export type Question =
  | { kind: "start"; module: WebAssembly.Module }
  | { kind: "load"; robot: string; image: Uint8Array }
  | { kind: "beat"; robot: string; model: number; gait: Float64Array; follow: boolean }
  | { kind: "gradient"; robot: string; model: number; gait: Float64Array }
  | { kind: "point"; robot: string; model: number; gait: Float64Array }
  | { kind: "sweep"; robot: string; model: number; gaits: Float64Array }
  | { kind: "twin"; robot: string } // starts one, in place of the one before
  | { kind: "tick"; gait: Float64Array; armed: boolean; broken: Broken[]; ticks: number };

/** Sensor channels that fail from now on in a way (1 stuck, 2 open, 3 spikes, 4 not a number; 0 mends). */
export interface Broken {
  way: number;
  first: number;
  last: number;
}

export type Answer =
  | { kind: "start"; quantities: string[]; derivatives: string[] }
  | { kind: "load"; text: string }
  | { kind: "beat"; quantities: Float64Array; path: Float64Array }
  | { kind: "gradient"; derivatives: Float64Array }
  | { kind: "point"; quantities: Float64Array; derivatives: Float64Array }
  | { kind: "sweep"; quantities: Float64Array }
  | { kind: "twin"; columns: Column[] }
  | { kind: "tick"; rows: Float64Array };

export type Reply = { id: number; answer: Answer } | { id: number; fault: string };

type AnswerTo<K extends Question["kind"]> = Extract<Answer, { kind: K }>;

interface Waiting {
  resolve(answer: Answer): void;
  reject(fault: Error): void;
}

/** A worker with the core. */
export class Calculator {
  private readonly worker: Worker;
  private readonly waiting = new Map<number, Waiting>();
  private last = 0;

  constructor(script: string) {
    this.worker = new Worker(script);
    this.worker.onmessage = ({ data }: MessageEvent<Reply>) => this.take(data);
  }

  ask<K extends Question["kind"]>(question: Question & { kind: K }): Promise<AnswerTo<K>> {
    const id = ++this.last;
    return new Promise<Answer>((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.worker.postMessage({ id, question });
    }) as Promise<AnswerTo<K>>;
  }

  /** Stop the worker: its questions stay without an answer. */
  end(): void {
    this.worker.terminate();
  }

  private take(reply: Reply): void {
    const waiting = this.waiting.get(reply.id);
    this.waiting.delete(reply.id);
    if ("answer" in reply) waiting?.resolve(reply.answer);
    else waiting?.reject(new Error(reply.fault));
  }
}
