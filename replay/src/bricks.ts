// All bricks of a run as one mesh: solids with darker rims. Where each is stands in a texture, so that all are drawn at once: where
// the processor draws, instances are drawn one after the other, which takes ten times as long as what is seen of them.
import { BufferAttribute, BufferGeometry, type Color, DataTexture, DoubleSide, FloatType, Matrix4, Mesh, Quaternion, RGBAFormat, ShaderMaterial, Vector3 } from "three";
import type { Payload } from "./payload";
import type { Pose, Run } from "./run";

const EACH = 3; // texels of a brick: its position and mark, its orientation, its colour
const ROW = 256; // bricks in a row of the texture
const HIDDEN = -1; // mark of a brick that is not drawn

// The faces of a shape: numbers of its corners, and what each of them has.
interface Solid {
  points: number[];
  normals: number[];
  rims: number[];
  triangles: number[];
}

// Faces with `rim`, from which the shader tells the distance to the nearest edge of the face [m]: min(z - |x|, w - |y|).
// A rectangle has two triangles, any other face a fan about its middle. Faces of a curved surface have no rims, and common normals.
function solid(shape: Payload["shapes"][number]): Solid {
  const { points, normals, rims, triangles }: Solid = { points: [], normals: [], rims: [], triangles: [] };
  const corners = shape.corners.map((corner) => new Vector3(...corner));
  const add = (point: Vector3, normal: Vector3, rim: number[]): number => {
    points.push(...point.toArray());
    normals.push(...normal.toArray());
    return rims.push(...rim) / 4 - 1;
  };
  const curved = new Set(shape.curved);
  const smooth = corners.map(() => new Vector3());
  const across = (face: number[]): Vector3 => face.slice(1, -1).reduce((sum, corner, place) => sum.add(corners[corner].clone().sub(corners[face[0]]).cross(corners[face[place + 2]].clone().sub(corners[face[0]]))), new Vector3());
  for (const number of curved) for (const corner of shape.faces[number]) smooth[corner].add(across(shape.faces[number]).normalize());
  for (const [number, face] of shape.faces.entries()) {
    if (curved.has(number)) {
      const [first, ...others] = face.map((corner) => add(corners[corner], smooth[corner].clone().normalize(), [0, 0, 1e9, 1e9]));
      others.slice(1).forEach((corner, place) => triangles.push(first, others[place], corner));
      continue;
    }
    const ring = face.map((corner) => corners[corner]);
    const middle = ring.reduce((sum, corner) => sum.add(corner), new Vector3()).divideScalar(ring.length);
    const normal = ring[0].clone().sub(middle).cross(ring[1].clone().sub(ring[0])).normalize();
    const [along, aside] = [ring[1].clone().sub(ring[0]), ring[2].clone().sub(ring[1])];
    const [a, b] = [along.length() / 2, aside.length() / 2];
    const far = ring.map((corner) => corner.distanceTo(middle));
    if (ring.length === 4 && Math.abs(along.dot(aside)) < 1e-9 * a * b && Math.max(...far) - Math.min(...far) < 1e-6 * far[0]) {
      const [first, second, third, fourth] = [[-a, -b], [a, -b], [a, b], [-a, b]].map(([x, y], place) => add(ring[place], normal, [x, y, a, b]));
      triangles.push(first, second, third, first, third, fourth);
      continue;
    }
    ring.forEach((from, place) => {
      const to = ring[(place + 1) % ring.length];
      const rim = middle.clone().sub(from).cross(to.clone().sub(from)).length() / to.distanceTo(from);
      triangles.push(...([[middle, rim], [from, 0], [to, 0]] as [Vector3, number][]).map(([point, high]) => add(point, normal, [0, 0, high, 1e9])));
    });
  }
  return { points, normals, rims, triangles };
}

