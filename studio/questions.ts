// The questions that the page asks a worker, and the class that asks them.

import type { Column } from "./core.ts";
import type { Swimmer } from "./robot.ts";

export type Question =
  | { kind: "start"; module: WebAssembly.Module }
  | { kind: "load"; robot: string; image: Uint8Array }
  | ({ kind: "swim"; follow: boolean } & Swimmer)
  | ({ kind: "path" } & Swimmer)
  | ({ kind: "gradient" } & Swimmer)
  | ({ kind: "point" } & Swimmer)
  | { kind: "samples"; robot: string; images: Uint8Array[] } // replaces the loaded samples
  | { kind: "spread"; robot: string; gaits: Float64Array } // computes quantities, ordered by sample, then by gait
  | { kind: "twin"; robot: string } // starts a twin in place of the one before
  | { kind: "fly"; robot: string; mission: number; seed: number } // starts a flight in place of the one before
  | { kind: "flown"; rows: number; every: number } // next rows of the flight, `every` ticks apart
  | { kind: "tick"; gait: Float64Array; armed: boolean; broken: Broken[]; ticks: number };

/** A fault of sensor channels `first` to `last`; `kind` is one of `FaultKind`. */
export interface Broken {
  kind: number;
  first: number;
  last: number;
}

/** The answer to each kind of question. */
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

/** Lets only the answer to the newest question through: older ones become null. */
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

/** A worker with the core; it starts with its first question. */
export class Calculator {
  private worker: Worker | null = null;
  private readonly waiting = new Map<number, Waiting>();
  private readonly loaded = new Map<string, Promise<string>>(); // text of each loaded robot, by its key
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

  /** Load a robot's image if it is not loaded yet; returns the image's text. */
  load(robot: string, image: () => Promise<Uint8Array>): Promise<string> {
    const known = this.loaded.get(robot);
    if (known !== undefined) return known;
    const text = image().then(async (bytes) => (await this.ask({ kind: "load", robot, image: bytes })).text);
    this.loaded.set(robot, text);
    text.catch(() => this.loaded.delete(robot)); // the next call tries again
    return text;
  }

  /** Stop the worker; open questions never get an answer. */
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
