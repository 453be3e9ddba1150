"""What a hit disturbs: which bricks are to move one by one, and which ride along on them.

The bricks that are struck move, with those that stand in line behind them, as good as side by side, and all that touch
these. What these carry presses on them with its weight, so it cannot stay frozen; but as long as it does not change its
shape it moves as one rigid body, true to its mass and inertia. All else stays frozen until it is reached itself.

A rigid body bridges what gives way below a part of it, where bricks would sag. So in a wall nothing rides: a group must
lie on what carries it with each of its lowest bricks alike, as a level of a tower does. What a wall carries may stand
without the bricks that are struck, and then needs not be woken (see `waking`).
"""

from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from stability.exact.hits.rigid_groups import FEWEST
from stability.geometry.vectors import dot
from stability.graph import components, reached
from stability.model import BodyId, Vec3
from stability.shapes.apart import apart
from stability.statics.assembly import Assembly
from stability.statics.facts import Contact, by_place

IN_LINE = 0.7  # cosine between a hit and the normal of a contact through which it goes on as it is
# Share of the smallest side, a millimetre for a plank: a brick that is hit closes such a gap within the very step.
BEHIND = 0.125
SIDEWAYS = 0.5  # vertical part of a normal up to which bricks stand side by side
LEVEL = 1.0 - 1e-6  # vertical part of a normal; on a contact that is less level no group may ride


@dataclass(frozen=True, slots=True)
class Region:
    """The bricks that a disturbance wakes, by name."""

    one_by_one: tuple[BodyId, ...]
    riding: tuple[tuple[BodyId, ...], ...]  # rigid groups
    lined: tuple[BodyId, ...]  # of those that move one by one: the struck, and those in line behind them
    in_wall: bool  # whether much of what moves one by one would ride if it lay on the rest as a level of a tower does


def region(assembly: Assembly, struck: Mapping[BodyId, Vec3], ride: bool) -> Region:
    """What moves when bricks of an assembly are struck, each along a direction [unit, W]; `ride` if any may do so."""
    lined: set[BodyId] = set()
    for brick, along_W in struck.items():
        lined |= reached([brick], lambda name, along_W=along_W: _behind(assembly, name, along_W))  # type: ignore[misc]
    core = lined | {other for brick in lined for other in touching(assembly, brick)}
    above = assembly.with_all_above(core) - core
    between = above & assembly.with_all_below(core)  # they carry part of the core, so they do not keep their place
    groups = components(above - between, lambda name: touching(assembly, name))
    large = [group for group in groups if len(group) >= FEWEST]
    riding = [group for group in large if ride and _may_ride(assembly, group)]
    return Region(
        _upwards(assembly, (core | above).difference(*riding)),
        tuple(_upwards(assembly, group) for group in riding),
        _upwards(assembly, lined),
        in_wall=len(riding) < len(large),
    )


def _upwards(assembly: Assembly, bricks: Collection[BodyId]) -> tuple[BodyId, ...]:
    """In an order of places: an engine that is told of bricks in the order of their names would round by these."""
    return tuple(sorted(bricks, key=lambda name: by_place(assembly.bricks[name])))


def _behind(assembly: Assembly, brick: BodyId, along_W: Vec3) -> list[BodyId]:
    """The bricks that stand beside a brick in line with a hit."""
    own = assembly.bricks[brick]
    within, found = BEHIND * own.brick.shape.least_thickness, []
    for name in assembly.around(brick, within):
        other = assembly.bricks[name]
        between = apart(own.brick.shape, own.pose, other.brick.shape, other.pose)
        sideways = abs(between.normal_BA_W[2]) < SIDEWAYS and abs(dot(between.normal_BA_W, along_W)) > IN_LINE
        if sideways and between.gap <= within:
            found.append(name)
    return found


def touching(assembly: Assembly, brick: BodyId) -> dict[BodyId, Contact]:
    """The other bricks that touch a brick."""
    found = {c.lower if c.upper == brick else c.upper: c for c in assembly.contacts(brick)}
    return {other: contact for other, contact in found.items() if other in assembly.bricks}


def _may_ride(assembly: Assembly, group: Collection[BodyId]) -> bool:
    """Whether a group lies flat on what carries it, each of its lowest bricks on all of that."""
    supports: dict[BodyId, set[BodyId]] = defaultdict(set)
    for brick in group:
        for contact in assembly.contacts(brick):
            other = contact.lower if contact.upper == brick else contact.upper
            if other not in group:
                supports[brick].add(other)
                if any(abs(n[2]) < LEVEL for n in contact.normals_W):
                    return False
    return len({frozenset(others) for others in supports.values()}) <= 1
