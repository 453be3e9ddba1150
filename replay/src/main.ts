// The page: what can be seen and done on it.
import { Quaternion, Vector3 } from "three";
import { type Answer, answerOf, Band } from "./band";
import { MODES, type Mode, token } from "./colours";
import { Inspector } from "./inspector";
import { type Heard, listen } from "./live";
import { OVERLAYS, type Overlay, type Which } from "./overlays";
import { button, choice, kept, offer, part, renew, say, swatch } from "./page";
import type { Claim, Payload } from "./payload";
import { Player, shortNames, SPEEDS } from "./player";
import { failed, marksOf, Run } from "./run";
import { Tools } from "./tools";
import type { From } from "./viewer";
import { eventText, howMany, names, seconds, WORDS } from "./wording";

const NOTHING_YET = "Waiting for the first run";
const NO_WEBGL =
  "This browser draws no bricks, as its WebGL 2 is off or missing. Turn on graphics acceleration in its settings, or open this page in a current Chrome, Edge, Firefox or Safari. All else on this page works.";
const VIEWS: [From, string][] = [
  ["three-quarter", "3/4 view"],
  ["front", "Front"],
  ["side", "Side"],
  ["plan", "Top"],
  ["weakest", "Weakest"],
];
const WHICH: [Which, string][] = [
  ["selected", "Selected brick"],
  ["largest", "Ten largest"],
  ["all", "All"],
];
const SHOWN: Record<Overlay, [string, string, string]> = {
  contacts: ["Contacts", "contacts", "areas in which bricks touch"],
  joints: ["Joints", "joints", "joints, by the share of their strength that they use at the load factor"],
  forces: ["Forces", "forces", "forces of the proof"],
  thrust: ["Thrust", "thrust", "line of thrust of the proof, and hinges where it reaches an edge"],
  paths: ["Paths", "paths", "where the load goes; thicker is more"],
  graph: ["Supports", "supports", "which brick rests on which"],
  names: ["Names", "names", "n: names of the bricks in view that find room, those of every fifth level first"],
  motion: ["Motion", "motion", "velocities with which the fall begins"],
};
const SWING = "m: play the proven initial motion of the fall";
const WORD: Record<string, string> = { passed: "passed", failed: "failed", differs: "expected failure", open: "not checked" };

