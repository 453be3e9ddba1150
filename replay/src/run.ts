// One run: where every brick is at any time, and what is known of it then.
import { Quaternion, Vector3 } from "three";
import type { Payload, Proof, Told } from "./payload";
import { COLUMNS, unpackedFloats, unpackedPoses } from "./unpack";

const SLOWEST = 1e-3; // [m/s] what is slower does not move, as people see it
const SAME = 1e-6; // [s] of times that are told with so many digits
const DISTURBS = new Set(["woken", "hit", "pushed", "shaken", "taken", "collapsed"]);
const PAUSE = 0.02; // [s] a shorter rest between two motions is none

export const enum State {
  Absent,
  Awake,
  Free, // awake, and at rest
  Riding,
  Proven,
  Fallen,
  Thrown,
}

export interface Pose {
  position: Vector3;
  orientation: Quaternion;
}

export interface Forces {
  proof: Proof;
  points: Float32Array; // three a point [m]
  forces: Float32Array; // three a point [N], of the lower body on the upper one
  place: Map<number, number>; // where each brick is among those of the proof
}

export class Run {
  readonly count: number;
  readonly halves: Vector3[]; // of the box around each shape [m]
  private readonly begins: Int32Array; // the first row of each brick
  private readonly states: [number, State][][]; // of each brick, from when on
  private readonly spans: [number, number][][]; // of each brick: when it moves
  private readonly turns: number[]; // when a brick begins to move, or comes to rest, sorted
  readonly moving: number[]; // the bricks that have more than one pose
  private readonly next = new Quaternion();
  private readonly now: Pose = { position: new Vector3(), orientation: new Quaternion() };

  private constructor(
    readonly told: Payload,
    private readonly rows: Float64Array,
    readonly proofs: Forces[],
  ) {
    this.count = told.bricks.name.length;
    this.begins = new Int32Array(this.count + 1);
    told.poses.counts.forEach((count, brick) => (this.begins[brick + 1] = this.begins[brick] + count));
    this.states = this.statesOfAll();
    this.moving = told.poses.counts.flatMap((count, brick) => (count > 1 ? [brick] : []));
    this.halves = told.shapes.map((shape) => {
      const half = new Vector3();
      for (const corner of shape.corners) half.max(new Vector3(...corner.map(Math.abs)));
      return half;
    });
    this.spans = told.bricks.name.map((_, brick) => joined(this.motionsOf(brick)));
    this.turns = this.spans.flat(2).sort((one, other) => one - other);
  }

  static async of(told: Payload): Promise<Run> {
    const proofs = told.proofs.map(async (proof) => ({
      proof,
      points: await unpackedFloats(proof.points),
      forces: await unpackedFloats(proof.forces),
      place: new Map(proof.bricks.map((brick, place) => [brick, place])),
    }));
    return new Run(told, await unpackedPoses(told.poses), await Promise.all(proofs));
  }

  isThere(brick: number, time: number): boolean {
    const gone = this.told.bricks.gone[brick];
    return time >= this.rows[this.begins[brick] * COLUMNS] - 1e-9 && (gone === null || time < gone);
  }

