"""Solids of very many corners are made in a supervised process, since signals do not interrupt Qhull."""

from itertools import product
from math import cos, pi, sin

import pytest

from stackdsl.language import bricks
from stackdsl.language.bricks import MOST_AT_ONCE, hull_form
from stackdsl.language.quantities import InputError


def test_slow_hulls_are_stopped_at_the_time_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bricks, "TIME_LIMIT", 0.5)
    circle = tuple((cos(2.0 * pi * k / 29_999), sin(2.0 * pi * k / 29_999), 0.0) for k in range(29_999))
    with pytest.raises(InputError, match="the corners takes too long"):
        hull_form((*circle, (0.0, 0.0, 1.0)))


def test_hull_of_many_points_has_their_extreme_points_as_corners() -> None:
    side = range(7)
    many = tuple((float(x), float(y), float(z)) for x, y, z in product(side, side, side) if {x, y, z} & {0, 6})
    few = tuple((float(x), float(y), float(z)) for x, y, z in product((0, 6), (0, 6), (0, 6)))
    assert len(many) > MOST_AT_ONCE > len(few)
    assert hull_form(many) == hull_form(few)


def test_errors_of_many_points_are_those_of_few_points() -> None:
    flat = tuple((float(x), float(y), 0.0) for x, y in product(range(20), range(20)))
    with pytest.raises(InputError, match="all points lie in one plane"):
        hull_form(flat)
