// The line of time: what was done, what hit, what was woken and what fell; a click goes there.
import { colourOf } from "./page";
import type { Told } from "./payload";

const MARKS: Record<string, [string, number]> = {
  placed: ["#8c959f", 0.3], // colour, and how high a mark is
  removed: ["#bf8700", 0.7],
  pushed: ["#bf8700", 0.7],
  hit: ["#bf3989", 0.8],
  woken: ["#1f6feb", 0.6],
  collapsed: ["#d1242f", 1],
};
const NEAR = 6; // [px] within which a click means a mark

export class Timeline {
  readonly canvas = document.createElement("canvas");
  end = 1; // [s]
  events: Told[] = [];
  private readonly marks = document.createElement("canvas");
  private key = "";
  private of: Told[] = [];

  constructor(private readonly go: (time: number) => void) {
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "slider");
    this.canvas.setAttribute("aria-label", "time");
    let held = false;
    this.canvas.addEventListener("pointerdown", (event) => {
      held = true;
      this.canvas.setPointerCapture(event.pointerId);
      this.go(this.meant(event.offsetX));
    });
    this.canvas.addEventListener("pointermove", (event) => held && this.go(this.timeAt(event.offsetX)));
    for (const name of ["pointerup", "pointercancel"]) this.canvas.addEventListener(name, () => (held = false));
  }

  // The event before a time, or after it.
  step(time: number, way: -1 | 1): Told | undefined {
    const told = this.events.filter((event) => event.kind in MARKS && (event.time - time) * way > 1e-6);
    return way > 0 ? told[0] : told[told.length - 1];
  }

  // What happened last, as far as a time.
  last(time: number): Told | undefined {
    const { events } = this;
    let [low, high] = [0, events.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (events[middle].time <= time + 1e-6) low = middle + 1;
      else high = middle;
    }
    return events[low - 1];
  }

  draw(time: number): void {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const ratio = Math.min(devicePixelRatio, 2);
    if (this.canvas.width !== Math.round(width * ratio)) {
      [this.canvas.width, this.canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    }
    const pen = this.canvas.getContext("2d")!;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.drawImage(this.marked(width, height, ratio), 0, 0, width, height);
    pen.fillStyle = colourOf("--ink");
    pen.beginPath();
    pen.arc(this.placeOf(time), height / 2, 6, 0, 7);
    pen.fill();
    this.canvas.setAttribute("aria-valuenow", time.toFixed(3));
    this.canvas.setAttribute("aria-valuemin", "0");
    this.canvas.setAttribute("aria-valuemax", this.end.toFixed(3));
  }

  // All marks, which are drawn once.
  private marked(width: number, height: number, ratio: number): HTMLCanvasElement {
    const { marks } = this;
    const key = [width, ratio, this.end, this.events.length].join();
    if (this.key === key && this.of === this.events) return marks;
    [this.key, this.of] = [key, this.events];
    [marks.width, marks.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    const pen = marks.getContext("2d")!;
    pen.scale(ratio, ratio);
    pen.fillStyle = "#8c959f40";
    pen.fillRect(0, height / 2 - 2, width, 4);
    for (const [kind, [colour, high]] of Object.entries(MARKS)) {
      pen.fillStyle = colour;
      for (const event of this.events) {
        if (event.kind === kind) pen.fillRect(this.placeOf(event.time) - 1, (height * (1 - high)) / 2, 2, height * high);
      }
    }
    return marks;
  }

  // Where a time is [px].
  placeOf(time: number): number {
    return 8 + (time / this.end) * (this.canvas.clientWidth - 16);
  }

  private timeAt(x: number): number {
    return Math.min(this.end, Math.max(0, ((x - 8) / (this.canvas.clientWidth - 16)) * this.end));
  }

  private meant(x: number): number {
    let [nearest, found] = [NEAR, this.timeAt(x)];
    for (const event of this.events) {
      const away = Math.abs(this.placeOf(event.time) - x) + (event.kind === "collapsed" ? 0 : 0.5);
      if (event.kind in MARKS && away < nearest) [nearest, found] = [away, event.time];
    }
    return found;
  }
}
