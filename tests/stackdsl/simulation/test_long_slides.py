"""What slides far without an engine: it meets what was not near when it began, and feels what is done to it."""

from functools import cache
from math import cos, hypot, radians, sin

import pytest

from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.trace import Trace
from tests.scenes import timeline_of

G, SLOPE, FRICTION = 9.81, radians(11.25), 0.1
SIZE, DENSITY = (0.05, 0.04, 0.06), 8000.0
MASS = DENSITY * SIZE[0] * SIZE[1] * SIZE[2]


@cache
def slid(rest: str, *others: str) -> Trace:
    """A block that slides down a slope, among others that hold on to it."""
    block = "{name: block, on: ground, brick: {size: [50 mm, 40 mm, 60 mm], density: 8000 kg/m3}}"
    holds = "friction: {between: [{pair: [fixed, ground], friction: 0.9}]}, " if others else ""
    head = f"friction: {FRICTION}\nworld: {{{holds}tilt: {{angle: 11.25 deg, towards: 0 deg}}}}\n"
    bricks = "\n".join(f"    - {each}" for each in (block, *others))
    return play(timeline_of(f"- bricks:\n{bricks}", head + rest), SYSTEMS["exact"])


@pytest.mark.parametrize("offset", [pytest.param(0.4, marks=pytest.mark.slow), 0.8, 1.3])
def test_what_slides_stops_at_what_was_far_away_when_it_began(offset: float) -> None:
    #  \   block -> ........ |fixed|
    size = "{size: [200 mm, 400 mm, 100 mm], density: 8000 kg/m3}"
    fixed = f"{{name: fixed, on: ground, offset: [{1000.0 * offset} mm, 0 m, 0 m], brick: {size}}}"
    trace = slid("watch: 3 s\nexpect: [{penetration: <= 1 mm}]", fixed)
    assert trace.tracks["block"].shift == pytest.approx(offset - 0.5 * (0.2 + SIZE[0]), abs=1e-3)
    assert trace.tracks["fixed"].shift < 1e-3
    assert trace.penetration is not None
    assert trace.penetration.depth < 0.01 * SIZE[0]


@pytest.mark.parametrize("at", [pytest.param(0.3, marks=pytest.mark.slow), 1.14])
def test_what_slides_far_is_pushed_aside_as_near_where_it_began(at: float) -> None:
    impulse = 2.0
    trace = slid(
        f"watch: 0.3 s\nimpacts: [{{at: {at} s, push: {{brick: block, impulse: [0 N*s, {impulse} N*s, 0 N*s]}}}}]"
    )
    seconds = trace.cost.simulated_time
    aside = integrated(at, impulse / MASS, seconds)
    assert trace.tracks["block"].shift == pytest.approx(hypot(*aside), rel=0.01)
    assert aside[1] > 0.2  # it is seen in the shift


def integrated(at: float, push: float, until: float) -> tuple[float, float]:
    """How far it gets down and across the slope [m]: Newton and Coulomb in small steps."""
    step, x, y, vx, vy, time = 1e-5, 0.0, 0.0, 0.0, 0.0, 0.0
    pushed = False
    while time < until:
        if not pushed and time >= at:
            vy, pushed = push, True
        speed = hypot(vx, vy) or 1.0
        held = FRICTION * G * cos(SLOPE) * step / speed
        vx, vy = vx + G * sin(SLOPE) * step - held * (vx or 1.0), vy - held * vy
        x, y, time = x + vx * step, y + vy * step, time + step
    return x, y
