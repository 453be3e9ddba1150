"""The least shift that mends a pile: by how far a centre of mass is beyond what carries it."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from math import cos, hypot, radians, sin

import pytest

from benchmarks.random_piles import mended, piles
from stability.analysis.piling import Piling, ShiftedBuild
from stability.analysis.repair import CLOSE, SIDES, Shifting, propping
from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Placed, Verdict
from stackdsl.report.studies import suggestion_text
from tests.planks import ACROSS, FLOOR, GRAVITY, LENGTH, WIDTH, WOOD, lying, plank


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


def aslant(x: float, y: float) -> Piling:
    """A square brick on one of the same size, beyond it by x and y from the limit of +x and +y."""
    box = Box((0.2, 0.2, 0.1))
    at = [(0.0, 0.0, 0.05), (0.1 + x, 0.1 + y, 0.15)]
    pile = [Placed(Brick(name, box, 1.0), Pose(place)) for name, place in zip(("low", "high"), at, strict=True)]
    return Piling((FLOOR,), WOOD, GRAVITY, [[pile[0]], [pile[1]]])


def test_a_shift_goes_along_one_side_where_that_is_nearly_the_shortest() -> None:
    #   The lower brick is turned by 20 deg, so the shortest shift is 20 deg off -x; along -x it is 6 % longer.
    turned = (0.0, 0.0, sin(radians(10.0)), cos(radians(10.0)))
    pile = aslant(0.04, -0.1)
    low = replace(pile.stages[0][0], pose=Pose((0.0, 0.0, 0.05), turned))
    found = Shifting(replace(pile, stages=[[low], pile.stages[1]])).least("high", {})
    assert found is not None
    assert found.shift == pytest.approx((-(0.14 - 0.1 / cos(radians(20.0))), 0.0), rel=2e-3)


def test_a_shift_off_a_corner_is_told_along_both_sides() -> None:
    found = Shifting(aslant(0.03, 0.02)).least("high", {})
    assert found is not None
    assert found.shift == pytest.approx((-0.03, -0.02), rel=2e-3)
    assert suggestion_text(found).startswith("move high by 30")
    assert " mm towards -x and 20" in suggestion_text(found)


def test_a_shift_moves_the_bricks_on_top_too() -> None:
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


def test_a_brick_is_shifted_along_a_neighbour_that_it_does_not_touch() -> None:
    # A gap of 2 mm beside a brick of 300 mm is no contact, though below the brick it would be one.
    box = Box((0.3, 0.3, 0.3))
    at = {"low": (0.0, 0.0, 0.15), "beside": (0.3, 0.302, 0.15), "high": (0.17, 0.0, 0.45), "near": (0.3, 0.302, 0.45)}
    pile = [Placed(Brick(name, box, 1.0), Pose(place)) for name, place in at.items()]
    found = Shifting(Piling((FLOOR,), WOOD, GRAVITY, [pile[:2], [pile[3]], [pile[2]]])).least("high", {})
    assert found is not None
    assert found.shift == pytest.approx((-0.02, 0.0), rel=1e-3)
    assert found.too_little == pytest.approx(0.02, rel=1e-5)


def test_a_shift_mends_a_fall_after_a_pull() -> None:
    # Two planks across, 60 mm apart, and one on both: without the second its middle is 30 - 11.7 mm beyond the first.
    across = [Placed(plank(name), lying(1, x, 0.0, ACROSS)) for name, x in (("left", 0.0), ("right", 0.06))]
    on = Placed(plank("on"), lying(2, 0.03))
    piling = Piling((FLOOR,), WOOD, GRAVITY, [across, [on], []], {2: ["right"]})
    fall = piling.first_fall()
    assert fall is not None
    assert (fall[0], fall[1].moving) == (2, ("on",))
    found = Shifting(piling).least("on", {})
    assert found is not None
    assert found.too_little == pytest.approx(0.03 - WIDTH / 2.0, rel=1e-4)
    assert found.shift == pytest.approx((-0.01831, 0.0), abs=1e-9)  # the next longer of four digits


def test_a_removed_brick_blocks_no_shift() -> None:
    # As above, but what falls comes 50 mm beyond the post, and where another plank lay: back through its place.
    post = Placed(plank("post"), lying(1, 0.0, 0.0, ACROSS))
    first, late = (Placed(plank(name), lying(2, x)) for name, x in (("first", 0.0), ("late", WIDTH / 2.0 + 0.05)))
    found = Shifting(Piling((FLOOR,), WOOD, GRAVITY, [[post], [first], [late]], {2: ["first"]})).least("late", {})
    assert found is not None
    assert found.shift == pytest.approx((-0.05, 0.0), abs=1e-5)


def test_props_hold_all_that_comes_later_too() -> None:
    found = propping(column([0.0, 0.065, 0.03, 0.095]))  # L2 and L4 tip by themselves
    assert found is not None
    assert (found.bricks, found.next_to_fall) == (("L2", "L4"), ())


@pytest.mark.parametrize("count", [1, pytest.param(25, marks=pytest.mark.slow)])
def test_random_piles_that_fall_are_mended_as_linear_programmes_have_it(count: int) -> None:
    for pile in islice(piles(2), count):
        found = mended(pile)
        assert found.how != "nothing"
        assert all(each.stands and each.falls_with_less for each in found.checked), found


def test_the_piles_that_once_nothing_mended_have_props() -> None:
    # A box lies on top of those that tip, with all of its underside: what is free is under them.
    found = mended(next(islice(piles(1), 19, None)))
    assert found.how == "props"
    assert all(each.stands and each.falls_with_less for each in found.checked)


def test_a_former_fall_decides_a_trial_only_where_the_build_falls() -> None:
    #   The three upper planks stand if their centre is over the first one: 12 mm less far out than 60 mm is enough.
    piling = column([0.0, 0.03, 0.06, 0.09])
    shifting = Shifting(piling)
    build = ShiftedBuild(piling)
    verdict = piling.verdict_at_once()
    assert verdict.motion is not None
    build.add_fall(len(piling.stages), {}, verdict.motion)
    missing = 0.06 - LENGTH / 2.0
    for share, falls in ((0.5, True), (1.0 - 1e-6, True), (1.0 + 1e-6, False), (5.0, False)):
        shift = dict.fromkeys(("L2", "L3", "L4"), (-share * missing, 0.0, 0.0))
        assert build.falls_again(shift, len(piling.stages)) is falls
        assert shifting.stands({"L2": (-share * missing, 0.0)}) is not falls


def test_the_shifts_of_a_high_column_need_few_verdicts(monkeypatch: pytest.MonkeyPatch) -> None:
    counted: list[Piling] = []
    whole = Piling.verdict_at_once

    def verdict(piling: Piling) -> Verdict:
        counted.append(piling)
        return whole(piling)

    monkeypatch.setattr(Piling, "verdict_at_once", verdict)
    shifting = Shifting(column([0.006 * level for level in range(28)]))
    missing = 14 * 0.006 - LENGTH / 2.0  # the mean of the upper planks
    for level in (10, 12):
        found = shifting.least(f"L{level}", {})
        assert found is not None
        assert found.too_little == pytest.approx(missing * 27 / (29 - level), rel=1e-5)
    assert len(counted) < 0.2 * shifting.verdict_count
