"""Faces that overlap by next to nothing, which no margin should lean on.

A sliver carries what a rigid body can (docs/decisions/0007), so a verdict counts on it. What a load survives, told to
whoever drives it, must not hang on a hundredth of a millimetre between cartons that were meant to stand flush.
"""

from dataclasses import replace

from stability.geometry.touching import gap_bridged, reach_between
from stability.model import BodyId
from stability.statics.contacts.solids import Solid, solid
from stability.statics.contacts.touch import flush_within
from stability.statics.facts import Contact, Problem


def without_slivers(problem: Problem) -> Problem:
    """The problem without contacts of bricks that would run flush if they were moved by less than a gap that counts.

    That is a thousandth of the smallest side of the thinner one. The problem itself if there are none.
    """
    solids = {name: solid(placed) for name, placed in problem.bricks.items()}
    kept = [contact for contact in problem.contacts if not _is_sliver(contact, solids)]
    return problem if len(kept) == len(problem.contacts) else replace(problem, contacts=kept)


def _is_sliver(contact: Contact, solids: dict[BodyId, Solid]) -> bool:
    if contact.lower not in solids or contact.upper not in solids:
        return False
    a, b = solids[contact.lower], solids[contact.upper]
    reach = reach_between(a.shortest, b.shortest)
    return flush_within(a, b, reach, gap_bridged(reach, 0.0))
