// The picture: one canvas for the bricks, one for what is drawn over them, one camera, and one run, or two side by side that
// are seen from the same place.
import { OrthographicCamera, PerspectiveCamera, Sphere, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { token } from "./colours";
import { lengthText, type Sight } from "./overlays";
import { colourOf } from "./page";
import type { Stage } from "./stage";
import { howMany } from "./wording";

export type From = "three-quarter" | "front" | "side" | "plan" | "weakest";
const DIRECTIONS: Record<Exclude<From, "weakest">, Vector3> = {
  "three-quarter": new Vector3(0.75, -1, 0.55).normalize(),
  front: new Vector3(0, -1, 0),
  side: new Vector3(1, 0, 0),
  plan: new Vector3(0, -1e-4, 1).normalize(),
};
const UP = new Vector3(0, 0, 1);
const ASIDE = Math.sin((45 * Math.PI) / 180); // of a throw: more is not looked for
const OPPOSITE = -0.55; // cosine of the angle to a throw up to which what it hits is seen from the side that is hit
const TURNS = Array.from({ length: 73 }, (_, place) => (((place % 2 ? 1 : -1) * Math.ceil(place / 2) * 5 * Math.PI) / 180)); // from the least on
const FIELD = 35; // [deg]
const TANGENT = Math.tan((FIELD / 2) * (Math.PI / 180));
const ROOM = 0.85; // share of the height that is filled
const [FOOT, FORCES] = [24, 58]; // [px] that the scales at the foot take up without and with that of forces
const FREE = 0.95; // of what is left above the scales at the foot, at most
const CENTRING = 4; // steps towards the middle, each of which leaves a small part of what is missing
const WIDER = 1.3; // times as far away as what is there needs: what of it is near later is taken in up to that
const MOVING = 280; // [ms] that the camera takes to a new place
const GROWN = 1.25; // times what was last fitted: then it is fitted anew
const FINE = 2; // pixels for each of the screen, along one side, of a picture that rests and was drawn without smooth edges
const LAGGING = 120; // [ms] by which shadows may lag behind where frames take too long
const FINGER = 14; // [px] around a tap in which a brick is looked for
const STILL = matchMedia("(prefers-reduced-motion: reduce)");

interface Place {
  target: Vector3;
  direction: Vector3; // from the target to the eye
  away: number; // [m]
}

export class Viewer {
  readonly canvas = document.createElement("canvas");
  readonly over = document.createElement("canvas");
  stages: Stage[] = [];
  from: From = "three-quarter";
  sharpness = 1; // pixels that are drawn for each of the screen, along one side
  turned = false; // whether the person has moved the camera since it was last fitted
  private foot = FOOT; // [px] of the picture that scales take up
  private whole = false; // whether structures far away are fitted as well
  readonly coarse: boolean; // whether a picture that rests is drawn again with smooth edges
  private readonly renderer: WebGLRenderer | undefined; // missing where the browser draws no bricks
  private readonly near = new PerspectiveCamera(FIELD, 1, 0.001, 1000);
  private readonly flat = new OrthographicCamera();
  private readonly controls: OrbitControls;
  private fittedAt: [number, number] | undefined; // the times that it was fitted to [s]
  private fitted: Sphere | undefined; // around what was last fitted
  private move: { from: Place; to: Place; began: number } | undefined;

  constructor(private readonly changed: () => void) {
    const drawnBy = whatDraws();
    const software = /swiftshader|llvmpipe|software/i.test(drawnBy); // smooth outlines would cost half of the frames
    this.coarse = software && devicePixelRatio < FINE;
    this.renderer = drawnBy ? new WebGLRenderer({ canvas: this.canvas, antialias: !software }) : undefined;
    if (this.renderer) this.renderer.autoClear = false;
    this.near.up.set(0, 0, 1);
    this.flat.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.near, this.canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("start", () => ([this.turned, this.move] = [true, undefined]));
    this.over.className = "over";
  }

  // True if the browser can draw bricks.
  get draws(): boolean {
    return this.renderer !== undefined;
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

  // Whether it is known from where a motion of the weakest part is seen from aside.
  get knowsWeakest(): boolean {
    return Boolean(this.stages[0]?.run.told.weakest);
  }

  look(from: From, time: number, also = time, smoothly = true): void {
    this.from = from;
    this.fit(time, from === "weakest" ? this.aside() : from === "three-quarter" ? this.besideThrows() : DIRECTIONS[from], also, smoothly);
  }

  // See it again from where it is seen now, or if that is what is seen, with structures that are far away.
  refit(time: number): void {
    this.whole = !this.whole && !this.turned && !this.move && this.stages.some((stage) => stage.apart > 0);
    this.fit(time);
  }

  // See all that is there, from a direction or from where it is seen now, in the middle; and what of it is near at another time,
  // unless that would make it much smaller.
  fit(time: number, from?: Vector3, also = time, smoothly = true): void {
    const corners = this.cornersAt(time);
    if (!corners.length) return;
    this.turned = false;
    this.fittedAt = [time, also];
    this.fitted = new Sphere().setFromPoints(corners);
    const direction = (from ?? this.place().direction).clone().normalize();
    const right = new Vector3().crossVectors(this.controls.object.up, direction).normalize();
    const upwards = new Vector3().crossVectors(direction, right);
    const high = TANGENT * Math.min(ROOM, FREE * (1 - this.foot / Math.max(1, this.canvas.clientHeight)));
    const wide = TANGENT * ROOM * this.aspect;
    const axes = [right, upwards, direction];
    const along = (all: Vector3[]): Float64Array[] => axes.map((axis) => Float64Array.from(all, (corner) => axis.dot(corner)));
    const [now, later] = [along(corners), along(also === time ? [] : this.cornersAt(also))];
    const middle = axes.map((axis) => axis.dot(this.fitted!.center));
    const nearer = this.orthographic ? 0 : 1; // what is nearer looks larger
    const needs = ([xs, ys, zs]: Float64Array[]): number => {
      let most = 0;
      for (let place = 0; place < xs.length; place++) most = Math.max(most, Math.max(Math.abs(ys[place] - middle[1]) / high, Math.abs(xs[place] - middle[0]) / wide) + nearer * (zs[place] - middle[2]));
      return most;
    };
    let away = 0;
    for (let turn = 0; turn <= CENTRING; turn++) {
      const least = needs(now);
      away = Math.max(least, Math.min(WIDER * least, needs(later)));
      if (turn === CENTRING) break;
      for (const axis of [0, 1]) {
        let [low, top] = [Infinity, -Infinity];
        for (let place = 0; place < corners.length; place++) {
          const seen = (now[axis][place] - middle[axis]) / (1 - (nearer * (now[2][place] - middle[2])) / away);
          [low, top] = [Math.min(low, seen), Math.max(top, seen)];
        }
        middle[axis] += (low + top) / 2;
      }
    }
    const target = axes.reduce((sum, axis, place) => sum.addScaledVector(axis, middle[place]), new Vector3());
    this.goTo({ target, direction, away }, smoothly);
  }

  private cornersAt(time: number): Vector3[] {
    return this.stages.flatMap((stage) => stage.corners(time, this.whole));
  }

  // Fit it again if it has grown out of the picture, unless the person has turned it since.
  follow(time: number): void {
    const { fitted } = this;
    if (this.turned || this.whole || this.move || !fitted) return;
    if (this.stages.some((stage) => stage.reach(time, fitted.center) > GROWN * fitted.radius)) this.fit(time);
  }

  // The canvas has another size: what was fitted to it is fitted again.
  resized(): void {
    if (!this.turned && this.fittedAt) this.fit(this.fittedAt[0], this.move?.to.direction, this.fittedAt[1], false);
  }

  // Keep the foot of the picture free for the scale of forces, or not any more.
  keepFree(forces: boolean): void {
    const foot = forces ? FORCES : FOOT;
    if (foot === this.foot) return;
    this.foot = foot;
    this.resized();
  }

  // Move along with something.
  shift(by: Vector3): void {
    this.controls.target.add(by);
    this.controls.object.position.add(by);
    this.controls.update();
  }

  zoom(factor: number): void {
    this.settle();
    this.turned = true;
    const { target, direction, away } = this.place();
    this.stand({ target, direction, away: away / factor });
  }

  // End a motion of the camera at once.
  settle(): void {
    if (this.move) this.stand(this.move.to);
    this.move = undefined;
  }

  // Draw it; finely if it rests.
  draw(finely = false): void {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const { renderer } = this;
    if (!width || !height || !renderer) return;
    this.advance();
    const size = renderer.getSize(new Vector2());
    const ratio = finely ? FINE : Math.min(devicePixelRatio, FINE) * this.sharpness;
    if (size.x !== width || size.y !== height || renderer.getPixelRatio() !== ratio) {
      renderer.setPixelRatio(ratio);
      renderer.setSize(width, height, false);
    }
    this.suit();
    for (const stage of this.stages) stage.cast(renderer, this.sharpness < 1 ? LAGGING : 0);
    renderer.setClearColor(token("--scene"));
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.setScissorTest(true);
    const each = width / Math.max(1, this.stages.length);
    this.stages.forEach((stage, place) => {
      renderer.setViewport(place * each, 0, each, height);
      renderer.setScissor(place * each, 0, each, height);
      stage.draw(renderer, this.controls.object, ratio);
    });
    this.drawOver(width, height);
    if (this.move) this.changed();
  }

  private drawOver(width: number, height: number): void {
    const sharp = Math.min(devicePixelRatio, FINE);
    if (this.over.width !== Math.round(width * sharp) || this.over.height !== Math.round(height * sharp)) [this.over.width, this.over.height] = [Math.round(width * sharp), Math.round(height * sharp)];
    const pen = this.over.getContext("2d")!;
    pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    pen.clearRect(0, 0, width, height);
    this.stages.forEach((stage, place) => {
      const sight = this.sight(place);
      pen.save();
      pen.beginPath();
      pen.rect(sight.left, 0, sight.width, height);
      pen.clip();
      stage.drawOver(pen, sight);
      pen.font = `12px ${colourOf("--sans")}`;
      pen.textAlign = "left";
      pen.textBaseline = "alphabetic";
      pen.fillStyle = colourOf("--ink-2");
      if (stage.run.told.planes.length) pen.fillText(`grid ${lengthText(stage.grid)}`, sight.left + 12, height - 10);
      if (stage.apart && !this.whole) pen.fillText(`${howMany(stage.apart, "more brick")} far away: Fit, twice, shows all`, sight.left + 12, 20);
      pen.restore();
    });
  }

  // How one of the stages is seen.
  sight(place: number): Sight {
    this.suit();
    const camera = this.controls.object;
    camera.updateMatrixWorld();
    const height = this.canvas.clientHeight;
    const width = this.canvas.clientWidth / Math.max(1, this.stages.length);
    const left = place * width;
    const seen = new Vector3();
    return {
      left,
      width,
      height,
      at: (point) => {
        seen.copy(point).project(camera);
        return [left + ((seen.x + 1) / 2) * width, ((1 - seen.y) / 2) * height];
      },
      scale: (point) => (height / (2 * TANGENT)) * (this.orthographic ? this.flat.zoom / this.place().away : 1 / Math.max(1e-9, -seen.copy(point).applyMatrix4(camera.matrixWorldInverse).z)),
      toEye: (point) => this.toEye(point),
      sees: (brick, [x, y]) => this.pick(x, y)?.[1] === brick,
    };
  }

  // The way from a point to the eye.
  toEye(point: Vector3): Vector3 {
    const { target, direction, away } = this.place();
    return this.orthographic ? direction : target.addScaledVector(direction, away).sub(point).normalize();
  }

  // The brick under a point of the canvas [px], and in which of the stages; near a tap if there is none under it.
  pick(x: number, y: number, tapped = false): [number, number] | undefined {
    if (!this.stages.length) return undefined;
    const each = this.canvas.clientWidth / Math.max(1, this.stages.length);
    const place = Math.min(this.stages.length - 1, Math.max(0, Math.floor(x / each)));
    const inside = new Vector2((2 * (x - place * each)) / each - 1, 1 - (2 * y) / this.canvas.clientHeight);
    this.suit();
    const camera = this.controls.object;
    camera.updateMatrixWorld();
    const origin = new Vector3(inside.x, inside.y, -1).unproject(camera);
    const direction = new Vector3(inside.x, inside.y, 1).unproject(camera).sub(origin).normalize();
    const brick = this.stages[place].pick(origin, direction);
    if (brick !== undefined) return [place, brick];
    if (!tapped) return undefined;
    for (let turn = 0; turn < 8; turn++) {
      const found = this.pick(x + FINGER * Math.cos((turn * Math.PI) / 4), y + FINGER * Math.sin((turn * Math.PI) / 4));
      if (found) return found;
    }
    return undefined;
  }

  // Where a point is on the canvas [px], in one of the stages.
  onScreen(point: Vector3, place: number): [number, number] {
    return this.sight(place).at(point);
  }

  // Where the camera stands; zooming in with parallel rays counts as going nearer.
  private place(): Place {
    const { object, target } = this.controls;
    const direction = object.position.clone().sub(target);
    const away = direction.length();
    return { target: target.clone(), direction: direction.divideScalar(away || 1), away: away / (this.orthographic ? this.flat.zoom : 1) };
  }

  private stand({ target, direction, away }: Place): void {
    this.controls.target.copy(target);
    this.controls.object.position.copy(target).addScaledVector(direction, away);
    this.flat.zoom = 1;
    this.controls.update();
  }

  private goTo(to: Place, smoothly: boolean): void {
    this.move = smoothly && !STILL.matches ? { from: this.place(), to, began: performance.now() } : undefined;
    if (this.move) this.changed();
    else this.stand(to);
  }

  private advance(): void {
    if (!this.move) return;
    const { from, to, began } = this.move;
    const part = (performance.now() - began) / MOVING;
    if (part >= 1) return this.settle();
    const eased = part < 0.5 ? 2 * part * part : 1 - 2 * (1 - part) ** 2;
    const direction = from.direction.clone().lerp(to.direction, eased).normalize();
    this.stand({ target: from.target.clone().lerp(to.target, eased), direction, away: from.away * (to.away / from.away) ** eased });
  }

  // Three quarters from the front, turned by as little as lets every throw be seen, if possible from the side where it comes
  // from, and aside of its path: what is hit would else hide what is thrown, or the other way round.
  private besideThrows(): Vector3 {
    const [usual, bearings] = [DIRECTIONS["three-quarter"], this.stages.flatMap((stage) => stage.bearings())];
    const turned = (angle: number): Vector3 => usual.clone().applyAxisAngle(UP, angle);
    const quality = (angle: number): number => {
      const { x, y } = turned(angle);
      const ways = bearings.map((bearing) => Math.atan2(y, x) - bearing);
      return ways.filter((way) => Math.cos(way) < OPPOSITE).length + ways.reduce((least, way) => Math.min(least, Math.abs(Math.sin(way))), ASIDE);
    };
    return turned(TURNS.reduce((best, angle) => (quality(angle) > quality(best) + 1e-9 ? angle : best)));
  }

  // From aside of the way in which the weakest part gives way.
  private aside(): Vector3 {
    const bearing = ((this.stages[0]?.run.told.weakest?.bearing_deg ?? 0) * Math.PI) / 180;
    const side = new Vector3(Math.sin(bearing), -Math.cos(bearing), 0);
    if (side.y > 1e-9) side.negate(); // from the front rather than from behind
    return side.setZ(0.2).normalize();
  }

  private get aspect(): number {
    return this.canvas.clientWidth / Math.max(1, this.stages.length) / Math.max(1, this.canvas.clientHeight);
  }

  private suit(): void {
    const away = this.controls.object.position.distanceTo(this.controls.target);
    const [width, height] = [this.canvas.clientWidth / Math.max(1, this.stages.length), Math.max(1, this.canvas.clientHeight)];
    this.near.near = away / 100;
    this.near.far = away * 100;
    const high = away * TANGENT;
    [this.flat.top, this.flat.bottom, this.flat.left, this.flat.right] = [high, -high, -high * this.aspect, high * this.aspect];
    [this.flat.near, this.flat.far] = [-away * 100, away * 100];
    for (const camera of [this.near, this.flat]) camera.setViewOffset(width, height, 0, this.foot / 2, width, height); // above the scales
  }
}

// The name of what draws; empty if nothing does.
function whatDraws(): string {
  const probe = document.createElement("canvas").getContext("webgl2");
  if (!probe) return "";
  const name = String(probe.getParameter(probe.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL ?? probe.RENDERER));
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return name || "unknown";
}
