"""Shaken ground against closed forms: what slides (Newmark), rocks and overturns (Housner), stands, and falls."""

from math import acosh, asin, cos, degrees, hypot, pi, sin, sqrt

import pytest

from stackdsl.simulation.known_systems import missing, system_named
from stackdsl.simulation.runner import play
from stackdsl.trace import BrickState, RunVerdict, Trace
from tests.engines_at_hand import PEERS
from tests.scenes import timeline_of

GRAVITY = 9.81
ENGINES = [
    "exact",
    "tuned",
    *(
        pytest.param(peer, marks=pytest.mark.skipif(bool(missing([peer])), reason=f"{peer} is not installed"))
        for peer in PEERS
    ),
]


def shaken(build: str, shake: str, system: str = "exact", rest: str = "") -> Trace:
    world = f"world: {{shake: {{{shake}}}}}"
    return play(timeline_of(build, f"{world}\n{rest}\nexpect: [energy: {{gain: <= 1 %}}]"), system_named(system))


def block(base: float, height: float) -> str:
    """A block with a square base, in mm."""
    size = f"{{size: [{base} mm, {base} mm, {height} mm], mass: 500 g}}"
    return f"- bricks: [{{name: block, at: [0 mm, 0 mm, {height / 2} mm], brick: {size}}}]"


def pulse(acceleration: float, duration: float, bearing: float = 0.0) -> str:
    table = f"[[0 s, {acceleration} m/s2], [{duration} s, {acceleration} m/s2]]"
    return f"bearing: {bearing} deg, table: {table}"


def way_along(trace: Trace, name: str, bearing: float) -> float:
    """How far a brick ends along a bearing from where it was placed [m]."""
    (x, y, _), (start_x, start_y, _) = (trace.tracks[name].final.position_W, trace.tracks[name].placed.position_W)
    return (x - start_x) * cos(bearing * pi / 180.0) + (y - start_y) * sin(bearing * pi / 180.0)


# --- a block slides where the ground accelerates by more than mu g ----------------------------------------------------


@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_below_the_limit_of_friction_a_block_goes_with_the_ground_and_no_engine_is_asked(mu: float) -> None:
    trace = shaken(block(100, 40), pulse(0.999 * mu * GRAVITY, 0.5, 30), rest=f"friction: {mu}")
    assert trace.cost.steps == 0
    assert trace.drift == 0.0
    assert trace.tracks["block"].state is BrickState.FROZEN


@pytest.mark.parametrize("system", ENGINES)
@pytest.mark.parametrize("bearing", [0.0, 200.0])
def test_beyond_it_newmarks_block_slides_as_far_as_the_pulse_leaves_it_behind(system: str, bearing: float) -> None:
    #   It loses (a - mu g) t of speed against the ground, and gets it back at mu g.
    mu, acceleration, duration = 0.4, 8.0, 0.2
    trace = shaken(block(100, 40), pulse(acceleration, duration, bearing), system, f"friction: {mu}")
    beyond = acceleration - mu * GRAVITY
    way = 0.5 * beyond * duration**2 * (1.0 + beyond / (mu * GRAVITY))
    assert way_along(trace, "block", bearing) == pytest.approx(-way, rel=0.03)
    assert trace.tracks["block"].state is BrickState.DISPLACED
    assert trace.verdict is RunVerdict.STANDS


@pytest.mark.parametrize("system", ENGINES)
def test_half_a_sine_slides_a_block_from_where_it_passes_the_limit(system: str) -> None:
    mu, most, frequency = 0.3, 9.0, 2.0
    rate, slope = 2.0 * pi * frequency, mu * GRAVITY
    begins, ends = asin(slope / most) / rate, 0.5 / frequency
    speed = most / rate * (cos(rate * begins) + 1.0) - slope * (ends - begins)
    way = most / rate * ((ends - begins) * cos(rate * begins) + sin(rate * begins) / rate)
    way += -0.5 * slope * (ends - begins) ** 2 + speed**2 / (2.0 * slope)
    sine = f"acceleration: {most} m/s2, frequency: {frequency} Hz, for: {ends} s"
    trace = shaken(block(100, 40), sine, system, f"friction: {mu}")
    assert way_along(trace, "block", 0.0) == pytest.approx(-way, rel=0.03)


