// One run on the screen: its bricks, what is drawn over them, the ground, and the light.
import {
  DepthTexture,
  DoubleSide,
  LessEqualCompare,
  LinearFilter,
  Matrix4,
  Mesh,
  Object3D,
  OrthographicCamera,
  PlaneGeometry,
  Quaternion,
  Scene,
  ShaderMaterial,
  Sphere,
  Vector2,
  Vector3,
  WebGLRenderTarget,
  type WebGLRenderer,
} from "three";
import { Bricks, type Light, Mark, SHADED } from "./bricks";
import { Colours, type Mode, niceAbove, token } from "./colours";
import { type Overlay, Overlays, type Sight, type Which } from "./overlays";
import { marksOf, type Pose, type Run } from "./run";

const SUN = new Vector3(-0.45, -0.75, 1.1).normalize(); // towards it
const SHADOWED = 4000; // bricks up to which they cast shadows; benchmarks/replay.py measures what more of them cost
const SHARPNESS = 2048; // [px] of the map of shadows, along a side
const SOFT = 1.6; // pixels of the map beside a point at which it is looked up as well
const REACH = 1.2 * SOFT + 1.5; // pixels of the map beside a point that its shadow depends on, and a half more
const NEARBY = 2; // times the ball around what was built: what ends farther out would make it tiny
const APART = 12; // times the size of a structure: another one farther away is left out of the picture
const INSIDE = 0.9; // of the way to its corners: points of a brick that are to be seen

export interface Look {
  time: number; // [s]
  mode: Mode;
  overlays: Set<Overlay>;
  which: Which; // of the forces
  xray: boolean; // whether what hides the picked brick is drawn as if of glass
  top: number; // the highest level that is drawn
  swing: number; // how far the proven motion is drawn, in its longest brick; 0 for none
  picked: number | undefined; // a brick of this run
  hovered: number | undefined;
}

export class Stage {
  readonly scene = new Scene();
  readonly colours: Colours;
  readonly size: number; // the longest side of a usual brick [m]
  readonly grid: number; // its step [m]
  readonly overlays: Overlays;
  apart = 0; // bricks of structures so far away that they are left out of the picture
  private readonly near: Sphere; // what is outside has gone far from what was built
  private readonly home: Sphere; // around what is built, and what of it ends nearby
  private readonly bricks: Bricks;
  private readonly grounds = new Object3D();
  private readonly light: Light = {
    sun: { value: SUN },
    shift: { value: 0 },
    shade: { value: new Matrix4() },
    shadows: { value: null },
    soft: { value: SOFT / SHARPNESS },
    outlines: { value: [] },
    pixel: { value: 1 },
  };
  private readonly sun = new OrthographicCamera();
  private readonly map: WebGLRenderTarget | undefined;
  private readonly pose: Pose = { position: new Vector3(), orientation: new Quaternion() };
  private readonly other: Pose = { position: new Vector3(), orientation: new Quaternion() };
  private readonly matrix = new Matrix4();
  private readonly ghosts = new Set<number>();
  private passed = ""; // what the bricks that do not move depend on
  private lit = false; // whether shadows are those of what is drawn
  private castAt = -Infinity; // when shadows were last drawn [ms]
  private look: Look | undefined;

