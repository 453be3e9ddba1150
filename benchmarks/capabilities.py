"""Plays the scenes of the two published tests on every system named there: the figures of docs/method.md.

Run it with `python -m benchmarks.capabilities`; five minutes, most of them for the long runs of `tuned`.
"""

from itertools import takewhile
from pathlib import Path

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stackdsl.checking.cases import Case, gather
from stackdsl.checking.play_case import play_case
from stackdsl.results import observations
from stackdsl.trace import STAND, BrickState, EventKind, Trace

SCENARIOS = Path(__file__).parent.parent / "scenarios"
FOLDERS = ("capabilities", "user_test")
AIMS = {"impact-level-3": "L3.2", "impact-top": "L13.2"}  # target of the thrown plank


def main() -> None:
    """Play and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    cases = gather([SCENARIOS / folder for folder in FOLDERS]).cases
    console = Console(stderr=True)
    rows = {
        row_name(case): row(case, play_case(case.timeline, case.system))
        for case in track(cases, "scenes of the publication", console=console, transient=True)
    }
    table = Table("case", *next(iter(rows.values())))
    for name, values in rows.items():
        shown = (f"{value:.4g}" if isinstance(value, float) else str(value) for value in values.values())
        table.add_row(name, *shown)
    Console(width=200).print(table)
    if write:
        record("capabilities", "python -m benchmarks.capabilities --write", {"cases": rows})


def row_name(case: Case) -> str:
    """Return the name of a case, with a word for the slash of a unit."""
    return case.name.replace("/", " per ")


def row(case: Case, trace: Trace) -> Row:
    """Return the figures of a run."""
    seen = observations(trace)
    collapse, landing = trace.collapse, trace.landing
    aim = next((brick for family, brick in AIMS.items() if family in case.name), None)
    return {
        "verdict": trace.reported_verdict,
        "statics": trace.statics.stability.value if trace.statics is not None else None,
        "level": collapse.level if collapse is not None else None,
        "first": collapse.brick if collapse is not None else None,
        "placed": sum(t.state not in (BrickState.UNPLACED, BrickState.THROWN) for t in trace.tracks.values()),
        "levels_standing": levels_standing(trace),
        "woken": len({name for event in trace.events if event.kind is EventKind.WOKEN for name in event.bricks}),
        "drift_mm": 1000.0 * trace.drift,
        "drift_of_what_stands_mm": _number(seen["drift of what stands"]),
        "shift_before_mm": 1000.0 * trace.shift_before,
        "hit_mm": 1000.0 * trace.tracks[aim].shift if aim is not None else None,
        "reach_mm": 1000.0 * landing.reach if landing is not None else None,
    }


def _number(value: object) -> float | None:
    return value if isinstance(value, float) else None


def levels_standing(trace: Trace) -> int:
    """Return the number of levels, from the lowest, with all bricks standing at the end."""
    tracks = [each for each in trace.tracks.values() if each.state is not BrickState.THROWN]
    levels = sorted({each.level for each in tracks})
    whole = {level: all(each.state in STAND for each in tracks if each.level == level) for level in levels}
    return len(list(takewhile(whole.__getitem__, levels)))


if __name__ == "__main__":
    main()
