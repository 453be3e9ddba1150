// What a brick is coloured by.
import { Color } from "three";
import { colourOf } from "./page";
import { type Run, State } from "./run";
import { WORDS } from "./wording";

export type Mode = "state" | "level" | "room" | "load" | "stage" | "material" | "joints" | "strength";
export const MODES: Mode[] = ["state", "level", "room", "load", "stage", "material", "joints", "strength"];

const STATES: [State, string, string][] = [
  [State.Proven, WORDS[State.Proven], "--wood"],
  [State.Awake, WORDS[State.Awake], "--moves"],
  [State.Free, WORDS[State.Free], "--free"],
  [State.Riding, WORDS[State.Riding], "--rides"],
  [State.Fallen, WORDS[State.Fallen], "--left"],
  [State.Thrown, WORDS[State.Thrown], "--thrown"],
];
const NOTHING = "nothing is known";
const NOT_STORED = "as placed; the file stores no motion";
const LEVELS = ramp("#1d2f6f #2b5c8a #3c8796 #62ae8b #a5cd7c #f2e58a");
const MARGIN = ramp("#a63603 #d9742b #f3b77a #efe9dc #a9cde0 #5a9bc5 #1f5f99");
const SHARE = ramp("#f2efe6 #cfe0e8 #9fc5da #629fc4 #2f74a8 #12497a");
// Kinds, told apart by people who see no red or no green as well (Okabe and Ito). A kind beyond these has no hue of its own.
const KINDS = ramp("#e69f00 #56b4e9 #009e73 #f0e442 #0072b2 #d55e00 #cc79a7");
const USED = ramp("#f2efe6 #cfe0e8 #9fc5da #629fc4 #2f74a8"); // of its strength, by a joint
const MOST_LEVELS = 8; // listed one by one in the legend; of more, every fifth

// One line of the legend: what occurs at a time, and in how many bricks; a hollow one has an outline and no fill.
export interface Entry {
  text: string;
  colour: Color;
  count?: number; // missing where the line tells an end of a ramp
  hollow?: boolean;
}

// What has nothing to tell at a time without a proof.
export const OF_PROOFS: ReadonlySet<Mode> = new Set<Mode>(["stage", "room", "load"]);

export class Colours {
  private readonly levels: number[]; // that occur, from the lowest on
  private readonly stages: string[];
  private readonly kinds: string[];
  private readonly kind: Int32Array; // of each brick
  private readonly room: number; // [mm] of one step of the ramp
  private readonly carried: number; // [N] likewise
  private readonly used = new Map<number, number>(); // the largest share of strength of the joints of each brick; GIVES_WAY if one yields
  private readonly crushed = new Map<number, number>(); // the share of its strength that each brick uses against crushing
  private readonly loads = new Map<object, Map<number, number>>(); // of each proof, by brick [N]

  constructor(private readonly run: Run) {
    const { bricks, proofs } = run.told;
    this.levels = [...new Set(bricks.level)].filter(Boolean).sort((one, other) => one - other);
    this.stages = byCount(proofs.flatMap((proof) => proof.stage.map((stage) => proof.stages[stage])));
    const kinds = bricks.shape.map((_, brick) => this.kindOf(brick));
    this.kinds = byCount(kinds);
    const places = new Map(this.kinds.map((kind, place) => [kind, place]));
    this.kind = Int32Array.from(kinds, (kind) => places.get(kind)!);
    this.room = niceAbove(proofs.reduce((most, { depth }) => depth.reduce<number>((so_far, one) => Math.max(so_far, one ?? 0), most), 0) / MARGIN.length);
    const { limit } = run.told;
    limit?.used.forEach((used, joint) => {
      for (const body of [limit.lower[joint], limit.upper[joint]]) if (typeof body === "number") this.used.set(body, Math.max(this.used.get(body) ?? 0, limit.yields[joint] ? GIVES_WAY : used));
    });
    run.told.strength?.bricks.forEach((brick, place) => this.crushed.set(brick, run.told.strength!.used[place]));
    for (const found of run.proofs) this.loads.set(found.proof, loadsOf(found));
    this.carried = niceAbove([...this.loads.values()].reduce((most, loads) => [...loads.values()].reduce((so_far, one) => Math.max(so_far, one), most), 0) / SHARE.length);
  }

