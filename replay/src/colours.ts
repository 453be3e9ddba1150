// What a brick is coloured by.
import { Color } from "three";
import { type Run, State } from "./run";

export type Mode = "state" | "stage" | "room" | "level" | "material";
export const MODES: Mode[] = ["state", "stage", "room", "level", "material"];

// Told apart by people who see no red or no green as well (Okabe and Ito).
const PALETTE = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#8c8c8c"].map(
  (code) => new Color(code),
);
const UNKNOWN = new Color("#b8b4aa");
const STATES: [State, string, Color][] = [
  [State.Proven, "stands", new Color("#d9b98a")],
  [State.Awake, "moves", new Color("#56b4e9")],
  [State.Riding, "rides on another", new Color("#009e73")],
  [State.Fallen, "has left its place", new Color("#d55e00")],
  [State.Thrown, "thrown or dropped", new Color("#cc79a7")],
];
const LOW = new Color("#d55e00");
const HIGH = new Color("#0072b2");
const NEAR = "centre of mass near the edge of the support";
const FAR = "10 mm or more inside the support";
const NOTHING = "nothing is known";
const ENOUGH = 10; // [mm] of room, beyond which it shows no more

// One line of the legend: what occurs at a time, and in how many bricks; a hollow one has an outline and no fill.
export interface Entry {
  text: string;
  colour: Color;
  count?: number; // missing where the line tells an end of a ramp
  hollow?: boolean;
}

// What has nothing to tell at a time without a proof.
export const OF_PROOFS: ReadonlySet<Mode> = new Set<Mode>(["stage", "room"]);

export class Colours {
  private readonly stages: string[];
  private readonly kinds: string[];
  private readonly mixed = new Color();

  constructor(private readonly run: Run) {
    this.stages = [...new Set(run.told.proofs.flatMap((proof) => proof.stages))];
    this.kinds = [...new Set(run.told.bricks.shape.map((_, brick) => this.kindOf(brick)))];
  }

  of(mode: Mode, brick: number, time: number): Color {
    switch (mode) {
      case "state": {
        const now = this.run.stateAt(brick, time);
        if (this.run.told.marks && now === State.Awake) return UNKNOWN; // a golden file says nothing of the way
        return STATES.find(([state]) => state === now)?.[2] ?? UNKNOWN;
      }
      case "level":
        return this.run.told.bricks.level[brick] ? PALETTE[(this.run.told.bricks.level[brick] - 1) % 7] : UNKNOWN;
      case "material":
        return PALETTE[this.kinds.indexOf(this.kindOf(brick)) % PALETTE.length];
      default: {
        const found = this.run.proofAt(time);
        const place = found?.place.get(brick);
        if (found === undefined || place === undefined) return UNKNOWN;
        if (mode === "stage") {
          return PALETTE[this.stages.indexOf(found.proof.stages[found.proof.stage[place]]) % PALETTE.length];
        }
        const depth = found.proof.depth[place];
        return depth === null ? UNKNOWN : this.mixed.lerpColors(LOW, HIGH, Math.min(1, Math.max(0, depth / ENOUGH)));
      }
    }
  }

  // What occurs at a time, in the order of the legend.
  legend(mode: Mode, time: number): Entry[] {
    const { run } = this;
    const found = run.proofAt(time);
    const counts = new Map<string, number>();
    let removed = 0;
    for (let brick = 0; brick < run.count; brick++) {
      const gone = run.told.bricks.gone[brick];
      if (gone !== null && gone <= time) removed++;
      if (!run.isThere(brick, time)) continue;
      const text = this.textOf(mode, brick, time, found);
      counts.set(text, (counts.get(text) ?? 0) + 1);
    }
    const pulled: Entry[] = removed ? [{ text: "pulled out", colour: UNKNOWN, count: removed, hollow: true }] : [];
    return [...this.all(mode).flatMap(([text, colour]) => (counts.has(text) ? [{ text, colour, count: counts.get(text) }] : [])), ...pulled];
  }

  private textOf(mode: Mode, brick: number, time: number, found: ReturnType<Run["proofAt"]>): string {
    const place = found?.place.get(brick);
    const level = this.run.told.bricks.level[brick];
    switch (mode) {
      case "state": {
        const now = this.run.stateAt(brick, time);
        return this.run.told.marks && now === State.Awake ? NOTHING : (STATES.find(([state]) => state === now)?.[1] ?? NOTHING);
      }
      case "level":
        return level ? `level ${level}` : NOTHING;
      case "material":
        return this.kindOf(brick);
      case "stage":
        return found && place !== undefined ? found.proof.stages[found.proof.stage[place]] : NOTHING;
      default: {
        const depth = place === undefined ? null : (found?.proof.depth[place] ?? null);
        return depth === null ? NOTHING : depth >= ENOUGH ? FAR : NEAR;
      }
    }
  }

  private all(mode: Mode): [string, Color][] {
    const { level } = this.run.told.bricks;
    const nothing: [string, Color] = [NOTHING, UNKNOWN];
    switch (mode) {
      case "state":
        return [...STATES.map(([, text, colour]): [string, Color] => [text, colour]), nothing];
      case "stage":
        return [...this.stages.map((stage, place): [string, Color] => [stage, PALETTE[place % 8]]), nothing];
      case "room":
        return [[NEAR, LOW], [FAR, HIGH], nothing];
      case "material":
        return this.kinds.map((kind, place) => [kind, PALETTE[place % 8]]);
      default:
        return [...[...new Set(level)].sort((one, other) => one - other).map((one): [string, Color] => (one ? [`level ${one}`, PALETTE[(one - 1) % 7]] : nothing))];
    }
  }

  private kindOf(brick: number): string {
    const { shape, density } = this.run.told.bricks;
    const sides = this.run.halves[shape[brick]].toArray().map((half) => +(2000 * half).toPrecision(4));
    return `${sides.join(" x ")} mm, ${density[brick]} kg/m3`;
  }
}
