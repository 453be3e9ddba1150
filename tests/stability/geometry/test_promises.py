"""Protocol of convex shapes, tested with the box and with shapes of the tests."""

from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.vectors import cross, dot, norm, scale, subtract
from stability.model import ConvexShape, Vec3
from tests.stability.geometry.polyhedra import SHAPES, around, integrals

MASS = 0.012  # [kg]
EVERY_SHAPE = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
directions = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda way: norm(way) > 1e-3)


@EVERY_SHAPE
def test_faces_look_outwards_and_all_corners_lie_behind_them(shape: ConvexShape) -> None:
    for face in shape.faces:
        assert norm(face.normal) == pytest.approx(1.0, abs=1e-12)
        reach = shape.reach(face.normal)
        heights = [dot(corner, face.normal) for corner in shape.corners]
        assert reach > 0.0
        assert max(heights) == pytest.approx(reach, abs=1e-15)
        assert [n for n, height in enumerate(heights) if height > reach - 1e-12] == sorted(face.corners)


@EVERY_SHAPE
def test_faces_run_counter_clockwise_seen_from_outside(shape: ConvexShape) -> None:
    for face in shape.faces:
        a, b, c = (shape.corners[number] for number in face.corners[:3])
        across = cross(subtract(b, a), subtract(c, b))
        assert dot(across, face.normal) == pytest.approx(norm(across))


@EVERY_SHAPE
def test_corners_and_faces_are_two_more_than_edges(shape: ConvexShape) -> None:
    assert len(shape.corners) - len(shape.edges) + len(shape.faces) == 2  # Euler


@EVERY_SHAPE
def test_each_edge_lies_between_two_faces_that_run_along_it_in_opposite_ways(shape: ConvexShape) -> None:
    run = [pair for face in shape.faces for pair in around(face)]
    assert sorted(run) == sorted([*shape.edges, *((b, a) for a, b in shape.edges)])


@EVERY_SHAPE
def test_the_volume_is_that_which_the_surface_encloses(shape: ConvexShape) -> None:
    assert integrals(shape.corners, shape.faces)[0] == pytest.approx(shape.volume, rel=1e-12)


@EVERY_SHAPE
def test_the_centre_of_mass_is_the_origin(shape: ConvexShape) -> None:
    assert integrals(shape.corners, shape.faces)[1] == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)


def test_the_centre_of_mass_need_not_be_the_middle_of_the_box_around() -> None:
    wedge = SHAPES["wedge"]
    middle = [0.5 * (min(along) + max(along)) for along in zip(*wedge.corners, strict=True)]
    assert middle == pytest.approx((0.02, 0.0, 0.004 / 3.0))  # its centre is a third of the way from its thick end


@EVERY_SHAPE
def test_moments_about_principal_axes_are_the_inertia_that_the_surface_encloses(shape: ConvexShape) -> None:
    second = integrals(shape.corners, shape.faces)[2]
    enclosed = MASS / shape.volume * (np.trace(second) * np.eye(3) - second)
    axes = rotation_matrix(shape)
    assert axes @ np.diag(shape.moments(MASS)) @ axes.T == pytest.approx(enclosed, rel=1e-9, abs=1e-9 * enclosed.max())


@EVERY_SHAPE
@given(directions)
def test_the_support_is_a_corner_as_far_as_any(shape: ConvexShape, direction: Vec3) -> None:
    farthest = shape.support(direction)
    assert farthest in shape.corners
    assert dot(farthest, direction) == pytest.approx(max(dot(corner, direction) for corner in shape.corners), abs=1e-15)
    assert shape.reach(direction) == pytest.approx(dot(farthest, direction), abs=1e-15)


@EVERY_SHAPE
@given(directions, st.floats(0.1, 10.0))
def test_the_reach_grows_with_the_length_of_the_direction(shape: ConvexShape, way: Vec3, longer: float) -> None:
    assert shape.reach(scale(longer, way)) == pytest.approx(longer * shape.reach(way), abs=1e-15)


@EVERY_SHAPE
@given(directions)
def test_it_is_nowhere_thinner_than_its_least_thickness(shape: ConvexShape, direction: Vec3) -> None:
    way = scale(1.0 / norm(direction), direction)
    assert shape.reach(way) + shape.reach(scale(-1.0, way)) >= shape.least_thickness - 1e-15


@EVERY_SHAPE
def test_length_and_radius_bound_it(shape: ConvexShape) -> None:
    assert shape.bounding_radius == pytest.approx(max(map(norm, shape.corners)))
    assert shape.least_thickness <= shape.length <= 2.0 * shape.bounding_radius


@EVERY_SHAPE
def test_equal_shapes_are_equal_and_can_be_keys(shape: ConvexShape) -> None:
    assert {shape: 1}[shape] == 1


def test_a_tetrahedron_is_as_thick_as_between_a_face_and_a_corner_or_two_edges() -> None:
    #   Corners 0, x, y, z of a cube: between the slanted face and the corner it is thinner than along the axes.
    assert SHAPES["tetrahedron"].least_thickness < 0.03


def rotation_matrix(shape: ConvexShape) -> "np.ndarray[tuple[int, int], np.dtype[np.float64]]":
    x, y, z, w = shape.principal_axes
    assert sqrt(x * x + y * y + z * z + w * w) == pytest.approx(1.0, abs=1e-12)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
