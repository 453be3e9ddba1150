// What is played, and how: time, speed, colours, and what is looked at.
import { Vector3 } from "three";
import { MODES, type Mode, OF_PROOFS } from "./colours";
import { TOGETHER } from "./lanes";
import { NEED_PROOF, type Overlay, type Which } from "./overlays";
import { failed, goldenOf, type Run } from "./run";
import { Stage } from "./stage";
import { Timeline } from "./timeline";
import { type From, Viewer } from "./viewer";
import { isThrown } from "./wording";

export const SPEEDS = [1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 4, 8];
const LATE = 1 / 35; // [s] between frames
const COARSEST = 0.5; // fewer pixels than a quarter of them save nothing more: then it is corners that take the time
const TELLING = 60; // [ms] between texts while it plays, which nobody reads faster
const SWINGING = 1.5; // [s] from where it stood and back
const RESTING = 200; // [ms] after which a picture is drawn finely
const LOOKING = 250; // [ms] between looks at whether it has grown out of the picture

export class Player {
  readonly viewer = new Viewer(() => this.touch());
  readonly timeline = new Timeline((time) => this.seek(time));
  time = 0; // [s]
  playing = false;
  speed = 1;
  mode: Mode = "state";
  overlays = new Set<Overlay>();
  which: Which = "selected";
  xray = false;
  top = Infinity; // the highest level that is drawn
  hovered: [number, number] | undefined; // which stage, which brick
  following = false;
  swinging = false;
  picked: [number, number] | undefined; // which stage, which brick
  shown: number[] = []; // which of the runs
  told: () => void = () => undefined; // whenever something has changed
  drawn = 0; // frames so far
  heard = 0; // runs that came while the page was open, each time anew
  private sought = false; // whether somebody chose what time is seen
  private fresh = false; // whether what is drawn is what is there
  private said = false; // likewise what is told in words
  private before = 0; // when the last frame was drawn [ms]
  private drawnAt = 0; // when the bricks last changed [ms]
  private late = 0; // [s] between the last frames
  private toldAt = 0; // when texts and the line of time were last brought up to date [ms]
  private swingTime = 0; // [s]
  private fine = true; // whether it is drawn finely, or cannot be
  private looked = false; // whether it was looked at whether it has grown since it last changed
  private lookedAt = 0; // when it was last looked at whether it has grown [ms]
  private readonly made = new Map<number, Stage>();

  constructor(readonly runs: Run[]) {}

  // Show one run, or two beside each other.
  show(...numbers: number[]): void {
    const before = this.viewer.stages.length;
    this.stage(numbers);
    if (before !== numbers.length) this.viewer.fit(this.time, undefined, this.timeline.end);
  }

  private stage(numbers: number[]): void {
    this.shown = numbers;
    this.picked = undefined;
    const stages = numbers.map((number) => this.made.get(number) ?? new Stage(this.runs[number]));
    numbers.forEach((number, place) => this.made.set(number, stages[place]));
    this.viewer.stages = stages;
    const runs = stages.map((stage) => stage.run);
    this.timeline.show(runs, shortNames(runs));
    this.seek(Math.min(this.time, this.timeline.end));
  }

  // A run that there is from now on, or instead of the one of this number: what is looked at, and from where, stays.
  put(number: number, run: Run): void {
    const first = this.shown.length === 0;
    this.heard++;
    this.runs[number] = run;
    this.made.get(number)?.forget();
    this.made.delete(number);
    if (first) this.open(number);
    else if (this.shown.includes(number)) this.again(this.shown);
  }

  // There are fewer runs from now on.
  keep(count: number): void {
    if (this.runs.length <= count) return;
    this.runs.length = count;
    for (const [number, stage] of this.made) if (number >= count) stage.forget(), this.made.delete(number);
    const left = this.shown.filter((number) => number < count);
    if (left.length < this.shown.length) this.again(left.length ? left : [0]);
  }

  private again(numbers: number[]): void {
    const name = this.picked && this.viewer.stages[this.picked[0]].run.told.bricks.name[this.picked[1]];
    const place = this.picked?.[0] ?? 0;
    const [time, sought] = [this.time, this.sought];
    this.show(...numbers);
    const brick = name === undefined ? -1 : (this.viewer.stages[place]?.run.told.bricks.name.indexOf(name) ?? -1);
    if (brick >= 0) this.picked = [place, brick];
    else this.following = false;
    this.seek(sought ? time : this.beginning());
    this.sought = sought;
  }

