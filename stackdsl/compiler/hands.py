"""Compiles hands: when each brick comes and is released, and whether its path is free."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from stability.geometry.placed_shape import apart_from_plane, bounds_W, in_place, meeting
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import add, norm, rotate, scale
from stability.model import BodyId, Pose, Quaternion, Vec3
from stackdsl.compiler.bricks import ActionOrder, BuiltBrick
from stackdsl.compiler.fit import OVERLAP
from stackdsl.compiler.impact_scene import MissError, scene_of
from stackdsl.compiler.impacts import limit_speed
from stackdsl.compiler.schedule import Built, tilt_of, turned_pose
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.hands import ByHand
from stackdsl.language.impacts import Move
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import Action, Arrival, HoldAction, LetGo, MoveAction, Placement
from stackdsl.wording import mm

# Bricks that hands bring: when each comes, is in its place and is let go, and whether its way is free.


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
) -> Iterator[tuple[ActionOrder, Action]]:
    """What hands do: those that bring bricks together let them go together."""
    for (_, arrives), group in groupby(bricks, key=lambda one: (one.brick.written.step, one.brick.placed)):
        together = list(group)
        names = tuple(one.brick.name for one in together)
        for one in together:
            yield _at(arrives, placements[one.brick.name])
            places_W = tuple(rotate(tilt, place) for place in one.hand.course.places_W)
            course = type(one.hand.course)(places_W, one.hand.speed)
            yield _at(arrives, MoveAction(one.begins, one.brick.name, course, lowers=True))
        if together[0].hand.held:
            yield _at(arrives, HoldAction(arrives.time, names))
        yield _at(arrives, LetGo(together[0].let_go, names))


def placed_by_hand(placement: Placement, one: Brought, tilt: Quaternion) -> Placement:
    """A placement, as a hand does it."""
    return replace(placement, time=one.begins, arrival=Arrival.BY_HAND, came=turned_pose(one.came, tilt))


def _at(arrives: ActionOrder, action: Action) -> tuple[ActionOrder, Action]:
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
        path: KeyPath = ("build", step, "place")
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


# Are hands asked for what they can do: each brick in one at a time, and no way through ground or walls?


ROUNDING = 1e-9  # [s] of times that are worked out from others


@dataclass(frozen=True, slots=True)
class _InHand:
    """While a brick is in a hand."""

    path: KeyPath
    begins: float  # [s]
    ends: float  # [s]


def hands_apart(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """What is done to bricks while they are in another hand."""
    in_hand: dict[BodyId, _InHand] = {}
    for one in brought(built, scenario):
        path: KeyPath = ("build", one.brick.written.step, "place")
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
