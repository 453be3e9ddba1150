"""A gap below a body closes as it comes down. One beside it does not: nothing holds a body across it."""

from math import cos, pi, sin, sqrt

import pytest

from stability.geometry.box import Box
from stability.geometry.solid_making import prism
from stability.model import GROUND, Brick, ConvexShape, Plane, Pose, Vec3
from stability.problem import Stability
from stability.statics.assembly import Assembly

FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
CARTON = (0.4, 0.3, 0.25)  # [m]
REACH = 0.02 * min(CARTON)


def turned(angle: float, x: float, y: float, z: float) -> Pose:
    """A place in a scene that is turned about the vertical [rad]."""
    c, s = cos(angle), sin(angle)
    return Pose((c * x - s * y, s * x + c * y, z), (0.0, 0.0, sin(0.5 * angle), cos(0.5 * angle)))


def carton(size: Vec3, as_a_hull: bool) -> ConvexShape:
    x, y, z = size
    if not as_a_hull:
        return Box(size)
    return prism([(-0.5 * x, -0.5 * z), (0.5 * x, -0.5 * z), (0.5 * x, 0.5 * z), (-0.5 * x, 0.5 * z)], y).shape


def between_two(gap: float, size: float, angle: float, as_a_hull: bool) -> Assembly:
    """Two columns of two cartons and one that hovers between, `gap` from either [m]; all `size` times as large."""
    x, y, z = (size * side for side in CARTON)
    shape = carton((x, y, z), as_a_hull)
    sides = [(side * (y + gap), level) for side in (-1.0, 1.0) for level in (0.5, 1.5)]
    places = [(f"column {k}", turned(angle, 0.0, off, level * z)) for k, (off, level) in enumerate(sides)]
    assembly = Assembly((FLOOR,), 0.5, 9.81)
    for name, pose in [*places, ("amid", turned(angle, 0.0, 0.0, 1.2 * z))]:
        assembly.add(Brick(name, shape, 1.0), pose)
    return assembly


@pytest.mark.parametrize("as_a_hull", [False, True])
@pytest.mark.parametrize("angle", [0.0, 0.3])
@pytest.mark.parametrize("size", [0.01, 1.0, 10.0])
def test_cartons_beside_one_hold_it_in_the_air_only_if_they_touch_it(
    size: float, angle: float, as_a_hull: bool
) -> None:
    for share, touches in [(0.0, True), (0.049, True), (0.051, False), (0.3, False), (0.99, False)]:
        assembly = between_two(share * REACH * size, size, angle, as_a_hull)
        assert bool(assembly.contacts("amid")) is touches
        if not touches:
            verdict = assembly.verdict()
            assert (verdict.stability, verdict.moving) == (Stability.UNSTABLE, ("amid",))


@pytest.mark.parametrize("gap", [0.3, 0.99])
def test_a_wall_holds_nothing_across_a_gap(gap: float) -> None:
    walls = [
        Plane(f"wall {side}", (0.0, side * (0.5 * CARTON[1] + gap * REACH), 0.0), (0.0, -side, 0.0), 2.0)
        for side in (-1.0, 1.0)
    ]
    assembly = Assembly((FLOOR, *walls), 0.5, 9.81)
    verdict = assembly.add(Brick("amid", Box(CARTON), 1.0), Pose((0.0, 0.0, 1.0)))
    assert (verdict.stability, verdict.moving) == (Stability.UNSTABLE, ("amid",))


@pytest.mark.parametrize(("down", "touches"), [(0.0, True), (0.99, True), (1.01, False)])
def test_what_lies_in_a_groove_touches_it_if_it_need_come_down_by_no_more_than_the_reach(
    down: float, touches: bool
) -> None:
    side, slope = 0.25, 1.0 / sqrt(2.0)
    groove = [Plane(f"side {sign}", (0.0, 0.0, 0.0), (-sign * slope, 0.0, slope), 0.5) for sign in (-1.0, 1.0)]
    assembly = Assembly(groove, 0.5, 9.81)
    lowest = Pose((0.0, 0.0, side * slope + down * 0.02 * side), (0.0, sin(pi / 8.0), 0.0, cos(pi / 8.0)))
    verdict = assembly.add(Brick("stone", Box((side, side, side)), 1.0), lowest)
    assert verdict.stability is (Stability.STABLE if touches else Stability.UNSTABLE)


@pytest.mark.parametrize("as_a_hull", [False, True])
@pytest.mark.parametrize("angle", [0.0, 0.3])
@pytest.mark.parametrize("size", [0.01, 1.0, 10.0])
def test_a_carton_beyond_the_end_of_its_support_is_not_held_by_what_stands_flush_beside_that(
    size: float, angle: float, as_a_hull: bool
) -> None:
    # Its centre is beyond the end, which two cartons of a layer share; its edge runs along the top edge of the second.
    x, y, z = (size * side for side in CARTON)
    shape = carton((x, y, z), as_a_hull)
    for beyond, stands in [(-0.001, True), (0.001, False), (0.025, False)]:
        assembly = Assembly((FLOOR,), 0.9, 9.81)
        for row in (0.0, 1.0):
            assembly.add(Brick(f"row {row}", shape, 1.0), turned(angle, 0.5 * x, row * y, 0.5 * z))
        verdict = assembly.add(Brick("upper", shape, 1.0), turned(angle, -beyond * x, 0.0, 1.5 * z))
        assert (verdict.stability is Stability.STABLE) is stands


@pytest.mark.parametrize(("further", "stands"), [(0.0, False), (0.2e-6, False), (1e-6, True)])
def test_a_beam_that_reaches_from_edge_to_edge_falls_between_its_posts(further: float, stands: bool) -> None:
    assembly = Assembly((FLOOR,), 0.5, 9.81)
    for name, at in (("left", -0.4 + further), ("right", 0.4 - further)):
        assembly.add(Brick(name, Box(CARTON), 1.0), Pose((at, 0.0, 0.125)))
    verdict = assembly.add(Brick("beam", Box(CARTON), 1.0), Pose((0.0, 0.0, 0.375)))
    assert (verdict.stability is Stability.STABLE) is stands
