"""The extension where hands take bricks, move them, hold them and let them go.

A brick in a hand is none of those that are judged: as long as it moves it carries nothing that could be proven, and
once it is held at rest it carries like the ground, for a hand is as strong as it has to be (docs/decisions/0046).
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from math import inf

from stability.exact.candidates import fixed_bodies, solids
from stability.exact.proven_stability import ProvenStability
from stability.exact.release import release_until_stable
from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed
from stability.watching.extension import Update


@dataclass
class HandledStability(ProvenStability):
    """Watches the bricks of one engine some of which may be in hands; see `ProvenStability`."""

    _in_hands: dict[BodyId, Placed | None] = field(default_factory=dict, init=False)  # where each is held, if at rest

    def taken(self, brick: BodyId) -> Update:
        """Say that a hand takes a brick: what cannot stand without it is woken."""
        woken: tuple[BodyId, ...] = ()
        if brick in self._rigid_groups:
            self._rigid_groups.part(brick)
        if self.is_frozen(brick):
            judgement = release_until_stable(self.assembly, self.assembly.remove([brick]))
            woken = self._give_back(judgement.released)
            self._awake.rest_poses.remember_driven(judgement.released)
        self._observers.gone([brick])
        self._in_hands[brick] = None
        return Update((), woken, reason=f"{brick} taken by a hand" if woken else "")

    def held(self, bricks: Collection[BodyId]) -> Update:
        """Say that bricks are held at rest from now on: they carry as the ground does."""
        self.assembly.remove([brick for brick in bricks if self.is_frozen(brick)])
        self._observers.gone([brick for brick in bricks if brick not in self._in_hands])
        self._in_hands |= dict(solids(self.engine, self.engine.states(sorted(bricks))))
        return self._judged_anew(())

    def let_go(self, bricks: Collection[BodyId], set_down: bool) -> Update:
        """Say that hands let bricks go: those that were at rest are judged at once, with all that they carried."""
        resting = [placed for brick in sorted(bricks) if (placed := self._in_hands.pop(brick)) is not None]
        if set_down or resting:
            self.set_down(bricks)
        if not resting:
            return Update()
        self._awake.no_longer_new()
        return self._judged_anew(resting)

    def handled(self, bricks: Collection[BodyId], reason: str) -> Update:
        """Say which bricks hands may move: they are woken, and not judged while they are named."""
        self._awake.handled(bricks)
        for brick in bricks:
            if brick in self._rigid_groups:
                self._rigid_groups.part(brick)
        woken = self.wake([brick for brick in bricks if self.is_frozen(brick)])
        self._awake.rest_poses.remember_driven({brick: s.pose for brick, s in self.engine.states(woken).items()})
        return Update((), woken, reason=reason if woken else "")

    def _judged_anew(self, coming: Sequence[Placed]) -> Update:
        """Judge all that stands on what is fixed by now, the ground and what hands hold at rest; `coming` as well."""
        tables = [placed for placed in self._in_hands.values() if placed is not None]
        planes = self.planes if self.planes is not None else fixed_bodies(self.engine, self.friction)[0]
        standing = tuple(self.assembly.bricks.values())
        self.assembly = Assembly(planes, self.friction, self.assembly.gravity, self.tolerances, tables, overlap=inf)
        judgement = release_until_stable(self.assembly, self.assembly.add_all([*standing, *coming]))
        self._when_changed = judgement.first
        names = [placed.brick.id for placed in coming]
        return self._carry_out(judgement, names, set(names))

    def _apart(self) -> Collection[BodyId]:
        return self._in_hands
