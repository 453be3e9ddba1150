"""Compiles impacts of every kind into actions of the timeline."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import singledispatch
from math import atan2, cos, inf, sin, sqrt

from stability.geometry.placed_shape import apart, distance_outside, in_place, meeting
from stability.geometry.vectors import add, add_scaled, inverse, norm, rotate, scale, subtract
from stability.model import BodyId, Brick, Pose, Quaternion, Vec3
from stackdsl.compiler.bricks import ActionOrder, about_axes, about_z
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
from stackdsl.compiler.schedule import Built, tilt_of, turned_pose
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.impacts import Drop, Hold, ImpactKind, Move, Push, Remove, Throw
from stackdsl.language.quantities import SPEED
from stackdsl.language.schema import Scenario
from stackdsl.language.value_types import named_in
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import Action, Arrival, HoldAction, LetGo, MoveAction, Placement, PushAction, Removal
from stackdsl.wording import MILLIMETRES, mm, rounded_down, rounded_up

# What an impact comes to in the scene: the place where each kind registers how.


@singledispatch
def actions_of(done: ImpactKind, _scene: ImpactScene) -> tuple[Action, ...]:
    """The actions of the timeline that an impact comes to. Raises MissError if it cannot be as it is written."""
    if done.slid_in is not None:
        return ()  # it is placed with all other bricks of the structure
    raise NotImplementedError(f"nothing says what {type(done).__name__} comes to")


# Where a brick is let go that falls onto another: straight above its middle, by as much as it is to fall.


@actions_of.register
def dropped(drop: Drop, scene: ImpactScene) -> tuple[Placement, ...]:
    """The brick where it is let go. Raises MissError."""
    brick = scene.missile
    assert brick is not None  # the kind says that it has one
    below = aimed_at(drop.onto, scene, "onto")
    orientation = _along(below[0]) if drop.rotate is None else about_axes(drop.rotate)
    down = rotate(inverse(scene.tilt), (0.0, 0.0, -1.0))  # in the frame of the scene
    middle = middle_of(below)
    falling = in_place(brick.shape, Pose(middle, orientation))
    ways = [(other, meeting(falling, other.shape, down, OVERLAP)) for other in on_the_way(falling, down, scene)]
    met = {other.name: way for other, way in ways if way is not None}
    # From the middle of what is below; less than zero is above.
    lands = min((met[other.name][0] for other in below if other.name in met), default=None)
    if lands is None:
        hint = "turn it by `rotate`, or name a brick"
        raise MissError("onto", "SD207", f"brick '{brick.id}' falls past what it is dropped onto", hint)
    for name, (enters, leaves) in met.items():
        if enters < lands - OVERLAP and leaves > lands - drop.height + OVERLAP:
            hint = f"drop it onto '{name}', from lower down, or turned by `rotate`"
            raise MissError("onto", "SD207", f"brick '{name}' is in the way of brick '{brick.id}'", hint)
    start = Pose(add_scaled(middle, lands - drop.height, down), orientation)
    keep_out_of_planes(brick, start, scene, "height")
    pose, flight = turned_pose(start, scene.tilt), sqrt(2.0 * drop.height / scene.gravity)
    return (Placement(scene.moment.time, brick, 0, pose, Arrival.DROPPED, flight=flight),)


def _along(brick: StandingBrick) -> Quaternion:
    """Flat, with its length over that of a brick; along x over one that stands on end."""
    x, y, _ = brick.shape.axes_W[0]
    return about_z(atan2(y, x) if abs(x) + abs(y) > OVERLAP else 0.0)


# Does a brick that comes flying, or falls, begin where another one still is on its way?
#
# Where they are is known until they arrive, or something else is done to them; beyond, only a run can tell.


TIME_ROUNDING = 1e-9  # [s] of times that are worked out from others


@dataclass(frozen=True, slots=True)
class Coming:
    """A brick that comes, by the number of its impact."""

    number: int
    moment: ActionOrder
    placement: Placement


@dataclass(frozen=True, slots=True)
class Crossing:
    """One that begins inside another."""

    later: Coming
    earlier: Coming
    depth: float  # [m]


def crossings(
    coming: Sequence[Coming], known_until: Mapping[BodyId, ActionOrder], gravity: float
) -> Iterator[Crossing]:
    """Of each brick that begins inside others the first.

    `known_until` says which are pulled out or pushed, and when.
    """
    in_time = sorted(coming, key=lambda one: one.moment)
    for index, later in enumerate(in_time):
        there = [one for one in in_time[:index] if _flies_at(one, later.moment, known_until)]
        found = (Crossing(later, one, _depth(one, later, gravity)) for one in there)
        yield from [crossing for crossing in found if crossing.depth > OVERLAP][:1]


def _flies_at(coming: Coming, moment: ActionOrder, known_until: Mapping[BodyId, ActionOrder]) -> bool:
    """Whether it is on its way then, undisturbed."""
    arrives = coming.moment.time + coming.placement.flight
    end = known_until.get(coming.placement.brick.id)
    return moment.time <= arrives + TIME_ROUNDING and (end is None or moment < end)


def _depth(earlier: Coming, later: Coming, gravity: float) -> float:
    """How far the later one is inside the earlier one when it begins [m]."""
    one, other, time = earlier.placement, later.placement, later.moment.time - earlier.moment.time
    fallen = add_scaled(one.pose.position_W, -0.5 * gravity * time * time, (0.0, 0.0, 1.0))
    pose = replace(one.pose, position_W=add_scaled(fallen, time, one.velocity_W))
    return -apart(one.brick.shape, pose, other.brick.shape, other.pose).gap


# Bricks that hands move or hold, and let go.


@actions_of.register
def moved(move: Move, scene: ImpactScene) -> tuple[MoveAction | HoldAction | LetGo, ...]:
    """The way of the hand, and its end. Raises MissError."""
    _reach_for(move.brick, scene)
    limit_speed(move.speed, scene)
    course = move.course
    turned = tuple(rotate(scene.tilt, place) for place in course.places_W)
    begins, arrives = scene.moment.time, scene.moment.time + course.duration
    held = (HoldAction(arrives, (move.brick,)),) if move.held else ()
    course_W = type(course)(turned, course.speed)
    free_W = rotate(scene.tilt, (0.0, 0.0, 1.0)) if move.slid else None
    return (MoveAction(begins, move.brick, course_W, free_W), *held, LetGo(begins + move.lasts, (move.brick,)))


@actions_of.register
def held(hold: Hold, scene: ImpactScene) -> tuple[HoldAction | LetGo, ...]:
    """From when to when it is held. Raises MissError."""
    _reach_for(hold.brick, scene)
    begins = scene.moment.time
    return (HoldAction(begins, (hold.brick,)), LetGo(begins + hold.for_, (hold.brick,)))


def _reach_for(name: BodyId, scene: ImpactScene) -> None:
    """Raise MissError if a brick is not there by then."""
    brick = next((brick for brick in scene.bricks if brick.name == name), None)
    if brick is not None:
        if not brick.is_there(scene.moment):
            raise missing(name, scene, "brick")
    elif (comes := scene.flying[name].since) > scene.moment:
        message = f"brick '{name}' comes at {comes.time:g} s, not before {scene.moment.time:g} s"
        raise MissError("brick", "SD204", message, "begin later")


def limit_speed(speed: float, scene: ImpactScene) -> None:
    """Raise MissError if a hand is faster than a brick gets that falls by the thickness of the thinnest of all.

    Up to there a brick that is pushed moves by a share of its thickness in a step of any system; what is faster hits.
    """
    sizes = [(brick.shape.thickness, brick.name) for brick in scene.bricks]
    sizes += [(flying.brick.shape.least_thickness, name) for name, flying in scene.flying.items()]
    thinnest, name = min(sizes)
    most = sqrt(2.0 * scene.gravity * thinnest)
    if speed > most:
        what = f"what is as thin as brick '{name}', {mm(thinnest)}"
        message = f"a hand that moves at {speed:g} m/s hits rather than pushes {what}"
        hint = f"write at most {rounded_down(MILLIMETRES * most)} mm/s; for more there are `push` and `throw`"
        raise MissError("speed", "SD104", message, hint)


# Pushes of bricks that are there, at points that are on them.


TURNED = 1e-12  # how much longer the rounding of a turn may make an impulse


@actions_of.register
def pushed(push: Push, scene: ImpactScene) -> tuple[PushAction, ...]:
    """The push, of a brick of the structure or of one that came flying before. Raises MissError."""
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
        message = f"brick '{name}' comes at {comes.time:g} s, not before {scene.moment.time:g} s"
        raise MissError("brick", "SD204", message, "push it later")


def _touch(point: Vec3, brick: StandingBrick) -> None:
    """Raise MissError if a point, from the centre of a brick, is not in it."""
    beyond = distance_outside(brick.shape, add(brick.centre, point))
    if beyond > OVERLAP:
        message = f"the point is {mm(beyond)} outside brick '{brick.name}'"
        raise MissError("point", "SD207", message, "write it from the centre of the brick, in the axes of the scene")


def limit_push(push: PushAction, scene: ImpactScene) -> None:
    """Raise MissError if a push gives a brick no speed, or more than a thrown one may have, whatever kind it is of."""
    brick = next((brick for brick in scene.bricks if brick.name == push.brick), None)
    mass = scene.flying[push.brick].brick.mass if brick is None else brick.mass
    speed, most = norm(push.impulse_W) / mass, float(SPEED.most)
    if 0.0 < speed <= most * (1.0 + TURNED):
        return
    message = f"the push gives brick '{push.brick}' {speed:.4g} m/s, and it must be more than 0, at most {most:g} m/s"
    hint = f"write more than 0, at most {rounded_down(1000.0 * mass * most)} mN*s"
    raise MissError("impulse", "SD104", message, hint)


# All impacts of a scenario: as actions of the timeline, and what keeps some of them from being as they are written.


@dataclass
class ImpactActions:
    """What all impacts come to."""

    actions: list[tuple[ActionOrder, Action]] = field(default_factory=list)
    mistakes: list[Diagnostic] = field(default_factory=list)


def done(built: Built, scenario: Scenario, source: Source) -> ImpactActions:
    """The actions of all impacts, impact by impact."""
    found = ImpactActions()
    if not scenario.impacts:
        return found
    scene = scene_of(built, scenario.world.gravity, tilt_of(scenario))
    known = {*(brick.name for brick in scene.bricks), *scene.flying}
    coming: list[Coming] = []
    for number, (impact, moment) in enumerate(zip(scenario.impacts, built.impacts, strict=True)):
        if any(named.name not in known for named in named_in(impact)):
            continue  # a brick that nobody builds is told elsewhere
        try:
            actions = _actions(impact.done, replace(scene, moment=moment, missile=built.missiles.get(number)))
        except MissError as miss:
            span = source.span_of(("impacts", number, impact.kind, miss.key))
            found.mistakes.append(Diagnostic(miss.code, span, miss.message, miss.hint))
        else:
            found.actions += [(moment._replace(time=action.time), action) for action in actions]
            coming += [Coming(number, moment, action) for action in actions if isinstance(action, Placement)]
    blocked = crossings(coming, _struck(built, scenario), scene.gravity)
    found.mistakes += [_blocked(crossing, scenario, source) for crossing in blocked]
    return found


def _actions(done: ImpactKind, scene: ImpactScene) -> tuple[Action, ...]:
    """What an impact comes to, within the limits that hold for every kind. Raises MissError."""
    actions = actions_of(done, scene)
    for action in actions:
        if isinstance(action, PushAction):
            limit_push(action, scene)
    return actions


def _struck(built: Built, scenario: Scenario) -> Mapping[BodyId, ActionOrder]:
    """When a brick is first pulled out or pushed."""
    found: dict[BodyId, ActionOrder] = {}
    for moment, impact in sorted(zip(built.impacts, scenario.impacts, strict=True), key=lambda timed: timed[0]):
        for name in impact.done.struck:
            found.setdefault(name, moment)
    return found


def _blocked(crossing: Crossing, scenario: Scenario, source: Source) -> Diagnostic:
    later, earlier = crossing.later, crossing.earlier
    here, there = (
        source.key_span_of(("impacts", one.number, scenario.impacts[one.number].kind)) for one in (later, earlier)
    )
    message = (
        f"brick '{later.placement.brick.id}' begins {mm(crossing.depth)} inside "
        f"brick '{earlier.placement.brick.id}', which is still on its way from {there.seen_from(here)}"
    )
    hint = f"let it come later, such as `after: impact {earlier.number + 1} + 0.5 s`, or from elsewhere"
    return Diagnostic("SD201", here, message, hint)


# Which bricks are pulled out when, and whether they are there by then.


@actions_of.register
def removed(remove: Remove, scene: ImpactScene) -> tuple[Removal, ...]:
    """All of them at once, in the author's order."""
    return (Removal(scene.moment.time, tuple(named.name for named in remove.pulled_out)),)


