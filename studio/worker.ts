// The worker that computes beside the page: it answers questions about robots one by one.
import { Core, type CoreRobot, type CoreTwin } from "./core.ts";
import { bodyOf } from "./robot.ts";
import type { Answer, Question, Reply } from "./questions.ts";

const MAX_BODIES = 16; // changed bodies that stay loaded: searches and maps may still ask about them

let core: Core;
let twin: CoreTwin | null = null;
let sampled: { robot: string; samples: CoreRobot[] } = { robot: "", samples: [] };
const robots = new Map<string, CoreRobot>();

function robot(name: string): CoreRobot {
  const found = robots.get(name);
  if (found === undefined) throw new Error(`no robot ${name} was loaded`);
  return found;
}

/** Join arrays of numbers, one after another. */
function joined(parts: Float64Array[]): Float64Array {
  const whole = new Float64Array(parts.reduce((sum, { length }) => sum + length, 0));
  let place = 0;
  for (const part of parts) {
    whole.set(part, place);
    place += part.length;
  }
  return whole;
}

/** Free the oldest changed bodies, which no view shows any more. */
function forget(): void {
  const bodies = [...robots.keys()].filter((key) => bodyOf(key) !== "");
  for (const key of bodies.slice(0, -MAX_BODIES)) {
    robots.get(key)?.free();
    robots.delete(key);
  }
}

async function answer(question: Question): Promise<Answer> {
  switch (question.kind) {
    case "start":
      core = await Core.start(question.module);
      return null;
    case "load": {
      const read = core.read(question.image);
      robots.get(question.robot)?.free();
      robots.set(question.robot, read);
      forget();
      return { text: read.text };
    }
    case "swim":
      return { quantities: robot(question.robot).swim(question.model, question.gait, question.follow) };
    case "path":
      return { path: robot(question.robot).path(question.model, question.gait) };
    case "gradient":
      return { derivatives: robot(question.robot).gradient(question.model, question.gait) };
    case "point": {
      const swimmer = robot(question.robot);
      const quantities = swimmer.swim(question.model, question.gait, false);
      return { quantities, derivatives: swimmer.gradient(question.model, question.gait) };
    }
    case "samples":
      for (const sample of sampled.samples) sample.free();
      sampled = { robot: question.robot, samples: question.images.map((image) => core.read(image)) };
      return null;
    case "spread": {
      if (sampled.robot !== question.robot) throw new Error(`no samples of ${question.robot} were loaded`);
      const parts = sampled.samples.map((sample) => sample.swim(0, question.gaits, false));
      return { quantities: joined(parts) };
    }
    case "twin":
      twin?.free();
      twin = core.twin(robot(question.robot));
      return { columns: twin.columns };
    case "fly":
      twin?.free();
      twin = core.fly(robot(question.robot), question.mission, question.seed);
      return { columns: twin.columns };
    case "flown": {
      if (twin === null) throw new Error("no mission was started");
      const rows = twin.advance(question.rows, question.every);
      return { rows, over: rows.length < question.rows * twin.width };
    }
    case "tick":
      if (twin === null) throw new Error("no twin was started");
      twin.command(question.gait, question.armed);
      for (const { kind, first, last } of question.broken) twin.break(kind, first, last);
      return { rows: twin.advance(question.ticks) };
  }
}

// Questions are answered in order of arrival: a robot is loaded before it is asked about.
let last: Promise<void> = Promise.resolve();

self.onmessage = ({ data }: MessageEvent<{ id: number; question: Question }>): void => {
  last = last.then(async () => {
    let reply: Reply;
    try {
      reply = { id: data.id, answer: await answer(data.question) };
    } catch (error) {
      reply = { id: data.id, fault: error instanceof Error ? error.message : String(error) };
    }
    self.postMessage(reply);
  });
};
