"""Measures speed against error of every system, by the truths of scenarios (`make bench`, about 20 minutes).

Without arguments it plays the scenarios below on the systems of the table in README. It prints every run, the wrong
results, and a row for each system and time step. `--write` stores the figures in docs/data, draws the picture, and
renders the texts.
"""

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

from rich.console import Console
from rich.markdown import Markdown

from benchmarks.figures.data import file_of, load, save
from benchmarks.figures.pages import ROOT, render
from benchmarks.figures.recording import parser
from benchmarks.systems.bench import Bench, bench, jobs_of
from benchmarks.systems.entrants import entrant_named
from benchmarks.systems.measured import CASES, NAME, PICTURE, cases_text, data_of
from benchmarks.systems.plot import drawn
from benchmarks.systems.table import bench_text
from stackdsl.checking.cases import Case, gather
from stackdsl.cli.options import complain
from stackdsl.cli.terminal import paper, progress, write
from stackdsl.results import RunStatus
from stackdsl.simulation.plugins import ForeignSystemError

# Scenarios with a known result that every system can play within 20 minutes: 16 to 20 minutes, of which the hits take
# 3, and other scenes of the publication 3. A four-stack of 25 levels would take 4 more: see benchmarks/four_stack.py.
SCENARIOS = [
    ROOT / "scenarios" / name
    for name in (
        "slant-tower.yaml",
        "columns.yaml",
        "harmonic.yaml",
        "incline.yaml",
        "leaning.yaml",
        "drop.yaml",
        "hard",
        "capabilities/card-house.yaml",
        "capabilities/slant-tower.yaml",
        "capabilities/impact-level-3.yaml",
        "capabilities/impact-top.yaml",
        "user_test",
    )
]
# Excluded: too long, without a sufficiently known result, or variants of a scene for one system.
LEFT_OUT = {"long", "open", "comparison"}
SYSTEMS = ("exact", "thesis", "tuned", "stock", "mujoco", "sapien", "cra", "rbe")
RESOLUTIONS = "1,1/2"
FINEST, COARSEST = Fraction(1, 64), Fraction(64)


def main() -> None:
    """Play and print; write the figures on request."""
    arguments = parser(__doc__)
    arguments.add_argument("paths", nargs="*", type=Path, help="scenarios to play instead")
    arguments.add_argument("--system", action="append", dest="systems", help="only these systems; may be repeated")
    arguments.add_argument("--resolutions", default=RESOLUTIONS, help="time steps, as so many times each system's own")
    arguments.add_argument("--cases", action="store_true", help="print the kept runs, case by case, and play none")
    arguments.add_argument("--draw", action="store_true", help="draw the picture from the kept points, and play none")
    chosen = arguments.parse_args()
    if chosen.draw:
        _draw()
        return
    if chosen.cases:
        if not file_of(CASES).exists():
            arguments.error(
                f"no {file_of(CASES).name} in docs/data: run `make bench`, or copy the file of a release there"
            )
        Console().print(Markdown("".join(cases_text(load(CASES)))))
        return
    systems, factors = _playable(arguments, chosen.systems or SYSTEMS), _factors(arguments, chosen.resolutions)
    cases = _cases(chosen.paths)
    jobs = jobs_of(cases, systems, factors)
    if not jobs:
        arguments.error("there is nothing to play")
    with progress(len(jobs)) as bar:
        found = bench(jobs, bar.tell, bar.wait)
    write(bench_text(found, *paper()))
    crashed = any(score.record.status == RunStatus.CRASHED for score in found.scores)
    if found.interrupted or crashed:
        sys.exit("interrupted" if found.interrupted else "a run has crashed")
    if chosen.write:
        _write(found)


def _cases(paths: Sequence[Path]) -> list[Case]:
    gathered = gather(paths or SCENARIOS)
    if gathered.diagnostics:
        complain(gathered.diagnostics)
        sys.exit("there are mistakes in scenarios")
    taken = [case for case in gathered.cases if not case.is_sampled]
    return taken if paths else [case for case in taken if not LEFT_OUT & {*case.scenario.tags}]


def _playable(arguments: ArgumentParser, names: Sequence[str]) -> Sequence[str]:
    """Return the named systems, each once; all must be installed."""
    for name in names:
        try:
            package = entrant_named(name).package
        except (KeyError, ForeignSystemError) as error:
            arguments.error(f"there is no system '{name}'" if isinstance(error, KeyError) else str(error))
        if not package.installed:
            arguments.error(f"'{name}' needs {package.name}, which is not installed; try: {package.remedy}")
    return list(dict.fromkeys(names))


def _factors(arguments: ArgumentParser, text: str) -> Sequence[float]:
    """Return the factors on the time step of each system, such as `2,1,1/2`."""
    try:
        factors = [Fraction(part.strip()) for part in text.split(",")]
    except (ValueError, ZeroDivisionError):
        arguments.error(f"'{text}' is no list of numbers; write it like {RESOLUTIONS}")
    if not all(FINEST <= factor <= COARSEST for factor in factors):
        arguments.error(f"steps are from {FINEST} to {COARSEST} times as long; write it like {RESOLUTIONS}")
    return [float(factor) for factor in dict.fromkeys(factors)]


def _write(found: Bench) -> None:
    for data in data_of(found):
        save(data)
    _draw()
    render()


def _draw() -> None:
    """Draw the picture from the stored points."""
    (ROOT / "docs" / PICTURE).write_bytes(drawn(load(NAME).tables["points"]))


if __name__ == "__main__":
    main()
