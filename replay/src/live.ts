// A page that is open while its file is edited: it hears of each run again whenever that has changed.
import { type Answer, helping } from "./band";
import { icon, part, renew } from "./page";
import type { Help, Payload } from "./payload";
import type { Player } from "./player";
import { Run } from "./run";

const AROUND = 60; // lines of the file that are shown

// What a page hears while it is open, and where it shows that.
export interface Heard {
  lines: string[][]; // by run
  weakest: Payload["weakest"][]; // by run
  helps: Help[][]; // by run
  file: HTMLElement; // the text that is edited
  failed: Partial<Answer> | undefined; // what is said instead of the verdict while the file cannot be read
  changed(): void; // runs came or went
}

interface Mistake {
  code: string;
  message: string;
  hint: string;
  place: string;
  line: number;
  text: string;
}

interface Status {
  runs: number;
  mistakes: Mistake[];
  doing: string;
  lines: string[];
}

export function listen(player: Player, heard: Heard): void {
  const source = new EventSource("events");
  const file = document.title;
  const state = part("p", { class: "state" });
  const mistakes = part("div", { class: "mistakes" });
  const excerpt = part("ol", { class: "excerpt" });
  const helps = part("div", { class: "helps" });
  heard.file.hidden = false;
  heard.file.append(part("header", {}, icon("file"), part("b", { text: file }), state), mistakes, excerpt, helps);
  let known: Status = { runs: 0, mistakes: [], doing: "", lines: [] };
  let lost = "";
  const early = new Map<number, Run>(); // those that came before one of a lower number
  let turn = Promise.resolve(); // one after the other, in the order in which they came
  const on = <Told>(kind: string, hear: (told: Told) => Promise<void> | void): void =>
    source.addEventListener(kind, (event: MessageEvent<string>) => {
      turn = turn.then(() => hear(JSON.parse(event.data) as Told)).catch((error: unknown) => tell(String(error)));
    });

  const tell = (trouble = ""): void => {
    const [first, ...others] = known.mistakes;
    state.textContent = trouble || (lost && "disconnected") || known.doing || (first ? "cannot be read" : "valid");
    state.className = `state ${trouble || lost || first ? "differs" : known.doing ? "skipped" : "passed"}`;
    renew(mistakes, JSON.stringify(known.mistakes), () => known.mistakes.map(({ text }) => part("pre", { text })));
    heard.failed = first && {
      status: "differs",
      image: "disagrees",
      headline: `Cannot read ${file}: ${first.message}`,
      lead: [
        ["Still showing", "the last file that could be read"],
        ...(first.hint ? [["Would help", first.hint] as [string, string]] : []),
        ...(first.place ? [["At", [first.place, first.code].filter(Boolean).join(", ")] as [string, string]] : []),
        ...(others.length ? [["More", `${others.length} more below`] as [string, string]] : []),
      ],
      helps: [],
    };
    if (lost) heard.failed = { status: "differs", image: "disagrees", headline: lost, lead: [["Still showing", "the last run"], ["Would help", "start it again and open the new address"]], helps: [] };
    const tried = first ? [] : (heard.helps[player.shown[0]] ?? []);
    renew(helps, JSON.stringify(tried), () => (tried.length ? [part("h2", { class: "label", text: "Would let it stand, each tried" }), ...tried.map(helping)] : []));
    renew(excerpt, JSON.stringify([known.lines, known.mistakes, tried, claims()]), () => written(known, tried, claims()));
    heard.changed();
  };
  // The lines of the claims that fail.
  const claims = (): number[] =>
    (player.runs[player.shown[0]]?.told.told.claims ?? []).filter((claim) => !claim.passed).map((claim) => Number(/:(\d+):\d+$/.exec(claim.place)?.[1]));

  on<Status>("status", (status) => {
    player.keep(status.runs);
    known = status;
    if (known.lines[known.lines.length - 1] === "") known.lines.pop();
    tell();
  });
  on<{ run: number; told: Payload }>("run", async ({ run, told }) => {
    early.set(run, await Run.of({ ...told, weakest: heard.weakest[run] ?? null }));
    for (const [number, found] of [...early].sort(([one], [other]) => one - other)) {
      if (number > player.runs.length) break;
      player.put(number, found);
      early.delete(number);
    }
    const band = document.querySelector(".band")!;
    band.classList.remove("fresh");
    void (band as HTMLElement).offsetWidth; // so that it begins to fade anew
    band.classList.add("fresh");
    tell();
  });
  on<{ run: number; lines: string[]; weakest: Payload["weakest"]; helps: Help[] }>("lines", (told) => {
    heard.lines[told.run] = told.lines;
    heard.weakest[told.run] = told.weakest;
    if (player.runs[told.run]) player.runs[told.run].told.weakest = told.weakest;
    heard.helps[told.run] = told.helps;
    tell();
  });
  source.addEventListener("open", () => ((lost = ""), tell()));
  source.addEventListener("error", () => ((lost = "stackdsl has ended, or cannot be reached"), tell()));
}

// The file, with marks on the lines of mistakes, of claims that fail, and of numbers that would help.
function written({ lines, mistakes }: Status, helps: Help[], claims: number[]): HTMLElement[] {
  const wrong = new Set(mistakes.map(({ line }) => line));
  const failing = new Set(mistakes.length ? [] : claims);
  const changing = new Set(mistakes.length ? [] : helps.map(({ line }) => line));
  const marked = [...wrong, ...failing, ...changing].filter((line) => line > 0);
  const first = Math.max(1, Math.min(lines.length - AROUND + 1, Math.min(...marked, Infinity) - 4));
  return lines.slice(first - 1, first - 1 + AROUND).map((text, place) => {
    const line = first + place;
    const kind = wrong.has(line) ? "wrong" : failing.has(line) ? "failing" : changing.has(line) ? "changing" : "";
    const found = part("li", { class: kind }, part("code", { text: text || " " }));
    found.value = line;
    return found;
  });
}
