"""Contacts and their points as gaps and tilts approach the tolerance; gaps in shares of T."""

from math import pi, radians

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from stability.contacts.bodies import BoxSolid, box_solid
from stability.contacts.detection import contact_with_plane
from stability.geometry.vectors import multiply
from stability.model import IDENTITY, Pose, Vec3
from tests.stability.contacts.touching import (
    CUBE,
    GROUND,
    TOLERANCES,
    UP,
    T,
    W,
    about,
    brick,
    contact,
    elevations,
    leaning_pair,
    plank,
    same_points,
    touch,
    yawed,
)

REACH = TOLERANCES.gap * T


def disturbed(body: BoxSolid, shift: Vec3, turn: Vec3) -> BoxSolid:
    (x, y, z), turning = body.pose.position_W, IDENTITY
    for axis, angle in zip(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), UP), turn, strict=True):
        turning = multiply(about(axis, angle), turning)
    pose = Pose((x + shift[0], y + shift[1], z + shift[2]), multiply(turning, body.pose.orientation))
    return box_solid(body.id, body.size, pose)


NOISE = st.tuples(*[st.floats(-1e-5, 1e-5)] * 3)
TILT = st.tuples(*[st.floats(-1e-4, 1e-4)] * 3)


@given(st.sampled_from([20.0, 45.0, 60.0, 75.0]), NOISE, TILT, NOISE, TILT)
def test_noise_of_settling_takes_no_normal_from_leaning_planks(
    theta: float, shift_a: Vec3, turn_a: Vec3, shift_b: Vec3, turn_b: Vec3
) -> None:
    # A scene without noise in all but one number is one that was meant so, not one that an engine left.
    assume(sum(abs(each) > 1e-5 for each in (*turn_a, *turn_b)) > 3 and max(map(abs, shift_a)) > 1e-6)
    a, b = leaning_pair(radians(theta))
    found = contact(disturbed(a, shift_a, turn_a), disturbed(b, shift_b, turn_b))
    assert same_points(found.points_W, [(0.0, -W / 2, 0.0), (0.0, W / 2, 0.0)], 8e-5)
    widest = min(theta, 90.0 - theta)
    assert elevations(found) == pytest.approx([-widest, widest], abs=0.05)


# --- the tolerance --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("gap", "touches"), [(0.99, True), (1.01, False), (-0.99, True), (-1.01, False)])
def test_bodies_touch_up_to_the_tolerance_apart_or_in_each_other(gap: float, touches: bool) -> None:
    height = T + gap * REACH
    for orientation in (yawed(pi / 2.0), yawed(0.5), multiply(yawed(0.5), about((1.0, 0.0, 0.0), 1e-9))):
        assert (touch(plank("a", (0.0, 0.0, 0.0)), plank("b", (0.0, 0.0, height), orientation)) is not None) is touches
    assert (contact_with_plane(plank("b", (0.0, 0.0, height - T / 2)), GROUND, TOLERANCES) is not None) is touches


def test_the_smaller_of_two_bricks_sets_the_tolerance() -> None:
    slab = brick("slab", CUBE, (0.0, 0.0, -0.5))
    assert touch(slab, plank("b", (0.0, 0.0, T / 2 + 1.01 * REACH))) is None
    assert touch(slab, plank("b", (0.0, 0.0, T / 2 + 0.99 * REACH))) is not None


@given(NOISE, TILT, NOISE, TILT)
def test_noise_of_settling_moves_patch_corners_by_no_more_than_itself(
    shift_a: Vec3, turn_a: Vec3, shift_b: Vec3, turn_b: Vec3
) -> None:
    a, b = plank("a", (0.0, 0.0, 0.0)), plank("b", (0.03, 0.0, T), yawed(pi / 2.0))
    found = contact(disturbed(a, shift_a, turn_a), disturbed(b, shift_b, turn_b))
    assert len(found.normals_W) == 1
    assert same_points(found.points_W, contact(a, b).points_W, 5e-5)


@given(st.tuples(st.floats(-5e-4, 5e-4), st.floats(-5e-4, 5e-4)), st.floats(-0.3, 0.3))
def test_tilts_within_the_tolerance_leave_a_face_contact_one(tilt: tuple[float, float], gap: float) -> None:
    a, b = plank("a", (0.0, 0.0, 0.0)), plank("b", (0.05, 0.004, T + gap * REACH), yawed(0.3))
    found = contact(a, disturbed(b, (0.0, 0.0, 0.0), (tilt[0], tilt[1], 0.0)))
    assert len(found.points_W) == len(contact(a, b).points_W)
    assert same_points(
        [(x, y, 0.0) for x, y, _ in found.points_W], [(x, y, 0.0) for x, y, _ in contact(a, b).points_W], 1e-5
    )
