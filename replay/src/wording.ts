// What is said of bricks, times and events.
import type { Claim, Told } from "./payload";
import { type Run, State } from "./run";

export const WORDS: Record<State, string> = {
  [State.Absent]: "not there",
  [State.Awake]: "moves",
  [State.Free]: "simulated, at rest",
  [State.Riding]: "rides on another",
  [State.Proven]: "stands",
  [State.Fallen]: "has fallen",
  [State.Thrown]: "thrown or dropped",
};
const MOST = 6; // names or ranges that are written out
const SHORTEST = 3; // names of a range
const ranks = new WeakMap<Run, number[]>();

export function seconds(time: number): string {
  return `${time.toFixed(3)} s`;
}

export function howMany(count: number, noun: string): string {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}

export function threeDigits(value: number): string {
  return String(+value.toPrecision(3));
}

// A force in the one unit that suits the largest of those that are shown together.
export function newtons(most: number): { unit: string; text(force: number): string } {
  const [factor, unit] = most < 0.1 ? [1000, "mN"] : most < 1000 ? [1, "N"] : most < 1e6 ? [1e-3, "kN"] : [1e-6, "MN"];
  return { unit, text: (force) => `${threeDigits(force * factor)} ${unit}` };
}

// Names of bricks as in all reports (stability/name_order.py): runs of bricks named by level and place, or by a number, are ranges,
// which stand for all bricks that are there from the first to the last.
export function names(run: Run, bricks: number[], time: number): string {
  const { name } = run.told.bricks;
  const order = ranks.get(run) ?? name.map((_, brick) => brick).sort((one, other) => inOrder(name[one], name[other]));
  ranks.set(run, order);
  const meant = new Set(bricks);
  const runs: string[][] = [];
  let before: number | undefined;
  for (const brick of order) {
    if (!meant.has(brick) && !run.isThere(brick, time)) continue;
    const follows = before !== undefined && meant.has(before) && groupOf(name[brick]) !== undefined && groupOf(name[brick]) === groupOf(name[before]);
    if (meant.has(brick)) follows ? runs[runs.length - 1].push(name[brick]) : runs.push([name[brick]]);
    before = brick;
  }
  const items = runs.flatMap((of) => (of.length < SHORTEST ? of.map((one) => [one]) : [of]));
  const leftOut = items.slice(MOST).flat().length;
  const shown = leftOut > 1 ? items.slice(0, MOST) : items;
  return shown.map((of) => rangeText(of, items.length === 1)).join(", ") + (shown.length < items.length ? ` and ${leftOut} more` : "");
}

// The order of names, in which L2.1 comes before L10.1, and capitals come first.
function inOrder(one: string, other: string): number {
  const [parts, others] = [one.split(/(\d+)/), other.split(/(\d+)/)]; // letters and numbers alternate
  for (let at = 0; at < Math.min(parts.length, others.length); at++) {
    const [part, its] = [parts[at], others[at]];
    if (at % 2 ? Number(part) !== Number(its) : part !== its) return at % 2 ? Number(part) - Number(its) : part < its ? -1 : 1;
  }
  return parts.length - others.length || (one < other ? -1 : 1);
}

// A run; its number of bricks is told where a reader cannot count them from the names.
function rangeText(of: string[], alone: boolean): string {
  if (of.length === 1) return of[0];
  const inTurn = of.slice(1).every((name, before) => name === nextName(of[before]));
  return `${of[0]} to ${of[of.length - 1]}${alone || !inTurn ? ` (${howMany(of.length, "brick")})` : ""}`;
}

// What the names of a range have in common: `east.L.` of `east.L2.1`, `C` of `C007`.
function groupOf(name: string): string | undefined {
  const place = /^(.*)L\d+\.\d+$/.exec(name);
  return place ? `${place[1]}L.` : /^(.*?\D)\d+$/.exec(name)?.[1];
}

// The next name of a level, or else of a count: `L2.2` after `L2.1`, `C010` after `C009`.
function nextName(name: string): string {
  const [, stem, number] = /^(.*?\D)(\d+)$/.exec(name) ?? ["", "", ""];
  return `${stem}${String(Number(number) + 1).padStart(number.length, "0")}`;
}

// True for a brick that is thrown or dropped rather than set down.
export function isThrown(run: Run, event: Told): boolean {
  return event.kind === "placed" && event.bricks.length > 0 && event.bricks.every((brick) => run.told.bricks.thrown[brick]);
}

// An event as a sentence.
export function eventText(run: Run, event: Told): string {
  const who = names(run, event.bricks, event.time);
  const one = event.bricks.length === 1;
  const is = one ? "is" : "are";
  switch (event.kind) {
    case "placed":
      return `${who} ${is} ${event.reason}`;
    case "removed":
      return `${who} ${is} pulled out`;
    case "loaded":
      return `${who} ${is} loaded`;
    case "pushed":
      return `${who} ${is} pushed`;
    case "shaken":
      return "the ground is shaken";
    case "taken":
      return `a hand takes ${who}`;
    case "let go":
      return `a hand lets go of ${who}`;
    case "joined":
      return `${who} ${is} joined`;
    case "set":
      return `the joints of ${who} have set`;
    case "cut":
      return `the joints of ${who} are cut`;
    case "hit":
      return event.reason || `${who} hits the structure`; // before a run, only the planned time is known
    case "woken":
      return wokenText(event.reason, who, one);
    case "frozen":
      if (event.bricks.every((brick) => run.isAway(brick, event.time))) return `${who} ${one ? "lies" : "lie"} at rest`;
      return `${who} ${one ? "stands" : "stand"}${event.reason ? ", proven" : ", judged stable"}`;
    case "opened": // such as `joint of L1.1 and L2.1`
      return `${event.reason} ${event.reason.startsWith("joints") ? "open" : "opens"}`;
    case "crushed":
      return `${who} crushes: ${event.reason}`;
    case "collapsed":
      return `${event.reason.split(";")[0]}${failedToStand(run) ? ": the claim fails" : ""}`;
    default:
      return `${event.kind} ${who}`;
  }
}

// That bricks begin to move, and why: the reason often names another brick, such as the one of them that is hit.
function wokenText(reason: string, who: string, one: boolean): string {
  const moves = `${who} ${one ? "moves" : "move"}`;
  // Bricks wake ahead of a hit, which may miss them, and do not move yet.
  if (reason.includes(" would hit ")) return `${reason.split(/: |; /)[0]}; ${who} ${one ? "is" : "are"} simulated`;
  if (reason.includes(" than its proof allows")) return `${who} ${one ? "is" : "are"} also simulated: ${reason}`;
  if (!reason || reason.includes("; ")) return moves;
  return reason.startsWith(`${who} `) ? reason : `${moves}: ${reason}`;
}

// The claim that all stand, if it fails.
export function failedToStand(run: Run): Claim | undefined {
  return run.told.told.claims.find((claim) => claim.name === "stands" && !claim.passed);
}
