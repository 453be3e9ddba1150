// What is drawn over the bricks: contacts and forces of a proof, load paths, who rests on whom, and a proven motion.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  CylinderGeometry,
  ConeGeometry,
  DoubleSide,
  InstancedMesh,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  Object3D,
  Quaternion,
  Vector3,
} from "three";
import type { Forces, Run } from "./run";

export type Overlay = "contacts" | "forces" | "paths" | "graph" | "motion";
export const OVERLAYS: Overlay[] = ["contacts", "forces", "paths", "graph", "motion"];

// What is drawn only at times at which a proof holds.
export const NEED_PROOF: ReadonlySet<Overlay> = new Set<Overlay>(["contacts", "forces", "paths", "graph"]);

const UP = new Vector3(0, 1, 0);
const shaft = new CylinderGeometry(1, 1, 1, 8, 1, true).translate(0, 0.5, 0);
const tip = new ConeGeometry(1, 1, 10).translate(0, -0.5, 0);
const flat = (code: string): MeshBasicMaterial => new MeshBasicMaterial({ color: new Color(code), depthTest: false, transparent: true, opacity: 0.9 });
const FORCE = flat("#d1242f");
const PATH = flat("#8250df");
const MOTION = flat("#bf3989");

interface Arrow {
  from: Vector3;
  to: Vector3;
  radius: number;
}

function arrows(list: Arrow[], paint: MeshBasicMaterial, tips: boolean): Object3D {
  const group = new Object3D();
  const shafts = new InstancedMesh(shaft, paint, list.length);
  const heads = new InstancedMesh(tip, paint, tips ? list.length : 0);
  const turn = new Quaternion();
  const matrix = new Matrix4();
  list.forEach(({ from, to, radius }, place) => {
    const along = to.clone().sub(from);
    const length = Math.max(along.length(), 1e-9);
    turn.setFromUnitVectors(UP, along.divideScalar(length));
    const head = tips ? Math.min(0.4 * length, 6 * radius) : 0;
    shafts.setMatrixAt(place, matrix.compose(from, turn, new Vector3(radius, length - head, radius)));
    if (tips) heads.setMatrixAt(place, matrix.compose(to, turn, new Vector3(2.5 * radius, head, 2.5 * radius)));
  });
  for (const mesh of [shafts, heads]) {
    mesh.frustumCulled = false;
    mesh.renderOrder = 2;
    group.add(mesh);
  }
  return group;
}

// Bodies of a contact with its first point and how many there are.
function* contacts({ proof }: Forces): Generator<[number | string, number | string, number, number]> {
  let begin = 0;
  for (let contact = 0; contact < proof.counts.length; contact++) {
    yield [proof.lower[contact], proof.upper[contact], begin, proof.counts[contact]];
    begin += proof.counts[contact];
  }
}

const at = (values: Float32Array, place: number): Vector3 => new Vector3().fromArray(values, 3 * place);

export class Overlays {
  readonly group = new Object3D();
  private shown = "";

  constructor(
    private readonly run: Run,
    private readonly size: number, // the length of a usual brick [m]
    private readonly centre: (brick: number) => Vector3,
  ) {}

  show(wanted: Set<Overlay>, time: number): void {
    const found = this.run.proofAt(time);
    const { fall } = this.run.told;
    const falls = fall !== null && wanted.has("motion") && Math.abs(time - fall.time) < 0.5;
    const key = [...wanted, found?.proof.begin, falls].join();
    if (key === this.shown) return;
    this.shown = key;
    this.forget();
    if (falls) this.group.add(this.motion());
    if (found === undefined) return;
    if (wanted.has("contacts")) this.group.add(this.patches(found));
    if (wanted.has("forces")) this.group.add(this.forces(found));
    if (wanted.has("paths")) this.group.add(this.paths(found));
    if (wanted.has("graph")) this.group.add(this.graph(found));
  }

