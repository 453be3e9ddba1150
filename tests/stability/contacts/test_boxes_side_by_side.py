"""Level boxes side by side: the fast code gives the result of the general code."""

from itertools import product
from math import cos, sin

import numpy as np
import pytest

from stability.contacts import detection
from stability.contacts.bodies import convex_solid as solid
from stability.contacts.detection import contact_between
from stability.geometry.box import Box
from stability.model import Brick, Pose, Vec3
from stability.problem import Contact, Placed, Tolerances

REACH = 0.02 * 0.1  # of boxes whose smallest side is 0.1 m
GAPS = (-0.5, 0.0, 0.02, 0.049, 0.051, 0.3, 0.99, 1.01)  # of the reach
ALONG = (0.0, 0.19, 0.249, 0.251)  # [m] how far the second stands further along their sides, which overlap up to 0.25
UP = (0.0, 0.05, 0.199)  # [m] how much higher


@pytest.mark.parametrize("yaw", [0.0, 0.7, 1.5707963267948966])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_two_ways_find_the_same(monkeypatch: pytest.MonkeyPatch, yaw: float, side: float) -> None:
    found = []
    for gap, along, up in product(GAPS, ALONG, UP):
        x, y = side * (0.1 + gap * REACH), along
        at = (x * cos(yaw) - y * sin(yaw), x * sin(yaw) + y * cos(yaw), 0.1 + up)
        turn = (0.0, 0.0, sin(yaw / 2.0), cos(yaw / 2.0))
        one = solid(Placed(Brick("a", Box((0.1, 0.3, 0.2)), 1.0), Pose((0.0, 0.0, 0.1), turn)))
        other = solid(Placed(Brick("b", Box((0.1, 0.2, 0.2)), 1.0), Pose(at, turn)))
        short = contact_between(one, other, 0.5, Tolerances())
        with monkeypatch.context() as patch:
            patch.setattr(detection, "side_patch", lambda *_: None)
            long = contact_between(one, other, 0.5, Tolerances())
        assert (short is None) == (long is None), (gap, along, up)
        if short is not None and long is not None:
            assert short.normals_W[0] == pytest.approx(long.normals_W[0], abs=1e-12)
            assert np.allclose(in_order(short), in_order(long), rtol=0.0, atol=1e-9)
        found.append(short is not None)
    assert any(found)
    assert not all(found)


def in_order(contact: Contact) -> list[Vec3]:
    return sorted(contact.points_W, key=lambda point: [round(value, 6) for value in point])


def test_no_long_way_is_gone_across_a_gap_beside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(detection, "_closeness", None)  # calling it is an error
    one, other = (
        solid(Placed(Brick(name, Box((0.1, 0.3, 0.2)), 1.0), Pose((x, 0.0, 0.1))))
        for name, x in (("a", 0.0), ("b", 0.1 + 0.5 * REACH))
    )
    assert contact_between(one, other, 0.5, Tolerances()) is None
