"""Balance by friction cones: verdicts flip at closed forms, and no solver can make them wrong."""

from collections.abc import Callable
from dataclasses import replace
from math import atan, cos, nan, sin

import numpy as np
import pytest

from stability.contact_law import Coulomb
from stability.geometry.rows import Array
from stability.model import GROUND
from stability.problem import UP, Contact, Problem, Tolerances, Wrench
from stability.statics.conic_program import ConicProgram, SolverPoint, clarabel_solve
from stability.statics.equilibrium import Balance, balance
from stability.statics.proof import check_forces, check_motion
from tests.stability.statics.hand_built import (
    GRAVITY,
    LENGTH,
    THICKNESS,
    WEST,
    column,
    harmonic,
    inverted_v,
    ladder,
    level_patch,
    moved_by,
    on_a_slope,
    plank,
    stepped,
    weighed,
)

HAIR = 1e-6  # relative: every verdict must flip within this of its limit
SHARES = [(1.0 - HAIR, True), (1.0 + HAIR, False)]
EXACT = Tolerances()


def stands(problem: Problem) -> bool:
    """Whether it is proven to stand; fails unless one of the two is proven."""
    found = balance(problem)
    if found.forces is not None:
        assert check_forces(problem, found.forces, EXACT).holds
        return True
    assert found.motion is not None, found.note
    assert check_motion(problem, found.motion, EXACT).holds
    return False


@pytest.mark.parametrize(("share", "holds"), SHARES)
@pytest.mark.parametrize("count", [2, 10, 60])
def test_a_stepped_column_stands_up_to_its_length(count: int, share: float, holds: bool) -> None:
    assert stands(stepped(count, share * LENGTH / count)) is holds


@pytest.mark.parametrize(("share", "holds"), SHARES)
def test_a_harmonic_stack_of_a_hundred_stands_up_to_its_overhang(share: float, holds: bool) -> None:
    assert stands(harmonic(100, share)) is holds


@pytest.mark.parametrize(("share", "holds"), SHARES)
def test_a_block_slides_on_a_slope_as_steep_as_friction(share: float, holds: bool) -> None:
    assert stands(on_a_slope(atan(share * 0.5), 0.5)) is holds


@pytest.mark.parametrize(("share", "holds"), SHARES)
def test_a_tall_block_topples_on_a_slope_as_steep_as_its_base_over_its_height(share: float, holds: bool) -> None:
    assert stands(on_a_slope(atan(share * 0.01 / 0.03), 0.5, size=(0.01, 0.02, 0.03))) is holds


@pytest.mark.parametrize(("share", "holds"), SHARES)
def test_a_ladder_slips_from_a_smooth_wall(share: float, holds: bool) -> None:
    friction = 0.4
    steepest = 1.0 / (2.0 * friction + THICKNESS / LENGTH)
    assert stands(ladder(atan(steepest / share), friction)) is holds


@pytest.mark.parametrize(("share", "holds"), SHARES)
def test_an_inverted_v_spreads(share: float, holds: bool) -> None:
    angle = 1.2
    friction = 0.5 * (cos(angle) / sin(angle) - THICKNESS / LENGTH)
    assert stands(inverted_v(angle, friction / share)) is holds


@pytest.mark.parametrize(("share", "holds"), SHARES)
@pytest.mark.parametrize("masses", [(1e6, 1e6, 1.0), (1.0, 1e6, 1.0), (1e-6, 1e6, 1e-6)])
def test_the_top_plank_tips_half_over_whatever_the_masses(masses: tuple[float, ...], share: float, holds: bool) -> None:
    assert stands(column([0.0, 0.0, 0.5 * share * LENGTH], masses=masses)) is holds


@pytest.mark.parametrize(("share", "holds"), SHARES)
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_a_counterweight_holds_a_plank_by_the_lever_law(ratio: float, share: float, holds: bool) -> None:
    #  |w|                   w: counterweight with its centre `arm` behind the edge
    #  |-------p-------|     p: centre 0.03 m beyond the edge of the table, at x = 0
    #  ====table===|
    reach, mass = 0.03, 1.0
    weight = ratio * mass
    arm = mass * reach / weight / share
    base = plank("p", (reach, 0.0, 0.004), mass, (2.0 * (arm + 0.1), 0.024, 0.008))
    load = plank("w", (-arm, 0.0, 0.012), weight, (0.002, 0.024, 0.008))
    table = Contact("table", "p", level_patch((reach - arm - 0.1, 0.0), 0.0), (UP,), Coulomb(0.5))
    on_top = Contact("p", "w", level_patch((-arm - 0.001, -arm + 0.001), 0.008), (UP,), Coulomb(0.5))
    assert stands(weighed([base, load], [table, on_top])) is holds


