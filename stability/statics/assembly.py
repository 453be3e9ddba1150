"""Bricks in their places, and what is proven of them: the statics API.

    >>> assembly = Assembly()
    >>> plank = Brick("a", Box((0.12, 0.024, 0.008)), 0.0115)
    >>> assembly.add(plank, Pose((0.0, 0.0, 0.004))).stability
    <Stability.STABLE: 'stable'>

No engine takes part. Bricks come, go and move one by one or together, and only what that can affect is judged again.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from copy import copy
from dataclasses import replace
from time import perf_counter
from types import MappingProxyType

from stability.garbage import rarely_collected
from stability.geometry.plan import Point2
from stability.geometry.polygons import depth
from stability.graph import reached
from stability.model import EARTH, GROUND, BodyId, Brick, Plane, Pose
from stability.statics.admission import admit_brick, admit_names, admit_site, listed
from stability.statics.brick_graph import brick_graph, rests_on
from stability.statics.certificate import Tally, tallied, total_forces
from stability.statics.facts import Contact, Forces, Placed, Problem, Stability, Stage, Tolerances, Verdict, by_place
from stability.statics.prover import Prover
from stability.statics.rounding import rounded
from stability.statics.structure import Structure

LEVEL_GROUND = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction=0.5)


class Assembly:
    """Bricks, what they stand on, and the proof of each brick."""

    def __init__(
        self,
        planes: Iterable[Plane] = (LEVEL_GROUND,),
        friction: float = 0.5,
        gravity: float = EARTH,
        tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
        tables: Iterable[Placed] = (),
    ) -> None:
        """Begin with the fixed bodies alone: planes, and `tables`, which are boxes that never move.

        `friction` is the Coulomb coefficient of brick on brick and on tables; `gravity` is along -z [m/s2].
        """
        planes, tables = listed(planes, "planes, such as [Plane(...)]"), listed(tables, "tables, such as [Placed(...)]")
        admit_site(planes, tables, friction, gravity)
        self._structure = Structure(planes, tables, friction, gravity, tolerances)
        self._fixed = {plane.id for plane in self.planes} | {table.brick.id for table in self.tables}
        self._prover = Prover(self._structure)
        self._verdict = Verdict(Stability.STABLE)
        self.bricks: Mapping[BodyId, Placed] = MappingProxyType(self._structure.bricks)

    @property
    def planes(self) -> tuple[Plane, ...]:
        """The fixed planes."""
        return self._structure.planes

    @property
    def tables(self) -> tuple[Placed, ...]:
        """The boxes that never move."""
        return self._structure.tables

    @property
    def friction(self) -> float:
        """Coulomb coefficient of brick on brick."""
        return self._structure.friction

    @property
    def gravity(self) -> float:
        """Acceleration of free fall [m/s2]."""
        return self._structure.gravity

    def copied(self) -> "Assembly":
        """Another with the same bricks and proofs, which changes by itself."""
        other = copy(self)
        other._prover = self._prover.copied()
        other._structure = other._prover.structure
        other.bricks = MappingProxyType(other._structure.bricks)
        return other

    # --- changes ------------------------------------------------------------------------------------------------------

    def add(self, brick: Brick, pose: Pose) -> Verdict:
        """Set down one brick, at rest; the verdict is that of all there is. Raises ValueError for what is no brick."""
        return self._set_down((Placed(brick, pose),), names_smallest=True)

    def add_all(self, bricks: Iterable[Placed], *, names_smallest: bool = True) -> Verdict:
        """Set down bricks together, at rest. Raises ValueError, before anything has changed, for what is no brick.

        With `names_smallest` an UNSTABLE verdict names as few bricks as are found to fall without the rest: of a heap
        that takes seconds.
        """
        return self._set_down(listed(bricks, "bricks, such as [Placed(brick, pose)]"), names_smallest)

    @rarely_collected()
    def _set_down(self, bricks: Sequence[Placed], names_smallest: bool) -> Verdict:
        started = perf_counter()
        for placed in bricks:
            admit_brick(placed)
        admit_names([placed.brick.id for placed in bricks], self._structure.bricks)
        admit_names([placed.brick.id for placed in bricks], self._fixed)
        coming = sorted(bricks, key=by_place) if len(bricks) > 1 else bricks
        self._prover.put(coming)
        return self._judged(started, [placed.brick.id for placed in coming], names_smallest)

    @rarely_collected()
    def remove(self, bricks: Collection[BodyId], *, names_smallest: bool = True) -> Verdict:
        """Take bricks away. What they carried, or held by their weight, is judged again; see `add_all`."""
        started = perf_counter()
        if isinstance(bricks, str):
            raise TypeError(f"give a collection of names, such as ['{bricks}']")
        names = sorted(set(listed(bricks, "names, such as ['a']")))
        _reject_unknown(self._structure, names)
        return self._judged(started, self._prover.take(names), names_smallest)

    def move(self, brick: BodyId, pose: Pose) -> Verdict:
        """Put a brick somewhere else, at rest."""
        started = perf_counter()
        _reject_unknown(self._structure, [brick])
        placed = Placed(self._structure.bricks[brick].brick, pose)
        admit_brick(placed)
        again = self._prover.take([brick])
        self._prover.put([placed])
        return self._judged(started, [*again, brick], names_smallest=True)

    def _judged(self, started: float, changed: Sequence[BodyId], names_smallest: bool) -> Verdict:
        """Prove what is not proven yet, as far as it can be."""
        found = None if self._prover.all_proven() else self._prover.prove(names_smallest)
        if found is None:
            stage = self._prover.dearest(changed)
            self._verdict = Verdict(Stability.STABLE, stage, seconds=perf_counter() - started)
        else:
            self._verdict = replace(found, seconds=perf_counter() - started)
        return self._verdict

    # --- answers ------------------------------------------------------------------------------------------------------

    def verdict(self) -> Verdict:
        """The last verdict, which is that of the whole assembly."""
        return self._verdict

    def stage(self, brick: BodyId) -> Stage | None:
        """Which stage proved a brick; None while none has."""
        _reject_unknown(self._structure, [brick])
        return self._prover.ledger.stage(brick)

    def contacts(self, brick: BodyId) -> Sequence[Contact]:
        """The contacts of a brick, with bricks and planes."""
        _reject_unknown(self._structure, [brick])
        return tuple(self._structure.touching[brick].values())

    def all_contacts(self) -> Sequence[Contact]:
        """All contacts, each once."""
        return self._structure.contacts_of(self._structure.bricks)

    def with_all_above(self, bricks: Collection[BodyId]) -> set[BodyId]:
        """These bricks, and all that they can carry, directly or through others."""
        _reject_unknown(self._structure, sorted(bricks))
        return self._structure.with_all_above(bricks)

    def with_all_below(self, bricks: Collection[BodyId]) -> set[BodyId]:
        """These bricks, and all that can carry them, directly or through others."""
        _reject_unknown(self._structure, sorted(bricks))
        return reached(bricks, lambda brick: self._structure.below([brick]))

    def around(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """The bricks that may be as close to a brick as this [m]: a superset, by upright boxes, by name."""
        _reject_unknown(self._structure, [brick])
        return self._structure.around(brick, within)

    def core_depth(self, brick: BodyId, point: Point2) -> float:
        """How deep a point in plan lies inside the load core of a brick [m]; negative outside, -inf if it has none."""
        _reject_unknown(self._structure, [brick])
        return depth(point, self._structure.cores[brick].polygon)

    def rests_on(self, brick: BodyId) -> tuple[BodyId, ...]:
        """The bodies that a brick rests on or leans on, by name."""
        _reject_unknown(self._structure, [brick])
        return tuple(rests_on(self._structure, self._prover.ledger, brick))

    def problem(self, bricks: Collection[BodyId] | None = None) -> Problem:
        """The equilibrium of some bricks with all others held fixed, or that of all bricks."""
        group = list(self._structure.bricks) if bricks is None else sorted(bricks)
        _reject_unknown(self._structure, group)
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
        _reject_unknown(self._structure, [brick])
        return self.all_shares(self._structure.with_all_above([brick]))[brick]

    def all_shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """The shares of all bricks, or of some as if nothing else were there."""
        return brick_graph(self._structure, self._prover.ledger, self._structure.bricks if bricks is None else bricks)


def _reject_unknown(structure: Structure, names: Sequence[BodyId]) -> None:
    for name in names:
        if name not in structure.bricks:
            raise LookupError(f"there is no brick '{name}'")
