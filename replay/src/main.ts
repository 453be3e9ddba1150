// The page: what can be seen and done on it.
import { Quaternion, Vector3 } from "three";
import { MODES, type Mode } from "./colours";
import { OVERLAYS } from "./overlays";
import { button, choice, offer, part, say, swatch } from "./page";
import type { Payload } from "./payload";
import { type Heard, listen } from "./live";
import { Player, SPEEDS } from "./player";
import { marksOf, Run, State } from "./run";
import { DIFFERENT } from "./stage";
import type { From } from "./viewer";

const NOTHING_YET = "waiting for the first run";
const VIEWS: From[] = ["three-quarter", "front", "side", "plan"];
const WORDS: Record<State, string> = {
  [State.Absent]: "absent",
  [State.Awake]: "moves freely",
  [State.Riding]: "moves rigidly with other bricks",
  [State.Proven]: "frozen",
  [State.Fallen]: "has left its place",
  [State.Thrown]: "thrown or dropped",
};

// What is said of a brick.
function labelOf(run: Run, brick: number, time: number, marks: Map<string, string[]> | undefined): string {
  const { bricks } = run.told;
  const found = run.proofAt(time);
  const place = found?.place.get(brick);
  const lines = [
    `${bricks.name[brick]}${bricks.level[brick] ? `, level ${bricks.level[brick]}` : ""}, ${bricks.grams[brick]} g: ${run.told.marks ? "as in the golden file" : WORDS[run.stateAt(brick, time)]}`,
  ];
  if (found && place !== undefined) {
    const on = found.proof.rests[place].map(([below, share]) => run.nameOf(below) + (share === null ? "" : ` ${Math.round(100 * share)} %`));
    lines.push(`rests on ${on.join(", ") || "nothing"}`, `proven by ${found.proof.stages[found.proof.stage[place]]}`);
    const depth = found.proof.depth[place];
    if (depth !== null) lines.push(`centre of mass ${depth} mm inside the support`);
  }
  return [...lines, ...(marks?.get(bricks.name[brick]) ?? []), bricks.place[brick]].join("\n");
}

