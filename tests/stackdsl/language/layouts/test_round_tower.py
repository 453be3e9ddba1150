"""The round tower: rings that close, and planks whose weight two below carry in equal parts."""

from itertools import pairwise
from math import cos, inf, pi, sin, tan

import pytest

from stackdsl.language.layouts.registry import BrickSpec
from stackdsl.language.layouts.tower import TowerParams, tower
from stackdsl.language.quantities import InputError
from tests.stackdsl.language.layouts.layout_shapes import KAPLA, LENGTH, WIDTH, by_level, gap

RINGS = [(3, 0.2), (5, 0.5), (7, 0.4), (16, 0.4), (40, 0.05), (400, 0.45)]  # planks per ring, and their overlap


def rings(bricks: int, overlap: float, levels: int = 3) -> list[list[BrickSpec]]:
    return by_level(tower(TowerParams(levels=levels, bricks=bricks, overlap=overlap), KAPLA))


def seen_from(spec: BrickSpec, x: float, y: float) -> tuple[float, float]:
    """A point in plan, along the length and the width of a plank from its middle [m]."""
    dx, dy = x - spec.position[0], y - spec.position[1]
    return dx * cos(spec.yaw) + dy * sin(spec.yaw), -dx * sin(spec.yaw) + dy * cos(spec.yaw)


@pytest.mark.parametrize(("bricks", "overlap"), RINGS)
def test_a_plank_of_a_tower_lies_with_its_overlap_on_each_of_two_below(bricks: int, overlap: float) -> None:
    # ===|===|===     the middle line of a plank leaves the end face of one below at its overlap from its own end
    #  |===|===|
    for below, ring in pairwise(rings(bricks, overlap)):
        for spec in ring:
            for side in (-1.0, 1.0):
                along = side * (0.5 - overlap) * LENGTH
                x, y = spec.position[0] + along * cos(spec.yaw), spec.position[1] + along * sin(spec.yaw)
                ends = [abs(abs(seen_from(low, x, y)[0]) - LENGTH / 2) for low in below]
                assert min(ends) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("bricks", "overlap"), RINGS)
def test_two_equal_forces_inside_both_contacts_hold_each_plank_of_a_tower(bricks: int, overlap: float) -> None:
    #        o          Middle lines of a plank and of two below cross at x, within all three, at equal distances. Half
    #  --x-------x--    of the load at each x balances the plank, and presses on those below at such points of theirs.
    for below, ring in pairwise(rings(bricks, overlap, levels=4)):
        for spec in ring:
            carrying = [low for low in below if abs(crossing(spec, low)) < LENGTH / 2]
            one, other = (crossing(spec, low) for low in carrying)
            assert one == pytest.approx(-other, abs=1e-12)
            for low in carrying:
                assert abs(crossing(low, spec)) == pytest.approx(abs(one), abs=1e-12)
                assert gap(spec, low) == pytest.approx(0.0, abs=1e-12)


def crossing(spec: BrickSpec, low: BrickSpec) -> float:
    """Where the middle line of another plank crosses that of the first, along it from its middle [m]."""
    away, turn = seen_from(low, *spec.position[:2])[1], sin(spec.yaw - low.yaw)
    return -away / turn if abs(turn) > 1e-12 else inf


@pytest.mark.parametrize(("bricks", "overlap"), RINGS)
def test_planks_of_a_ring_are_free_of_each_other(bricks: int, overlap: float) -> None:
    ring = rings(bricks, overlap)[0]
    assert min(gap(one, other) for one, other in pairwise([*ring, ring[0]])) > 0.0


@pytest.mark.parametrize("bricks", [3, 5, 16, 400])
def test_a_ring_closes_at_its_largest_overlap(bricks: int) -> None:
    half_pitch = pi / bricks
    most = (1 / cos(half_pitch) - WIDTH / LENGTH * tan(half_pitch)) / 2
    ring = rings(bricks, most * (1 - 1e-9))[0]
    assert gap(ring[0], ring[1]) == pytest.approx(0.0, abs=1e-9)
    for overlap in (most * (1 + 1e-9), 0.0):
        with pytest.raises(InputError, match=rf"{bricks} planks per ring") as mistake:
            rings(bricks, overlap)
        assert mistake.value.hint == f"write an overlap greater than 0 % and less than {100 * most:.3g} %"
