"""Bricks that are let go above level ground, one by one, without a scenario."""

from collections.abc import Iterable
from math import sqrt

from stability.geometry.box import Box
from stability.model import AT_REST, GROUND, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.timeline import Action, Arrival, FixedWorld, Placement, Timeline

FRICTION, GRAVITY = 0.5, 9.81
LEVEL = FixedWorld(GRAVITY, FRICTION, (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION),))
DENSITY = 600.0  # [kg/m3]
PLANK, SHEET, CUBE = Box((0.1176, 0.0234, 0.0078)), Box((0.05, 0.05, 0.0002)), Box((0.1, 0.1, 0.1))
FLAT: Quaternion = (0.0, 0.0, 0.0, 1.0)
TIPPING: Quaternion = (0.0, 0.01, 0.0, sqrt(1.0 - 0.01**2))
ASKEW: Quaternion = (0.36, -0.22, 0.48, sqrt(1.0 - 0.36**2 - 0.22**2 - 0.48**2))


def let_go(  # noqa: PLR0913, PLR0917 -- all that a brick in the air is made of
    name: str,
    at_W: Vec3,
    shape: Box = PLANK,
    turned: Quaternion = ASKEW,
    velocity_W: Vec3 = AT_REST,
    time: float = 0.0,
    flight: float = 0.0,
    arrival: Arrival = Arrival.LET_GO,
) -> Placement:
    """A brick with its centre there [m], and a velocity [m/s]."""
    x, y, z = shape.size
    brick = Brick(name, shape, DENSITY * x * y * z)
    return Placement(time, brick, 1, Pose(at_W, turned), arrival, velocity_W, flight)


def set_down(name: str, at_W: Vec3, shape: Box = PLANK, time: float = 0.0) -> Placement:
    """A level brick that is put there at rest [m]."""
    return let_go(name, at_W, shape, FLAT, time=time, arrival=Arrival.SET_DOWN)


def over(actions: Iterable[Action], hold: float = 0.5) -> Timeline:
    """What happens then, watched for some time after the last [s]."""
    return Timeline(LEVEL, tuple(sorted(actions, key=lambda action: action.time)), hold, followed=0.3)
