"""Plays the structures of the user test and very fast throws on `modified`, which imitates the second published system.

The two structures of the user test are built until they fall, and a plank is thrown at level 3 of the tower of 13
levels so fast that the engine's steps are too long for it. Run it with `python -m benchmarks.modified_users`; half a
minute.
"""

from dataclasses import replace
from math import hypot

from rich.console import Console

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.modified import SCENARIOS, printed, struck, thrown
from stackdsl.checking.cases import Case, gather
from stackdsl.checking.play_case import play_case
from stackdsl.timeline import Action, Placement
from stackdsl.trace import BrickState

STRUCTURES = ("leaning-structure", "card-house")
SPEEDS = (8.0, 20.0)  # [m/s]


def main() -> None:
    """Play and print the tables; write them on request."""
    write = parser(__doc__).parse_args().write
    built = {name.replace("-", " "): by_users(name) for name in STRUCTURES}
    hits = {
        f"level 3, {speed:g} m per s": struck(faster(thrown("impact-level-3")[-1], speed), "L3.2") for speed in SPEEDS
    }
    for heading, rows in (("user test", built), ("hit", hits)):
        Console(width=120).print(printed(heading, rows))
    if write:
        record("modified-users", "python -m benchmarks.modified_users --write", {"user_test": built, "hits": hits})


def by_users(scenario: str) -> Row:
    """Return the level at which a structure of the user test falls, or that it stands."""
    cases = gather([SCENARIOS.parent / "user_test" / f"{scenario}.yaml"]).cases
    timeline = next(case.timeline for case in cases if case.scenario.scenario == f"user-test-{scenario}")
    trace = play_case(timeline, "modified")
    return {
        "verdict": trace.reported_verdict,
        "level": None if trace.collapse is None else trace.collapse.level,
        "placed": sum(track.state is not BrickState.UNPLACED for track in trace.tracks.values()),
    }


def faster(case: Case, speed: float) -> Case:
    """Return the same throw at another speed [m/s] that arrives at the same height."""

    def thrown_so(action: Action) -> Action:
        if not isinstance(action, Placement) or not action.hits:
            return action
        x, y, z = action.velocity_W
        factor = speed / hypot(x, y)
        return replace(action, velocity_W=(factor * x, factor * y, z / factor))

    return replace(case, timeline=replace(case.timeline, actions=tuple(map(thrown_so, case.timeline.actions))))


if __name__ == "__main__":
    main()
