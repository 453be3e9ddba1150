"""Planks that slip and slide in the engines of `exact` and `tuned`, against equations of motion, as users see them."""

from math import atan, degrees, radians

import pytest

from benchmarks.slipping import needed_friction
from benchmarks.slips import KAPLA, Case, errors, seen_motion, timeline
from stackdsl.playing.runner import play
from stackdsl.playing.systems import SYSTEMS

LATE, FAST = 2e-3, 0.015  # of times, and of speeds: an engine's are those of the middle of a step
PROVEN = 1e-4  # of what needs no engine
BARELY_LATE = 0.02  # with springs at rest, which hold what has hardly begun


@pytest.mark.parametrize("steeper", [1.01, 1.10])
@pytest.mark.parametrize("bearing", [0.0, 30.0, 45.0, 90.0])
@pytest.mark.parametrize("slope", [2.9, 26.6, 56.6])
def test_a_plank_on_a_slope_that_is_a_little_too_steep_slides_as_the_closed_form_says(
    steeper: float, bearing: float, slope: float
) -> None:
    for system, late in (("exact", LATE), ("tuned", BARELY_LATE)):
        found = errors(Case("slope", slope, 1.0 / steeper, bearing), SYSTEMS[system])
        assert abs(found.time) < late
        assert abs(found.speed) < max(late, FAST)


@pytest.mark.parametrize("share", [0.99, 0.90, 0.50])
@pytest.mark.parametrize("yaw", [0.0, 45.0, 75.0])
@pytest.mark.parametrize(("kind", "angle"), [("ladder", 50.0), ("ladder", 70.0), ("V", 60.0), ("V", 70.0)])
def test_planks_that_lean_slip_on_exact_as_newton_says(kind: str, angle: float, share: float, yaw: float) -> None:
    found = errors(Case(kind, angle, share, yaw), SYSTEMS["exact"])
    assert abs(found.time) < PROVEN
    assert abs(found.speed) < PROVEN


@pytest.mark.parametrize("scale", [0.5, 3.0, 10.0])
def test_so_do_planks_of_other_sizes(scale: float) -> None:
    length, width, thickness = (scale * side for side in KAPLA)
    assert abs(errors(Case("V", 60.0, 0.97, 30.0, (length, width, thickness)), SYSTEMS["exact"]).time) < PROVEN


def test_an_engine_takes_over_where_a_ladder_leaves_its_wall_without_adding_energy() -> None:
    case = Case("ladder", 60.0, 0.9, 30.0)
    trace = play(timeline(case), SYSTEMS["exact"])
    assert trace.cost.steps > 0
    assert trace.energy is not None
    assert trace.energy.gain < 0.01


@pytest.mark.parametrize(("share", "error"), [(0.99, 0.13), (0.97, 0.065), (0.90, 0.06), (0.50, 0.035)])
@pytest.mark.parametrize("kind", ["ladder", "V"])
@pytest.mark.parametrize("angle", [50.0, 60.0, 70.0])
def test_the_bare_engine_lets_planks_slip_a_little_early_or_late_whose_edges_lie_along_its_axes(
    kind: str, angle: float, share: float, error: float
) -> None:
    assert abs(errors(Case(kind, angle, share), SYSTEMS["tuned"]).time) < error


@pytest.mark.parametrize("yaw", [10.0, 30.0, 45.0, 75.0])
@pytest.mark.parametrize("kind", ["ladder", "V"])
def test_with_half_the_friction_they_need_it_lets_them_slip_in_time_in_every_direction(kind: str, yaw: float) -> None:
    assert abs(errors(Case(kind, 60.0, 0.5, yaw), SYSTEMS["tuned"]).time) < 0.06


@pytest.mark.parametrize("share", [0.50, 0.80, 0.90, 0.95, 0.97, 1.03, 1.05])
@pytest.mark.parametrize("yaw", [0.0, 10.0, 22.5, 30.0, 45.0, 60.0, 75.0])
@pytest.mark.parametrize("angle", [60.0, 65.0, 70.0, 75.0])
def test_the_bare_engine_knows_the_friction_of_a_v_within_3_percent_in_every_direction(
    angle: float, yaw: float, share: float
) -> None:
    #   mu = (cot a - t / L) / 2
    assert slips(Case("V", angle, share, yaw)) is (share < 1.0)


@pytest.mark.parametrize("share", [0.50, 0.80, 1.03])
@pytest.mark.parametrize("yaw", [0.0, 10.0, 22.5, 30.0, 45.0, 60.0, 75.0])
def test_so_it_does_where_both_stand_at_80_deg_but_that_one_of_fifty_sticks_with_up_to_10_percent_too_little(
    yaw: float, share: float
) -> None:
    assert slips(Case("V", 80.0, share, yaw)) is (share < 1.0)


@pytest.mark.parametrize("flatter", [2.0, 0.5, 0.3, 0.2, -0.2, -0.3, -1.0])
@pytest.mark.parametrize("yaw", [0.0, 10.0, 22.5, 30.0, 45.0, 60.0, 75.0])
@pytest.mark.parametrize("friction", [0.2, 0.35, 0.5])
def test_it_knows_the_angle_at_which_a_ladder_slips_within_a_fifth_of_a_degree(
    friction: float, yaw: float, flatter: float
) -> None:
    #   tan a = 1 / (2 mu + t / L) on a smooth wall
    length, _, thickness = KAPLA
    angle = atan(1.0 / (2.0 * friction + thickness / length)) - radians(flatter)
    share = friction / needed_friction(length, thickness, angle)
    assert slips(Case("ladder", degrees(angle), share, yaw)) is (flatter > 0.0)


def slips(case: Case) -> bool:
    """Whether its foot gets 2 mm on the bare engine within a second; what has not begun in a quarter of it stands."""
    for time, way, speed in seen_motion(case, SYSTEMS["tuned"]):
        if way > 0.002:
            return True
        if time > 1.0 or (time > 0.25 and speed < 1e-4 and way < 3e-4):
            return False
    return False
