"""How far loads can be stretched: closed forms, from both sides."""

from collections.abc import Mapping
from math import cos, inf, nan, sin

import pytest

from stability.model import BodyId
from stability.statics.equilibrium import balance
from stability.statics.facts import Problem, Tolerances, Wrench
from stability.statics.programme import Point, Programme, clarabel_solve
from stability.statics.proof import check_forces, check_motion, power
from stability.statics.stretching import stretch, stretched
from stability.statics.wrench_matrix import wrench_matrix
from tests.statics.hand_built import GRAVITY, LENGTH, THICKNESS, column, ladder, on_a_slope, stepped

EXACT = Tolerances()


def pushed(problem: Problem, heading: float = 0.0) -> Mapping[BodyId, Wrench]:
    """Each brick's weight, sideways."""
    return {
        name: Wrench((-load.force_W[2] * cos(heading), -load.force_W[2] * sin(heading), 0.0))
        for name, load in problem.loads.items()
    }


def limit(problem: Problem, direction: Mapping[BodyId, Wrench]) -> float:
    """The middle of the proven bounds, which are close."""
    found = stretch(problem, direction, EXACT)
    assert found is not None
    assert found.motion is not None
    assert found.lower <= found.upper
    assert found.upper - found.lower <= 1e-6
    assert check_forces(stretched(problem, direction, found.lower), found.forces, EXACT).holds
    assert check_motion(stretched(problem, direction, found.upper), found.motion, EXACT).holds
    assert power(direction, found.motion) == pytest.approx(1.0)
    return 0.5 * (found.lower + found.upper)


def test_a_flat_plank_slides_at_its_friction() -> None:
    problem = on_a_slope(0.0, 0.3)
    for heading in (0.0, 1.0, 2.0):
        assert limit(problem, pushed(problem, heading)) == pytest.approx(0.3, rel=1e-6)


def test_a_tall_block_tips_at_its_base_over_its_height() -> None:
    problem = on_a_slope(0.0, 0.9, size=(0.01, 0.02, 0.04))
    assert limit(problem, pushed(problem)) == pytest.approx(0.25, rel=1e-6)


@pytest.mark.parametrize("count", [1, 5, 30])
def test_a_straight_column_tips_at_its_length_over_its_height(count: int) -> None:
    problem = column([0.0] * count, friction=5.0)
    # Lengthwise, but for the first it slides before.
    expected = min(5.0, LENGTH / (count * THICKNESS))
    assert limit(problem, pushed(problem)) == pytest.approx(expected, rel=1e-6)


def test_without_friction_nothing_holds_a_push() -> None:
    problem = on_a_slope(0.0, 0.0)
    assert limit(problem, pushed(problem)) == pytest.approx(0.0, abs=1e-7)


def test_a_lift_ends_at_the_weight() -> None:
    problem = stepped(1, 0.0)
    assert limit(problem, {"p01": Wrench((0.0, 0.0, 1.0))}) == pytest.approx(0.012 * GRAVITY, rel=1e-6)


def test_a_ladder_that_slips_stands_once_it_is_held() -> None:
    # The largest factor, not the least: a push against its foot holds it from some factor on, up to another.
    problem = ladder(0.6, 0.4)
    assert balance(problem).motion is not None
    found = stretch(problem, {"ladder": Wrench((0.0, 0.0, -1.0))}, EXACT)
    assert found is None


def test_weight_can_be_added_for_ever_to_what_stands() -> None:
    problem = stepped(5, 0.01)
    found = stretch(problem, problem.loads, EXACT)
    assert found is not None
    assert (found.lower, found.upper, found.motion) == (inf, inf, None)
    assert check_forces(problem, found.forces, EXACT).holds


def test_the_motion_of_one_direction_bounds_every_other() -> None:
    problem = on_a_slope(0.0, 0.9, size=(0.01, 0.02, 0.04))
    found = stretch(problem, pushed(problem, 0.3), EXACT)
    assert found is not None
    assert found.motion is not None
    for heading in (0.0, 0.2, 0.5):
        direction = pushed(problem, heading)
        bound = -power(problem.loads, found.motion) / power(direction, found.motion)
        assert limit(problem, direction) <= bound * (1.0 + 1e-6)


def test_a_matrix_can_be_used_again() -> None:
    problem = stepped(5, 0.01)
    system = wrench_matrix(problem, whole=True)
    for heading in (0.0, 1.0):
        again = stretch(problem, pushed(problem, heading), EXACT, system=system)
        assert again == stretch(problem, pushed(problem, heading), EXACT)


def test_no_direction_has_no_end_that_could_be_found() -> None:
    assert stretch(stepped(2, 0.0), {}, EXACT) is None


def test_a_solver_cannot_stretch_a_bound() -> None:
    problem = stepped(3, 0.01)

    def boasts(programme: Programme, accuracy: float) -> Point:
        point = clarabel_solve(programme, accuracy)
        return Point(point.x, 2.0 * point.dual, "Solved")

    def fails(programme: Programme, accuracy: float) -> Point:
        point = clarabel_solve(programme, accuracy)
        return Point(nan * point.x, nan * point.dual, "Solved")

    truth = stretch(problem, pushed(problem), EXACT)
    boasted = stretch(problem, pushed(problem), EXACT, boasts)
    assert truth is not None
    assert boasted is None or boasted.lower <= truth.upper
    assert stretch(problem, pushed(problem), EXACT, fails) is None
