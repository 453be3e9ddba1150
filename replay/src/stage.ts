// One run on the screen: its bricks, what is drawn over them, and the ground.
import { Box3, Color, DoubleSide, GridHelper, InstancedMesh, LineSegments, Mesh, MeshBasicMaterial, PlaneGeometry, Quaternion, Scene, Vector3 } from "three";
import { Bricks } from "./bricks";
import { Colours, type Mode } from "./colours";
import { type Overlay, Overlays } from "./overlays";
import { marksOf, type Pose, type Run } from "./run";

export const DIFFERENT = new Color("#ff00ff");
const PICKED = new Color("#ffffff");

export interface Look {
  time: number; // [s]
  mode: Mode;
  overlays: Set<Overlay>;
  swing: number; // how far the proven motion is drawn, in its longest brick; 0 for none
  picked: number | undefined; // a brick of this run
}

export class Stage {
  readonly scene = new Scene();
  readonly colours: Colours;
  readonly size: number; // the longest side of a brick [m]
  private readonly bricks: Bricks;
  private readonly overlays: Overlays;
  private readonly pose: Pose = { position: new Vector3(), orientation: new Quaternion() };
  private readonly other: Pose = { position: new Vector3(), orientation: new Quaternion() };
  private readonly mixed = new Color();
  private passed = ""; // what the bricks that do not move depend on

  constructor(readonly run: Run) {
    this.size = 2 * Math.max(...run.halves.map((half) => Math.max(half.x, half.y, half.z)), 1e-6);
    this.bricks = new Bricks(run);
    this.colours = new Colours(run);
    this.overlays = new Overlays(run, this.size, (brick) => this.bricks.drawn(brick, new Vector3()));
    this.scene.add(this.bricks.group, this.overlays.group);
    for (const plane of run.told.planes) this.scene.add(this.surface(plane));
  }

  // Put everything where it is at a time; `beside` is another run that this one is compared with.
  update(look: Look, beside?: Run, places?: Map<string, number>): void {
    const { run, bricks } = this;
    const passed = [run.passed(look.time), look.mode, look.picked, beside?.told.name, beside?.passed(look.time), look.swing > 0].join();
    const fresh = passed !== this.passed || beside !== undefined;
    this.passed = passed;
    const all = fresh ? run.count : run.moving.length;
    for (let place = 0; place < all; place++) {
      const brick = fresh ? place : run.moving[place];
      if (!run.isThere(brick, look.time)) {
        bricks.hide(brick);
        continue;
      }
      run.poseAt(brick, look.time, this.pose);
      bricks.put(brick, this.pose);
      const colour = this.colours.of(look.mode, brick, look.time);
      if (brick === look.picked) bricks.paint(brick, this.mixed.copy(colour).lerp(PICKED, 0.6));
      else if (beside && this.differs(brick, look.time, beside, places)) bricks.paint(brick, this.mixed.copy(colour).lerp(DIFFERENT, 0.6));
      else bricks.paint(brick, colour);
    }
    if (look.swing) this.swing(look);
    bricks.done();
    this.overlays.show(look.overlays, look.time);
  }

  // It is not drawn any more: give back what it has on the graphics card.
  forget(): void {
    this.scene.traverse((one) => {
      if (one instanceof InstancedMesh) one.dispose();
      if (one instanceof Mesh || one instanceof LineSegments) one.geometry.dispose();
    });
  }

  // Where a brick is drawn.
  drawn(brick: number): Vector3 {
    return this.bricks.drawn(brick, new Vector3());
  }

  // The corners of all that is there and was not thrown.
  corners(time: number): Vector3[] {
    const { run, pose } = this;
    const found: Vector3[] = [];
    for (let brick = 0; brick < run.count; brick++) {
      if (!run.isThere(brick, time) || run.told.bricks.thrown[brick]) continue;
      run.poseAt(brick, time, pose);
      for (const corner of run.told.shapes[run.told.bricks.shape[brick]].corners) {
        found.push(new Vector3(...(corner as [number, number, number])).applyQuaternion(pose.orientation).add(pose.position));
      }
    }
    return found;
  }

