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
  Quaternion,
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

// Light depends on the face alone, so it is worked out at its corners; and points are multiplied by matrices one after
// the other, as products of matrices would cost the most of all where the processor draws.
const material = new ShaderMaterial({
  vertexShader: `
    attribute vec4 rim;
    attribute vec3 tint;
    varying vec3 vTint;
    varying vec4 vRim;
    void main() {
      vec3 n = mat3(instanceMatrix) * normal;
      vTint = tint * (0.55 + 0.3 * n.z + 0.2 * dot(n, vec3(-0.505, -0.808, 0.303)));
      vRim = rim;
      gl_Position = projectionMatrix * (viewMatrix * (instanceMatrix * vec4(position, 1.0)));
    }`,
  fragmentShader: `
    varying vec3 vTint;
    varying vec4 vRim;
    void main() {
      float rim = min(vRim.z - abs(vRim.x), vRim.w - abs(vRim.y));
      float edge = clamp(rim / max(fwidth(rim), 1e-9) - 0.4, 0.0, 1.0);
      gl_FragColor = vec4(vTint * (0.35 + 0.65 * edge), 1.0);
      #include <colorspace_fragment>
    }`,
});

export class Bricks {
  readonly group = new Object3D();
  private readonly meshes: InstancedMesh[];
  private readonly slots: Int32Array; // of each brick in the mesh of its shape
  private readonly tints: InstancedBufferAttribute[];
  private readonly matrix = new Matrix4();
  private readonly whole = new Vector3(1, 1, 1);

  constructor(private readonly run: Run) {
    const { shape } = run.told.bricks;
    const counts = run.told.shapes.map(() => 0);
    this.slots = Int32Array.from(shape, (number) => counts[number]++);
    this.tints = counts.map((count) => new InstancedBufferAttribute(new Float32Array(3 * Math.max(count, 1)), 3));
    this.meshes = run.told.shapes.map((one, number) => {
      const geometry = solid(one);
      geometry.setAttribute("tint", this.tints[number].setUsage(DynamicDrawUsage));
      const mesh = new InstancedMesh(geometry, material, counts[number]);
      mesh.instanceMatrix.setUsage(DynamicDrawUsage);
      mesh.frustumCulled = false;
      this.group.add(mesh);
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

  paint(brick: number, colour: Color): void {
    this.tints[this.run.told.bricks.shape[brick]].setXYZ(this.slots[brick], colour.r, colour.g, colour.b);
  }

  // Where a brick is drawn.
  drawn(brick: number, position: Vector3): Vector3 {
    this.meshes[this.run.told.bricks.shape[brick]].getMatrixAt(this.slots[brick], this.matrix);
    return position.setFromMatrixPosition(this.matrix);
  }

  done(): void {
    for (const mesh of this.meshes) mesh.instanceMatrix.needsUpdate = true;
    for (const tint of this.tints) tint.needsUpdate = true;
  }
}