  // Show one run for the first time, beside its golden file if that differs.
  private open(number: number): void {
    const golden = this.runs.findIndex((run) => run.told.name === goldenOf(this.runs[number]));
    const differs = golden >= 0 && Object.keys(this.runs[golden].told.marks ?? {}).length > 0;
    this.stage([number, ...(differs ? [golden] : [])]);
    this.seek(this.beginning());
    this.viewer.look("three-quarter", this.time, this.timeline.end, false);
    this.sought = false;
  }

  // Begin with the run of this name, or the first that failed, or the first.
  start(name: string): void {
    const named = this.runs.findIndex((run) => run.told.name === name);
    if (this.runs.length) this.open(Math.max(0, named < 0 ? this.runs.findIndex(failed) : named));
    const frame = (now: number): void => {
      this.frame(now);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  // Of a run that failed, just before it begins to fall, or its end. Any other opens as it stands before what is thrown at it, or
  // what makes it fall; if it stands, at its end.
  private beginning(): number {
    const { run } = this.viewer.stages[0];
    const { events, fall, end } = run.told;
    const fell = events.find((event) => event.kind === "collapsed");
    if (fall && !fell) return fall.time;
    const just = (time: number): number => Math.max(0, time - 0.001);
    if (failed(run)) return fell ? just(Math.min(fell.time, fall?.time ?? Infinity)) : end;
    const thrown = events.find((event) => isThrown(run, event));
    const done = events.filter((event) => event.kind in TOGETHER && fell && event.time <= fell.time);
    const cause = thrown ?? done[done.length - 1];
    return cause ? just(cause.time) : end;
  }

  seek(time: number): void {
    this.time = Math.min(this.timeline.end, Math.max(0, time));
    this.sought = true;
    this.swinging = false;
    this.touch();
  }

  play(wanted = !this.playing): void {
    if (wanted && this.time >= this.timeline.end) this.time = 0;
    this.playing = wanted;
    this.sought ||= wanted;
    this.swinging = false;
    this.touch();
  }

  step(way: -1 | 1): void {
    const event = this.timeline.step(this.time, way);
    this.playing = false;
    this.seek(event ? event.time : way > 0 ? this.timeline.end : 0);
  }

  // Show a brick of this name.
  pickNamed(name: string | undefined): void {
    const brick = this.viewer.stages[0]?.run.told.bricks.name.indexOf(name ?? "") ?? -1;
    if (brick >= 0) this.pick([0, brick]);
  }

  // Play the motion with which it begins to fall, which proves that it does.
  swing(): void {
    const fall = this.viewer.stages[0]?.run.told.fall;
    if (!fall) return;
    this.playing = false;
    this.seek(fall.time);
    this.overlays.add("motion");
    this.swinging = true;
    this.swingTime = 0;
  }

  colour(mode: Mode): void {
    this.mode = MODES.includes(mode) ? mode : this.mode;
    this.touch();
  }

  // The colours that are shown: those of the state if what is chosen has nothing to tell.
  get seen(): Mode {
    return this.silent(this.mode) ? "state" : this.mode;
  }

  // Why a colouring has nothing to tell at this time; empty if it has.
  silent(mode: Mode): string {
    const reasons = this.viewer.stages.map((stage) => stage.colours.silent(mode, this.time));
    return reasons.every(Boolean) ? (reasons[0] ?? "") : "";
  }

  // What is chosen, but has nothing to show at this time, as no proof holds.
  get missing(): string[] {
    if (this.proves()) return [];
    return [...(OF_PROOFS.has(this.mode) ? [`colours by ${this.mode}`] : []), ...[...this.overlays].filter((overlay) => NEED_PROOF.has(overlay))];
  }

  private proves(): boolean {
    return this.viewer.stages.some((stage) => stage.run.proofAt(this.time) !== undefined);
  }

  overlay(name: Overlay): void {
    if (!this.overlays.delete(name)) this.overlays.add(name);
    const fall = this.viewer.stages[0]?.run.told.fall;
    if (name === "motion" && fall && this.overlays.has(name)) this.seek(fall.time); // it is the motion of this moment
    this.touch();
  }

  look(from: From): void {
    this.viewer.look(from, this.time);
    this.touch();
  }

  pick(found: [number, number] | undefined): void {
    this.picked = found;
    this.hovered = undefined;
    if (!found) this.following = false;
    this.touch();
  }

  follow(): void {
    this.following = !this.following && this.picked !== undefined;
    this.touch();
  }

  // A brick that is pointed at.
  point(found: [number, number] | undefined): void {
    if (this.hovered?.join() === found?.join()) return;
    this.hovered = found;
    this.touch();
  }

  touch(): void {
    this.fresh = false;
  }

  // Only words have changed: to draw all bricks for them would take time from whoever works out what comes next.
  retell(): void {
    this.said = false;
  }

  private frame(now: number): void {
    const passed = Math.min(0.1, (now - this.before) / 1000);
    this.before = now;
    this.adapt(passed);
    if (this.playing) {
      this.fresh = false;
      this.time = this.timeline.later(this.time, passed * this.speed);
      if (this.time >= this.timeline.end) [this.time, this.playing] = [this.timeline.end, false];
    }
    if (this.swinging) this.swingTime += passed;
    if (!this.viewer.stages.length) return;
    if (!this.fresh) this.looked = false;
    if (!this.looked && now - this.lookedAt > LOOKING) {
      [this.looked, this.lookedAt] = [true, now];
      if (!this.following) this.viewer.follow(this.time);
    }
    if (!this.fresh || this.swinging) {
      [this.fresh, this.said] = [true, false];
      this.update();
      this.viewer.draw();
      this.drawn++;
      [this.fine, this.drawnAt] = [!this.viewer.coarse, now];
    } else if (!this.fine && !this.playing && now - this.drawnAt > RESTING) {
      this.fine = true;
      this.viewer.draw(true);
    }
    if (this.said || (this.playing && now - this.toldAt < TELLING)) return;
    [this.said, this.toldAt] = [true, now];
    this.timeline.draw(this.time);
    this.told();
  }

  // Draw fewer pixels while it moves, where frames take too long, and all of them once it rests.
  private adapt(passed: number): void {
    this.late = this.playing || this.swinging ? 0.8 * this.late + 0.2 * passed : 0;
    const { viewer } = this;
    const wanted = this.late > LATE && viewer.sharpness > COARSEST ? Math.max(COARSEST, viewer.sharpness * 0.7) : this.late ? viewer.sharpness : 1;
    if (wanted === viewer.sharpness) return;
    [viewer.sharpness, this.fresh] = [wanted, false];
    if (this.late) this.late = 1 / 60;
  }

  // Put everything where it is now; drawing comes after.
  update(): void {
    this.viewer.keepFree(this.overlays.has("forces"));
    const was = this.following ? this.centre() : undefined;
    const swing = this.swinging ? 0.35 * (1 - Math.cos((2 * Math.PI * this.swingTime) / SWINGING)) / 2 : 0;
    const { stages } = this.viewer;
    stages.forEach((stage, place) => {
      const other = stages.length > 1 ? stages[1 - place].run : undefined;
      const [picked, hovered] = [this.picked, this.hovered].map((one) => (one?.[0] === place ? one[1] : undefined));
      const { time, seen: mode, overlays, which, xray, top } = this;
      stage.update({ time, mode, overlays, which, xray, top, swing, picked, hovered }, (point) => this.viewer.toEye(point), other, other && placesOf(other));
    });
    const is = this.following ? this.centre() : undefined;
    if (was && is) this.viewer.shift(is.sub(was));
  }

  private centre(): Vector3 | undefined {
    return this.picked && this.viewer.stages[this.picked[0]].drawn(this.picked[1]);
  }
}

// What two runs are called beside each other: by what differs of scenario, variables and system.
export function shortNames(runs: Run[]): string[] {
  if (runs.some((run) => run.told.marks)) return runs.map((run) => (run.told.marks ? "golden file" : "this run"));
  const parts = runs.map((run) => run.told.name.replace(/\]$/, "").split(/[[,]/)); // scenario, variables, system
  const own = parts.map((of) => of.filter((part) => !parts.every((other) => other.includes(part))).join(", "));
  return own.includes("") ? runs.map((run) => run.told.name) : own;
}

const known = new WeakMap<Run, Map<string, number>>();

function placesOf(run: Run): Map<string, number> {
  const found = known.get(run) ?? new Map(run.told.bricks.name.map((name, brick) => [name, brick]));
  known.set(run, found);
  return found;
}
