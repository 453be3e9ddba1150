// The answer of the page, on top of it: what failed, or that nothing did; why, and what would help.
import { copier, icon, kept, part, renew } from "./page";
import type { Claim, Help, Status } from "./payload";
import type { Run } from "./run";

export const SHAPES: Record<Status, string> = { passed: "passed", failed: "failed", differs: "differs", open: "skipped" };

// What a page says of what it shows.
export interface Answer {
  status: Status;
  headline: string;
  lead: [string, string][]; // what is told at once: a name and a text
  helps: Help[];
  claims: Claim[];
  truths: Claim[];
  facts: [string, string][]; // what is folded
  see: string;
  name: string;
  about: string;
  image?: string; // another shape than that of the status
}

export class Band {
  readonly element = part("header", { class: "band" });
  readonly runs = part("div", { class: "runs" }); // which of several runs is shown
  private readonly image = part("span", { class: "image" });
  private readonly title = part("h1");
  private readonly lead = part("p", { class: "lead" });
  private readonly more = part("details", { class: "more" }, part("summary", { text: "Details" }));
  private readonly folded = part("div", { class: "facts" });
  private readonly name = part("b");
  private readonly about = part("span");

  constructor() {
    this.title.setAttribute("aria-live", "polite");
    this.more.append(this.folded);
    const who = part("div", { class: "who" }, this.name, this.about, this.runs);
    this.element.append(this.image, part("div", { class: "words" }, this.title, this.lead, this.more), who);
  }

  say(answer: Answer): void {
    this.element.dataset.status = answer.status;
    const shape = answer.image ?? SHAPES[answer.status];
    renew(this.image, shape, () => [icon(shape, true)]);
    renew(this.title, answer.headline, () => [kept(answer.headline)]);
    renew(this.name, answer.name, () => [answer.name]);
    renew(this.about, answer.about, () => [answer.about]);
    renew(this.lead, JSON.stringify([answer.lead, answer.helps[0]]), () => [
      ...answer.lead.flatMap(([name, text]) => [part("span", {}, part("b", { text: name }), " ", kept(stop(text))), " "]),
      ...answer.helps.slice(0, 1).map((help) => {
        const text = part("span", { text: help.text });
        return part("span", { class: "help" }, icon("remedy"), part("b", { text: "Would help" }), " ", text, ...(help.now ? [`, ${place(help)}`] : []), " ", copier(help.copy, text));
      }),
    ]);
    this.lead.hidden = !this.lead.childNodes.length;
    const { claims, truths, facts, see, helps } = answer;
    const nothing = claims.length + truths.length + facts.length + helps.length === 0 && !see;
    this.more.hidden = nothing;
    renew(this.folded, JSON.stringify([claims, truths, facts, see, helps]), () => [
      ...(claims.length + truths.length ? [table(claims, truths)] : []),
      ...(facts.length ? [part("dl", {}, ...facts.flatMap(([name, text]) => [part("dt", { text: name }), part("dd", { text })]))] : []),
      ...(helps.length ? [part("h2", { class: "label", text: "Would help, each tried" }), ...helps.map(helping)] : []),
      ...(see ? [seen(see)] : []),
    ]);
  }
}

// A sentence ends with a full stop.
function stop(text: string): string {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}

function place(help: Help): string {
  return [help.now, help.line ? `line ${help.line}` : ""].filter(Boolean).join(", ");
}

export function helping(help: Help): HTMLElement {
  const text = part("b", { text: help.text });
  return part("div", { class: "help" }, icon("remedy"), text, part("span", { class: "faint", text: place(help) }), copier(help.copy, text));
}

function seen(command: string): HTMLElement {
  const code = part("code", { text: command });
  return part("div", { class: "see" }, part("span", { class: "label", text: "See it" }), code, copier(command, code));
}

const WARNING = "Warning"; // about the files of a run, which fails nothing
const HEADS = ["", "claim", "expected", "measured", "margin", "written at"];

function table(claims: Claim[], truths: Claim[]): HTMLElement {
  const row = (claim: Claim, good: string, poor: string): HTMLElement => {
    const state = part("td", { class: claim.passed ? "passed" : good === "agrees" ? "disagrees" : "failed" }, icon(claim.passed ? "passed" : good === "agrees" ? "disagrees" : "failed"), part("span", { text: claim.passed ? good : poor }));
    const cells = [claim.name, claim.expected, claim.measured, claim.margin, claim.place].map((text, place) => {
      const cell = part("td", {}, kept(text));
      cell.dataset.name = HEADS[place + 1]; // for narrow screens, where there is no row of heads
      return cell;
    });
    return part("tr", {}, state, ...cells.filter((cell) => cell.textContent || cell.dataset.name !== "margin" || hasMargins));
  };
  const hasMargins = [...claims, ...truths].some((claim) => claim.margin);
  const heads = HEADS.filter((name) => name !== "margin" || hasMargins).map((text) => part("th", { text }));
  const rows = [...claims.map((claim) => row(claim, "holds", "fails")), ...truths.map((truth) => row(truth, "agrees", "reference disagrees"))];
  return part("div", { class: "wide" }, part("table", {}, part("thead", {}, part("tr", {}, ...heads)), part("tbody", {}, ...rows)));
}

// What is said of one run.
export function answerOf(run: Run, brief = false): Answer {
  const { told, name, system, fall, description, weakest, room, bricks, limit } = run.told;
  const facts = new Map(told.facts);
  const failed = told.claims.filter((claim) => !claim.passed);
  const lead: [string, string][] = [];
  const why = facts.get("Why");
  if (why) lead.push(["Why", why]);
  const falls = fall ? `at ${fall.time.toFixed(3)} s: ${fall.reason}` : "";
  if (!why && fall?.predicted) lead.push(["This run", `no brick fell on ${system}`], ["Statics predict", `a fall ${falls}`]);
  if (facts.get("After") && !brief) lead.push(["After", facts.get("After")!]);
  if (!why && fall && !fall.predicted) lead.push(["Falls", falls]);
  const rest: [string, string][] = told.facts.filter(([name]) => name !== "Why" && name !== WARNING && (brief || name !== "After"));
  if (!why && !fall && weakest) lead.push([run.asBuilt()[1] < run.told.end ? "Weakest as built" : "Weakest", weakest.text.replace(/^weakest: /, "")]);
  if (limit) lead.push(["Load factor", `${limit.factor}; beyond it ${limit.text}`]);
  if (!fall && room) rest.push(["Least room", `${bricks.name[room.brick]}, with its centre of mass ${room.depth} mm inside the support`]);
  if (description) rest.unshift(["About", description]);
  const nearest = told.claims.length === 1 ? told.claims[0] : undefined;
  if (told.status === "passed" && nearest?.margin && !nearest.margin.startsWith("0 ")) lead.push(["Margin", nearest.margin]);
  lead.push(...told.facts.filter(([name]) => name === WARNING));
  const count = told.claims.length;
  const about = [system, !count ? "" : failed.length ? `${failed.length} of ${count} claims failed` : `${count} of ${count} claims hold`, failed[0]?.place ?? ""];
  const image = told.status === "differs" ? "disagrees" : undefined; // it fails as expected, and no golden file differs
  return { status: told.status, image, headline: told.headline, lead, helps: told.helps, claims: told.claims, truths: told.truths, facts: rest, see: told.see, name, about: about.filter(Boolean).join(", ") };
}