def newmark(most: float, frequency: float, duration: float, slope: float) -> float:
    """Where a rigid block ends that slides on ground shaken as a sine: Coulomb's law in steps of 5 us [m]."""
    step, speed, way, time = 5e-6, 0.0, 0.0, 0.0
    while time < duration or speed != 0.0:
        pull = -most * sin(2.0 * pi * frequency * (time + 0.5 * step)) if time < duration else 0.0
        if speed == 0.0 and abs(pull) <= slope:
            time += step
            continue
        against = slope if (speed or pull) > 0.0 else -slope
        after = speed + (pull - against) * step
        after = 0.0 if speed * after < 0.0 else after
        way, speed, time = way + 0.5 * (speed + after) * step, after, time + step
    return way


@pytest.mark.parametrize(("frequency", "duration"), [(2.0, 0.75), (1.0, 1.5)])
def test_a_block_that_sticks_and_slips_to_and_fro_ends_where_coulomb_has_it(frequency: float, duration: float) -> None:
    mu, most = 0.4, 7.0
    sine = f"acceleration: {most} m/s2, frequency: {frequency} Hz, for: {duration} s"
    trace = shaken(block(100, 40), sine, rest=f"friction: {mu}")
    assert way_along(trace, "block", 0.0) == pytest.approx(newmark(most, frequency, duration, mu * GRAVITY), rel=0.03)


def test_the_amplitude_of_a_sine_says_the_same_as_its_acceleration() -> None:
    acceleration = 0.02 * (2.0 * pi * 3.0) ** 2
    by = [
        "amplitude: 20 mm, frequency: 3 Hz, for: 0.5 s",
        f"acceleration: {acceleration!r} m/s2, frequency: 3 Hz, for: 0.5 s",
    ]
    first, second = (shaken(block(100, 40), sine, rest="friction: 0.3") for sine in by)
    assert way_along(first, "block", 0.0) != 0.0
    assert first.tracks["block"].final.position_W == pytest.approx(second.tracks["block"].final.position_W)


# --- a slender block tips where the ground accelerates by more than g b / h -----------------------------------------


def overturns_after(acceleration: float, base: float, height: float) -> float:
    """How long a pulse takes to overturn a slender block (Housner 1963) [s]; lengths in m."""
    ratio = acceleration / (GRAVITY * base / height)
    rate = sqrt(3.0 * GRAVITY / (2.0 * hypot(base, height)))
    return acosh(1.0 + 1.0 / (2.0 * ratio * (ratio - 1.0))) / rate


@pytest.mark.parametrize("system", ["exact", "tuned"])
@pytest.mark.parametrize("share", [0.98, 1.02])
def test_a_long_pulse_tips_a_block_just_beyond_its_slenderness(share: float, system: str) -> None:
    trace = shaken(block(20, 100), pulse(share * GRAVITY * 0.2, 2.0, 90), system, "friction: 0.9")
    assert trace.verdict is (RunVerdict.STANDS if share < 1.0 else RunVerdict.COLLAPSES)
    if share < 1.0 and system == "exact":
        assert trace.cost.steps == 0


@pytest.mark.parametrize("share", [0.95, 1.05])
@pytest.mark.parametrize("times", [1.5, 3.0])
def test_a_short_pulse_rocks_a_slender_block_and_a_longer_one_overturns_it(times: float, share: float) -> None:
    acceleration = times * GRAVITY * 0.1
    duration = share * overturns_after(acceleration, 0.02, 0.2)
    trace = shaken(block(20, 200), pulse(acceleration, duration), rest="friction: 0.9\nwatch: 3 s")
    assert (trace.verdict is RunVerdict.COLLAPSES) == (share > 1.0)


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_column_tips_as_one_where_its_weight_as_tilted_leaves_its_foot(share: float) -> None:
    #   Five cubes of 40 mm: g b / h = g / 5, and friction holds each on the next.
    size = "{size: [40 mm, 40 mm, 40 mm], mass: 50 g}"
    build = f"- brick: {size}\n  column: {{levels: 5}}"
    trace = shaken(build, pulse(share * GRAVITY / 5.0, 1.5, 180), rest="friction: 0.5")
    assert trace.verdict is (RunVerdict.STANDS if share < 1.0 else RunVerdict.COLLAPSES)
    assert (trace.cost.steps == 0) == (share < 1.0)


@pytest.mark.parametrize(("bearing", "stands"), [(0.0, True), (180.0, False)])
def test_an_overhanging_brick_bears_less_acceleration_away_from_its_overhang(bearing: float, stands: bool) -> None:
    #   A tall block 10 mm off its base tips at g / 10 over the edge that it hangs over, and at g / 5 over its own.
    flat, tall = "{size: [40 mm, 40 mm, 10 mm], mass: 50 g}", "{size: [40 mm, 40 mm, 200 mm], mass: 500 g}"
    build = (
        f"- bricks: [{{name: flat, at: [0 mm, 0 mm, 5 mm], brick: {flat}}},"
        f" {{name: tall, at: [10 mm, 0 mm, 110 mm], brick: {tall}}}]"
    )
    trace = shaken(build, pulse(0.15 * GRAVITY, 1.0, bearing))
    assert (trace.cost.steps == 0) is stands
    assert trace.verdict is (RunVerdict.STANDS if stands else RunVerdict.COLLAPSES)


