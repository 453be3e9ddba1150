"""Tunnelling: a thrown brick that passes through another one is reported, and no other brick is."""

import pytest

from stability.geometry.box import Box
from stability.model import Vec3
from stackdsl.report.warnings import passed_text
from stackdsl.simulation.measurements import entry
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Arrival, FixedWorld, Placement, Timeline
from stackdsl.trace import Trace
from tests.planks import ACROSS, FLOOR, GRAVITY, LENGTH, WOOD, four_stack, lying, plank

CUBE = Box((0.02, 0.02, 0.02))


@pytest.mark.parametrize(
    ("start", "end", "inside"),
    [
        ((-0.1, 0.0, 0.0), (0.1, 0.0, 0.0), True),  # through it
        ((-0.1, 0.0, 0.0), (-0.005, 0.0, 0.0), True),  # into it
        ((-0.1, 0.0, 0.0), (-0.011, 0.0, 0.0), False),  # up to it
        ((-0.1, 0.011, 0.0), (0.1, 0.011, 0.0), False),  # along a side
        ((-0.1, 0.01, 0.0), (0.1, 0.01, 0.0), False),  # in a side
        ((-0.02, 0.001, 0.0), (0.0, 0.021, 0.0), False),  # past an edge
        ((-0.02, -0.001, 0.0), (0.0, 0.019, 0.0), True),  # within an edge
        ((0.1, 0.0, 0.0), (0.2, 0.0, 0.0), False),  # away from it
    ],
)
def test_a_way_goes_through_a_box_if_a_part_of_it_is_inside(start: Vec3, end: Vec3, inside: bool) -> None:
    assert (entry(CUBE, start, end) is not None) is inside
    assert (entry(CUBE, end, start) is not None) is inside


def thrown(speed: float, system: str) -> Trace:
    """A plank that flies end-on at the long side of a plank of the third of four levels, from 10 mm away."""
    tower = [Placement(0.0, plank(name), 0, pose) for name, pose in four_stack(range(1, 5)).items()]
    from_beside = lying(3, y=LENGTH + 0.01, turn=ACROSS)
    shot = Placement(1.0, plank("shot"), 0, from_beside, Arrival.THROWN, (0.0, -speed, 0.0))
    return play(Timeline(FixedWorld(GRAVITY, WOOD, (FLOOR,)), (*tower, shot), 0.05), SYSTEMS[system])


def test_a_plank_that_flies_through_a_tower_is_told_of() -> None:
    #   20 m/s at 1/240 s are 83 mm a step, and a plank is 23.4 mm wide.
    passed = thrown(20.0, "modified").passed_through
    assert passed is not None
    assert (passed.brick, passed.through) == ("shot", "L3.2")
    assert "shot passed through L3.2" in passed_text(passed)


@pytest.mark.parametrize(("speed", "system"), [(1.0, "modified"), (8.0, "exact"), (8.0, "thesis")])
def test_a_stopped_or_pushing_brick_passed_through_nothing(speed: float, system: str) -> None:
    assert thrown(speed, system).passed_through is None