@pytest.mark.parametrize(("share", "holds"), SHARES)
def test_verdicts_flip_as_sharply_a_kilometre_away(share: float, holds: bool) -> None:
    # Places there are exact to 1e-13 m only, twice a millionth of a millionth of the plank.
    assert stands(moved_by(stepped(10, 0.1 * share * LENGTH), (1000.0, -1000.0, 0.0))) is holds


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
def test_verdicts_do_not_depend_on_how_heavy_all_is(factor: float) -> None:
    for share, holds in SHARES:
        problem = stepped(10, 0.1 * share * LENGTH)
        loads = {name: Wrench((0.0, 0.0, load.force_W[2] * factor)) for name, load in problem.loads.items()}
        assert stands(replace(problem, loads=loads)) is holds


def test_a_pushed_block_slides_if_low_and_tips_if_high() -> None:
    size, mass, friction = (0.02, 0.02, 0.06), 0.1, 0.5
    block = plank("b", (0.0, 0.0, 0.03), mass, size)
    ground = Contact(GROUND, "b", level_patch((-0.01, 0.01), 0.0, 0.02), (UP,), Coulomb(friction))
    weight = mass * GRAVITY

    def pushed(force: float, height: float) -> Problem:
        load = Wrench((force, 0.0, -weight), (0.0, force * (height - 0.03), 0.0))
        return Problem({"b": block}, [ground], {"b": load})

    for share, holds in SHARES:
        assert stands(pushed(share * friction * weight, 0.005)) is holds  # below b / (2 mu) = 0.02 m it slides
        assert stands(pushed(share * weight * 0.01 / 0.05, 0.05)) is holds  # above it tips


def test_residuals_do_not_add_up_to_hold_a_tall_column() -> None:
    # Sideways residuals count with their height over the joint: of 300 planks, residuals of 1e-9 of what each carries
    # would do what friction and weight cannot. The solver may fail to prove the fall, but must not prove the opposite.
    tall = stepped(300, LENGTH / 300 * (1.0 + HAIR))
    assert balance(tall, Tolerances(residual=1e-12)).forces is None


def test_equilibrium_lets_bricks_without_contacts_fall_and_weightless_ones_stay() -> None:
    free = weighed([plank("p", (0.0, 0.0, 1.0))], [])
    assert not stands(free)
    assert stands(replace(free, loads={}))
    assert stands(Problem({}, [], {}))


def test_a_plank_hangs_from_nothing() -> None:
    # A fixed plank lies on it: it cannot pull.
    above = Contact("p", "fixed", level_patch((-0.06, 0.06), 1.004), (UP,), Coulomb(0.5))
    assert not stands(weighed([plank("p", (0.0, 0.0, 1.0))], [above]))


def test_a_plank_stands_in_a_groove_of_two_normals() -> None:
    # One edge contact with two extreme normals holds sideways pushes up to the slope of its sides.
    side = 0.5**0.5
    groove = Contact(
        "groove", "p", ((0.0, -0.01, 0.0), (0.0, 0.01, 0.0)), ((side, 0.0, side), (-side, 0.0, side)), Coulomb(0.0)
    )
    body = plank("p", (0.0, 0.0, 0.004))
    for share, holds in SHARES:
        # The push acts through the groove, so that nothing turns.
        load = Wrench((share, 0.0, -1.0), (0.0, -share * 0.004, 0.0))
        assert stands(Problem({"p": body}, [groove], {"p": load})) is holds


def test_a_wall_with_friction_carries_part_of_a_ladder() -> None:
    angle, friction = 0.7, 0.4
    assert not stands(ladder(angle, friction))
    assert stands(ladder(angle, 0.6, 0.6))


# --- whatever a solver says -------------------------------------------------------------------------------------------


def answered(
    change: Callable[[SolverPoint, ConicProgram], SolverPoint],
) -> Callable[[ConicProgram, float], SolverPoint]:
    return lambda program, accuracy: change(clarabel_solve(program, accuracy), program)


def garbage(program: ConicProgram) -> tuple[Array, Array]:
    random = np.random.default_rng(3)
    return random.normal(size=len(program.cost)), random.normal(size=len(program.offset))


