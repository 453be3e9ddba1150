// The picture: one canvas, one camera, and one run, or two side by side that are seen from the same place.
import { Color, OrthographicCamera, PerspectiveCamera, Sphere, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { colourOf } from "./page";
import type { Stage } from "./stage";

export type From = "three-quarter" | "front" | "side" | "plan";
const DIRECTIONS: Record<From, Vector3> = {
  "three-quarter": new Vector3(0.75, -1, 0.55).normalize(),
  front: new Vector3(0, -1, 0),
  side: new Vector3(1, 0, 0),
  plan: new Vector3(0, -1e-4, 1).normalize(),
};
const FIELD = 35; // [deg]
const NEARBY = 2; // times the ball around what stands: what ends farther out would make it tiny
const ROOM = 0.85; // share of the height that is filled

export class Viewer {
  readonly canvas = document.createElement("canvas");
  stages: Stage[] = [];
  from: From = "three-quarter";
  sharpness = 1; // pixels that are drawn for each of the screen, along one side
  private readonly renderer: WebGLRenderer;
  private readonly near = new PerspectiveCamera(FIELD, 1, 0.001, 1000);
  private readonly flat = new OrthographicCamera();
  private readonly controls: OrbitControls;

  constructor(changed: () => void) {
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: !drawnBySoftware() });
    this.renderer.autoClear = false;
    this.near.up.set(0, 0, 1);
    this.flat.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.near, this.canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", changed);
  }

  get orthographic(): boolean {
    return this.controls.object === this.flat;
  }

  set orthographic(wanted: boolean) {
    const [old, next] = [this.controls.object, wanted ? this.flat : this.near];
    next.position.copy(old.position);
    this.flat.zoom = 1;
    this.controls.object = next;
    this.controls.update();
  }

  look(from: From, time: number): void {
    this.from = from;
    this.fit(time, DIRECTIONS[from]);
  }

  // See all that is there, from a direction or from where it is seen now; and what of it is near at another time.
  fit(time: number, from?: Vector3, also = time): void {
    const corners = this.stages.flatMap((stage) => stage.corners(time));
    if (!corners.length) return;
    if (also !== time) {
      const around = new Sphere().setFromPoints(corners);
      around.radius *= NEARBY;
      corners.push(...this.stages.flatMap((stage) => stage.corners(also)).filter((corner) => around.containsPoint(corner)));
    }
    const camera = this.controls.object;
    const direction = (from ?? camera.position.clone().sub(this.controls.target)).clone().normalize();
    const up = Math.tan((FIELD / 2) * (Math.PI / 180)) * ROOM;
    const right = new Vector3().crossVectors(camera.up, direction).normalize();
    const upwards = new Vector3().crossVectors(direction, right);
    const middle = new Vector3();
    for (const axis of [direction, right, upwards]) {
      const [least, most] = corners.reduce(([low, high], corner) => [Math.min(low, corner.dot(axis)), Math.max(high, corner.dot(axis))], [Infinity, -Infinity]);
      middle.addScaledVector(axis, (least + most) / 2);
    }
    const away = corners.reduce((farthest, corner) => {
      corner.sub(middle);
      const aside = Math.max(Math.abs(corner.dot(upwards)) / up, Math.abs(corner.dot(right)) / up / this.aspect);
      return Math.max(farthest, aside + (this.orthographic ? 0 : corner.dot(direction))); // what is nearer looks larger
    }, 0);
    this.controls.target.copy(middle);
    camera.position.copy(this.controls.target).addScaledVector(direction, away);
    this.flat.zoom = 1;
    this.controls.update();
  }

  // Move along with something.
  shift(by: Vector3): void {
    this.controls.target.add(by);
    this.controls.object.position.add(by);
    this.controls.update();
  }

  zoom(factor: number): void {
    const camera = this.controls.object;
    camera.position.sub(this.controls.target).multiplyScalar(1 / factor).add(this.controls.target);
    this.controls.update();
  }

  draw(): void {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (!width || !height) return;
    const size = this.renderer.getSize(new Vector2());
    const ratio = Math.min(devicePixelRatio, 2) * this.sharpness;
    if (size.x !== width || size.y !== height || this.renderer.getPixelRatio() !== ratio) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
    }
    this.suit();
    this.renderer.setClearColor(new Color(colourOf("--paper")));
    this.renderer.setScissorTest(false);
    this.renderer.clear();
    this.renderer.setScissorTest(true);
    const each = width / Math.max(1, this.stages.length);
    this.stages.forEach((stage, place) => {
      this.renderer.setViewport(place * each, 0, each, height);
      this.renderer.setScissor(place * each, 0, each, height);
      this.renderer.render(stage.scene, this.controls.object);
    });
  }

  // The brick under a point of the canvas [px], and in which of the stages.
  pick(x: number, y: number, time: number): [number, number] | undefined {
    if (!this.stages.length) return undefined;
    const each = this.canvas.clientWidth / Math.max(1, this.stages.length);
    const place = Math.min(this.stages.length - 1, Math.floor(x / each));
    const inside = new Vector2((2 * (x - place * each)) / each - 1, 1 - (2 * y) / this.canvas.clientHeight);
    this.suit();
    const camera = this.controls.object;
    camera.updateMatrixWorld();
    const origin = new Vector3(inside.x, inside.y, -1).unproject(camera);
    const direction = new Vector3(inside.x, inside.y, 1).unproject(camera).sub(origin).normalize();
    const brick = this.stages[place].pick(origin, direction, time);
    return brick === undefined ? undefined : [place, brick];
  }

  // Where a point is on the canvas [px], in one of the stages.
  onScreen(point: Vector3, place: number): [number, number] {
    this.suit();
    const camera = this.controls.object;
    camera.updateMatrixWorld();
    const seen = point.clone().project(camera);
    const each = this.canvas.clientWidth / Math.max(1, this.stages.length);
    return [place * each + ((seen.x + 1) / 2) * each, ((1 - seen.y) / 2) * this.canvas.clientHeight];
  }

  private get aspect(): number {
    return this.canvas.clientWidth / Math.max(1, this.stages.length) / Math.max(1, this.canvas.clientHeight);
  }

  private suit(): void {
    const away = this.controls.object.position.distanceTo(this.controls.target);
    this.near.aspect = this.aspect;
    this.near.near = away / 100;
    this.near.far = away * 100;
    this.near.updateProjectionMatrix();
    const high = away * Math.tan((FIELD / 2) * (Math.PI / 180));
    [this.flat.top, this.flat.bottom, this.flat.left, this.flat.right] = [high, -high, -high * this.aspect, high * this.aspect];
    [this.flat.near, this.flat.far] = [-away * 100, away * 100];
    this.flat.updateProjectionMatrix();
  }
}

// Whether there is no graphics card: smooth outlines would cost half of the frames.
function drawnBySoftware(): boolean {
  const probe = document.createElement("canvas").getContext("webgl2");
  const name = String(probe?.getParameter(probe.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL ?? probe.RENDERER));
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
