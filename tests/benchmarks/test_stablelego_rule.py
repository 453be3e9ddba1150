"""The rule of StableLego on bricks that tip about a point beside a stud, by hand."""

import pytest

from benchmarks.stablelego_rule import PULL, LegoBrick, rule_load_factor
from stability.model import EARTH

MASS = 0.002  # [kg]


@pytest.mark.parametrize(
    ("width", "mirrored", "moment", "arm"),
    [
        # Over one stud that is one wide: four points, the outermost of which is the hinge.
        (1, False, 0.5 + 2 * 0.25, 1.5 - 0.25),
        (1, True, 0.5 + 2 * 0.25, 1.5 - 0.25),
        # Over four studs: the points are an eighth beyond the stud, or, mirrored, a quarter.
        (2, False, 4 * 1.0 + 2 * 1.375 + 2 * 0.375, 1.0 - 0.625),
        (2, True, 4 * 1.375 + 2 * 1.0 + 4 * 0.375, 1.0 - 0.75),
    ],
)
def test_a_brick_that_overhangs_tips_about_a_point_beside_a_stud(
    width: int, mirrored: bool, moment: float, arm: float
) -> None:
    """`moment` is that of all pulls about the hinge, and `arm` that of the weight, in pitches."""
    bricks = [LegoBrick((0, 0, 0), (width, width), MASS), LegoBrick((0, 0, 1), (4, width), MASS)]
    factor = rule_load_factor(bricks, 0.008, 0.0096, mirrored)
    assert factor == pytest.approx(moment * PULL / (arm * MASS * EARTH), rel=1e-6)


def test_neighbours_push_and_a_brick_that_none_holds_has_no_load_factor() -> None:
    beam = [LegoBrick((0, 0, 0), (1, 1), MASS), LegoBrick((0, 0, 1), (4, 1), MASS)]
    prop = [LegoBrick((4, 0, 0), (1, 1), MASS), LegoBrick((4, 0, 1), (2, 1), MASS)]
    assert rule_load_factor(beam + prop, 0.008, 0.0096) > rule_load_factor(beam, 0.008, 0.0096)
    floating = [LegoBrick((0, 0, 0), (1, 1), MASS), LegoBrick((1, 0, 1), (1, 1), MASS)]
    assert rule_load_factor(floating, 0.008, 0.0096) == pytest.approx(0.0, abs=1e-9)