  constructor(readonly run: Run) {
    const sides = run.told.bricks.shape.map((shape) => 2 * Math.max(...run.halves[shape].toArray())).sort((one, other) => one - other);
    this.size = sides[sides.length >> 1] || 1e-6;
    this.grid = niceAbove(this.size * 0.8);
    [this.near, this.home] = this.builtWithin();
    this.bricks = new Bricks(run, this.light);
    this.colours = new Colours(run);
    this.overlays = new Overlays(this);
    this.scene.add(this.grounds, this.bricks.mesh, this.bricks.ghosts);
    for (const plane of run.told.planes) this.grounds.add(this.surface(plane));
    if (run.count > SHADOWED) return;
    this.map = new WebGLRenderTarget(SHARPNESS, SHARPNESS);
    this.map.depthTexture = new DepthTexture(SHARPNESS, SHARPNESS);
    this.map.depthTexture.compareFunction = LessEqualCompare;
    this.map.depthTexture.minFilter = this.map.depthTexture.magFilter = LinearFilter;
    this.light.shadows.value = this.map.depthTexture;
    for (const one of [this.bricks.material, ...this.grounds.children.map((ground) => (ground as Mesh).material as ShaderMaterial)]) one.defines = { ...one.defines, SHADOWS: "" };
    const { center } = this.home;
    const radius = 1.1 * this.home.radius;
    [this.sun.left, this.sun.right, this.sun.bottom, this.sun.top, this.sun.near, this.sun.far] = [-radius, radius, -radius, radius, 0, 4 * radius];
    this.sun.position.copy(center).addScaledVector(SUN, 2 * radius);
    this.sun.up.set(0, 0, 1);
    this.sun.lookAt(center);
    this.sun.updateProjectionMatrix();
    this.sun.updateMatrixWorld();
    this.light.shift.value = (REACH * 2 * radius) / SHARPNESS;
    const half = new Matrix4().makeScale(0.5, 0.5, 0.5).setPosition(0.5, 0.5, 0.5);
    this.light.shade.value = half.multiply(this.sun.projectionMatrix).multiply(this.sun.matrixWorldInverse);
  }

  // The ways of what is thrown, as seen from above, in radians from the axis of x.
  bearings(): number[] {
    const { run } = this;
    return run.told.events.flatMap((event) => {
      if (event.kind !== "hit") return [];
      const way = this.centreAt(event.bricks[0], event.time).clone().sub(this.centreAt(event.bricks[0], -1));
      return Math.hypot(way.x, way.y) > Math.abs(way.z) ? [Math.atan2(way.y, way.x)] : [];
    });
  }

  // Put everything where it is at a time; `beside` is another run that this one is compared with.
  update(look: Look, toEye: (point: Vector3) => Vector3, beside?: Run, places?: Map<string, number>): void {
    const { run, bricks, ghosts } = this;
    this.hide(look, toEye);
    const { time, mode, picked, hovered, top } = look;
    const passed = [run.changes(time), mode, picked, hovered, top, beside?.told.name, beside?.changes(time), look.swing > 0, run.proofAt(time)?.proof.begin, token("--wood").getHex(), ...ghosts].join();
    const fresh = passed !== this.passed || beside !== undefined;
    this.passed = passed;
    this.look = look;
    const all = fresh ? run.count : run.moving.length;
    if (all) this.lit = false;
    for (let place = 0; place < all; place++) {
      const brick = fresh ? place : run.moving[place];
      if (!this.shows(brick, time)) {
        bricks.hide(brick);
        continue;
      }
      run.poseAt(brick, time, this.pose);
      bricks.put(brick, this.pose);
      const differs = beside !== undefined && this.differs(brick, time, beside, places);
      const mark = brick === picked ? Mark.Picked : differs ? Mark.Different : brick === hovered ? Mark.Hovered : Mark.None;
      bricks.paint(brick, this.colours.of(mode, brick, time), mark, ghosts.has(brick));
    }
    if (look.swing) this.swing(look);
    bricks.done();
    bricks.ghosts.visible = ghosts.size > 0;
  }

  // Whether a brick is drawn at a time: bricks above the highest level that is looked at are left out.
  shows(brick: number, time: number): boolean {
    return this.run.isThere(brick, time) && this.run.told.bricks.level[brick] <= (this.look?.top ?? Infinity);
  }

  // Draw the bricks and the ground.
  draw(renderer: WebGLRenderer, camera: Parameters<WebGLRenderer["render"]>[1], pixel: number): void {
    this.light.pixel.value = pixel;
    this.light.outlines.value = ["--outline", "--accent", "--accent", "--known"].map(token);
    renderer.render(this.scene, camera);
  }

