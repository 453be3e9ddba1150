"""Hits that friction absorbs before the struck brick has moved."""

from dataclasses import dataclass
from math import sqrt

import pytest

from stability.geometry.box import Box
from stability.geometry.solid_making import solid_of_corners
from stability.geometry.vectors import scale
from stability.model import BodyState, Brick, Pose, Vec3
from stability.stabilizers.approach import Hit
from stability.stabilizers.exact.hits import HoldingForces, IncomingBrick, friction_stops
from stability.stabilizers.exact.overload import MOVED
from stability.statics.assembly import Assembly
from tests.planks import GRAVITY, LENGTH, MASS, THICKNESS, WIDTH, WOOD, column, standing

CUBE = Box((0.004, 0.004, 0.004))
MEAN_BY_ROOT = 0.816  # a plank that is hit at its middle moves as one; this is the bound that is used for all
LIMIT = MOVED * THICKNESS  # [m]


@dataclass(frozen=True, slots=True)
class Coming:
    """How a cube of a plank's mass comes onto the long side of a plank, or onto its edge."""

    speed: float  # at which the gap closes [m/s]
    normal_W: Vec3 = (0.0, -1.0, 0.0)
    velocity_W: Vec3 | None = None  # of its centre [m/s], if not along the normal
    aside: float = 0.0  # of the middle of the plank [m]
    height: float = 0.0  # above it [m]


def is_stopped(assembly: Assembly, brick: str, coming: Coming) -> bool:
    """Whether friction stops it before the plank has moved by anything."""
    x, y, z = assembly.bricks[brick].pose.position_W
    start = Pose((x + coming.aside, y + 0.5 * WIDTH + 0.003, z + coming.height))
    state = BodyState(start, coming.velocity_W or scale(coming.speed, coming.normal_W))
    beside = [placed for name, placed in assembly.bricks.items() if name != brick]
    hit = Hit("cube", brick, coming.speed, coming.normal_W)
    return friction_stops(assembly, hit, IncomingBrick(Brick("cube", CUBE, MASS), state), beside, HoldingForces())


def fastest(above: int) -> float:
    """Two alike go on with half the speed, and 2 m (v / 2)^2 / 2 = s mu (2 n + 1) m g stops both."""
    return sqrt(4.0 * LIMIT * MEAN_BY_ROOT * WOOD * GRAVITY * (2 * above + 1))


@pytest.mark.parametrize("above", [0, 1, 10, 40])
def test_friction_above_and_below_stops_a_hit_up_to_the_speed_at_which_both_move_by_a_twentieth_of_a_millimetre(
    above: int,
) -> None:
    assembly = standing(column(above + 1))
    assert is_stopped(assembly, "L1", Coming(0.99 * fastest(above)))
    assert not is_stopped(assembly, "L1", Coming(1.01 * fastest(above)))


def test_a_plank_hit_near_its_end_gives_way_to_less() -> None:
    #   There it weighs M / (1 + 12 (x / L)^2) at most, so that it takes more of the speed.
    assembly = standing(column(11))
    assert is_stopped(assembly, "L1", Coming(0.9 * fastest(10)))
    assert not is_stopped(assembly, "L1", Coming(0.9 * fastest(10), aside=0.45 * LENGTH))


def test_an_edge_under_the_next_plank_is_met_from_the_side_only() -> None:
    #   A brick that falls along a wall at 2 m/s comes close to every edge between two planks, but hits none from above.
    along_the_edge = Coming(1.5, (0.0, -sqrt(0.5), -sqrt(0.5)), (0.0, -0.1, -2.0), height=0.5 * THICKNESS)
    assembly = standing(column(31))
    assert is_stopped(assembly, "L11", along_the_edge)
    assert not is_stopped(assembly, "L31", along_the_edge)  # nothing lies on it


def test_the_count_of_courses_that_hold_a_brick_ends_at_the_last_course() -> None:
    #   As where a block meets a sliver; counting on beyond the last course took hours.
    assert not HoldingForces().at_least(standing(column(3)), "L1", 1e12 * MASS * GRAVITY)


def test_a_hit_on_an_upright_brick_is_never_proven_to_be_borne() -> None:
    upright = Pose((0.0, 0.0, 0.5 * LENGTH), (0.0, sqrt(0.5), 0.0, sqrt(0.5)))
    assert not is_stopped(standing({"L1": upright}), "L1", Coming(1e-3))


def test_a_hit_on_a_solid_that_is_no_box_is_left_to_an_engine() -> None:
    same_plank = solid_of_corners(Box((LENGTH, WIDTH, THICKNESS)).corners).shape
    assembly = Assembly(friction=WOOD)
    for level in range(11):
        assembly.add(Brick(f"L{level + 1}", same_plank, MASS), Pose((0.0, 0.0, (level + 0.5) * THICKNESS)))
    assert not is_stopped(assembly, "L1", Coming(0.1 * fastest(10)))
