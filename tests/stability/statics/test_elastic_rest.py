"""What comes to rest on contacts that give a little and are pressed by loads alone, and under which forces."""

from dataclasses import replace
from itertools import pairwise
from math import cos, hypot, radians, sin, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from stability.contact_law import Coulomb
from stability.problem import Contact, Forces, Problem, Tolerances, Wrench
from stability.statics.elastic_rest import elastic_rest
from stability.statics.equilibrium import balance
from stability.statics.proof import check_forces
from stability.statics.wrench_matrix import wrench_matrix
from tests.stability.statics.hand_built import (
    EAST,
    between_walls,
    column,
    moved_by,
    plank,
    stepped,
    wall_patch,
    weighed,
)

EXACT = Tolerances()
WIDTH, DEPTH, WEIGHT = 0.12, 0.024, 0.11772  # [m], [m], [N] of a plank


def wedge(angle: float, friction: float, turn: float = 0.0) -> Problem:
    """A plank in a groove of walls that lean outwards by `angle` [deg], `turn`ed about the vertical [rad]."""
    lean = radians(angle)

    def turned(x: float, y: float, z: float) -> tuple[float, float, float]:
        return (x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn), z)

    def side(name: str, sign: float) -> Contact:
        ends = tuple(turned(sign * WIDTH / 2.0, y, 0.0) for y in (-DEPTH / 2.0, DEPTH / 2.0))
        return Contact(name, "wedge", ends, (turned(-sign * cos(lean), 0.0, sin(lean)),), Coulomb(friction))

    return weighed([plank("wedge", (0.0, 0.0, 0.0))], [side("east", 1.0), side("west", -1.0)])


def parts(problem: Problem, forces: Forces) -> list[tuple[float, float]]:
    """Of each point how hard it is pressed, and how large the friction is [N]."""
    found = []
    for contact, of_points in zip(problem.contacts, forces.of_contacts, strict=True):
        for (force,) in of_points:
            pressed = sum(a * b for a, b in zip(force, contact.normals_W[0], strict=True))
            across = [a - pressed * b for a, b in zip(force, contact.normals_W[0], strict=True)]
            found.append((pressed, hypot(*across)))
    return found


def closes_wherever_it_presses(problem: Problem, forces: Forces) -> bool:
    """Whether some motion closes every contact that presses, and slips against all friction: a linear program."""
    system = wrench_matrix(problem, carried=dict.fromkeys(problem.bricks, 1.0))
    pressed = system.rows_of(np.array([f for c in forces.of_contacts for p in c for f in p])).reshape(-1, 3)
    slips = system.matrix.toarray().reshape(len(pressed), 3, -1)
    rows, bounds = [], []
    for slip, (normal, *across) in zip(slips, pressed, strict=True):
        if normal > 1e-9 * pressed[:, 0].max():
            rows += [slip[0], across[0] * slip[1] + across[1] * slip[2]]
            bounds += [-1.0, 0.0]
    return bool(linprog(np.zeros(slips.shape[2]), rows, bounds, bounds=(None, None)).success)


@pytest.mark.parametrize("angle", [1.0, 10.0, 45.0])
@pytest.mark.parametrize("friction", [0.0, 0.1, 0.84, 2.0])
def test_a_wedge_pulls_itself_tight_as_its_springs_say(angle: float, friction: float) -> None:
    # With closing u sin and slip u cos on springs of 1 and mu^2, friction is used up if mu^2 cos > mu sin.
    problem = wedge(angle, friction)
    found = elastic_rest(problem)
    assert found is not None
    lean, used_up = radians(angle), friction > tan(radians(angle))
    if used_up:
        pressed = WEIGHT / 4.0 / (sin(lean) + friction * cos(lean))
    else:
        pressed = WEIGHT / 4.0 * sin(lean) / (sin(lean) ** 2 + (friction * cos(lean)) ** 2)
    rubbed = friction * pressed if used_up else friction**2 * pressed / tan(lean)
    assert parts(problem, found) == [pytest.approx((pressed, rubbed), rel=1e-9)] * 4


@pytest.mark.parametrize("angle", [0.0, -1e-3, -5.0, -30.0])
@pytest.mark.parametrize("friction", [0.0, 0.84, 2.0])
def test_between_walls_that_are_upright_or_lean_inwards_nothing_pulls_tight(angle: float, friction: float) -> None:
    assert elastic_rest(wedge(angle, friction)) is None


def test_a_wedge_that_sinks_a_thousand_times_as_far_as_it_closes_is_not_taken_to_hold() -> None:
    # It sinks by 1 / tan of its angle: 573 times at 0.1 deg, 1,146 times at 0.05 deg.
    assert elastic_rest(wedge(0.1, 0.5)) is not None
    assert elastic_rest(wedge(0.05, 0.5)) is None


