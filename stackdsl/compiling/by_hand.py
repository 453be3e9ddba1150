"""Bricks that hands bring: when each comes, is in its place and is let go, and whether its way is free."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from stability.geometry.neighbours import Neighbours
from stability.geometry.rotations import rotate
from stability.geometry.vectors import add, norm, scale
from stability.model import BodyId, Pose, Quaternion
from stability.shapes.apart import apart_from_plane, in_place, meeting
from stability.shapes.in_pose import bounds_W
from stackdsl.compiling.built import Built
from stackdsl.compiling.built_bricks import BuiltBrick
from stackdsl.compiling.fitting import OVERLAP
from stackdsl.compiling.impacts.handling import limit_speed
from stackdsl.compiling.impacts.scene import MissError, scene_of
from stackdsl.compiling.moment import Moment
from stackdsl.compiling.site import tilt_of, turned_pose
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.hand_words import ByHand
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source
from stackdsl.timeline import Action, Arrival, Hold, LetGo, Move, Placement
from stackdsl.wording import mm


@dataclass(frozen=True, slots=True)
class Brought:
    """A brick that a hand brings."""

    brick: BuiltBrick
    hand: ByHand

    @property
    def came(self) -> Pose:
        """Where it comes, in the frame of the scene."""
        pose = self.brick.written.pose
        return Pose(add(pose.position_W, self.hand.from_), pose.orientation)

    @property
    def begins(self) -> float:
        """When the hand comes with it [s]."""
        return self.brick.in_hand.begins

    @property
    def let_go(self) -> float:
        """When the hand lets it go [s]."""
        return self.brick.in_hand.let_go


def brought(built: Built, scenario: Scenario) -> list[Brought]:
    """All that hands bring, in order of time."""
    steps = [
        (brick, scenario.build[brick.written.step].place) for brick in built.in_order if not brick.written.inserted
    ]
    return [Brought(brick, hand) for brick, hand in steps if hand is not None]


def bringing(
    bricks: Sequence[Brought], placements: Mapping[BodyId, Placement], tilt: Quaternion
) -> Iterator[tuple[Moment, Action]]:
    """What hands do: those that bring bricks together let them go together."""
    for (_, arrives), group in groupby(bricks, key=lambda one: (one.brick.written.step, one.brick.placed)):
        together = list(group)
        names = tuple(one.brick.name for one in together)
        for one in together:
            yield _at(arrives, placements[one.brick.name])
            places_W = tuple(rotate(tilt, place) for place in one.hand.course.places_W)
            course = type(one.hand.course)(places_W, one.hand.speed)
            yield _at(arrives, Move(one.begins, one.brick.name, course, lowers=True))
        if together[0].hand.held:
            yield _at(arrives, Hold(arrives.time, names))
        yield _at(arrives, LetGo(together[0].let_go, names))


def placed_by_hand(placement: Placement, one: Brought, tilt: Quaternion) -> Placement:
    """A placement, as a hand does it."""
    return replace(placement, time=one.begins, arrival=Arrival.BY_HAND, came=turned_pose(one.came, tilt))


def _at(arrives: Moment, action: Action) -> tuple[Moment, Action]:
    return arrives._replace(time=action.time), action


# --- whether it can be ------------------------------------------------------------------------------------------------


def hands_that_bring(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Hands that are too fast, begin inside something, or pass through something; one for each step."""
    bricks, told = brought(built, scenario), set[int]()
    if not bricks:
        return
    scene, places = scene_of(built, scenario.world.gravity, tilt_of(scenario)), _places(built)
    for one in bricks:
        step = one.brick.written.step
        if step in told:
            continue
        path: Path = ("build", step, "place")
        try:
            limit_speed(one.hand.speed, scene)
        except MissError as miss:
            told.add(step)
            span = source.span_of((*path, miss.key) if "speed" in one.hand.model_fields_set else path)
            yield Diagnostic(miss.code, span, miss.message, miss.hint)
            continue
        if (why := _in_the_way(one, built, places)) is not None:
            told.add(step)
            yield Diagnostic("SD209", source.span_of(path), why, "let the hand come from elsewhere, by `from`")


def _places(built: Built) -> Neighbours[int]:
    """All bricks by their number, to ask which are near the way of a hand."""
    found: Neighbours[int] = Neighbours()
    for number, brick in enumerate(built.bricks):
        found.add(number, *bounds_W(brick.written.shape, brick.written.pose))
    return found


def _in_the_way(one: Brought, built: Built, places: Neighbours[int]) -> str | None:
    """What is in the way of a hand, of all whose place is known; what it touches in the end is not."""
    name, shape = one.brick.name, one.brick.written.shape
    for plane in built.planes:
        gap = apart_from_plane(shape, one.came, plane).gap
        if gap < -OVERLAP:
            return f"the hand comes with brick '{name}' {mm(-gap)} inside {plane.id}"
    length = norm(one.hand.from_)
    along, block = scale(-1.0 / length, one.hand.from_), in_place(shape, one.came)
    ends = (bounds_W(shape, one.came), bounds_W(shape, one.brick.written.pose))
    (ax, ay, az), (bx, by, bz) = (map(min, *(low for low, _ in ends)), map(max, *(high for _, high in ends)))
    for number in places.around((ax, ay, az), (bx, by, bz), OVERLAP):
        other = built.bricks[number]
        there = other.placed < one.brick.placed and (other.gone is None or other.gone.time > one.begins)
        if other.name == name or not there or other.written.drop:
            continue
        way = meeting(block, in_place(other.written.shape, other.written.pose), along, OVERLAP)
        if way is not None and way[0] < length - OVERLAP and way[1] > OVERLAP:
            return f"brick '{other.name}' is in the way of the hand that brings brick '{name}'"
    return None
