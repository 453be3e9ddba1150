// The line of time: lanes with names, marks that are joined where they touch, an axis, and the place of now.
import { type Lane, lanesOf, type Mark, type Span, TOGETHER } from "./lanes";
import { icon, part, widthOf } from "./page";
import type { Told } from "./payload";
import type { Run } from "./run";
import { seconds } from "./wording";

const KINDS = new Set(["placed", "removed", "pushed", "shaken", "taken", "let go", "hit", "woken", "collapsed"]);
const NEAR = 6; // [px] within which a click means a mark
const GAP = 8; // [px] between two marks
const ICON = 18; // [px] with the space to its text
const TICK = 76; // [px] between two times of the axis, at least

// Marks that are shown as one.
interface Group {
  marks: Mark[];
  alike: boolean; // whether all say the same
  kind: string; // of all; empty if they differ
  left: number; // [px]
  right: number;
  text: string;
  turned: boolean; // whether the text is to the left of the icon
}

export class Timeline {
  readonly element = part("div", { class: "lanes" });
  end = 1; // [s]
  events: Told[] = []; // of the first run
  private readonly head = part("div", { class: "head" });
  private lanes: Lane[] = [];
  private width = 0;

  constructor(private readonly go: (time: number) => void) {
    const { element } = this;
    element.tabIndex = 0;
    element.setAttribute("role", "slider");
    element.setAttribute("aria-label", "time");
    let held = false;
    element.addEventListener("pointerdown", (event) => {
      held = true;
      element.setPointerCapture(event.pointerId);
      this.go(this.meant(this.within(event)));
    });
    element.addEventListener("pointermove", (event) => held && this.go(this.timeAt(this.within(event))));
    for (const name of ["pointerup", "pointercancel"]) element.addEventListener(name, () => (held = false));
  }

  // Show one run, or two that have these names.
  show(runs: Run[], names: string[]): void {
    this.end = Math.max(...runs.map((run) => run.told.end), 1e-3);
    this.events = runs[0].told.events;
    this.lanes = lanesOf(runs, names);
    this.width = 0;
  }

  // The event before a time, or after it.
  step(time: number, way: -1 | 1): Told | undefined {
    const told = this.events.filter((event) => KINDS.has(event.kind) && (event.time - time) * way > 1e-6);
    return way > 0 ? told[0] : told[told.length - 1];
  }

  draw(time: number): void {
    const width = this.element.clientWidth;
    if (width !== this.width) this.arrange(width);
    this.head.style.left = `${this.placeOf(time)}px`;
    this.element.setAttribute("aria-valuenow", time.toFixed(3));
    this.element.setAttribute("aria-valuetext", `${seconds(time)} of ${seconds(this.end)}`);
    this.element.setAttribute("aria-valuemin", "0");
    this.element.setAttribute("aria-valuemax", this.end.toFixed(3));
  }

  // Where a time is [px].
  placeOf(time: number): number {
    return (time / this.end) * this.element.clientWidth;
  }

  private arrange(width: number): void {
    this.width = width;
    const lanes = this.lanes.map((lane) => {
      const marks = this.grouped(lane.marks, width).map((group) => this.marked(group));
      const ticks = lane.marks.length > 1 ? [this.ticked(lane.marks)] : [];
      return part("div", { class: "lane" }, part("span", { class: "name", text: lane.name }), ...lane.spans.map((span, place) => this.spanned(span, lane.spans[place + 1])), ...ticks, ...marks);
    });
    this.element.replaceChildren(...lanes, this.axis(width), this.head);
  }

  // Marks from the left on; where two would touch they are joined, and the joined one may touch the one before.
  private grouped(marks: Mark[], width: number): Group[] {
    const roomy = marks.length * ICON < width;
    const timed = roomy ? marks.map((mark) => this.group([mark], true, mark.kind, width, true)) : [];
    if (roomy && timed.every((group, place) => !place || timed[place - 1].right + GAP <= group.left)) return timed;
    const found: Group[] = [];
    for (const mark of marks) {
      let next = this.group([mark], true, mark.kind, width, false);
      while (found.length && found[found.length - 1].right + GAP > next.left) {
        const before = found.pop()!;
        const alike = before.alike && next.alike && before.marks[0].text === next.marks[0].text;
        const kind = before.kind === next.kind ? before.kind : "";
        for (const one of next.marks) before.marks.push(one);
        next = this.group(before.marks, alike, kind, width, false);
      }
      found.push(next);
    }
    return found;
  }

