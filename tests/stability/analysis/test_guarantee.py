"""Rest is guaranteed where forces along normals alone balance everything; where friction is needed, it is possible."""

from dataclasses import replace
from math import cos, radians, sin

import pytest

from stability.analysis.margins import guarantee
from stability.contact_law import Coulomb
from stability.geometry.box import Box
from stability.model import Brick, Plane, Pose
from stability.problem import Forces, Placed, Stability
from stability.statics.assembly import LEVEL_GROUND, Assembly
from stability.statics.proof import check_forces


def assembly(*bricks: Placed, planes: tuple[Plane, ...] = (LEVEL_GROUND,), friction: float = 0.5) -> Assembly:
    made = Assembly(planes, friction)
    assert made.add_all(bricks).stability is Stability.STABLE
    return made


def guaranteed(made: Assembly) -> bool:
    return guarantee(made.problem(), made.forces()) is not None


def cube(name: str, x: float, z: float, angle: float = 0.0) -> Placed:
    """A cube of 0.1 m, turned about y [deg]."""
    half = radians(angle) / 2.0
    return Placed(Brick(name, Box((0.1, 0.1, 0.1)), 1.0), Pose((x, 0.0, z), (0.0, sin(half), 0.0, cos(half))))


def slope(name: str, angle: float, friction: float) -> Plane:
    """A plane through the origin, whose normal leans towards +x [deg]."""
    return Plane(name, (0.0, 0.0, 0.0), (sin(radians(angle)), 0.0, cos(radians(angle))), friction)


def test_a_stack_on_level_ground_is_guaranteed_even_where_it_stands_over_the_edge() -> None:
    assert guaranteed(assembly(cube("a", 0.0, 0.05), cube("b", 0.049, 0.15)))


def test_a_cube_on_a_slope_is_possible_since_friction_holds_it() -> None:
    angle = 10.0
    centre = (0.05 * sin(radians(angle)), 0.05 * cos(radians(angle)))
    on_slope = assembly(cube("a", *centre, angle=angle), planes=(slope("ground", angle, 0.5),))
    assert not guaranteed(on_slope)


def test_a_cube_in_a_groove_is_guaranteed_since_both_sides_press_it_up() -> None:
    groove = (slope("ground", 45.0, 0.3), slope("wall1", -45.0, 0.3))
    assert guaranteed(assembly(cube("a", 0.0, 0.05 * 2.0**0.5, angle=45.0), planes=groove))


def test_a_wall_beside_a_cube_that_the_ground_carries_takes_no_guarantee_away() -> None:
    groove = (slope("ground", 0.0, 0.3), slope("wall1", 90.0, 0.3))
    assert guaranteed(assembly(cube("a", 0.05, 0.05), planes=groove))


def test_a_falling_structure_has_no_guarantee() -> None:
    falling = Assembly()
    assert falling.add_all([cube("a", 0.0, 0.05), cube("b", 0.051, 0.15)]).stability is Stability.UNSTABLE
    assert not guaranteed(falling)


def test_a_guarantee_holds_a_kilometre_away_as_well() -> None:
    assert guaranteed(assembly(cube("a", 1000.0, 0.05), cube("b", 1000.049, 0.15)))


def test_the_certificate_is_along_the_normals_and_balances_without_friction() -> None:
    made = assembly(cube("a", 0.0, 0.05), cube("b", 0.02, 0.15))
    problem = made.problem()
    forces = guarantee(problem)
    assert forces is not None
    smooth = replace(problem, contacts=[replace(contact, law=Coulomb(0.0)) for contact in problem.contacts])
    assert check_forces(smooth, forces, made._structure.tolerances).holds


def test_known_forces_that_lean_on_friction_are_no_certificate() -> None:
    made = assembly(cube("a", 0.0, 0.05))
    problem, forces = made.problem(), made.forces()
    assert forces is not None
    (contact,) = forces.of_contacts
    pushed = Forces((tuple(tuple((x + 1.0, y, z) for x, y, z in each) for each in contact),))
    found = guarantee(problem, pushed)
    assert found is not None
    assert found != pushed


@pytest.mark.parametrize("gap", [0.0, 1e-4])
def test_nothing_is_guaranteed_across_a_gap(gap: float) -> None:
    made = assembly(cube("a", 0.0, 0.05), cube("b", 0.02, 0.15 + gap))
    assert made.verdict().stability is Stability.STABLE
    assert guaranteed(made) is (gap == 0.0)


def test_a_certificate_leaves_out_a_gap_that_it_does_not_need() -> None:
    low = Placed(Brick("low", Box((0.1, 0.1, 0.0999)), 1.0), Pose((0.0, 0.2, 0.04995)))
    lid = Placed(Brick("lid", Box((0.1, 0.5, 0.1)), 5.0), Pose((0.0, 0.04, 0.15)))
    made = assembly(cube("a", 0.0, 0.05), lid, low)
    problem, forces = made.problem(), guarantee(made.problem(), made.forces())
    assert forces is not None
    for contact, of_points in zip(problem.contacts, forces.of_contacts, strict=True):
        for gap, (force,) in zip(contact.gaps, of_points, strict=False):
            assert gap == 0.0 or force == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("friction", [0.01, 0.5, 5.0])
def test_a_guarantee_does_not_ask_how_much_friction_there_is(friction: float) -> None:
    assert guaranteed(assembly(cube("a", 0.0, 0.05), cube("b", 0.03, 0.15), friction=friction))