  // Draw what the sun sees, unless nothing has moved since or it was drawn just now.
  cast(renderer: WebGLRenderer, pause: number): void {
    const now = performance.now();
    if (!this.map || this.lit || now - this.castAt < pause) return;
    [this.lit, this.castAt] = [true, now];
    const unseen = [this.grounds, this.bricks.ghosts].map((one): [Object3D, boolean] => [one, one.visible]);
    for (const [one] of unseen) one.visible = false;
    this.scene.overrideMaterial = this.bricks.cast;
    renderer.setRenderTarget(this.map);
    renderer.clear();
    renderer.render(this.scene, this.sun);
    renderer.setRenderTarget(null);
    this.scene.overrideMaterial = null;
    for (const [one, visible] of unseen) one.visible = visible;
  }

  drawOver(pen: CanvasRenderingContext2D, sight: Sight): void {
    if (this.look) this.overlays.draw(pen, sight, this.look);
  }

  // It is not drawn any more: give back what it has on the graphics card.
  forget(): void {
    this.map?.depthTexture?.dispose();
    this.map?.dispose();
    this.bricks.forget();
    for (const ground of this.grounds.children) (ground as Mesh).geometry.dispose();
  }

  // Where a brick is drawn.
  drawn(brick: number): Vector3 {
    return new Vector3().setFromMatrixPosition(this.matrixOf(brick, this.matrix));
  }

  matrixOf(brick: number, matrix: Matrix4): Matrix4 {
    return this.bricks.drawn(brick, matrix);
  }

  // What a brick takes up on the canvas, and how high its outermost corners are [px].
  boxOf(brick: number, sight: Pick<Sight, "at">): { left: number; top: number; right: number; bottom: number; leftAt: number; rightAt: number } {
    const place = this.matrixOf(brick, this.matrix);
    const box = { left: Infinity, top: Infinity, right: -Infinity, bottom: -Infinity, leftAt: 0, rightAt: 0 };
    for (const corner of this.run.told.shapes[this.run.told.bricks.shape[brick]].corners) {
      const [x, y] = sight.at(new Vector3(...corner).applyMatrix4(place));
      if (x < box.left) [box.left, box.leftAt] = [x, y];
      if (x > box.right) [box.right, box.rightAt] = [x, y];
      box.top = Math.min(box.top, y);
      box.bottom = Math.max(box.bottom, y);
    }
    return box;
  }

  // The corners of all that is there and was not thrown; unless all is asked for, of what is near what was built.
  corners(time: number, all = false): Vector3[] {
    const { run } = this;
    const found: Vector3[] = [];
    for (let brick = 0; brick < run.count; brick++) {
      if (!run.isThere(brick, time) || run.told.bricks.thrown[brick]) continue;
      if (all || this.near.containsPoint(this.centreAt(brick, time))) found.push(...this.cornersOf(brick, time));
    }
    return found;
  }

  // How far any of these is from a point [m].
  reach(time: number, from: Vector3): number {
    const { run, pose } = this;
    let most = 0;
    for (let brick = 0; brick < run.count; brick++) {
      if (!run.isThere(brick, time) || run.told.bricks.thrown[brick]) continue;
      run.poseAt(brick, time, pose);
      if (this.near.containsPoint(pose.position)) most = Math.max(most, pose.position.distanceTo(from) + run.halves[run.told.bricks.shape[brick]].length());
    }
    return most;
  }

  // The nearest brick that a ray meets, of those that are not of glass.
  pick(origin: Vector3, direction: Vector3): number | undefined {
    const time = this.look?.time ?? 0;
    let [nearest, found]: [number, number | undefined] = [Infinity, undefined];
    for (let brick = 0; brick < this.run.count; brick++) {
      if (!this.shows(brick, time) || this.ghosts.has(brick)) continue;
      const at = this.meets(brick, origin, direction, time);
      if (at < nearest) [nearest, found] = [at, brick];
    }
    return found;
  }