  private group(marks: Mark[], alike: boolean, kind: string, width: number, timed: boolean): Group {
    const [first, last] = [marks[0], marks[marks.length - 1]];
    const [from, to] = [this.placeOf(first.time), this.placeOf(last.time)];
    const text = marks.length > 1 ? joined(marks, alike, kind) : timed ? `${first.text}, ${+first.time.toFixed(3)} s` : first.text;
    const wide = ICON + widthOf(text) + 2;
    const turned = from - NEAR + wide > width;
    const left = Math.max(0, turned ? Math.min(from + NEAR - wide, from - NEAR) : from - NEAR);
    return { marks, alike, kind, text, turned, left, right: Math.max(to + NEAR, turned ? from + NEAR : left + wide) };
  }

  private marked({ marks, text, turned, left, right }: Group): HTMLElement {
    const one = marks[0];
    const bad = marks.some((mark) => mark.bad);
    const found = part("span", { class: `mark${bad ? " bad" : ""}${turned ? " turned" : ""}` }, icon(bad ? "failed" : one.icon), part("span", { text }));
    found.title = marks.slice(0, 12).map((mark) => `${seconds(mark.time)}: ${mark.text}`).concat(marks.length > 12 ? [`and ${marks.length - 12} more`] : []).join("\n");
    found.style.left = `${left}px`;
    if (marks.length > 1) found.style.width = `${right - left}px`;
    return found;
  }

  // A line at each of many times, so that none is lost where marks are joined.
  private ticked(marks: Mark[]): HTMLElement {
    const found = part("span", { class: "ticks" });
    const places = new Set(marks.map((mark) => Math.round(this.placeOf(mark.time))));
    found.append(
      ...[...places].map((place) => {
        const tick = part("i");
        tick.style.left = `${place}px`;
        return tick;
      }),
    );
    return found;
  }

  // A span with the longest text that fits into it, or else beside it before the next one.
  private spanned(span: Span, next: Span | undefined): HTMLElement {
    const [left, right] = [this.placeOf(span.begin), this.placeOf(Math.min(span.end, this.end))];
    const wide = Math.max(2, right - left);
    const beside = (next ? this.placeOf(next.begin) : this.element.clientWidth) - right - GAP;
    const inside = span.texts.find((text) => text && widthOf(text) + 14 <= wide) ?? "";
    const after = inside ? "" : (span.texts.find((text) => text && widthOf(text) + GAP <= beside) ?? "");
    const found = part("span", { class: `span ${span.kind}` }, part("span", { class: after ? "after" : "", text: inside || after }));
    found.title = `${seconds(span.begin)} to ${seconds(span.end)}: ${span.texts[0] || span.kind}`;
    found.style.left = `${left}px`;
    found.style.width = `${wide}px`;
    return found;
  }

  private axis(width: number): HTMLElement {
    const least = (this.end * TICK) / Math.max(width, TICK);
    const power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((one) => one >= least) ?? 10 * power;
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const found = part("div", { class: "axis" });
    for (let number = 0; number * step <= this.end * (1 + 1e-9); number++) {
      const place = this.placeOf(number * step);
      const text = number === 0 ? "0 s" : (number * step).toFixed(digits);
      const tick = part("span", { text });
      tick.className = place < 12 ? "first" : place > width - 16 ? "last" : "";
      tick.style.left = `${place}px`;
      found.append(tick);
    }
    return found;
  }

  private within(event: PointerEvent): number {
    return event.clientX - this.element.getBoundingClientRect().left;
  }

  private timeAt(x: number): number {
    return Math.min(this.end, Math.max(0, (x / this.element.clientWidth) * this.end));
  }

  private meant(x: number): number {
    let [nearest, found] = [NEAR, this.timeAt(x)];
    for (const event of this.events) {
      const away = Math.abs(this.placeOf(event.time) - x) + (event.kind === "collapsed" ? 0 : 0.5);
      if (KINDS.has(event.kind) && away < nearest) [nearest, found] = [away, event.time];
    }
    return found;
  }
}

function joined(marks: Mark[], alike: boolean, kind: string): string {
  if (alike) return marks[0].text;
  if (kind === "collapsed") return marks.map((mark) => mark.text).join("; ");
  return kind ? `${marks.length} ${TOGETHER[kind]}` : `${marks.length} actions`;
}
