"""Planks that slip and slide in the engines of `exact` and `tuned`, against equations of motion, as users see them."""

from collections.abc import Iterable
from itertools import product
from math import atan, degrees, radians

import pytest
from _pytest.mark import ParameterSet

from benchmarks.limits import ENGINES, falls, scaled
from benchmarks.slipping import needed_friction
from benchmarks.slips import KAPLA, Case, errors, timeline
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from tests.engines_at_hand import needs_pybullet

# Accuracy of slips in PyBullet.
pytestmark = needs_pybullet

LATE, FAST = 2e-3, 0.015  # of times, and of speeds: an engine's are those of the middle of a step
MOVED = 0.01  # of times and speeds of `exact`, whose engine has rounded edges
BARE = ENGINES["tuned"]
BARELY_LATE = 0.02  # with friction anchors, which hold bricks at the onset of a slip


def quick(points: Iterable[tuple[float, ...]], *kept: tuple[float, ...]) -> list[ParameterSet]:
    """All points of a grid: those that begin like one that is kept are in the suite, the others behind a marker."""
    return [
        pytest.param(*one, marks=[] if any(one[: len(some)] == some for some in kept) else [pytest.mark.slow])
        for one in points
    ]


YAWS = pytest.mark.parametrize("yaw", quick(product((0.0, 10.0, 22.5, 30.0, 45.0, 60.0, 75.0)), (10.0,), (45.0,)))
SLOPES = product((2.9, 26.6, 56.6), (0.0, 30.0, 45.0, 90.0), (1.01, 1.10))  # [deg], [deg], times the limit


@pytest.mark.parametrize(
    ("slope", "bearing", "steeper"),
    quick(SLOPES, (2.9, 30.0, 1.10), (26.6, 0.0, 1.10), (26.6, 45.0, 1.01), (56.6, 90.0)),
)
def test_a_plank_on_a_slope_that_is_a_little_too_steep_slides_as_the_closed_form_says(
    slope: float, bearing: float, steeper: float
) -> None:
    for system, late in (("exact", LATE), ("tuned", BARELY_LATE)):
        found = errors(Case("slope", slope, 1.0 / steeper, bearing), SYSTEMS[system])
        assert abs(found.time) < late
        assert abs(found.speed) < max(late, FAST)


@pytest.mark.parametrize(
    ("yaw", "share"), quick(product((0.0, 45.0, 75.0), (0.99, 0.90, 0.50)), (0.0, 0.90), (75.0, 0.99))
)
@pytest.mark.parametrize(("kind", "angle"), [("ladder", 50.0), ("ladder", 70.0), ("V", 60.0), ("V", 70.0)])
def test_planks_that_lean_slip_on_exact_as_newton_says(kind: str, angle: float, share: float, yaw: float) -> None:
    found = errors(Case(kind, angle, share, yaw), SYSTEMS["exact"])
    assert abs(found.time) < MOVED
    assert abs(found.speed) < MOVED


@pytest.mark.parametrize("scale", [0.5, pytest.param(3.0, marks=pytest.mark.slow), 10.0])
def test_leaning_planks_of_other_sizes_slip_on_exact_as_newton_says(scale: float) -> None:
    length, width, thickness = (scale * side for side in KAPLA)
    assert abs(errors(Case("V", 60.0, 0.97, 30.0, (length, width, thickness)), SYSTEMS["exact"]).time) < MOVED


def test_an_engine_takes_over_where_a_ladder_leaves_its_wall_without_adding_energy() -> None:
    case = Case("ladder", 60.0, 0.9, 30.0)
    trace = play(timeline(case), SYSTEMS["exact"])
    assert trace.cost.steps > 0
    assert trace.energy is not None
    assert trace.energy.gain < 0.01


@pytest.mark.parametrize(
    ("share", "error"), quick(((0.99, 0.13), (0.97, 0.065), (0.90, 0.06), (0.50, 0.035)), (0.99,), (0.50,))
)
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


@pytest.mark.parametrize("share", [0.50, 0.90, 0.99, 1.01])
@YAWS
@pytest.mark.parametrize("angle", [50.0, 70.0, 80.0])
def test_the_bare_engine_knows_the_friction_of_a_v_within_1_percent_in_every_direction(
    angle: float, yaw: float, share: float
) -> None:
    #   mu = (cot a - t / L) / 2
    assert falls(Case("V", angle, share, yaw), BARE) is (share < 1.0)


@pytest.mark.parametrize("share", [0.98, 1.02])
@pytest.mark.parametrize("yaw", quick(product((0.0, 30.0)), (30.0,)))
@pytest.mark.parametrize("angle", [60.0, 80.0])
@pytest.mark.parametrize("length", quick(product((0.01, 0.03, 1.2)), (0.01,), (1.2,)))
def test_the_bare_engine_knows_the_friction_of_a_v_of_1_cm_bricks_and_of_beams_within_2_percent(
    length: float, angle: float, yaw: float, share: float
) -> None:
    assert falls(Case("V", angle, share, yaw, scaled(length)), BARE) is (share < 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("length", [0.01, 0.03, KAPLA[0], 0.2, 1.2])
@pytest.mark.parametrize("angle", range(46, 83, 4))
def test_the_bare_engine_knows_the_friction_of_a_v_within_2_percent_at_every_angle_and_bearing(
    angle: float, length: float
) -> None:
    for yaw, share in product(range(0, 91, 5), (0.98, 1.02)):
        assert falls(Case("V", angle, share, yaw, scaled(length)), BARE) is (share < 1.0), (yaw, share)


@pytest.mark.parametrize("share", [0.98, 1.02])
@YAWS
@pytest.mark.parametrize("angle", [60.0, 75.0, 80.0])
def test_the_engine_of_exact_also_moves_leaning_bricks_without_closed_form(
    angle: float, yaw: float, share: float
) -> None:
    assert falls(Case("V", angle, share, yaw), ENGINES["moving"]) is (share < 1.0)


@pytest.mark.parametrize("flatter", [2.0, 0.15, -0.15, -1.0])
@YAWS
@pytest.mark.parametrize("friction", [0.2, 0.35, 0.5])
def test_the_bare_engine_knows_the_slip_angle_of_a_ladder_within_a_sixth_of_a_degree(
    friction: float, yaw: float, flatter: float
) -> None:
    #   tan a = 1 / (2 mu + t / L) on a smooth wall
    length, _, thickness = KAPLA
    angle = atan(1.0 / (2.0 * friction + thickness / length)) - radians(flatter)
    share = friction / needed_friction(length, thickness, angle)
    assert falls(Case("ladder", degrees(angle), share, yaw), BARE) is (flatter > 0.0)