  // Why a colouring has nothing to tell at a time; empty if it has.
  silent(mode: Mode, time: number): string {
    if (mode === "level" && this.levels.length < 2) return this.levels.length ? "all bricks are of one level" : "no brick has a level";
    if (mode === "material" && this.kinds.length < 2) return "all bricks have one size and one density";
    if (mode === "joints" && !this.run.told.limit) return "the run has no joints with a load factor";
    if (mode === "strength" && !this.run.told.strength) return "no brick has a strength, or there are too many bricks";
    if (!OF_PROOFS.has(mode)) return "";
    const found = this.run.proofAt(time);
    if (!found) return this.run.proofs.length ? "no proof holds at this time" : "no structure of this run is proven to stand";
    if (mode === "room" && found.proof.depth.every((depth) => depth === null)) return "no brick has a support area of its own";
    if (mode === "stage" && new Set(found.proof.stage).size < 2) return `all bricks are proven by ${found.proof.stages[found.proof.stage[0]]}`;
    return "";
  }

  of(mode: Mode, brick: number, time: number): Color {
    return this.entry(mode, brick, time, this.run.proofAt(time))[1];
  }

  // What occurs at a time, in the order of the legend.
  legend(mode: Mode, time: number): Entry[] {
    const { run } = this;
    const found = run.proofAt(time);
    const entries = new Map<string, Entry & { order: number; count: number }>();
    let removed = 0;
    for (let brick = 0; brick < run.count; brick++) {
      const gone = run.told.bricks.gone[brick];
      if (gone !== null && gone <= time) removed++;
      if (!run.isThere(brick, time)) continue;
      const [text, colour, order] = this.entry(mode, brick, time, found);
      const entry = entries.get(text);
      if (entry) entry.count++;
      else entries.set(text, { text, colour: colour.clone(), order, count: 1 });
    }
    const all = [...entries.values()].sort((one, other) => one.order - other.order);
    const ends = new Set([all[0], all[all.length - 1]]);
    const told = mode === "level" && all.length > MOST_LEVELS ? all.filter((entry) => ends.has(entry) || entry.order % 5 === 0) : all;
    return removed ? [...told, { text: "pulled out", colour: token("--ink-2"), count: removed, hollow: true }] : told;
  }

  // The line of the legend that a brick belongs to, its colour, and where that line stands.
  private entry(mode: Mode, brick: number, time: number, found: ReturnType<Run["proofAt"]>): [string, Color, number] {
    const unknown: [string, Color, number] = [NOTHING, token("--edge"), 1e9];
    const place = found?.place.get(brick);
    switch (mode) {
      case "state": {
        const now = this.run.stateAt(brick, time);
        if (this.run.told.marks && (now === State.Awake || now === State.Free)) return [NOT_STORED, unknown[1], unknown[2]]; // a golden file says nothing of the way
        const order = STATES.findIndex(([state]) => state === now);
        return order < 0 ? unknown : [STATES[order][1], token(STATES[order][2]), order];
      }
      case "level": {
        const level = this.run.told.bricks.level[brick];
        return level ? [`level ${level}`, along(LEVELS, this.levels.indexOf(level) / Math.max(1, this.levels.length - 1)), level] : unknown;
      }
      case "material": {
        const kind = this.kind[brick];
        return kind < KINDS.length || this.kinds.length === KINDS.length + 1 ? [this.kinds[kind], KINDS[kind] ?? unknown[1], kind] : [`${this.kinds.length - KINDS.length} rarer kinds`, unknown[1], kind];
      }
      case "joints": {
        const used = this.used.get(brick);
        return used === undefined ? ["no joint", unknown[1], 1e9] : usedStep(used);
      }
      case "strength": {
        const used = this.crushed.get(brick);
        if (used === undefined) return ["no strength", unknown[1], 1e9];
        return this.run.told.strength!.crushes === brick ? ["crushes", token("--left"), USED.length] : usedStep(Math.min(used, 1));
      }
      case "stage":
        if (!found || place === undefined) return unknown;
        return [found.proof.stages[found.proof.stage[place]], KINDS[this.stages.indexOf(found.proof.stages[found.proof.stage[place]])] ?? unknown[1], found.proof.stage[place]];
      case "room": {
        const depth = place === undefined ? null : (found?.proof.depth[place] ?? null);
        return depth === null ? ["no support area of its own", unknown[1], 1e9] : step(MARGIN, depth, this.room, "mm of room");
      }
      default: {
        const load = found && this.loads.get(found.proof)?.get(brick);
        return load === undefined ? unknown : step(SHARE, load, this.carried, "N carried");
      }
    }
  }

