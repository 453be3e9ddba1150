"""Motions by finite displacements as text, CSV and JSON."""

from collections.abc import Iterator, Sequence
from math import inf
from typing import Any, Final

from stability.analysis.large_motion import Position
from stackdsl.report.study_table import StudyTable, rows_within
from stackdsl.studies.large_motion import FollowedMotion, Pushed
from stackdsl.wording import PARTS

LABEL: Final = 11  # [characters] column of labels
MILLIMETRES: Final = 1000.0
SHOWN: Final = 8  # positions in text, about
DIGITS: Final = 5  # of a movement in text
COLUMNS: Final = ("case", "movement", "unit", "thrust_n", "thrust_per_weight", "load_factor", "hinges", "sliding")


def motion_lines(found: FollowedMotion) -> Iterator[str]:
    """Yield the end of a motion, then its positions at which other hinges open."""
    yield f"{found.case}: {ending_text(found)}"
    for number, part in enumerate(found.why.split(PARTS) if found.why else ()):
        yield f"  {'' if number else 'falls':<{LABEL}}{part}"
    yield ""
    of_loads = found.pushed is Pushed.LOADS
    yield f"  {'displacement' if of_loads else 'movement':>14}  {'load factor' if of_loads else 'thrust':>14}  hinges"
    for position in _told(found.motion.positions):
        value = f"{round(position.factor, 4) + 0.0:.4f}" if of_loads else f"{found.thrust(position):.1f} N"
        movement = f"{found.movement(position.amount):.3f} {found.unit}"
        yield f"  {movement:>14}  {value:>14}  {hinges_text(position)}"


def ending_text(found: FollowedMotion) -> str:
    """Return how a motion ends, in words."""
    motion = found.motion
    holds = f"{found.movement(motion.holds):.{DIGITS}g} {found.unit}"
    if motion.ends:
        return f"followed to {holds}: {motion.ends}"
    if found.pushed is Pushed.LOADS:
        first, last = motion.positions[0].factor, motion.positions[-1].factor
        if motion.falls == inf:
            sliding = ", where it still slides" if motion.positions[-1].sliding else ""
            later = f"{last:.5g} times at a displacement of {holds}{sliding}"
            return f"bears {first:.5g} times its loads at first, and {later}"
        return f"bears {first:.5g} times its loads at first, and none of them at a displacement of {holds}"
    if motion.falls == inf:
        return f"stands when its supports have moved by {holds}"
    times = f"{motion.holds:.5g} times the movement in the file"
    return f"falls when its supports have moved by more than {holds}, {times}"


def hinges_text(position: Position) -> str:
    """Return the hinges of a position with their places, and the joints that slide."""
    hinges = [
        f"{hinge.lower}-{hinge.upper} ({', '.join(f'{round(MILLIMETRES * x) + 0:d}' for x in hinge.point_W)})"
        for hinge in position.hinges
    ]
    sliding = [f"{upper} slides on {lower}" for lower, upper in position.sliding]
    return "; ".join(hinges + sliding) or "none"


def _told(positions: Sequence[Position]) -> Iterator[Position]:
    """Yield the first and the last position, those with other hinges than before, and some between."""
    last: object = None
    apart = positions[-1].amount / SHOWN if positions else 0.0
    told = -inf
    for number, position in enumerate(positions):
        opened = {(hinge.lower, hinge.upper) for hinge in position.hinges}, position.sliding
        if opened != last or position.amount >= told + apart or number == len(positions) - 1:
            yield position
            told = position.amount
        last = opened


def motion_table(found: Sequence[FollowedMotion]) -> StudyTable:
    """Return a row for each position; JSON has poses and reactions too."""
    cases = [_case(each) for each in found]
    return StudyTable(COLUMNS, rows_within(cases, "positions"), cases)


def _case(found: FollowedMotion) -> dict[str, Any]:
    motion = found.motion
    return {
        "case": found.case,
        "unit": found.unit,
        "holds": found.movement(motion.holds),
        "falls": None if motion.falls == inf else found.movement(motion.falls),
        "why": found.why,
        "ends": motion.ends,
        "weight_n": found.weight,
        "positions": [_row(found, position) for position in motion.positions],
    }


def _row(found: FollowedMotion, position: Position) -> dict[str, Any]:
    supported = found.pushed is Pushed.SUPPORTS
    thrust = found.thrust(position) if supported else None
    return {
        "movement": found.movement(position.amount),
        "thrust_n": thrust,
        "thrust_per_weight": None if thrust is None else thrust / found.weight,
        "load_factor": None if supported else position.factor,
        "hinges": "; ".join(f"{hinge.lower}-{hinge.upper}" for hinge in position.hinges),
        "sliding": "; ".join(f"{lower}-{upper}" for lower, upper in position.sliding),
        "hinges_at_m": [hinge.point_W for hinge in position.hinges],
        "reactions_n": position.reactions_W,
        "poses": {name: (pose.position_W, pose.orientation) for name, pose in position.poses.items()},
    }
