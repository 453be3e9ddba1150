"""Contacts of edges and corners from poses and sizes alone. L, W and T are the sides of a plank."""

from math import asin, cos, pi, radians, sin, sqrt

import pytest

from stability.contacts.detection import contact_with_plane
from stability.geometry.vectors import multiply, rotate
from stability.model import IDENTITY, Plane, Vec3
from tests.stability.contacts.touching import (
    CUBE,
    GROUND,
    TOLERANCES,
    UP,
    L,
    T,
    W,
    about,
    brick,
    contact,
    elevations,
    ladder,
    leaning_pair,
    pitched,
    plank,
    same_points,
    touch,
    yawed,
)

ON_EDGE = pi / 4.0


def test_a_ladder_stands_on_one_edge_and_leans_on_another() -> None:
    theta = radians(63.0)
    leaning = ladder(theta)
    on_floor = contact_with_plane(leaning, GROUND, TOLERANCES)
    assert on_floor is not None
    assert (on_floor.lower, on_floor.upper) == ("ground", "ladder")
    assert same_points(on_floor.points_W, [(0.0, -W / 2, 0.0), (0.0, W / 2, 0.0)], 1e-16)
    wall = Plane("wall", (L * cos(theta), 0.0, 0.0), (-1.0, 0.0, 0.0), 0.0)
    on_wall = contact_with_plane(leaning, wall, TOLERANCES)
    assert on_wall is not None
    assert on_wall.normals_W == ((-1.0, 0.0, 0.0),)
    top = (L * cos(theta), L * sin(theta))
    assert same_points(on_wall.points_W, [(top[0], -W / 2, top[1]), (top[0], W / 2, top[1])], 1e-16)


def test_a_ladder_on_bricks_touches_them_as_it_touches_planes() -> None:
    theta = radians(50.0)
    leaning = ladder(theta)
    floor = brick("floor", (1.0, 0.01, 0.1), (0.0, 0.0, -0.05))
    found = contact(leaning, floor)
    assert found.lower == "floor"
    assert same_points(found.points_W, [(0.0, -0.005, 0.0), (0.0, 0.005, 0.0)], 1e-15)
    wall = brick("wall", (0.2, 1.0, 1.0), (L * cos(theta) + 0.1, 0.0, 0.5))
    on_wall = contact(leaning, wall)
    assert on_wall.normals_W[0] == pytest.approx((1.0, 0.0, 0.0), abs=1e-15)
    assert same_points(on_wall.points_W, [(L * cos(theta), y, L * sin(theta)) for y in (-W / 2, W / 2)], 1e-15)


@pytest.mark.parametrize("theta", [20.0, 45.0, 60.0, 75.0])
def test_leaning_planks_admit_every_normal_of_both_edges(theta: float) -> None:
    # Face and end of one plank are the bounds for one, those of the other for the other: least of theta and 90 - theta.
    found = contact(*leaning_pair(radians(theta)))
    assert same_points(found.points_W, [(0.0, -W / 2, 0.0), (0.0, W / 2, 0.0)], 1e-15)
    widest = min(theta, 90.0 - theta)
    assert elevations(found) == pytest.approx([-widest, widest])
    assert all(normal[0] > 0.0 for normal in found.normals_W)
    assert (found.lower, found.upper) == ("a", "b")


def test_crossing_edges_touch_in_a_point_with_the_normal_across_both() -> None:
    # Two cubes on edge, crosswise.
    lower = brick("a", CUBE, (0.0, 0.0, 0.0), pitched(ON_EDGE))
    upper = brick("b", CUBE, (0.3, 0.2, sqrt(2.0)), about((1.0, 0.0, 0.0), ON_EDGE))
    found = contact(lower, upper)
    assert found.normals_W[0] == pytest.approx(UP, abs=1e-15)
    assert same_points(found.points_W, [(0.0, 0.2, sqrt(0.5))], 1e-15)


def test_an_upright_corner_touches_a_face_in_a_point() -> None:
    # A cube that stands on a corner is as high as its diagonal.
    standing = multiply(about((sqrt(0.5), -sqrt(0.5), 0.0), -asin(sqrt(2 / 3))), IDENTITY)
    height = max(-corner[2] for corner in brick("b", CUBE, (0.0, 0.0, 0.0), standing).corners_W)
    assert height == pytest.approx(sqrt(3.0) / 2.0)
    found = contact(brick("a", (4.0, 4.0, 1.0), (0.0, 0.0, 0.0)), brick("b", CUBE, (0.4, 0.3, 0.5 + height), standing))
    assert found.normals_W == (UP,)
    assert same_points(found.points_W, [(0.4, 0.3, 0.5)], 1e-15)


@pytest.mark.parametrize("off", [(1.0, 0.25, 1.0), (1.0, 1.0, 1.0), (1.0, 1.0, 0.25)])
@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_edges_and_corners_that_run_flush_carry_nothing(off: Vec3, tilt: float) -> None:
    # Stairs that touch along an edge, corners that meet, columns across from each other: each can move past the other.
    turn = pitched(radians(tilt))
    lower = brick("a", CUBE, (0.0, 0.0, 0.0), turn)
    assert touch(lower, brick("b", CUBE, rotate(turn, off), turn)) is None


def test_a_brick_that_just_misses_an_edge_does_not_rest_on_it() -> None:
    # Nor on one that it is above by rounding.
    for miss in (-0.9e-6, 0.0, 1e-6, 1e-3, 0.015):
        assert touch(brick("a", CUBE, (0.0, 0.0, 0.0)), brick("b", CUBE, (1.0 + miss, 0.0, 1.0))) is None
    assert contact(brick("a", CUBE, (0.0, 0.0, 0.0)), brick("b", CUBE, (1.0 - 1.1e-6, 0.0, 1.0))).normals_W == (UP,)


def test_a_corner_on_the_edge_of_another_carries_nothing_and_one_further_in_does() -> None:
    # A cube turned by 45 deg: its upright edge is above the edge of another, where it can slide down past its side.
    for further, carries in ((0.0, False), (0.9e-6, False), (1.1e-6, True)):
        turned = brick("b", CUBE, (0.5 + sqrt(0.5) - further, 0.1, 1.0), yawed(pi / 4.0))
        assert (touch(brick("a", CUBE, (0.0, 0.0, 0.0)), turned) is not None) is carries


def test_a_plank_across_the_edge_of_another_touches_it_at_that_edge() -> None:
    # Tilted by 10 deg about the far edge of the lower brick, with its own under side on that edge.
    tilt = pitched(-radians(10.0))
    x, _, z = rotate(tilt, (0.02, 0.0, T / 2))
    found = contact(brick("a", CUBE, (-0.5, 0.0, -0.5)), plank("b", (x, 0.0, z), tilt))
    assert same_points(found.points_W, [(0.0, -W / 2, 0.0), (0.0, W / 2, 0.0)], 1e-15)
    assert found.normals_W[0] == pytest.approx(rotate(tilt, UP), abs=1e-15)
