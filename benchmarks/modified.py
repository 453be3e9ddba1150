"""Plays structures of the publication on the unextended engine with changed constants of the scene.

The publication's second system is of this kind: constants such as gravity and friction were changed until the engine
kept stacks. By statics a four-stack of 30 levels stands for any constants, the slant tower falls at level 9, and the
card house stands. The scenes with a thrown plank are played on `modified` alone. Run it with `python -m
benchmarks.modified`; two minutes.
"""

from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.capabilities import levels_standing
from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from stability.model import BodyId
from stackdsl.checking.cases import Case, gather
from stackdsl.checking.play_case import play_case
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import AS_WRITTEN, MODIFIED, SYSTEMS, Modification
from stackdsl.timeline import Timeline
from stackdsl.trace import STAND, Trace

SCENARIOS = Path(__file__).parent.parent / "scenarios" / "capabilities"
SCENES = {"four_stack": "four-stack", "slant_tower": "slant-tower", "card_house": "card-house"}  # key, scenario
HITS = {"level 3": ("impact-level-3", "L3.2"), "top": ("impact-top", "L13.2")}  # scenario, and target
MODIFICATIONS = {
    **{f"gravity {gravity:g} m/s2": Modification(gravity=gravity) for gravity in (0.1, 1.0, 3.0)},
    "gravity 9.81 m/s2, as written": AS_WRITTEN,
    "planks 10 times as large": Modification(size=10.0),
    "gravity 1 m/s2, friction 1.5: `modified`": MODIFIED,
    "gravity 1 m/s2, friction 1.5, planks 10 times as large": replace(MODIFIED, size=10.0),
}


def main() -> None:
    """Play and print the tables; write them on request."""
    write = parser(__doc__).parse_args().write
    timelines = {key: timeline(name) for key, name in SCENES.items()}
    console = Console(stderr=True)
    rows = {
        name: row(modification, timelines)
        for name, modification in track(MODIFICATIONS.items(), "modified scenes", console=console, transient=True)
    }
    hits = {
        f"{name}, {speed(case)}": struck(case, aim)
        for name, (scenario, aim) in track(HITS.items(), "hits", console=console, transient=True)
        for case in thrown(scenario)
    }
    for heading, part in (("changed", rows), ("hit", hits)):
        Console(width=160).print(printed(heading, part))
    if write:
        record("modified", "python -m benchmarks.modified --write", {"scenes": rows, "hits": hits})


def printed(heading: str, rows: Rows) -> Table:
    """Return the table for the terminal."""
    table = Table(heading, *next(iter(rows.values())))
    for name, values in rows.items():
        table.add_row(name, *(f"{value:.3g}" if isinstance(value, float) else str(value) for value in values.values()))
    return table


def timeline(scenario: str) -> Timeline:
    """Return the timeline of a scenario of the publication."""
    cases = gather([SCENARIOS / f"{scenario}.yaml"]).cases
    return next(case.timeline for case in cases if case.scenario.scenario == f"capabilities-{scenario}")


def thrown(scenario: str) -> list[Case]:
    """Return the throws at the four-stack of 13 levels, at each speed, on the engine alone."""
    cases = gather([SCENARIOS / f"{scenario}.yaml"]).cases
    return [case for case in cases if case.scenario.scenario.endswith("-bare") and case.system == "stock"]


def speed(case: Case) -> str:
    """Return the speed, with a word for the slash of the unit."""
    return dict(case.variant.parameters)["speed"].replace("/", " per ")


def struck(case: Case, aim: BodyId) -> Row:
    """Return the figures of a hit in the changed scene."""
    trace = play_case(case.timeline, "modified")
    return {
        "verdict": trace.reported_verdict,
        "levels_standing": levels_standing(trace),
        "planks_standing": sum(each.state in STAND for each in trace.tracks.values()),
        "hit_mm": 1000.0 * trace.tracks[aim].shift,
        "passed_through": None if trace.passed_through is None else trace.passed_through.through,
    }


def row(modification: Modification, timelines: dict[str, Timeline]) -> Row:
    """Return the figures of each structure."""
    system = replace(SYSTEMS["stock"], modification=modification)
    traces = {key: play(scene, system) for key, scene in timelines.items()}
    told = {key: told_of(trace) for key, trace in traces.items()}
    return {**told, "four_stack_drift_mm": 1000.0 * drift(traces["four_stack"])}


def told_of(trace: Trace) -> str:
    """Return whether the structure stands, or the level at which it falls."""
    return "stands" if trace.collapse is None else f"falls at level {trace.collapse.level}"


def drift(trace: Trace) -> float:
    """Return the largest creep of a plank; for a fall the one before the brick at which it fell [m]."""
    return trace.drift if trace.collapse is None else trace.shift_before


if __name__ == "__main__":
    main()
