"""Errors of the public names for wrong values, in terms of the caller."""

import traceback
from collections.abc import Callable
from fractions import Fraction
from math import inf, nan

import numpy as np
import pytest

from stability import (
    Assembly,
    Box,
    Brick,
    Friction,
    OffCentreBox,
    Placed,
    Plane,
    Pose,
    bricks_in_poses,
    bricks_of,
    forces_of,
    margins,
    outcome,
    pose_of,
    prism,
    solid_of_corners,
    solid_of_mesh,
)
from tests.paths import ROOT

ODD = [
    None, True, "x", b"x", 0, 5, -1.0, 1e-200, 1e200, nan, inf, 10**400, 10**5000, 1j, [], {}, {"a": 1}, [1], object(),
    (1e-200,) * 3, (1e200,) * 3, (10**400,) * 3, (None,) * 3, [(0.0, 0.0, 0.0)] * 4, np.array([1.0, 2.0, 3.0]),
    np.array([]), np.array(3), Fraction(10**400), Fraction(1, 3), iter([1]),
]  # fmt: skip
BOX, POSE = Box((0.1, 0.1, 0.1)), Pose((0.0, 0.0, 0.05))
BRICK = Brick("a", BOX, 1.0)
ABOVE = Pose((0.0, 0.0, 0.15))
CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
LOOPS = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
TRIANGLE = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]


def standing(**site: object) -> Assembly:
    assembly = Assembly(**site)  # type: ignore[arg-type]
    assembly.add(BRICK, POSE)
    return assembly


# Calls with one odd value each.
CALLS: dict[str, Callable[..., object]] = {
    "planes": lambda odd: standing(planes=odd),
    "plane": lambda odd: standing(planes=[odd]),
    "friction": lambda odd: standing(friction=odd),
    "gravity": lambda odd: standing(gravity=odd),
    "tolerances": lambda odd: standing(tolerances=odd),
    "tables": lambda odd: standing(tables=odd),
    "overlap": lambda odd: standing(overlap=odd),
    "usual": lambda odd: standing(friction=Friction(odd)),
    "own": lambda odd: standing(friction=Friction(0.5, odd)),
    "own of one": lambda odd: standing(friction=Friction(0.5, {"a": odd})),
    "between": lambda odd: standing(friction=Friction(0.5, {}, odd)),
    "between two": lambda odd: standing(friction=Friction(0.5, {}, {("a", "ground"): odd})),
    "kinds": lambda odd: standing(friction=Friction(0.5, kinds=odd)),
    "kind": lambda odd: standing(friction=Friction(0.5, {"k": 0.2}, kinds={"a": odd})),
    "rule": lambda odd: standing(friction=Friction(0.5, rule=odd)),
    "times": lambda odd: Friction(0.5).times(odd),
    "on": lambda odd: Friction(0.5).on("a", odd),
    "plane id": lambda odd: standing(planes=[Plane(odd, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)]),
    "plane point": lambda odd: standing(planes=[Plane("p", odd, (0.0, 0.0, 1.0), 0.5)]),
    "plane normal": lambda odd: standing(planes=[Plane("p", (0.0, 0.0, 0.0), odd, 0.5)]),
    "plane friction": lambda odd: standing(planes=[Plane("p", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), odd)]),
    "brick": lambda odd: standing().add(odd, ABOVE),
    "id": lambda odd: standing().add(Brick(odd, BOX, 1.0), ABOVE),
    "shape": lambda odd: standing().add(Brick("b", odd, 1.0), ABOVE),
    "mass": lambda odd: standing().add(Brick("b", BOX, odd), ABOVE),
    "size": lambda odd: standing().add(Brick("b", Box(odd), 1.0), ABOVE),
    "side": lambda odd: standing().add(Brick("b", Box((0.1, odd, 0.1)), 1.0), ABOVE),
    "size off centre": lambda odd: standing().add(Brick("b", OffCentreBox(odd, (0.0, 0.0, 0.0)), 1.0), ABOVE),
    "centre of mass": lambda odd: standing().add(Brick("b", OffCentreBox((0.1, 0.1, 0.1), odd), 1.0), ABOVE),
    "pose": lambda odd: standing().add(Brick("b", BOX, 1.0), odd),
    "position": lambda odd: standing().add(Brick("b", BOX, 1.0), Pose(odd)),
    "height": lambda odd: standing().add(Brick("b", BOX, 1.0), Pose((0.0, 0.0, odd))),
    "orientation": lambda odd: standing().add(Brick("b", BOX, 1.0), Pose((0.0, 0.0, 0.15), odd)),
    "bricks": lambda odd: standing().add_all(odd),
    "placed": lambda odd: standing().would_all([odd]),
    "placed brick": lambda odd: standing().add_all([Placed(odd, ABOVE)]),
    "remove": lambda odd: standing().remove(odd),
    "remove one": lambda odd: standing().would_without([odd]),
    "move": lambda odd: standing().move(odd, POSE),
    "move to": lambda odd: standing().move("a", odd),
    "stage": lambda odd: standing().stage(odd),
    "rests on": lambda odd: standing().rests_on(odd),
    "restore": lambda odd: standing().restore(odd),
    "problem": margins,
    "tolerance": lambda odd: margins(standing().problem(), odd),
    "margin of gravity": lambda odd: margins(standing().problem(), gravity=odd),
    "margin on planes": lambda odd: margins(standing().problem(), planes=odd),
    "outcome": outcome,
    "forces": lambda odd: outcome(standing().problem(), odd),
    "forces of": forces_of,
    "bricks of": bricks_of,
    "pose of": pose_of,
    "names": lambda odd: bricks_in_poses(odd, (0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0)),
    "shapes": lambda odd: bricks_in_poses(["a", "b"], odd, 1.0, (0.0, 0.0, 0.0)),
    "masses": lambda odd: bricks_in_poses(["a", "b"], (0.1, 0.1, 0.1), odd, (0.0, 0.0, 0.0)),
    "positions": lambda odd: bricks_in_poses(["a", "b"], (0.1, 0.1, 0.1), 1.0, odd),
    "orientations": lambda odd: bricks_in_poses(["a", "b"], (0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), odd),
    "outline": lambda odd: prism(odd, 0.1),
    "corner of an outline": lambda odd: prism([*TRIANGLE[:2], (odd, 1.0)], 0.1),
    "depth": lambda odd: prism(TRIANGLE, odd),
    "corners": solid_of_corners,
    "corner": lambda odd: solid_of_corners([*CORNERS[:3], odd]),
    "part of a corner": lambda odd: solid_of_corners([*CORNERS[:3], (0.0, 0.0, odd)]),
    "centre of a solid": lambda odd: solid_of_corners(CORNERS, odd),
    "corners of a mesh": lambda odd: solid_of_mesh(odd, LOOPS),
    "faces": lambda odd: solid_of_mesh(CORNERS, odd),
    "face": lambda odd: solid_of_mesh(CORNERS, [*LOOPS[:3], odd]),
    "corner of a face": lambda odd: solid_of_mesh(CORNERS, [*LOOPS[:3], (1, 2, odd)]),
}


