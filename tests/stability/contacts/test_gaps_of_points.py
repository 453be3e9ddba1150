"""A gap counts as contact at each point of a face separately."""

from math import asin, cos, pi, sin

import pytest

from stability.geometry.box import Box
from stability.geometry.solid_making import prism
from stability.geometry.vectors import body_axes
from stability.model import GROUND, Brick, Plane, Pose, Quaternion, Vec3
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly

SLOPE = 10.0 * pi / 180.0
LENGTH, WIDTH, THICKNESS = 0.4, 0.2, 0.1  # [m]
WALL = 0.3  # thickness of the fixed box that is a wall [m]
AT_A_CORNER = 1e-9  # [m] by which the nearest corner is from the wall
BESIDE = 1e-3 * THICKNESS  # the widest gap that counts beside this box [m]


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    (ax, ay, az, aw), (bx, by, bz, bw) = a, b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


TILT: Quaternion = (0.0, sin(0.5 * SLOPE), 0.0, cos(0.5 * SLOPE))  # x of the slope points downhill


def on_slope(x: float, y: float, z: float) -> Vec3:
    (ax, bx, cx), (ay, by, cy), (az, bz, cz) = body_axes(TILT)
    return (x * ax + y * ay + z * az, x * bx + y * by + z * bz, x * cx + y * cy + z * cz)


def box_at_wall(far: float, wall: str, *, as_prism: bool = False) -> Assembly:
    """A smooth box on a smooth slope: one lower corner touches a wall square to the slope, the other is `far` away."""
    yaw = asin(far / WIDTH)
    reach = 0.5 * (LENGTH * cos(yaw) + WIDTH * sin(yaw)) + AT_A_CORNER
    ground = Plane(GROUND, (0.0, 0.0, 0.0), on_slope(0.0, 0.0, 1.0), 0.0)
    planes, tables = [ground], []
    if wall == "plane":
        planes.append(Plane("wall", on_slope(reach, 0.0, 0.0), on_slope(-1.0, 0.0, 0.0), 0.0))
    else:
        block = Brick("wall", Box((WALL, 1.0, 0.4)), 1.0)
        tables.append(Placed(block, Pose(on_slope(reach + 0.5 * WALL, 0.0, 0.2), TILT)))
    made = Assembly(planes, 0.0, tables=tables)
    half, high = 0.5 * LENGTH, 0.5 * THICKNESS
    outline = [(-half, -high), (half, -high), (half, high), (-half, high)]
    shape = prism(outline, WIDTH).shape if as_prism else Box((LENGTH, WIDTH, THICKNESS))
    turn = product(TILT, (0.0, 0.0, sin(0.5 * yaw), cos(0.5 * yaw)))
    made.add(Brick("box", shape, 5.0), Pose(on_slope(0.0, 0.0, high), turn))
    return made


@pytest.mark.parametrize("wall", ["plane", "box"])
@pytest.mark.parametrize("as_prism", [False, True])
@pytest.mark.parametrize("far", [0.4e-3, 1.0e-3, 1.9e-3])
def test_a_box_that_meets_a_wall_with_one_corner_turns(far: float, as_prism: bool, wall: str) -> None:
    # The wall presses beside the centre of mass, at half the width; nothing else has a moment about the slope's normal.
    assert box_at_wall(far, wall, as_prism=as_prism).verdict().stability is Stability.UNSTABLE


@pytest.mark.parametrize("wall", ["plane", "box"])
@pytest.mark.parametrize("as_prism", [False, True])
def test_a_box_whose_far_corner_is_within_a_thousandth_of_its_thickness_lies_on_the_wall(
    as_prism: bool, wall: str
) -> None:
    assert box_at_wall(0.9 * BESIDE, wall, as_prism=as_prism).verdict().stability is Stability.STABLE
