// What a page is told of its runs; stackdsl/viewing/replay/payload.py writes it.

export interface Poses {
  counts: number[]; // of each brick
  origin: [number, number, number]; // [m]
  unit: number; // [m]
  data: string;
}

export interface Told {
  time: number; // [s]
  kind: string;
  bricks: number[];
  riding: number[];
  reason: string;
}

export interface Proof {
  begin: number; // [s]
  end: number | null; // [s]; null: it holds to the end
  stages: string[];
  bricks: number[];
  stage: number[]; // of each of these bricks
  depth: (number | null)[]; // [mm]
  rests: [number | string, number | null][][];
  lower: (number | string)[]; // of each contact; a text names the ground or a wall
  upper: (number | string)[];
  counts: number[]; // of its points
  points: string;
  forces: string;
  loads: [number, number, number, number, number, number, number][]; // brick, place [m], force [N]
  thrust: [number, number, number, number, number, number, number, number][]; // brick, both ends [m], force [N]
  hinges: [number, number, number, number][]; // brick, place [m]
}

export interface Fall {
  time: number; // [s]
  reason: string;
  predicted: boolean; // by statics, while all bricks of the run stand: an engine can be wrong
  bricks: number[];
  velocity: [number, number, number][];
  spin: [number, number, number][];
}

// The first mechanism of bricks with joints under a multiple of their own weight.
export interface Limit {
  factor: number;
  text: string; // what moves beyond it, and which joint gives way
  bricks: number[]; // that move beyond it
  lower: (number | string)[]; // of each joint
  upper: (number | string)[];
  used: number[]; // share of its strength
  yields: number[]; // 1 if it gives way
  points: [number, number, number][][]; // of its contact [m]
}

export interface Claim {
  name: string;
  expected: string;
  measured: string;
  margin: string; // with its unit; empty if there is none
  passed: boolean;
  place: string;
}

export interface Help {
  text: string;
  now: string; // what it replaces; empty if it is an addition
  copy: string; // what can be written in the file
  file: string; // where; empty if it is no number of the file
  line: number;
}

export type Status = "passed" | "failed" | "differs" | "open";

// The verdict in words; stackdsl/viewing/replay/verdict_band.py writes it.
export interface Verdict {
  status: Status;
  headline: string;
  facts: [string, string][];
  claims: Claim[];
  truths: Claim[];
  see: string; // a command
  helps: Help[]; // of a live page see `Heard`
}

export interface Payload {
  name: string;
  system: string;
  description: string;
  verdict: string;
  end: number; // [s]
  told: Verdict;
  gravity: number; // [m/s2]
  planes: { name: string; point: [number, number, number]; normal: [number, number, number] }[];
  shapes: { corners: [number, number, number][]; faces: number[][]; curved?: number[] }[]; // `curved`: faces that stand for parts of a curved surface
  bricks: {
    name: string[];
    shape: number[];
    level: number[];
    grams: number[];
    density: number[];
    thrown: number[];
    gone: (number | null)[];
    left: (number | null)[];
    place: string[];
  };
  poses: Poses;
  events: Told[];
  proofs: Proof[];
  fall: Fall | null;
  room: { brick: number; depth: number } | null; // the brick of what stands whose centre has least room [mm]
  weakest: { brick: string; text: string; bearing_deg: number } | null; // what gives way first, pulled sideways; a live page hears of it later
  limit: Limit | null; // of bricks with joints; a live page does without
  strength: { bricks: number[]; used: number[]; crushes: number | null } | null; // share of their strength that bricks use in the last structure; a live page does without
  marks: Record<string, string[]> | null; // of a golden file: what differs from its run, by brick or what else it is of
  ties: { bricks: number[]; points: [number, number, number][] }[]; // corners of each [m]; the first one again if it is closed
}
