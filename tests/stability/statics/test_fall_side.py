"""Which way what falls goes, held against closed forms."""

from dataclasses import replace
from math import atan2, cos, pi, radians, sin

import pytest

from stability.geometry.box import Box
from stability.geometry.vectors import scale
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Motion, Placed, Stability, Stage
from stability.statics.assembly import Assembly
from stability.statics.fall_description import FallSide, fall_side
from tests.planks import LENGTH, lying, plank


def side_of(assembly: Assembly) -> FallSide:
    assert assembly.verdict().stability is Stability.UNSTABLE
    return fall_side(assembly.verdict(), assembly.bricks)


def column(levels: int, step: tuple[float, float]) -> Assembly:
    assembly = Assembly()
    for level in range(levels):
        assembly.add(plank(f"L{level + 1}"), lying(level + 1, level * step[0], level * step[1]))
    return assembly


@pytest.mark.parametrize(("sign", "bearing"), [(1.0, 0.0), (-1.0, pi)])
def test_a_leaning_column_tips_to_the_side_that_it_leans_to_by_its_overhang(sign: float, bearing: float) -> None:
    #   Nine planks upon the first, 12 mm further each: their centre is 5 steps out, 60 mm, and the edge 58.8 mm.
    side = side_of(column(10, (sign * 0.012, 0.0)))
    assert abs(side.bearing or 0.0) == pytest.approx(bearing)
    assert side.overhang == pytest.approx(0.060 - LENGTH / 2.0)


def test_over_a_long_side_it_tips_across() -> None:
    #   One plank upon another, 15 mm aside: beyond the long edge at 11.7 mm.
    side = side_of(column(2, (0.0, 0.015)))
    assert side.bearing == pytest.approx(pi / 2.0)
    assert side.overhang == pytest.approx(0.0033)


@pytest.mark.parametrize("towards", [0.3, -2.0])
def test_the_fall_side_of_a_slide_is_downhill(towards: float) -> None:
    #   A block on a plane of 20 deg with friction 0.3 < tan 20 deg = 0.364.
    slope = radians(20.0)
    normal = (sin(slope) * cos(towards), sin(slope) * sin(towards), cos(slope))
    axis = (-sin(towards) * sin(slope / 2.0), cos(towards) * sin(slope / 2.0), 0.0)
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), normal, 0.3),), 0.3)
    block = Brick("block", Box((0.1, 0.1, 0.02)), 1.0)
    x, y, z = (0.01 * part for part in normal)
    assembly.add(block, Pose((x, y, z), (*axis, cos(slope / 2.0))))
    assert assembly.verdict().stage is Stage.CONES
    side = side_of(assembly)
    assert side.bearing == pytest.approx(atan2(sin(towards), cos(towards)), abs=1e-3)
    assert side.overhang is None


def test_a_free_fall_has_no_fall_side() -> None:
    assembly = Assembly()
    assembly.add_all([Placed(plank("a"), Pose((0.0, 0.0, 0.5)))])
    assert side_of(assembly) == FallSide()


def test_how_fast_a_motion_is_told_says_nothing_of_its_side() -> None:
    assembly = column(2, (0.07, 0.0))
    verdict = assembly.verdict()
    assert verdict.motion is not None
    faster = Motion({name: (scale(7.0, v), scale(7.0, w)) for name, (v, w) in verdict.motion.velocity.items()})
    assert fall_side(replace(verdict, motion=faster), assembly.bricks).overhang == pytest.approx(0.07 - LENGTH / 2.0)
