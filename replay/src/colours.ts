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
  [State.Proven, "frozen, since proven or judged stable", new Color("#d9b98a")],
  [State.Awake, "moves freely", new Color("#56b4e9")],
  [State.Riding, "moves rigidly with other bricks", new Color("#009e73")],
  [State.Fallen, "has left its place", new Color("#d55e00")],
  [State.Thrown, "thrown or dropped", new Color("#cc79a7")],
];
const LOW = new Color("#d55e00");
const HIGH = new Color("#0072b2");
const ENOUGH = 10; // [mm] of room, beyond which it shows no more

export type Entry = [string, Color];

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

  legend(mode: Mode): Entry[] {
    switch (mode) {
      case "state":
        return STATES.map(([, text, colour]) => [text, colour]);
      case "stage":
        return [...this.stages.map((stage, place): Entry => [stage, PALETTE[place % 8]]), ["no proof at this time", UNKNOWN]];
      case "room":
        return [
          ["centre of mass at the edge of the support", LOW],
          [`${ENOUGH} mm or more inside the support`, HIGH],
          ["not determined", UNKNOWN],
        ];
      case "material":
        return this.kinds.slice(0, 8).map((kind, place) => [kind, PALETTE[place % 8]]);
      default: {
        const levels = [...new Set(this.run.told.bricks.level)].filter((level) => level > 0).sort((one, other) => one - other);
        const alike = PALETTE.slice(0, 7).map((_, place) => levels.filter((level) => (level - 1) % 7 === place));
        return alike.flatMap((some, place): Entry[] => (some.length ? [[`level ${some.slice(0, 3).join(", ")}${some.length > 3 ? " ..." : ""}`, PALETTE[place]]] : []));
      }
    }
  }

  private kindOf(brick: number): string {
    const { shape, density } = this.run.told.bricks;
    const sides = this.run.halves[shape[brick]].toArray().map((half) => +(2000 * half).toPrecision(4));
    return `${sides.join(" x ")} mm, ${density[brick]} kg/m3`;
  }
}