  // The nearest brick that a ray meets.
  pick(origin: Vector3, direction: Vector3, time: number): number | undefined {
    let [nearest, found]: [number, number | undefined] = [Infinity, undefined];
    for (let brick = 0; brick < this.run.count; brick++) {
      if (!this.run.isThere(brick, time)) continue;
      this.run.poseAt(brick, time, this.pose);
      const back = this.pose.orientation.conjugate();
      const from = origin.clone().sub(this.pose.position).applyQuaternion(back);
      const at = intoBox(from, direction.clone().applyQuaternion(back), this.run.halves[this.run.told.bricks.shape[brick]]);
      if (at < nearest) [nearest, found] = [at, brick];
    }
    return found;
  }

  private differs(brick: number, time: number, beside: Run, places?: Map<string, number>): boolean {
    const marks = marksOf(this.run, beside);
    if (marks) return marks.has(this.run.told.bricks.name[brick]);
    const there = places?.get(this.run.told.bricks.name[brick]);
    if (there === undefined || !beside.isThere(there, time)) return true;
    beside.poseAt(there, time, this.other);
    this.run.poseAt(brick, time, this.pose);
    const half = this.run.halves[this.run.told.bricks.shape[brick]];
    const least = Math.min(half.x, half.y, half.z); // half of the smallest side: what counts as having left its place
    const turned = 2 * this.pose.orientation.angleTo(this.other.orientation) * half.length();
    return this.pose.position.distanceTo(this.other.position) + turned > least;
  }

  // The motion that proves that it falls, from where it stood.
  private swing({ swing }: Look): void {
    const { fall } = this.run.told;
    if (fall === null) return;
    const most = fall.bricks.reduce((so_far, _, place) => {
      const spin = Math.hypot(...fall.spin[place]) * 0.5 * this.size;
      return Math.max(so_far, Math.hypot(...fall.velocity[place]) + spin);
    }, 1e-12);
    const amount = (swing * this.size) / most;
    fall.bricks.forEach((brick, place) => {
      this.run.poseAt(brick, fall.time, this.pose);
      this.pose.position.addScaledVector(new Vector3(...fall.velocity[place]), amount);
      const axis = new Vector3(...fall.spin[place]);
      const angle = axis.length() * amount;
      if (angle > 0) this.pose.orientation.premultiply(new Quaternion().setFromAxisAngle(axis.normalize(), angle));
      this.bricks.put(brick, this.pose);
    });
  }

  private surface(plane: { point: number[]; normal: number[] }): Mesh {
    const box = new Box3().setFromPoints(this.corners(this.run.told.end));
    const middle = box.isEmpty() ? new Vector3() : box.getCenter(new Vector3());
    const wide = Math.max(box.isEmpty() ? 1 : box.getSize(new Vector3()).length() * 2, 4 * this.size);
    const normal = new Vector3(...plane.normal);
    const foot = middle.clone().addScaledVector(normal, -normal.dot(middle.clone().sub(new Vector3(...plane.point))));
    const paint = new MeshBasicMaterial({ color: 0x8a8577, transparent: true, opacity: 0.22, side: DoubleSide, depthWrite: false });
    const mesh = new Mesh(new PlaneGeometry(wide, wide), paint);
    const grid = new GridHelper(wide, Math.min(80, Math.round(wide / this.size)), 0x8a8577, 0x8a8577);
    grid.material.transparent = true;
    grid.material.opacity = 0.25;
    grid.rotateX(Math.PI / 2);
    mesh.add(grid);
    mesh.position.copy(foot).addScaledVector(normal, -1e-4 * wide);
    mesh.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), normal);
    return mesh;
  }
}

// Where a ray enters a box about the origin, in its own length; Infinity if it misses.
function intoBox(from: Vector3, direction: Vector3, half: Vector3): number {
  let [enter, leave] = [0, Infinity];
  for (const axis of ["x", "y", "z"] as const) {
    const [a, b] = [(-half[axis] - from[axis]) / direction[axis], (half[axis] - from[axis]) / direction[axis]];
    enter = Math.max(enter, Math.min(a, b));
    leave = Math.min(leave, Math.max(a, b));
  }
  return enter <= leave ? enter : Infinity;
}