  private kindOf(brick: number): string {
    const { shape, density } = this.run.told.bricks;
    const sides = this.run.halves[shape[brick]].toArray().map((half) => +(2000 * half).toPrecision(4));
    return `${sides.join(" × ")} mm, ${density[brick]} kg/m³`;
  }
}

// What each brick of a proof carries of others, as the forces that press on it from above them together [N].
function loadsOf({ proof, forces }: { proof: { bricks: number[]; lower: (number | string)[]; counts: number[] }; forces: Float32Array }): Map<number, number> {
  const loads = new Map(proof.bricks.map((brick) => [brick, 0]));
  let begin = 0;
  proof.counts.forEach((count, contact) => {
    const force = [0, 0, 0];
    for (let point = begin; point < begin + count; point++) for (let axis = 0; axis < 3; axis++) force[axis] += forces[3 * point + axis];
    begin += count;
    const lower = proof.lower[contact];
    if (typeof lower === "number" && loads.has(lower)) loads.set(lower, loads.get(lower)! + Math.hypot(...force));
  });
  return loads;
}

const tokens = new Map<string, Color>();

// A colour that the style names, as light or dark as the page is.
export function token(name: string): Color {
  const code = colourOf(name);
  const found = tokens.get(code) ?? new Color(code);
  tokens.set(code, found);
  return found;
}

function ramp(codes: string): Color[] {
  return codes.split(" ").map((code) => new Color(code));
}

function along(colours: Color[], part: number): Color {
  const at = part * (colours.length - 1);
  const low = Math.min(colours.length - 2, Math.floor(at));
  return colours[low].clone().lerp(colours[low + 1], at - low);
}

// The step of a ramp for a value, named by its limits.
function step(colours: Color[], value: number, each: number, unit: string): [string, Color, number] {
  const place = Math.min(colours.length - 1, Math.max(0, Math.floor(value / each)));
  const [low, high] = [place, place + 1].map((edge) => String(+(edge * each).toPrecision(2)));
  return [`${low} to ${high} ${unit}`, colours[place], place];
}

export const GIVES_WAY = 2; // in place of a share of strength

// The line of the legend and the colour of a joint that uses a share of its strength at the load factor.
export function usedStep(used: number): [string, Color, number] {
  if (used >= GIVES_WAY) return ["a joint gives way first", token("--left"), USED.length];
  const [text, colour, place] = step(USED, 100 * used, 100 / USED.length, "% of strength used");
  return [text, colour, place];
}

// The next of 1, 2, 5, 10 and so on.
export function niceAbove(value: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.max(value, 1e-12)));
  return power * ([1, 2, 5].find((factor) => factor * power >= value * (1 - 1e-9)) ?? 10);
}

// Each of the texts once, the most frequent first.
function byCount(texts: string[]): string[] {
  const counts = new Map<string, number>();
  for (const text of texts) counts.set(text, (counts.get(text) ?? 0) + 1);
  return [...counts].sort(([, one], [, other]) => other - one).map(([text]) => text);
}
