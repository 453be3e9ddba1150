// What the lanes of the line of time show of one run, or of two.
import type { Told } from "./payload";
import type { Run } from "./run";
import { eventText, failedToStand, howMany, isThrown, names } from "./wording";

export interface Mark {
  time: number; // [s]
  kind: string; // of its event
  icon: string;
  text: string;
  bad: boolean;
}

export interface Span {
  begin: number; // [s]
  end: number; // [s]
  kind: "proven" | "judged" | "moves";
  texts: string[]; // the longest that there is room for is shown
}

export interface Lane {
  name: string;
  marks: Mark[];
  spans: Span[];
}

// Bricks that are set down one after the other before anything else happens.
export interface Build {
  count: number; // bricks
  last: number; // when the last of them is set down [s]
  end: number; // just before what comes next is done [s]
}

const ICONS: Record<string, string> = {
  placed: "set-down",
  removed: "pulled-out",
  loaded: "motion",
  pushed: "motion",
  shaken: "motion",
  taken: "pulled-out",
  "let go": "set-down",
  joined: "joints",
  set: "joints",
  cut: "joints",
  hit: "motion",
};
export const TOGETHER: Record<string, string> = {
  placed: "set down",
  removed: "pulled out",
  loaded: "loaded",
  pushed: "pushed",
  shaken: "shakes",
  taken: "taken",
  "let go": "let go",
  joined: "joined",
  set: "mortar sets",
  cut: "joints cut",
  hit: "hits",
};
const SAME = 1e-6; // [s]
const LONG = 0.4; // share of a run from which on its build is a long one
const BEFORE = 0.15; // time that is shown before what comes next, of the time that follows
const STEPS = 3; // times at which bricks are set down: fewer are no build
const ORDINARY = new Set(["placed", "frozen", "woken"]); // what happens while it is built

export function lanesOf(runs: Run[], names: string[]): Lane[] {
  const busiest = runs.reduce((most, run) => (hands(run).length > hands(most).length ? run : most), runs[0]);
  const lanes: Lane[] = [{ name: "Hands", marks: hands(busiest), spans: [] }];
  if (runs.length === 1) {
    lanes.push({ name: "Moves", marks: [], spans: moves(runs[0]) }, { name: "Proof", marks: [], spans: proofs(runs[0]) });
  } else {
    const own = runs.flatMap((run, place) => (run.told.marks ? [] : [{ name: names[place], marks: [], spans: both(run) }])); // a golden file has no motion
    lanes.push(...own);
  }
  const claims = runs.flatMap((run, place) => (run.told.marks ? [] : claimMarks(run, runs.length > 1 ? `${names[place]}: ` : "")));
  if (claims.length) lanes.push({ name: "Claims", marks: claims.sort((one, other) => one.time - other.time), spans: [] });
  return lanes;
}

// The build, if it is so long that what follows would be squeezed beside it.
export function buildOf(runs: Run[], end: number): Build | undefined {
  const played = runs.filter((run) => !run.told.marks);
  const builds = (run: Run, event: Told): boolean => event.kind === "placed" && !isThrown(run, event);
  const events = played.flatMap((run) => run.told.events);
  const odd = played.flatMap((run) => run.told.events.filter((event) => !ORDINARY.has(event.kind) || isThrown(run, event)));
  const happens = Math.min(...odd.map((event) => event.time), ...played.map((run) => run.told.fall?.time ?? Infinity));
  // The last action before an event may be its cause, so it is not joined with the build.
  const cause = Math.max(...events.filter((event) => event.kind in ICONS && event.time <= happens + SAME).map((event) => event.time));
  const placed = played.reduce<Told[]>((most, run) => {
    const its = run.told.events.filter((event) => builds(run, event) && event.time < cause - SAME);
    return its.length > most.length ? its : most;
  }, []);
  const times = [...new Set(placed.map((event) => event.time))];
  if (happens === Infinity || times.length < STEPS) return undefined;
  const last = times[times.length - 1];
  const until = Math.max(last, cause - BEFORE * (end - cause));
  return until > LONG * end ? { count: new Set(placed.flatMap((event) => event.bricks)).size, last, end: until } : undefined;
}

