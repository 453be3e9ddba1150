"""Completes a verdict of UNSTABLE by the motion with which everything that is connected with what falls begins.

The cascade proves a fall by the smallest part that it finds. An engine, however, must be given back every brick that
begins to move, and a reader wants to know how they move.
"""

from dataclasses import replace

from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.statics.facts import Stability, Verdict
from stability.statics.solvers.fall_words import described

MOST = 300  # bricks in one program: a tenth of a second; of larger structures those nearest to what falls


def as_it_begins(assembly: Assembly, verdict: Verdict) -> Verdict:
    """The verdict with all bricks that begin to move, and how; unchanged if nothing falls or no motion is proven."""
    if verdict.stability is not Stability.UNSTABLE or verdict.motion is None:
        return verdict
    from stability.motion.least_constraint import onset  # noqa: PLC0415 -- it brings numpy, and what stands does without

    problem = assembly.problem(_around(assembly, verdict.moving))
    motion = onset(problem, verdict.motion)
    if motion is None:
        return verdict
    moving = tuple(sorted(motion.velocity))
    same = moving == tuple(sorted(verdict.moving))
    return replace(verdict, motion=motion, moving=moving, reason=verdict.reason if same else described(problem, motion))


def _around(assembly: Assembly, bricks: tuple[BodyId, ...]) -> set[BodyId]:
    """These bricks and all that are connected with them, or only the nearest where there are too many."""
    group = set(bricks)
    while len(group) < MOST:
        larger = group | {other for brick in group for other in _neighbours(assembly, brick)}
        if len(larger) == len(group):
            break
        group = larger
    return group


def _neighbours(assembly: Assembly, brick: BodyId) -> set[BodyId]:
    bodies = {body for contact in assembly.contacts(brick) for body in (contact.lower, contact.upper)}
    return {body for body in bodies if body in assembly.bricks}
