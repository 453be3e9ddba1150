// What is said of bricks, times and events.
import type { Claim, Told } from "./payload";
import { type Run, State } from "./run";

export const WORDS: Record<State, string> = {
  [State.Absent]: "not there",
  [State.Awake]: "moves",
  [State.Riding]: "rides on another",
  [State.Proven]: "stands",
  [State.Fallen]: "has left its place",
  [State.Thrown]: "thrown or dropped",
};
const MOST = 4; // names that are written out
const IN_ORDER = new Intl.Collator("en", { numeric: true }).compare;
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

// Names of bricks: a range if no other brick that is there at the time is among them.
export function names(run: Run, bricks: number[], time: number): string {
  const { name } = run.told.bricks;
  const order = ranks.get(run) ?? name.map((_, brick) => brick).sort((one, other) => IN_ORDER(name[one], name[other]));
  ranks.set(run, order);
  const meant = new Set(bricks);
  const sorted = order.filter((brick) => meant.has(brick));
  if (sorted.length <= MOST) return sorted.map((brick) => name[brick]).join(", ");
  const [first, last] = [sorted[0], sorted[sorted.length - 1]];
  const between = order.slice(order.indexOf(first), order.indexOf(last) + 1);
  if (between.every((brick) => meant.has(brick) || !run.isThere(brick, time))) return `${name[first]} to ${name[last]} (${howMany(sorted.length, "brick")})`;
  return `${sorted.slice(0, MOST - 1).map((brick) => name[brick]).join(", ")} and ${sorted.length - MOST + 1} more`;
}

// True for a brick that is thrown or dropped rather than set down.
export function isThrown(run: Run, event: Told): boolean {
  return event.kind === "placed" && event.bricks.length > 0 && event.bricks.every((brick) => run.told.bricks.thrown[brick]);
}

// An event as a person would say it.
export function eventText(run: Run, event: Told): string {
  const who = names(run, event.bricks, event.time);
  switch (event.kind) {
    case "placed":
      return `${who} ${event.reason}`;
    case "removed":
      return `${who} pulled out`;
    case "pushed":
      return `${who} pushed`;
    case "shaken":
      return "the ground is shaken";
    case "taken":
      return `a hand takes ${who}`;
    case "let go":
      return `a hand lets go of ${who}`;
    case "hit":
      return `${who} hits`;
    case "woken":
      return event.reason.includes(" hit by ") || !event.reason ? `${who} ${event.bricks.length === 1 ? "moves" : "move"}, hit by others` : shortReason(run, event);
    case "frozen":
      return `${who} ${event.bricks.length === 1 ? "stands" : "stand"}${event.reason ? ", proven" : ", judged stable"}`;
    case "collapsed":
      return `${who} has left its place${failedToStand(run) ? ": the claim fails" : ""}`;
    default:
      return `${event.kind} ${who}`;
  }
}

// The reason of a fall with its bricks named as a range.
function shortReason(run: Run, event: Told): string {
  const verb = /^.+? ((?:tip|slide|fall|turn|rise|lose|roll)s? .+)$/.exec(event.reason);
  return verb ? `${names(run, event.bricks, event.time)} ${verb[1]}` : event.reason;
}

// The claim that all stand, if it fails.
export function failedToStand(run: Run): Claim | undefined {
  return run.told.told.claims.find((claim) => claim.name === "stands" && !claim.passed);
}
