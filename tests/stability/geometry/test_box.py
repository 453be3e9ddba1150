"""The box against closed forms."""

from math import sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.box import Box, UnknownShapeError, as_box
from stability.geometry.vectors import norm, subtract
from stability.model import IDENTITY, Vec3
from tests.stability.geometry.polyhedra import TETRAHEDRON, polyhedron

BOX = Box((3.0, 4.0, 12.0))
sides = st.floats(0.01, 10.0)


def test_a_box_has_eight_corners_half_its_sides_away() -> None:
    assert set(BOX.corners) == {(x, y, z) for x in (-1.5, 1.5) for y in (-2.0, 2.0) for z in (-6.0, 6.0)}


def test_a_box_has_six_faces_and_twelve_edges_along_its_axes() -> None:
    assert {face.normal for face in BOX.faces} == {
        tuple(sign * float(axis == other) for other in range(3)) for axis in range(3) for sign in (-1.0, 1.0)
    }
    lengths = [norm(subtract(BOX.corners[i], BOX.corners[j])) for i, j in BOX.edges]
    assert sorted(lengths) == [3.0] * 4 + [4.0] * 4 + [12.0] * 4


def test_a_box_measures_its_sides() -> None:
    assert (BOX.least_thickness, BOX.length, BOX.volume) == (3.0, 12.0, 144.0)
    assert BOX.bounding_radius == 6.5  # half the diagonal: 3, 4, 12 and 13


def test_the_moments_of_a_box_are_a_twelfth_of_mass_times_squared_sides() -> None:
    assert BOX.moments(6.0) == pytest.approx((80.0, 76.5, 12.5))
    assert BOX.principal_axes == IDENTITY


def test_a_box_reaches_half_its_sides_along_its_axes_and_half_its_diagonal_along_that() -> None:
    assert [BOX.reach(axis) for axis in ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))] == [1.5, 2.0, 6.0]
    assert BOX.reach((3.0 / 13.0, -4.0 / 13.0, 12.0 / 13.0)) == pytest.approx(6.5)
    assert BOX.support((1.0, -1.0, -1.0)) == (1.5, -2.0, -6.0)


def test_of_corners_that_are_equally_far_the_one_on_the_positive_side_supports() -> None:
    assert BOX.support((0.0, -1.0, 0.0)) == (1.5, -2.0, 6.0)
    assert BOX.support((-1.0, 0.0, 0.0)) == (-1.5, 2.0, 6.0)


@given(sides, sides, sides)
def test_a_box_is_the_solid_with_its_corners(a: float, b: float, c: float) -> None:
    box, solid = Box((a, b, c)), polyhedron(Box((a, b, c)).corners)
    assert {face.normal for face in box.faces} == {tuple(round(p, 9) + 0.0 for p in f.normal) for f in solid.faces}
    assert set(box.edges) == set(solid.edges)
    assert box.volume == pytest.approx(solid.volume)
    assert sorted(box.moments(2.0)) == pytest.approx(solid.moments(2.0))
    assert box.least_thickness == pytest.approx(solid.least_thickness)


@given(sides, sides, sides, st.floats(0.1, 10.0))
def test_larger_boxes_have_all_in_proportion(a: float, b: float, c: float, times: float) -> None:
    small, large = Box((a, b, c)), Box((times * a, times * b, times * c))
    assert large.volume == pytest.approx(times**3 * small.volume)
    assert large.least_thickness == pytest.approx(times * small.least_thickness)
    assert large.bounding_radius == pytest.approx(times * small.bounding_radius)
    assert large.moments(1.0) == pytest.approx([times**2 * moment for moment in small.moments(1.0)])


@given(sides, sides, sides)
def test_sides_that_change_places_take_their_moments_with_them(a: float, b: float, c: float) -> None:
    x, y, z = Box((a, b, c)).moments(1.0)
    assert Box((b, c, a)).moments(1.0) == pytest.approx((y, z, x))


def test_a_cube_turns_alike_about_every_axis() -> None:
    assert Box((2.0, 2.0, 2.0)).moments(3.0) == pytest.approx((2.0, 2.0, 2.0))
    assert Box((2.0, 2.0, 2.0)).bounding_radius == pytest.approx(sqrt(3.0))


def test_unsupported_shapes_are_rejected_by_name() -> None:
    assert as_box(BOX, "the test") is BOX
    with pytest.raises(UnknownShapeError, match=r"^the test does not support the shape Polyhedron$"):
        as_box(TETRAHEDRON, "the test")


@pytest.mark.parametrize("size", [(1.0, 2.0, 3.0), (0.12, 0.024, 0.008)])
def test_boxes_of_one_size_are_one_shape(size: Vec3) -> None:
    assert Box(size) == Box(size)
    assert Box(size).corners is Box(size).corners  # worked out once
