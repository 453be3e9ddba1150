// What is drawn over the bricks, at the place where each of them is drawn: contacts and forces of a proof, load paths, who
// rests on whom, a proven motion, names, what was pulled out, and scales.
import { Matrix4, Quaternion, Vector3 } from "three";
import { GIVES_WAY, niceAbove, usedStep } from "./colours";
import { colourOf } from "./page";
import type { Forces, Pose } from "./run";
import type { Look, Stage } from "./stage";
import { howMany, newtons, threeDigits } from "./wording";

export type Overlay = "contacts" | "joints" | "forces" | "thrust" | "paths" | "graph" | "motion" | "names";
export const OVERLAYS: Overlay[] = ["contacts", "joints", "forces", "thrust", "paths", "graph", "motion", "names"];

// What is drawn only at times at which a proof holds.
export const NEED_PROOF: ReadonlySet<Overlay> = new Set<Overlay>(["contacts", "forces", "thrust", "paths", "graph"]);

// Which forces are drawn: those of the selected brick or, while none is selected, the ten largest; the ten largest; or all.
export type Which = "selected" | "largest" | "all";
const TEN = 10;
const MANY = 200; // arrows: more of them have no halo, which would hide what is behind
const MANY_LOADS = 12; // from which on they bear no numbers
const LEAST = 0.002; // of the largest force: smaller ones are not drawn
const LONGEST = 76; // [px] of an arrow
const RAMP = ["--f1", "--f2", "--f3", "--f4", "--f5"];
const AROUND_FALL = 0.5; // [s] in which its motion is drawn
const [NARROW, LOW] = [0.7, 8]; // of its name, and [px]: a narrower or lower face has no name on it
const TRIES = 400; // names that are tried, as each is looked for behind all bricks

// How a stage is seen.
export interface Sight {
  at(point: Vector3): [number, number]; // on the canvas [px]
  scale(point: Vector3): number; // [px/m]
  toEye(point: Vector3): Vector3;
  sees(brick: number, point: [number, number]): boolean; // whether it is the nearest there
  left: number; // of its part of the canvas [px]
  width: number;
  height: number;
}

// A force of a proof between two bodies.
export interface Force {
  lower: number | string;
  upper: number | string;
  point: Vector3; // where it acts as a whole [m]
  force: Vector3; // of the lower body on the upper one [N]
}

export interface Arrow {
  brick: number | string; // that it is drawn at
  tip: Vector3;
  force: Vector3; // towards the tip [N]
}

export interface ForceScale {
  perNewton: number; // [px]
  force: number; // that the bar stands for [N]
  text: string;
  title: string;
}

interface Box {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

const known = new WeakMap<object, Force[]>();

// One force for each contact that carries anything, where it acts as a whole.
export function forcesOf({ proof, points, forces }: Forces): Force[] {
  const found = known.get(proof);
  if (found) return found;
  const all: Force[] = [];
  let begin = 0;
  proof.counts.forEach((count, contact) => {
    const [point, force] = [new Vector3(), new Vector3()];
    let total = 0;
    for (let place = begin; place < begin + count; place++) {
      const each = at(forces, place);
      force.add(each);
      total += each.length();
      point.addScaledVector(at(points, place), each.length());
    }
    begin += count;
    if (total > 0) all.push({ lower: proof.lower[contact], upper: proof.upper[contact], point: point.divideScalar(total), force });
  });
  known.set(proof, all);
  return all;
}

const at = (values: Float32Array, place: number): Vector3 => new Vector3().fromArray(values, 3 * place);

export class Overlays {
  bar: ForceScale | undefined; // of the forces that are drawn
  arrows: Arrow[] = []; // forces
  motions: { brick: number; from: Vector3; tip: Vector3 }[] = []; // velocities of a proven motion
  named: [string, number, number][] = []; // bricks with their names on them, and where [px]
  private moved: [number, number][] | undefined; // when anything moves [s]
  private boxes: Box[] = []; // that texts take up so far
  private readonly was: Pose = { position: new Vector3(), orientation: new Quaternion() };
  private readonly matrix = new Matrix4();

  constructor(private readonly stage: Stage) {}

