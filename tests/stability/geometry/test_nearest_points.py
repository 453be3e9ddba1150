"""The points of two convex bodies that are nearest to each other."""

from collections.abc import Sequence
from itertools import product
from math import cos, hypot, radians, sin

import pytest

from stability.geometry.box_distance import Support, nearest_points
from stability.geometry.vectors import dot, norm, subtract
from stability.model import Vec3


def spanned(corners: Sequence[Vec3]) -> Support:
    return lambda along_W: max(corners, key=lambda corner: dot(corner, along_W))


def box(size: Vec3, middle: Vec3 = (0.0, 0.0, 0.0)) -> Support:
    ends = [(m - s / 2.0, m + s / 2.0) for m, s in zip(middle, size, strict=True)]
    return spanned([(x, y, z) for x, y, z in product(*ends)])


def way(a: Support, b: Support) -> Vec3 | None:
    nearest = nearest_points(a, b, (0.3, 0.2, 0.1))
    return None if nearest is None else subtract(*nearest)


PLANK = (0.12, 0.024, 0.008)


@pytest.mark.parametrize("gap", [1e-6, 1e-4, 0.01, 3.0])
def test_from_face_to_face_it_is_as_far_as_the_gap_is_wide(gap: float) -> None:
    beside = box(PLANK, (0.03, 0.01, PLANK[2] + gap))
    assert way(beside, box(PLANK)) == pytest.approx((0.0, 0.0, gap), abs=1e-12)


def test_from_corner_to_corner_it_is_the_diagonal() -> None:
    assert way(box(PLANK, (0.123, 0.028, 0.020)), box(PLANK)) == pytest.approx((0.003, 0.004, 0.012))


@pytest.mark.parametrize("crossing", [90.0, 20.0, 3.0, 0.1, 0.001])
def test_edges_that_cross_are_as_far_apart_as_the_planes_through_them(crossing: float) -> None:
    #   Going to and fro between them, at 3 deg, the way gets shorter by three thousandths a time.
    angle, gap = radians(crossing), 0.0002
    along = (cos(angle), sin(angle), 0.0)
    lower = spanned([(-0.05, 0.0, 0.0), (0.06, 0.0, 0.0)])
    upper = spanned([(-0.06 * along[0], -0.06 * along[1], gap), (0.05 * along[0], 0.05 * along[1], gap)])
    assert way(upper, lower) == pytest.approx((0.0, 0.0, gap), abs=1e-9)


def test_an_edge_over_a_slope_is_nearest_with_its_lower_end() -> None:
    slope = radians(0.5)
    edge = spanned([(0.0, 0.0, 0.001), (0.1 * cos(slope), 0.0, 0.001 + 0.1 * sin(slope))])
    on_edge, on_face = nearest_points(edge, box((1.0, 1.0, 0.2), (0.0, 0.0, -0.1)), (0.0, 0.0, 1.0)) or ((), ())
    assert on_edge == pytest.approx((0.0, 0.0, 0.001), abs=1e-12)
    assert on_face == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_a_tetrahedron_is_nearest_to_a_point_with_the_face_towards_it() -> None:
    corners: list[Vec3] = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)]
    found = way(spanned([(1.0, 1.0, 1.0)]), spanned(corners))
    assert found is not None
    assert norm(found) == pytest.approx(2.0 / hypot(1.0, 1.0, 1.0))


@pytest.mark.parametrize("deep", [0.0, 1e-9, 1e-4, 0.008])
def test_overlapping_or_touching_shapes_have_no_nearest_points(deep: float) -> None:
    assert way(box(PLANK, (0.03, 0.01, PLANK[2] - deep)), box(PLANK)) is None
