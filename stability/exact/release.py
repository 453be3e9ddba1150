"""Bricks that move, or are in doubt, are taken out of an assembly until what is left of it is proven."""

from collections.abc import Mapping
from dataclasses import dataclass

from stability.model import BodyId, Pose
from stability.motion.onset import as_it_begins
from stability.statics.assembly import Assembly
from stability.statics.facts import Stability, Verdict


@dataclass(frozen=True, slots=True)
class Judgement:
    """What came of a verdict: which bricks an assembly had to release, and what was proven of the rest."""

    first: Verdict
    last: Verdict  # STABLE, of the bricks that stay
    released: Mapping[BodyId, Pose]  # the bricks that do not stay, and where they are
    lowest: tuple[BodyId, ...]  # the lowest brick that the first verdict names; empty if it names none


def release_until_stable(assembly: Assembly, verdict: Verdict, *, names_smallest: bool = True) -> Judgement:
    """Take out of an assembly what begins to move or is in doubt, until what is left is proven; see `add_all`."""
    first = verdict = as_it_begins(assembly, verdict)
    released: dict[BodyId, Pose] = {}
    lowest: tuple[BodyId, ...] = ()
    while verdict.stability is not Stability.STABLE:
        moving = verdict.moving or tuple(assembly.bricks)
        poses = {brick: assembly.bricks[brick].pose for brick in moving}
        lowest = lowest or (min(moving, key=lambda brick: (poses[brick].position_W[2], brick)),)
        released |= poses
        verdict = as_it_begins(assembly, assembly.remove(moving, names_smallest=names_smallest))
    return Judgement(first, verdict, released, lowest)