function build(player: Player): Heard {
  const { runs, viewer, timeline } = player;
  const heard: Heard = { lines: [], weakest: [], helps: [], file: part("section", { class: "file" }), failed: undefined, changed: () => changed() };
  const band = new Band();
  const inspector = new Inspector(player);
  const notice = part("div", { class: "notice" });
  const tip = part("div", { class: "tip" });
  const legend = part("div", { class: "legend" });
  const news = part("p", { class: "news" });
  const captions = [part("div", { class: "caption" }), part("div", { class: "caption" })];
  const heads = part("div", { class: "heads" }, ...captions); // above the pictures, where they cover nothing
  const clock = part("output");
  const playing = button("Play", "space", () => player.play(), "play");
  playing.classList.add("primary");
  const flat = button("Parallel", "o: without perspective", () => {
    viewer.orthographic = !viewer.orthographic;
    player.touch();
  }, "parallel");
  const speed = choice("speed", SPEEDS.map((one) => [String(one), `Speed ×${one < 1 ? `1/${1 / one}` : one}`]), (value) => (player.speed = +value));
  const colour = choice("colour by", MODES.map((mode) => [mode, mode[0].toUpperCase() + mode.slice(1)]), (value) => player.colour(value as Mode));
  const view = choice("view", VIEWS, (value) => player.look(value as From));
  const second = choice("beside", [], () => chosen());
  const first = choice("run", [], () => chosen());
  const chosen = (): void => player.show(+first.value, ...(second.value ? [+second.value] : []));
  const overlays = OVERLAYS.map((name): [Overlay, HTMLButtonElement] => {
    const [word, image, title] = SHOWN[name];
    return [name, button(word, title, () => player.overlay(name), image)];
  });
  const which = choice("which forces", WHICH, (value) => {
    player.which = value as Which;
    player.overlays.add("forces");
    player.touch();
  });
  const xray = button("X-ray", "x: draw what hides the selected brick as if of glass", () => ((player.xray = !player.xray), player.touch()), "x-ray");
  const level = part("input", { title: "the highest level that is drawn" });
  level.type = "range";
  level.setAttribute("aria-label", level.title);
  level.addEventListener("input", () => {
    player.top = +level.value < +level.max ? +level.value : Infinity;
    player.touch();
  });
  const levels = part("label", { class: "button levels" }, part("span"), level);
  const weakestOf = (): string | undefined => viewer.stages[0]?.run.told.weakest?.brick;
  const pickWeakest = (): void => {
    const run = viewer.stages[0]?.run;
    const [since, until] = run?.asBuilt() ?? [0, 0];
    if (run?.told.weakest && (player.time < since || player.time > until)) player.play(false), player.seek(until); // it is not the weakest of what is there now
    player.pickNamed(weakestOf());
  };
  const roomOf = (): string | undefined => {
    const told = viewer.stages[0]?.run.told;
    return told?.room ? told.bricks.name[told.room.brick] : undefined;
  };
  const pickRoom = (): void => player.pickNamed(roomOf());
  const weakest = button("Weakest", "w: select the lowest brick of the part that moves first under horizontal acceleration", pickWeakest, "weakest");
  const room = button("Least room", "r: select the brick whose centre of mass is nearest to the edge of its support", pickRoom, "room");
  const swing = button("How it falls", SWING, () => player.swing(), "how-it-falls");
  speed.value = "1";
  const fit = button("Fit", "0: see all bricks", () => (viewer.refit(player.time), player.touch()), "fit");
  const tools = new Tools([
    ["Colour by", [colour]],
    ["Camera", [view, fit, flat, xray, levels]],
    ["Show", overlays.flatMap(([name, one]) => (name === "forces" ? [one, which] : [one]))],
    ["Explain", [swing, weakest, room]],
  ]);
  const counted = part("span");
  band.runs.append(part("label", {}, counted, first), part("label", {}, "Beside ", second));
  let offered = "";
  const changed = (): void => {
    const key = [...runs.map((run) => [run.told.name, run.told.told.status]), player.shown].join();
    band.runs.hidden = runs.length < 2;
    if (key !== offered) {
      offered = key;
      const all = runs.map((run, number): [string, string] => [String(number), `${failed(run) ? "✗ " : ""}${run.told.name}`]);
      const played = runs.filter((run) => !run.told.marks); // a golden file is none
      counted.textContent = played.some(failed) ? `Run (${played.filter(failed).length} of ${played.length} failed) ` : "Run ";
      offer(first, all, String(player.shown[0] ?? 0));
      offer(second, [["", "none"], ...all], String(player.shown[1] ?? ""));
    }
    player.retell();
  };
  viewer.canvas.tabIndex = 0;
  viewer.canvas.setAttribute("role", "img");
  heard.file.hidden = true;
  document.body.append(
    band.element,
    tools.element,
    part("main", {}, heard.file, part("div", { class: "scene" }, heads, part("div", { class: "view" }, viewer.canvas, viewer.over, tip), notice, legend), inspector.element),
    part(
      "footer",
      {},
      part("div", { class: "controls" }, button("", "previous event: ,", () => player.step(-1), "prev"), playing, button("", "next event: .", () => player.step(1), "next"), clock, speed, news),
      timeline.element,
    ),
  );

  const undrawn = part("figure");
  if (!viewer.draws) {
    document.body.classList.add("undrawn");
    viewer.canvas.parentElement!.append(part("p", { class: "notice", text: NO_WEBGL }), undrawn);
  }

  let hovered: { x: number; y: number } | undefined;
  let toolsOf = "";
  player.told = () => {
    const shown = viewer.stages.map((stage) => stage.run);
    const run = shown[0];
    const marks = marksOf(run, shown[1]);
    const answer = answered(shown, marks, heard, player.shown[0]);
    band.say(heard.failed ? { ...answer, ...heard.failed } : answer);
    document.title = `${answer.name}: ${shown.length > 1 && !marks ? WORD[answer.status] : answer.headline.split(/[;:]/)[0].toLowerCase()}`;
    weakest.disabled = weakestOf() === undefined;
    weakest.hidden = weakest.disabled && (heard.file.hidden || run.told.fall !== null); // a live page hears of it later
    room.hidden = run.told.room === null;
    swing.hidden = run.told.fall === null;
    const predicted = run.told.fall?.predicted;
    say(swing.querySelector("span")!, predicted ? "Predicted fall" : "How it falls");
    swing.title = predicted ? "m: play the initial motion of the fall that statics predict; it did not happen in this run" : SWING;
    for (const [name, one] of overlays) {
      one.setAttribute("aria-pressed", String(player.overlays.has(name)));
      if (name === "motion") one.hidden = run.told.fall === null;
      if (name === "joints") one.hidden = run.told.limit === null;
    }
    xray.setAttribute("aria-pressed", String(player.xray));
    xray.disabled = !player.picked;
    which.value = player.which;
    which.hidden = !player.overlays.has("forces");
    view.options[VIEWS.length - 1].hidden = !viewer.knowsWeakest;
    const most = Math.max(...shown.map((one) => one.levels));
    levels.hidden = most < 2;
    level.min = "1";
    level.max = String(most);
    level.value = String(Math.min(most, player.top));
    say(levels.querySelector("span")!, player.top < most ? `to ${player.top}` : "Levels");
    const tooled = [weakest.hidden, room.hidden, swing.hidden, which.hidden, levels.hidden].join();
    if (tooled !== toolsOf) tools.fit();
    toolsOf = tooled;
    renew(clock, `${player.time.toFixed(3)} ${timeline.end}`, () => [part("b", { text: seconds(player.time) }), part("span", { text: ` of ${seconds(timeline.end)}` })]);
    const word = player.playing ? "Pause" : "Play";
    if (playing.textContent !== word) {
      say(playing.querySelector("span")!, word);
      playing.querySelector("use")!.setAttribute("href", `#icon-${word.toLowerCase()}`);
    }
    flat.setAttribute("aria-pressed", String(viewer.orthographic));
    colour.value = player.mode;
    colour.options[MODES.indexOf("joints")].hidden = run.told.limit === null;
    colour.options[MODES.indexOf("strength")].hidden = !run.told.strength;
    view.value = viewer.from;
    speed.value = String(player.speed);
    const faster = player.playing ? timeline.fasterAt(player.time) : 1;
    say(news, player.swinging ? `${predicted ? "Predicted by statics: " : ""}${run.told.fall!.reason}` : faster > 1.05 ? `The build plays ${faster.toPrecision(2)} times as fast.` : newsOf(run, player.time));
    viewer.canvas.setAttribute("aria-label", `${run.told.name} at ${seconds(player.time)}`);
    const called = shortNames(shown);
    heads.hidden = shown.length < 2;
    captions.forEach((caption, place) => {
      const its = shown[place];
      if (its) renew(caption, called[place] + its.told.told.headline, () => [part("b", { text: called[place] }), part("span", { text: kept(its.told.told.headline) })]);
      if (its) caption.dataset.status = its.told.told.status;
    });
    if (!viewer.draws) renew(undrawn, run.told.name, () => drawingOf(run.told.name));
    tellLegend(player, legend, marks);
    const missing = player.missing;
    const silent = missing.length ? "" : player.silent(player.mode);
    notice.hidden = !missing.length && !silent;
    renew(notice, `${missing} ${silent} ${run.proofs.length} ${missing.length ? player.time : ""}`, () =>
      silent ? [part("b", { text: `Colours by ${player.mode}:` }), ` ${silent}. Shown is the state.`] : [part("b", { text: capital(missing.join(", ")) }), " ", inspector.noProof(run, player.time)],
    );
    inspector.say(marks, weakestOf());
    const seen = hovered && !player.playing ? viewer.pick(hovered.x, hovered.y) : undefined;
    player.point(seen);
    tip.hidden = !seen;
    if (seen && hovered) {
      const its = shown[seen[0]];
      renew(tip, `${its.told.name} ${seen[1]} ${player.time}`, () => tipOf(its, seen[1], player.time));
      const box = viewer.stages[seen[0]].boxOf(seen[1], viewer.sight(seen[0]));
      const [width, height] = [viewer.canvas.clientWidth - tip.offsetWidth - 4, viewer.canvas.clientHeight - tip.offsetHeight - 4];
      const left = box.right + 8 <= width ? box.right + 8 : box.left - tip.offsetWidth - 8; // beside it: it is what is looked at
      tip.style.left = `${Math.max(4, Math.min(width, left))}px`;
      tip.style.top = `${Math.max(4, Math.min(height, left >= 4 ? (box.top + box.bottom - tip.offsetHeight) / 2 : box.bottom + 8))}px`;
    }
  };

  let pressed = [0, 0];
  viewer.canvas.addEventListener("pointerdown", (event) => (pressed = [event.offsetX, event.offsetY]));
  viewer.canvas.addEventListener("pointermove", (event) => {
    hovered = event.pointerType === "mouse" && !event.buttons ? { x: event.offsetX, y: event.offsetY } : undefined;
    player.retell();
  });
  viewer.canvas.addEventListener("pointerleave", () => ((hovered = undefined), player.retell()));
  viewer.canvas.addEventListener("click", (event) => {
    if (Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) > 5) return; // it was turned
    player.pick(viewer.pick(event.offsetX, event.offsetY, event instanceof PointerEvent && event.pointerType === "touch"));
  });
  const keys: Record<string, () => void> = {
    " ": () => player.play(),
    ",": () => player.step(-1),
    ".": () => player.step(1),
    Home: () => player.seek(0),
    End: () => player.seek(timeline.end),
    "0": () => viewer.refit(player.time),
    f: () => player.follow(),
    o: () => (viewer.orthographic = !viewer.orthographic),
    v: () => player.look(VIEWS[(VIEWS.findIndex(([from]) => from === viewer.from) + 1) % (VIEWS.length - (viewer.knowsWeakest ? 0 : 1))][0]),
    x: () => (player.xray = !player.xray),
    n: () => player.overlay("names"),
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
  };
  addEventListener("keydown", (event) => {
    const at = event.target;
    if (event.ctrlKey || event.metaKey || event.altKey || at instanceof HTMLSelectElement) return;
    if ((at instanceof HTMLButtonElement || (at instanceof HTMLElement && at.tagName === "SUMMARY")) && event.key === " ") return;
    const way = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (way) player.seek(timeline.later(player.time, way * (event.shiftKey ? 1 : 1 / 60)));
    else if (Object.hasOwn(keys, event.key)) keys[event.key]();
    else return;
    event.preventDefault();
    player.touch();
  });
  new ResizeObserver(() => (player.following || viewer.resized(), player.touch())).observe(viewer.canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => player.touch());
  new ResizeObserver(() => player.touch()).observe(timeline.element);
  if (!runs.length) band.say({ status: "open", headline: NOTHING_YET, lead: [], helps: [], claims: [], truths: [], facts: [], see: "", name: document.title, about: "" });
  changed();
  return heard;
}

