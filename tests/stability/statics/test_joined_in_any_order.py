"""Joined bricks that come and go one by one have the verdicts of all together, and their proofs add up."""

import random

import pytest

from benchmarks.joined import KINDS, assembly_of, drawn
from stability.problem import Placed, Stability, Verdict
from stability.statics.assembly import Assembly


def judged(site: Assembly, bricks: list[Placed]) -> Verdict:
    """The verdict on bricks that are all set down at once."""
    return Assembly(site.planes, site.friction, joints=site.joints).add_all(bricks)


@pytest.mark.parametrize("seed", range(40))
def test_bricks_that_come_and_go_have_the_verdict_of_all_together(seed: int) -> None:
    draw = random.Random(seed)
    strength = draw.choice((2.0, 5.0, 20.0))
    assembly, bricks = assembly_of(drawn(draw, KINDS[seed % len(KINDS)], draw.randint(3, 10)).times(strength))
    present: list[Placed] = []
    for coming in bricks:
        more = [*present, coming]
        if assembly.would(coming.brick, coming.pose).stability is not judged(assembly, more).stability:
            pytest.fail(f"{coming.brick.id} has another verdict when it comes last")
        if judged(assembly, more).stability is Stability.STABLE:
            assembly.add(coming.brick, coming.pose)
            present = more
            assert assembly.forces() is not None  # which checks the sum of all proofs
        going = draw.choice(present) if present else None
        rest = [each for each in present if each is not going]
        if going is None or not rest or draw.random() > 0.3:
            continue
        verdict = judged(assembly, rest).stability
        assert assembly.would_without([going.brick.id]).stability is verdict
        if verdict is Stability.STABLE:
            assembly.remove([going.brick.id])
            present = rest
            assert assembly.forces() is not None
