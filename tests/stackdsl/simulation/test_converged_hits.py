"""A hit on a tower under `exact` agrees with the same tower in small steps, every plank awake."""

from dataclasses import replace

import pytest

from benchmarks.hits import shifts, timeline
from benchmarks.impacts import FROM_SIDE, LEVELS, Throw
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import MOVING, SYSTEMS, System

AWAKE = System("awake", "", replace(MOVING, time_step=1.0 / 1920.0, first_steps=0), None)


@pytest.mark.slow
@pytest.mark.parametrize(("level", "speed"), [(3, 2.0), (LEVELS, 1.0)])
def test_a_plank_that_is_hit_on_its_side_moves_as_far_as_with_all_awake(level: int, speed: float) -> None:
    throw = Throw(level, FROM_SIDE, speed)
    exact, awake = (shifts(play(timeline(throw), system))[throw.hit] for system in (SYSTEMS["exact"], AWAKE))
    assert exact == pytest.approx(awake, rel=0.08)
