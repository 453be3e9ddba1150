"""Kinetic and potential energy of all bricks, against closed forms."""

from dataclasses import replace
from math import cos, radians, sin, sqrt

import pytest

from benchmarks.energy import heap
from stability.geometry.box import Box
from stability.geometry.vectors import add, scale
from stability.model import GROUND, BodyState, Brick, Plane, Pose
from stackdsl.checking.cases import Case, gather
from stackdsl.simulation.measurements import EnergyMeter, kinetic_energy
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.trace import Energy
from tests.paths import ROOT
from tests.scenes import timeline_of

GRAVITY = 9.81
SIZE = (0.1176, 0.0234, 0.0078)
MASS = 557.0 * SIZE[0] * SIZE[1] * SIZE[2]
BRICK = Brick("plank", Box(SIZE), MASS)
LEVEL = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
QUARTER_TURN = (0.0, 0.0, sqrt(0.5), sqrt(0.5))  # about z: its length lies along y


def test_a_turning_box_has_the_energy_of_its_moment_about_that_axis() -> None:
    moving = BodyState(Pose((1.0, 2.0, 3.0), QUARTER_TURN), (3.0, 4.0, 0.0), (0.0, 6.0, 0.0))
    moment = MASS * (SIZE[1] ** 2 + SIZE[2] ** 2) / 12.0  # about its length, which lies along y
    assert kinetic_energy(BRICK, moving) == pytest.approx(0.5 * MASS * 25.0 + 0.5 * moment * 36.0)


@pytest.mark.parametrize("tilt", [0.0, 30.0, 89.9])
def test_a_gain_is_a_share_of_the_distance_from_the_ground_however_it_is_tilted(tilt: float) -> None:
    #   A plank that lies 4 mm from a slope and is lifted as far.
    normal_W = (-sin(radians(tilt)), 0.0, cos(radians(tilt)))
    meter = EnergyMeter(GRAVITY, Plane(GROUND, (0.0, 0.0, 0.0), normal_W, 0.5))
    along_W = (cos(radians(tilt)), 0.0, sin(radians(tilt)))
    at_W = add(scale(0.004, normal_W), scale(2.0, along_W))
    meter.see(0.0, {"plank": BRICK}, {"plank": BodyState(Pose(at_W))})
    meter.start()
    assert meter.now == pytest.approx(MASS * GRAVITY * at_W[2])
    meter.see(0.0, {"plank": BRICK}, {"plank": BodyState(Pose(add(at_W, (0.0, 0.0, 0.004))))})
    meter.look(["plank"])
    energy = meter.energy()
    assert energy is not None
    assert energy.of_what_moved == pytest.approx(MASS * GRAVITY * 0.004)
    assert energy.gain == pytest.approx(1.0)


@pytest.mark.parametrize("others", [0, 1, 100])
def test_what_does_not_move_hides_no_digit_of_a_gain(others: int) -> None:
    block = Brick("block", Box((1.0, 1.0, 1.0)), 2000.0)
    bricks = {"plank": BRICK} | {f"block{i}": block for i in range(others)}
    meter = EnergyMeter(GRAVITY, LEVEL)
    meter.see(0.0, bricks, {name: BodyState(Pose((0.0, 0.0, 0.1 * (i + 1)))) for i, name in enumerate(bricks)})
    meter.start()
    meter.see(0.0, bricks, {"plank": BodyState(Pose((0.0, 0.0, 0.15)))})
    meter.see(
        0.0, bricks, {name: BodyState(Pose((0.0, 0.0, 0.1 * (i + 1)))) for i, name in enumerate(bricks) if i == 1}
    )
    meter.look(["plank"])
    energy = meter.energy()
    assert energy is not None
    assert energy.gain == MASS * GRAVITY * 0.15 / (MASS * GRAVITY * 0.1) - 1.0


@pytest.mark.parametrize(("sunk", "gain"), [(0.0, 1.0), (1e-6, 0.5), (2e-6, 0.0), (4e-6, 0.0), (-1e-6, 1.0)])
def test_energy_that_a_heavy_brick_gives_by_sinking_a_micrometre_is_no_gain(sunk: float, gain: float) -> None:
    #   The block weighs as much as 10,000 planks, and the plank rises from 20 to 40 mm.
    block, on_it = Brick("block", Box((1.0, 1.0, 1.0)), 1e4 * MASS), 0.04 + 0.5 * SIZE[2] + 0.5
    bricks, above = {"plank": BRICK, "block": block}, BodyState(Pose((0.0, 0.0, on_it)))
    meter = EnergyMeter(GRAVITY, LEVEL)
    meter.see(0.0, bricks, {"plank": BodyState(Pose((0.0, 0.0, 0.02))), "block": above})
    meter.start()
    meter.see(
        0.0, bricks, {"plank": BodyState(Pose((0.0, 0.0, 0.04))), "block": BodyState(Pose((0.0, 0.0, on_it - sunk)))}
    )
    meter.look(["plank"])
    energy = meter.energy()
    assert energy is not None
    assert energy.gain == pytest.approx(gain, abs=1e-8)


