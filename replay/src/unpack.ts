// Poses and numbers from few bytes; stackdsl/viewing/replay/packing.py packs them.
import type { Poses } from "./payload";

const TURNS = 16384;
const TICKS = 10000;
export const COLUMNS = 8; // time, x, y, z and the parts of an orientation

async function inflated(data: string): Promise<Int32Array> {
  const bytes = Uint8Array.from(atob(data), (char) => char.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = planes.length / 4;
  const whole = new Int32Array(count);
  for (let i = 0; i < count; i++) {
    whole[i] = planes[i] | (planes[count + i] << 8) | (planes[2 * count + i] << 16) | (planes[3 * count + i] << 24);
  }
  return whole;
}

export async function unpackedFloats(data: string): Promise<Float32Array> {
  return new Float32Array((await inflated(data)).buffer);
}

// One row a pose, by brick, then by time: seconds, metres and quaternions.
export async function unpackedPoses(poses: Poses): Promise<Float64Array> {
  const changes = await inflated(poses.data);
  const rows = changes.length / COLUMNS;
  const table = new Float64Array(changes.length);
  for (let column = 0; column < COLUMNS; column++) {
    const unit = column === 0 ? 1 / TICKS : column < 4 ? poses.unit : 1 / TURNS;
    const origin = column >= 1 && column < 4 ? poses.origin[column - 1] : 0;
    let row = 0;
    for (const count of poses.counts) {
      let value = 0;
      let change = 0;
      for (const end = row + count; row < end; row++) {
        change = (change + changes[column * rows + row]) | 0;
        value = (value + change) | 0;
        table[row * COLUMNS + column] = origin + value * unit;
      }
    }
  }
  return table;
}
