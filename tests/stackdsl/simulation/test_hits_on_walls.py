"""Hits on walls: what lies above stands without the brick that is hit, and friction under its weight stops that one.

A plank below n courses of a wall carries n weights and passes on n + 1. Pushed out of the wall at a speed v it comes to
rest after v^2 / (2 mu g (2 n + 1)), as long as what it lies between still holds it on its whole length.
"""

from math import hypot

import pytest

from stability.geometry.box import Box
from stability.model import Brick, Pose
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Action, Arrival, FixedWorld, Placement, PushAction, Timeline
from stackdsl.trace import Trace
from tests.planks import ACROSS, FLOOR, GRAVITY, LENGTH, MASS, THICKNESS, WIDTH, WOOD, lying, plank

GAP = 0.2e-3  # [m] between planks of a course: they do not touch
PITCH = LENGTH + GAP
COURSES, ABREAST = 12, 7
MIDDLE = ABREAST // 2
HALF = Box((0.5 * (LENGTH - GAP), WIDTH, THICKNESS))


def wall() -> list[Placement]:
    """A running bond whose ends are closed with half planks."""
    return [placed for level in range(1, COURSES + 1) for placed in (even(level) if level % 2 == 0 else odd(level))]


def even(level: int) -> list[Placement]:
    return [Placement(0.0, plank(f"L{level}.{place}"), level, lying(level, PITCH * place)) for place in range(ABREAST)]


def odd(level: int) -> list[Placement]:
    between = [
        Placement(0.0, plank(f"L{level}.{place}"), level, lying(level, PITCH * (place + 0.5)))
        for place in range(ABREAST - 1)
    ]
    ends = {"left": -0.25 * PITCH, "right": PITCH * (ABREAST - 1) + 0.25 * PITCH}
    halves = [
        Placement(0.0, Brick(f"L{level}.{name}", HALF, 0.5 * MASS), level, lying(level, x)) for name, x in ends.items()
    ]
    return [*between, *halves]


def played(*actions: Action, hold: float = 0.5) -> Trace:
    return play(Timeline(FixedWorld(GRAVITY, WOOD, (FLOOR,)), (*wall(), *actions), hold), SYSTEMS["exact"])


def pushed(level: int, speed: float) -> Trace:
    return played(PushAction(0.2, f"L{level}.{MIDDLE}", (0.0, -speed * MASS, 0.0)))


@pytest.mark.parametrize(("level", "speed"), [(4, 0.5), (8, 1.0), (10, 0.5)])
def test_a_plank_in_a_wall_slides_until_friction_below_and_above_has_taken_its_energy(level: int, speed: float) -> None:
    trace = pushed(level, speed)
    above = COURSES - level
    way = speed**2 / (2.0 * WOOD * GRAVITY * (2 * above + 1))
    assert way < 0.6 * WIDTH  # it is still held between its neighbours
    assert trace.tracks[f"L{level}.{MIDDLE}"].shift == pytest.approx(way, rel=0.02)
    assert {name for name, track in trace.tracks.items() if track.shift > 0.0} == {f"L{level}.{MIDDLE}"}


def test_a_plank_that_is_knocked_out_leaves_the_wall_standing() -> None:
    trace = pushed(6, 3.0)
    assert trace.tracks[f"L6.{MIDDLE}"].shift > WIDTH
    others = [track.shift for name, track in trace.tracks.items() if name != f"L6.{MIDDLE}"]
    assert max(others) < 0.5e-3


def test_what_a_push_costs_in_a_wall_does_not_grow_with_what_lies_above() -> None:
    assert pushed(4, 0.5).cost.one_by_one == pushed(10, 0.5).cost.one_by_one == 1


def test_a_push_at_the_second_course_from_the_top_moves_what_lies_on_it_too() -> None:
    #   Without it what lies on its two halves would fall, so both are woken with all around them.
    trace = pushed(COURSES - 1, 0.3)
    assert trace.cost.one_by_one > 3
    assert trace.collapse is None


def test_a_plank_thrown_at_a_wall_shares_its_speed_with_the_one_it_hits() -> None:
    #   Plastic, and of the same mass: both go on at half the speed, and the friction of the one stops both.
    level, speed, away = 6, 1.5, 1e-3
    target = lying(level, PITCH * MIDDLE)
    x, y, z = target.position_W
    start = Pose((x, y + 0.5 * (WIDTH + LENGTH) + away, z), ACROSS)
    rise = 0.5 * GRAVITY * away / speed  # brings it back to its height when it arrives
    thin = plank("shot", (LENGTH, WIDTH, 0.5 * THICKNESS))  # meets no edge of the courses above and below
    trace = played(Placement(0.2, thin, 0, start, Arrival.THROWN, (0.0, -speed, rise)))
    deceleration = 0.5 * WOOD * GRAVITY * (2 * (COURSES - level) + 1)  # of two planks, by the friction of one
    final = trace.tracks[f"L{level}.{MIDDLE}"].final.position_W
    assert hypot(final[0] - x, final[1] - y) == pytest.approx((speed / 2.0) ** 2 / (2.0 * deceleration), rel=0.05)


@pytest.mark.parametrize("speed", [2.0, 4.0])
def test_a_block_that_hits_three_courses_at_once_passes_its_momentum_on_to_them(speed: float) -> None:
    #   It strikes the ends of planks, which turn. Were those beside and above them held fast, they would jam, and all
    #   would stop at once. Only friction on what stays in place slows them: by less than a tenth in ten milliseconds.
    away, mass, size = 1e-3, 5.0 * MASS, (0.05, 0.05, 2.5 * THICKNESS)
    x, y, z = lying(COURSES - 1, PITCH * MIDDLE).position_W
    start = Pose((x, y + 0.5 * (WIDTH + size[1]) + away, z))
    rise = 0.5 * GRAVITY * away / speed
    block = Placement(0.2, Brick("block", Box(size), mass), 0, start, Arrival.THROWN, (0.0, -speed, rise))
    trace = played(block, hold=0.01)
    since = trace.cost.simulated_time - 0.2 - away / speed
    starts = {placed.brick.id: placed for placed in [*wall(), block]}
    carried = sum(
        starts[name].brick.mass * (starts[name].pose.position_W[1] - track.final.position_W[1])
        for name, track in trace.tracks.items()
    )
    assert 0.9 * mass * speed * since < carried - mass * away < 1.01 * mass * speed * since