// The solids of all bricks, one after the other.
function geometryOf({ shapes, bricks }: Payload): BufferGeometry {
  const solids = shapes.map(solid);
  const sum = (one: (of: Solid) => number[]): number => bricks.shape.reduce((sum, shape) => sum + one(solids[shape]).length, 0);
  const [points, normals, rims] = [(of: Solid) => of.points, (of: Solid) => of.normals, (of: Solid) => of.rims].map((one) => new Float32Array(sum(one)));
  const of = new Float32Array(points.length / 3);
  const triangles = new Uint32Array(sum((solid) => solid.triangles));
  let [at, next] = [0, 0];
  bricks.shape.forEach((shape, brick) => {
    const one = solids[shape];
    const count = one.points.length / 3;
    points.set(one.points, 3 * at);
    normals.set(one.normals, 3 * at);
    rims.set(one.rims, 4 * at);
    of.fill(brick, at, at + count);
    for (const corner of one.triangles) triangles[next++] = at + corner;
    at += count;
  });
  const geometry = new BufferGeometry();
  for (const [name, values, size] of [["position", points, 3], ["normal", normals, 3], ["rim", rims, 4], ["brick", of, 1]] as [string, Float32Array, number][]) geometry.setAttribute(name, new BufferAttribute(values, size));
  geometry.setIndex(new BufferAttribute(triangles, 1));
  return geometry;
}

// Marks of a brick: its rim is wider then, and has a colour of its own.
export const enum Mark {
  None,
  Hovered,
  Picked,
  Different,
}
const GHOSTLY = 0.5; // added to a mark: what lies before the picked brick is drawn as if of glass

// Light from the sun depends on the face alone, so it is worked out at its corners; and points are multiplied by matrices
// one after the other, as products of matrices would cost the most of all where the processor draws.
const PLACE = `
  attribute float brick;
  uniform highp sampler2D places;
  vec4 told(int part) {
    int at = int(brick + 0.5);
    return texelFetch(places, ivec2(${EACH} * (at % ${ROW}) + part, at / ${ROW}), 0);
  }
  vec3 turned(vec4 by, vec3 way) { return way + 2.0 * cross(by.xyz, cross(by.xyz, way) + by.w * way); }`;
const VERTEX = `
  attribute vec4 rim;
  ${PLACE}
  uniform vec3 sun;
  uniform float shift;
  uniform mat4 shade;
  varying vec4 vTint;
  varying vec4 vRim;
  varying vec2 vLight;
  varying vec3 vShade;
  void main() {
    vec4 place = told(0);
    bool ghost = fract(place.w) > 0.25;
    #ifdef GHOST
    ghost = !ghost;
    #endif
    if (ghost || place.w < 0.0) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
    vec4 turn = told(1);
    vec3 n = turned(turn, normal);
    vec4 at = vec4(place.xyz + turned(turn, position), 1.0);
    vLight = vec2(0.58 + 0.1 * n.z, 0.42 * max(0.0, dot(n, sun)));
    vTint = vec4(told(2).rgb, place.w);
    vRim = rim;
    #ifdef SHADOWS
    float steep = length(cross(n, sun)); // the steeper the light, the farther is what is looked up beside a point from its plane
    vShade = (shade * vec4(at.xyz + shift * steep * n, 1.0)).xyz;
    #endif
    gl_Position = projectionMatrix * (viewMatrix * at);
  }`;
const CAST = `
  ${PLACE}
  void main() {
    vec4 place = told(0);
    gl_Position = place.w < 0.0 || fract(place.w) > 0.25 ? vec4(2.0) : projectionMatrix * (viewMatrix * vec4(place.xyz + turned(told(1), position), 1.0));
  }`;
export const SHADED = `
  #ifdef SHADOWS
  uniform sampler2DShadow shadows;
  uniform float soft;
  float lit(vec3 at) {
    if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
    float sum = 2.0 * texture(shadows, at);
    for (int place = 0; place < 4; place++) {
      vec2 aside = soft * (place < 2 ? vec2(float(2 * place - 1), 0.6) : vec2(0.6, float(2 * place - 5)));
      sum += texture(shadows, vec3(at.xy + aside, at.z));
    }
    return sum / 6.0;
  }
  #else
  float lit(vec3 at) { return 1.0; }
  #endif`;
