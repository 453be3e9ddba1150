"""Contacts of faces from poses and sizes alone, on bricks and on planes. L, W and T are the sides of a plank."""

from collections.abc import Sequence
from math import cos, pi, radians, sin, sqrt

import pytest

from stability.contacts.detection import contact_with_plane
from stability.geometry.vectors import rotate
from stability.model import Plane, Quaternion, Vec3
from tests.stability.contacts.touching import (
    CUBE,
    PLANK,
    TOLERANCES,
    UP,
    L,
    T,
    W,
    about,
    brick,
    contact,
    pitched,
    plank,
    same_points,
    yawed,
)


def area(points: Sequence[Vec3]) -> float:
    """Of a level polygon, positive if it runs counter-clockwise seen from above [m2]."""
    pairs = zip(points, [*points[1:], points[0]], strict=True)
    return 0.5 * sum(a[0] * b[1] - a[1] * b[0] for a, b in pairs)


# --- face on face ---------------------------------------------------------------------------------------------------


def test_crossed_planks_share_a_square_of_their_width() -> None:
    found = contact(plank("a", (0.0, 0.0, 0.0)), plank("b", (0.0, 0.0, T), yawed(pi / 2.0)))
    assert (found.lower, found.upper, found.law.friction) == ("a", "b", 0.5)
    assert found.normals_W == (UP,)
    h = W / 2.0
    assert same_points(found.points_W, [(-h, -h, T / 2), (h, -h, T / 2), (h, h, T / 2), (-h, h, T / 2)], 1e-16)
    assert area(found.points_W) == pytest.approx(W * W)


def test_a_shifted_plank_rests_on_the_remaining_overlap() -> None:
    found = contact(plank("z", (0.0, 0.0, 0.0)), plank("b", (0.08, -0.005, T)))
    assert found.lower == "z"
    corners = [(x, y, T / 2) for x in (0.08 - L / 2, L / 2) for y in (-W / 2, W / 2 - 0.005)]
    assert same_points(found.points_W, corners, 1e-16)


@pytest.mark.parametrize("angle", [30.0, 45.0, 60.0, 150.0])
def test_planks_crossed_askew_share_a_rhomb(angle: float) -> None:
    # Two strips of width W that cross at an angle share W^2 / sin(angle).
    found = contact(plank("a", (0.0, 0.0, 0.0)), plank("b", (0.0, 0.0, T), yawed(radians(angle))))
    assert len(found.points_W) == 4
    assert area(found.points_W) == pytest.approx(W * W / sin(radians(angle)), rel=1e-12)


def test_a_turned_square_on_a_square_shares_an_octagon() -> None:
    found = contact(brick("a", CUBE, (0.0, 0.0, 0.0)), brick("b", CUBE, (0.0, 0.0, 1.0), yawed(pi / 4.0)))
    assert len(found.points_W) == 8
    assert area(found.points_W) == pytest.approx(2.0 * sqrt(2.0) - 2.0, rel=1e-12)


@pytest.mark.parametrize("orientation", [about((1.0, 0.0, 0.0), pi / 2.0), pitched(pi / 2.0), pitched(-pi / 2.0)])
def test_any_side_of_a_brick_may_be_the_level_one(orientation: Quaternion) -> None:
    extents = [abs(each) for each in rotate(orientation, PLANK)]
    upper = plank("b", (0.0, 0.0, 0.5 * T + 0.5 * extents[2]), orientation)
    assert upper.flat
    found = contact(plank("a", (0.0, 0.0, 0.0)), upper)
    assert area(found.points_W) == pytest.approx(min(extents[0], L) * min(extents[1], W), rel=1e-12)


@pytest.mark.parametrize("yaw", [0.0, 0.4])
@pytest.mark.parametrize("sliver", [1e-3, 1e-6, 1e-7])
def test_a_sliver_is_a_patch_with_its_true_corners(sliver: float, yaw: float) -> None:
    shift = L * (1.0 - sliver)
    upper = plank("b", (shift * cos(yaw), shift * sin(yaw), T), yawed(yaw))
    found = contact(plank("a", (0.0, 0.0, 0.0), yawed(yaw)), upper)
    assert len(found.normals_W) == 1
    assert found.normals_W[0] == pytest.approx(UP)
    assert area(found.points_W) == pytest.approx(L * sliver * W, rel=2e-16 / sliver + 1e-12)


def test_neighbours_that_stand_side_by_side_touch_with_their_sides() -> None:
    found = contact(plank("b", (0.0, 0.0, 0.0)), plank("a", (0.01, -W, 0.001)))
    assert (found.lower, found.upper) == ("a", "b")
    assert found.normals_W == ((0.0, 1.0, 0.0),)
    x, y, z = L / 2, -W / 2, T / 2
    assert same_points(
        found.points_W, [(0.01 - x, y, z), (x, y, z), (0.01 - x, y, 0.001 - z), (x, y, 0.001 - z)], 1e-16
    )


def test_bricks_on_a_common_slope_touch_with_their_faces() -> None:
    slope = pitched(0.3)
    found = contact(plank("a", (0.0, 0.0, 0.0), slope), plank("b", rotate(slope, (0.05, 0.0, T)), slope))
    corners = [(x, y, T / 2) for x in (0.05 - L / 2, L / 2) for y in (-W / 2, W / 2)]
    assert same_points(found.points_W, [rotate(slope, corner) for corner in corners], 1e-15)
    assert found.normals_W[0] == pytest.approx(rotate(slope, UP), abs=1e-15)


def test_a_pebble_on_a_slab_rests_on_its_whole_base() -> None:
    found = contact(
        brick("slab", (1e3, 1e3, 1.0), (0.0, 0.0, -0.5)), brick("p", (1e-3, 2e-3, 1e-3), (321.0, 5.0, 5e-4))
    )
    assert area(found.points_W) == pytest.approx(2e-6, rel=1e-9)


# --- planes ---------------------------------------------------------------------------------------------------------


def test_a_plank_on_tilted_ground_touches_it_with_its_face() -> None:
    tilt = pitched(0.4)
    slope = Plane("slope", (0.0, 0.0, 0.0), rotate(tilt, UP), 0.3)
    found = contact_with_plane(plank("b", rotate(tilt, (1.0, 0.0, T / 2)), tilt), slope, TOLERANCES)
    assert found is not None
    assert found.law.friction == 0.3
    corners = [rotate(tilt, (1.0 + x, y, 0.0)) for x in (-L / 2, L / 2) for y in (-W / 2, W / 2)]
    assert same_points(found.points_W, corners, 1e-15)
    assert area(found.points_W) > 0.0


def test_a_ceiling_is_the_lower_body_by_definition() -> None:
    ceiling = Plane("ceiling", (0.0, 0.0, T / 2), (0.0, 0.0, -1.0), 0.5)
    found = contact_with_plane(plank("b", (0.0, 0.0, 0.0)), ceiling, TOLERANCES)
    assert found is not None
    assert (found.lower, found.normals_W) == ("ceiling", ((0.0, 0.0, -1.0),))
    assert len(found.points_W) == 4