  // Where a ray enters a brick, in its own length; Infinity if it misses.
  private meets(brick: number, origin: Vector3, direction: Vector3, time: number): number {
    this.run.poseAt(brick, time, this.pose);
    const back = this.pose.orientation.conjugate();
    const from = origin.clone().sub(this.pose.position).applyQuaternion(back);
    return intoBox(from, direction.clone().applyQuaternion(back), this.run.halves[this.run.told.bricks.shape[brick]]);
  }

  // What hides the picked brick is drawn as if of glass: all above it, and all between it and the eye.
  private hide({ xray, picked, time }: Look, toEye: (point: Vector3) => Vector3): void {
    const { run, ghosts } = this;
    ghosts.clear();
    if (!xray || picked === undefined || !run.isThere(picked, time)) return;
    run.poseAt(picked, time, this.other);
    const half = run.halves[run.told.bricks.shape[picked]];
    const points = CORNERS.map((corner) => corner.clone().multiply(half).multiplyScalar(INSIDE).applyQuaternion(this.other.orientation).add(this.other.position));
    const highest = points.reduce((most, { z }) => Math.max(most, z), -Infinity);
    const rays = points.map((point): [Vector3, Vector3] => [point, toEye(point)]);
    for (let brick = 0; brick < run.count; brick++) {
      if (brick === picked || !run.isThere(brick, time)) continue;
      run.poseAt(brick, time, this.pose);
      if (this.pose.position.z > highest || rays.some(([point, way]) => this.meets(brick, point, way, time) < Infinity)) ghosts.add(brick);
    }
  }

  // Around what is built, where it is set down, and where it ends if that is not far away. Of structures so far apart that
  // none could be seen beside the other, the one that falls first, or the one with the most bricks.
  private builtWithin(): [Sphere, Sphere] {
    const { run } = this;
    const built = Array.from({ length: run.count }, (_, brick) => brick).filter((brick) => !run.told.bricks.thrown[brick]);
    if (!built.length) return [new Sphere(new Vector3(), Infinity), new Sphere(new Vector3(), this.size)];
    const all = this.around(built, -1);
    const groups = this.groups(built);
    const fall = (group: number[]): number => group.reduce((first, brick) => Math.min(first, run.told.bricks.left[brick] ?? Infinity), Infinity);
    groups.sort((one, other) => (fall(one) < fall(other) ? -1 : fall(one) > fall(other) ? 1 : other.length - one.length));
    const first = this.around(groups[0], -1);
    this.apart = groups.length > 1 && all.radius > APART * first.radius ? built.length - groups[0].length : 0;
    const found = this.apart ? first : all;
    const near = new Sphere(found.center, NEARBY * found.radius);
    const ended = built.filter((brick) => near.containsPoint(this.centreAt(brick, run.told.end)));
    return [near, ended.length ? found.clone().union(this.around(ended, run.told.end)) : found];
  }

  private around(bricks: number[], time: number): Sphere {
    return new Sphere().setFromPoints(bricks.flatMap((brick) => this.cornersOf(brick, time)));
  }

  private centreAt(brick: number, time: number): Vector3 {
    this.run.poseAt(brick, time, this.pose);
    return this.pose.position;
  }

  private cornersOf(brick: number, time: number): Vector3[] {
    const { run, pose } = this;
    run.poseAt(brick, time, pose);
    return run.told.shapes[run.told.bricks.shape[brick]].corners.map((corner) => new Vector3(...corner).applyQuaternion(pose.orientation).add(pose.position));
  }

