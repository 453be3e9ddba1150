"""What slides on a slip sheet, and the sheet below it: each by the friction of its own contact, without an engine."""

from math import cos, radians, sin

import pytest

from stability.exact.release import release_until_stable
from stability.friction_law import Friction, GivenFriction
from stability.geometry.rotations import rotate
from stability.model import GROUND, Brick, Plane, Pose
from stability.motion.frictional_motion import FrictionalMotion, frictional_motion_of
from stability.shapes.box import Box
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed

SLOPE, GRAVITY, STEP, STEPS = radians(15.0), 9.81, 1e-3, 100
TURN = (0.0, sin(0.5 * SLOPE), 0.0, cos(0.5 * SLOPE))
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (sin(SLOPE), 0.0, cos(SLOPE)), 0.9)
SHEET = Placed(Brick("sheet", Box((0.6, 0.3, 0.02)), 0.5), Pose(rotate(TURN, (0.0, 0.0, 0.01)), TURN))
BLOCK = Placed(Brick("block", Box((0.1, 0.1, 0.02)), 0.5), Pose(rotate(TURN, (0.0, 0.0, 0.03)), TURN))


def begun(friction: GivenFriction) -> FrictionalMotion:
    """How the block on the sheet begins to move."""
    assembly = Assembly((FLOOR,), friction, GRAVITY)
    falling = release_until_stable(assembly, assembly.add_all([SHEET, BLOCK])).released.keys()
    whole = Assembly((FLOOR,), friction, GRAVITY)
    whole.add_all([SHEET, BLOCK])
    found = frictional_motion_of(whole.problem(), falling, GRAVITY, (), (FLOOR,), friction)
    assert found is not None
    return found


def ways(friction: GivenFriction) -> dict[str, float]:
    """How far downhill each brick that moves has come [m]."""
    motion = begun(friction)
    assert all(motion.goes_on(STEP) for _ in range(STEPS))
    started = {placed.brick.id: placed.pose.position_W for placed in (SHEET, BLOCK)}
    return {name: (state.pose.position_W[0] - started[name][0]) / cos(SLOPE) for name, state in motion.states().items()}


def way(acceleration: float) -> float:
    """From rest, with an acceleration in parts of gravity [m]."""
    return 0.5 * GRAVITY * acceleration * (STEPS * STEP) ** 2


def test_a_block_slides_down_its_sheet_by_what_the_friction_of_the_two_leaves() -> None:
    gone = ways(Friction(0.9, own={"block": 0.1}))
    assert gone == {"block": pytest.approx(way(sin(SLOPE) - 0.1 * cos(SLOPE)), rel=1e-6)}


def test_a_sheet_slides_with_what_lies_on_it_by_its_friction_on_the_ground() -> None:
    gone = ways(Friction(0.9, between={("sheet", GROUND): 0.1}))
    expected = pytest.approx(way(sin(SLOPE) - 0.1 * cos(SLOPE)), rel=1e-6)
    assert gone == {"block": expected, "sheet": expected}


def test_both_slide_each_by_its_own_law() -> None:
    # The block, as heavy as the sheet, pulls it downhill by 0.15, and the ground holds both back by 0.2 of both.
    gone = ways(Friction(0.9, between={("sheet", GROUND): 0.2, ("sheet", "block"): 0.15}))
    assert gone["block"] == pytest.approx(way(sin(SLOPE) - 0.15 * cos(SLOPE)), rel=1e-6)
    assert gone["sheet"] == pytest.approx(way(sin(SLOPE) + (0.15 - 2.0 * 0.2) * cos(SLOPE)), rel=1e-6)