  draw(pen: CanvasRenderingContext2D, sight: Sight, look: Look): void {
    const { run } = this.stage;
    const { time, overlays, picked } = look;
    const found = run.proofAt(time);
    const { fall } = run.told;
    this.boxes = [];
    this.bar = undefined;
    this.arrows = [];
    this.motions = [];
    this.named = [];
    pen.lineJoin = pen.lineCap = "round";
    pen.font = `12px ${colourOf("--sans")}`;
    this.pulledOut(pen, sight, time);
    this.ties(pen, sight, time);
    if (found && overlays.has("contacts")) this.patches(pen, sight, found, picked);
    if (overlays.has("joints")) this.joints(pen, sight, look);
    if (found && overlays.has("paths")) this.paths(pen, sight, found);
    if (found && overlays.has("graph")) this.graph(pen, sight, found);
    if (picked !== undefined && this.stage.shows(picked, time)) this.edges(pen, sight, picked, this.place(picked), "--accent", 2);
    if (found && overlays.has("forces")) this.forces(pen, sight, found, look);
    if (found && overlays.has("thrust")) this.thrust(pen, sight, found);
    if (found && (overlays.has("forces") || overlays.has("thrust"))) this.loads(pen, sight, found);
    if (fall && overlays.has("motion") && Math.abs(time - fall.time) < AROUND_FALL) this.motion(pen, sight);
    this.names(pen, sight, look);
  }

  // Only the edges of faces that look at the eye: those behind would be taken for parts of other bricks. Of a curved surface, its outline.
  private edges(pen: CanvasRenderingContext2D, sight: Sight, brick: number, place: Matrix4, colour: string, width: number): void {
    const shape = this.stage.run.told.shapes[this.stage.run.told.bricks.shape[brick]];
    const corners = shape.corners.map((corner) => new Vector3(...corner).applyMatrix4(place));
    pen.strokeStyle = colourOf(colour);
    pen.lineWidth = width;
    pen.beginPath();
    const seen = shape.faces.filter((face) => {
      const [a, b, c] = face.map((corner) => corners[corner]);
      return b.clone().sub(a).cross(c.clone().sub(b)).dot(sight.toEye(a)) > 0;
    });
    const curved = new Set(shape.curved?.map((face) => shape.faces[face]));
    const inner = new Set(seen.filter((face) => curved.has(face)).flatMap((face) => face.map((corner, place) => `${face[(place + 1) % face.length]} ${corner}`)));
    for (const face of seen) {
      if (curved.has(face)) {
        face.forEach((corner, place) => {
          const next = face[(place + 1) % face.length];
          if (inner.has(`${corner} ${next}`)) return;
          pen.moveTo(...sight.at(corners[corner]));
          pen.lineTo(...sight.at(corners[next]));
        });
        continue;
      }
      face.forEach((corner, number) => (number ? pen.lineTo(...sight.at(corners[corner])) : pen.moveTo(...sight.at(corners[corner]))));
      pen.closePath();
    }
    pen.stroke();
  }

  // What was pulled out, where it was; while bricks move, others can be there.
  private pulledOut(pen: CanvasRenderingContext2D, sight: Sight, time: number): void {
    const { run } = this.stage;
    this.moved ??= run.motions();
    if (this.moved.some(([begin, end]) => time > begin && time < end)) return;
    const { gone } = run.told.bricks;
    pen.setLineDash([4, 3]);
    for (let brick = 0; brick < run.count; brick++) {
      const removed = gone[brick];
      if (removed === null || removed > time) continue;
      run.poseAt(brick, -1, this.was); // where it was set down
      this.edges(pen, sight, brick, this.matrix.compose(this.was.position, this.was.orientation, ONES), "--ink-2", 1);
    }
    pen.setLineDash([]);
  }