const FRAGMENT = `
  varying vec4 vTint;
  varying vec4 vRim;
  varying vec2 vLight;
  varying vec3 vShade;
  uniform vec3 outlines[4];
  uniform float pixel;
  ${SHADED}
  void main() {
    float rim = min(vRim.z - abs(vRim.x), vRim.w - abs(vRim.y));
    int mark = int(vTint.w + 0.25); // between corners it is not quite whole
    float wide = (mark == 0 ? 0.4 : 1.6) * pixel;
    float each = max(fwidth(rim), 1e-9);
    float inside = clamp(rim / each - wide, 0.0, 1.0);
    if (mark == 0) inside = mix(1.0, inside, clamp(min(vRim.z, vRim.w) / each / pixel / 6.0, 0.25, 1.0)); // rims of what is tiny would hide it
    float light = vLight.x + vLight.y * lit(vShade);
    vec3 fill = vTint.rgb * light * light;
    #ifdef GHOST
    gl_FragColor = vec4(mix(outlines[mark], vTint.rgb, inside), mix(0.6, 0.1, inside));
    #else
    gl_FragColor = vec4(mix(outlines[mark], fill, inside * 0.94 + 0.06), 1.0);
    #endif
    #include <colorspace_fragment>
  }`;

// What lets its light fall on a scene; stage.ts sets it, and draws what the sun sees.
export type Light = Record<"sun" | "shift" | "shade" | "shadows" | "soft" | "outlines" | "pixel", { value: unknown }>;

export class Bricks {
  readonly mesh: Mesh;
  readonly ghosts: Mesh; // the same bricks, of which only ghosts are drawn
  readonly material: ShaderMaterial;
  readonly cast: ShaderMaterial; // what the sun sees: how far each place is from it
  private readonly places: DataTexture;
  private readonly data: Float32Array;
  private readonly turn = new Quaternion();

  constructor(run: Run, light: Light) {
    const rows = Math.ceil(run.count / ROW) || 1;
    this.data = new Float32Array(4 * EACH * ROW * rows);
    this.places = new DataTexture(this.data, EACH * ROW, rows, RGBAFormat, FloatType);
    const uniforms = { ...light, places: { value: this.places } };
    this.material = new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms });
    this.cast = new ShaderMaterial({ vertexShader: CAST, fragmentShader: "void main() { gl_FragColor = vec4(1.0); }", uniforms, side: DoubleSide });
    const geometry = geometryOf(run.told);
    this.mesh = new Mesh(geometry, this.material);
    this.ghosts = new Mesh(geometry, new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, defines: { GHOST: "" }, transparent: true, depthWrite: false }));
    this.mesh.frustumCulled = this.ghosts.frustumCulled = false;
  }

  hide(brick: number): void {
    this.data[4 * EACH * brick + 3] = HIDDEN;
  }

  put(brick: number, { position, orientation }: Pose): void {
    position.toArray(this.data, 4 * EACH * brick);
    orientation.toArray(this.data, 4 * (EACH * brick + 1));
  }

  paint(brick: number, colour: Color, mark: Mark, ghost: boolean): void {
    this.data[4 * EACH * brick + 3] = mark + (ghost ? GHOSTLY : 0);
    colour.toArray(this.data, 4 * (EACH * brick + 2));
  }

  // Where a brick is drawn.
  drawn(brick: number, matrix: Matrix4): Matrix4 {
    const at = 4 * EACH * brick;
    return matrix.makeRotationFromQuaternion(this.turn.fromArray(this.data, at + 4)).setPosition(this.data[at], this.data[at + 1], this.data[at + 2]);
  }

  done(): void {
    this.places.needsUpdate = true;
  }

  // It is not drawn any more.
  forget(): void {
    this.mesh.geometry.dispose();
    this.places.dispose();
  }
}
