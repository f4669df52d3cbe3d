// A short video of a canvas, by the browser's own recorder.

const TYPES = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
const SHARP = 8e6; // bits a second
const FRAMES = 60; // a second
const LEAST = 3; // s
const MARGIN = 0.1; // s: the first frame comes late

/** The kind of video that this browser records; "" where it records none. */
export function videoType(): string {
  if (typeof MediaRecorder !== "function" || !("captureStream" in HTMLCanvasElement.prototype)) return "";
  return TYPES.find((type) => MediaRecorder.isTypeSupported(type)) ?? "";
}

/** How long a video of two beats is, of 3 s at least [s]. */
export function lengthOf(frequency: number, tempo: number): number {
  return Math.max(LEAST, 2 / (frequency * tempo));
}

/** A video of a canvas while something is drawn on it; `stop` ends it sooner. */
export class Video {
  readonly done: Promise<Blob>;
  private readonly recorder: MediaRecorder;

  constructor(canvas: HTMLCanvasElement, seconds: number) {
    const type = videoType();
    const stream = canvas.captureStream(FRAMES);
    this.recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: SHARP });
    const chunks: Blob[] = [];
    this.recorder.ondataavailable = ({ data }) => chunks.push(data);
    this.done = new Promise((resolve, reject) => {
      this.recorder.onstop = () => {
        for (const track of stream.getTracks()) track.stop();
        resolve(new Blob(chunks, { type: type.replace(/;.*/, "") }));
      };
      this.recorder.onerror = () => reject(new Error("this browser could not record the picture"));
    });
    this.recorder.onstart = () => window.setTimeout(() => this.stop(), 1000 * (seconds + MARGIN));
    this.recorder.start();
  }

  stop(): void {
    if (this.recorder.state !== "inactive") this.recorder.stop();
  }
}
