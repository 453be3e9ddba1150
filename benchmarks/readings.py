"""Compares the effect of each reading of the published equations on the publication's structures with statics.

The text leaves the meaning of some equations open (`stability/stabilizers/published/support.py`). Each is changed by
itself, and so is the rule by which two supports share a load, for a rule that conserves load and moment. Run it with
`python -m benchmarks.readings`; four minutes.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import log2
from pathlib import Path

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.model import BodyId
from stability.stabilizers.published.support import AS_READ, ActsAt, Closest, Merge, Readings, Square
from stackdsl.checking.cases import gather
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS, System
from stackdsl.timeline import Timeline
from stackdsl.trace import EventKind, Trace

SCENARIOS = Path(__file__).parent.parent / "scenarios"
TOWERS = {
    "four_stack": ("capabilities/four-stack.yaml", "capabilities-four-stack"),
    "slant": ("capabilities/slant-tower.yaml", "capabilities-slant-tower"),
    "leaning": ("user_test/leaning-structure.yaml", "user-test-leaning-structure"),
}
CARD_HOUSE = ("capabilities/card-house.yaml", "capabilities-card-house")
FRICTIONS = (0.02, 1.0)  # range of the search for the least friction of the card house
ACCURACY = 0.001  # of that friction
READINGS: Mapping[str, Readings] = {
    "as `thesis` reads it": AS_READ,
    "pivot of a merge: the closest point, not corner": Readings(pivot=Closest.POINT),
    "Eq. 10 to the letter: mass acts at com above": Readings(acts_at=ActsAt.COM_ABOVE),
    "pivot of a leaning brick: the closest corner": Readings(leaning_pivot=Closest.CORNER),
    "angle of a leaning brick: against gravity": Readings(leaning_angle=Square.GRAVITY),
    "angle of a leaning brick: against the normal": Readings(leaning_angle=Square.NORMAL),
    "not published: the lever rule, which keeps moments": Readings(merge=Merge.LEVER_RULE),
}


def main() -> None:
    """Play and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    systems = {name: replace(SYSTEMS["thesis"], readings=readings) for name, readings in READINGS.items()}
    systems["statics: `exact`"] = SYSTEMS["exact"]
    scenes = {key: timeline(*where) for key, where in TOWERS.items()}
    house = timeline(*CARD_HOUSE)
    console = Console(stderr=True)
    rows = {
        name: row(system, scenes, house)
        for name, system in track(systems.items(), "readings", console=console, transient=True)
    }
    table = Table("reading", *next(iter(rows.values())))
    for name, values in rows.items():
        table.add_row(name, *(f"{value:.3g}" if isinstance(value, float) else str(value) for value in values.values()))
    Console(width=180).print(table)
    if write:
        record("readings", "python -m benchmarks.readings --write", {"scenes": rows})


def timeline(path: str, scenario: str) -> Timeline:
    """Return the timeline of a scene of the publication."""
    return next(case.timeline for case in gather([SCENARIOS / path]).cases if case.scenario.scenario == scenario)


def row(system: System, towers: Mapping[str, Timeline], house: Timeline) -> Row:
    """Return the figures of each structure, and the friction that the card house needs."""
    told: dict[str, str | float | None] = {name: told_of(play(tower, system)) for name, tower in towers.items()}
    return {**told, "card_house": told_of(play(house, system)), "card_house_friction": least_friction(house, system)}


def told_of(trace: Trace) -> str:
    """Return the brick at which a run falls, and the first brick at which bricks wake without a fall."""
    woken = next((event.time for event in trace.events if event.kind is EventKind.WOKEN), None)
    falls = None if trace.collapse is None else f"falls with {last_placed(trace, trace.collapse.time)}"
    wakes = None if woken is None else f"woken from {last_placed(trace, woken)} on"
    if falls is not None and wakes is not None and falls.split()[-1] in wakes:
        wakes = None
    return "; ".join(filter(None, [falls or "stands", wakes]))


def last_placed(trace: Trace, time: float) -> BodyId:
    """Return the brick that was placed last at a time."""
    placed = (event for event in trace.events if event.kind is EventKind.PLACED and event.time <= time)
    return [name for event in placed for name in event.bricks][-1]


def least_friction(house: Timeline, system: System) -> float | None:
    """Return the least friction with which a structure stands; None if it falls with any."""
    falls, stands = FRICTIONS
    if not stands_with(house, system, stands):
        return None
    for _ in range(round(log2((stands - falls) / ACCURACY))):
        middle = 0.5 * (falls + stands)
        falls, stands = (falls, middle) if stands_with(house, system, middle) else (middle, stands)
    return stands


def stands_with(timeline: Timeline, system: System, friction: float) -> bool:
    """Return whether a structure stands with this friction everywhere."""
    planes = tuple(replace(plane, friction=friction) for plane in timeline.world.planes)
    world = replace(timeline.world, friction=friction, planes=planes)
    return play(replace(timeline, world=world), system).collapse is None


if __name__ == "__main__":
    main()