WRONG: dict[str, Callable[[SolverPoint, ConicProgram], SolverPoint]] = {
    "zeros": lambda point, _: SolverPoint(0.0 * point.x, 0.0 * point.dual, "Solved"),
    "not numbers": lambda point, _: SolverPoint(nan * point.x, nan * point.dual, "Solved"),
    "garbage": lambda _, program: SolverPoint(*garbage(program), "Solved"),
    "wrong shape": lambda point, _: SolverPoint(point.x[:-1], point.dual[:-1], "Solved"),
    "all sink": lambda point, program: SolverPoint(-program.cost, 0.0 * point.dual, "DualInfeasible"),
    "turned round": lambda point, _: SolverPoint(-point.x, -point.dual, "Solved"),
    "forces doubled": lambda point, _: SolverPoint(0.0 * point.x, 2.0 * point.dual, "Solved"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_points_prove_nothing_whatever_their_status(wrong: str) -> None:
    for problem in (stepped(9, 0.0135), stepped(8, 0.0135), ladder(0.6, 0.4), ladder(1.2, 0.5)):
        found = balance(problem, solver=answered(WRONG[wrong]))
        assert found.forces is None
        assert found.motion is None
        assert found.note


@pytest.mark.parametrize("status", ["Solved", "PrimalInfeasible", "DualInfeasible", "NumericalError", ""])
def test_right_points_prove_whatever_their_status(status: str) -> None:
    solve = answered(lambda point, _: SolverPoint(point.x, point.dual, status))
    assert balance(stepped(8, 0.0135), solver=solve).forces is not None
    assert balance(stepped(9, 0.0135), solver=solve).motion is not None


def test_the_points_of_a_standing_structure_do_not_pass_for_those_of_a_falling_one() -> None:
    remembered: list[SolverPoint] = []

    def remember(program: ConicProgram, accuracy: float) -> SolverPoint:
        remembered.append(clarabel_solve(program, accuracy))
        return remembered[-1]

    assert balance(stepped(8, 0.0135), solver=remember).forces is not None
    found = balance(column([0.0135 * (i + (i == 7)) for i in range(8)]), solver=lambda *_: remembered[0])
    assert found == Balance(None, None, found.note)


def test_small_errors_of_a_solver_are_corrected() -> None:
    random = np.random.default_rng(7)

    def shaken(point: SolverPoint, _: ConicProgram) -> SolverPoint:
        noise = 1.0 + 1e-6 * random.normal(size=len(point.dual))
        return SolverPoint(point.x, point.dual * noise, "AlmostSolved")

    assert balance(stepped(8, 0.0135), solver=answered(shaken)).forces is not None
    assert balance(ladder(1.2, 0.5, 0.3), solver=answered(shaken)).forces is not None


def test_a_motion_that_closes_contacts_by_a_hair_is_mended() -> None:
    def sunk(point: SolverPoint, program: ConicProgram) -> SolverPoint:
        return SolverPoint(point.x * (1.0 - 1e-9 * np.arange(len(point.x))), point.dual, point.status)

    found = balance(stepped(9, 0.0135), solver=answered(sunk))
    assert found.motion is not None
    assert check_motion(stepped(9, 0.0135), found.motion, EXACT).violation <= EXACT.violation


def test_a_solver_that_dies_is_a_note() -> None:
    def dies(_: ConicProgram, __: float) -> SolverPoint:
        raise RuntimeError("out of luck")

    found = balance(stepped(3, 0.01), solver=dies)
    assert found.forces is None
    assert found.motion is None
    assert "out of luck" in found.note


def test_the_solver_is_asked_again_where_its_first_points_prove_nothing() -> None:
    accuracies: list[float] = []

    def late(program: ConicProgram, accuracy: float) -> SolverPoint:
        accuracies.append(accuracy)
        point = clarabel_solve(program, accuracy)
        return point if len(accuracies) > 2 else SolverPoint(0.0 * point.x, 0.0 * point.dual, "Solved")

    assert balance(stepped(8, 0.0135), solver=late).forces is not None
    accuracies.clear()
    assert balance(stepped(9, 0.0135), solver=late).motion is not None
    assert len(accuracies) == 3


@pytest.mark.parametrize(("share", "holds"), SHARES)
@pytest.mark.parametrize("friction", [0.4, 0.05])
def test_a_block_pressed_against_a_wall_holds_by_friction_alone(friction: float, share: float, holds: bool) -> None:
    weight = 0.012 * GRAVITY
    wall = Contact("wall", "b", ((0.06, -0.01, 0.5), (0.06, 0.01, 0.5)), (WEST,), Coulomb(friction))
    # The weight would turn the block about the wall; a torque undoes that.
    load = Wrench((weight / friction / share, 0.0, -weight), (0.0, 0.06 * weight, 0.0))
    assert stands(Problem({"b": plank("b", (0.0, 0.0, 0.5))}, [wall], {"b": load})) is holds