def refusal(call: str, odd: object) -> Exception | None:
    """Return the error of a call; None if it accepts its arguments."""
    try:
        CALLS[call](odd)
    except (TypeError, ValueError, LookupError) as error:
        return error
    return None


@pytest.mark.parametrize("call", CALLS)
def test_an_odd_value_is_accepted_or_rejected_with_a_specific_error(call: str) -> None:
    errors = [error for odd in ODD if (error := refusal(call, odd)) is not None]
    assert errors
    for error in errors:
        raised = traceback.extract_tb(error.__traceback__)[-1]
        assert raised.filename.startswith(str(ROOT / "stability")), str(error)
        assert (raised.line or "").startswith("raise"), str(error)
        assert 10 < len(str(error)) < 400


@pytest.mark.parametrize("scale", [1e-200, 1e-100, 1e-10, 1e10, 1e100, 1e200])
def test_a_solid_beyond_all_measure_is_refused(scale: float) -> None:
    corners = [(scale * x, scale * y, scale * z) for x, y, z in CORNERS]
    with pytest.raises(ValueError, match=r"(less than|within) 1e"):
        solid_of_corners(corners)
    with pytest.raises(ValueError, match=r"(less than|within) 1e"):
        solid_of_mesh(corners, LOOPS)
    with pytest.raises(ValueError, match="from 1e-09 to 1e\\+09"):
        prism(TRIANGLE, scale)


@pytest.mark.parametrize(
    ("call", "odd", "message"),
    [
        ("own", 5, r"`own` of a Friction is 5; write a mapping, such as \{'sheet': 0.2\}"),
        ("forces of", "x", "expected an Assembly, not 'x'"),
        pytest.param("mass", 10**5000, "the mass of brick 'b' is a number of 16610 bits; write a number", id="huge"),
        ("height", 10**400, "the position of 'b' is"),
        ("size", np.array([0.1, 0.1, 0.1]), r"write a tuple, as in Box\(\(0.4, 0.3, 0.2\)\)"),
        ("gravity", 10**400, "the gravity is 1000.*; write a number from"),
        ("tolerance", 0.0, "the tolerance is 0.0; write a fraction of the limit"),
    ],
)
def test_the_error_states_the_problem_and_the_remedy(call: str, odd: object, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        CALLS[call](odd)


def test_a_margin_on_no_plane_that_is_there_has_an_answer() -> None:
    found = margins(standing().problem(), planes=[])
    assert found is not None
    assert found.placement > 0.0
