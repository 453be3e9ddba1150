"""Takes out of an assembly what a hit wakes, and what cannot stand without it.

In a wall what lies above a brick mostly stands without it, and is proven to. Then the brick that is struck is woken
alone, and what stays frozen presses on it with the forces of the proof (`dead_loads`): what a hit costs is what it
reaches. Where something falls without it, bricks that are few are all woken, down to what they lie on: beside bricks as
firm as frozen ones are, those that move carry too little.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from stability.exact.hits.region import Region, touching
from stability.exact.release import release_until_stable
from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.statics.certificate import Tally
from stability.statics.facts import Placed, by_place

FEW = 40  # bricks whose motion costs about a second for a second
MOSTLY = 0.5  # share of a region that stands without what is struck, or it is woken whole


@dataclass(frozen=True, slots=True)
class Woken:
    """Bricks that an assembly has released, and how they move on."""

    placed: Mapping[BodyId, Placed]  # as they stood
    riding: tuple[tuple[BodyId, ...], ...] = ()  # those that do not move one by one, as rigid groups
    touched: Mapping[BodyId, Collection[BodyId]] = field(default_factory=dict)  # whom those touched that ride
    forces: Tally | None = None  # with which they carried what stays frozen; None if they carried nothing of it


def wake(assembly: Assembly, reached: Region, presses: bool) -> Woken:
    """Release a region from an assembly; `presses` if frozen bricks can press on woken ones."""
    before = dict(assembly.bricks)
    released: set[BodyId] = set()
    if presses and reached.in_wall:
        forces = assembly.forces_above(reached.lined)
        few = len(reached.one_by_one) <= FEW
        released = _released(assembly, reached.lined, names_smallest=few)
        if len(released) <= (len(reached.lined) if few else MOSTLY * len(reached.one_by_one)):
            return Woken(_in_order(before, released), forces=forces)
    touched = {brick: sorted(touching(assembly, brick)) for group in reached.riding for brick in group}
    released |= _released(assembly, {*reached.one_by_one, *touched} - released, names_smallest=True)
    return Woken(_in_order(before, released), reached.riding, touched)


def _released(assembly: Assembly, bricks: Collection[BodyId], names_smallest: bool) -> set[BodyId]:
    """Take bricks out of an assembly, and what cannot stand without them; these are they."""
    verdict = assembly.remove(bricks, names_smallest=names_smallest)
    return {*bricks, *release_until_stable(assembly, verdict, names_smallest=names_smallest).released}


def _in_order(before: Mapping[BodyId, Placed], bricks: Collection[BodyId]) -> dict[BodyId, Placed]:
    return {brick: before[brick] for brick in sorted(bricks, key=lambda name: by_place(before[name]))}
