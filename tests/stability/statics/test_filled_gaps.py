"""Thin sheets between thick bodies: what lies on a sheet does not touch what is below it, however thin the sheet is."""

from itertools import permutations
from math import atan, cos, sin

import pytest

from stability.contact_law import Friction
from stability.geometry.box import Box
from stability.geometry.vectors import multiply, rotate
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Placed, Stability, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.structure import Structure
from tests.stability.statics.closed_forms import level_ground

CARTON, SHEET = (0.3, 0.2, 0.15), (0.4, 0.3, 0.001)  # a sheet is much thinner than 2 % of a carton [m]


def put(name: str, size: Vec3, bottom: float, x: float = 0.0) -> Placed:
    return Placed(Brick(name, Box(size), 1.0), Pose((x, 0.0, bottom + 0.5 * size[2])))


def touching(assembly: Assembly) -> set[tuple[str, str]]:
    return {(contact.lower, contact.upper) for contact in assembly.all_contacts()}


LOW, THIN, TOP = put("low", CARTON, 0.0), put("sheet", SHEET, 0.15), put("top", CARTON, 0.151)


@pytest.mark.parametrize("order", list(permutations((LOW, THIN, TOP))), ids=lambda o: "-".join(p.brick.id for p in o))
def test_a_carton_on_a_sheet_touches_the_sheet_alone_whichever_came_first(order: tuple[Placed, ...]) -> None:
    assembly = Assembly()
    for placed in order:
        assembly.add(placed.brick, placed.pose)
    assert touching(assembly) == {(GROUND, "low"), ("low", "sheet"), ("sheet", "top")}
    assert assembly.verdict().stability is Stability.STABLE
    assert assembly.forces() is not None
    assert assembly.remove(["sheet"]).stability is Stability.STABLE
    assert touching(assembly) == {(GROUND, "low"), ("low", "top")}  # a millimetre is contact where nothing is in it


@pytest.mark.parametrize("order", list(permutations((LOW, THIN, TOP))), ids=lambda o: "-".join(p.brick.id for p in o))
def test_a_sheet_that_was_removed_and_put_back_fills_the_gap_again(order: tuple[Placed, ...]) -> None:
    structure = Structure((level_ground(),), (), 0.5, 9.81, Tolerances())
    for placed in order:
        structure.put(placed)
    touched = {GROUND: {"low"}, "low": {GROUND, "sheet"}, "sheet": {"low", "top"}, "top": {"sheet"}}
    for _ in range(2):
        assert {name: set(structure.touching[name]) for name in structure.bricks} == {
            name: touched[name] for name in structure.bricks
        }
        assert [contact.lower for contact in structure.supports["top"]] == ["sheet"]
        assert structure.carried["low"] == ["sheet"]
        structure.take("sheet")
        structure.put(THIN)


def test_two_sheets_on_each_other_keep_a_carton_off_the_ground() -> None:
    assembly = Assembly()
    assembly.add_all([put("s1", SHEET, 0.0), put("s2", SHEET, 0.001), put("top", CARTON, 0.002)])
    assert touching(assembly) == {(GROUND, "s1"), ("s1", "s2"), ("s2", "top")}
    assembly.remove(["s2"])
    assert touching(assembly) == {
        (GROUND, "s1"),
        (GROUND, "top"),
    }  # it hangs above the sheet by more than that is thick


def test_a_sheet_beside_the_gap_fills_none() -> None:
    assembly = Assembly()
    assembly.add_all([put("top", CARTON, 0.001), put("sheet", SHEET, 0.0, x=0.5)])
    assert touching(assembly) == {(GROUND, "top"), (GROUND, "sheet")}


def test_a_sheet_upright_between_two_cartons_keeps_them_apart() -> None:
    side = Placed(Brick("sheet", Box((0.0001, 0.2, 0.1)), 0.1), Pose((0.0, 0.0, 0.05)))
    assembly = Assembly()
    assembly.add_all([put("a", CARTON, 0.0, x=-0.15005), side, put("b", CARTON, 0.0, x=0.15005)])
    beside = {pair for pair in touching(assembly) if GROUND not in pair}
    assert beside == {("a", "sheet"), ("b", "sheet")}


def test_a_hypothetical_sheet_fills_no_gap() -> None:
    assembly = Assembly()
    assembly.add_all([LOW, TOP])
    before = assembly.all_contacts(), assembly.forces()
    assembly.would(THIN.brick, THIN.pose)
    assert (assembly.all_contacts(), assembly.forces()) == before


@pytest.mark.parametrize(("share", "expected"), [(1.0 - 1e-6, Stability.UNSTABLE), (1.0 + 1e-6, Stability.STABLE)])
@pytest.mark.parametrize("below", ["ground", "carton"])
def test_a_carton_slides_on_a_sheet_of_a_millimetre_as_that_lets_it(
    share: float, expected: Stability, below: str
) -> None:
    tangent = 0.2
    half = 0.5 * atan(tangent)
    turn = (0.0, sin(half), 0.0, cos(half))
    pile = [THIN, TOP, LOW] if below == "carton" else [put("sheet", SHEET, 0.0), put("top", CARTON, 0.001)]
    law = Friction(0.6, between={("sheet", "top"): share * tangent})
    plane = Plane(GROUND, (0.0, 0.0, 0.0), rotate(turn, level_ground().normal_W), 0.6)
    verdict = Assembly((plane,), law).add_all(
        Placed(each.brick, Pose(rotate(turn, each.pose.position_W), multiply(turn, each.pose.orientation)))
        for each in pile
    )
    assert verdict.stability is expected
    assert verdict.moving == (("top",) if expected is Stability.UNSTABLE else ())
