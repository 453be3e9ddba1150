// The panel beside the picture: all about the selected brick, or else what happens around now.
import { button, link, part, renew } from "./page";
import type { Limit, Told } from "./payload";
import type { Player } from "./player";
import { type Forces, type Run, State } from "./run";
import { eventText, howMany, newtons, seconds, threeDigits, WORDS } from "./wording";

const AROUND = [4, 8]; // events before now and from now on that are listed
const OUTSIDE = 0.05; // [mm] a smaller shift is told as none

export class Inspector {
  readonly element = part("aside", { class: "inspector" });
  readonly follow: HTMLButtonElement;
  private readonly close: HTMLButtonElement;

  constructor(private readonly player: Player) {
    this.element.setAttribute("aria-label", "selected brick, or events");
    this.follow = button("Follow", "f: keep the camera on this brick", () => player.follow(), "follow");
    this.close = button("Close", "Escape: select nothing", () => player.pick(undefined));
  }

  say(marks: Map<string, string[]> | undefined, weakest: string | undefined): void {
    const { player } = this;
    const { picked, time } = player;
    const stages = player.viewer.stages;
    this.element.classList.toggle("of-brick", picked !== undefined);
    this.follow.setAttribute("aria-pressed", String(player.following));
    if (picked) {
      const { run } = stages[picked[0]];
      const key = [run.told.name, picked[1], time, run.proofs.length, weakest, marks?.size].join();
      renew(this.element, key, () => this.brick(run, picked[1], time, marks, weakest));
      return;
    }
    const { run } = stages[0];
    const at = run.passed(time);
    renew(this.element, ["events", run.told.name, run.told.events.length, run.told.end, at, run.proofAt(time)?.proof.begin].join(), () => this.events(run, at));
  }

  private brick(run: Run, brick: number, time: number, marks: Map<string, string[]> | undefined, weakest: string | undefined): Node[] {
    const { bricks, gravity } = run.told;
    const name = bricks.name[brick];
    const state = run.stateAt(brick, time);
    const found = run.proofAt(time);
    const place = found?.place.get(brick);
    const half = run.halves[bricks.shape[brick]];
    const weight = (bricks.grams[brick] / 1000) * gravity;
    const gone = bricks.gone[brick];
    const moved = 1000 * run.movedBy(brick, time);
    const told: [string, string][] = [
      ["State", state === State.Absent ? (gone !== null && gone <= time ? `pulled out at ${seconds(gone)}` : "not yet there") : run.told.marks ? "as in the golden file" : WORDS[state]],
      ["Proof", found && place !== undefined ? found.proof.stages[found.proof.stage[place]] || "holds" : state === State.Proven ? "not shown at this time" : "none at this time"],
      ["Mass", `${mass(bricks.grams[brick])}, weighs ${newtons(weight).text(weight)}`],
      ["Size", `${half.toArray().map((side) => threeDigits(2000 * side)).join(" × ")} mm`],
      ["Moved", state === State.Absent ? "" : moved < OUTSIDE ? "0 mm since it was set down" : `${threeDigits(moved)} mm since it was set down`],
      ["Written at", bricks.place[brick]],
    ];
    const rows = told.filter(([, text]) => text).flatMap(([name, text]) => [part("dt", { text: name }), part("dd", { text })]);
    const level = bricks.level[brick];
    const parts: Node[] = [
      part("div", { class: "top" }, part("h2", { text: name }), part("span", { class: "faint", text: level ? `level ${level}` : "" }), this.follow, this.close),
      part("dl", {}, ...rows),
    ];
    if (found && place !== undefined) parts.push(...this.loads(run, found, brick, place));
    else parts.push(section("Forces", this.noProof(run, time)));
    const room = place === undefined ? null : (found?.proof.depth[place] ?? null);
    const left: string[] = [];
    if (room !== null) left.push(`Its centre of mass is ${threeDigits(room)} mm inside the area that carries it.`);
    if (run.told.room?.brick === brick && !run.told.fall) left.push("No brick that stands at the end has less room.");
    const [since, until] = run.asBuilt();
    if (weakest === name && time >= since && time <= until) left.push(`It gives way first: ${run.told.weakest!.text.replace(/^weakest: /, "")}.`);
    if (left.length) parts.push(section("Room left", part("p", { text: left.join(" ") })));
    if (run.told.limit) parts.push(...this.joints(run, run.told.limit, brick));
    const strength = run.told.strength;
    const used = strength?.used[strength.bricks.indexOf(brick)];
    if (strength && used !== undefined) {
      const text = strength.crushes === brick ? `It crushes: it needs ${threeDigits(100 * used)} % of its strength.` : `It uses ${threeDigits(100 * used)} % of its strength, in forces that need as little of all strengths as possible.`;
      parts.push(section("Strength", part("p", { text })));
    }
    const differs = marks?.get(name);
    if (differs) parts.push(section("Differs from the golden file", ...differs.map((text) => part("p", { text }))));
    return parts;
  }