def test_what_an_action_brings_in_is_no_gain_and_what_comes_by_itself_is() -> None:
    meter = EnergyMeter(GRAVITY, LEVEL)
    bricks, rest = {"a": BRICK, "b": BRICK}, BodyState(Pose((0.0, 0.0, 0.1)))
    weighs = MASS * GRAVITY
    meter.see(0.0, bricks, {"a": rest, "b": rest})
    meter.start()
    meter.see(0.0, bricks, {"a": BodyState(Pose((0.0, 0.0, 0.2)))})  # lifted by nobody
    meter.look(["a"])
    meter.see(0.0, bricks, {"a": rest})
    meter.look(["a"])
    energy = meter.energy()
    assert energy is not None
    assert (energy.start, energy.risen, energy.of_what_moved) == pytest.approx(
        (0.2 * weighs, 0.1 * weighs, 0.1 * weighs)
    )
    assert energy.gain == pytest.approx(1.0)
    meter.forget(["a"])
    meter.start()
    energy = meter.energy()
    assert energy is not None
    assert (energy.start, energy.risen, energy.gain) == pytest.approx((0.1 * weighs, 0.0, 0.0))


@pytest.mark.parametrize("system", ["stock", "exact"])
def test_a_plank_that_falls_freely_gains_nothing(system: str) -> None:
    build = "- bricks: [{name: plank, at: [0 mm, 0 mm, 1 m], drop: true}]"
    trace = play(timeline_of(build, "expect: [{stands: {for: 0.4 s}}]"), SYSTEMS[system])
    assert trace.energy is not None
    assert trace.energy.start == pytest.approx(MASS * GRAVITY)
    assert trace.energy.of_what_moved == pytest.approx(MASS * GRAVITY)
    assert trace.energy.gain < 1e-6
    assert trace.tracks["plank"].final.position_W[2] < 0.25  # or nothing would be shown: it falls by 0.78 m


def test_a_throw_and_a_push_bring_their_energy_in() -> None:
    throw = "{at: 0.5 s, throw: {at: L1.1, from: {bearing: 90 deg, distance: 50 mm}, speed: 3 m/s, name: shot}}"
    trace = play(timeline_of("- column: {levels: 1}", f"impacts: [{throw}]"), SYSTEMS["exact"])
    assert trace.energy is not None
    rise = 0.5 * GRAVITY * 0.05 / 3.0  # [m/s]
    kinetic = 0.5 * MASS * (3.0**2 + rise**2)
    assert trace.energy.start == pytest.approx(kinetic + 2.0 * MASS * GRAVITY * 0.0039)
    assert trace.energy.of_what_moved == pytest.approx(trace.energy.start)  # a gain is a share of motion, too
    push = f"{{at: 0.5 s, push: {{brick: L1.1, impulse: [{0.2 * MASS} N*s, 0 N*s, 0 N*s]}}}}"
    trace = play(timeline_of("- column: {levels: 1}", f"impacts: [{push}]"), SYSTEMS["exact"])
    assert trace.energy is not None
    assert trace.energy.start == pytest.approx(0.5 * MASS * 0.2**2 + MASS * GRAVITY * 0.0039)
    assert trace.energy.gain < 1e-4


HARD = [
    case
    for case in gather([ROOT / "scenarios" / "hard"]).cases
    if case.system == "exact" and "collapse" in case.scenario.tags
]
CHOSEN = ("hard-nearly-in-line-falls[aside=0.1", "hard-stepped-column-falls[count=5", "hard-turned-column-falls")
MOST_GAIN = 0.002  # of the potential energy, by any collapse; twice what was seen


def gain(case: Case, system: str, share: float) -> float:
    """Played at so many times the time step of a system."""
    energy = play(case.timeline, SYSTEMS[system].at_step(share)).energy
    assert energy is not None
    return energy.gain