function build(player: Player): Heard {
  const { runs, viewer, timeline } = player;
  const lines: string[][] = [];
  const weakestHeard: (string | null)[] = [];
  const title = part("h1", { text: NOTHING_YET });
  const about = part("p");
  const notes = part("p", { class: "notes" });
  const mistakes = part("pre", { class: "mistakes" });
  const label = part("div", { class: "label" });
  const legend = part("div", { class: "legend" });
  const news = part("div", { class: "news" });
  const captions = [part("div", { class: "caption" }), part("div", { class: "caption" })];
  const clock = part("output");
  const playing = button("Play", "space", () => player.play());
  const following = button("Follow", "f: follow the selected brick", () => player.follow());
  const flat = button("Orthographic", "o", () => {
    viewer.orthographic = !viewer.orthographic;
    player.touch();
  });
  const [speedLabel, speed] = choice("Speed", SPEEDS.map((one) => [String(one), one < 1 ? `1/${1 / one}` : `${one}`]), (value) => (player.speed = +value));
  const [colourLabel, colour] = choice("Colour", MODES.map((mode) => [mode, mode]), (value) => player.colour(value as Mode));
  const [viewLabel, view] = choice("View", VIEWS.map((view) => [view, view]), (value) => player.look(value as From));
  const second = choice("beside", [], () => chosen());
  const first = choice("Run", [], () => chosen());
  const chosen = (): void => player.show(+first[1].value, ...(second[1].value ? [+second[1].value] : []));
  const overlays = OVERLAYS.map((name): [string, HTMLButtonElement] => [name, button(name, `show ${name}`, () => player.overlay(name))]);
  const weakestOf = (): string | undefined => viewer.stages[0]?.run.told.weakest?.brick ?? weakestHeard[player.shown[0]] ?? undefined;
  const pickWeakest = (): void => player.pickNamed(weakestOf());
  const roomOf = (): string | undefined => {
    const told = viewer.stages[0]?.run.told;
    return told?.room ? told.bricks.name[told.room.brick] : undefined;
  };
  const pickRoom = (): void => player.pickNamed(roomOf());
  const weakest = button("Weakest", "w: select the lowest brick of the part that moves first under horizontal acceleration", pickWeakest);
  const room = button("Least room", "r: select the brick whose centre of mass is nearest to the edge of its support", pickRoom);
  const swing = button("How it falls", "m: play the proven initial motion of the fall", () => player.swing());
  speed.value = "1";
  const buttons = [
    button("|<", "previous event: ,", () => player.step(-1)),
    playing,
    button(">|", "next event: .", () => player.step(1)),
    clock,
    speedLabel,
    colourLabel,
    viewLabel,
    button("Fit", "0", () => (viewer.fit(player.time), player.touch())),
    flat,
    following,
    ...overlays.map(([, one]) => one),
    swing,
    weakest,
    room,
  ];
  const several = part("div", { class: "bar" }, first[0], second[0]);
  const changed = (): void => {
    const names = runs.map((run, number): [string, string] => [String(number), run.told.name]);
    several.hidden = runs.length < 2;
    offer(first[1], names, String(player.shown[0] ?? 0));
    offer(second[1], [["", "none"], ...names], String(player.shown[1] ?? ""));
    player.retell();
  };
  viewer.canvas.tabIndex = 0;
  document.body.append(
    part("header", {}, title, about, several, notes, mistakes),
    part("main", {}, viewer.canvas, ...captions, legend, news, label),
    part("footer", {}, timeline.canvas, part("div", { class: "bar" }, ...buttons)),
  );

  let hovered: { x: number; y: number } | undefined;
  let legendOf = "";
  player.told = () => {
    const run = viewer.stages[0].run;
    say(title, `${run.told.name}: ${run.told.verdict}`);
    const failed = run.told.outcomes.filter((outcome) => !outcome.passed).map((outcome) => `failed: ${outcome.text}`);
    say(about, [run.told.description, ...failed].filter(Boolean).join(" - "));
    const marks = marksOf(run, viewer.stages[1]?.run);
    const ofWhole = [...(marks ?? [])].filter(([name]) => !run.told.bricks.name.includes(name)).flatMap(([name, texts]) => texts.map((text) => `${name} ${text}`));
    say(notes, [factOf(run), ...ofWhole, ...(lines[player.shown[0]] ?? [])].filter(Boolean).join("\n"));
    weakest.hidden = weakestOf() === undefined;
    room.hidden = run.told.room === null;
    say(clock, `${player.time.toFixed(3)} s of ${timeline.end.toFixed(3)} s`);
    say(playing, player.playing ? "Pause" : "Play");
    following.setAttribute("aria-pressed", String(player.following));
    flat.setAttribute("aria-pressed", String(viewer.orthographic));
    for (const [name, one] of overlays) one.setAttribute("aria-pressed", String(player.overlays.has(name as never)));
    swing.hidden = run.told.fall === null;
    const last = timeline.last(player.time);
    const who = last ? last.bricks.slice(0, 4).map((brick) => run.told.bricks.name[brick]).join(", ") + (last.bricks.length > 4 ? " ..." : "") : "";
    news.hidden = !last;
    say(news, player.swinging ? run.told.fall!.reason : last ? `${[`${last.time.toFixed(3)} s`, last.kind, who].filter(Boolean).join(" ")}${last.reason ? `: ${last.reason}` : ""}` : "");
    captions.forEach((caption, place) => {
      caption.hidden = viewer.stages.length < 2;
      say(caption, viewer.stages[place]?.run.told.name ?? "");
      caption.style.left = place ? "50.5%" : ".5rem";
    });
    const entries = viewer.stages[0].colours.legend(player.mode, player.time);
    if (viewer.stages.length > 1) entries.push({ text: marks ? "differs from the golden file" : "position differs from the other run", colour: DIFFERENT });
    const key = entries.map(({ text, count, colour }) => `${text} ${count} ${colour.getHexString()}`).join();
    if (key !== legendOf) {
      legendOf = key;
      legend.hidden = entries.length === 0;
      legend.replaceChildren(
        ...entries.map(({ text, count, colour }) => part("div", {}, swatch(`#${colour.getHexString()}`), document.createTextNode([text, count].filter(Boolean).join(" ")))),
      );
    }
    colour.value = player.mode;
    view.value = viewer.from;
    const seen = hovered && !player.playing ? viewer.pick(hovered.x, hovered.y, player.time) : undefined;
    const found = seen ?? player.picked;
    label.hidden = !found;
    if (found) {
      label.textContent = labelOf(viewer.stages[found[0]].run, found[1], player.time, marks);
      const [x, y] = seen && hovered ? [hovered.x, hovered.y] : viewer.onScreen(viewer.stages[found[0]].drawn(found[1]), found[0]);
      label.style.left = `${Math.min(x + 14, viewer.canvas.clientWidth - label.offsetWidth - 4)}px`;
      label.style.top = `${Math.min(y + 14, viewer.canvas.clientHeight - label.offsetHeight - 4)}px`;
    }
  };

  let pressed = [0, 0];
  viewer.canvas.addEventListener("pointerdown", (event) => (pressed = [event.offsetX, event.offsetY]));
  viewer.canvas.addEventListener("pointermove", (event) => {
    hovered = event.pointerType === "mouse" && !event.buttons ? { x: event.offsetX, y: event.offsetY } : undefined;
    player.touch();
  });
  viewer.canvas.addEventListener("pointerleave", () => ((hovered = undefined), player.touch()));
  viewer.canvas.addEventListener("click", (event) => {
    if (Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) > 5) return; // it was turned
    player.pick(viewer.pick(event.offsetX, event.offsetY, player.time));
  });
  const keys: Record<string, () => void> = {
    " ": () => player.play(),
    ",": () => player.step(-1),
    ".": () => player.step(1),
    Home: () => player.seek(0),
    End: () => player.seek(timeline.end),
    "0": () => viewer.fit(player.time),
    f: () => player.follow(),
    o: () => (viewer.orthographic = !viewer.orthographic),
    v: () => player.look(VIEWS[(VIEWS.indexOf(viewer.from) + 1) % VIEWS.length]),
    m: () => player.swing(),
    w: pickWeakest,
    r: pickRoom,
    "+": () => viewer.zoom(1.25),
    "-": () => viewer.zoom(0.8),
    "[": () => faster(-1),
    "]": () => faster(1),
    Escape: () => player.pick(undefined),
  };
  MODES.forEach((mode, place) => (keys[String(place + 1)] = () => player.colour(mode)));
  const faster = (way: number): void => {
    player.speed = SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, SPEEDS.indexOf(player.speed) + way))];
    speed.value = String(player.speed);
  };
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLSelectElement) return;
    if (event.target instanceof HTMLButtonElement && event.key === " ") return;
    const way = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (way) player.seek(player.time + way * (event.shiftKey ? 1 : 1 / 60));
    else if (Object.hasOwn(keys, event.key)) keys[event.key]();
    else return;
    event.preventDefault();
    player.touch();
  });
  new ResizeObserver(() => player.touch()).observe(viewer.canvas);
  changed();
  return { mistakes, lines, weakest: weakestHeard, changed };
}

