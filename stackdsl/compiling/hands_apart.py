"""Are hands asked for what they can do: each brick in one at a time, and no way through ground or walls?"""

from collections.abc import Iterator
from dataclasses import dataclass

from stability.geometry.vectors import add
from stability.model import BodyId, Pose, Vec3
from stability.shapes.apart import apart_from_plane
from stackdsl.compiling.built import Built
from stackdsl.compiling.built_bricks import BuiltBrick
from stackdsl.compiling.by_hand import brought
from stackdsl.compiling.fitting import OVERLAP
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.impacts.move import Move
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source
from stackdsl.wording import mm

ROUNDING = 1e-9  # [s] of times that are worked out from others


@dataclass(frozen=True, slots=True)
class _InHand:
    """While a brick is in a hand."""

    path: Path
    begins: float  # [s]
    ends: float  # [s]


def hands_apart(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """What is done to bricks while they are in another hand."""
    in_hand: dict[BodyId, _InHand] = {}
    for one in brought(built, scenario):
        path: Path = ("build", one.brick.written.step, "place")
        in_hand[one.brick.name] = _InHand(path, one.begins, one.let_go)
    order = sorted(range(len(scenario.impacts)), key=built.impacts.__getitem__)
    for number in order:
        impact, begins = scenario.impacts[number], built.impacts[number].time
        path = ("impacts", number, impact.kind)
        for name in impact.done.struck:
            other = in_hand.get(name)
            if other is not None and begins < other.ends - ROUNDING:
                there, here = source.key_span_of(other.path), source.key_span_of(path)
                message = f"brick '{name}' is in the hand of {there.seen_from(here)} until {other.ends:g} s"
                hint = f"begin at {other.ends:g} s, when it is let go, or later"
                yield Diagnostic("SD209", here, message, hint)
            if impact.done.lasts:
                in_hand[name] = _InHand(path, begins, begins + impact.done.lasts)


def ways_through_planes(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Moves that lead into the ground or a wall, of bricks whose place is known."""
    bricks = {brick.name: brick for brick in built.bricks if not brick.written.drop}
    shifts: dict[BodyId, Vec3 | None] = {}  # None where only a run can tell
    for number in sorted(range(len(scenario.impacts)), key=built.impacts.__getitem__):
        impact = scenario.impacts[number]
        for name in impact.done.struck:
            shift = shifts.get(name, (0.0, 0.0, 0.0))
            if not isinstance(impact.done, Move):
                shifts[name] = shift if impact.done.lasts else None
            elif name in bricks and shift is not None:
                yield from _through(impact.done, bricks[name], shift, built, source, number)
                shifts[name] = add(shift, impact.done.course.end_W)


def _through(  # noqa: PLR0913, PLR0917 -- a way, where it begins, and where it is written
    move: Move, brick: BuiltBrick, shift: Vec3, built: Built, source: Source, number: int
) -> Iterator[Diagnostic]:
    written = brick.written
    for place in move.course.places_W:
        pose = Pose(add(written.pose.position_W, add(shift, place)), written.pose.orientation)
        for plane in built.planes:
            gap = apart_from_plane(written.shape, pose, plane).gap
            if gap < -OVERLAP:
                span = source.span_of(("impacts", number, "move", move.kind))
                message = f"the hand would take brick '{brick.name}' {mm(-gap)} into {plane.id}"
                yield Diagnostic("SD209", span, message, f"lead it past {plane.id}")
                return
