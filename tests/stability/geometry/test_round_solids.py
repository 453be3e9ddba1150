"""Round solids: extents, volumes and moments of inertia against integrals over thin slices, and their distances."""

from math import cos, hypot, pi, sin

import numpy as np
import pytest

from stability.geometry.box import Box
from stability.geometry.placed_shape import apart, apart_from_plane, bounds_W, in_place, meeting
from stability.geometry.round_solid import RoundSolid, capsule, cylinder, frustum, pipe, sphere
from stability.geometry.vectors import about, norm, rotate, unit
from stability.model import Plane, Pose

SOLIDS = [
    cylinder(0.03, 0.1),
    frustum(0.05, 0.02, 0.08),
    frustum(0.0, 0.04, 0.1),
    pipe(0.05, 0.01, 0.2),
    sphere(0.04),
    capsule(0.03, 0.1),
]


def slices(solid: RoundSolid) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the heights of thin slices, their outer radii and their thickness, from the middle of the axis [m]."""
    half = 0.5 * solid.height + solid.rounding
    edges = np.linspace(-half, half, 200_001)
    z = 0.5 * (edges[1:] + edges[:-1])
    if solid.rounding:
        beyond = np.maximum(np.abs(z) - 0.5 * solid.height, 0.0)
        return z, np.sqrt(np.maximum(solid.rounding**2 - beyond**2, 0.0)), 2.0 * half / len(z)
    low, high = solid.radii
    return z, low + (high - low) * (z + half) / (2.0 * half), 2.0 * half / len(z)


@pytest.mark.parametrize("solid", SOLIDS)
def test_volume_centroid_and_inertia_are_those_of_a_pile_of_thin_discs(solid: RoundSolid) -> None:
    z, radius, thick = slices(solid)
    area = pi * (radius**2 - solid.bore**2)
    volume = area.sum() * thick
    centre = (area * z).sum() * thick / volume
    along = (0.5 * pi * (radius**4 - solid.bore**4)).sum() * thick / volume
    across = (0.25 * pi * (radius**4 - solid.bore**4) + area * (z - centre) ** 2).sum() * thick / volume
    assert solid.volume == pytest.approx(volume, rel=1e-8)
    assert solid.centre_of_mass == pytest.approx((0.0, 0.0, centre), abs=1e-9)
    assert solid.moments(2.0) == pytest.approx((2.0 * across, 2.0 * across, 2.0 * along), rel=1e-8)


@pytest.mark.parametrize("solid", SOLIDS)
def test_no_point_of_the_drawn_polyhedron_is_outside_the_surface(solid: RoundSolid) -> None:
    for step in range(40):
        direction = unit((cos(step), sin(step), cos(1.7 * step)))
        inside = max(np.array(solid.corners) @ np.array(direction))
        assert inside <= solid.reach(direction) + 1e-15
        assert inside >= 0.9 * solid.reach(direction) - 0.01 * solid.length
        assert np.dot(solid.support(direction), direction) == pytest.approx(solid.reach(direction))
        assert norm(solid.support(direction)) <= solid.bounding_radius + 1e-15


def test_bounds_of_a_leaning_cylinder_are_those_of_its_two_circles() -> None:
    low, high = bounds_W(cylinder(0.03, 0.1), Pose((1.0, 2.0, 3.0), about((0.0, 1.0, 0.0), 0.3)))
    x, z = 0.03 * cos(0.3) + 0.05 * sin(0.3), 0.03 * sin(0.3) + 0.05 * cos(0.3)
    assert high == pytest.approx((1.0 + x, 2.03, 3.0 + z))
    assert low == pytest.approx((1.0 - x, 1.97, 3.0 - z))


def test_two_balls_are_apart_by_the_distance_of_their_centres_less_both_radii() -> None:
    gap = apart(sphere(0.1), Pose((0.0, 0.0, 0.0)), sphere(0.2), Pose((0.3, 0.4, 1.2)))
    assert gap.gap == pytest.approx(1.3 - 0.3)
    assert gap.normal_BA_W == pytest.approx((-0.3 / 1.3, -0.4 / 1.3, -1.2 / 1.3))


@pytest.mark.parametrize(("x", "y", "z"), [(0.3, 0.0, 0.0), (0.2, 0.25, 0.0), (0.2, 0.25, 0.3), (0.0, 0.01, -0.4)])
def test_a_ball_is_apart_from_a_box_by_the_distance_of_its_centre(x: float, y: float, z: float) -> None:
    outside = [max(abs(part) - 0.1, 0.0) for part in (x, y, z)]
    gap = apart(sphere(0.05), Pose((x, y, z)), Box((0.2, 0.2, 0.2)), Pose((0.0, 0.0, 0.0)))
    assert gap.gap == pytest.approx(hypot(*outside) - 0.05)


def test_crossed_cylinders_are_apart_by_the_distance_of_their_axes() -> None:
    lying = about((0.0, 1.0, 0.0), 0.5 * pi)
    across = about((1.0, 0.0, 0.0), 0.5 * pi)
    gap = apart(cylinder(0.1, 1.0), Pose((0.1, 0.0, 0.0), lying), cylinder(0.2, 1.0), Pose((0.0, 0.1, 0.35), across))
    assert gap.gap == pytest.approx(0.05)
    assert gap.normal_BA_W == pytest.approx((0.0, 0.0, -1.0))


def test_the_rim_of_a_leaning_cylinder_comes_nearest_to_an_edge() -> None:
    """The separating direction is perpendicular to the edge and to the rim: only the search finds it."""
    turned, at = about(unit((1.0, 1.0, 0.0)), 0.7), (0.19, 0.13, 0.14)
    box = Box((0.3, 0.2, 0.1))
    corners = np.array([rotate(turned, corner) for corner in box.corners]) + np.array(at)
    tilts, angles = np.meshgrid(np.linspace(0.0, 0.5 * pi, 361), np.linspace(0.0, 0.5 * pi, 361))
    normals = np.stack([np.sin(tilts) * np.cos(angles), np.sin(tilts) * np.sin(angles), np.cos(tilts)], axis=-1)
    own = 0.1 * np.cos(tilts) + 0.1 * np.sin(tilts)
    best = float(((normals @ corners.T).min(axis=-1) - own).max())
    found = apart(cylinder(0.1, 0.2), Pose((0.0, 0.0, 0.0)), box, Pose(at, turned)).gap
    assert best < found < best + 5e-5


def test_a_cylinder_is_above_a_plane_by_the_lowest_point_of_its_rim() -> None:
    plane = Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
    pose = Pose((0.0, 0.0, 0.2), about((0.0, 1.0, 0.0), 0.3))
    assert apart_from_plane(cylinder(0.03, 0.1), pose, plane).gap == pytest.approx(
        0.2 - 0.03 * sin(0.3) - 0.05 * cos(0.3)
    )


def test_a_falling_ball_meets_another_where_their_centres_are_two_radii_apart() -> None:
    fixed, down = in_place(sphere(0.1), Pose((0.0, 0.0, 0.0))), (0.0, 0.0, -1.0)
    met = meeting(in_place(sphere(0.1), Pose((0.12, 0.0, 1.0))), fixed, down, 0.0)
    assert met == pytest.approx((1.0 - 0.16, 1.0 + 0.16))
    assert meeting(in_place(sphere(0.1), Pose((0.21, 0.0, 1.0))), fixed, down, 0.0) is None