// The weakest spot of what stands, and where a centre has least room; or what gives way.
function factOf({ told }: Run): string {
  if (told.fall) return `falls at ${told.fall.time.toFixed(3)} s: ${told.fall.reason}`;
  const room = told.room && `least room: ${told.bricks.name[told.room.brick]}, with its centre of mass ${told.room.depth} mm inside the support`;
  return [told.weakest?.text, room].filter(Boolean).join("\n");
}

async function main(): Promise<void> {
  const data = document.getElementById("runs")!;
  const told = JSON.parse(data.textContent!) as Payload[];
  const player = new Player(await Promise.all(told.map((one) => Run.of(one))));
  const heard = build(player);
  player.start(nameIn(location.hash));
  heard.changed();
  expose(player);
  if (data.dataset.live !== undefined) listen(player, heard);
}

// Which run a link means.
function nameIn(hash: string): string {
  try {
    return decodeURIComponent(hash.slice(1));
  } catch {
    return "";
  }
}

// What whoever drives the page from outside can ask, such as its tests.
function expose(player: Player): void {
  const pose = { position: new Vector3(), orientation: new Quaternion() };
  const numberOf = (name: string): [number, number] => [0, player.viewer.stages[0].run.told.bricks.name.indexOf(name)];
  Object.assign(window, {
    replay: {
      seek: (time: number) => (player.play(false), player.seek(time), player.update(), player.viewer.draw()),
      time: () => player.time,
      drawn: () => player.drawn,
      heard: () => player.heard,
      positionOf: (name: string) => player.viewer.stages[0].drawn(numberOf(name)[1]).toArray(),
      poseOf: (name: string) => (
        player.viewer.stages[0].run.poseAt(numberOf(name)[1], player.time, pose), [...pose.position.toArray(), ...pose.orientation.toArray()]
      ),
      onScreen: (name: string) => player.viewer.onScreen(player.viewer.stages[0].drawn(numberOf(name)[1]), 0),
      onTimeline: (time: number) => player.timeline.placeOf(time),
    },
  });
}

void main();
