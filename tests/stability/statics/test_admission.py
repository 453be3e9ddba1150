"""Numbers that mean nothing are refused, with what is wrong and what to do, and nothing changes."""

from math import inf, nan
from typing import Any

import pytest

from stability.geometry.box import Box
from stability.model import Brick, Plane, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly

SIZE = (0.12, 0.024, 0.008)
AT = (0.0, 0.0, 0.004)
UNTURNED = (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("mass", [nan, inf, 0.0, -1.0])
def test_a_mass_is_a_number_above_nothing(mass: float) -> None:
    with pytest.raises(ValueError, match="the mass of brick 'a' is"):
        Assembly().add(Brick("a", Box(SIZE), mass), Pose(AT))


@pytest.mark.parametrize(
    "size", [(0.0, 1.0, 1.0), (-0.1, 1.0, 1.0), (nan, 1.0, 1.0), (1.0, inf, 1.0), (1.0, 1.0), (1e300,) * 3]
)
def test_every_side_of_a_brick_has_a_length(size: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match=r"the size of (brick )?'a' is"):
        Assembly().add(Brick("a", Box(size), 1.0), Pose(AT))


def test_a_size_where_a_shape_is_due_is_told_how_to_be_one() -> None:
    size: Any = SIZE
    with pytest.raises(ValueError, match=r"the shape of brick 'a' is \(.*\); write Box\(\(0.12, 0.024, 0.008\)\)"):
        Assembly().add(Brick("a", size, 1.0), Pose(AT))


@pytest.mark.parametrize(
    "turn", [(0.0, 0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 2.0), (nan, 0.0, 0.0, 1.0)]
)
def test_a_turn_is_a_quaternion_of_unit_length(turn: tuple[float, float, float, float]) -> None:
    with pytest.raises(ValueError, match=r"the orientation of (brick )?'a' is"):
        Assembly().add(Brick("a", Box(SIZE), 1.0), Pose(AT, turn))


@pytest.mark.parametrize("at", [(nan, 0.0, 0.0), (inf, 0.0, 0.0), (1e300, 0.0, 0.0), (0.0, 0.0)])
def test_a_place_is_three_numbers(at: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="'a'"):
        Assembly().add(Brick("a", Box(SIZE), 1.0), Pose(at))


@pytest.mark.parametrize("friction", [nan, inf, -0.5])
def test_friction_is_nothing_or_more(friction: float) -> None:
    with pytest.raises(ValueError, match="the friction is"):
        Assembly(friction=friction)
    with pytest.raises(ValueError, match="the friction of plane 'ground' is"):
        Assembly(planes=[Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)])


@pytest.mark.parametrize("gravity", [nan, inf, 0.0, -9.81])
def test_gravity_points_down(gravity: float) -> None:
    with pytest.raises(ValueError, match="the gravity is"):
        Assembly(gravity=gravity)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 2.0), (0.0, 0.0, 0.0), (nan, 0.0, 1.0)])
def test_a_normal_is_of_unit_length(normal: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match=r"the normal of (plane )?'ground' is"):
        Assembly(planes=[Plane("ground", (0.0, 0.0, 0.0), normal, 0.5)])


def test_fixed_bodies_have_names_of_their_own() -> None:
    ground = Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
    table = Placed(Brick("ground", Box((1.0, 1.0, 0.1)), 1.0), Pose((0.0, 0.0, 1.0)))
    with pytest.raises(ValueError, match="two bodies with the name 'ground'"):
        Assembly(planes=[ground, ground])
    with pytest.raises(ValueError, match="two bodies with the name 'ground'"):
        Assembly(planes=[ground], tables=[table])


def test_a_refused_brick_leaves_the_assembly_unchanged() -> None:
    assembly = Assembly()
    assembly.add(Brick("a", Box(SIZE), 1.0), Pose(AT))
    good, bad = (
        Placed(Brick("b", Box(SIZE), 1.0), Pose((0.0, 0.0, 0.012))),
        Placed(Brick("c", Box(SIZE), nan), Pose(AT)),
    )
    with pytest.raises(ValueError, match="'c'"):
        assembly.add_all([good, bad])
    with pytest.raises(ValueError, match="'a'"):
        assembly.move("a", Pose(AT, (0.0, 0.0, 0.0, 0.0)))
    with pytest.raises(LookupError, match="no brick 'z'"):
        assembly.remove(["a", "z"])
    with pytest.raises(LookupError, match="no brick 'z'"):
        assembly.move("z", Pose(AT))
    with pytest.raises(TypeError, match="collection of names"):
        assembly.remove("a")
    assert set(assembly.bricks) == {"a"}
    assert assembly.verdict().stability is Stability.STABLE
    assert assembly.forces() is not None


def test_a_name_that_is_given_twice_is_removed_once() -> None:
    assembly = Assembly()
    assembly.add(Brick("a", Box(SIZE), 1.0), Pose(AT, UNTURNED))
    assert assembly.remove(["a", "a"]).stability is Stability.STABLE
    assert not assembly.bricks
