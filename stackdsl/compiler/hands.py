"""Compiles hands: the times at which they bring and release bricks, and checks of their paths."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from stability.geometry.placed_shape import apart_from_plane, bounds_W, in_place, meeting
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import add, norm, rotate, scale
from stability.model import BodyId, Pose, Quaternion, Vec3
from stackdsl.compiler.bricks import ActionOrder, ResolvedBrick
from stackdsl.compiler.fit import OVERLAP
from stackdsl.compiler.impact_scene import MissError, scene_of
from stackdsl.compiler.impacts import limit_speed
from stackdsl.compiler.schedule import ResolvedScenario, tilt_of, turned_pose
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.hands import ByHand
from stackdsl.language.impacts import Move
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import Action, Arrival, HoldAction, MoveAction, Placement, ReleaseAction
from stackdsl.wording import mm

# Bricks that hands bring.


@dataclass(frozen=True, slots=True)
class CarriedBrick:
    """A brick that a hand brings."""

    brick: ResolvedBrick
    hand: ByHand

    @property
    def start(self) -> Pose:
        """The pose at which the hand starts, in the scene frame."""
        pose = self.brick.written.pose
        return Pose(add(pose.position_W, self.hand.from_), pose.orientation)

    @property
    def begins(self) -> float:
        """The time at which the hand starts [s]."""
        return self.brick.in_hand.begins

    @property
    def let_go(self) -> float:
        """The time at which the hand releases the brick [s]."""
        return self.brick.in_hand.let_go


def carried_bricks(built: ResolvedScenario, scenario: Scenario) -> list[CarriedBrick]:
    """Return the bricks that hands bring, in order of time."""
    steps = [
        (brick, scenario.build[brick.written.step].place) for brick in built.in_order if not brick.written.inserted
    ]
    return [CarriedBrick(brick, hand) for brick, hand in steps if hand is not None]


def carrying_actions(
    bricks: Sequence[CarriedBrick], placements: Mapping[BodyId, Placement], tilt: Quaternion
) -> Iterator[tuple[ActionOrder, Action]]:
    """Yield the actions of the hands; hands that bring bricks together release them together."""
    for (_, arrives), group in groupby(bricks, key=lambda carried: (carried.brick.written.step, carried.brick.placed)):
        together = list(group)
        names = tuple(carried.brick.name for carried in together)
        for carried in together:
            yield _at(arrives, placements[carried.brick.name])
            places_W = tuple(rotate(tilt, place) for place in carried.hand.course.places_W)
            course = type(carried.hand.course)(places_W, carried.hand.speed)
            yield _at(arrives, MoveAction(carried.begins, carried.brick.name, course, lowers=True))
        if together[0].hand.held:
            yield _at(arrives, HoldAction(arrives.time, names))
        yield _at(arrives, ReleaseAction(together[0].let_go, names))


def carried_placement(placement: Placement, carried: CarriedBrick, tilt: Quaternion) -> Placement:
    """Return a placement as carried out by a hand."""
    return replace(placement, time=carried.begins, arrival=Arrival.BY_HAND, came=turned_pose(carried.start, tilt))


def _at(arrives: ActionOrder, action: Action) -> tuple[ActionOrder, Action]:
    return arrives._replace(time=action.time), action


# --- checks -----------------------------------------------------------------------------------------------------------


def blocked_carrying(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report hands that are too fast, or start inside or pass through a body; one diagnostic per step."""
    bricks, reported = carried_bricks(built, scenario), set[int]()
    if not bricks:
        return
    scene, places = scene_of(built, scenario.world.gravity, tilt_of(scenario)), _places(built)
    for carried in bricks:
        step = carried.brick.written.step
        if step in reported:
            continue
        path: KeyPath = ("build", step, "place")
        try:
            limit_speed(carried.hand.speed, scene)
        except MissError as miss:
            reported.add(step)
            span = source.span_of((*path, miss.key) if "speed" in carried.hand.model_fields_set else path)
            yield Diagnostic(miss.code, span, miss.message, miss.hint)
            continue
        if (obstacle := _obstacle(carried, built, places)) is not None:
            reported.add(step)
            yield Diagnostic("SD209", source.span_of(path), obstacle, "choose another start with `from`")


def _places(built: ResolvedScenario) -> Neighbours[int]:
    """Return a spatial index of all bricks, by index."""
    grid: Neighbours[int] = Neighbours()
    for number, brick in enumerate(built.bricks):
        grid.add(number, *bounds_W(brick.written.shape, brick.written.pose))
    return grid


