"""The least counterweight, held against the law of the lever."""

from math import cos, sin

import pytest

from stability.analysis.margins import counterweight, least_counterweight
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from tests.planks import GRAVITY, LENGTH, MASS, THICKNESS, lying, plank

WEIGHT = MASS * GRAVITY


def column(levels: int, step: float) -> Assembly:
    assembly = Assembly(gravity=GRAVITY)
    assembly.add_all(Placed(plank(f"L{n}"), lying(n, (n - 1) * step)) for n in range(1, levels + 1))
    assert assembly.verdict().stability is Stability.UNSTABLE
    return assembly


@pytest.mark.parametrize("on", [2, 3, 4])
def test_a_counterweight_inside_the_edge_holds_a_leaning_column_by_its_lever_arm(on: int) -> None:
    #   Nine planks hang over the edge of the first by 1.2 mm on average; plank n lies 58.8 - 12 (n - 1) mm inside it.
    found = counterweight(column(10, 0.012).problem(), f"L{on}")
    least = 9.0 * WEIGHT * 0.0012 / (LENGTH / 2.0 - 0.012 * (on - 1))
    assert found is not None
    assert found.weight == pytest.approx(least, rel=1e-6)
    assert found.too_little < least * (1.0 + 1e-9) < found.weight * (1.0 + 1e-9)


@pytest.mark.parametrize("on", ["L1", "L6", "L10"])
def test_no_weight_helps_on_what_does_not_tip_or_lies_outside_the_edge(on: str) -> None:
    #   The first plank stays where it is, and the sixth is 60 mm out, beyond the edge at 58.8 mm.
    assert counterweight(column(10, 0.012).problem(), on) is None


def test_the_least_lies_furthest_inside() -> None:
    problem = column(10, 0.012).problem()
    found = least_counterweight(problem, problem.bricks)
    assert found is not None
    assert found.brick == "L2"


def test_a_beam_is_held_by_a_weight_at_its_short_end() -> None:
    #   A beam of 1 kg with its centre 100 mm beyond the edge of its bearer, and a block on it 200 mm inside the edge:
    #   half a kilogram there in all, of which the block is 0.2 kg.
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5),), gravity=GRAVITY)
    assembly.add_all(
        [
            Placed(Brick("bearer", Box((0.6, 0.1, 0.1)), 5.0), Pose((-0.3, 0.0, 0.05))),
            Placed(Brick("beam", Box((0.8, 0.1, 0.02)), 1.0), Pose((0.1, 0.0, 0.11))),
            Placed(Brick("block", Box((0.05, 0.05, 0.05)), 0.2), Pose((-0.2, 0.0, 0.145))),
        ]
    )
    found = counterweight(assembly.problem(), "block")
    assert found is not None
    assert found.weight == pytest.approx(0.3 * GRAVITY, rel=1e-6)


def test_no_counterweight_holds_a_sliding_brick() -> None:
    #   Friction and what drives it downhill grow alike.
    slope, friction = 0.6, 0.5  # tan 0.6 = 0.684
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (sin(slope), 0.0, cos(slope)), friction),), gravity=GRAVITY)
    half = THICKNESS / 2.0
    turn = (0.0, sin(slope / 2.0), 0.0, cos(slope / 2.0))
    assembly.add(plank("a"), Pose((half * sin(slope), 0.0, half * cos(slope)), turn))
    assert assembly.verdict().stability is Stability.UNSTABLE
    assert counterweight(assembly.problem(), "a") is None


def test_a_brick_that_is_not_there_is_refused() -> None:
    with pytest.raises(LookupError, match="there is no brick 'x'"):
        counterweight(column(10, 0.012).problem(), "x")
