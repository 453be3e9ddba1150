// All bricks of a run as a few instanced meshes, one a shape: solids with darker rims.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DynamicDrawUsage,
  InstancedBufferAttribute,
  InstancedMesh,
  Matrix4,
  Object3D,
  type Quaternion,
  ShaderMaterial,
  Vector3,
} from "three";
import type { Payload } from "./payload";
import type { Pose, Run } from "./run";

const NOWHERE = new Matrix4().makeScale(0, 0, 0);

// Faces with `rim`, from which the shader tells the distance to the nearest edge of the face [m]: min(z - |x|, w - |y|).
// A rectangle has two triangles, any other face a fan about its middle.
function solid(shape: Payload["shapes"][number]): BufferGeometry {
  const points: number[] = [];
  const normals: number[] = [];
  const rims: number[] = [];
  const triangles: number[] = [];
  const corners = shape.corners.map((corner) => new Vector3(...corner));
  const add = (point: Vector3, normal: Vector3, rim: number[]): number => {
    points.push(...point.toArray());
    normals.push(...normal.toArray());
    return rims.push(...rim) / 4 - 1;
  };
  for (const face of shape.faces) {
    const ring = face.map((corner) => corners[corner]);
    const middle = ring.reduce((sum, corner) => sum.add(corner), new Vector3()).divideScalar(ring.length);
    const normal = ring[0].clone().sub(middle).cross(ring[1].clone().sub(ring[0])).normalize();
    const [along, across] = [ring[1].clone().sub(ring[0]), ring[2].clone().sub(ring[1])];
    const [a, b] = [along.length() / 2, across.length() / 2];
    const far = ring.map((corner) => corner.distanceTo(middle));
    if (ring.length === 4 && Math.abs(along.dot(across)) < 1e-9 * a * b && Math.max(...far) - Math.min(...far) < 1e-6 * far[0]) {
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
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  geometry.setAttribute("normal", new BufferAttribute(new Float32Array(normals), 3));
  geometry.setAttribute("rim", new BufferAttribute(new Float32Array(rims), 4));
  geometry.setIndex(triangles);
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
const VERTEX = `
  attribute vec4 rim;
  attribute vec4 tint;
  uniform vec3 sun;
  uniform float shift;
  uniform mat4 shade;
  varying vec4 vTint;
  varying vec4 vRim;
  varying vec2 vLight;
  varying vec3 vShade;
  void main() {
    bool ghost = fract(tint.w) > 0.25;
    #ifdef GHOST
    ghost = !ghost;
    #endif
    if (ghost) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
    vec3 n = mat3(instanceMatrix) * normal;
    vec4 at = instanceMatrix * vec4(position, 1.0);
    vLight = vec2(0.58 + 0.1 * n.z, 0.42 * max(0.0, dot(n, sun)));
    vTint = tint;
    vRim = rim;
    #ifdef SHADOWS
    float steep = length(cross(n, sun)); // the steeper the light, the farther is what is looked up beside a point from its plane
    vShade = (shade * vec4(at.xyz + shift * steep * n, 1.0)).xyz;
    #endif
    gl_Position = projectionMatrix * (viewMatrix * at);
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
  readonly group = new Object3D();
  readonly ghosts = new Object3D(); // the same bricks, of which only ghosts are drawn
  readonly material: ShaderMaterial;
  private readonly meshes: InstancedMesh[];
  private readonly slots: Int32Array; // of each brick in the mesh of its shape
  private readonly tints: InstancedBufferAttribute[];
  private readonly matrix = new Matrix4();
  private readonly whole = new Vector3(1, 1, 1);

  constructor(private readonly run: Run, light: Light) {
    const { shape } = run.told.bricks;
    const counts = run.told.shapes.map(() => 0);
    this.material = new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: light });
    const glass = new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: light, defines: { GHOST: "" }, transparent: true, depthWrite: false });
    this.slots = Int32Array.from(shape, (number) => counts[number]++);
    this.tints = counts.map((count) => new InstancedBufferAttribute(new Float32Array(4 * Math.max(count, 1)), 4));
    this.meshes = run.told.shapes.map((one, number) => {
      const geometry = solid(one);
      geometry.setAttribute("tint", this.tints[number].setUsage(DynamicDrawUsage));
      const mesh = new InstancedMesh(geometry, this.material, counts[number]);
      const ghost = new InstancedMesh(geometry, glass, counts[number]);
      mesh.instanceMatrix.setUsage(DynamicDrawUsage);
      ghost.instanceMatrix = mesh.instanceMatrix;
      mesh.frustumCulled = ghost.frustumCulled = false;
      this.group.add(mesh);
      this.ghosts.add(ghost);
      return mesh;
    });
  }

  hide(brick: number): void {
    this.meshes[this.run.told.bricks.shape[brick]].setMatrixAt(this.slots[brick], NOWHERE);
  }

  put(brick: number, pose: Pose): void {
    this.matrix.compose(pose.position, pose.orientation as Quaternion, this.whole);
    this.meshes[this.run.told.bricks.shape[brick]].setMatrixAt(this.slots[brick], this.matrix);
  }

  paint(brick: number, colour: Color, mark: Mark, ghost: boolean): void {
    this.tints[this.run.told.bricks.shape[brick]].setXYZW(this.slots[brick], colour.r, colour.g, colour.b, mark + (ghost ? GHOSTLY : 0));
  }

  // Where a brick is drawn.
  drawn(brick: number, matrix: Matrix4): Matrix4 {
    this.meshes[this.run.told.bricks.shape[brick]].getMatrixAt(this.slots[brick], matrix);
    return matrix;
  }

  done(): void {
    for (const mesh of this.meshes) mesh.instanceMatrix.needsUpdate = true;
    for (const tint of this.tints) tint.needsUpdate = true;
  }
}