  // The joints of a brick at the load factor, those that give way first.
  private joints(run: Run, limit: Limit, brick: number): Node[] {
    const own = limit.used.flatMap((used, joint): [string, string, number][] => {
      const others = [limit.lower[joint], limit.upper[joint]].filter((body) => body !== brick);
      if (others.length !== 1) return [];
      return [[`to ${run.nameOf(others[0])}`, limit.yields[joint] ? "gives way" : `${Math.round(100 * used)} % of its strength`, limit.yields[joint] ? 2 : used]];
    });
    if (!own.length) return [];
    const rows = own.sort(([, , one], [, , other]) => other - one).flatMap(([to, text]) => [part("dt", { text: to }), part("dd", { text })]);
    return [section(`Joints at ${limit.factor} times the weight`, part("dl", {}, ...rows))];
  }

  // What presses on a brick and what it rests on, as one set of forces that proves that it stands.
  private loads(run: Run, found: Forces, brick: number, place: number): Node[] {
    const above: [string, number, string][] = [];
    const below: [string, number, string][] = [];
    const shares = new Map(found.proof.rests[place].map(([body, share]) => [run.nameOf(body), share]));
    let begin = 0;
    found.proof.counts.forEach((count, contact) => {
      const [lower, upper] = [found.proof.lower[contact], found.proof.upper[contact]];
      if (lower === brick || upper === brick) {
        const force = [0, 0, 0];
        for (let point = begin; point < begin + count; point++) for (let axis = 0; axis < 3; axis++) force[axis] += found.forces[3 * point + axis];
        const other = run.nameOf(lower === brick ? upper : lower);
        const share = lower === brick ? null : shares.get(other);
        (lower === brick ? above : below).push([other, Math.hypot(...force), share == null ? "" : `${Math.round(100 * share)} %`]);
      }
      begin += count;
    });
    const most = Math.max(...[...above, ...below].map(([, force]) => force), 1e-12);
    const { text } = newtons(most);
    const bars = (list: [string, number, string][]): Node[] =>
      list.map(([name, force, share]) => {
        const bar = part("i");
        bar.style.width = `${Math.max(1, (100 * force) / most)}%`;
        return part("div", { class: "force" }, part("span", { text: name }), part("span", { class: "faint", text: share }), part("span", { class: "bar" }, bar), part("span", { class: "number", text: text(force) }));
      });
    const nothing = part("p", { class: "faint", text: "nothing" });
    return [
      section("Presses on it", ...(above.length ? bars(above) : [nothing])),
      section("Rests on", ...(below.length ? bars(below) : [nothing.cloneNode(true)]), part("p", { class: "note", text: "The forces of the proof. Other forces can prove it as well." })),
    ];
  }

  // What happens around now; each goes there.
  private events(run: Run, at: number): Node[] {
    const moments: { event: Told; past: boolean; text: string }[] = [];
    run.told.events.forEach((event, number) => {
      const before = moments[moments.length - 1];
      const together = before?.event.kind === "placed" && event.kind === "frozen" && event.time === before.event.time && event.bricks.join() === before.event.bricks.join();
      if (together) [before.text, before.past] = [`${before.text}, ${event.reason ? "proven to stand" : "judged stable"}`, number < at];
      else moments.push({ event, past: number < at, text: eventText(run, event) });
    });
    const first = Math.max(0, moments.filter(({ past }) => past).length - AROUND[0]);
    const shown = moments.slice(first, first + AROUND[0] + AROUND[1]);
    const rows = shown.map(({ event, past, text }, place) => {
      const now = past && !(shown[place + 1]?.past ?? false);
      const row = part("li", { class: [now ? "now" : "", event.kind === "collapsed" && run.told.told.status === "failed" ? "failed" : ""].join(" ").trim() }, link(seconds(event.time), () => (this.player.play(false), this.player.seek(event.time))), part("span", { text }));
      return row;
    });
    const before = first;
    const after = moments.length - first - shown.length;
    return [
      part("div", { class: "top" }, part("h2", { text: "Events" }), part("span", { class: "faint", text: "around this time" })),
      ...(before ? [part("p", { class: "faint", text: `${howMany(before, "earlier event")}` })] : []),
      part("ol", { class: "events" }, ...rows),
      ...(after ? [part("p", { class: "faint", text: `${howMany(after, "later event")}` })] : []),
      part("p", { class: "note", text: "Select a brick in the picture to see its proof, its loads and its room." }),
    ];
  }

  // That no proof holds now, and where one does.
  noProof(run: Run, time: number): HTMLElement {
    const found = part("p", {}, "No proof holds at this time. ");
    const proofs = run.proofs.map(({ proof }) => proof);
    const before = proofs.filter((proof) => proof.end !== null && proof.end <= time).map((proof) => Math.max(proof.begin, proof.end! - 0.001)).pop();
    const after = proofs.map((proof) => proof.begin).find((begin) => begin > time);
    const go = (to: number): Node => link(`Go to ${seconds(to)}`, () => (this.player.play(false), this.player.seek(to)));
    if (before === undefined && after === undefined) found.append("No structure of this run is proven to stand.");
    found.append(...[before, after].filter((to) => to !== undefined).flatMap((to) => [go(to), " "]));
    return found;
  }
}

function mass(grams: number): string {
  return grams < 1000 ? `${threeDigits(grams)} g` : `${threeDigits(grams / 1000)} kg`;
}

function section(name: string, ...inside: Node[]): HTMLElement {
  return part("section", {}, part("h3", { class: "label", text: name }), ...inside);
}
