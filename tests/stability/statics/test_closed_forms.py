"""Exact statics against closed forms: the verdict flips within a millionth of the limit, on both sides."""

from collections.abc import Callable
from functools import partial
from math import pi, radians

import pytest

from stability.problem import Placed, Stability, Verdict
from stability.statics.assembly import Assembly
from tests.stability.statics import closed_forms
from tests.stability.statics.closed_forms import Structure
from tests.stability.statics.independent import independent_verdict

MILLIONTH = 1e-6

LIMITS: dict[str, Callable[[float], Structure]] = {
    **{f"stepped column of {n}": partial(closed_forms.stepped_column, count=n) for n in (2, 3, 8, 12, 40, 100)},
    **{f"harmonic stack of {n}": partial(closed_forms.harmonic_stack, count=n) for n in (1, 10, 50, 100)},
    "ladder on a smooth wall": closed_forms.ladder,
    "ladder on a rough wall": partial(closed_forms.ladder, floor=0.4, wall=0.3),
    "ladder on a rougher wall": partial(closed_forms.ladder, floor=0.3, wall=0.8),
    **{f"inverted V at {a} deg": partial(closed_forms.inverted_v, theta=radians(a)) for a in (50, 60, 70, 75)},
    "plank that slides down a slope": closed_forms.slope_that_slides,
    "plank that slides down a gentle slope": partial(closed_forms.slope_that_slides, friction=0.12),
    "block that tips down a slope": closed_forms.slope_that_tips,
    "counterweighted overhang": closed_forms.counterweighted_overhang,
    "bridge tied by friction": closed_forms.bridge,
    "bridge tied by more friction": partial(closed_forms.bridge, friction=0.8),
    "load on three legs": closed_forms.three_legs,
    "load on four unequal supports": closed_forms.four_unequal_supports,
}
FLAT = [name for name in LIMITS if not any(word in name for word in ("ladder", "V", "slope"))]


def judged(structure: Structure) -> Verdict:
    """The verdict of all its bricks, set down together."""
    return assembled(structure).add_all(structure.bricks)


def assembled(structure: Structure) -> Assembly:
    return Assembly(planes=structure.planes, friction=structure.friction)


@pytest.mark.parametrize("name", LIMITS)
def test_stands_a_millionth_below_its_limit(name: str) -> None:
    assert judged(LIMITS[name](1.0 - MILLIONTH)).stability is Stability.STABLE


@pytest.mark.parametrize("name", LIMITS)
def test_falls_a_millionth_beyond_its_limit(name: str) -> None:
    verdict = judged(LIMITS[name](1.0 + MILLIONTH))
    assert verdict.stability is Stability.UNSTABLE
    assert verdict.moving


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("share", [0.5, 0.97])
def test_stands_well_below_its_limit(name: str, share: float) -> None:
    assert judged(LIMITS[name](share)).stability is Stability.STABLE


@pytest.mark.parametrize("name", LIMITS)
def test_falls_well_beyond_its_limit(name: str) -> None:
    assert judged(LIMITS[name](1.03)).stability is Stability.UNSTABLE


@pytest.mark.parametrize("name", FLAT)
def test_the_independent_check_knows_the_same_limits(name: str) -> None:
    for share, expected in ((0.999, "stable"), (1.001, "unstable")):
        structure = LIMITS[name](share)
        assert independent_verdict(structure.bricks, structure.friction) == expected


@pytest.mark.parametrize("friction", [0.1, 0.5, 2.0])
def test_a_plank_wedged_between_walls_is_undecided_since_nothing_says_that_it_is_pressed(friction: float) -> None:
    verdict = judged(closed_forms.wedged_plank(friction))
    assert verdict.stability is Stability.UNDECIDED
    assert verdict.moving == ("plank",)
    assert verdict.reason


def test_a_plank_between_smooth_walls_falls() -> None:
    assert judged(closed_forms.wedged_plank(0.0)).stability is Stability.UNSTABLE


def test_neither_half_of_the_bridge_stands_without_the_beam() -> None:
    structure = closed_forms.bridge(0.5)
    without = tuple(each for each in structure.bricks if each.brick.id != "beam")
    assert judged(Structure(without, structure.planes, structure.friction)).stability is Stability.UNSTABLE


def test_a_smooth_beam_ties_nothing() -> None:
    structure = closed_forms.bridge(0.5)
    assert judged(Structure(structure.bricks, structure.planes, 0.0)).stability is Stability.UNSTABLE


def test_the_overhang_falls_without_its_counterweight() -> None:
    structure = closed_forms.counterweighted_overhang(0.5)
    assembly = assembled(structure)
    assert assembly.add_all(structure.bricks).stability is Stability.STABLE
    assert assembly.remove(["weight"]).stability is Stability.UNSTABLE
    assert assembly.verdict().moving == ("plank",)


def test_only_the_stepped_part_of_a_column_moves() -> None:
    structure = closed_forms.stepped_column(1.01, 8)
    assert judged(structure).moving == tuple(f"c{k:03}" for k in range(1, 8))


def test_the_rest_of_a_fallen_column_stands() -> None:
    structure = closed_forms.stepped_column(1.01, 8)
    assembly = assembled(structure)
    moving = assembly.add_all(structure.bricks).moving
    assert assembly.remove(moving).stability is Stability.STABLE


@pytest.mark.parametrize("name", LIMITS)
def test_adding_bricks_one_by_one_gives_the_verdict_of_all_together(name: str) -> None:
    for share in (1.0 - MILLIONTH, 1.0 + MILLIONTH):
        structure = LIMITS[name](share)
        assembly = assembled(structure)
        for each in sorted(structure.bricks, key=lambda each: each.pose.position_W[2]):
            assembly.add(each.brick, each.pose)
        expected = Stability.STABLE if share < 1.0 else Stability.UNSTABLE
        assert assembly.verdict().stability is expected


def on_edge(share: float) -> tuple[Placed, ...]:
    """A plank whose centre is a share of the way to the edge of a block below it."""
    block = closed_forms.brick_at("block", (0.02, 0.02, 0.02), (0.0, 0.0, 0.01))
    x = share * 0.01
    return (block, closed_forms.brick_at("plank", closed_forms.PLANK, (x, 0.0, 0.0239)))


@pytest.mark.parametrize(("share", "expected"), [(1.0 - 1e-6, Stability.STABLE), (1.0 + 1e-6, Stability.UNSTABLE)])
def test_a_plank_tips_once_its_centre_is_beyond_the_edge(share: float, expected: Stability) -> None:
    assert Assembly().add_all(on_edge(share)).stability is expected


def test_the_v_of_the_readme_needs_the_friction_that_was_measured() -> None:
    # (cot 70 deg - 7.8 / 117.6) / 2 = 0.149
    assert closed_forms.inverted_v(1.0, 70.0 * pi / 180.0).friction == pytest.approx(0.1488, abs=1e-4)
