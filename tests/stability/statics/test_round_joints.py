"""Glued ends of round bodies: the strength of the whole disc, by closed forms."""

from math import pi, sqrt

import pytest

from stability.geometry.box import Box
from stability.geometry.round_patch import Disc, RoundPatch
from stability.geometry.round_solid import RoundSolid, cylinder, frustum
from stability.geometry.vectors import about, multiply, rotate
from stability.joints import Bond, JointRule, Joints
from stability.model import IDENTITY, Brick, Plane, Pose, Quaternion, Vec3
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly

RADIUS, HEIGHT, WEIGHT = 0.03, 0.1, 9.81
CAN = cylinder(RADIUS, HEIGHT)
STRONG = 1e9  # [Pa]
ALONG_X: Quaternion = about((0.0, 1.0, 0.0), 0.5 * pi)  # its axis


def glued(can: RoundSolid, at: Pose, bond: Bond, scene: Quaternion = IDENTITY, size: float = 1.0) -> Stability:
    """Judge a can of 1 kg that is glued to a fixed block, in a scene that is turned about the vertical and scaled."""
    block = Placed(Brick("block", Box((0.2 * size,) * 3), 1.0), Pose((0.0, 0.0, 0.0), scene))
    under = Plane("ground", (0.0, 0.0, -5.0 * size), (0.0, 0.0, 1.0), 0.9)
    rule = JointRule(bond, (frozenset({"can"}), frozenset({"block"})))
    assembly = Assembly(planes=[under], friction=0.5, joints=Joints((rule,)), tables=[block])
    return assembly.add_all(
        [Placed(Brick("can", can, 1.0), Pose(rotate(scene, at.position_W), multiply(scene, at.orientation)))]
    ).stability


@pytest.mark.parametrize(("share", "verdict"), [(0.999, Stability.UNSTABLE), (1.001, Stability.STABLE)])
@pytest.mark.parametrize(("yaw", "size"), [(0.0, 1.0), (0.7, 1.0), (0.0, 8.0)])
def test_a_can_on_a_wall_opens_about_its_lowest_point(
    share: float, verdict: Stability, yaw: float, size: float
) -> None:
    """Its weight at half of its height turns it; the tension f of the disc resists with f pi R^2 R."""
    needed = WEIGHT * 0.5 * HEIGHT * size / (pi * (RADIUS * size) ** 3)
    can = cylinder(RADIUS * size, HEIGHT * size)
    at = ((0.1 + 0.5 * HEIGHT) * size, 0.0, 0.0)
    assert glued(can, Pose(at, ALONG_X), Bond(share * needed, STRONG), about((0.0, 0.0, 1.0), yaw), size) is verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.999, Stability.UNSTABLE), (1.001, Stability.STABLE)])
def test_a_can_below_a_ceiling_hangs_on_the_tension_of_its_disc(share: float, verdict: Stability) -> None:
    bond = Bond(share * WEIGHT / (pi * RADIUS**2), STRONG)
    assert glued(CAN, Pose((0.0, 0.0, -0.1 - 0.5 * HEIGHT)), bond) is verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.999, Stability.UNSTABLE), (1.001, Stability.STABLE)])
def test_a_cone_below_a_ceiling_hangs_on_its_upper_end_alone(share: float, verdict: Stability) -> None:
    cone = frustum(RADIUS, 0.01, HEIGHT)
    bond = Bond(share * WEIGHT / (pi * 0.01**2), STRONG)
    top = 0.5 * HEIGHT - cone.centre_of_mass[2]
    assert glued(cone, Pose((0.0, 0.0, -0.1 - top)), bond) is verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.999, Stability.UNSTABLE), (1.001, Stability.STABLE)])
def test_a_can_over_the_edge_of_a_ceiling_hangs_on_the_part_of_its_disc_below(share: float, verdict: Stability) -> None:
    """A half of the disc is glued; its centroid is 4 R / 3 pi inside of the edge, over which the can would tip."""
    inside = 4.0 * RADIUS / (3.0 * pi)
    # It opens about the rim of the disc opposite to the edge, as contact presses there.
    needed = WEIGHT * RADIUS / (0.5 * pi * RADIUS**2 * (RADIUS - inside))
    assert glued(CAN, Pose((0.1, 0.0, -0.1 - 0.5 * HEIGHT)), Bond(share * needed, STRONG)) is verdict


def test_the_line_of_a_log_is_not_glued() -> None:
    at = Pose((0.0, 0.0, -0.1 - RADIUS), about((1.0, 0.0, 0.0), 0.5 * pi))
    assert glued(CAN, at, Bond(STRONG, STRONG)) is Stability.UNSTABLE


@pytest.mark.parametrize("sides", [16, 64])
def test_the_area_of_a_patch_is_that_between_its_arcs(sides: int) -> None:
    axes: tuple[Vec3, Vec3] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    disc = RoundPatch((0.0, 0.0, 0.0), axes, (Disc(0.0, 0.0, 2.0),)).with_sides(sides)
    lens = RoundPatch((0.0, 0.0, 0.0), axes, (Disc(0.0, 0.0, 1.0), Disc(1.0, 0.0, 1.0))).with_sides(sides)
    half = RoundPatch(
        (0.0, 0.0, 0.0), axes, (Disc(0.0, 0.0, 1.0),), ((0.0, -2.0), (2.0, -2.0), (2.0, 2.0), (0.0, 2.0))
    ).with_sides(sides)
    assert disc.area == pytest.approx(4.0 * pi)
    assert lens.area == pytest.approx(2.0 * pi / 3.0 - 0.5 * sqrt(3.0))
    assert half.area == pytest.approx(0.5 * pi)
