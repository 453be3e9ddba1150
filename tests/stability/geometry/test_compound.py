"""Rigid bodies of several convex parts: mass properties by closed forms, extents, distances, and what is refused."""

from math import hypot, pi

import numpy as np
import pytest

from stability.geometry.box import Box, OffCentreBox
from stability.geometry.compound_making import compound
from stability.geometry.convex_solid import NotASolidError
from stability.geometry.placed_shape import apart, bounds_W, distance_outside, in_place, meeting, scaled
from stability.geometry.solid_making import prism
from stability.geometry.vectors import about, body_axes, rotate
from stability.model import IDENTITY, Pose
from tests.stability.statics.compounds import boxes

RING = boxes(
    *(((0.4, 0.1, 0.2), (0.0, y, 0.0)) for y in (-0.15, 0.15)),
    *(((0.1, 0.2, 0.2), (x, 0.0, 0.0)) for x in (-0.15, 0.15)),
)


def test_a_square_ring_has_the_moments_of_a_square_less_its_hole() -> None:
    # m/12 (a2 + b2) of the outer square of 0.4 less that of the hole of 0.2, at equal density.
    outer, hole = 0.4**2, 0.2**2
    mass = 3.0
    density = mass / (outer - hole)
    about_z = density * (outer * 2.0 * outer - hole * 2.0 * hole) / 12.0
    across = density * (outer * (outer + 0.2**2) - hole * (hole + 0.2**2)) / 12.0
    assert RING.shape.moments(mass) == pytest.approx((across, across, about_z), rel=1e-12)
    assert RING.shape.principal_axes == IDENTITY
    assert RING.shape.volume == pytest.approx(0.2 * (outer - hole), rel=1e-12)
    assert RING.centre_of_mass == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)


def test_an_angle_has_its_centroid_and_principal_axes_on_its_line_of_symmetry() -> None:
    angle = boxes(((0.1, 0.05, 0.02), (0.05, 0.0, 0.01)), ((0.02, 0.05, 0.08), (0.01, 0.0, 0.06)))
    x, _, z = angle.centre_of_mass
    assert x == pytest.approx((0.002 * 0.05 + 0.0016 * 0.01) / 0.0036, rel=1e-12)
    assert x == pytest.approx(z, rel=1e-12)
    axes = body_axes(angle.shape.principal_axes)
    diagonal = [abs(axis[0]) for axis in axes if abs(axis[1]) < 0.5]
    assert diagonal == pytest.approx([0.5**0.5] * 2, rel=1e-9)


@pytest.mark.parametrize("turn", [IDENTITY, about((0.6, 0.0, 0.8), 0.7)])
def test_parts_of_a_cut_box_have_together_the_moments_of_the_box(turn: tuple[float, float, float, float]) -> None:
    halves = [(Box((0.1, 0.3, 0.4)), (x, 0.0, 0.0)) for x in (-0.05, 0.05)]
    made = compound([(box, Pose(rotate(turn, at), turn)) for box, at in halves])
    whole = sorted(Box((0.2, 0.3, 0.4)).moments(2.0))
    assert sorted(made.shape.moments(2.0)) == pytest.approx(whole, rel=1e-12)
    assert made.shape.bounding_radius == pytest.approx(0.5 * hypot(0.2, 0.3, 0.4), rel=1e-12)
    assert made.shape.least_thickness == 0.1


def test_a_scaled_compound_scales_its_parts() -> None:
    twice = scaled(RING.shape, 2.0)
    assert twice.volume == pytest.approx(8.0 * RING.shape.volume)
    assert twice.moments(1.0) == pytest.approx([4.0 * moment for moment in RING.shape.moments(1.0)])
    assert twice.reach((1.0, 0.0, 0.0)) == pytest.approx(0.4)


def test_a_body_in_the_hole_of_a_ring_is_apart_from_it() -> None:
    inside = apart(Box((0.1, 0.1, 0.1)), Pose((0.02, 0.0, 0.0)), RING.shape, Pose((0.0, 0.0, 0.0)))
    assert inside.gap == pytest.approx(0.03)
    assert inside.normal_BA_W == pytest.approx((-1.0, 0.0, 0.0))
    within = in_place(RING.shape, Pose((0.0, 0.0, 0.0)))
    assert distance_outside(within, (0.0, 0.0, 0.0)) == pytest.approx(0.1)
    assert distance_outside(within, (0.15, 0.0, 0.0)) == pytest.approx(-0.05)
    falling = in_place(Box((0.1, 0.1, 0.1)), Pose((0.0, 0.0, 1.0)))
    assert meeting(falling, within, (0.0, 0.0, -1.0), 1e-6) is None
    aside = in_place(Box((0.1, 0.1, 0.1)), Pose((0.1, 0.0, 1.0)))
    assert meeting(aside, within, (0.0, 0.0, -1.0), 1e-6) == pytest.approx((0.85, 1.15))


def test_bounds_are_those_of_all_parts() -> None:
    low, high = bounds_W(RING.shape, Pose((1.0, 0.0, 0.0), about((0.0, 0.0, 1.0), 0.25 * pi)))
    assert np.subtract(high, low) == pytest.approx((0.4 * 2.0**0.5, 0.4 * 2.0**0.5, 0.2))


@pytest.mark.parametrize(
    ("parts", "cause"),
    [
        ([], "the body has 0 parts"),
        ([(Box((1.0, 1.0, 1.0)), Pose((3.0 * n, 0.0, 0.0))) for n in range(2)], "part 2 does not touch"),
        ([(Box((1.0, 1.0, 1.0)), Pose((0.9 * n, 0.0, 0.0))) for n in range(2)], "parts 1 and 2 overlap by 100 mm"),
        ([(OffCentreBox((1.0, 1.0, 1.0), (0.1, 0.0, 0.0)), Pose((0.0, 0.0, 0.0)))], "neither a box nor"),
        ([(Box((1.0, 1.0, 1.0)), Pose((float(n), 0.0, 0.0))) for n in range(201)], "the body has 201 parts"),
    ],
)
def test_parts_that_make_no_rigid_body_are_refused(parts: list[tuple[Box, Pose]], cause: str) -> None:
    with pytest.raises(NotASolidError) as refused:
        compound(parts)
    assert cause in str(refused.value)


def test_a_centre_of_mass_may_lie_between_the_parts_but_not_outside_their_hull() -> None:
    parts = [(part.shape, part.place) for part in RING.shape.parts]
    assert compound(parts, (0.05, 0.0, 0.0)).shape.reach((1.0, 0.0, 0.0)) == pytest.approx(0.15)
    with pytest.raises(NotASolidError, match="outside the body"):
        compound(parts, (0.3, 0.0, 0.0))


def test_convex_solids_are_parts_with_their_own_centroid() -> None:
    wedge = prism([(0.0, 0.0), (0.1, 0.0), (0.0, 0.1)], 0.1)
    other = prism([(0.1, 0.0), (0.1, 0.1), (0.0, 0.1)], 0.1)
    made = compound([(each.shape, Pose(each.centre_of_mass)) for each in (wedge, other)])
    assert made.centre_of_mass == pytest.approx((0.05, 0.0, 0.05))
    assert sorted(made.shape.moments(1.0)) == pytest.approx([0.02 / 12.0] * 3, rel=1e-9)
