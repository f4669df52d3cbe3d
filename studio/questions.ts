// What the page asks a worker, and how it asks.

import type { Column } from "./core.ts";
import type { Swimmer } from "./robot.ts";

export type Question =
  | { kind: "start"; module: WebAssembly.Module }
  | { kind: "load"; robot: string; image: Uint8Array }
  | ({ kind: "swim"; follow: boolean } & Swimmer)
  | ({ kind: "path" } & Swimmer)
  | ({ kind: "gradient" } & Swimmer)
  | ({ kind: "point" } & Swimmer)
  | { kind: "samples"; robot: string; images: Uint8Array[] } // of the coefficients, in place of those before
  | { kind: "spread"; robot: string; gaits: Float64Array } // quantities by sample, then by gait
  | { kind: "twin"; robot: string } // starts one, in place of the one before
  | { kind: "fly"; robot: string; mission: number; seed: number } // as well
  | { kind: "flown"; rows: number; every: number } // ticks from row to row
  | { kind: "tick"; gait: Float64Array; armed: boolean; broken: Broken[]; ticks: number };

/** Sensor channels with a fault from now on, of a kind of `FaultKind`. */
export interface Broken {
  kind: number;
  first: number;
  last: number;
}

/** What each kind of question is answered with. */
export interface Answers {
  start: null;
  load: { text: string };
  swim: { quantities: Float64Array };
  path: { path: Float64Array };
  gradient: { derivatives: Float64Array };
  point: { quantities: Float64Array; derivatives: Float64Array };
  samples: null;
  spread: { quantities: Float64Array };
  twin: { columns: Column[] };
  fly: { columns: Column[] };
  flown: { rows: Float64Array; over: boolean };
  tick: { rows: Float64Array };
}

export type Answer = Answers[keyof Answers];
export type Reply = { id: number; answer: Answer } | { id: number; fault: string };

/** Keeps the answer to the last question alone: one that a newer question has overtaken is null. */
export class Latest {
  private asked = 0;

  async of<T>(answer: Promise<T>): Promise<T | null> {
    const own = ++this.asked;
    const found = await answer.catch((error) => {
      if (own === this.asked) throw error;
      return null;
    });
    return own === this.asked ? found : null;
  }
}

interface Waiting {
  resolve(answer: Answer): void;
  reject(fault: Error): void;
}

/** A worker with the core, which starts with its first question. */
export class Calculator {
  private worker: Worker | null = null;
  private readonly waiting = new Map<number, Waiting>();
  private readonly loaded = new Map<string, Promise<string>>(); // text of each robot
  private last = 0;

  constructor(
    private readonly script: string,
    private readonly module: WebAssembly.Module,
  ) {}

  ask<K extends Question["kind"]>(question: Question & { kind: K }): Promise<Answers[K]> {
    if (this.worker === null) {
      this.worker = new Worker(this.script);
      this.worker.onmessage = ({ data }: MessageEvent<Reply>) => this.take(data);
      void this.ask({ kind: "start", module: this.module });
    }
    const { worker } = this;
    const id = ++this.last;
    return new Promise<Answer>((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      worker.postMessage({ id, question });
    }) as Promise<Answers[K]>;
  }

  /** Another worker with the same core. */
  another(): Calculator {
    return new Calculator(this.script, this.module);
  }

  /** Load a robot's image, where it was not loaded yet; returns its text. */
  load(robot: string, image: () => Promise<Uint8Array>): Promise<string> {
    const known = this.loaded.get(robot);
    if (known !== undefined) return known;
    const text = image().then(async (bytes) => (await this.ask({ kind: "load", robot, image: bytes })).text);
    this.loaded.set(robot, text);
    text.catch(() => this.loaded.delete(robot)); // it may be tried again
    return text;
  }

  /** Stop the worker: its questions stay without an answer. */
  end(): void {
    this.worker?.terminate();
  }

  private take(reply: Reply): void {
    const waiting = this.waiting.get(reply.id);
    this.waiting.delete(reply.id);
    if ("answer" in reply) waiting?.resolve(reply.answer);
    else waiting?.reject(new Error(reply.fault));
  }
}
