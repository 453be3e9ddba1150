"""Statics sees two boxes as far apart as everybody else does."""

from math import sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.contacts.bodies import box_solid
from stability.contacts.box_contacts import closeness
from stability.geometry.box_distance import boxes_apart
from stability.model import Pose, Quaternion, Vec3

PLANK, CUBE = (0.1176, 0.0234, 0.0078), (0.03, 0.03, 0.03)
FAR = 10.0  # [m] everything is nearer
PART = st.floats(-1.0, 1.0)
TURN = st.tuples(PART, PART, PART, PART).filter(lambda turn: sum(part * part for part in turn) > 0.01)


@given(st.tuples(*[st.floats(-0.1, 0.1)] * 3), TURN, TURN)
def test_the_gap_of_a_contact_is_that_of_the_separation(place: Vec3, turn_a: Quaternion, turn_b: Quaternion) -> None:
    a, b = Pose(place, unit(turn_a)), Pose((0.0, 0.0, 0.0), unit(turn_b))
    close = closeness(box_solid("a", PLANK, a), box_solid("b", CUBE, b), FAR)
    assert close is not None
    assert close.gap == pytest.approx(boxes_apart(PLANK, a, CUBE, b).gap, abs=2e-9)  # faces win ties by a nanometre


def unit(turn: Quaternion) -> Quaternion:
    x, y, z, w = turn
    length = sqrt(x * x + y * y + z * z + w * w)
    return (x / length, y / length, z / length, w / length)
