"""What the engine as it comes makes of the publication's structures when constants of the scene are changed.

Its second system is of this kind: constants such as gravity and friction were changed until the engine stacked. A
four-stack of 30 levels stands by statics whatever they are; the slant tower falls at level 9; the card house stands.
The scenes in which a plank is thrown are played on `modified` alone. Run it with `python -m benchmarks.modified`; two
minutes.
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
HITS = {"level 3": ("impact-level-3", "L3.2"), "top": ("impact-top", "L13.2")}  # scenario, and what is thrown at
MODIFICATIONS = {
    **{f"gravity {gravity:g} m/s2": Modification(gravity=gravity) for gravity in (0.1, 1.0, 3.0)},
    "gravity 9.81 m/s2, as written": AS_WRITTEN,
    "planks 10 times as large": Modification(size=10.0),
    "gravity 1 m/s2, friction 1.5: `modified`": MODIFIED,
    "gravity 1 m/s2, friction 1.5, planks 10 times as large": replace(MODIFIED, size=10.0),
}


def main() -> None:
    """Play, print the table, and keep it if asked to."""
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
    """For people who look on."""
    table = Table(heading, *next(iter(rows.values())))
    for name, values in rows.items():
        table.add_row(name, *(f"{value:.3g}" if isinstance(value, float) else str(value) for value in values.values()))
    return table


def timeline(scenario: str) -> Timeline:
    """The scene of the publication that is called so."""
    cases = gather([SCENARIOS / f"{scenario}.yaml"]).cases
    return next(case.timeline for case in cases if case.scenario.scenario == f"capabilities-{scenario}")


def thrown(scenario: str) -> list[Case]:
    """A plank thrown at the four-stack of 13 levels, at each speed, in the engine alone."""
    cases = gather([SCENARIOS / f"{scenario}.yaml"]).cases
    return [case for case in cases if case.scenario.scenario.endswith("-bare") and case.system == "stock"]


def speed(case: Case) -> str:
    """How fast, with a word for the slash of the unit."""
    return dict(case.variant.parameters)["speed"].replace("/", " per ")


def struck(case: Case, aim: BodyId) -> Row:
    """What a hit does in the changed scene."""
    trace = play_case(case.timeline, "modified")
    return {
        "verdict": trace.reported_verdict,
        "levels_standing": levels_standing(trace),
        "planks_standing": sum(each.state in STAND for each in trace.tracks.values()),
        "hit_mm": 1000.0 * trace.tracks[aim].shift,
        "passed_through": None if trace.passed_through is None else trace.passed_through.through,
    }


def row(modification: Modification, timelines: dict[str, Timeline]) -> Row:
    """What comes of each structure."""
    system = replace(SYSTEMS["stock"], modification=modification)
    traces = {key: play(scene, system) for key, scene in timelines.items()}
    told = {key: told_of(trace) for key, trace in traces.items()}
    return {**told, "four_stack_drift_mm": 1000.0 * drift(traces["four_stack"])}


def told_of(trace: Trace) -> str:
    """Whether it stands, or where it falls."""
    return "stands" if trace.collapse is None else f"falls at level {trace.collapse.level}"


def drift(trace: Trace) -> float:
    """How far a plank has crept; of what falls, before the plank came with which it did [m]."""
    return trace.drift if trace.collapse is None else trace.shift_before


if __name__ == "__main__":
    main()
