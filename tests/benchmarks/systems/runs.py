"""Runs and cases for tests of the bench: a tower that stood and one that fell, and what is known of them."""

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.systems.answers import Answer, Source
from benchmarks.systems.run_record import Record
from stackdsl.checking.cases import Case
from stackdsl.results import KINDS, Seen
from tests.scenes import compiled, scene

STOOD: dict[str, Seen] = {
    **dict.fromkeys(KINDS),
    "verdict": "stands",
    "fallen": (),
    "drift": 0.25,
    "largest tilt": 0.0,
    "height": 39.0,
    "energy gain": 0.5,
    "shift before": 0.125,
}
FELL: dict[str, Seen] = {
    **STOOD,
    "verdict": "collapses",
    "collapse level": 3.0,
    "collapse time": 2.1,
    "first to leave": "L3.1",
    "fallen": ("L2.1", "L3.1"),
    "drift": 200.0,
    "reach": 80.0,
    "bearing": 179.0,
}
RECORD = Record(
    case="tower",
    system="tuned",
    factor=1.0,
    status="done",
    levels=5,
    observations=STOOD,
    wall_time=2.0,
    simulated_time=4.0,
    steps=4000,
    peak_memory=2**20,
)
SHOULD_STAND = Answer(stands=True, source=Source.TRUTH, undisturbed=True)
SHOULD_FALL = Answer(stands=False, source=Source.TRUTH, least=3.0, most=3.0)


def run(seen: Mapping[str, Seen] = STOOD, system: str = "tuned", factor: float = 1.0, **more: Seen) -> Record:
    seen = dict(seen) | {name.replace("_", " "): value for name, value in more.items()}
    return replace(RECORD, system=system, factor=factor, observations=seen)


def case_of(build: str, rest: str = "expect:\n  - stands: all\n") -> Case:
    cases, mistakes = compiled(scene(build, rest))
    assert mistakes == []
    return cases[0]