def _obstacle(carried: CarriedBrick, built: ResolvedScenario, places: Neighbours[int]) -> str | None:
    """Return the message about a body of known position in the path of a hand; contacts at the end do not count."""
    name, shape = carried.brick.name, carried.brick.written.shape
    for plane in built.planes:
        gap = apart_from_plane(shape, carried.start, plane).gap
        if gap < -OVERLAP:
            return f"the path of the hand starts with brick '{name}' {mm(-gap)} inside {plane.id}"
    length = norm(carried.hand.from_)
    along, block = scale(-1.0 / length, carried.hand.from_), in_place(shape, carried.start)
    ends = (bounds_W(shape, carried.start), bounds_W(shape, carried.brick.written.pose))
    (ax, ay, az), (bx, by, bz) = (map(min, *(low for low, _ in ends)), map(max, *(high for _, high in ends)))
    for number in places.around((ax, ay, az), (bx, by, bz), OVERLAP):
        other = built.bricks[number]
        is_present = other.placed < carried.brick.placed and (
            other.removed is None or other.removed.time > carried.begins
        )
        if other.name == name or not is_present or other.written.drop:
            continue
        way = meeting(block, in_place(other.written.shape, other.written.pose), along, OVERLAP)
        if way is not None and way[0] < length - OVERLAP and way[1] > OVERLAP:
            return f"brick '{other.name}' blocks the path of the hand that brings brick '{name}'"
    return None


# Each brick may be in one hand at a time, and no path may lead through the ground or walls.


ROUNDING = 1e-9  # [s] rounding error of computed times


@dataclass(frozen=True, slots=True)
class _InHand:
    """The time for which a brick is in a hand."""

    path: KeyPath
    begins: float  # [s]
    ends: float  # [s]


def actions_on_held_bricks(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report impacts on bricks that are in another hand."""
    in_hand: dict[BodyId, _InHand] = {}
    for carried in carried_bricks(built, scenario):
        path: KeyPath = ("build", carried.brick.written.step, "place")
        in_hand[carried.brick.name] = _InHand(path, carried.begins, carried.let_go)
    order = sorted(range(len(scenario.impacts)), key=built.impacts.__getitem__)
    for number in order:
        impact, begins = scenario.impacts[number], built.impacts[number].time
        path = ("impacts", number, impact.kind)
        for name in impact.content.struck:
            other = in_hand.get(name)
            if other is not None and begins < other.ends - ROUNDING:
                there, here = source.key_span_of(other.path), source.key_span_of(path)
                message = f"the hand of {there.seen_from(here)} holds brick '{name}' until {other.ends:g} s"
                hint = f"begin at {other.ends:g} s or later, when the hand has released the brick"
                yield Diagnostic("SD209", here, message, hint)
            if impact.content.lasts:
                in_hand[name] = _InHand(path, begins, begins + impact.content.lasts)


def moves_through_planes(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report moves into the ground or a wall, of bricks with known positions."""
    bricks = {brick.name: brick for brick in built.bricks if not brick.written.drop}
    shifts: dict[BodyId, Vec3 | None] = {}  # None if unknown before the run
    for number in sorted(range(len(scenario.impacts)), key=built.impacts.__getitem__):
        impact = scenario.impacts[number]
        for name in impact.content.struck:
            shift = shifts.get(name, (0.0, 0.0, 0.0))
            if not isinstance(impact.content, Move):
                shifts[name] = shift if impact.content.lasts else None
            elif name in bricks and shift is not None:
                yield from _through(impact.content, bricks[name], shift, built, source, number)
                shifts[name] = add(shift, impact.content.course.end_W)


def _through(  # noqa: PLR0913, PLR0917 -- a path, its start and its position in the file
    move: Move, brick: ResolvedBrick, shift: Vec3, built: ResolvedScenario, source: Source, number: int
) -> Iterator[Diagnostic]:
    written = brick.written
    for place in move.course.places_W:
        pose = Pose(add(written.pose.position_W, add(shift, place)), written.pose.orientation)
        for plane in built.planes:
            gap = apart_from_plane(written.shape, pose, plane).gap
            if gap < -OVERLAP:
                span = source.span_of(("impacts", number, "move", move.kind))
                message = f"the hand would move brick '{brick.name}' {mm(-gap)} into {plane.id}"
                yield Diagnostic("SD209", span, message, f"choose a path that avoids {plane.id}")
                return
