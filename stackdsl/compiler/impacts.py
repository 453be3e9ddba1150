"""Compiles impacts of every kind into actions of the timeline."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import singledispatch
from math import atan2, cos, inf, sin, sqrt

from stability.geometry.placed_shape import apart, distance_outside, in_place, meeting
from stability.geometry.vectors import add, add_scaled, inverse, norm, rotate, scale, subtract
from stability.model import BodyId, Brick, Pose, Quaternion, Vec3
from stackdsl.compiler.bricks import ActionOrder
from stackdsl.compiler.fit import OVERLAP
from stackdsl.compiler.impact_scene import (
    ImpactScene,
    MissError,
    StandingBrick,
    aimed_at,
    keep_out_of_planes,
    middle_of,
    missing,
    on_the_way,
    scene_of,
)
from stackdsl.compiler.schedule import ResolvedScenario, tilt_of, turned_pose
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.impacts import Cut, Drop, Glue, Hold, ImpactKind, Move, Push, Remove, Throw
from stackdsl.language.quantities import SPEED
from stackdsl.language.rotations import about_axes, about_z
from stackdsl.language.schema import Scenario
from stackdsl.language.value_types import named_in
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import Action, Arrival, HoldAction, MoveAction, Placement, PushAction, ReleaseAction, Removal
from stackdsl.wording import MILLIMETRES, mm, rounded_down, rounded_up

# The actions of an impact. Each kind registers a function.


@singledispatch
def actions_of(done: ImpactKind, _scene: ImpactScene) -> tuple[Action, ...]:
    """Return the actions of an impact. Raises MissError if it cannot happen as written."""
    if done.slid_in is not None:
        return ()  # the brick is placed like those of the build
    raise NotImplementedError(f"no function is registered for {type(done).__name__}")


# Drops: the brick starts vertically above the midpoint of its target, at the height of the drop.


@actions_of.register
def dropped(drop: Drop, scene: ImpactScene) -> tuple[Placement, ...]:
    """Return the placement of the falling brick at its start. Raises MissError."""
    brick = scene.missile
    assert brick is not None  # a drop always has one
    below = aimed_at(drop.onto, scene, "onto")
    orientation = _along(below[0]) if drop.rotate is None else about_axes(drop.rotate)
    down = rotate(inverse(scene.tilt), (0.0, 0.0, -1.0))  # in the scene frame
    middle = middle_of(below)
    falling = in_place(brick.shape, Pose(middle, orientation))
    ways = [(other, meeting(falling, other.shape, down, OVERLAP)) for other in on_the_way(falling, down, scene)]
    met = {other.name: way for other, way in ways if way is not None}
    # Distance from the midpoint of the target downwards; negative above.
    lands = min((met[other.name][0] for other in below if other.name in met), default=None)
    if lands is None:
        hint = "rotate it with `rotate`, or choose a brick as its target"
        raise MissError("onto", "SD207", f"brick '{brick.id}' misses its target", hint)
    for name, (enters, leaves) in met.items():
        if enters < lands - OVERLAP and leaves > lands - drop.height + OVERLAP:
            hint = f"drop it onto '{name}', from a smaller height, or rotated with `rotate`"
            raise MissError("onto", "SD207", f"brick '{name}' blocks the path of brick '{brick.id}'", hint)
    start = Pose(add_scaled(middle, lands - drop.height, down), orientation)
    keep_out_of_planes(brick, start, scene, "height")
    pose, flight = turned_pose(start, scene.tilt), sqrt(2.0 * drop.height / scene.gravity)
    return (Placement(scene.moment.time, brick, 0, pose, Arrival.DROPPED, flight=flight),)


def _along(brick: StandingBrick) -> Quaternion:
    """Return the orientation that lies flat along the length of a brick; along x for a brick that stands on end."""
    x, y, _ = brick.shape.axes_W[0]
    return about_z(atan2(y, x) if abs(x) + abs(y) > OVERLAP else 0.0)


# A brick must not start inside another one in flight.
#
# The position of a flying brick is known until it arrives, or until another impact acts on it.


TIME_ROUNDING = 1e-9  # [s] rounding error of computed times


@dataclass(frozen=True, slots=True)
class Flight:
    """The flight of a thrown or dropped brick, with the index of its impact."""

    number: int
    moment: ActionOrder
    placement: Placement


@dataclass(frozen=True, slots=True)
class FlightCollision:
    """A flight that starts inside an earlier one."""

    later: Flight
    earlier: Flight
    depth: float  # [m]


def crossings(
    flights: Sequence[Flight], known_until: Mapping[BodyId, ActionOrder], gravity: float
) -> Iterator[FlightCollision]:
    """Yield the first crossing of each flight that starts inside others.

    `known_until` maps bricks to the moments when they are pulled out or pushed.
    """
    in_time = sorted(flights, key=lambda flight: flight.moment)
    for index, later in enumerate(in_time):
        in_flight = [flight for flight in in_time[:index] if _flies_at(flight, later.moment, known_until)]
        pairs = (FlightCollision(later, flight, _depth(flight, later, gravity)) for flight in in_flight)
        yield from [crossing for crossing in pairs if crossing.depth > OVERLAP][:1]


def _flies_at(flight: Flight, moment: ActionOrder, known_until: Mapping[BodyId, ActionOrder]) -> bool:
    """Whether a brick is in flight at a moment, undisturbed."""
    arrives = flight.moment.time + flight.placement.flight
    end = known_until.get(flight.placement.brick.id)
    return moment.time <= arrives + TIME_ROUNDING and (end is None or moment < end)


def _depth(earlier: Flight, later: Flight, gravity: float) -> float:
    """Return the overlap of two bricks at the start of the later one [m]."""
    one, other, time = earlier.placement, later.placement, later.moment.time - earlier.moment.time
    fallen = add_scaled(one.pose.position_W, -0.5 * gravity * time * time, (0.0, 0.0, 1.0))
    pose = replace(one.pose, position_W=add_scaled(fallen, time, one.velocity_W))
    return -apart(one.brick.shape, pose, other.brick.shape, other.pose).gap


# Hands that move or hold bricks.


@actions_of.register
def moved(move: Move, scene: ImpactScene) -> tuple[MoveAction | HoldAction | ReleaseAction, ...]:
    """Return the move, the holding and the release. Raises MissError."""
    _reach_for(move.brick, scene)
    limit_speed(move.speed, scene)
    course = move.course
    turned = tuple(rotate(scene.tilt, place) for place in course.places_W)
    begins, arrives = scene.moment.time, scene.moment.time + course.duration
    holding = (HoldAction(arrives, (move.brick,)),) if move.held else ()
    course_W = type(course)(turned, course.speed)
    free_W = rotate(scene.tilt, (0.0, 0.0, 1.0)) if move.slid else None
    return (
        MoveAction(begins, move.brick, course_W, free_W),
        *holding,
        ReleaseAction(begins + move.lasts, (move.brick,)),
    )


@actions_of.register
def held(hold: Hold, scene: ImpactScene) -> tuple[HoldAction | ReleaseAction, ...]:
    """Return the holding and the release. Raises MissError."""
    _reach_for(hold.brick, scene)
    begins = scene.moment.time
    return (HoldAction(begins, (hold.brick,)), ReleaseAction(begins + hold.for_, (hold.brick,)))


def _reach_for(name: BodyId, scene: ImpactScene) -> None:
    """Raise MissError if a brick is not present at the moment of the scene."""
    brick = next((brick for brick in scene.bricks if brick.name == name), None)
    if brick is not None:
        if not brick.is_there(scene.moment):
            raise missing(name, scene, "brick")
    elif (comes := scene.flying[name].since) > scene.moment:
        message = (
            f"brick '{name}' does not exist before {comes.time:g} s, but this impact begins at {scene.moment.time:g} s"
        )
        raise MissError("brick", "SD204", message, "begin later")


def limit_speed(speed: float, scene: ImpactScene) -> None:
    """Raise MissError if a hand is faster than a brick that has fallen by the thickness of the thinnest brick.

    Up to that speed, a pushed brick moves by a fraction of its thickness per step of any system. A faster hand hits.
    """
    sizes = [(brick.shape.thickness, brick.name) for brick in scene.bricks]
    sizes += [(flying.brick.shape.least_thickness, name) for name, flying in scene.flying.items()]
    thinnest, name = min(sizes)
    most = sqrt(2.0 * scene.gravity * thinnest)
    if speed > most:
        message = f"a hand at {speed:g} m/s is too fast for the thinnest brick, '{name}' ({mm(thinnest)})"
        hint = f"write a speed of at most {rounded_down(MILLIMETRES * most)} mm/s, or use `push` or `throw`"
        raise MissError("speed", "SD104", message, hint)


# Pushes.


TURNED = 1e-12  # relative rounding error of a rotated impulse


@actions_of.register
def pushed(push: Push, scene: ImpactScene) -> tuple[PushAction, ...]:
    """Return the push of a brick of the structure, or of one thrown or dropped before. Raises MissError."""
    brick = next((brick for brick in scene.bricks if brick.name == push.brick), None)
    if brick is None:
        _await(push.brick, scene.flying[push.brick].since, scene)
    elif not brick.is_there(scene.moment):
        raise missing(push.brick, scene, "brick")
    elif not brick.let_go:
        _touch(push.point, brick)
    impulse_W, offset_W = rotate(scene.tilt, push.impulse), rotate(scene.tilt, push.point)
    return (PushAction(scene.moment.time, push.brick, impulse_W, offset_W),)


def _await(name: BodyId, comes: ActionOrder, scene: ImpactScene) -> None:
    if comes > scene.moment:
        message = (
            f"brick '{name}' does not exist before {comes.time:g} s, but this impact begins at {scene.moment.time:g} s"
        )
        raise MissError("brick", "SD204", message, "push it later")


def _touch(point: Vec3, brick: StandingBrick) -> None:
    """Raise MissError if a point, given from the centre of a brick, is outside of it."""
    beyond = distance_outside(brick.shape, add(brick.centre, point))
    if beyond > OVERLAP:
        message = f"the point is {mm(beyond)} outside brick '{brick.name}'"
        raise MissError(
            "point",
            "SD207",
            message,
            "write the point relative to the centre of the brick, along the axes of the scene",
        )


def limit_push(push: PushAction, scene: ImpactScene) -> None:
    """Raise MissError if a push gives a brick no speed, or more than the largest speed of a thrown brick."""
    brick = next((brick for brick in scene.bricks if brick.name == push.brick), None)
    mass = scene.flying[push.brick].brick.mass if brick is None else brick.mass
    speed, most = norm(push.impulse_W) / mass, float(SPEED.most)
    if 0.0 < speed <= most * (1.0 + TURNED):
        return
    message = f"the push accelerates brick '{push.brick}' to {speed:.4g} m/s, outside the range from 0 to {most:g} m/s"
    hint = f"write an impulse greater than 0 and at most {rounded_down(1000.0 * mass * most)} mN*s"
    raise MissError("impulse", "SD104", message, hint)


# All impacts of a scenario.


@dataclass
class ImpactActions:
    """The actions of all impacts, and the mistakes of those that cannot happen as written."""

    actions: list[tuple[ActionOrder, Action]] = field(default_factory=list)
    mistakes: list[Diagnostic] = field(default_factory=list)


def impact_actions(built: ResolvedScenario, scenario: Scenario, source: Source) -> ImpactActions:
    """Return the actions of all impacts."""
    result = ImpactActions()
    if not scenario.impacts:
        return result
    scene = scene_of(built, scenario.world.gravity, tilt_of(scenario))
    names = {*(brick.name for brick in scene.bricks), *scene.flying}
    flights: list[Flight] = []
    for number, (impact, moment) in enumerate(zip(scenario.impacts, built.impacts, strict=True)):
        if any(named.name not in names for named in named_in(impact)):
            continue  # `unknown_bricks` reports it
        try:
            actions = _actions(impact.content, replace(scene, moment=moment, missile=built.missiles.get(number)))
        except MissError as miss:
            span = source.span_of(("impacts", number, impact.kind, miss.key))
            result.mistakes.append(Diagnostic(miss.code, span, miss.message, miss.hint))
        else:
            result.actions += [(moment._replace(time=action.time), action) for action in actions]
            flights += [Flight(number, moment, action) for action in actions if isinstance(action, Placement)]
    blocked = crossings(flights, _struck(built, scenario), scene.gravity)
    result.mistakes += [_blocked(crossing, scenario, source) for crossing in blocked]
    return result


def _actions(done: ImpactKind, scene: ImpactScene) -> tuple[Action, ...]:
    """Return the actions of an impact, within the limits for every kind. Raises MissError."""
    actions = actions_of(done, scene)
    for action in actions:
        if isinstance(action, PushAction):
            limit_push(action, scene)
    return actions


def _struck(built: ResolvedScenario, scenario: Scenario) -> Mapping[BodyId, ActionOrder]:
    """Return the moment at which each brick is first pulled out or pushed."""
    first: dict[BodyId, ActionOrder] = {}
    for moment, impact in sorted(zip(built.impacts, scenario.impacts, strict=True), key=lambda timed: timed[0]):
        for name in impact.content.struck:
            first.setdefault(name, moment)
    return first


def _blocked(crossing: FlightCollision, scenario: Scenario, source: Source) -> Diagnostic:
    later, earlier = crossing.later, crossing.earlier
    here, there = (
        source.key_span_of(("impacts", flight.number, scenario.impacts[flight.number].kind))
        for flight in (later, earlier)
    )
    message = (
        f"brick '{later.placement.brick.id}' starts {mm(crossing.depth)} inside "
        f"brick '{earlier.placement.brick.id}', which is still in flight from {there.seen_from(here)}"
    )
    hint = f"start it later, for example with `after: impact {earlier.number + 1} + 0.5 s`, or elsewhere"
    return Diagnostic("SD201", here, message, hint)


# Joints. Glue and cuts are compiled together with all other joints, in `joints_in_time`.


@actions_of.register
def joined(_joining: Glue | Cut, _scene: ImpactScene) -> tuple[()]:
    """Return no action."""
    return ()


# Removals.


@actions_of.register
def removed(remove: Remove, scene: ImpactScene) -> tuple[Removal, ...]:
    """Return the removal of all bricks at once, in file order."""
    return (Removal(scene.moment.time, tuple(named.name for named in remove.pulled_out)),)


def early_removals(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report bricks that are pulled out twice, or before they are placed; `unknown_bricks` reports unknown names."""
    placed_at = {brick.name: brick.placed for brick in built.bricks} if scenario.impacts else {}
    placed_at |= {brick.id: built.impacts[number] for number, brick in built.missiles.items()}
    removed_by: dict[BodyId, KeyPath] = {}
    for number in sorted(range(len(built.impacts)), key=built.impacts.__getitem__):
        begins, impact = built.impacts[number], scenario.impacts[number]
        for named in impact.content.pulled_out:
            path, name = (("impacts", number, impact.kind, *named.path)), named.name
            if name in removed_by:
                there = source.span_of(removed_by[name])
                message = f"another impact also pulls out brick '{name}', at {there.seen_from(source.span_of(path))}"
                yield Diagnostic("SD204", source.span_of(path), message, "remove one of them")
            elif name in placed_at and placed_at[name] > begins:
                placed = placed_at[name].time
                message = (
                    f"brick '{name}' is not placed before {placed:g} s, but this impact begins at {begins.time:g} s"
                )
                hint = f"pull it out later, for example with `after: brick {name} + 1 s`"
                yield Diagnostic("SD204", source.span_of(path), message, hint)
            removed_by.setdefault(name, path)


