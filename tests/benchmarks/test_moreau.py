"""The reference for hits meets the closed forms of rigid bodies, by itself."""

import pytest

pytest.importorskip("numba")

from benchmarks.end_hits import EndHit, referred, timeline
from benchmarks.hits import shifts
from benchmarks.moreau.motion import Boxes
from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Placed
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS

pytestmark = pytest.mark.slow  # numba compiles it for a minute

STEP, GRAVITY, FRICTION = 1.0 / 4000.0, 9.81, 0.5
SIDE, MASS = 0.02, 0.01


def cube(name: str, x: float, mass: float = MASS, z: float = 0.5 * SIDE) -> Placed:
    return Placed(Brick(name, Box((SIDE, SIDE, SIDE)), mass), Pose((x, 0.0, z)))


def test_a_box_slides_by_v_squared_over_two_mu_g() -> None:
    boxes = Boxes([cube("a", 0.0)], GRAVITY, FRICTION)
    boxes.throw(0, (0.5, 0.0, 0.0))
    for _ in range(800):
        boxes.step(STEP)
    assert boxes.places[0, 0] == pytest.approx(0.5**2 / (2.0 * FRICTION * GRAVITY), rel=0.01)


@pytest.mark.parametrize("mass", [MASS, 3.0 * MASS])
def test_two_boxes_that_meet_go_on_at_the_speed_of_their_momentum(mass: float) -> None:
    boxes = Boxes([cube("a", 0.0), cube("b", 0.021, mass)], 0.0, FRICTION)
    boxes.throw(0, (2.0, 0.0, 0.0))
    for _ in range(20):
        boxes.step(STEP)
    # Of the whole nothing is lost; contacts have the stiffness of wood, and what that gives back parts them a little.
    assert MASS * boxes.speeds[0, 0] + mass * boxes.speeds[1, 0] == pytest.approx(2.0 * MASS, rel=1e-6)
    assert boxes.speeds[:, 0] == pytest.approx([2.0 * MASS / (MASS + mass)] * 2, rel=0.01)


def test_a_box_that_falls_does_not_rebound() -> None:
    boxes = Boxes([cube("a", 0.0, z=0.5 * SIDE + 0.05)], GRAVITY, FRICTION)
    highest_after = 0.0
    for number in range(1200):
        boxes.step(STEP)
        if number * STEP > 0.11:  # it falls for sqrt(2 h / g) = 0.101 s
            highest_after = max(highest_after, float(boxes.places[0, 2]))
    assert highest_after == pytest.approx(0.5 * SIDE, abs=2e-6)


def test_a_hit_that_is_level_to_the_last_digit_is_sensitive() -> None:
    """Whether the thrown plank goes in between the planks below and above, or catches one, is for a hair to say."""
    level, lower, higher = (referred(EndHit(2.0, above=above), 2000) for above in (0.0, -1e-5, 1e-5))
    assert level > 1.3 * max(lower, higher)
    assert lower == pytest.approx(higher, rel=0.1)


@pytest.mark.parametrize("speed", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("above", [-2e-3, -2e-4, 2e-4, 2e-3])
def test_a_plank_that_is_hit_on_its_end_moves_as_far_as_the_impact_law_says(speed: float, above: float) -> None:
    hit = EndHit(speed, above=above)
    assert shifts(play(timeline(hit), SYSTEMS["exact"]))[5] == pytest.approx(referred(hit, 8000), rel=0.06)
