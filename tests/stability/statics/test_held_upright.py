"""Weights that can be handed down: no motion lowers what they are loads of, and no solver need be asked."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from stability.contact_law import Coulomb
from stability.model import GROUND, Plane
from stability.problem import UP, Contact, Problem, Stability, Wrench
from stability.statics import equilibrium
from stability.statics.assembly import Assembly
from stability.statics.equilibrium import balance, falling_motion
from stability.statics.propagation import is_held_upright
from tests.stability.statics.hand_built import LENGTH, on_a_slope, stepped
from tests.stability.statics.random_piles import FRICTION, random_pile


@pytest.mark.parametrize("count", [2, 5, 9])
def test_a_stepped_column_is_held_up_to_its_limit(count: int) -> None:
    limit = LENGTH / count
    assert is_held_upright(stepped(count, limit * (1.0 - 1e-6)))
    assert not is_held_upright(stepped(count, limit * (1.0 + 1e-6)))


def test_piles_held_upright_are_stable_and_balanced() -> None:
    held = 0
    for number in range(60):
        assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION),), FRICTION)
        verdict = assembly.add_all(random_pile(np.random.default_rng([3, number]), number))
        if is_held_upright(assembly.problem()):
            held += 1
            assert verdict.stability is Stability.STABLE
            assert balance(assembly.problem()).forces is not None
    assert 10 < held < 50


def test_no_solver_is_asked_whether_what_is_held_falls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(equilibrium, "wrench_matrix", None)  # calling it is an error
    assert falling_motion(stepped(5, 0.1 * LENGTH)) is None


def pulled(problem: Problem) -> Problem:
    return replace(problem, loads={**problem.loads, "p02": Wrench((1e-9, 0.0, -1.0))})


def twisted(problem: Problem) -> Problem:
    return replace(problem, loads={**problem.loads, "p02": Wrench((0.0, 0.0, -1.0), (0.0, 1e-9, 0.0))})


def in_a_ring(problem: Problem) -> Problem:
    x, y, _ = problem.contacts[-1].points_W[0]
    return replace(problem, contacts=[*problem.contacts, Contact("p03", "p01", ((x, y, 0.0),), (UP,), Coulomb(0.5))])


def on_nothing(problem: Problem) -> Problem:
    return replace(problem, contacts=problem.contacts[1:])


@pytest.mark.parametrize("changed", [pulled, twisted, in_a_ring, on_nothing])
def test_other_loads_than_weights_rings_and_what_hangs_in_the_air_are_not_judged(
    changed: Callable[[Problem], Problem],
) -> None:
    column = stepped(3, 0.0)
    assert is_held_upright(column)
    assert not is_held_upright(changed(column))


def test_a_plank_on_a_slope_is_held_while_its_friction_holds_upright_forces() -> None:
    assert is_held_upright(on_a_slope(0.1, 0.11))
    assert not is_held_upright(on_a_slope(0.1, 0.09))