def missing_bricks(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are pulled out before they come, or again; those that never come are told elsewhere."""
    when = {brick.name: brick.placed for brick in built.bricks} if scenario.impacts else {}
    when |= {brick.id: built.impacts[number] for number, brick in built.missiles.items()}
    gone: dict[BodyId, KeyPath] = {}
    for number in sorted(range(len(built.impacts)), key=built.impacts.__getitem__):
        begins, impact = built.impacts[number], scenario.impacts[number]
        for named in impact.done.pulled_out:
            path, name = (("impacts", number, impact.kind, *named.path)), named.name
            if name in gone:
                there = source.span_of(gone[name])
                message = f"brick '{name}' is pulled out already, at {there.seen_from(source.span_of(path))}"
                yield Diagnostic("SD204", source.span_of(path), message, "leave out one of them")
            elif name in when and when[name] > begins:
                message = f"brick '{name}' is placed at {when[name].time:g} s, not before {begins.time:g} s"
                hint = f"pull it out later, such as `after: brick {name} + 1 s`"
                yield Diagnostic("SD204", source.span_of(path), message, hint)
            gone.setdefault(name, path)


# How a thrown brick flies: it leaves with the upward speed that brings it to the height of its aim as it arrives.
#
# So it hits what it is aimed at from however far away it comes. It does not turn on its way.


SPEED_ROUNDING = 1e-12  # of the speed, so that what is told to be allowed is


@actions_of.register
def thrown(throw: Throw, scene: ImpactScene) -> tuple[Placement, ...]:
    """The brick where it begins to fly. Raises MissError."""
    brick = scene.missile
    assert brick is not None  # the kind says that it has one
    towards = _direction_from(throw.from_.bearing)
    start = _start(brick, throw, towards, scene)
    ahead_W = rotate(scene.tilt, towards)
    _limit_height(throw, ahead_W, scene)
    # After a time t it is at start + v t + g t^2 / 2, which at the end shall be straight ahead by the distance.
    duration, gravity_W = throw.from_.distance / throw.speed, (0.0, 0.0, -scene.gravity)
    velocity_W = subtract(scale(throw.speed, ahead_W), scale(0.5 * duration, gravity_W))
    pose = turned_pose(start, scene.tilt)
    return (Placement(scene.moment.time, brick, 0, pose, Arrival.THROWN, velocity_W, duration),)


def _limit_height(throw: Throw, ahead_W: Vec3, scene: ImpactScene) -> None:
    """Raise MissError for a throw that rises or falls, as it leaves or arrives, faster than one may be thrown."""
    assert scene.missile is not None
    speed, distance, gravity = throw.speed, throw.from_.distance, scene.gravity
    climb, most = abs(ahead_W[2]), float(SPEED.most)
    fastest = climb * speed + 0.5 * gravity * (distance / speed)
    if fastest <= most * (1.0 + SPEED_ROUNDING):
        return
    # Slower than the lesser root of climb s^2 - most s + g d / 2 = 0, it is in the air for too long.
    under_root = most * most - 2.0 * climb * gravity * distance
    slowest = gravity * distance / (most + sqrt(under_root)) if under_root >= 0.0 else inf
    nearest = 2.0 * (most - climb * speed) * speed / gravity
    remedies = [f"throw it at {rounded_up(slowest)} m/s or faster"] if speed < slowest <= most else []
    remedies += [f"from {rounded_down(MILLIMETRES * nearest)} mm or nearer"] if nearest > 0.0 else []
    message = f"brick '{scene.missile.id}' would rise and fall at up to {fastest:.4g} m/s, and {most:g} m/s is the most"
    raise MissError("speed", "SD104", message, ", or ".join(remedies) or "throw it more slowly, or from nearer")


def _direction_from(bearing: float) -> Vec3:
    """Of the flight along the ground, rounded to where processors agree on it."""
    return (0.0 - round(cos(bearing), 15), 0.0 - round(sin(bearing), 15), 0.0)


def _start(brick: Brick, throw: Throw, towards: Vec3, scene: ImpactScene) -> Pose:
    """At the height of the aim, with its nose at the distance from what it meets first on the straight way there."""
    aim = middle_of(aimed_at(throw.at, scene, "at"))
    orientation = about_z(throw.from_.bearing + throw.turn)
    flying = in_place(brick.shape, Pose(aim, orientation))
    ways = [meeting(flying, other.shape, towards, OVERLAP) for other in on_the_way(flying, towards, scene)]
    nearest = min((way[0] for way in ways if way is not None), default=None)
    if nearest is None:
        hint = "aim at a brick, take another bearing, or `turn: 90 deg` to let it come broadside"
        raise MissError("at", "SD207", f"nothing is in the way of brick '{brick.id}'", hint)
    start = Pose(add_scaled(aim, nearest - throw.from_.distance, towards), orientation)
    keep_out_of_planes(brick, start, scene, "from")
    return start
