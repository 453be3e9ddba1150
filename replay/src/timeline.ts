// The line of time: lanes with names, marks that are joined where they touch, an axis, and the place of now. A long build takes a
// small part of it, which is told apart.
import { type Build, buildOf, type Lane, lanesOf, type Mark, type Span, TOGETHER } from "./lanes";
import { icon, part, widthOf } from "./page";
import type { Told } from "./payload";
import type { Run } from "./run";
import { howMany, seconds } from "./wording";

const KINDS = new Set(["placed", "removed", "loaded", "pushed", "shaken", "taken", "let go", "joined", "set", "cut", "hit", "woken", "collapsed"]);
const NEAR = 6; // [px] within which a click means a mark
const GAP = 8; // [px] between two marks
const ICON = 18; // [px] with the space to its text
const TICK = 76; // [px] between two times of the axis, at least
const BUILD = [0.12, 0.4]; // share of the width that a build takes which is drawn shorter, at least and at most
const BUILDING = 4; // [s] that such a build plays for at most

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
  private build: Build | undefined; // if it is drawn shorter
  private width = 0;
  private across = new Scale([[0, 0], [1, 1]]); // from times to places [px]
  private pace = new Scale([[0, 0], [1, 1]]); // from times to how long it plays until then [s]

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
    this.build = buildOf(runs, this.end);
    this.lanes = lanesOf(runs, names);
    this.width = 0;
    const { build, end } = this;
    const short = build ? Math.min(build.end, BUILDING) : 0;
    this.pace = new Scale(build ? [[0, 0], [build.end, short], [end, short + end - build.end]] : [[0, 0], [end, end]]);
    this.measure(this.element.clientWidth);
  }

  // The time that comes so long after another one while it plays, or before it [s].
  later(time: number, by: number): number {
    return this.pace.back(this.pace.of(time) + by);
  }

  // Factor on the chosen speed at a time.
  fasterAt(time: number): number {
    return this.build && time < this.build.end ? this.build.end / this.pace.of(this.build.end) : 1;
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
    return this.across.of(time);
  }

  private measure(width: number): void {
    const { build, end } = this;
    const wide = build ? Math.min(BUILD[1] * width, Math.max(BUILD[0] * width, ICON + widthOf(builtText(build)) + 2 * GAP)) : 0;
    this.across = new Scale(build ? [[0, 0], [build.end, wide], [end, width]] : [[0, 0], [end, width]]);
  }

  private arrange(width: number): void {
    this.width = width;
    this.measure(width);
    const lanes = this.lanes.map((lane) => {
      const marks = this.grouped(lane.marks, width).map((group) => this.marked(group));
      const timed = lane.marks.filter((mark) => !this.isBuilt(mark));
      const ticks = lane.marks.length > 1 ? [this.ticked(timed)] : [];
      return part("div", { class: "lane" }, part("span", { class: "name", text: lane.name }), ...lane.spans.map((span, place) => this.spanned(span, lane.spans[place + 1])), ...ticks, ...marks);
    });
    this.element.replaceChildren(...this.shortened(), ...lanes, this.axis(width), this.head);
  }

  // The part of the line that is drawn shorter, behind all lanes, and where it breaks.
  private shortened(): HTMLElement[] {
    const { build } = this;
    if (!build) return [];
    const faster = this.fasterAt(0);
    const [back, crack] = [part("div", { class: "built" }), part("div", { class: "break" })];
    back.style.width = crack.style.left = `${this.placeOf(build.end)}px`;
    crack.title = `The scale changes here: the build, ${howMany(build.count, "brick")} in ${seconds(build.last)}, is drawn shorter${faster > 1.05 ? ` and plays ${faster.toPrecision(2)} times as fast` : ""}.`;
    return [back, crack];
  }

  private isBuilt(mark: Mark): boolean {
    return mark.kind === "placed" && this.build !== undefined && mark.time <= this.build.last;
  }

  // Marks from the left on; where two would touch they are joined, and the joined one may touch the one before.
  private grouped(all: Mark[], width: number): Group[] {
    const built = all.filter((mark) => this.isBuilt(mark));
    const marks = all.slice(built.length);
    const first = built.length ? [this.group(built, false, "placed", width, false)] : [];
    const roomy = marks.length * ICON < width;
    const timed = roomy ? [...first, ...marks.map((mark) => this.group([mark], true, mark.kind, width, true))] : [];
    if (roomy && timed.every((group, place) => !place || timed[place - 1].right + GAP <= group.left)) return timed;
    const found: Group[] = first;
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
    const text = this.build && kind === "placed" && this.isBuilt(last) ? builtText(this.build) : marks.length > 1 ? joined(marks, alike, kind) : timed ? `${first.text}, ${+first.time.toFixed(3)} s` : first.text;
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

  // A span with the longest text that fits into it, or else beside it before the next one; the text is not over the break.
  private spanned(span: Span, next: Span | undefined): HTMLElement {
    const [left, right] = [this.placeOf(span.begin), this.placeOf(Math.min(span.end, this.end))];
    const wide = Math.max(2, right - left);
    const crack = this.build ? this.placeOf(this.build.end) : -Infinity;
    const [before, behind] = crack > left && crack < right ? [crack - left - GAP, right - crack - GAP] : [wide, 0];
    const fits = Math.max(before, behind);
    const beside = (next ? this.placeOf(next.begin) : this.element.clientWidth) - right - GAP;
    const inside = span.texts.find((text) => text && widthOf(text) + 14 <= fits) ?? "";
    const after = inside ? "" : (span.texts.find((text) => text && widthOf(text) + GAP <= beside) ?? "");
    const text = part("span", { class: after ? "after" : "", text: inside || after });
    if (inside && behind > before) text.style.marginLeft = `${wide - behind}px`;
    const found = part("span", { class: `span ${span.kind}` }, text);
    found.title = `${seconds(span.begin)} to ${seconds(span.end)}: ${span.texts.find(Boolean) ?? span.kind}`;
    found.style.left = `${left}px`;
    found.style.width = `${wide}px`;
    return found;
  }

  private axis(width: number): HTMLElement {
    const begin = this.build?.end ?? 0;
    const from = this.placeOf(begin);
    const least = ((this.end - begin) * TICK) / Math.max(width - from, TICK);
    const power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((one) => one >= least) ?? 10 * power;
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const found = part("div", { class: "axis" });
    const add = (place: number, text: string): void => {
      const tick = part("span", { text });
      tick.className = place < 12 ? "first" : place > width - 16 ? "last" : "";
      tick.style.left = `${place}px`;
      found.append(tick);
    };
    add(0, "0 s");
    for (let number = Math.floor(begin / step) + 1; number * step <= this.end * (1 + 1e-9); number++) {
      const place = this.placeOf(number * step);
      if (!this.build || place > from + TICK / 4) add(place, (number * step).toFixed(digits));
    }
    return found;
  }

  private within(event: PointerEvent): number {
    return event.clientX - this.element.getBoundingClientRect().left;
  }

  private timeAt(x: number): number {
    return Math.min(this.end, Math.max(0, this.across.back(x)));
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

function builtText({ count }: Build): string {
  return `build: ${howMany(count, "brick")}`;
}

// A scale in pieces, each of which is even.
class Scale {
  constructor(private readonly knots: [number, number][]) {}

  of(value: number): number {
    return this.along(value, 0, 1);
  }

  back(value: number): number {
    return this.along(value, 1, 0);
  }

  private along(value: number, from: 0 | 1, to: 0 | 1): number {
    const { knots } = this;
    const next = knots.findIndex((knot, place) => place > 0 && value < knot[from]);
    const [low, high] = next < 0 ? knots.slice(-2) : [knots[next - 1], knots[next]];
    return low[to] + ((value - low[from]) * (high[to] - low[to])) / Math.max(high[from] - low[from], 1e-12);
  }
}
