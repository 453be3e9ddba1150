"""What can be asked of bricks in their places, and of what is proven of them; nothing here changes anything."""

from collections.abc import Collection, Mapping, Sequence, Set
from types import MappingProxyType
from typing import Final

from stability.friction_law import GivenFriction
from stability.geometry.plan import Point2
from stability.geometry.polygons import depth
from stability.graph import reached
from stability.model import BodyId, Plane
from stability.statics.admission import admit_name
from stability.statics.brick_graph import brick_graph, rests_on
from stability.statics.certificate import Tally, tallied, total_forces
from stability.statics.facts import Contact, Forces, Placed, Problem, Stage, Tolerances, Verdict
from stability.statics.journal import Kept
from stability.statics.prover import Prover
from stability.statics.rounding import rounded
from stability.statics.structure import Structure

LAST: Final = "last"


class AssemblyAnswers:
    """Bricks, what they stand on, and the proof of each brick."""

    _working: Prover
    _said: Kept[str, Verdict]

    @property
    def _prover(self) -> Prover:
        """All that is proven, by changes that took effect."""
        self._working.structure.journal.undo()
        return self._working

    @property
    def _structure(self) -> Structure:
        return self._prover.structure

    @property
    def _verdict(self) -> Verdict:
        self._working.structure.journal.undo()
        return self._said[LAST]

    @property
    def bricks(self) -> Mapping[BodyId, Placed]:
        """In the order in which they came."""
        return MappingProxyType(self._structure.bricks)

    @property
    def planes(self) -> tuple[Plane, ...]:
        """The fixed planes."""
        return self._structure.planes

    @property
    def tables(self) -> tuple[Placed, ...]:
        """The boxes that never move."""
        return self._structure.tables

    @property
    def friction(self) -> GivenFriction:
        """Coulomb coefficient of brick on brick, as it was given."""
        return self._structure.friction

    @property
    def gravity(self) -> float:
        """Acceleration of free fall [m/s2]."""
        return self._structure.gravity

    @property
    def tolerances(self) -> Tolerances:
        """How exact it is."""
        return self._structure.tolerances

    def _reject_unknown(self, names: Sequence[BodyId]) -> None:
        for name in names:
            admit_name("a brick", name)
            if name not in self._structure.bricks:
                raise LookupError(f"there is no brick '{name}'")

    def verdict(self) -> Verdict:
        """The last verdict, which is that of the whole assembly."""
        return self._verdict

    def stage(self, brick: BodyId) -> Stage | None:
        """Which stage proved a brick; None while none has."""
        self._reject_unknown([brick])
        return self._prover.ledger.stage(brick)

    def contacts(self, brick: BodyId) -> Sequence[Contact]:
        """The contacts of a brick, with bricks and planes."""
        self._reject_unknown([brick])
        return tuple(self._structure.touching[brick].values())

    def all_contacts(self) -> Sequence[Contact]:
        """All contacts, each once."""
        return self._structure.contacts_of(self._structure.bricks)

    def with_all_above(self, bricks: Collection[BodyId]) -> set[BodyId]:
        """These bricks, and all that they can carry, directly or through others."""
        self._reject_unknown(sorted(bricks))
        return self._structure.with_all_above(bricks)

    def with_all_below(self, bricks: Collection[BodyId]) -> set[BodyId]:
        """These bricks, and all that can carry them, directly or through others."""
        self._reject_unknown(sorted(bricks))
        return reached(bricks, lambda brick: self._structure.below([brick]))

    def around(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """The bricks that may be as close to a brick as this [m]: a superset, by upright boxes, by name."""
        self._reject_unknown([brick])
        return self._structure.around(brick, within)

    def core_depth(self, brick: BodyId, point: Point2) -> float:
        """How deep a point in plan lies inside the load core of a brick [m]; negative outside, -inf if it has none."""
        self._reject_unknown([brick])
        return depth(point, self._structure.cores[brick].polygon)

    def rests_on(self, brick: BodyId) -> tuple[BodyId, ...]:
        """The bodies that a brick rests on or leans on, by name."""
        self._reject_unknown([brick])
        return tuple(rests_on(self._structure, self._prover.ledger, brick))

    def problem(self, bricks: Collection[BodyId] | None = None) -> Problem:
        """The equilibrium of some bricks with all others held fixed, or that of all bricks."""
        group = list(self._structure.bricks) if bricks is None else sorted(bricks)
        self._reject_unknown(group)
        return self._structure.problem(group, self._structure.contacts_of(group))

    def forces(self) -> Forces | None:
        """Contact forces that balance all there is, one entry for each of `all_contacts()`, checked by arithmetic.

        None unless the verdict is STABLE. Such forces are not unique.
        """
        if not self._prover.all_proven():
            return None
        from stability.statics.proof import check_forces  # noqa: PLC0415 -- it brings numpy, and verdicts do without

        problem = self.problem()
        forces = total_forces(self._structure, self._prover.ledger, list(problem.contacts))
        check = check_forces(problem, forces, rounded(problem, self._structure.tolerances))
        if not check.holds:
            raise ArithmeticError(f"the proof of the assembly does not hold: {check}")
        return forces

    def forces_above(self, bricks: Collection[BodyId], among: Set[BodyId] | None = None) -> Tally:
        """The forces of the proof on these bricks and all that they carry, as they are now, by contact.

        Such forces are not unique, and these are not checked. `among`: of what load cores carry, the weights of these
        bricks only.
        """
        weighed = self.with_all_above(bricks) if among is None else among
        return tallied(self._structure, self._prover.ledger, weighed)

    def shares(self, brick: BodyId) -> Mapping[BodyId, float]:
        """What a brick rests on, and which part of its load goes there; see `brick_graph` on what these mean."""
        self._reject_unknown([brick])
        return self.all_shares(self._structure.with_all_above([brick]))[brick]

    def all_shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """The shares of all bricks, or of some as if nothing else were there."""
        return brick_graph(self._structure, self._prover.ledger, self._structure.bricks if bricks is None else bricks)