// The verdict of one run; of two what differs between them.
function answered(shown: Run[], marks: Map<string, string[]> | undefined, heard: Heard, number: number): Answer {
  const one = answerOf(shown[0], !heard.file.hidden);
  const lines = heard.lines[number] ?? [];
  const answer: Answer = { ...one, helps: heard.helps[number]?.length ? heard.helps[number] : one.helps, facts: [...one.facts, ...lines.map((line): [string, string] => ["Statics", line])] };
  if (shown.length < 2) return answer;
  if (marks) {
    const count = [...marks.values()].flat().length;
    const of = [...marks].slice(0, 3).map(([name, texts]): [string, string] => [name, texts[0]]);
    const failed = answer.status === "failed";  // a claim that fails comes before the golden file
    const differs = `Golden differs in ${howMany(count, "value")}`;
    const told = failed ? { headline: `${answer.headline}; ${differs[0].toLowerCase()}${differs.slice(1)}`, lead: answer.lead } : { headline: differs, lead: of };
    return { ...answer, status: failed ? "failed" : "differs", image: undefined, ...told, facts: [...[...marks].flatMap(([name, texts]) => texts.map((text): [string, string] => [name, text])), ...answer.facts] };
  }
  const other = answerOf(shown[1]);
  const [mine, its] = shortNames(shown);
  const alike = answer.status === other.status;
  const status = [answer, other].find((each) => each.status === "failed")?.status ?? [answer, other].find((each) => each.status !== "passed")?.status ?? "passed";
  const headline = alike ? `Both runs: ${WORD[answer.status]}` : `${mine}: ${WORD[answer.status]}; ${its}: ${WORD[other.status]}`;
  const name = answer.name === other.name ? answer.name : `${answer.name} beside ${other.name}`;
  const differ = firstToDiffer(shown[0], shown[1]);
  const lead: [string, string][] = [["First to differ", differ]];
  if (answer.truths.length + other.truths.length) lead.push(["Reference", [answer, other].map((each, place) => `${[mine, its][place]} ${each.truths.every((truth) => truth.passed) ? "agrees" : "disagrees"}`).join(", ")]);
  return { ...answer, status, headline, name, about: "", lead, helps: [], claims: [...named(answer.claims, mine), ...named(other.claims, its)], truths: [...named(answer.truths, mine), ...named(other.truths, its)] };
}

