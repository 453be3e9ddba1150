"""Bricks on ground that moves as a record, against Housner's equation integrated apart, and closed forms of Newmark."""

from collections.abc import Sequence
from itertools import pairwise
from math import atan2, cos, hypot, sin
from pathlib import Path

import pytest

from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.trace import RunVerdict, Trace
from tests.records import at2, csv, shaken, wavelet

GRAVITY = 9.81
STEP = 0.005


def played(folder: Path, files: dict[str, str], shake: str, brick: str, rest: str) -> Trace:
    return play(shaken(folder, files, shake, brick, rest), system_named("exact"))


def housner(accelerations: Sequence[float], base: float, height: float) -> tuple[bool, float]:
    """Return if a rocking block overturns on ground with accelerations in steps of `STEP`, and its largest tilt [rad].

    Housner (1963): I t'' = -m g R sin(a - |t|) sgn(t) - m a_g R cos(a - |t|), with I = 4/3 m R^2 for a rectangle, and
    the speed times 1 - 1.5 sin(a)^2 whenever the block passes its base.
    """
    slenderness, rate = atan2(base, height), 3.0 * GRAVITY / (2.0 * hypot(base, height))
    dt, tilt, speed, side, most = 2e-5, 0.0, 0.0, 0, 0.0
    for before, after in pairwise([*accelerations, *[0.0] * round(2.0 / STEP)]):
        for number in range(steps := round(STEP / dt)):
            ground = before + (after - before) * number / steps
            if side == 0:
                if abs(ground) <= GRAVITY * base / height:
                    continue
                side = -1 if ground > 0.0 else 1
            left = slenderness - side * tilt
            speed -= rate * (side * sin(left) + ground / GRAVITY * cos(left)) * dt
            tilt += speed * dt
            most = max(most, abs(tilt))
            if abs(tilt) > 1.2:
                return True, most
            if tilt * side < 0.0:
                speed, tilt, side = speed * (1.0 - 1.5 * sin(slenderness) ** 2), 0.0, -side
                side = 0 if abs(speed) < 1e-3 else side
    return False, most


@pytest.mark.parametrize("peak", [3.0, 4.0, 6.0])
def test_a_block_rocks_under_a_record_as_far_as_housner_has_it_or_overturns(tmp_path: Path, peak: float) -> None:
    accelerations = wavelet(peak, STEP)
    falls, tilt = housner(accelerations, 0.1, 0.5)
    brick = "{size: [100 mm, 100 mm, 500 mm], mass: 500 g}"
    scaled = f"file: r.at2, scale: {peak / 2.0}"
    trace = played(tmp_path, {"r.at2": at2(wavelet(2.0, STEP), STEP)}, scaled, brick, "friction: 0.9\nwatch: 2 s")
    assert falls == (peak == 6.0)
    assert (trace.verdict is RunVerdict.COLLAPSES) is falls
    if not falls:
        assert trace.tracks["L1.1"].tilt == pytest.approx(tilt, rel=0.03)


def box(base: float, height: float) -> str:
    return f"{{size: [{base} mm, {base} mm, {height} mm], mass: 500 g}}"


def table(along: float, across: float, up: float, duration: float) -> str:
    """A rectangular pulse of all components [m/s2]."""
    return csv("time [s],along [m/s2],across [m/s2],up [m/s2]", [(t, along, across, up) for t in (0.0, duration)])


@pytest.mark.parametrize("up", [-4.0, 3.0])
@pytest.mark.parametrize("share", [0.995, 1.005])
def test_ground_that_rises_faster_holds_a_block_by_so_much_more_friction(
    tmp_path: Path, up: float, share: float
) -> None:
    most = share * 0.3 * (GRAVITY + up)
    files = {"r.csv": table(0.6 * most, 0.8 * most, up, 0.3)}
    trace = played(tmp_path, files, "file: r.csv", box(100, 40), "friction: 0.3")
    assert (trace.cost.steps == 0) is (share < 1.0)


