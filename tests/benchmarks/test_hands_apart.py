"""Planks as hands set them down, worked out apart from the package: the check that is told in docs/method.md."""

from math import pi, radians, sqrt, tan

import pytest

from benchmarks import card_houses_apart
from benchmarks.hands_apart import Plank, falls_at, shared
from benchmarks.human_error import held_apart
from stability.problem import Placed
from tests.scenes import compiled

SIZE = LENGTH, WIDTH, THICKNESS = (0.12, 0.024, 0.008)  # [m]


def plank(level: int, x: float, turn: float = 0.0) -> Plank:
    return Plank(f"L{level}", x, 0.0, (level - 1) * THICKNESS, turn, SIZE, 0.012, level)


def test_planks_that_cross_share_a_rhombus() -> None:
    found = shared(plank(1, 0.0), plank(2, 0.0, pi / 6.0))
    # Two strips of one width that cross at 30 deg share a rhombus whose sides are twice as long as they are wide.
    assert sorted(sqrt(x * x + y * y) for x, y in found) == pytest.approx(
        [WIDTH / sqrt(2.0 + sqrt(3.0))] * 2 + [WIDTH / sqrt(2.0 - sqrt(3.0))] * 2
    )
    assert shared(plank(1, 0.0), plank(2, LENGTH)) == []


@pytest.mark.parametrize(("step", "level"), [(0.99 * LENGTH / 6.0, 0), (1.01 * LENGTH / 6.0, 6)])
def test_a_column_stands_while_levels_times_step_are_at_most_a_length(step: float, level: int) -> None:
    assert falls_at([plank(number, step * (number - 1)) for number in range(1, 7)], 0.5) == (level, 6)


def test_hands_and_verdicts_of_samples_are_those_that_are_worked_out_apart() -> None:
    found = held_apart("four-stack", 4.0, 4.0, 2)
    assert (found["alike"], found["contradicted"], found["not_said"]) == (2, 0, 0)
    assert isinstance(found["off_nm"], float)
    assert found["off_nm"] < 1.0


@pytest.mark.parametrize(("share", "stands"), [(0.97, False), (1.03, True)])
def test_a_v_stands_from_its_least_friction_on(share: float, stands: bool) -> None:
    # Cards at an angle a that meet along an edge: (cot a - thickness / length) / 2. Pyramids are within 2 % of cones.
    cards = compiled("scenario: v\nbuild:\n  - card_house: {levels: 1, angle: 70 deg}\n")[0][0].timeline.placements
    least = 0.5 * (1.0 / tan(radians(70.0)) - 7.8 / 117.6)
    assert card_houses_apart.stands([Placed(each.brick, each.pose) for each in cards], share * least) is stands