@pytest.mark.parametrize("share", [1.0, pytest.param(0.5, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "case",
    [pytest.param(c, id=c.name, marks=[] if c.name.startswith(CHOSEN) else [pytest.mark.slow]) for c in HARD],
)
def test_a_hard_collapse_gains_no_energy_at_any_step(case: Case, share: float) -> None:
    assert gain(case, "exact", share) <= MOST_GAIN


@pytest.mark.parametrize("case", [case for case in HARD if "nearly-in-line" in case.name], ids=lambda case: case.name)
def test_a_plate_that_slips_onto_a_thin_post_is_not_shot_out(case: Case) -> None:
    # Its mass is that of 700 posts, so that steps are split into seven.
    assert gain(case, "tuned", 1.0) <= MOST_GAIN


@pytest.mark.parametrize(("most", "told"), [(1.009, 0.0), (1.011, 0.011)])
def test_a_rise_of_more_than_a_hundredth_is_a_fault_of_the_engine(most: float, told: float) -> None:
    trace = play(timeline_of("- column: {levels: 1}"), SYSTEMS["exact"])
    risen = replace(trace, energy=Energy(start=1.0, risen=most - 1.0, of_what_moved=1.0))
    assert risen.energy_gained == pytest.approx(told)


@pytest.mark.slow
def test_a_block_that_tips_over_a_post_gains_nothing_as_it_meets_the_ground() -> None:
    # Its foot is there before it has turned by 30 deg, as far as it is followed without an engine.
    trace = play(heap(1), SYSTEMS["exact"])
    assert trace.collapse is not None
    assert trace.cost.steps > 0
    assert trace.energy is not None
    assert trace.energy.gain < 1e-9


def test_a_plank_that_tips_over_a_corner_near_a_sliver_is_not_shot_off_it() -> None:
    trace = play(heap(385), SYSTEMS["exact"])
    assert min(track.brick.shape.least_thickness for track in trace.tracks.values()) < 0.0001
    assert trace.collapse is not None
    assert not trace.energy_gained


SUNK = """
- bricks:
    - {name: a, at: [0 mm, 0 mm, 0.5 mm], brick: {size: [20 mm, 10 mm, 1 mm], density: 557 kg/m3}}
    - {name: b, at: [8 mm, 0 mm, 1.48 mm], brick: {size: [20 mm, 10 mm, 1 mm], density: 557 kg/m3}}
    - {name: c, at: [17 mm, 0 mm, 2.46 mm], brick: {size: [20 mm, 10 mm, 1 mm], density: 557 kg/m3}}
"""
BLOCK = "- {name: far, at: [20 m, 0 mm, 0.5 m], brick: {size: [1 m, 1 m, 1 m], density: 2000 kg/m3}}"


def test_a_block_elsewhere_hides_no_gain() -> None:
    #   Sheets that lie in each other are driven apart. What an engine shakes the block by is no gain of theirs.
    push = "impacts: [{after: built + 0.1 s, push: {brick: c, impulse: [0.001 mN*s, 0 N*s, 0 N*s]}}]"
    alone, beside = (play(timeline_of(build, push), SYSTEMS["stock"]) for build in (SUNK, f"{SUNK}    {BLOCK}\n"))
    assert alone.energy is not None
    assert beside.energy is not None
    assert 0.001 < alone.energy.gain < 0.003
    assert beside.energy.gain == pytest.approx(alone.energy.gain, rel=1e-3)


@pytest.mark.slow
def test_what_tips_over_a_sheet_and_comes_down_beside_it_gains_nothing() -> None:
    """The sheet fills the gap to the block until the plank has closed it; the plank was in that by 0.14 mm before."""
    assert play(heap(909), SYSTEMS["exact"]).energy_gained == 0.0
    timeline = timeline_of(
        "- bricks:\n"
        "  - {name: block, at: [0 mm, 0 mm, 18 mm], brick: {size: [25 mm, 57 mm, 36 mm], mass: 250 g}}\n"
        "  - {name: sheet, at: [-3 mm, 9 mm, 36.028 mm], brick: {size: [8 mm, 41 mm, 0.056 mm], mass: 0.06 g}}\n"
        "  - {name: plank, at: [31 mm, 16 mm, 42.956 mm], brick: {size: [67 mm, 16 mm, 13.8 mm], mass: 29 g}}\n",
        "expect: [{collapses: any}]",
    )
    energy = play(timeline, SYSTEMS["exact"]).energy
    assert energy is not None
    assert energy.gain < 1e-4
