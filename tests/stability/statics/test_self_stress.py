"""Verdicts that rest on forces which may be there or not are told from those that do not."""

from dataclasses import replace
from math import cos, pi, sin

import pytest

from stability.contact_law import Coulomb
from stability.model import GROUND
from stability.problem import UP, Contact, Forces, Problem, Tolerances
from stability.statics.conic_program import ConicProgram, SolverPoint
from stability.statics.equilibrium import balance, separating_motion, separating_velocities, widest_separation
from stability.statics.proof import check_forces, least_separating_speed
from stability.statics.self_stress import forces_without_self_stress
from tests.stability.statics.hand_built import (
    EAST,
    LENGTH,
    THICKNESS,
    between_walls,
    column,
    inverted_v,
    ladder,
    level_patch,
    plank,
    stepped,
    wall_patch,
    weighed,
)

EXACT = Tolerances()


def honest(problem: Problem) -> Forces | None:
    forces = balance(problem).forces
    assert forces is not None
    found = forces_without_self_stress(problem, forces, EXACT)
    assert found is None or check_forces(problem, found, EXACT).holds
    return found


def pressed(forces: Forces, contact: int) -> float:
    return sum(abs(part) for point in forces.of_contacts[contact] for force in point for part in force)


def wedged(friction: float = 0.6) -> Problem:
    """A plank between two walls, and nothing under it."""
    lying = column([0.0])
    return between_walls(replace(lying, contacts=[]), friction)


def tripod() -> Problem:
    """A plate on three legs, which stand on rough ground."""
    legs, contacts = [], []
    for i in range(3):
        x, y = 0.03 * cos(2.0 * pi * i / 3.0), 0.03 * sin(2.0 * pi * i / 3.0)
        name = f"leg{i}"
        legs.append(plank(name, (x, y, 0.02), size=(0.01, 0.01, 0.04)))
        square = [(x + dx, y + dy) for dx, dy in ((-0.005, -0.005), (0.005, -0.005), (0.005, 0.005), (-0.005, 0.005))]
        contacts.append(Contact(GROUND, name, tuple((a, b, 0.0) for a, b in square), (UP,), Coulomb(0.5)))
        contacts.append(Contact(name, "plate", tuple((a, b, 0.04) for a, b in square), (UP,), Coulomb(0.5)))
    return weighed([*legs, plank("plate", (0.0, 0.0, 0.045), size=(0.1, 0.1, 0.01))], contacts)


def running_bond(columns: int, levels: int) -> Problem:
    """A wall of planks end to end, each course shifted by half a plank; their ends touch."""
    bricks, contacts = [], []
    places: dict[tuple[int, int], float] = {}
    for level in range(levels):
        for i in range(columns - level % 2):
            x, z = (i + 0.5 * (level % 2)) * LENGTH, level * THICKNESS
            name = f"{level:02}.{i:02}"
            places[level, i] = x
            bricks.append(plank(name, (x, 0.0, z + 0.5 * THICKNESS)))
            for (below, j), other in places.items():
                if below == level - 1 and abs(other - x) < 0.9 * LENGTH:
                    shared = (max(x, other) - 0.5 * LENGTH, min(x, other) + 0.5 * LENGTH)
                    contacts.append(Contact(f"{below:02}.{j:02}", name, level_patch(shared, z), (UP,), Coulomb(0.5)))
            if level == 0:
                contacts.append(Contact(GROUND, name, level_patch((x - 0.06, x + 0.06), 0.0), (UP,), Coulomb(0.5)))
            if i > 0:
                ends = wall_patch(x - 0.5 * LENGTH, (z, z + THICKNESS))
                contacts.append(Contact(f"{level:02}.{i - 1:02}", name, ends, (EAST,), Coulomb(0.5)))
    return weighed(bricks, contacts)


OPENED = {
    "column": stepped(10, 0.01),
    "ladder": ladder(1.0, 0.5, 0.3),
    "inverted V": inverted_v(1.2, 0.5),
    "tripod": tripod(),
    "wall of planks end to end": running_bond(5, 6),
    "rough ladder": ladder(1.3, 2.0, 2.0),
}