function named(claims: Claim[], who: string): Claim[] {
  return claims.map((claim) => ({ ...claim, name: `${who}: ${claim.name}` }));
}

const COUNTING = 250; // [ms]
const MOST_TIMES = 200; // at which two runs are compared at first
const told = new WeakMap<Run, [Run, string]>();

// The bricks that are the first to be in different places, and after what.
function firstToDiffer(one: Run, other: Run): string {
  const known = told.get(one);
  if (known?.[0] === other) return known[1];
  const events = [...one.told.events.map((event) => ({ event, run: one })), ...other.told.events.map((event) => ({ event, run: other }))];
  const times = [...new Set(events.map(({ event }) => event.time)), Math.min(one.told.end, other.told.end)].sort((a, b) => a - b);
  const differ = (time: number): boolean => one.differing(other, time + 1e-4).length > 0;
  const stride = Math.ceil(times.length / MOST_TIMES);
  const near = times.findIndex((time, place) => place % stride === stride - 1 && differ(time));
  const at = near < 0 ? times.slice(-stride).find(differ) : times.slice(Math.max(0, near - stride + 1), near + 1).find(differ);
  const before = at === undefined ? undefined : events.filter(({ event }) => event.time < at && event.kind !== "frozen").sort((a, b) => a.event.time - b.event.time).pop();
  const text = at === undefined ? "no brick" : `${names(one, one.differing(other, at + 1e-4), at)}, by ${seconds(at)}${before ? `; before that, ${eventText(before.run, before.event)} at ${seconds(before.event.time)}` : ""}`;
  told.set(one, [other, text]);
  return text;
}

