"""The least shift that mends a pile: by how far a centre of mass is beyond what carries it."""

from collections.abc import Sequence
from math import hypot

import pytest

from benchmarks.mending import mended, piles
from stability.statics.facts import Placed
from stability.statics.mending.piling import Piling
from stability.statics.mending.shifts import CLOSE, SIDES, Shifting
from tests.planks import FLOOR, GRAVITY, LENGTH, WOOD, lying, plank


def column(places: Sequence[float]) -> Piling:
    """Planks on each other, each so far along x [m]."""
    planks = [Placed(plank(f"L{level}"), lying(level, x)) for level, x in enumerate(places, 1)]
    return Piling((FLOOR,), WOOD, GRAVITY, [[each] for each in planks])


def test_a_plank_goes_back_by_what_its_centre_is_beyond_the_edge() -> None:
    found = Shifting(column([0.0, 0.07])).least("L2", {})
    assert found is not None
    assert found.shift == pytest.approx((-(0.07 - LENGTH / 2.0), 0.0), abs=1e-5)
    assert found.length >= 0.07 - LENGTH / 2.0 >= found.too_little * (1.0 - 1e-9)
    assert found.too_little > found.length * (1.0 - 1e-3 - CLOSE)
    assert found.shorter == SIDES  # 3 % less is not enough in any direction


def test_what_rests_on_a_brick_goes_with_it() -> None:
    # Three planks 30 mm apart on the first: their centre is 60 mm from its middle, and 58.8 mm may be.
    shifting = Shifting(column([0.0, 0.03, 0.06, 0.09]))
    moved = {name: found for name in ("L2", "L3", "L4") if (found := shifting.least(name, {})) is not None}
    missing = 0.06 - LENGTH / 2.0
    for name, above in (("L2", 3), ("L3", 2), ("L4", 1)):
        assert moved[name].length == pytest.approx(missing * 3 / above, rel=1e-3)


def test_where_one_shift_is_not_enough_several_are() -> None:
    shifting = Shifting(column([0.0, 0.065, 0.0]))
    assert [shifting.least(name, {}) for name in ("L2", "L3")] == [None] * 2
    found = shifting.several()
    assert found is not None
    assert [name for name, _ in found.shifts] == ["L2", "L3"]
    assert [hypot(*shift) for _, shift in found.shifts] == pytest.approx([0.065 - LENGTH / 2.0] * 2, rel=1e-3)
    assert found.too_little > 1.0 - 1e-5


def test_a_brick_is_not_shifted_into_another() -> None:
    places = column([0.0, 0.07]).stages
    beside = Placed(plank("beside"), lying(2, 0.07 - LENGTH - 0.005))  # 5 mm of room, and 11.2 are needed
    below = Placed(plank("below"), lying(1, -LENGTH))
    piling = Piling((FLOOR,), WOOD, GRAVITY, [[places[0][0], below], [beside], places[1]])
    found = Shifting(piling).least("L2", {})
    assert found is None or abs(found.shift[1]) > 0.01  # past it, if at all


@pytest.mark.parametrize("count", [1, pytest.param(25, marks=pytest.mark.slow)])
def test_random_piles_that_fall_are_mended_as_a_linear_programme_has_it(count: int) -> None:
    drawn = piles(2)
    for _ in range(count):
        found = mended(next(drawn))
        assert found["how"] != "nothing"
        assert found["stands"], found
        assert found["falls"] or found["how"] == "props", found