@pytest.mark.parametrize("name", OPENED)
def test_contacts_with_a_separating_motion_carry_no_self_stress(name: str) -> None:
    problem = OPENED[name]
    motion = separating_motion(problem)
    assert motion is not None
    assert least_separating_speed(problem, motion) > 0.0
    forces = balance(problem).forces
    assert forces is not None
    assert forces_without_self_stress(problem, forces, EXACT) is forces


def test_a_plank_wedged_between_two_walls_rests_on_self_stress() -> None:
    assert separating_motion(wedged()) is None
    assert honest(wedged()) is None


def test_a_wedged_plank_on_the_ground_does_without_the_walls() -> None:
    found = honest(between_walls(column([0.0])))
    assert found is not None
    assert pressed(found, 0) > 0.1  # its weight of 0.118 N
    assert pressed(found, 1) == pressed(found, 2) == 0.0


@pytest.mark.parametrize("friction", [0.3, 0.9, 2.0])
def test_a_stack_between_walls_does_without_them(friction: float) -> None:
    found = honest(between_walls(column([0.0] * 6), friction))
    assert found is not None
    assert all(pressed(found, i) > 0.1 for i in range(6))
    assert all(pressed(found, i) == 0.0 for i in range(6, 18))


def test_a_ladder_keeps_the_wall_it_needs_and_does_without_the_one_at_its_foot() -> None:
    # A block on the ground just behind the foot: foot and block can be pressed together, and hold nothing.
    leaning = ladder(1.1, 0.5)
    behind = Contact("block", "ladder", ((0.0, -0.012, 0.0), (0.0, 0.012, 0.0)), (EAST,), Coulomb(0.5))
    before = Contact("stop", "ladder", ((0.0, -0.012, 0.0), (0.0, 0.012, 0.0)), ((-1.0, 0.0, 0.0),), Coulomb(0.5))
    found = honest(replace(leaning, contacts=[*leaning.contacts, behind, before]))
    assert found is not None
    assert pressed(found, 0) > 0.1
    assert pressed(found, 1) > 0.01


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_plank_that_hangs_over_a_table_jams_between_walls(friction: float) -> None:
    # It tips but for the walls, between which its diagonal does not fit: they push at opposite corners, 8 mm apart in
    # height, and N x 8 mm = W x 10 mm balances the weight beyond the edge even where all is smooth.
    table = Contact("table", "p01", level_patch((-0.06, -0.01), 0.0), (UP,), Coulomb(friction))
    hanging = replace(column([0.0]), contacts=[table])
    assert balance(hanging).motion is not None
    assert honest(between_walls(hanging)) is not None


@pytest.mark.parametrize("friction", [0.5, 2.0, 5.0])
def test_a_block_in_a_groove_needs_no_more_than_its_normals_whatever_the_friction(friction: float) -> None:
    # Faces of 30 and 50 deg, along which friction above 1 could squeeze it: N1 and N2 alone carry its weight.
    faces = {"steep": (-0.06, (sin(1.0), 0.0, cos(1.0))), "flat": (0.06, (-sin(0.5), 0.0, cos(0.5)))}
    contacts = []
    for name, (x, normal) in faces.items():
        corners = tuple((x, y, z) for y in (-0.01, 0.01) for z in (-0.3, 0.3))
        contacts.append(Contact(name, "p01", corners, (normal,), Coulomb(friction)))
    found = honest(weighed([plank("p01", (0.0, 0.0, 0.0))], contacts))
    assert found is not None


def test_without_a_solver_nothing_is_honest_but_what_can_be_lifted() -> None:
    def dies(_: ConicProgram, __: float) -> SolverPoint:
        raise RuntimeError

    problem = between_walls(column([0.0]))
    forces = balance(problem).forces
    assert forces is not None
    assert forces_without_self_stress(problem, forces, EXACT, dies) is None
    assert separating_motion(stepped(3, 0.0), dies) is not None


def test_contacts_that_no_motion_opens_are_named() -> None:
    widest = widest_separation(between_walls(column([0.0, 0.0]), friction=0.0))
    assert widest is not None
    assert [separation > 0.5 for separation in widest.of_contacts] == [True, True, False, False, False, False]


def test_bricks_under_a_fixed_brick_have_no_separating_motion() -> None:
    stack = stepped(3, 0.0)
    assert separating_velocities(stack, ["p03"]) is not None
    assert separating_velocities(stack, ["p01", "p02", "p03"]) is not None
    assert separating_velocities(stack, ["p01", "p02"]) is None