def test_shaken_bricks_slide_first_where_friction_is_least() -> None:
    #   The top of three planks lies as rough as all others, and the ground is smooth.
    world = f"world: {{ground: {{friction: 0.1}}, shake: {{{pulse(0.15 * GRAVITY, 0.2)}}}}}"
    build = timeline_of("- column: {levels: 3}", f"{world}\nexpect: [energy: {{gain: <= 1 %}}]")
    trace = play(build, system_named("exact"))
    ways = [way_along(trace, f"L{level}.1", 0.0) for level in (1, 2, 3)]
    way = 0.5 * 0.05 * GRAVITY * 0.2**2 * 1.5
    assert ways == pytest.approx([-way, -way, -way], rel=0.03)


@pytest.mark.parametrize("levels", [1, 2])
def test_cartons_that_were_shaken_are_proven_again_as_soon_as_the_ground_is_still(levels: int) -> None:
    #   They slide by a tenth of a millimetre, and would be asked about again ten times 0.57 s after the first slip.
    carton = "{size: [400 mm, 300 mm, 250 mm], mass: 8 kg}"
    build = f"- brick: {carton}\n  column: {{levels: {levels}}}"
    sine = "acceleration: 4 m/s2, frequency: 2 Hz, for: 1 s"
    trace = shaken(build, sine, rest="friction: 0.4\nwatch: 1 s")
    assert trace.cost.steps > 0
    assert all(track.state is BrickState.FROZEN for track in trace.tracks.values())


# --- what else is done while it shakes --------------------------------------------------------------------------------


@pytest.mark.parametrize("system", ENGINES)
def test_a_falling_brick_is_left_behind_by_the_accelerating_ground(system: str) -> None:
    #   In the air all the time, 0.19 s from 200 mm up. What is known of falls without an engine is of ground at rest.
    build = "- bricks: [{name: a, at: [0 mm, 0 mm, 203.9 mm], drop: true}]"
    trace = play(timeline_of(build, f"world: {{shake: {{{pulse(4.0, 0.15)}}}}}\nwatch: 0.04 s"), system_named(system))
    assert trace.cost.simulated_time == pytest.approx(0.19, abs=1e-3)
    way = 0.5 * 4.0 * 0.15**2 + 4.0 * 0.15 * 0.04
    assert way_along(trace, "a", 0.0) == pytest.approx(-way, rel=0.02)


@pytest.mark.parametrize("system", ENGINES)
def test_the_work_of_the_ground_is_no_energy_that_an_engine_added(system: str) -> None:
    trace = shaken(block(100, 40), pulse(8.0, 0.3), system, "friction: 0.3")
    assert trace.energy is not None
    assert trace.energy.gain < 0.01
    assert trace.energy.of_what_moved > 0.5 * 0.5 * ((8.0 - 0.3 * GRAVITY) * 0.3) ** 2


def test_all_that_is_connected_is_woken_at_the_moment_when_the_limit_is_passed() -> None:
    sine = "acceleration: 6 m/s2, frequency: 1 Hz, for: 1 s"
    trace = shaken("- column: {levels: 3}", sine)
    woken = next(event for event in trace.events if event.kind.value == "woken")
    assert woken.bricks == ("L1.1", "L2.1", "L3.1")
    assert woken.time == pytest.approx(asin(0.5 * GRAVITY / 6.0) / (2.0 * pi), abs=1e-3)
    assert "ground acceleration outside the proven range, -4.9" in woken.reason
    assert degrees(trace.tracks["L3.1"].tilt) < 1.0


def test_a_structure_that_stands_on_its_own_beside_one_that_slides_is_left_in_peace() -> None:
    wide, flat = "{size: [60 mm, 60 mm, 10 mm], mass: 90 g}", "{size: [10 mm, 60 mm, 40 mm], mass: 90 g}"
    build = (
        f"- bricks: [{{name: low, at: [0 mm, 0 mm, 5 mm], brick: {wide}}},"
        f" {{name: tall, at: [300 mm, 0 mm, 20 mm], brick: {flat}}}]"
    )
    trace = shaken(build, pulse(0.4 * GRAVITY, 1.0))
    assert trace.tracks["low"].shift == 0.0
    assert trace.tracks["tall"].state is BrickState.FALLEN
