"""A wall from which a plank is taken stands as an arch about the hole, and few planks are asked to prove it."""

from stability.problem import Stability, Stage
from tests.planks import LENGTH, lying, standing

PITCH = LENGTH + 0.2e-3
BASE, LEVELS = 40, 30


def test_the_proof_takes_in_little_more_than_what_is_unsettled_and_its_forces_hold() -> None:
    assembly = standing(
        {
            f"L{level}.{place}": lying(level, PITCH * (place + 0.5 * level))
            for level in range(1, LEVELS + 1)
            for place in range(BASE + 1 - level)
        }
    )
    above = assembly.with_all_above(["L2.19"])
    assert assembly.remove(["L2.19"]).stability is Stability.STABLE
    together = [brick for brick in assembly.bricks if assembly.stage(brick) is Stage.VERTICAL]
    assert 0 < len(together) < 0.5 * len(above)
    assert assembly.forces() is not None  # checked by arithmetic, all of them at once
