"""Round bricks that are shaken, pushed, thrown and moved by hands on `exact`, against closed forms."""

import re
from math import cos, hypot, pi, sin

import pytest

from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.trace import BrickState, EventKind, RunVerdict, Trace
from tests.scenes import timeline_of

GRAVITY = 9.81
RADIUS, HEIGHT = 0.03, 0.1  # of the can [m]
CAN = "{cylinder: {diameter: 60 mm, height: 100 mm}, mass: 300 g}"
PUCK = "{cylinder: {diameter: 120 mm, height: 30 mm}, mass: 300 g}"
# Moment of inertia about the axis of rolling, as a share of m r^2.
ROLLING = {
    "ball": ("{sphere: 100 mm, mass: 500 g}", "0 deg", 0.4),
    "log": ("{cylinder: {diameter: 100 mm, height: 200 mm}, mass: 500 g}", "90 deg", 0.5),
}


def played(build: str, rest: str = "") -> Trace:
    return play(timeline_of(build, f"{rest}\nexpect: [energy: {{gain: <= 1 %}}]"), system_named("exact"))


def standing(brick: str, height: float) -> str:
    return f"- bricks: [{{name: it, at: [0 mm, 0 mm, {500.0 * height} mm], brick: {brick}}}]"


def lying(name: str) -> str:
    brick, turn, _ = ROLLING[name]
    return f"- bricks: [{{name: it, at: [0 mm, 0 mm, 50 mm], rotate: [{turn}, 0 deg, 0 deg], brick: {brick}}}]"


def pulse(acceleration: float, duration: float, bearing: float = 0.0) -> str:
    table = f"[[0 s, {acceleration} m/s2], [{duration} s, {acceleration} m/s2]]"
    return f"world: {{shake: {{bearing: {bearing} deg, table: {table}}}}}"


def way(trace: Trace, bearing: float = 0.0, name: str = "it") -> float:
    """Return the displacement of a brick along a bearing [deg] from its place to its end [m]."""
    (x, y, _), (start_x, start_y, _) = (trace.tracks[name].final.position_W, trace.tracks[name].placed.position_W)
    return (x - start_x) * cos(bearing * pi / 180.0) + (y - start_y) * sin(bearing * pi / 180.0)


# --- shaken -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bearing", [0.0, 17.0])
def test_a_can_goes_with_the_ground_below_its_diameter_over_its_height_and_is_never_simulated(bearing: float) -> None:
    trace = played(
        standing(CAN, HEIGHT), f"friction: 0.9\n{pulse(0.99 * 2.0 * RADIUS / HEIGHT * GRAVITY, 1.0, bearing)}"
    )
    assert trace.cost.steps == 0
    assert trace.tracks["it"].state is BrickState.FROZEN


@pytest.mark.parametrize("bearing", [0.0, 17.0])
def test_a_can_tips_over_under_a_long_pulse_just_above_it(bearing: float) -> None:
    trace = played(
        standing(CAN, HEIGHT), f"friction: 0.9\n{pulse(1.05 * 2.0 * RADIUS / HEIGHT * GRAVITY, 1.0, bearing)}"
    )
    assert trace.tracks["it"].state is BrickState.FALLEN
    assert way(trace, bearing) < 0.0  # against the ground


@pytest.mark.parametrize("bearing", [0.0, 200.0])
def test_a_puck_slides_as_newmarks_block(bearing: float) -> None:
    mu, acceleration, duration = 0.4, 8.0, 0.2
    trace = played(standing(PUCK, 0.03), f"friction: {mu}\n{pulse(acceleration, duration, bearing)}")
    beyond = acceleration - mu * GRAVITY
    expected = 0.5 * beyond * duration**2 * (1.0 + beyond / (mu * GRAVITY))
    assert way(trace, bearing) == pytest.approx(-expected, rel=0.03)
    assert trace.verdict is RunVerdict.STANDS


