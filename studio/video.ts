// Records a short video of a canvas with the browser's own recorder.

const TYPES = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
const BIT_RATE = 8e6; // bits per second of the video
const FRAME_RATE = 60; // frames per second
const MIN_LENGTH = 3; // s, shortest video
const MARGIN = 0.1; // s, extra recording time: the first frame comes late

/** The type of video that this browser can record; "" if it records none. */
export function videoType(): string {
  if (typeof MediaRecorder !== "function" || !("captureStream" in HTMLCanvasElement.prototype)) return "";
  return TYPES.find((type) => MediaRecorder.isTypeSupported(type)) ?? "";
}

/** Length of a video of two beats, at least 3 s [s]. */
export function lengthOf(frequency: number, tempo: number): number {
  return Math.max(MIN_LENGTH, 2 / (frequency * tempo));
}

/** Records a canvas for some seconds; `stop` ends the video sooner. */
export class Video {
  readonly done: Promise<Blob>;
  private readonly recorder: MediaRecorder;

  constructor(canvas: HTMLCanvasElement, seconds: number) {
    const type = videoType();
    const stream = canvas.captureStream(FRAME_RATE);
    this.recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: BIT_RATE });
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
