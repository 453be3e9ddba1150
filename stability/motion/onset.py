"""A verdict of UNSTABLE, with the motion that everything connected with what falls begins with.

The cascade proves that something falls by the smallest part that it finds. What is to be given back to an engine is all
that begins to move, and what is to be seen of it is how.
"""

from dataclasses import replace

from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.statics.facts import Stability, Verdict
from stability.statics.solvers.fall_words import described

MOST = 300  # bricks in one program: a tenth of a second; of larger structures those nearest to what falls


def as_it_begins(assembly: Assembly, verdict: Verdict) -> Verdict:
    """The verdict, naming all bricks that begin to move, and how; as it was if nothing falls or none was proven."""
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
    """These bricks, and those that are connected with them: the nearest, where there are too many."""
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
