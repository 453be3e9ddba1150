"""The published method freezes round bricks that stand on a flat end, and leaves to the engine what can roll."""

from collections.abc import Set
from contextlib import closing
from math import cos, pi, sin

import pytest

from stability.engines.lazy_world import stepped_world
from stability.geometry.box import Box
from stability.geometry.round_solid import capsule, cylinder, frustum, pipe, sphere
from stability.geometry.vectors import about, add, multiply, rotate
from stability.model import GROUND, IDENTITY, BodyId, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3
from stability.stabilizers.published.stabilizer import StackStability
from stackdsl.simulation.systems import SYSTEMS

GRAVITY, FRICTION, DURATION = 9.81, 0.5, 0.02
R = 0.05
CAN, LOG, BALL = cylinder(R, 0.12), cylinder(R, 0.4), sphere(R)
BLOCK, PLANK = Box((0.1, 0.4, 0.08)), Box((0.3, 0.1, 0.02))
LYING: Quaternion = about((1.0, 0.0, 0.0), 0.5 * pi)
Part = tuple[ConvexShape, Vec3, Quaternion]


def frozen(parts: dict[BodyId, Part], turn: Quaternion = IDENTITY, shift: Vec3 = (0.0, 0.0, 0.0)) -> Set[BodyId]:
    """Return the bricks that the method has frozen after some steps, in a scene that is turned and shifted."""
    with closing(stepped_world(SYSTEMS["thesis"].engine, GRAVITY, FRICTION, 1.0)) as world:
        plane = Plane(GROUND, (0.0, 0.0, shift[2]), (0.0, 0.0, 1.0), FRICTION)
        world.add_plane(plane)
        for name, (shape, at, own) in parts.items():
            world.add_brick(Brick(name, shape, 1.0), Pose(add(rotate(turn, at), shift), multiply(turn, own)))
        method = StackStability(world, guard=False, friction=FRICTION, planes=[plane], gravity=GRAVITY)
        method.set_down(parts)
        seen: set[BodyId] = set()
        while world.time() < DURATION:
            method.update()
            seen |= {name for name in parts if method.is_frozen(name)}
            world.step()
        return seen


def upright(shape: ConvexShape, x: float = 0.0, y: float = 0.0, on: float = 0.0) -> Part:
    return shape, (x, y, on + shape.reach((0.0, 0.0, -1.0))), IDENTITY


def lying(x: float, z: float = R) -> Part:
    return LOG, (x, 0.0, z), LYING


@pytest.mark.parametrize("shape", [CAN, frustum(0.05, 0.02, 0.1), frustum(0.02, 0.05, 0.1), pipe(0.05, 0.01, 0.1)])
def test_a_round_brick_on_its_flat_end_freezes(shape: ConvexShape) -> None:
    assert frozen({"it": upright(shape)}) == {"it"}


@pytest.mark.parametrize("way", [0.3, 2.0])
@pytest.mark.parametrize(("share", "stands"), [(0.998, True), (1.002, False)])
def test_a_can_stands_on_a_can_until_its_centre_is_beyond_the_rim_below(share: float, stands: bool, way: float) -> None:
    across = (share * R * cos(way), share * R * sin(way))
    parts = {"low": upright(CAN), "up": upright(CAN, *across, on=0.12)}
    assert ("up" in frozen(parts)) is stands


def test_a_pyramid_of_cans_freezes() -> None:
    places = [(row, place) for row in range(3) for place in range(3 - row)]
    parts = {f"{row}{place}": upright(CAN, 2.02 * R * (place + 0.5 * row), 0.0, 0.12 * row) for row, place in places}
    assert frozen(parts) == parts.keys()


ROLLS: dict[str, dict[BodyId, Part]] = {
    "ball": {"ball": (BALL, (0.0, 0.0, R), IDENTITY)},
    "log": {"log": lying(0.0)},
    "capsule": {"capsule": (capsule(R, 0.1), (0.0, 0.0, R), LYING)},
    "standing capsule": {"capsule": (capsule(R, 0.1), (0.0, 0.0, 0.1), IDENTITY)},
    "log between blocks": {
        "log": lying(0.0),
        "left": (BLOCK, (-R - 0.05, 0.0, 0.04), IDENTITY),
        "right": (BLOCK, (R + 0.05, 0.0, 0.04), IDENTITY),
    },
    "plank on two logs": {"log a": lying(-0.1), "log b": lying(0.1), "plank": (PLANK, (0.0, 0.0, 0.11), IDENTITY)},
    "plank on two balls": {
        "ball a": (BALL, (-0.1, 0.0, R), IDENTITY),
        "ball b": (BALL, (0.1, 0.0, R), IDENTITY),
        "plank": (PLANK, (0.0, 0.0, 0.11), IDENTITY),
    },
    "can on a log": {"log": lying(0.0), "can": upright(CAN, on=2.0 * R)},
}


@pytest.mark.parametrize("name", ROLLS)
@pytest.mark.parametrize(("yaw", "shift"), [(0.0, (0.0, 0.0, 0.0)), (0.7, (0.3, -0.2, 0.5))])
def test_no_brick_that_can_roll_freezes_and_none_on_it(name: str, yaw: float, shift: Vec3) -> None:
    still = {body for body in ROLLS[name] if body in {"left", "right"}}
    assert frozen(ROLLS[name], about((0.0, 0.0, 1.0), yaw), shift) == still


def test_a_plank_that_leans_on_a_log_stays_with_the_engine() -> None:
    angle = 0.6
    turn = about((0.0, 1.0, 0.0), -angle)
    # Its lower end is on the ground, and its lower face touches the log: the ground and the face are tangents.
    touch = R / (sin(angle) / (1.0 + cos(angle)))  # from the end to the points of contact
    log = (LOG, (touch, 0.0, R), LYING)
    middle = (0.15 * cos(angle) - 0.01 * sin(angle), 0.0, 0.15 * sin(angle) + 0.01 * cos(angle))
    assert frozen({"log": log, "plank": (PLANK, middle, turn)}) == set()


def test_a_plank_on_two_cans_freezes_with_them() -> None:
    parts = {
        "can a": upright(CAN, -0.1),
        "can b": upright(CAN, 0.1),
        "plank": (PLANK, (0.0, 0.0, 0.13), IDENTITY),
    }
    assert frozen(parts) == parts.keys()