@pytest.mark.parametrize("count", [2, 3, 5, 9])
def test_a_row_of_stones_between_upright_walls_comes_to_no_rest_though_an_arch_would_hold(count: int) -> None:
    x = [WIDTH * (i + 0.5 - 0.5 * count) for i in range(count)]
    stones = [plank(f"s{i}", (at, 0.0, 0.0), size=(WIDTH, DEPTH, WIDTH)) for i, at in enumerate(x)]
    names = ["west", *(stone.brick.id for stone in stones), "east"]
    joints = [x[0] - 0.5 * WIDTH, *(at + 0.5 * WIDTH for at in x)]
    contacts = [
        Contact(left, right, wall_patch(joint, (-0.5 * WIDTH, 0.5 * WIDTH)), (EAST,), Coulomb(1.0))
        for (left, right), joint in zip(pairwise(names), joints, strict=True)
    ]
    assert balance(weighed(stones, contacts)).forces is not None
    assert elastic_rest(weighed(stones, contacts)) is None


@pytest.mark.parametrize("leans", [(6.4, 8.2), (12.8, 14.1), (20.0, 40.0)])
@pytest.mark.parametrize("friction", [0.2, 0.6, 1.0])
def test_a_wedge_between_unlike_walls_is_found_to_rest(leans: tuple[float, float], friction: float) -> None:
    # They open upwards by the sum of what they lean; forces along normals alone would turn the wedge.
    east, west = (wedge(lean, friction).contacts for lean in leans)
    problem = replace(wedge(1.0, friction), contacts=[east[0], west[1]])
    found = elastic_rest(problem)
    assert found is not None
    assert closes_wherever_it_presses(problem, found)


def test_a_falling_structure_has_no_elastic_rest() -> None:
    assert elastic_rest(stepped(3, 0.07)) is None
    assert elastic_rest(replace(column([0.0]), contacts=[])) is None


def test_a_column_presses_with_what_is_above() -> None:
    problem = column([0.0] * 5)
    found = elastic_rest(problem)
    assert found is not None
    sums = [sum(pressed for pressed, _ in parts(problem, found)[4 * i : 4 * i + 4]) for i in range(5)]
    assert sums == [pytest.approx(WEIGHT * (5 - i), rel=1e-9) for i in range(5)]


def test_a_plank_between_upright_walls_presses_neither_of_them_if_it_has_a_ground() -> None:
    problem = between_walls(column([0.0]), 2.0)
    found = elastic_rest(problem)
    assert found is not None
    assert [pressed for pressed, _ in parts(problem, found)[4:]] == pytest.approx([0.0] * 8, abs=1e-12)


@settings(max_examples=40)
@given(
    angle=st.floats(0.6, 60.0),
    friction=st.floats(0.0, 2.0),
    turn=st.floats(-3.0, 3.0),
    weight=st.floats(1e-6, 1e6),
    shift=st.tuples(*[st.floats(-100.0, 100.0)] * 3),
)
def test_neither_place_nor_bearing_nor_weight_changes_how_a_wedge_holds(
    angle: float, friction: float, turn: float, weight: float, shift: tuple[float, float, float]
) -> None:
    plain, moved = wedge(angle, friction), moved_by(wedge(angle, friction, turn), shift)
    heavy = replace(moved, loads={"wedge": Wrench((0.0, 0.0, -weight))})
    one, other = elastic_rest(plain), elastic_rest(heavy)
    assert one is not None
    assert other is not None
    share = weight / WEIGHT
    expected = [pytest.approx((share * n, share * t), rel=1e-6, abs=1e-9 * weight) for n, t in parts(plain, one)]
    assert parts(heavy, other) == expected


def held_at_random(random: np.random.Generator) -> Problem:
    """A plank that some fixed bodies touch, from below and aside, in any direction."""
    contacts = []
    for i in range(random.integers(2, 7)):
        x, y, z = random.uniform(-0.5, 0.5, 3) * (0.12, 0.024, 0.008)
        normal = random.normal(size=3)
        normal[2] = abs(normal[2]) * random.choice([0.2, 1.0])
        nx, ny, nz = (normal / np.linalg.norm(normal)).tolist()
        contacts.append(
            Contact(f"peg{i}", "plank", ((x, y, z),), ((nx, ny, nz),), Coulomb(float(random.uniform(0.05, 1.5))))
        )
    return weighed([plank("plank", (0.0, 0.0, 0.0))], contacts)


def test_whatever_comes_to_rest_closes_where_it_presses_and_slips_against_friction() -> None:
    # The reference is a linear program that knows forces alone, and no springs.
    random, rested = np.random.default_rng(5), 0
    for _ in range(60):
        problem = held_at_random(random)
        found = elastic_rest(problem)
        if found is not None:
            rested += 1
            assert check_forces(problem, found, EXACT).holds
            assert closes_wherever_it_presses(problem, found)
    assert rested > 6


def test_forces_of_a_squeezed_plank_close_nothing() -> None:
    problem = wedge(0.0, 1.0)
    squeezed = Forces(
        tuple(((((-WEIGHT * c.normals_W[0][0] * -1.0, 0.0, WEIGHT / 4.0),),) * 2) for c in problem.contacts)
    )
    assert check_forces(problem, squeezed, EXACT).holds
    assert not closes_wherever_it_presses(problem, squeezed)