  // Where a brick is; before it comes, where it will come to.
  poseAt(brick: number, time: number, pose: Pose): void {
    const { rows } = this;
    let low = this.begins[brick];
    let high = this.begins[brick + 1] - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (rows[middle * COLUMNS] <= time) low = middle;
      else high = middle - 1;
    }
    const at = low * COLUMNS;
    pose.position.set(rows[at + 1], rows[at + 2], rows[at + 3]);
    pose.orientation.set(rows[at + 4], rows[at + 5], rows[at + 6], rows[at + 7]);
    const after = at + COLUMNS;
    if (low + 1 < this.begins[brick + 1] && time > rows[at] && rows[after] > rows[at]) {
      const part = Math.min(1, (time - rows[at]) / (rows[after] - rows[at]));
      pose.position.set(
        rows[at + 1] + part * (rows[after + 1] - rows[at + 1]),
        rows[at + 2] + part * (rows[after + 2] - rows[at + 2]),
        rows[at + 3] + part * (rows[after + 3] - rows[at + 3]),
      );
      this.next.set(rows[after + 4], rows[after + 5], rows[after + 6], rows[after + 7]);
      pose.orientation.slerp(this.next, part);
    }
    pose.orientation.normalize();
  }

  // Whether a brick was thrown or dropped, or has fallen: at rest it lies, and does not stand.
  isAway(brick: number, time: number): boolean {
    const left = this.told.bricks.left[brick];
    return Boolean(this.told.bricks.thrown[brick]) || (left !== null && time >= left - SAME);
  }

  // From when to when the structure is as its weakest spot was computed: complete, and not yet hit or moved.
  asBuilt(): [number, number] {
    const { events, bricks, end } = this.told;
    const builds = (event: Told): boolean => event.kind === "removed" || (event.kind === "placed" && event.bricks.some((brick) => !bricks.thrown[brick]));
    const since = Math.max(0, ...events.filter(builds).map((event) => event.time));
    const disturbed = events.find((event) => DISTURBS.has(event.kind) && event.time > since + SAME);
    return [since, disturbed ? disturbed.time - SAME : end];
  }

  stateAt(brick: number, time: number): State {
    if (!this.isThere(brick, time)) return State.Absent;
    const left = this.told.bricks.left[brick];
    if (left !== null && time >= left) return State.Fallen;
    if (this.told.bricks.thrown[brick]) return State.Thrown;
    let found = State.Awake;
    for (const [since, state] of this.states[brick]) {
      if (since > time) break;
      found = state;
    }
    return found === State.Awake && !this.spans[brick].some(([begin, end]) => begin <= time && time < end) ? State.Free : found;
  }

  private isFrozen(brick: number, time: number): boolean {
    let found = false;
    for (const [since, state] of this.states[brick]) {
      if (since > time) break;
      found = state === State.Proven;
    }
    return found;
  }

  proofAt(time: number): Forces | undefined {
    return this.proofs.find(({ proof }) => time >= proof.begin && time < (proof.end ?? Infinity));
  }

  // When a brick moves at all, as spans of time.
  private motionsOf(brick: number): [number, number][] {
    const { rows, begins } = this;
    const spans: [number, number][] = [];
    const long = this.halves[this.told.bricks.shape[brick]].length();
    for (let row = begins[brick]; row + 1 < begins[brick + 1]; row++) {
      const [at, next] = [row * COLUMNS, (row + 1) * COLUMNS];
      let [way, same] = [0, 0];
      for (let axis = 1; axis <= 3; axis++) way += (rows[next + axis] - rows[at + axis]) ** 2;
      for (let part = 4; part <= 7; part++) same += rows[next + part] * rows[at + part];
      const moved = Math.sqrt(way) + 2 * Math.acos(Math.min(1, Math.abs(same))) * long;
      if (this.isFrozen(brick, (rows[at] + rows[next]) / 2)) continue; // it is drawn to slide to where it moves next
      if (moved > SLOWEST * Math.max(rows[next] - rows[at], 1e-9)) spans.push([rows[at], rows[next]]);
    }
    return spans;
  }

  // Which of some bricks move in a span of time.
  movers(among: number[], begin: number, end: number): number[] {
    return among.filter((brick) => this.spans[brick].some(([from, to]) => from < end && to > begin));
  }

  // When any of some bricks moves at all, as spans of time.
  motions(among = this.moving): [number, number][] {
    return joined(among.flatMap((brick) => this.spans[brick]));
  }

  // How far a brick is from where it was set down [m].
  movedBy(brick: number, time: number): number {
    const at = this.begins[brick] * COLUMNS;
    this.poseAt(brick, time, this.now);
    return this.now.position.distanceTo(new Vector3(this.rows[at + 1], this.rows[at + 2], this.rows[at + 3]));
  }

  // Which bricks are not where they are in another run, by more than half of their smallest side.
  differing(other: Run, time: number): number[] {
    const there = new Map(other.told.bricks.name.map((name, brick) => [name, brick]));
    return this.told.bricks.name.flatMap((name, brick) => {
      const its = there.get(name);
      const [here, away] = [this.isThere(brick, time), its !== undefined && other.isThere(its, time)];
      if (!here || its === undefined || !away) return here !== away ? [brick] : [];
      this.poseAt(brick, time, this.now);
      other.poseAt(its, time, other.now);
      const half = this.halves[this.told.bricks.shape[brick]];
      const turned = 2 * this.now.orientation.angleTo(other.now.orientation) * half.length();
      return this.now.position.distanceTo(other.now.position) + turned > Math.min(half.x, half.y, half.z) ? [brick] : [];
    });
  }

  // How many of the events have happened; while that is the same, nothing comes or goes.
  passed(time: number): number {
    return until(this.told.events, time, (event) => event.time - 1e-6);
  }

  // How many events, and beginnings and ends of motions, have happened; while that is the same, no brick changes its state.
  changes(time: number): number {
    return this.passed(time) + until(this.turns, time, (turn) => turn);
  }

  // The highest of its levels; 0 if it has none.
  get levels(): number {
    return this.told.bricks.level.reduce((most, level) => Math.max(most, level), 0);
  }

  nameOf(body: number | string): string {
    return typeof body === "string" ? body : this.told.bricks.name[body];
  }

  private statesOfAll(): [number, State][][] {
    const states: [number, State][][] = Array.from({ length: this.count }, () => []);
    for (const event of this.told.events) {
      const state = event.kind === "frozen" ? State.Proven : event.kind === "woken" ? State.Awake : undefined;
      if (state === undefined) continue;
      for (const brick of event.bricks) states[brick].push([event.time, state]);
      for (const brick of event.riding) states[brick].push([event.time, State.Riding]);
    }
    return states;
  }
}

// Spans of time in their order; those with no more than a pause between them are one.
function joined(spans: [number, number][]): [number, number][] {
  const found: [number, number][] = [];
  for (const [begin, end] of [...spans].sort(([one], [other]) => one - other)) {
    const last = found[found.length - 1];
    if (last && begin <= last[1] + PAUSE) last[1] = Math.max(last[1], end);
    else found.push([begin, end]);
  }
  return found;
}

// How many of sorted entries are no later than a time.
function until<T>(entries: T[], time: number, timeOf: (entry: T) => number): number {
  let [low, high] = [0, entries.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (timeOf(entries[middle]) <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

// What differs between a run and its golden file, if these two are seen, by name of a brick or of what else it is of.
export function marksOf(one: Run, other: Run | undefined): Map<string, string[]> | undefined {
  const golden = [one, other].find((run) => run?.told.marks);
  const run = golden === one ? other : one;
  if (!golden?.told.marks || !run || golden.told.name !== goldenOf(run)) return undefined;
  return new Map(Object.entries(golden.told.marks));
}

// True for a run, and not for a golden file.
export function failed(run: Run): boolean {
  return !run.told.marks && run.told.told.status === "failed";
}

// What the golden file of a run is called.
export function goldenOf({ told }: Run): string {
  return `${told.name}, golden file`;
}