// What happened last, and what comes next.
function newsOf(run: Run, time: number): string {
  const { events } = run.told;
  const at = run.passed(time);
  const [last, next] = [events[at - 1], events[at]];
  return [last ? `${seconds(last.time)}: ${eventText(run, last)}.` : "", next ? `Next at ${seconds(next.time)}: ${eventText(run, next)}.` : ""].filter(Boolean).join(" ");
}

// What occurs now, with counts: under the picture, where it covers nothing.
function tellLegend(player: Player, legend: HTMLElement, marks: Map<string, string[]> | undefined): void {
  const { stages } = player.viewer;
  // While it plays, bricks are counted a few times a second: to count thousands takes time from drawing them.
  const when = player.playing ? `playing ${Math.floor(performance.now() / COUNTING)}` : player.time;
  const key = [when, player.seen, player.shown, player.runs.length, marks?.size, player.heard].join();
  renew(legend, key, () => {
    const lines = stages.map((stage, place) => {
      const entries = stage.colours.legend(player.seen, player.time);
      const name = stages.length > 1 ? [part("b", { text: shortNames(stages.map((stage) => stage.run))[place] })] : [part("b", { class: "label", text: player.seen === "joints" ? `joints at ${stage.run.told.limit!.factor} times the weight` : player.seen === "strength" ? "strength, in the last structure" : `${player.seen}, at ${seconds(player.time)}` })];
      return part("div", {}, ...name, ...entries.map(({ text, colour, count, hollow }) => part("span", { class: "entry" }, swatch(`#${colour.getHexString()}`, hollow), text, ...(count === undefined ? [] : [part("b", { class: "number", text: String(count) })]))));
    });
    if (stages.length > 1) {
      const count = marks ? stages[0].run.told.bricks.name.filter((name) => marks.has(name)).length : stages[0].run.differing(stages[1].run, player.time).length;
      lines.push(part("div", {}, part("span", { class: "entry" }, swatch(`#${token("--known").getHexString()}`, true), part("b", { class: "number", text: count ? howMany(count, "brick") : "no brick" }), marks ? (count > 1 ? "differ from the golden file" : "differs from the golden file") : `${count < 2 ? "is" : "are"} not where ${count < 2 ? "it is" : "they are"} in the other run`)));
    }
    return lines;
  });
}

