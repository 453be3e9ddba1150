"""Assigns to each brick the proof that covers its weight.

Forces are additive, so an assembly is proven in groups: the weight of each brick belongs to one group, and the forces
of that group balance the weights of its bricks and nothing else. They end on fixed bodies, or as vertical loads inside
the load cores of bricks outside the group, which carry them to the ground regardless of other loads.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from itertools import count

from stability.model import BodyId
from stability.problem import ConeForces, Contact, Stage
from stability.statics.journal import Journal, JournaledDict
from stability.statics.propagation import VerticalForce


@dataclass(frozen=True, slots=True)
class ProofGroup:
    """Bricks that were proven together, and the forces of the proof."""

    members: tuple[BodyId, ...]
    stage: Stage
    vertical: Sequence[VerticalForce] = ()  # vertical forces, each inside a contact
    forces: Sequence[tuple[Contact, ConeForces]] = ()  # forces at the points of contacts

    def touches(self) -> set[BodyId]:
        """Return every body that the forces act on."""
        used = [force.contact for force in self.vertical] + [contact for contact, _ in self.forces]
        return {*self.members, *(c.lower for c in used), *(c.upper for c in used)}


@dataclass(frozen=True, slots=True)
class LedgerState:
    """Snapshot of all entries of a ledger."""

    by_core: frozenset[BodyId]
    groups: Mapping[int, ProofGroup]
    group_of: Mapping[BodyId, int]
    touching: Mapping[BodyId, frozenset[int]]


@dataclass
class Ledger:
    """Groups of an assembly. A brick whose weight lies in its own load core is a group by itself, stored as a name."""

    journal: Journal = field(default_factory=Journal)
    _by_core: JournaledDict[BodyId, None] = field(init=False)
    _groups: JournaledDict[int, ProofGroup] = field(init=False)
    _group_of: JournaledDict[BodyId, int] = field(init=False)
    _touching: JournaledDict[BodyId, frozenset[int]] = field(init=False)
    _numbers: "count[int]" = field(default_factory=count)

    def __post_init__(self) -> None:
        """Start without entries."""
        self._by_core, self._groups, self._group_of, self._touching = (JournaledDict(self.journal) for _ in range(4))

    def prove_by_core(self, brick: BodyId) -> None:
        """Record the proof of a brick whose weight acts inside its load core."""
        self._by_core[brick] = None

    def enter(self, group: ProofGroup) -> None:
        """Enter a group and remove the previous proofs of its members.

        A group that only rests a load on one of them is kept: cores carry that load regardless of other loads.
        """
        for brick in group.members:
            self._by_core.pop(brick, None)
            if brick in self._group_of:
                self._strike_group(self._group_of[brick])
        number = next(self._numbers)
        self._groups[number] = group
        self._group_of |= dict.fromkeys(group.members, number)
        for body in group.touches():
            self._touching[body] = self._touching.get(body, frozenset()) | {number}

    def strike(self, bricks: Iterable[BodyId]) -> set[BodyId]:
        """Remove the groups of these bricks and those with forces on them; return the bricks that lost their proof."""
        lost: set[BodyId] = set()
        for brick in bricks:
            if brick in self._by_core:
                del self._by_core[brick]
                lost.add(brick)
            for number in sorted(self._touching.get(brick, ())):
                lost.update(self._strike_group(number))
        return lost

    def _strike_group(self, number: int) -> tuple[BodyId, ...]:
        group = self._groups.pop(number)
        for body in group.touches():
            if left := self._touching[body] - {number}:
                self._touching[body] = left
            else:
                del self._touching[body]
        for member in group.members:
            del self._group_of[member]
        return group.members

    def state(self) -> LedgerState:
        """Return a snapshot of all entries."""
        return LedgerState(frozenset(self._by_core), dict(self._groups), dict(self._group_of), dict(self._touching))

    def restore(self, state: LedgerState) -> None:
        """Restore all entries."""
        self._by_core.replace(dict.fromkeys(state.by_core))
        self._groups.replace(state.groups)
        self._group_of.replace(state.group_of)
        self._touching.replace(state.touching)
        self._numbers = count(max([next(self._numbers), *(number + 1 for number in state.groups)]))

    def stage(self, brick: BodyId) -> Stage | None:
        """Return the stage that proved a brick; None without a proof."""
        if brick in self._by_core:
            return Stage.LOAD_CORE
        return self._groups[self._group_of[brick]].stage if brick in self._group_of else None

    def group(self, brick: BodyId) -> ProofGroup | None:
        """Return the group of a brick; None if its own load core proves it, or nothing."""
        return self._groups[self._group_of[brick]] if brick in self._group_of else None

    def with_partners(self, bricks: Collection[BodyId]) -> set[BodyId]:
        """Return these bricks and all that were proven together with one of them."""
        numbers = {self._group_of[brick] for brick in bricks if brick in self._group_of}
        return {*bricks, *(member for number in numbers for member in self._groups[number].members)}

    def groups(self) -> list[ProofGroup]:
        """Return the groups with forces, in order of entry."""
        return [self._groups[number] for number in sorted(self._groups)]

    def by_core(self) -> Set[BodyId]:
        """Return the bricks whose weight lies in their own load core."""
        return self._by_core.keys()