@pytest.mark.parametrize("name", ROLLING)
def test_what_rolls_lags_behind_the_ground_by_one_over_one_plus_its_inertia(name: str) -> None:
    """Friction F moves it by F / m and turns it by F r / I, so its relative acceleration is - a / (1 + I / m r^2)."""
    acceleration, duration, inertia = 3.0, 0.3, ROLLING[name][2]
    trace = played(lying(name), f"friction: 0.9\nwatch: 0.2 s\n{pulse(acceleration, duration)}")
    lag = acceleration / (1.0 + inertia)
    after = trace.cost.simulated_time - duration
    assert way(trace) == pytest.approx(-(0.5 * lag * duration**2 + lag * duration * after), rel=0.02)


# --- pushed -----------------------------------------------------------------------------------------------------------


def test_a_pushed_puck_slides_its_speed_squared_over_twice_its_friction() -> None:
    speed, mu = 1.0, 0.4
    push = f"impacts: [{{after: built + 0.1 s, push: {{brick: it, impulse: [{0.3 * speed} N*s, 0 N*s, 0 N*s]}}}}]"
    trace = played(standing(PUCK, 0.03), f"friction: {mu}\n{push}")
    assert way(trace) == pytest.approx(speed**2 / (2.0 * mu * GRAVITY), rel=0.02)
    assert trace.verdict is RunVerdict.STANDS


# --- thrown -----------------------------------------------------------------------------------------------------------


def test_a_thrown_ball_arrives_at_the_speed_of_its_parabola() -> None:
    """From the distance d at the speed v it arrives with g d / 2 v downwards; `d` is that of the surfaces."""
    block = "- bricks: [{name: block, on: ground, brick: {size: [200 mm, 200 mm, 200 mm], mass: 20 kg}}]"
    throw = (
        "impacts: [{after: built + 0.1 s, throw: {brick: {sphere: 60 mm, mass: 60 g}, name: ball, at: block, "
        "from: {bearing: 180 deg, distance: 0.5 m}, speed: 3 m/s}}]"
    )
    trace = played(block, f"friction: 0.5\nwatch: 0.5 s\n{throw}")
    (hit,) = [event for event in trace.events if event.kind is EventKind.HIT and "block" in event.reason]
    (speed, *_) = re.findall(r"at ([\d.]+) m/s", hit.reason)
    assert float(speed) == pytest.approx(hypot(3.0, GRAVITY * 0.5 / 6.0), rel=5e-3)
    assert trace.tracks["block"].state is BrickState.FROZEN or trace.tracks["block"].shift < 1e-4


# --- moved by hands ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bearing", [0.0, 35.0])
def test_a_hand_moves_a_can_and_what_stands_on_it_as_far_as_it_goes(bearing: float) -> None:
    stack = (
        f"- bricks: [{{name: it, at: [0 mm, 0 mm, 50 mm], brick: {CAN}}}, "
        f"{{name: top, at: [0 mm, 0 mm, 150 mm], brick: {CAN}}}]"
    )
    by = f"[{40.0 * cos(bearing * pi / 180.0)} mm, {40.0 * sin(bearing * pi / 180.0)} mm, 0 mm]"
    trace = played(stack, f"friction: 0.6\nwatch: 0.3 s\nimpacts: [move: {{brick: it, by: {by}}}]")
    assert [way(trace, bearing, name) for name in ("it", "top")] == pytest.approx([0.04, 0.04], abs=1e-4)
    assert trace.verdict is RunVerdict.STANDS


def test_a_can_that_a_hand_takes_away_lets_the_one_above_fall_by_its_height() -> None:
    stack = (
        f"- bricks: [{{name: it, at: [0 mm, 0 mm, 50 mm], brick: {CAN}}}, "
        f"{{name: top, at: [0 mm, 0 mm, 150 mm], brick: {CAN}}}]"
    )
    trace = played(stack, "friction: 0.6\nwatch: 1 s\nimpacts: [remove: {brick: it}]")
    drop = trace.tracks["top"].placed.position_W[2] - trace.tracks["top"].final.position_W[2]
    assert drop == pytest.approx(HEIGHT, abs=1e-3)