// The drawing of the end of a run, from what the page has for browsers without JavaScript.
function drawingOf(name: string): Node[] {
  const stills = new DOMParser().parseFromString(document.querySelector("noscript")!.textContent!, "text/html").querySelectorAll<HTMLElement>(".still");
  const drawing = [...stills].find((still) => still.dataset.run === name)?.querySelector("figure > svg");
  return drawing ? [document.importNode(drawing, true)] : [];
}

// A few words beside a brick that is pointed at.
function tipOf(run: Run, brick: number, time: number): Node[] {
  const { bricks } = run.told;
  const found = run.proofAt(time);
  const place = found?.place.get(brick);
  const on = place === undefined || !found ? "" : `rests on ${found.proof.rests[place].map(([below]) => run.nameOf(below)).join(", ") || "nothing"}`;
  return [part("b", { text: bricks.name[brick] }), ...[run.told.marks ? "as in the golden file" : WORDS[run.stateAt(brick, time)], on].filter(Boolean).map((text) => part("div", { text }))];
}

function capital(text: string): string {
  return text[0] ? `${text[0].toUpperCase()}${text.slice(1)}:` : "";
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
      seek: (time: number) => (player.play(false), player.seek(time), player.viewer.settle(), player.update(), player.viewer.draw()),
      colourOf: (name: string) => player.viewer.stages[0].colours.of(player.seen, numberOf(name)[1], player.time).getHexString(),
      forceScale: () => player.viewer.stages[0].overlays.bar,
      forces: () =>
        player.viewer.stages[0].overlays.arrows.map(({ tip, force }) => {
          const sight = player.viewer.sight(0);
          const from = tip.clone().addScaledVector(force, -player.viewer.stages[0].overlays.bar!.perNewton / sight.scale(tip));
          return { from: sight.at(from), tip: sight.at(tip), newtons: force.length() };
        }),
      motions: () => player.viewer.stages[0].overlays.motions.map(({ brick, from }) => [player.viewer.stages[0].run.nameOf(brick), from.toArray(), player.viewer.stages[0].drawn(brick).toArray()]),
      names: () => player.viewer.stages[0].overlays.named,
      pickedAt: (x: number, y: number) => player.viewer.stages[0].run.told.bricks.name[player.viewer.pick(x, y)?.[1] ?? -1] ?? "",
      time: () => player.time,
      drawn: () => player.drawn,
      heard: () => player.heard,
      positionOf: (name: string) => player.viewer.stages[0].drawn(numberOf(name)[1]).toArray(),
      poseOf: (name: string) => (
        player.viewer.stages[0].run.poseAt(numberOf(name)[1], player.time, pose), [...pose.position.toArray(), ...pose.orientation.toArray()]
      ),
      boxOf: (name: string) => player.viewer.stages[0].boxOf(numberOf(name)[1], player.viewer.sight(0)),
      onScreen: (name: string) => player.viewer.onScreen(player.viewer.stages[0].drawn(numberOf(name)[1]), 0),
      pickNamed: (name: string) => player.pickNamed(name),
      perMetre: () => player.viewer.sight(0).scale(player.viewer.stages[0].drawn(0)),
      onTimeline: (time: number) => player.timeline.placeOf(time),
    },
  });
}

void main();