function hands(run: Run): Mark[] {
  return run.told.events
    .filter((event) => event.kind in ICONS)
    .map((event) => ({ time: event.time, kind: event.kind, icon: isThrown(run, event) ? ICONS.hit : ICONS[event.kind], text: handText(run, event), bad: false }));
}

function handText(run: Run, event: Told): string {
  if (event.kind === "shaken") return "shaken";
  if (event.kind === "hit") return eventText(run, event);
  if (event.bricks.length > 1) return event.kind === "placed" && event.time === 0 ? "built" : `${event.bricks.length} ${TOGETHER[event.kind]}`;
  return names(run, event.bricks, event.time);
}

function claimMarks(run: Run, who: string): Mark[] {
  const { told, end, events } = run.told;
  const fell = events.find((event) => event.kind === "collapsed");
  const marks: Mark[] = [];
  const stands = fell && failedToStand(run); // this claim fails with the fall, and others at the end
  if (fell) marks.push({ time: fell.time, kind: "collapsed", icon: stands ? "failed" : "how-it-falls", text: `${who}falls${stands ? ", claim fails" : ""}`, bad: stands !== undefined });
  const failed = told.claims.filter((claim) => !claim.passed && claim !== stands).length;
  const fails = failed > 1 ? `${failed} claims fail` : "claim fails";
  if (told.status === "failed" && (failed || !stands)) marks.push({ time: end, kind: "collapsed", icon: "failed", text: who + fails, bad: true });
  return marks;
}

function moves(run: Run): Span[] {
  const { events, bricks } = run.told;
  const own = run.moving.filter((brick) => !bricks.thrown[brick]);
  const thrown = run.moving.filter((brick) => bricks.thrown[brick]);
  const starts = events.filter((event) => event.kind === "woken");
  const structure = run.motions(own).map(([begin, end]): Span => {
    const during = starts.filter((event) => event.time >= begin - 0.01 && event.time <= end);
    const hit = events.find((event) => event.kind === "hit" && event.time >= begin - 0.01 && event.time <= end);
    const first = hit ?? during[0];
    const count = run.movers(own, begin, end).length;
    return { begin, end, kind: "moves", texts: [first && 2 * first.bricks.length > count ? eventText(run, first) : "", count ? `${howMany(count, "brick")} move` : "", count ? String(count) : ""] };
  });
  // What flies to the structure, or rolls away from it, while nothing of it moves.
  const others = run.motions(thrown).flatMap(([begin, end]) => without({ begin, end, kind: "moves", texts: [] }, structure));
  const told = others.map((span): Span => {
    const who = run.movers(thrown, span.begin, span.end);
    return { ...span, texts: [`only ${names(run, who, span.begin)} ${who.length === 1 ? "moves" : "move"}`, names(run, who, span.begin), ""] };
  });
  return [...structure, ...told].sort((one, other) => one.begin - other.begin);
}

// When all that is there is proven to stand, or else judged to be stable by the system.
function proofs(run: Run): Span[] {
  const shown = run.proofs.flatMap(({ proof }) => {
    const end = proof.end ?? run.told.end;
    const known = new Set(proof.bricks);
    const later = run.told.events.find((event) => event.kind === "placed" && event.time > proof.begin + SAME && event.time < end && event.bricks.some((brick) => !known.has(brick)));
    const parts = later ? [[proof.begin, later.time], [later.time, end]] : [[proof.begin, end]]; // of all that is there, and from then on of some
    return parts.map(([begin, end]) => {
      const there = run.told.bricks.name.filter((_, brick) => run.isThere(brick, begin + SAME)).length;
      const whole = proof.bricks.length >= there;
      const texts = whole ? provenTexts(run, proof.bricks, begin) : [`${proof.bricks.length} of ${there} proven to stand`, "some proven", ""];
      return { whole, span: { begin, end, kind: "proven", texts } as Span };
    });
  });
  const told = frozen(run);
  const proven = together([...shown.filter(({ whole }) => whole).map(({ span }) => span), ...told.filter((span) => span.kind === "proven")]);
  const judged = together(told.filter((span) => span.kind === "judged").flatMap((span) => without(span, proven)));
  const some = together(shown.filter(({ whole }) => !whole).flatMap(({ span }) => without(span, [...proven, ...judged])));
  return [...proven, ...judged, ...some].sort((one, other) => one.begin - other.begin);
}

