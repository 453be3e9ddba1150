"""Slides on a slip sheet and of the sheet, each by the friction of its own contact, without an engine."""

from math import cos, radians, sin

import pytest

from stability.contact_law import Friction, GivenFriction
from stability.dynamics.frictional_motion import FrictionalMotion, frictional_motion_of
from stability.geometry.box import Box
from stability.geometry.vectors import rotate
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed
from stability.stabilizers.exact.candidates import release_until_stable
from stability.statics.assembly import Assembly

SLOPE, GRAVITY, STEP, STEPS = radians(15.0), 9.81, 1e-3, 100
TURN = (0.0, sin(0.5 * SLOPE), 0.0, cos(0.5 * SLOPE))
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (sin(SLOPE), 0.0, cos(SLOPE)), 0.9)


def on_slope(thick: float) -> list[Placed]:
    """A sheet, and a block as heavy on it."""
    return [
        Placed(Brick(name, Box(size), 0.5), Pose(rotate(TURN, (0.0, 0.0, height)), TURN))
        for name, size, height in (
            ("sheet", (0.6, 0.3, thick), 0.5 * thick),
            ("block", (0.1, 0.1, 0.02), thick + 0.01),
        )
    ]


def begun(friction: GivenFriction, thick: float) -> FrictionalMotion:
    """How the block on a sheet of this thickness [m] begins to move."""
    bricks = on_slope(thick)
    assembly = Assembly((FLOOR,), friction, GRAVITY)
    falling = release_until_stable(assembly, assembly.add_all(bricks)).released.keys()
    whole = Assembly((FLOOR,), friction, GRAVITY)
    whole.add_all(bricks)
    found = frictional_motion_of(whole.problem(), falling, GRAVITY, (), (FLOOR,), friction)
    assert found is not None
    return found


def ways(friction: GivenFriction, thick: float = 0.02) -> dict[str, float]:
    """How far downhill each brick that moves has come [m]."""
    motion = begun(friction, thick)
    assert all(motion.advance(STEP) for _ in range(STEPS))
    started = {placed.brick.id: placed.pose.position_W for placed in on_slope(thick)}
    return {name: (state.pose.position_W[0] - started[name][0]) / cos(SLOPE) for name, state in motion.states().items()}


def way(acceleration: float) -> float:
    """From rest, with an acceleration in parts of gravity [m]."""
    return 0.5 * GRAVITY * acceleration * (STEPS * STEP) ** 2


@pytest.mark.parametrize("thick", [0.02, 0.0002])  # the second is thinner than the gap that a block bridges
def test_a_block_slides_down_its_sheet_by_the_friction_of_the_two(thick: float) -> None:
    gone = ways(Friction(0.9, between={("sheet", "block"): 0.1}), thick)
    assert gone == {"block": pytest.approx(way(sin(SLOPE) - 0.1 * cos(SLOPE)), rel=1e-6)}


def test_a_sliding_brick_has_no_landings_and_takes_whole_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[float] = []
    steps = FrictionalMotion._steps

    def noted(motion: FrictionalMotion, duration: float) -> bool:
        taken.append(duration)
        return steps(motion, duration)

    monkeypatch.setattr(FrictionalMotion, "_steps", noted)
    assert ways(Friction(0.9, between={("sheet", "block"): 0.1})).keys() == {"block"}
    assert taken == [STEP] * STEPS


def test_a_sheet_slides_with_its_load_by_its_friction_on_the_ground() -> None:
    gone = ways(Friction(0.9, between={("sheet", GROUND): 0.1}))
    expected = pytest.approx(way(sin(SLOPE) - 0.1 * cos(SLOPE)), rel=1e-6)
    assert gone == {"block": expected, "sheet": expected}


def test_sheet_and_brick_each_slide_by_their_own_friction_law() -> None:
    # The block, as heavy as the sheet, pulls it downhill by 0.15, and the ground holds both back by 0.2 of both.
    gone = ways(Friction(0.9, between={("sheet", GROUND): 0.2, ("sheet", "block"): 0.15}))
    assert gone["block"] == pytest.approx(way(sin(SLOPE) - 0.15 * cos(SLOPE)), rel=1e-6)
    assert gone["sheet"] == pytest.approx(way(sin(SLOPE) + (0.15 - 2.0 * 0.2) * cos(SLOPE)), rel=1e-6)