@pytest.mark.parametrize("share", [0.995, 1.005])
def test_ground_that_sinks_tips_a_block_by_so_much_less(tmp_path: Path, share: float) -> None:
    files = {"r.csv": table(0.0, share * 0.2 * (GRAVITY - 3.0), -3.0, 3.0)}
    trace = played(tmp_path, files, "file: r.csv, bearing: 40 deg", box(20, 100), "friction: 0.9")
    # The upright accelerations are those of both axes of the square base, so the edges are at the bearing.
    assert (trace.cost.steps == 0) is (share < cosine_of_edge(40.0))


def cosine_of_edge(bearing: float) -> float:
    """Return how much more a square base bears towards a bearing [deg] than across its edge."""
    angle = bearing * 3.141592653589793 / 180.0
    return 1.0 / max(abs(cos(angle)), abs(sin(angle)))


@pytest.mark.parametrize(("along", "across", "up"), [(5.0, 6.0, 0.0), (5.0, 6.0, 4.0), (0.0, 8.0, 0.0)])
def test_newmarks_block_slides_along_both_components_and_less_on_rising_ground(
    tmp_path: Path, along: float, across: float, up: float
) -> None:
    mu, duration = 0.4, 0.2
    files = {"r.csv": table(along, across, up, duration)}
    trace = played(tmp_path, files, "file: r.csv, bearing: 30 deg", box(100, 40), f"friction: {mu}")
    size = hypot(along, across)
    beyond = size - mu * (GRAVITY + up)
    way = 0.5 * beyond * duration**2 * (1.0 + beyond / (mu * GRAVITY))
    direction = atan2(across, along) + 30.0 * 3.141592653589793 / 180.0
    assert trace.energy is not None
    assert trace.energy.gain < 0.01
    x, y, _ = trace.tracks["L1.1"].final.position_W
    assert (x, y) == pytest.approx((-way * cos(direction), -way * sin(direction)), rel=0.03)


def test_a_block_leaves_ground_that_sinks_faster_than_it_falls_and_lands_on_it(tmp_path: Path) -> None:
    rows = [(0.0, 0.0, -15.0), (0.1, 0.0, -15.0), (0.1, 0.0, 5.0), (0.4, 0.0, 5.0)]
    files = {"r.csv": csv("time [s],along [m/s2],up [m/s2]", rows)}
    trace = played(tmp_path, files, "file: r.csv", box(100, 40), "watch: 1 s")
    assert trace.cost.steps > 0
    assert trace.verdict is RunVerdict.STANDS
    assert trace.tracks["L1.1"].final.position_W[2] == pytest.approx(0.02, abs=1e-4)


def test_loaded_bricks_are_simulated_on_rising_ground_since_their_loads_do_not_grow_with_it(tmp_path: Path) -> None:
    load = "friction: 0.3\nloads: [{brick: L1.1, weight: 5 kg, at: 0 s}]"
    trace = played(tmp_path, {"r.csv": table(0.5, 0.0, 1.0, 0.1)}, "file: r.csv, at: 1 s", box(100, 40), load)
    assert trace.cost.steps > 0
    assert trace.verdict is RunVerdict.STANDS


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_glued_block_bears_both_components_up_to_the_strength_of_its_joint(tmp_path: Path, share: float) -> None:
    #   The block tips over an edge at (g + f A / m) b / h, where the glue pulls with f on the whole of its base A.
    limit = (GRAVITY + 2000.0 * 0.1 * 0.1 / 0.5) * 100.0 / 400.0
    most = share * limit / 0.8  # towards the nearer axis, whose part is 0.8
    files = {"r.csv": table(0.6 * most, 0.8 * most, 0.0, 0.05)}
    glue = "joints: [{of: [L1.1, ground], bond: {tension: 2 kPa, cohesion: 1 MPa}}]"
    trace = played(tmp_path, files, "file: r.csv", box(100, 400), f"friction: 0.9\n{glue}")
    assert (trace.cost.steps == 0) is (share < 1.0)


def test_a_record_from_another_bearing_leaves_a_block_turned_as_much(tmp_path: Path) -> None:
    files = {"r.csv": table(6.0, 2.0, 1.5, 0.15)}
    ways = []
    for bearing in (0, 90):
        trace = played(tmp_path, files, f"file: r.csv, bearing: {bearing} deg", box(100, 40), "friction: 0.4")
        ways.append(trace.tracks["L1.1"].final.position_W[:2])
    assert ways[1] == pytest.approx((-ways[0][1], ways[0][0]), abs=1e-5)
