"""What a hit disturbs: which bricks are to move one by one, and which ride along on them.

The bricks that are struck move, with those that stand in line behind them side by side, and all that touch these. What
these carry presses on them with its weight, so it cannot stay frozen; but as long as it does not change its shape it
moves as one rigid body, true to its mass and inertia. All else stays frozen until it is reached itself.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from stability.contact_graph import components, reached
from stability.model import BodyId, Vec3
from stability.riders import FEWEST
from stability.statics.assembly import Assembly
from stability.statics.facts import Contact
from stability.vectors import dot

IN_LINE = 0.7  # cosine between a hit and the normal of a contact through which it goes on as it is
SIDEWAYS = 0.5  # vertical part of a normal up to which bricks stand side by side
LEVEL = 1.0 - 1e-6  # vertical part of a normal from which on what lies on a contact may ride


@dataclass(frozen=True, slots=True)
class Region:
    """Bricks by name."""

    one_by_one: tuple[BodyId, ...]
    riding: tuple[tuple[BodyId, ...], ...]  # each group one rigid body


def region(assembly: Assembly, struck: Mapping[BodyId, Vec3], ride: bool) -> Region:
    """What moves when bricks of an assembly are struck, each along a direction [unit, W]; `ride` if any may do so."""
    lined: set[BodyId] = set()
    for brick, along_W in struck.items():
        lined |= reached([brick], lambda name, along_W=along_W: _behind(assembly, name, along_W))  # type: ignore[misc]
    core = lined | {other for brick in lined for other in touching(assembly, brick)}
    above = assembly.with_all_above(core) - core
    between = above & assembly.with_all_below(core)  # they carry part of the core, so they do not keep their place
    riding = [
        group
        for group in components(above - between, lambda name: touching(assembly, name))
        if ride and _may_ride(assembly, group)
    ]
    one_by_one = (core | above).difference(*riding)
    return Region(tuple(sorted(one_by_one)), tuple(tuple(sorted(group)) for group in riding))


def _behind(assembly: Assembly, brick: BodyId, along_W: Vec3) -> list[BodyId]:
    """The bricks that stand beside a brick in line with a hit."""
    return [
        other
        for other, contact in touching(assembly, brick).items()
        if any(abs(n[2]) < SIDEWAYS and abs(dot(n, along_W)) > IN_LINE for n in contact.normals_W)
    ]


def touching(assembly: Assembly, brick: BodyId) -> dict[BodyId, Contact]:
    """The other bricks that touch a brick."""
    found = {c.lower if c.upper == brick else c.upper: c for c in assembly.contacts(brick)}
    return {other: contact for other, contact in found.items() if other in assembly.bricks}


def _may_ride(assembly: Assembly, group: Collection[BodyId]) -> bool:
    """Whether a group is worth joining and lies flat on what carries it."""
    outside = (
        contact
        for brick in group
        for contact in assembly.contacts(brick)
        if contact.lower not in group or contact.upper not in group
    )
    return len(group) >= FEWEST and all(abs(n[2]) >= LEVEL for contact in outside for n in contact.normals_W)
