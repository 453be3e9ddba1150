"""What tips as one body: the cheapest proof of falling."""

import pytest

from stability.contact_law import Coulomb
from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Contact, Placed, Problem, Tolerances, Wrench
from stability.statics.proof import check_motion
from stability.statics.tipping import tipping
from tests.stability.statics.test_propagation import patch

SIZE = (2.0, 2.0, 0.4)


def plank(name: str, x: float, z: float = 0.2, mass: float = 1.0) -> Placed:
    return Placed(Brick(name, Box(SIZE), mass), Pose((x, 0.0, z)))


def proves(bricks: dict[str, Placed], contacts: list[Contact]) -> bool:
    fall = tipping(bricks, contacts)
    if fall is None:
        return False
    loads = {name: Wrench((0.0, 0.0, -placed.brick.mass)) for name, placed in bricks.items()}
    return check_motion(Problem(bricks, contacts, loads), fall.motion, Tolerances()).holds


@pytest.mark.parametrize(("overhang", "falls"), [(1.0 - 1e-6, False), (1.0 + 1e-6, True)])
def test_a_plank_tips_once_its_centre_passes_the_edge(overhang: float, falls: bool) -> None:
    #      |--p--|
    # |----s----|
    edge = 1.0
    bricks = {"p": plank("p", edge + overhang - 1.0)}
    assert proves(bricks, [patch("s", "p", (overhang - 1.0, edge))]) is falls


def test_tipping_lets_a_brick_without_contacts_fall() -> None:
    assert proves({"p": plank("p", 0.0)}, [])


@pytest.mark.parametrize(("mass", "falls"), [(0.9, True), (1.1, False)])
def test_a_counterweight_is_part_of_the_body_that_tips(mass: float, falls: bool) -> None:
    bricks = {"p": plank("p", 0.5), "w": plank("w", -0.5, z=0.6, mass=mass)}
    assert proves(bricks, [patch("s", "p", (-0.5, 0.0))]) is falls


def test_on_one_point_a_plank_tips_any_way() -> None:
    contact = Contact("s", "p", ((0.0, 0.0, 0.0),), ((0.0, 0.0, 1.0),), Coulomb(0.5))
    assert proves({"p": plank("p", 0.1)}, [contact])


def test_on_a_line_a_plank_tips_to_the_side_of_its_centre() -> None:
    contact = Contact("s", "p", ((0.0, -1.0, 0.0), (0.0, 1.0, 0.0)), ((0.0, 0.0, 1.0),), Coulomb(0.5))
    assert proves({"p": plank("p", 0.1)}, [contact])
    assert proves({"p": plank("p", -0.1)}, [contact])


def test_a_wall_in_the_way_takes_the_proof_away() -> None:
    # Turning about the edge would drive the plank's end into the wall.
    wall = Contact("w", "p", ((1.5, 0.0, 0.0),), ((-1.0, 0.0, 0.0),), Coulomb(0.5))
    bricks = {"p": plank("p", 0.5)}
    below = patch("s", "p", (-0.5, 0.3))
    assert proves(bricks, [below])
    assert not proves(bricks, [below, wall])