  // Bricks in cells that touch each other, a few bricks wide.
  private groups(bricks: number[]): number[][] {
    const cells = new Map<string, number[]>();
    const wide = 8 * this.size;
    for (const brick of bricks) {
      const key = this.centreAt(brick, -1).toArray().map((x) => Math.floor(x / wide)).join();
      const inside = cells.get(key);
      if (inside) inside.push(brick);
      else cells.set(key, [brick]);
    }
    const groups: number[][] = [];
    while (cells.size) {
      const group: number[] = [];
      const next = [cells.keys().next().value!];
      for (let key = next.pop(); key !== undefined; key = next.pop()) {
        const inside = cells.get(key);
        if (!inside) continue;
        cells.delete(key);
        for (const brick of inside) group.push(brick); // a spread of many would be too many arguments
        const [x, y, z] = key.split(",").map(Number);
        for (const a of [-1, 0, 1]) for (const b of [-1, 0, 1]) for (const c of [-1, 0, 1]) next.push([x + a, y + b, z + c].join());
      }
      groups.push(group);
    }
    return groups;
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
    const { center, radius } = this.home;
    const normal = new Vector3(...plane.normal);
    const foot = center.clone().addScaledVector(normal, -normal.dot(center.clone().sub(new Vector3(...plane.point))));
    const wide = 3.5 * Math.max(radius, this.size);
    const paint = new ShaderMaterial({
      vertexShader: GROUND_VERTEX,
      fragmentShader: GROUND_FRAGMENT,
      transparent: true,
      depthWrite: false,
      side: DoubleSide,
      uniforms: {
        ...this.light,
        ground: { value: token("--ground") },
        lines: { value: token("--grid") },
        each: { value: this.grid },
        wide: { value: wide },
        solid: { value: normal.z > 0.5 ? 1 : 0.3 },
        origin: { value: new Vector2() },
      },
    });
    const mesh = new Mesh(new PlaneGeometry(2 * wide, 2 * wide), paint);
    mesh.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), normal);
    const away = foot.clone().applyQuaternion(mesh.quaternion.clone().invert());
    paint.uniforms.origin.value.set(away.x % (5 * this.grid), away.y % (5 * this.grid)); // lines stay where they are in the world
    mesh.position.copy(foot).addScaledVector(normal, -1e-3 * this.size);
    mesh.onBeforeRender = () => {
      paint.uniforms.ground.value = token("--ground");
      paint.uniforms.lines.value = token("--grid");
    };
    return mesh;
  }
}

const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => new Vector3(bits & 1 ? 1 : -1, bits & 2 ? 1 : -1, bits & 4 ? 1 : -1)).concat(new Vector3());

const GROUND_VERTEX = `
  uniform mat4 shade;
  varying vec2 vAt;
  varying vec3 vShade;
  void main() {
    vAt = position.xy;
    vec4 at = modelMatrix * vec4(position, 1.0);
    #ifdef SHADOWS
    vShade = (shade * at).xyz;
    #endif
    gl_Position = projectionMatrix * (viewMatrix * at);
  }`;
const GROUND_FRAGMENT = `
  uniform vec3 ground;
  uniform vec3 lines;
  uniform vec2 origin;
  uniform float each;
  uniform float wide;
  uniform float solid;
  uniform float pixel;
  varying vec2 vAt;
  varying vec3 vShade;
  ${SHADED}
  float grid(float by) {
    vec2 at = (vAt + origin) / by;
    vec2 one = fwidth(at);
    vec2 away = abs(fract(at - 0.5) - 0.5) / max(one, 1e-9) / pixel;
    return (1.0 - clamp(min(away.x, away.y) - 0.1, 0.0, 1.0)) * (1.0 - smoothstep(0.08, 0.3, max(one.x, one.y)));
  }
  void main() {
    float line = max(0.5 * grid(each), grid(5.0 * each));
    vec3 colour = mix(ground, lines, line) * mix(0.6, 1.0, lit(vShade));
    float far = length(vAt) / wide;
    gl_FragColor = vec4(colour, (gl_FrontFacing ? solid : 0.3) * (1.0 - smoothstep(0.55, 1.0, far)));
    #include <colorspace_fragment>
  }`;

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
