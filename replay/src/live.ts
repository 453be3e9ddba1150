// A page that is open while its file is edited: it hears of each run again whenever that has changed.
import { part, say } from "./page";
import type { Payload } from "./payload";
import type { Player } from "./player";
import { Run } from "./run";

// Where texts go that a page hears while it is open.
export interface Heard {
  mistakes: HTMLElement;
  lines: string[][]; // by run
  weakest: (string | null)[]; // by run, the brick that they call so
  changed(): void; // runs came or went
}

interface Status {
  runs: number;
  mistakes: string[];
  doing: string;
}

export function listen(player: Player, heard: Heard): void {
  const source = new EventSource("events");
  const state = part("p", { class: "state" });
  heard.mistakes.before(state);
  const early = new Map<number, Run>(); // those that came before one of a lower number
  let turn = Promise.resolve(); // one after the other, in the order in which they came
  const on = <Told>(kind: string, hear: (told: Told) => Promise<void> | void): void =>
    source.addEventListener(kind, (event: MessageEvent<string>) => {
      turn = turn.then(() => hear(JSON.parse(event.data) as Told)).catch((error: unknown) => say(state, String(error)));
    });
  on<Status>("status", ({ runs, mistakes, doing }) => {
    player.keep(runs);
    say(heard.mistakes, mistakes.join("\n"));
    say(state, doing);
    heard.changed();
  });
  on<{ run: number; told: Payload }>("run", async ({ run, told }) => {
    early.set(run, await Run.of(told));
    for (const [number, found] of [...early].sort(([one], [other]) => one - other)) {
      if (number > player.runs.length) break;
      player.put(number, found);
      early.delete(number);
    }
    heard.changed();
  });
  on<{ run: number; lines: string[]; weakest: string | null }>("lines", ({ run, lines, weakest }) => {
    heard.lines[run] = lines;
    heard.weakest[run] = weakest;
    player.retell();
  });
  source.addEventListener("open", () => say(state, ""));
  source.addEventListener("error", () => say(state, "stackdsl has ended; this page shows its last run"));
}