// When no brick is awake, from the events; a reason names a proof, and a system that only judges gives none.
function frozen(run: Run): Span[] {
  const { events, end } = run.told;
  const state = new Map<number, boolean>(); // of what is there: whether it is frozen, and by a proof
  let awake = 0;
  let judged = 0;
  let since = 0;
  const spans: Span[] = [];
  const drop = (brick: number): void => {
    const was = state.get(brick);
    if (was === undefined) awake--;
    else if (!was) judged--;
    state.delete(brick);
  };
  const there = new Set<number>();
  events.forEach((event, place) => {
    for (const brick of [...event.bricks, ...event.riding]) {
      if (event.kind === "placed" && !there.has(brick)) there.add(brick), awake++;
      else if (event.kind === "removed" && there.delete(brick)) drop(brick);
      else if (there.has(brick) && (event.kind === "frozen" || event.kind === "woken")) {
        drop(brick);
        if (event.kind === "woken") awake++;
        else if ((state.set(brick, event.reason !== ""), event.reason === "")) judged++;
      }
    }
    const next = place + 1 < events.length ? events[place + 1].time : end;
    since = event.time;
    if (awake > 0 || !there.size || next <= since + SAME) return;
    spans.push(judged ? { begin: since, end: next, kind: "judged", texts: ["judged stable, not proven", "judged", ""] } : { begin: since, end: next, kind: "proven", texts: provenTexts(run, [...there], since) });
  });
  return spans;
}

// What bricks that all are at rest by proof do: those that fell, or were thrown, lie somewhere.
function provenTexts(run: Run, bricks: number[], time: number): string[] {
  const lie = bricks.filter((brick) => run.isAway(brick, time)).length;
  const stand = bricks.length - lie;
  return lie ? [`${stand} proven to stand, ${lie} ${lie === 1 ? "lies" : "lie"} at rest`, `${stand} stand, ${lie} ${lie === 1 ? "lies" : "lie"}`, ""] : ["all bricks proven to stand", "all proven", ""];
}

function both(run: Run): Span[] {
  const moving = moves(run);
  return [...proofs(run).flatMap((span) => without(span, moving)), ...moving].sort((one, other) => one.begin - other.begin);
}

// Spans that touch, as one; of their texts those of the longest.
function together(spans: Span[]): Span[] {
  const found: Span[] = [];
  for (const span of [...spans].sort((one, other) => one.begin - other.begin)) {
    const last = found[found.length - 1];
    if (!last || span.begin > last.end + 1e-3) found.push({ ...span });
    else {
      if (span.end - span.begin > last.end - last.begin) last.texts = span.texts;
      last.end = Math.max(last.end, span.end);
    }
  }
  return found;
}

// What of a span is in none of others.
function without(span: Span, others: Span[]): Span[] {
  let left = [span];
  for (const { begin, end } of others) {
    left = left.flatMap((one) => [
      ...(begin > one.begin ? [{ ...one, end: Math.min(one.end, begin) }] : []),
      ...(end < one.end ? [{ ...one, begin: Math.max(one.begin, end) }] : []),
    ]);
    left = left.filter((one, place) => one.end > one.begin + SAME && left.findIndex((other) => other.begin === one.begin && other.end === one.end) === place);
  }
  return left;
}
