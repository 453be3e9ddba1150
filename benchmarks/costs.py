"""Measures what falls and hits cost: whole runs on `exact`, on engines with every brick awake, and before.

Each run is a process of its own on one core. Its seconds are processor time of the run, proofs included, after a small
run that loads what the system needs. Next to them stands the error: whether all that the scenario expects holds, or
how far a hit plank slides compared with the closed form.

Run it with `python -m benchmarks.costs`; it needs the extra `mujoco` and the plug-in `stackdsl-sapien`. `--before`
names a checkout of an earlier version, whose `exact` is played too. `--keep` names a file of rows; finished runs are
not run again. With every system it takes about an hour.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.dropped import kept
from benchmarks.figures.data import Row
from benchmarks.figures.pages import ROOT
from benchmarks.figures.recording import parser, record

LIMIT_S: Final = 300  # of processor time, after which a run is ended
BEFORE: Final = "before"
RUNS: Final = ("exact", BEFORE, "tuned", "mujoco", "sapien")

HEAD: Final = "scenario: cost\nbrick: kapla\nfriction: 0.5\n"
SCENES: Final = {  # a scenario, or the scene of another benchmark
    "column of 12 planks, the tenth makes it fall": (
        HEAD + "build: [{column: {levels: 12, step: 12 mm}, every: 1 s}]\nexpect: [{collapses: {at: level 10}}]\n"
    ),
    "harmonic stack of 100 planks that falls": (
        HEAD + "build: [{harmonic: {bricks: 100, share: 1.03}}]\nexpect: [{collapses: {at: level 100}}]\n"
    ),
    "tower of 100 planks that leans and falls": (
        HEAD + "build: [{four_stack: {levels: 50, step: 1.6 mm, spacing: 43 mm}}]\nexpect: [{collapses: any}]\n"
    ),
    "Jenga tower": (ROOT / "scenarios" / "jenga.yaml").read_text(),
    **{
        f"row of {count} dominoes": HEAD
        + f"build: [{{dominoes: {{bricks: {count}, spacing: 30 mm}}}}]\n"
        + "impacts: [{at: 1 s, push: {brick: L1.1, impulse: [2 mN*s, 0 N*s, 0 N*s], point: [0 mm, 0 mm, 50 mm]}}]\n"
        + f"watch: {3.0 + 0.03 * count:g} s\nexpect: [{{falls: {{count: {count}}}}}]\n"
        for count in (80, 200, 1000)
    },
    "wall of 30 x 30 planks, hit in the middle": "wall",
}
LONG: Final = ("row of 200 dominoes", "row of 1000 dominoes")  # played on `exact` alone

# A checkout plays it in its own directory. The arguments are a scene, a system, and the seconds that a run may take.
PLAYED: Final = """
import json, sys
from resource import RLIMIT_CPU, setrlimit
from time import process_time
from benchmarks import dropped, wall_hits
from stackdsl.api.run import play as played
from stackdsl.checking.cases import cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play

scene, system, limit = sys.argv[1], sys.argv[2], int(sys.argv[3])
play(dropped.let_go(1), system_named(system))
if scene == "wall":
    bricks = wall_hits.placed(30, 30)
    target = wall_hits.middle_of(15, bricks)
    timeline = wall_hits.thrown_at(bricks, target, 3.0)
else:
    cases, mistakes = cases_of(parse(scene, "cost.yaml"))
    assert not mistakes, mistakes
began = process_time()
setrlimit(RLIMIT_CPU, (int(began) + limit + 1, -1))
if scene == "wall":
    trace = play(timeline, system_named(system))
else:
    run = played(cases[0].on(system))
    trace = run.trace
seconds = process_time() - began
if scene == "wall":
    found = wall_hits.measured(trace, target, wall_hits.way_mm(15, 1.5, 2))
    error = f"{found['error_percent']:+.1f} %"
else:
    error = "" if all(outcome.passed for outcome in run.outcomes) else "wrong"
print(json.dumps({"seconds": seconds, "steps": trace.cost.steps, "error": error}))
"""


def main() -> None:
    """Play and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--before", type=Path, help="a checkout of an earlier version")
    arguments.add_argument("--scenes", nargs="+", default=[""], help="words; only scenes with one of them are played")
    arguments.add_argument("--systems", nargs="+", default=list(RUNS), choices=RUNS)
    arguments.add_argument("--keep", type=Path, help="file of rows, which is gone on with")
    chosen = arguments.parse_args()
    names = [name for name in SCENES if any(word in name for word in chosen.scenes)]
    found = kept(chosen.keep)
    runs = [run for run in chosen.systems if run != BEFORE or chosen.before is not None]
    asked = [(name, run) for name in names for run in runs if run == "exact" or name not in LONG]
    for name, run in track(asked, "costs", console=Console(stderr=True)):
        if (key := f"{name} / {run}") not in found:
            tree, system = (chosen.before, "exact") if run == BEFORE else (ROOT, run)
            found[key] = one(tree, SCENES[name], system)
            if chosen.keep is not None:
                with chosen.keep.open("a") as file:
                    file.write(json.dumps([key, found[key]]) + "\n")
    rows: dict[str, Row] = {}
    for name in names:
        cells = {run: found.get(f"{name} / {run}") for run in RUNS}
        texts = {run: None if cell is None else shown(cell) for run, cell in cells.items()}
        now, then = ((cells[run] or {}).get("seconds") for run in ("exact", BEFORE))
        times = f"{then / now:.2g}" if isinstance(now, float) and isinstance(then, float) else None
        rows[name] = {**texts, "times": times}
    table = Table("", *RUNS, "times as fast as before")
    for name, row in rows.items():
        table.add_row(name, *(str(row.get(key) or "-") for key in (*RUNS, "times")))
    Console(width=140).print(table)
    if chosen.write:
        record("costs", "python -m benchmarks.costs --before BEFORE --write", {"scenes": rows})


def one(tree: Path, scene: str, system: str) -> Row:
    """Return the processor time of a run, its steps and its error; without a time if it exceeds the limit."""
    paths = [str(tree.resolve()), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    run = subprocess.run(
        [sys.executable, "-c", PLAYED, scene, system, str(LIMIT_S)],
        cwd=tree,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
        check=False,
    )
    if run.returncode < 0:  # by the limit
        return {"seconds": None, "steps": None, "error": ""}
    if run.returncode:
        raise RuntimeError(f"{system} failed in {tree}:\n{run.stderr}")
    row: Row = json.loads(run.stdout.splitlines()[-1])
    return row


def shown(cell: Row) -> str:
    """Return the seconds and the error of a run as text."""
    if cell["seconds"] is None:
        return f"over {LIMIT_S}"
    return f"{cell['seconds']:.3g}" + (f", {cell['error']}" if cell["error"] else "")


if __name__ == "__main__":
    main()