  private patches(pen: CanvasRenderingContext2D, sight: Sight, found: Forces, picked: number | undefined): void {
    const { proof, points } = found;
    pen.strokeStyle = pen.fillStyle = colourOf("--accent");
    pen.lineWidth = 1.5;
    let begin = 0;
    proof.counts.forEach((count, contact) => {
      const corners = Array.from({ length: count }, (_, place) => sight.at(this.follow(at(points, begin + place), proof.upper[contact], found)));
      begin += count;
      if (picked !== undefined && proof.lower[contact] !== picked && proof.upper[contact] !== picked) return;
      pen.beginPath();
      corners.forEach(([x, y], place) => (place ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      pen.closePath();
      pen.globalAlpha = 0.25;
      pen.fill();
      pen.globalAlpha = 1;
      pen.stroke();
      if (count < 3) for (const [x, y] of corners) dot(pen, x, y, 2.5);
    });
  }

  // The joints, by the share of their strength that they use at the load factor; the one that gives way first comes last.
  private joints(pen: CanvasRenderingContext2D, sight: Sight, { time, picked }: Look): void {
    const { limit } = this.stage.run.told;
    if (!limit) return;
    const shares = limit.used.map((used, joint) => (limit.yields[joint] ? GIVES_WAY : used));
    const order = shares.map((_, joint) => joint).sort((one, other) => shares[one] - shares[other]);
    for (const joint of order) {
      const bodies = [limit.lower[joint], limit.upper[joint]];
      if (picked !== undefined && !bodies.includes(picked)) continue;
      if (bodies.some((body) => typeof body === "number" && !this.stage.shows(body, time))) continue;
      pen.beginPath();
      limit.points[joint].forEach((point, place) => {
        const [x, y] = sight.at(new Vector3(...point));
        if (place) pen.lineTo(x, y);
        else pen.moveTo(x, y);
      });
      pen.closePath();
      pen.fillStyle = pen.strokeStyle = `#${usedStep(shares[joint])[1].getHexString()}`;
      pen.globalAlpha = 0.75;
      pen.fill();
      pen.globalAlpha = 1;
      pen.lineWidth = shares[joint] === GIVES_WAY ? 3 : 1.5;
      pen.stroke();
    }
  }

  private forces(pen: CanvasRenderingContext2D, sight: Sight, found: Forces, { which, picked }: Look): void {
    const { told } = this.stage.run;
    const all = forcesOf(found).filter(({ force }) => force.length() > 0);
    const own = which === "selected" && picked !== undefined;
    let shown = own ? all.filter(({ lower, upper }) => lower === picked || upper === picked) : all.slice().sort((one, other) => other.force.length() - one.force.length());
    if (!own && which !== "all") shown = shown.slice(0, TEN);
    const most = shown.reduce((so_far, { force }) => Math.max(so_far, force.length()), 0);
    if (!most) return;
    shown = shown.filter(({ force }) => force.length() >= LEAST * most);
    this.arrows = shown.map(({ lower, upper, point, force }) => ({ brick: own ? picked : upper, tip: this.follow(point, upper, found), force: own && lower === picked ? force.clone().negate() : force }));
    const middle = this.arrows.reduce((sum, { tip }) => sum.addScaledVector(tip, 1 / this.arrows.length), new Vector3());
    const longest = Math.min(LONGEST, Math.max(28, 0.7 * this.stage.size * sight.scale(middle)));
    const words = newtons(most);
    const force = niceAbove(most) > 1.5 * most ? niceAbove(most / 2.5) : niceAbove(most);
    const title = own ? `Forces on ${told.bricks.name[picked]}` : which === "all" ? (shown.length < all.length ? `${shown.length} of ${howMany(all.length, "force")}` : `All ${howMany(all.length, "force")}`) : `The ${shown.length} largest of ${howMany(all.length, "force")}`;
    this.bar = { perNewton: longest / most, force, text: words.text(force), title };
    const drawn = this.arrows.map(({ tip, force }): [[number, number], [number, number], number] => {
      const length = (this.bar!.perNewton * force.length()) / sight.scale(tip);
      return [sight.at(tip.clone().addScaledVector(force, -length / force.length())), sight.at(tip), force.length() / most];
    });
    drawn.sort(([, , one], [, , other]) => one - other);
    for (const [from, to, share] of drawn) arrow(pen, from, to, share, colourFor(share), drawn.length < MANY);
    const low = sight.height - 14;
    const right = sight.left + sight.width - 14;
    const wide = this.bar.perNewton * force;
    pen.textAlign = "right";
    pen.textBaseline = "alphabetic";
    this.text(pen, title, right, low - 34, "--ink-2");
    this.text(pen, this.bar.text, right, low - 16, "--ink");
    arrow(pen, [right - wide, low - 4], [right, low - 4], Math.min(1, force / most));
    this.boxes.push({ left: right - Math.max(wide, 150), top: low - 50, right, bottom: low + 4 });
    if (which === "all" && !own) return;
    drawn.reverse().forEach(([[x, y], [tipX, tipY], share]) => {
      const below = y > tipY;
      pen.textAlign = "center";
      this.free(pen, words.text(share * most), x + (Math.abs(x - tipX) > 8 ? Math.sign(x - tipX) * 14 : 0), y + (below ? 15 : -6), "--ink");
    });
  }

  // From the centre of each brick, through where its load goes out, to the centre of what takes it; the more, the thicker.
  private paths(pen: CanvasRenderingContext2D, sight: Sight, found: Forces): void {
    const all = forcesOf(found).slice().sort((one, other) => one.force.length() - other.force.length());
    const most = all.length ? all[all.length - 1].force.length() : 1;
    const wide = Math.max(3, Math.min(9, 0.12 * this.stage.size * (all[0] ? sight.scale(all[0].point) : 1)));
    for (const halo of [true, false]) {
      for (const { lower, upper, point, force } of all) {
        const share = force.length() / most;
        const through = this.follow(point, upper, found);
        pen.beginPath();
        pen.moveTo(...sight.at(this.centre(upper, through)));
        pen.lineTo(...sight.at(through));
        pen.lineTo(...sight.at(this.centre(lower, through)));
        pen.lineWidth = Math.max(1, wide * Math.sqrt(share)) + (halo ? 2 : 0);
        pen.strokeStyle = colourOf(halo ? "--halo" : colourFor(share));
        pen.stroke();
      }
    }
  }

  // Straps, bands and rods, as soon as all their bricks are placed.
  private ties(pen: CanvasRenderingContext2D, sight: Sight, time: number): void {
    for (const { bricks, points } of this.stage.run.told.ties) {
      if (!bricks.every((brick) => this.stage.shows(brick, time))) continue;
      for (const halo of [true, false]) {
        pen.strokeStyle = colourOf(halo ? "--halo" : "--accent");
        pen.lineWidth = halo ? 4.5 : 2.5;
        pen.beginPath();
        points.forEach((point, number) => {
          const at = sight.at(new Vector3(...point));
          if (number) pen.lineTo(...at);
          else pen.moveTo(...at);
        });
        pen.stroke();
      }
    }
  }

  // The way of the forces of the proof from joint to joint, and the joints where it reaches an edge.
  private thrust(pen: CanvasRenderingContext2D, sight: Sight, found: Forces): void {
    const { thrust, hinges } = found.proof;
    for (const halo of [true, false]) {
      pen.strokeStyle = colourOf(halo ? "--halo" : "--fail");
      pen.lineWidth = halo ? 5 : 2.5;
      pen.beginPath();
      for (const [brick, ax, ay, az, bx, by, bz] of thrust) {
        pen.moveTo(...sight.at(this.follow(new Vector3(ax, ay, az), brick, found)));
        pen.lineTo(...sight.at(this.follow(new Vector3(bx, by, bz), brick, found)));
      }
      pen.stroke();
    }
    pen.lineWidth = 2;
    pen.strokeStyle = colourOf("--fail");
    pen.fillStyle = colourOf("--scene");
    for (const [brick, x, y, z] of hinges) {
      pen.beginPath();
      pen.arc(...sight.at(this.follow(new Vector3(x, y, z), brick, found)), 4, 0, 2 * Math.PI);
      pen.fill();
      pen.stroke();
    }
  }

  // Loads on bricks, each with its tip where it acts; their scale is not that of the forces of the proof.
  private loads(pen: CanvasRenderingContext2D, sight: Sight, found: Forces): void {
    const { loads } = found.proof;
    const most = loads.reduce((so_far, [, , , , x, y, z]) => Math.max(so_far, Math.hypot(x, y, z)), 0);
    const words = newtons(most);
    for (const [brick, px, py, pz, fx, fy, fz] of loads) {
      const force = new Vector3(fx, fy, fz);
      const share = force.length() / most;
      if (share < LEAST) continue;
      const tip = this.follow(new Vector3(px, py, pz), brick, found);
      const long = Math.min(LONGEST / sight.scale(tip), 0.6 * this.stage.size);
      const tail = sight.at(tip.clone().addScaledVector(force, -long / most));
      arrow(pen, tail, sight.at(tip), share, "--accent");
      pen.textAlign = "center";
      if (loads.length < MANY_LOADS) this.free(pen, words.text(force.length()), tail[0], tail[1] - 6, "--accent");
    }
  }

  private graph(pen: CanvasRenderingContext2D, sight: Sight, { proof }: Forces): void {
    pen.lineWidth = 1.5;
    proof.bricks.forEach((brick, place) => {
      const from = this.centre(brick, ONES);
      const [x, y] = sight.at(from);
      for (const [below] of proof.rests[place]) {
        const to = sight.at(typeof below === "number" ? this.centre(below, ONES) : new Vector3(from.x, from.y, this.foot(brick)));
        pen.strokeStyle = pen.fillStyle = colourOf("--pass");
        pen.beginPath();
        pen.moveTo(x, y);
        pen.lineTo(...to);
        pen.stroke();
      }
      pen.fillStyle = colourOf("--pass");
      dot(pen, x, y, 2.5);
    });
  }

  // Velocities with which it begins to fall, of bricks where they are now.
  private motion(pen: CanvasRenderingContext2D, sight: Sight): void {
    const fall = this.stage.run.told.fall!;
    const fastest = fall.velocity.reduce((most, v) => Math.max(most, Math.hypot(...v)), 1e-12);
    fall.bricks.forEach((brick, place) => {
      const velocity = new Vector3(...fall.velocity[place]);
      const share = velocity.length() / fastest;
      if (share < LEAST) return;
      const from = this.centre(brick, ONES);
      const long = Math.min(LONGEST / sight.scale(from), 0.6 * this.stage.size);
      const tip = from.clone().addScaledVector(velocity, long / fastest);
      this.motions.push({ brick, from, tip });
      arrow(pen, sight.at(from), sight.at(tip), share, "--accent");
    });
  }

  // Names: of the picked brick with a leader, of the one that is pointed at, and on demand of all that find room, those of
  // every fifth level first.
  private names(pen: CanvasRenderingContext2D, sight: Sight, { picked, hovered, overlays, time }: Look): void {
    const { run } = this.stage;
    const { name, level } = run.told.bricks;
    pen.textBaseline = "middle";
    if (picked !== undefined && this.stage.shows(picked, time)) this.leader(pen, sight, picked);
    pen.textAlign = "center";
    if (!overlays.has("names")) return;
    const there = Array.from({ length: run.count }, (_, brick) => brick).filter((brick) => brick !== picked && this.stage.shows(brick, time));
    const fifth = (brick: number): number => (brick === hovered ? 2 : level[brick] && level[brick] % 5 === 0 ? 1 : 0);
    const near = new Map(there.map((brick) => [brick, sight.scale(this.centre(brick, ONES))]));
    there.sort((one, other) => fifth(other) - fifth(one) || near.get(other)! - near.get(one)!);
    let tries = TRIES;
    for (const brick of there) {
      for (const [x, y] of this.facing(brick, sight, pen.measureText(name[brick]).width)) {
        if (!this.room(pen, name[brick], x, y)) continue;
        if (!tries--) return;
        if (!sight.sees(brick, [x, y])) continue;
        this.free(pen, name[brick], x, y, "--ink", "middle");
        this.named.push([name[brick], x, y]);
        break;
      }
    }
  }

  // The middles of those faces of a brick that look at the eye and are about as wide as a text, the largest first [px].
  private facing(brick: number, sight: Sight, wide: number): [number, number][] {
    const { run } = this.stage;
    const shape = run.told.shapes[run.told.bricks.shape[brick]];
    const place = this.place(brick);
    const corners = shape.corners.map((corner) => sight.at(new Vector3(...corner).applyMatrix4(place)));
    const found: [number, [number, number]][] = [];
    for (const face of shape.faces) {
      const ring = face.map((corner) => corners[corner]);
      const area = ring.reduce((sum, [x, y], number) => sum + x * ring[(number + 1) % ring.length][1] - y * ring[(number + 1) % ring.length][0], 0) / -2; // negative from behind
      const [width, height] = [0, 1].map((axis) => Math.max(...ring.map((corner) => corner[axis])) - Math.min(...ring.map((corner) => corner[axis])));
      if (area > 0 && width > NARROW * wide && height > LOW) found.push([area, [0, 1].map((axis) => ring.reduce((sum, corner) => sum + corner[axis] / ring.length, 0)) as [number, number]]);
    }
    return found.sort(([one], [other]) => other - one).map(([, at]) => at);
  }

  private leader(pen: CanvasRenderingContext2D, sight: Sight, brick: number): void {
    const box = this.stage.boxOf(brick, sight);
    const name = this.stage.run.told.bricks.name[brick];
    pen.font = `600 14px ${colourOf("--sans")}`;
    const wide = pen.measureText(name).width;
    const after = box.right + 28 + wide < sight.left + sight.width;
    const [from, high, x] = after ? [box.right, box.rightAt, box.right + 24] : [box.left, box.leftAt, Math.max(sight.left + wide + 4, box.left - 24)];
    const y = Math.min(sight.height - 10, Math.max(10, high - 10));
    pen.strokeStyle = colourOf("--accent");
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.moveTo(from, high);
    pen.lineTo(x, y);
    pen.stroke();
    pen.textAlign = after ? "left" : "right";
    this.text(pen, name, x + (after ? 4 : -4), y, "--ink");
    this.boxes.push({ left: after ? x : x - wide - 4, right: after ? x + wide + 4 : x, top: y - 10, bottom: y + 10 });
    pen.font = `12px ${colourOf("--sans")}`;
  }

  private text(pen: CanvasRenderingContext2D, text: string, x: number, y: number, colour: string): void {
    pen.lineWidth = 4;
    pen.strokeStyle = colourOf("--halo");
    pen.strokeText(text, x, y);
    pen.fillStyle = colourOf(colour);
    pen.fillText(text, x, y);
  }

  // A text where no other one is.
  private free(pen: CanvasRenderingContext2D, text: string, x: number, y: number, colour: string, base: CanvasTextBaseline = "alphabetic"): void {
    const box = boxAround(pen, text, x, base === "middle" ? y : y - 4);
    if (this.boxes.some((other) => overlap(box, other))) return;
    this.boxes.push(box);
    pen.textBaseline = base;
    this.text(pen, text, x, y, colour);
  }

  private room(pen: CanvasRenderingContext2D, text: string, x: number, y: number): boolean {
    const box = boxAround(pen, text, x, y);
    return !this.boxes.some((other) => overlap(box, other));
  }

  private place(brick: number): Matrix4 {
    return this.stage.matrixOf(brick, this.matrix);
  }

  private centre(body: number | string, otherwise: Vector3): Vector3 {
    return typeof body === "number" ? new Vector3().setFromMatrixPosition(this.place(body)) : otherwise;
  }

  // The height of the lowest point of a brick [m].
  private foot(brick: number): number {
    const { run } = this.stage;
    const place = this.place(brick);
    return run.told.shapes[run.told.bricks.shape[brick]].corners.reduce((low, corner) => Math.min(low, new Vector3(...corner).applyMatrix4(place).z), Infinity);
  }

  // A point of a proof on the brick that it is on, wherever that is drawn now.
  private follow(point: Vector3, body: number | string, { proof }: Forces): Vector3 {
    if (typeof body !== "number") return point;
    this.stage.run.poseAt(body, proof.begin, this.was);
    point = point.clone().sub(this.was.position).applyQuaternion(this.was.orientation.invert());
    return point.applyMatrix4(this.place(body));
  }
}

const ONES = new Vector3(1, 1, 1);

function colourFor(share: number): string {
  return RAMP[Math.min(RAMP.length - 1, Math.floor(share * RAMP.length))];
}

// An arrow with a halo; the more, the thicker and the darker.
function arrow(pen: CanvasRenderingContext2D, from: [number, number], to: [number, number], share: number, colour = colourFor(share), haloed = true): void {
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  if (length < 1) return;
  const wide = 1.5 + 2 * share;
  const head = Math.min(0.6 * length, 5 + 6 * share);
  const [x, y] = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
  const neck: [number, number] = [to[0] - x * head * 0.8, to[1] - y * head * 0.8];
  for (const halo of haloed ? [true, false] : [false]) {
    pen.strokeStyle = pen.fillStyle = colourOf(halo ? "--halo" : colour);
    pen.lineWidth = wide + (halo ? 3 : 0);
    pen.beginPath();
    pen.moveTo(...from);
    pen.lineTo(...neck);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(...to);
    for (const side of [-1, 1]) pen.lineTo(to[0] - x * head - side * y * head * 0.45, to[1] - y * head + side * x * head * 0.45);
    pen.closePath();
    if (halo) {
      pen.lineWidth = 3;
      pen.stroke();
    }
    pen.fill();
  }
}

function dot(pen: CanvasRenderingContext2D, x: number, y: number, radius: number): void {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.fill();
}

function boxAround(pen: CanvasRenderingContext2D, text: string, x: number, y: number): Box {
  const half = pen.measureText(text).width / 2 + 2;
  return { left: x - half, right: x + half, top: y - 8, bottom: y + 8 };
}

function overlap(one: Box, other: Box): boolean {
  return one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom;
}

// The step of the grid on the ground as a text.
export function lengthText(metres: number): string {
  return metres >= 1 ? `${threeDigits(metres)} m` : `${threeDigits(1000 * metres)} mm`;
}
