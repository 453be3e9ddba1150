"""Ground, walls and tilt: the fixed bodies, and the turn from the frame of the scene to W."""

from collections.abc import Iterator
from dataclasses import replace
from math import cos, sin

from stability.geometry.rotations import multiply, rotate
from stability.model import GROUND, IDENTITY, Plane, Pose, Quaternion, Vec3
from stackdsl.language.schema import Scenario

Z_AXIS: Vec3 = (0.0, 0.0, 1.0)


def planes_of(scenario: Scenario) -> Iterator[Plane]:
    """Ground and walls in the frame of the scene."""
    ground = scenario.world.ground.friction
    yield Plane(GROUND, (0.0, 0.0, 0.0), Z_AXIS, scenario.friction if ground is None else ground)
    for number, wall in enumerate(scenario.world.walls, start=1):
        x, y = cos(wall.bearing), sin(wall.bearing)
        friction = scenario.friction if wall.friction is None else wall.friction
        yield Plane(f"wall{number}", (x * wall.distance, y * wall.distance, 0.0), (-x, -y, 0.0), friction)


def tilt_of(scenario: Scenario) -> Quaternion:
    """From the frame of the scene to W: the ground's normal leans towards downhill."""
    angle, towards = scenario.world.tilt.angle, scenario.world.tilt.towards
    if angle == 0.0:
        return IDENTITY
    half = angle / 2.0
    return (-sin(towards) * sin(half), cos(towards) * sin(half), 0.0, cos(half))


def turned_plane(plane: Plane, tilt: Quaternion) -> Plane:
    """A plane of the scene in W."""
    if tilt == IDENTITY:
        return plane
    return replace(plane, point_W=rotate(tilt, plane.point_W), normal_W=rotate(tilt, plane.normal_W))


def turned_pose(pose: Pose, tilt: Quaternion) -> Pose:
    """A pose of the scene in W; to the bit the same if there is no tilt."""
    if tilt == IDENTITY:
        return pose
    return Pose(rotate(tilt, pose.position_W), multiply(tilt, pose.orientation))
