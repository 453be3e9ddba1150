"""Bricks in motion under loads on `exact`, against equations of motion integrated apart."""

from collections.abc import Callable
from math import cos, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.recording import Recorder, Track
from stackdsl.simulation.runner import play
from stackdsl.trace import BrickState, Trace
from tests.scenes import timeline_of

B, H, G, MU = 0.3, 0.9, 9.81, 0.5
M = 200.0 * B * 0.4 * H
BLOCK = "- bricks: [{name: block, at: [0 m, 0 m, 0.45 m]}]"
BEGINS = 0.5  # [s]


def played(
    load: str, build: str = BLOCK, more: str = "", friction: float = MU, watch: float = 0.6
) -> tuple[Trace, Track]:
    """Return the trace of a run, and the poses of the block."""
    scene = f"\nbrick: {{size: [{B} m, 0.4 m, {H} m], density: 200 kg/m3}}\nfriction: {friction}\nwatch: {watch} s"
    recorder = Recorder()
    rest = f"{scene}\nloads: [{{{load}, brick: block, at: {BEGINS} s}}]\nexpect: [stands: all]\n{more}"
    trace = play(timeline_of(build, rest), system_named("exact"), recorder=recorder)
    return trace, recorder.recording().track("block")


def test_a_block_does_not_move_under_a_load_that_it_bears() -> None:
    trace, _ = played(f"force: {0.49 * M * G} N, towards: 0 deg, point: [0 m, 0 m, -0.4 m]")
    assert trace.cost.steps == 0
    assert trace.tracks["block"].state is BrickState.FROZEN


@pytest.mark.parametrize(
    ("load", "axis", "acceleration"),
    [
        (f"force: {0.6 * M * G} N, towards: 0 deg, point: [0 m, 0 m, -0.4 m]", 0, 0.1 * G),
        (f"force: {0.8 * M * G} N, towards: 90 deg, point: [0 m, 0 m, -0.4 m]", 1, 0.3 * G),
        (f"force: {1.5 * M * G} N, towards: up", 2, 0.5 * G),
        (f"pressure: {-1.2 * M * G / (B * 0.4)} Pa, face: top", 2, 0.2 * G),
    ],
)
def test_a_block_slides_or_rises_with_the_excess_of_its_load(load: str, axis: int, acceleration: float) -> None:
    trace, track = played(load)
    since = np.maximum(track.times - BEGINS, 0.0)
    way = track.positions[:, axis] - track.positions[0, axis]
    assert way[-1] > 0.1
    # The first step is taken at once, so the motion may be ahead by a step of 2 ms.
    assert way == pytest.approx(0.5 * acceleration * since**2, abs=0.003 * acceleration * since[-1])
    assert trace.energy is None or trace.energy.gain == pytest.approx(0.0, abs=1e-9)


ARM = 0.35
WIND = 320.0  # [Pa]


@pytest.mark.parametrize(
    ("load", "torque"),
    [
        # a force keeps its direction and its point of the block
        (f"force: 70 N, towards: 0 deg, point: [0 m, 0 m, {ARM} m]", lambda a: 70.0 * _height(a, H / 2 + ARM)),
        # a pressure turns with its face
        (f"pressure: {WIND} Pa, face: 180 deg", lambda _: WIND * 0.4 * H * H / 2),
        ("moment: 60 N*m, about: 90 deg", lambda _: 60.0),
    ],
)
def test_a_block_tips_under_its_load(load: str, torque: Callable[[float], float]) -> None:
    trace, track = played(load, friction=1.5)
    leans = 2.0 * np.arctan2(track.orientations[:, 1], track.orientations[:, 3])
    assert trace.tracks["block"].state is BrickState.FALLEN
    inertia = M * (B**2 + H**2) / 3.0

    def motion(_: float, state: np.ndarray) -> tuple[float, float]:
        angle, speed = state
        weight = M * G * (-B / 2 * cos(angle) + H / 2 * sin(angle))
        return speed, (torque(angle) + weight) / inertia

    tipping = (leans > 0.05) & (leans < 0.6)
    assert tipping.sum() > 5
    found = solve_ivp(motion, (0.0, 2.0), (0.0, 0.0), rtol=1e-10, atol=1e-12, dense_output=True)
    expected = found.sol(track.times[tipping] - BEGINS)[0]
    assert leans[tipping] == pytest.approx(expected, rel=0.02)


def _height(angle: float, at: float) -> float:
    """Return the height of a point of the left face above the ground while the block leans about its right edge."""
    return B / 2 * sin(angle) + at * cos(angle)


def test_a_load_turned_with_its_scene_moves_the_block_alike() -> None:
    turned = "- bricks: [{name: block, at: [0 m, 0 m, 0.45 m], rotate: [0 deg, 0 deg, 90 deg]}]"
    _, one = played(f"force: 70 N, towards: 0 deg, point: [0 m, 0 m, {ARM} m]")
    _, other = played(f"force: 70 N, towards: 90 deg, point: [0 m, 0 m, {ARM} m]", turned)
    assert other.positions[-1, 1] == pytest.approx(one.positions[-1, 0], rel=1e-4)


def test_a_block_that_a_push_shifts_comes_to_rest_under_its_load() -> None:
    """A load downwards adds friction: the block stops after v^2 m / (2 mu (m g + F))."""
    speed = 0.5
    push = f"impacts: [{{after: built + 1 s, push: {{brick: block, impulse: [{M * speed} N*s, 0 N*s, 0 N*s]}}}}]"
    trace, track = played(f"weight: {2 * M * G} N", more=push, friction=0.2, watch=2.0)
    assert trace.tracks["block"].frozen
    assert track.positions[-1, 0] == pytest.approx(speed**2 / (2 * 0.2 * 3 * G), rel=0.04)
