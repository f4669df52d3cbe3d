// Computes the beat of the gait on the knobs: its quantities first, then its path, its gradient and the start from
// rest.
import type { Calculator } from "./questions.ts";
import { type Swimmer, sameRobot } from "./robot.ts";
import type { ImageLoader } from "./robots.ts";

const START_DELAY = 250; // ms after the last turn of a knob; then the start from rest is computed

/** Receives a beat: quantities before the path; gradient and start from rest only of the last gait. */
export interface Listener {
  numbers(of: Swimmer, quantities: Float64Array): void;
  path(of: Swimmer, path: Float64Array): void;
  gradient(derivatives: Float64Array): void;
  fromRest(quantities: Float64Array): void;
}

export class Beats {
  private wanted: Swimmer | null = null;
  private image: ImageLoader = async () => new Uint8Array(); // reads the image of the wanted robot
  private running = false;
  private quiet = 0; // timer that begins the start from rest

  /** `live` computes quantities and path, `beside` the rest: no turn of a knob waits for a gradient. */
  constructor(
    private readonly live: Calculator,
    private readonly beside: Calculator,
    private readonly listener: Listener,
  ) {}

  /** Compute the beat of a gait. If knobs are turned meanwhile, only the last gait is computed next. */
  async request(swimmer: Swimmer, image: ImageLoader): Promise<void> {
    clearTimeout(this.quiet);
    this.wanted = swimmer;
    this.image = image;
    if (this.running) return;
    this.running = true;
    document.documentElement.dataset.busy = "1";
    try {
      for (let now: Swimmer | null = null; now !== this.wanted; ) {
        now = this.wanted;
        await this.compute(now);
      }
    } finally {
      this.running = false;
      document.documentElement.dataset.busy = "0";
    }
    this.quiet = window.setTimeout(() => void this.follow(), START_DELAY);
  }

  private async compute(now: Swimmer): Promise<void> {
    const { live, beside, listener, image } = this;
    await live.load(now.robot, image);
    const numbers = live.ask({ kind: "swim", ...now, follow: false });
    const path = live.ask({ kind: "path", ...now });
    const { quantities } = await numbers;
    if (!sameRobot(now.robot, this.wanted?.robot)) return;
    listener.numbers(now, quantities);
    listener.path(now, (await path).path);
    if (now !== this.wanted) return;
    await beside.load(now.robot, image);
    const { derivatives } = await beside.ask({ kind: "gradient", ...now });
    if (now === this.wanted) listener.gradient(derivatives);
  }

  /** Simulate the start from rest with the gait that is shown. */
  private async follow(): Promise<void> {
    const now = this.wanted;
    if (now === null) return;
    const { quantities } = await this.beside.ask({ kind: "swim", ...now, follow: true });
    if (now === this.wanted) this.listener.fromRest(quantities);
  }
}