  private forget(): void {
    this.group.traverse((one) => {
      if (one instanceof InstancedMesh) one.dispose();
      else if (one instanceof Mesh || one instanceof LineSegments) one.geometry.dispose();
    });
    this.group.clear();
  }

  private patches(found: Forces): Object3D {
    const corners: number[] = [];
    const ends: number[] = [];
    for (const [, , begin, count] of contacts(found)) {
      for (let place = 1; place < count - 1; place++) {
        for (const corner of [0, place, place + 1]) corners.push(...at(found.points, begin + corner).toArray());
      }
      if (count < 3) for (const end of [0, count - 1]) ends.push(...at(found.points, begin + end).toArray());
    }
    const paint = new MeshBasicMaterial({ color: new Color("#1f6feb"), transparent: true, opacity: 0.55, side: DoubleSide, depthTest: false });
    const mesh = new Mesh(geometryOf(corners), paint);
    mesh.renderOrder = 1;
    mesh.add(lines(ends, "#1f6feb"));
    return mesh;
  }

  private forces(found: Forces): Object3D {
    const sizes = Array.from({ length: found.points.length / 3 }, (_, place) => at(found.forces, place).length());
    const most = Math.max(...sizes.slice(0, 100000), 1e-12);
    const list: Arrow[] = [];
    sizes.forEach((size, place) => {
      if (size < 0.002 * most) return;
      const from = at(found.points, place);
      const to = from.clone().addScaledVector(at(found.forces, place), (0.6 * this.size) / most);
      list.push({ from, to, radius: 0.008 * this.size });
    });
    return arrows(list, FORCE, true);
  }

  // From the centre of each brick, through where its load goes out, to the centre of what takes it; the more, the thicker.
  private paths(found: Forces): Object3D {
    const flows: [Vector3, Vector3, Vector3, number][] = [];
    for (const [lower, upper, begin, count] of contacts(found)) {
      const through = new Vector3();
      let total = 0;
      for (let place = begin; place < begin + count; place++) {
        const size = at(found.forces, place).length();
        through.addScaledVector(at(found.points, place), size);
        total += size;
      }
      if (total <= 0) continue;
      through.divideScalar(total);
      flows.push([this.endOf(upper, through), through, this.endOf(lower, through), total]);
    }
    const most = flows.reduce((so_far, [, , , total]) => Math.max(so_far, total), 1e-12);
    const list = flows.flatMap(([above, through, below, total]): Arrow[] => {
      const radius = 0.03 * this.size * Math.sqrt(total / most);
      return [
        { from: above, to: through, radius },
        { from: through, to: below, radius },
      ];
    });
    return arrows(list, PATH, false);
  }

  private graph({ proof }: Forces): Object3D {
    const ends: number[] = [];
    proof.bricks.forEach((brick, place) => {
      const from = this.centre(brick);
      for (const [below] of proof.rests[place]) {
        const to = this.endOf(below, new Vector3(from.x, from.y, 0));
        ends.push(...from.toArray(), ...to.toArray());
      }
    });
    return lines(ends, "#116329");
  }

  private motion(): Object3D {
    const fall = this.run.told.fall!;
    const fastest = Math.max(...fall.velocity.map((v) => Math.hypot(...v)), 1e-12);
    const list = fall.bricks.map((brick, place): Arrow => {
      const from = this.centre(brick);
      const to = from.clone().addScaledVector(new Vector3(...fall.velocity[place]), (0.6 * this.size) / fastest);
      return { from, to, radius: 0.012 * this.size };
    });
    return arrows(list, MOTION, true);
  }

  private endOf(body: number | string, otherwise: Vector3): Vector3 {
    return typeof body === "number" ? this.centre(body) : otherwise;
  }
}

function geometryOf(points: number[]): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  return geometry;
}

function lines(points: number[], code: string): LineSegments {
  const paint = new LineBasicMaterial({ color: new Color(code), depthTest: false });
  const found = new LineSegments(geometryOf(points), paint);
  found.renderOrder = 2;
  found.frustumCulled = false;
  return found;
}
