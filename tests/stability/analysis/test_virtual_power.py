"""A proof that nothing starts is read by arithmetic alone: what is changed in it is found."""

from dataclasses import replace
from math import radians, tan

import numpy as np
import pytest

from stability.analysis.uniqueness import FrictionProof, outcome
from stability.analysis.uniqueness_program import (
    Condition,
    ContactMode,
    Multipliers,
    ProvenBranch,
    check_branch,
    cover_every_case,
)
from stability.contact_law import Coulomb
from stability.statics.initial_motion import start_equations
from tests.stability.analysis.leaning_scenes import ladder, pile_on_a_slope

OPENS, SHUT = Condition(0, ContactMode.OPENS), Condition(0, ContactMode.SHUT)
UPHILL = Condition(0, ContactMode.TOWARDS, (1.0, 0.0, 0.0))


def proof(friction: float = 0.5) -> FrictionProof:
    (braced,) = outcome(pile_on_a_slope(1, 20.0, friction).problem()).braced
    return braced


@pytest.mark.parametrize("name", ["virtual", "of_loads", "of_forces", "braking", "along"])
def test_a_proof_whose_numbers_are_changed_is_none(name: str) -> None:
    braced = proof()
    (branch,) = braced.proof
    changed = replace(branch.multipliers, **{name: getattr(branch.multipliers, name) + 1e-3})
    assert braced.holds()
    assert not replace(braced, proof=(replace(branch, multipliers=changed),)).holds()


@pytest.mark.parametrize(("share", "enough"), [(1.001, True), (0.999, False)])
def test_a_proof_holds_down_to_the_friction_that_the_slope_needs(share: float, enough: bool) -> None:
    # The least of all proofs asks for no more than tan a.
    braced = proof(0.5)
    rough = [replace(contact, law=Coulomb(share * tan(radians(20.0)))) for contact in braced.problem.contacts]
    assert replace(braced, problem=replace(braced.problem, contacts=rough)).holds() is enough


def test_a_proof_of_no_numbers_is_none() -> None:
    equations = start_equations(pile_on_a_slope(1, 20.0, 0.5).problem())
    points, rows = 4, 5
    nothing = Multipliers(
        np.zeros((6, 6)),
        np.zeros(rows),
        np.zeros((rows, rows)),
        np.zeros((points, rows, 3)),
        np.zeros(1),
        np.zeros((1, 3)),
    )
    assert not check_branch(equations, ProvenBranch((), nothing))


def test_products_of_what_may_be_negative_are_no_proof() -> None:
    braced = proof()
    (branch,) = braced.proof
    turned = replace(branch.multipliers, of_parts=branch.multipliers.of_parts - 1.0)
    assert not replace(braced, proof=(replace(branch, multipliers=turned),)).holds()


ROUND = np.array([1.0, -1.0, 1.0, -1.0, 0.0])  # a body opens at four corners so that this sum is nothing


def test_a_part_that_is_not_negative_takes_no_negative_multiplier_though_coefficients_agree() -> None:
    braced = proof()
    (branch,) = braced.proof
    turned = replace(branch.multipliers, of_loads=branch.multipliers.of_loads - 10.0 * ROUND)
    assert not replace(braced, proof=(replace(branch, multipliers=turned),)).holds()


def test_no_force_is_multiplied_by_what_is_outside_of_the_dual_of_its_cone_though_coefficients_agree() -> None:
    braced = proof()
    (branch,) = braced.proof
    of_forces = branch.multipliers.of_forces.copy()
    of_forces[0] += 10.0 * np.outer(ROUND, braced.problem.contacts[0].normals_W[0])
    turned = replace(branch.multipliers, of_forces=of_forces)
    assert not replace(braced, proof=(replace(branch, multipliers=turned),)).holds()


@pytest.mark.parametrize("point", range(4))
def test_the_force_of_every_point_counts(point: int) -> None:
    braced = proof()
    (branch,) = braced.proof
    of_forces = branch.multipliers.of_forces.copy()
    of_forces[point] += 1e-3
    turned = replace(branch.multipliers, of_forces=of_forces)
    assert not replace(braced, proof=(replace(branch, multipliers=turned),)).holds()


def test_branches_leave_nothing_out_if_each_question_has_both_answers() -> None:
    assert cover_every_case([()])
    assert cover_every_case([(OPENS,), (SHUT, UPHILL), (SHUT, UPHILL.opposite)])
    assert not cover_every_case([(SHUT, UPHILL), (SHUT, UPHILL.opposite)])
    assert not cover_every_case([(OPENS,), (SHUT, UPHILL)])
    assert not cover_every_case([])


def test_a_proof_without_one_of_its_branches_is_none() -> None:
    (braced,) = outcome(ladder(60.0, 0.5, 0.3).problem()).braced
    assert braced.holds()
    assert not replace(braced, proof=braced.proof[1:]).holds()
