"""Solids of very many corners are made in a process that is watched: Qhull obeys no signal."""

from itertools import product
from math import cos, pi, sin

import pytest

from stackdsl.language import bricks
from stackdsl.language.bricks import MOST_AT_ONCE, hull_form
from stackdsl.language.quantities import MistakeError


def test_corners_that_qhull_takes_minutes_for_are_a_mistake_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bricks, "TIME_LIMIT", 0.5)
    circle = tuple((cos(2.0 * pi * k / 29_999), sin(2.0 * pi * k / 29_999), 0.0) for k in range(29_999))
    with pytest.raises(MistakeError, match="its corners take too long"):
        hull_form((*circle, (0.0, 0.0, 1.0)))


def test_a_solid_of_many_points_is_that_of_its_corners() -> None:
    side = range(7)
    many = tuple((float(x), float(y), float(z)) for x, y, z in product(side, side, side) if {x, y, z} & {0, 6})
    few = tuple((float(x), float(y), float(z)) for x, y, z in product((0, 6), (0, 6), (0, 6)))
    assert len(many) > MOST_AT_ONCE > len(few)
    assert hull_form(many) == hull_form(few)


def test_what_is_wrong_with_many_points_is_told_as_of_few() -> None:
    flat = tuple((float(x), float(y), 0.0) for x, y in product(range(20), range(20)))
    with pytest.raises(MistakeError, match="all points lie in one plane"):
        hull_form(flat)
