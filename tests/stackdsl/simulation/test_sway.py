"""Sway: oscillations of known amplitude and frequency, and motions that are no oscillation."""

from collections.abc import Callable
from math import acos, pi, sin, sqrt

import pytest

from stability.geometry.box import Box
from stability.model import BodyState, Brick, Pose
from stackdsl.simulation.brick_tracks import BrickTracker
from stackdsl.simulation.measurements import TREMBLE, SwayMeter
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Arrival, Placement
from stackdsl.trace import Sway
from tests.scenes import timeline_of

SIZE = (0.1176, 0.0234, 0.0078)  # [m]
LOOK = 0.01  # [s]


def swayed(way: Callable[[float], float], seconds: float = 3.0, arrival: Arrival = Arrival.SET_DOWN) -> Sway | None:
    """What is told of a plank that goes so along x, from where it was set down."""
    watch = BrickTracker()
    watch.add(Placement(0.0, Brick("a", Box(SIZE), 0.012), 1, Pose((way(0.0), 0.0, 0.0039)), arrival))
    meter = SwayMeter(watch)
    for look in range(1, round(seconds / LOOK) + 1):
        states = {"a": BodyState(Pose((way(look * LOOK), 0.0, 0.0039)))}
        watch.see(look * LOOK, states)
        meter.see(look * LOOK, states)
    return meter.sway


def found(way: Callable[[float], float], seconds: float = 3.0) -> Sway:
    sway = swayed(way, seconds)
    assert sway is not None
    return sway


@pytest.mark.parametrize("frequency", [0.5, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("amplitude", [1e-5, 1e-3])
def test_an_oscillation_is_told_with_its_amplitude_and_its_frequency(amplitude: float, frequency: float) -> None:
    sway = found(lambda t: amplitude * sin(2.0 * pi * frequency * t), seconds=3.0 / frequency)
    assert sway.amplitude == pytest.approx(
        amplitude, rel=0.5 * (pi * frequency * LOOK) ** 2 + 1e-9
    )  # looks miss the peak
    assert 1.0 / sway.frequency == pytest.approx(1.0 / frequency, abs=2.0 * LOOK)
    assert sway.brick == "a"


def test_of_an_oscillation_that_grows_the_largest_swing_is_told() -> None:
    sway = found(lambda t: 1e-3 * t / 3.0 * sin(2.0 * pi * 2.0 * t))
    assert sway.amplitude == pytest.approx(
        1e-3 * (2.375 + 2.625) / 2.0 / 3.0, rel=0.01
    )  # it turns there, and comes back
    assert sway.time > 2.5


@pytest.mark.parametrize("creep", [0.1, 0.5, 0.9])
def test_creep_beside_it_takes_away_what_it_does_not_come_back(creep: float) -> None:
    #   A sin(w t) + k A w t turns where cos(w t) = -k; the way back is 2 A (sqrt(1 - k^2) - k acos(k)).
    amplitude, pulse = 1e-3, 2.0 * pi
    sway = found(lambda t: amplitude * sin(pulse * t) + creep * amplitude * pulse * t, seconds=2.5)
    assert sway.amplitude == pytest.approx(amplitude * (sqrt(1.0 - creep**2) - creep * acos(creep)), rel=0.02)


@pytest.mark.parametrize(
    "way",
    [
        lambda t: 1e-3 * t,  # creep
        lambda t: 1e-3 if t > 1.0 else 0.0,  # shifted once
        lambda t: 0.45 * TREMBLE * SIZE[2] * (-1.0) ** round(t / LOOK),  # the last digits tremble
        lambda t: 1e-5 * t + 0.4 * TREMBLE * SIZE[2] * (-1.0) ** round(t / LOOK),
        lambda t: 0.0,
    ],
    ids=["creep", "shift", "tremble", "tremble while it creeps", "rest"],
)
def test_a_motion_without_return_is_no_sway(way: Callable[[float], float]) -> None:
    assert swayed(way) is None


def test_the_sway_of_one_swing_is_half_its_range() -> None:
    assert found(lambda t: 1e-3 * max(0.0, sin(pi * t)) if t < 1.0 else 0.0).amplitude == pytest.approx(5e-4, rel=0.01)


def test_nothing_sways_that_flies_by() -> None:
    assert swayed(lambda t: 1e-3 * sin(2.0 * pi * t), arrival=Arrival.THROWN) is None


def test_a_falling_brick_does_not_sway() -> None:
    sway = found(lambda t: 1e-3 * sin(2.0 * pi * t) if t < 1.5 else 0.02 * sin(2.0 * pi * t))
    assert sway.amplitude == pytest.approx(1e-3, rel=0.01)


def test_a_tower_that_is_proven_does_not_sway_and_one_in_an_engine_as_it_comes_does() -> None:
    tower = timeline_of(
        "- four_stack: {levels: 4}\n  every: 1 s", "brick: kapla\nexpect: [sway: {amplitude: <= 0 mm}]\n"
    )
    assert play(tower, SYSTEMS["exact"]).sway is None
    sway = play(tower, SYSTEMS["stock"]).sway
    assert sway is not None
    assert 1e-6 < sway.amplitude < 1e-3  # [m]


def test_sway_is_not_measured_where_nobody_asks() -> None:
    tower = timeline_of("- four_stack: {levels: 4}\n  every: 1 s", "brick: kapla\nexpect: [stands: all]\n")
    assert play(tower, SYSTEMS["stock"]).sway is None
