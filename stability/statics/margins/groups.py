"""Bricks that touch none of each other's, directly or through others: what shakes one group leaves the next alone."""

from dataclasses import replace

from stability.graph import components
from stability.model import BodyId
from stability.statics.facts import Problem


def groups_apart(problem: Problem) -> list[Problem]:
    """The groups of bricks that touch none of each other's, each with its contacts and loads."""
    touching: dict[BodyId, set[BodyId]] = {name: set() for name in problem.bricks}
    for contact in problem.contacts:
        if contact.lower in touching and contact.upper in touching:
            touching[contact.lower].add(contact.upper)
            touching[contact.upper].add(contact.lower)
    found = []
    for members in components(problem.bricks, touching.__getitem__):
        found.append(
            replace(
                problem,
                bricks={name: placed for name, placed in problem.bricks.items() if name in members},
                contacts=[each for each in problem.contacts if each.lower in members or each.upper in members],
                loads={name: load for name, load in problem.loads.items() if name in members},
            )
        )
    return found
