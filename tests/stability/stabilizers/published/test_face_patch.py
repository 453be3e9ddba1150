"""The overlap of two faces."""

from math import cos, pi, radians, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.model import Pose, Quaternion, Vec3
from stability.stabilizers.published.support import contact_area, face_patch

PLANK = (0.1176, 0.0234, 0.0078)
BELOW = Pose((0.0, 0.0, 0.0039))
noise = st.floats(-1e-7, 1e-7)


def about_z(angle: float) -> Quaternion:
    return (0.0, 0.0, sin(angle / 2.0), cos(angle / 2.0))


def about_y(angle: float) -> Quaternion:
    return (0.0, sin(angle / 2.0), 0.0, cos(angle / 2.0))


def in_mm(corners: tuple[Vec3, ...]) -> set[tuple[float, ...]]:
    return {tuple(round(1000.0 * part, 3) + 0.0 for part in corner) for corner in corners}


def test_planks_crossed_at_their_ends_overlap_in_a_square_of_their_width() -> None:
    #   The outer edges of the two planks coincide, the case in which PyBullet's own points go astray.
    above = Pose((-0.0471, 0.0471, 0.0117), about_z(pi / 2.0))
    assert in_mm(face_patch(PLANK, above, PLANK, Pose((0.0, 0.0471, 0.0039)))) == {
        (x, y, 7.8) for x in (-58.8, -35.4) for y in (35.4, 58.8)
    }


@given(noise, noise, noise, st.floats(-1e-6, 1e-6))
def test_rounding_changes_neither_the_number_of_corners_nor_their_place(
    x: float, y: float, z: float, turn: float
) -> None:
    above = Pose((0.03 + x, y, 0.0117 + z), about_z(turn))
    corners = face_patch(PLANK, above, PLANK, BELOW)
    assert len(corners) == 4
    area = contact_area("below", corners)
    assert area.centre == pytest.approx((0.015, 0.0), abs=1e-6)


def test_corners_run_counter_clockwise_seen_from_above() -> None:
    for turned_over in (about_y(0.0), about_y(pi)):
        corners = face_patch(PLANK, Pose((0.0, 0.0, 0.0117)), PLANK, Pose((0.0, 0.0, 0.0039), turned_over))
        doubled = sum(
            ax * by - ay * bx for (ax, ay, _), (bx, by, _) in zip(corners, corners[1:] + corners[:1], strict=True)
        )
        assert doubled == pytest.approx(2.0 * PLANK[0] * PLANK[1])


def test_planks_at_an_angle_overlap_in_a_rhombus() -> None:
    corners = face_patch(PLANK, Pose((0.0, 0.0, 0.0117), about_z(radians(60))), PLANK, BELOW)
    assert len(corners) == 4
    x, y = contact_area("below", corners).centre
    assert (x, y) == pytest.approx((0.0, 0.0), abs=1e-12)
    # A rhombus with both heights equal to the width w has its long corner at w / sin(60 deg) / (2 sin(30 deg)).
    assert max(abs(corner[1]) for corner in corners) == pytest.approx(PLANK[1] / 2.0)


@pytest.mark.parametrize(
    "above",
    [
        Pose((0.2, 0.0, 0.0117)),  # beside it
        Pose((0.1176 - 1e-6, 0.0, 0.0117)),  # over a sliver of rounding
        Pose((0.0, 0.0, 0.03), about_y(radians(10))),  # on its edge
    ],
)
def test_faces_apart_or_on_edge_have_no_patch(above: Pose) -> None:
    assert face_patch(PLANK, above, PLANK, BELOW) == ()


@given(st.floats(-pi, pi), st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))
def test_moving_and_turning_both_planks_carries_the_patch_along(yaw: float, x: float, y: float) -> None:
    def carried(at: Vec3) -> Vec3:
        return (x + cos(yaw) * at[0] - sin(yaw) * at[1], y + sin(yaw) * at[0] + cos(yaw) * at[1], at[2])

    above = Pose((0.03, 0.004, 0.0117), about_z(0.4))
    here = face_patch(PLANK, above, PLANK, BELOW)
    there = face_patch(
        PLANK,
        Pose(carried(above.position_W), about_z(0.4 + yaw)),
        PLANK,
        Pose(carried(BELOW.position_W), about_z(yaw)),
    )
    assert len(there) == len(here)
    for corner in here:
        assert min(sum(abs(a - b) for a, b in zip(carried(corner), c, strict=True)) for c in there) < 1e-9
