"""What is of another kind than statics asks for is refused with what was expected, and not deep inside by Python."""

from collections.abc import Callable
from typing import Any

import pytest

from stability import (
    Assembly,
    Box,
    Brick,
    OffCentreBox,
    Placed,
    Plane,
    Pose,
    ProvenStability,
    margins,
    prism,
    solid_of_corners,
    solid_of_mesh,
)

NAN = float("nan")
WHERE = Pose((0.0, 0.0, 0.05))
TETRAHEDRON = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
Loose = Any  # what a type checker would refuse


def added(shape: Loose = Box((0.1, 0.1, 0.1)), mass: Loose = 1.0, pose: Loose = WHERE, name: Loose = "a") -> object:  # noqa: B008 -- frozen
    return Assembly().add(Brick(name, shape, mass), pose)


def standing() -> Assembly:
    assembly = Assembly()
    assembly.add(Brick("a", Box((0.1, 0.1, 0.1)), 1.0), WHERE)
    return assembly


def loose(value: object) -> Loose:
    return value


@pytest.mark.parametrize(
    ("call", "error", "told"),
    [
        (
            lambda: added(Box(loose("abc"))),
            TypeError,
            "the size of 'a' is 'abc'; write length, width and thickness, in m",
        ),
        (lambda: added(Box(loose((0.1, 0.1)))), ValueError, r"is \(0.1, 0.1\); write length, width and thickness"),
        (lambda: added(Box((0.1, 0.1, NAN))), ValueError, "write length, width and thickness, in metres"),
        (lambda: added(None), TypeError, r"the shape of brick 'a' is None; write Box\(\(length, width, thickness\)\)"),
        (lambda: added(mass="1 kg"), TypeError, "the mass of brick 'a' is '1 kg'; write a number"),
        (lambda: added(name=3), TypeError, "the name of a brick is 3; write a string"),
        (lambda: added(pose=(0, 0, 0.05)), TypeError, r"write Pose\(\(x, y, z\)\), in metres"),
        (lambda: added(pose=Pose(loose("000"))), TypeError, "the position of 'a' is '000'; write x, y and z in metres"),
        (lambda: added(pose=Pose((0, 0, 0), loose(None))), TypeError, "write a quaternion x, y, z, w, as 4 numbers"),
        (
            lambda: added(OffCentreBox((0.1, 0.1, 0.1), loose((0, 0)))),
            ValueError,
            "from the centre of the box, in metres",
        ),
        (lambda: added(OffCentreBox((0.1, 0.1, 0.1), (0, 0, 1))), ValueError, "outside the box"),
        (lambda: Assembly().add(loose("brick"), WHERE), TypeError, r"expected Brick\(name, shape, mass\), not 'brick'"),
        (lambda: Assembly().add_all([loose("a")]), TypeError, r"expected Placed\(brick, pose\), not 'a'"),
        (lambda: Assembly().add_all(loose(Placed(loose(1), WHERE))), TypeError, "a collection of bricks"),
        (
            lambda: Assembly(friction=loose("0.5")),
            TypeError,
            "the friction is '0.5'; write a coefficient of at least 0",
        ),
        (lambda: Assembly(gravity=loose("g")), TypeError, "in m/s2"),
        (lambda: Assembly(loose(0.5)), TypeError, r"a collection of planes, such as \[Plane\(...\)\]"),
        (lambda: Assembly([Plane("g", (0, 0, 0), loose("up"), 0.5)]), TypeError, "the outward normal"),
        (lambda: standing().move("a", loose((0, 0, 1))), TypeError, r"write Pose\(\(x, y, z\)\)"),
        (lambda: standing().remove(loose(3)), TypeError, r"a collection of names, such as \['a'\]"),
        (lambda: standing().problem("b"), LookupError, "there is no brick 'b'"),
        (lambda: margins(loose(standing())), TypeError, r"`assembly.problem\(\)`, not Assembly"),
        (lambda: prism(loose("abc"), 0.1), TypeError, "corners of an outline, each x and z in metres"),
        (lambda: prism([(0, 0), (1, 0), (0, NAN)], 0.1), ValueError, r"point 3 is \(0, nan\); write x and z in metres"),
        (lambda: prism([(0, 0), (1, 0), (0, 1)], -0.1), ValueError, "write a number from"),
        (lambda: solid_of_corners([loose((0, 0))]), ValueError, r"point 1 is \(0, 0\); write x, y and z in metres"),
        (lambda: solid_of_mesh(TETRAHEDRON, [(0, 1, 9)]), ValueError, "face 1 is .* corner numbers run from 0 to 3"),
        (lambda: solid_of_mesh(TETRAHEDRON, [loose("ab")]), TypeError, "list the numbers of its corners, from 0"),
        (lambda: ProvenStability(loose("engine")), TypeError, r"such as PyBulletBodies\(client\), not 'engine'"),
    ],
)
def test_an_invalid_brick_is_refused_with_the_expected_value(
    call: Callable[[], object], error: type[Exception], told: str
) -> None:
    with pytest.raises(error, match=told):
        call()


def test_an_invalid_brick_leaves_the_assembly_unchanged() -> None:
    assembly = standing()
    with pytest.raises(TypeError):
        assembly.move("a", Pose(loose("abc")))
    assert assembly.bricks["a"].pose == WHERE
    assert assembly.verdict().stability == "stable"
