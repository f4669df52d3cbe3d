// A mission that is flown live: a worker computes it as fast as it can, and the view plays it.
import type { Calculator } from "../questions.ts";
import type { Robot } from "../robot.ts";
import { Flight } from "./flight.ts";

const ROW_RATE = 10; // rows per second of the flight
const QUESTION_TIME = 5; // s of the flight that one question to the worker computes

export class Live {
  readonly flight: Flight;
  over = false; // whether the mission is flown to its end
  private stopped = false;

  private constructor(
    private readonly calculator: Calculator,
    private readonly rate: number,
    private readonly robot: Robot,
    mission: number,
    seed: number,
    columns: ConstructorParameters<typeof Flight>[1],
  ) {
    const { pilot, missions } = robot;
    const flown = missions[mission];
    if (pilot === null || flown === undefined) throw new Error(`${robot.robot} has no mission ${mission}`);
    const head = {
      title: `${flown.name}, seed ${seed}`,
      robot: robot.robot,
      mission: flown,
      modes: pilot.modes,
      reasons: pilot.reasons,
      joints: robot.joints.length,
    };
    this.flight = new Flight(head, columns);
  }

  static async start(calculator: Calculator, robot: Robot, mission: number, seed: number): Promise<Live> {
    const { columns } = await calculator.ask({ kind: "fly", robot: robot.key, mission, seed });
    return new Live(calculator, robot.twin?.rate ?? 100, robot, mission, seed, columns);
  }

  /** Fly to the end; `grown` is called after each part. */
  async run(grown: () => void): Promise<void> {
    const every = Math.round(this.rate / ROW_RATE);
    let next = { rows: 1, every: 1 }; // the first tick, then ten rows per second, as in a log
    while (!this.over && !this.stopped) {
      const { rows, over } = await this.calculator.ask({ kind: "flown", ...next });
      if (this.stopped) return;
      next = { rows: QUESTION_TIME * ROW_RATE, every };
      this.flight.append(rows);
      this.over = over;
      grown();
    }
  }

  /** How the flight ended, in words; "" while it lasts. */
  get ending(): string {
    const { flight, robot } = this;
    const place = flight.value("ending", flight.count - 1);
    return place > 0 ? (robot.pilot?.endings[place - 1]?.text ?? "") : "";
  }

  stop(): void {
    this.stopped = true;
    this.calculator.end();
  }
}
