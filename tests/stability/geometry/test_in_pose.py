"""Where shapes are in a pose, and how far apart, whatever they are."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.box import Box
from stability.geometry.box_distance import box_above_plane, boxes_apart
from stability.geometry.placed_shape import apart, apart_from_plane, bounds_W, corners_W, principal_turn, reach_W, top_W
from stability.geometry.vectors import add, body_axes, dot, multiply, norm, rotate, unit
from stability.model import IDENTITY, ConvexShape, Plane, Pose, Quaternion, Vec3
from tests.stability.geometry.polyhedra import LOWER_HALF, PLANK, SHAPES, SIZE, TETRAHEDRON, integrals

EVERY_SHAPE = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
QUARTER_ABOUT_Z: Quaternion = (0.0, 0.0, sqrt(0.5), sqrt(0.5))
places = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
turns = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: sum(p * p for p in q) > 1e-2)


def pose_of(position: Vec3, turn: Quaternion) -> Pose:
    x, y, z, w = (part / sqrt(sum(p * p for p in turn)) for part in turn)
    return Pose(position, (x, y, z, w))


def test_the_corners_of_a_turned_box_are_its_half_lengths_away() -> None:
    corners = corners_W(Box((2.0, 4.0, 6.0)), Pose((10.0, 0.0, 0.0), QUARTER_ABOUT_Z))
    assert {tuple(round(part, 9) for part in corner) for corner in corners} == {
        (10.0 + x, y, z) for x in (-2.0, 2.0) for y in (-1.0, 1.0) for z in (-3.0, 3.0)
    }


@EVERY_SHAPE
@given(places, turns)
def test_the_top_is_the_highest_corner(shape: ConvexShape, position: Vec3, turn: Quaternion) -> None:
    pose = pose_of(position, turn)
    assert top_W(shape, pose) == pytest.approx(max(z for _, _, z in corners_W(shape, pose)), abs=1e-12)


def test_the_top_of_a_wedge_is_higher_above_its_centre_than_its_foot_is_below() -> None:
    #   Two thirds of its thickness, and one third.
    assert top_W(LOWER_HALF, Pose((0.0, 0.0, 1.0))) == pytest.approx(1.0 + 2.0 / 3.0 * SIZE[2])
    assert bounds_W(LOWER_HALF, Pose((0.0, 0.0, 1.0)))[0][2] == pytest.approx(1.0 - SIZE[2] / 3.0)


@EVERY_SHAPE
@given(places, turns)
def test_the_upright_box_around_it_is_as_small_as_can_be(shape: ConvexShape, position: Vec3, turn: Quaternion) -> None:
    pose = pose_of(position, turn)
    low, high = bounds_W(shape, pose)
    for axis, way in enumerate(body_axes(IDENTITY)):
        back = (-way[0], -way[1], -way[2])
        assert high[axis] == pytest.approx(position[axis] + reach_W(shape, pose, way), abs=1e-12)
        assert low[axis] == pytest.approx(position[axis] - reach_W(shape, pose, back), abs=1e-12)


@EVERY_SHAPE
@given(places, turns, places, turns)
def test_a_scene_that_is_moved_as_a_whole_takes_corners_and_gaps_with_it(
    shape: ConvexShape, position: Vec3, turn: Quaternion, shift: Vec3, by: Quaternion
) -> None:
    pose, moved = pose_of(position, turn), pose_of(shift, by)
    after = Pose(add(shift, rotate(moved.orientation, position)), multiply(moved.orientation, pose.orientation))
    for before, now in zip(corners_W(shape, pose), corners_W(shape, after), strict=True):
        assert now == pytest.approx(add(shift, rotate(moved.orientation, before)), abs=1e-12)
    plane = Plane("", (0.1, 0.2, 0.3), (0.6, 0.0, 0.8), 0.5)
    point, normal = add(shift, rotate(moved.orientation, plane.point_W)), rotate(moved.orientation, plane.normal_W)
    gap = apart_from_plane(shape, after, Plane("", point, normal, 0.5)).gap
    assert gap == pytest.approx(apart_from_plane(shape, pose, plane).gap, abs=1e-12)


@EVERY_SHAPE
@given(turns)
def test_about_its_principal_axes_in_w_its_inertia_has_no_products(shape: ConvexShape, turn: Quaternion) -> None:
    pose = pose_of((0.0, 0.0, 0.0), turn)
    second = integrals(corners_W(shape, pose), shape.faces)[2]
    axes = np.array(body_axes(principal_turn(shape, pose.orientation)))
    about = np.trace(second) * np.eye(3) - axes @ second @ axes.T
    assert about == pytest.approx(np.diag(shape.moments(shape.volume)), abs=1e-9 * about.max())


@given(places, turns, places, turns)
def test_boxes_are_as_far_apart_as_by_their_sizes(one: Vec3, turn: Quaternion, other: Vec3, by: Quaternion) -> None:
    a, b, cube = pose_of(one, turn), pose_of(other, by), Box((0.3, 0.2, 0.1))
    assert apart(PLANK, a, cube, b) == boxes_apart(SIZE, a, cube.size, b)
    slope = Plane("", (0.0, 0.0, 0.1), unit((1.0, 2.0, 3.0)), 0.5)
    assert apart_from_plane(PLANK, a, slope).gap == pytest.approx(box_above_plane(SIZE, a, slope).gap, abs=1e-12)


def test_a_tetrahedron_on_its_corner_is_as_high_above_the_ground_as_that_corner() -> None:
    lowest = min(TETRAHEDRON.corners, key=lambda corner: corner[2])
    found = apart_from_plane(TETRAHEDRON, Pose((0.0, 0.0, 1.0)), Plane("", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    assert found.gap == pytest.approx(1.0 + lowest[2])
    assert found.normal_BA_W == (0.0, 0.0, 1.0)


def test_a_plank_above_a_wedge_is_as_far_from_it_as_from_its_highest_corner() -> None:
    between = apart(PLANK, Pose((0.0, 0.0, 1.0)), LOWER_HALF, Pose((0.0, 0.0, 0.0)))
    assert between.gap == pytest.approx(1.0 - 0.5 * SIZE[2] - LOWER_HALF.reach((0.0, 0.0, 1.0)))
    assert between.normal_BA_W == pytest.approx((0.0, 0.0, 1.0))


def test_a_turn_about_an_axis_leaves_the_reach_along_it() -> None:
    turned = Pose((0.0, 0.0, 0.0), (0.0, 0.0, sin(pi / 10.0), cos(pi / 10.0)))
    assert reach_W(TETRAHEDRON, turned, (0.0, 0.0, 1.0)) == pytest.approx(TETRAHEDRON.reach((0.0, 0.0, 1.0)))
    assert norm(TETRAHEDRON.support((0.0, 0.0, 1.0))) >= dot(TETRAHEDRON.support((0.0, 0.0, 1.0)), (0.0, 0.0, 1.0))
