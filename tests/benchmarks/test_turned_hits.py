"""Planks thrown end-on, turned and broadside move what they hit as far as references apart from the engine say."""

import pytest

pytest.importorskip("numba")

from benchmarks.moreau.planar_hits import falls_past, shift
from benchmarks.plank_structures import LENGTH
from benchmarks.turned_hits import TurnedHit, by_impact_law, of_exact

pytestmark = pytest.mark.slow  # numba compiles for a minute, and a hit takes seconds

STEPS = 16000  # of the impact law, a second: with half as many, hits that catch differ by 3 %


def test_the_planar_reference_does_not_depend_on_its_step() -> None:
    assert shift(1.0, step=4e-5) == pytest.approx(shift(1.0, step=1e-5), rel=1e-3)


@pytest.mark.parametrize("speed", [1.0, 1.5])
def test_a_plank_that_nothing_carries_pushes_until_it_has_fallen_past(speed: float) -> None:
    """The closed form lets it fall without turning; by its length it turns a little."""
    assert shift(speed, floor=False, thrown=LENGTH) == pytest.approx(falls_past(speed), rel=0.02)


@pytest.mark.parametrize("speed", [1.0, 1.5])
def test_a_plank_that_comes_end_on_between_the_planks_below_pushes_until_it_has_fallen_past(speed: float) -> None:
    hit = TurnedHit(0.0, speed, above=0.0)
    assert of_exact(hit) == pytest.approx(by_impact_law(hit, STEPS), rel=0.01)
    assert 0.95 * falls_past(speed) < of_exact(hit) < falls_past(speed)


@pytest.mark.parametrize("speed", [0.5, 1.0, 1.5])
def test_a_plank_that_comes_broadside_follows_onto_the_planks_below_and_stops_there(speed: float) -> None:
    """They carry it, friction brakes both: so the other goes less far than if the thrown one fell past."""
    assert shift(speed) < 0.9 * falls_past(speed)
    assert of_exact(TurnedHit(90.0, speed, above=0.0)) == pytest.approx(shift(speed), rel=0.01)


@pytest.mark.parametrize(
    ("turn", "speed"), [(85.0, 1.0), (60.0, 0.5), (60.0, 1.0), (45.0, 1.0), (0.0, 2.0), (90.0, 4.0)]
)
def test_a_turned_plank_moves_what_it_hits_as_far_as_the_impact_law_says(turn: float, speed: float) -> None:
    hit = TurnedHit(turn, speed)
    assert of_exact(hit) == pytest.approx(by_impact_law(hit, STEPS), rel=0.03)


def test_a_plank_that_is_aimed_a_hair_too_low_catches_the_planks_below() -> None:
    """It moves them all and shares its momentum with three: a quarter of the way. One that comes higher goes in."""
    lower, level = (TurnedHit(90.0, 1.0, above=above) for above in (-2e-4, 2e-4))
    assert of_exact(lower) < 0.3 * of_exact(level)
    assert of_exact(lower) == pytest.approx(by_impact_law(lower, STEPS), rel=0.03)


@pytest.mark.parametrize("turn", [90.0, 60.0])
@pytest.mark.parametrize("scene", [37.0, 90.0, 180.0])
def test_a_hit_does_not_depend_on_how_the_whole_scene_is_turned(scene: float, turn: float) -> None:
    here, turned = (of_exact(TurnedHit(turn, 1.0, levels=3, scene=angle)) for angle in (0.0, scene))
    assert turned == pytest.approx(here, rel=0.03)