# Throws: the brick starts with the upward speed that brings it to the height of its target on arrival.
#
# So it hits its target from any distance. It does not rotate in flight.


SPEED_ROUNDING = 1e-12  # relative rounding error, so that the speed given in a hint is accepted


@actions_of.register
def thrown(throw: Throw, scene: ImpactScene) -> tuple[Placement, ...]:
    """Return the placement of the thrown brick at its start. Raises MissError."""
    brick = scene.missile
    assert brick is not None  # a throw always has one
    towards = _direction_from(throw.from_.bearing)
    start = _start(brick, throw, towards, scene)
    ahead_W = rotate(scene.tilt, towards)
    _limit_height(throw, ahead_W, scene)
    # The position at time t is start + v t + g t^2 / 2; at the end it is `distance` ahead of the start.
    duration, gravity_W = throw.from_.distance / throw.speed, (0.0, 0.0, -scene.gravity)
    velocity_W = subtract(scale(throw.speed, ahead_W), scale(0.5 * duration, gravity_W))
    pose = turned_pose(start, scene.tilt)
    return (Placement(scene.moment.time, brick, 0, pose, Arrival.THROWN, velocity_W, duration),)


def _limit_height(throw: Throw, ahead_W: Vec3, scene: ImpactScene) -> None:
    """Raise MissError if the vertical speed of a throw at its start or end exceeds the largest allowed speed."""
    assert scene.missile is not None
    speed, distance, gravity = throw.speed, throw.from_.distance, scene.gravity
    climb, most = abs(ahead_W[2]), float(SPEED.most)
    fastest = climb * speed + 0.5 * gravity * (distance / speed)
    if fastest <= most * (1.0 + SPEED_ROUNDING):
        return
    # Below the smaller root of climb s^2 - most s + g d / 2 = 0, the flight takes too long.
    under_root = most * most - 2.0 * climb * gravity * distance
    slowest = gravity * distance / (most + sqrt(under_root)) if under_root >= 0.0 else inf
    nearest = 2.0 * (most - climb * speed) * speed / gravity
    remedies = [f"throw it at {rounded_up(slowest)} m/s or faster"] if speed < slowest <= most else []
    remedies += (
        [f"throw it from a distance of at most {rounded_down(MILLIMETRES * nearest)} mm"] if nearest > 0.0 else []
    )
    limit = f"the maximum is {most:g} m/s"
    message = f"the vertical speed of brick '{scene.missile.id}' reaches {fastest:.4g} m/s; {limit}"
    raise MissError("speed", "SD104", message, ", or ".join(remedies) or "reduce the speed or the distance")


def _direction_from(bearing: float) -> Vec3:
    """Return the horizontal direction of a flight, rounded to digits on which all processors agree."""
    return (0.0 - round(cos(bearing), 15), 0.0 - round(sin(bearing), 15), 0.0)


def _start(brick: Brick, throw: Throw, towards: Vec3, scene: ImpactScene) -> Pose:
    """Return the start pose: at the height of the target, with its front at the distance from the first brick met."""
    aim = middle_of(aimed_at(throw.at, scene, "at"))
    orientation = about_z(throw.from_.bearing + throw.turn)
    flying = in_place(brick.shape, Pose(aim, orientation))
    ways = [meeting(flying, other.shape, towards, OVERLAP) for other in on_the_way(flying, towards, scene)]
    nearest = min((way[0] for way in ways if way is not None), default=None)
    if nearest is None:
        hint = "aim at a brick, change the bearing, or write `turn: 90 deg` to throw it broadside"
        raise MissError("at", "SD207", f"brick '{brick.id}' misses all bricks", hint)
    start = Pose(add_scaled(aim, nearest - throw.from_.distance, towards), orientation)
    keep_out_of_planes(brick, start, scene, "from")
    return start
