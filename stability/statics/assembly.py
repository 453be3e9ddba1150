"""Bricks that stand about, and what is proven of them: the statics API.

    >>> assembly = Assembly()
    >>> plank = Brick("a", (0.12, 0.024, 0.008), 0.0115)
    >>> assembly.add(plank, Pose((0.0, 0.0, 0.004))).stability
    <Stability.STABLE: 'stable'>

No engine takes part. Bricks come, go and move one by one or together, and only what that can affect is judged again.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from types import MappingProxyType

from stability.geometry.plan import Point2
from stability.geometry.polygons import depth
from stability.graph import reached
from stability.model import EARTH, GROUND, BodyId, Brick, Plane, Pose
from stability.statics.admission import admit_brick, admit_names, admit_site
from stability.statics.brick_graph import brick_graph, rests_on
from stability.statics.cascade import Partners, judge
from stability.statics.certificate import total_forces
from stability.statics.facts import Contact, Forces, Placed, Problem, Stability, Stage, Tolerances, Verdict
from stability.statics.ledger import Ledger
from stability.statics.structure import Structure

LEVEL_GROUND = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction=0.5)
LOST_DIGITS = 1e-15  # of a coordinate: a few times what one rounding takes
DEAREST_FIRST = tuple(reversed(Stage))


class Assembly:
    """Bricks and planes, and the proof of each brick."""

    def __init__(
        self,
        planes: Iterable[Plane] = (LEVEL_GROUND,),
        friction: float = 0.5,
        gravity: float = EARTH,
        tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
        tables: Iterable[Placed] = (),
    ) -> None:
        """Nothing stands yet but fixed planes, and `tables`: boxes that never move.

        `friction` is the Coulomb coefficient of brick on brick and on tables; `gravity` is along -z [m/s2].
        """
        self._structure = Structure(tuple(planes), tuple(tables), friction, gravity, tolerances)
        admit_site(self.planes, self.tables, friction, gravity)
        self._fixed = {plane.id for plane in self.planes} | {table.brick.id for table in self.tables}
        self._ledger = Ledger()
        self._unproven: set[BodyId] = set()
        self._in_doubt: dict[BodyId, Verdict] = {}  # what was found of unproven bricks
        self._partners = Partners(self._structure, self._ledger.with_partners)
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

    @property
    def names_smallest(self) -> bool:
        """Whether an UNSTABLE verdict names as few bricks as are found to fall without the rest: seconds for heaps."""
        return self._structure.smallest

    @names_smallest.setter
    def names_smallest(self, wanted: bool) -> None:
        self._structure.smallest = wanted

    # --- changes ------------------------------------------------------------------------------------------------------

    def add(self, brick: Brick, pose: Pose) -> Verdict:
        """Set down one brick, at rest; the verdict is that of all there is. Raises ValueError for what is no brick."""
        return self._set_down((Placed(brick, pose),))

    def add_all(self, bricks: Iterable[Placed]) -> Verdict:
        """Set down bricks together, at rest. Raises ValueError, before anything has changed, for what is no brick."""
        return self._set_down(tuple(bricks))

    def _set_down(self, bricks: Sequence[Placed]) -> Verdict:
        started = perf_counter()
        for placed in bricks:
            admit_brick(placed)
        admit_names([placed.brick.id for placed in bricks], self._structure.bricks)
        admit_names([placed.brick.id for placed in bricks], self._fixed)
        coming = sorted(bricks, key=_by_height) if len(bricks) > 1 else bricks
        for placed in coming:
            self._structure.put(placed)
            self._ask_core(placed.brick.id)
        names = [placed.brick.id for placed in coming]
        self._touched(names)
        return self._judged(started, names)

    def remove(self, bricks: Collection[BodyId]) -> Verdict:
        """Take bricks away. What they carried, or held by their weight, is judged again."""
        started = perf_counter()
        if isinstance(bricks, str):
            raise TypeError(f"give a collection of names, such as ['{bricks}']")
        names = sorted(set(bricks))
        self._reject_unknown(names)
        return self._judged(started, self._take(names))

    def move(self, brick: BodyId, pose: Pose) -> Verdict:
        """Put a brick somewhere else, at rest."""
        started = perf_counter()
        self._reject_unknown([brick])
        placed = replace(self._structure.bricks[brick], pose=pose)
        admit_brick(placed)
        again = self._take([brick])
        self._structure.put(placed)
        self._ask_core(brick)
        self._touched([brick])
        return self._judged(started, [*again, brick])

    def _reject_unknown(self, names: Sequence[BodyId]) -> None:
        for name in names:
            if name not in self._structure.bricks:
                raise LookupError(f"there is no brick '{name}'")

    def _touched(self, names: Iterable[BodyId]) -> None:
        """What was found of everything connected with these bricks has to be found anew."""
        if self._in_doubt:
            for name in names:
                for other in self._structure.component(name):
                    self._in_doubt.pop(other, None)

    def _take(self, bricks: Sequence[BodyId]) -> list[BodyId]:
        """Take bricks out, and the proofs that counted on them; returns the bricks to be judged again."""
        structure = self._structure
        self._touched(bricks)
        affected = structure.with_all_above(bricks)
        while True:
            larger = structure.with_all_above(affected | self._ledger.strike(affected))
            if len(larger) == len(affected):
                break
            affected = larger
        for name in bricks:
            structure.take(name)
        again = structure.upwards(affected.difference(bricks))
        self._unproven.difference_update(bricks)
        for name in again:
            del structure.cores[name]
        for name in again:
            structure.find_core(name)
            self._ask_core(name)
        return again

    # --- judging ------------------------------------------------------------------------------------------------------

    def _ask_core(self, name: BodyId) -> None:
        """The first stage."""
        if self._structure.cores[name].carries(self._structure.weights[name].at):
            self._ledger.prove_by_core(name)
            self._unproven.discard(name)
        else:
            self._unproven.add(name)

    def _judged(self, started: float, changed: Sequence[BodyId]) -> Verdict:
        """Prove what is not proven yet, as far as it can be."""
        if self._unproven:
            found = self._ask_cascade()
            if found is not None:
                self._verdict = replace(found, seconds=perf_counter() - started)
                return self._verdict
        self._verdict = Verdict(Stability.STABLE, self._dearest(changed), seconds=perf_counter() - started)
        return self._verdict

    def _ask_cascade(self) -> Verdict | None:
        """Judge the bricks without a proof, from the lowest on; None if all are proven now."""
        found: Verdict | None = None
        for name in self._structure.upwards(self._unproven):
            if name not in self._unproven:
                continue
            verdict = self._in_doubt.get(name) or self._asked(name)
            found = verdict or found
            if found is not None and found.stability is Stability.UNSTABLE:
                break  # what moves must go before more can be said
        return found

    def _asked(self, name: BodyId) -> Verdict | None:
        """What the cascade says of a brick if it cannot prove it; remembered until something near it changes."""
        answer = judge(self._structure, name, self._partners)
        if answer.group is not None:
            self._ledger.enter(answer.group)
            self._unproven.difference_update(answer.group.members)
            return None
        if answer.verdict is not None:
            self._in_doubt |= dict.fromkeys(self._unproven.intersection({*answer.verdict.moving, name}), answer.verdict)
        return answer.verdict

    def _dearest(self, bricks: Sequence[BodyId]) -> Stage | None:
        if len(bricks) == 1:
            return self._ledger.stage(bricks[0])
        stages = {self._ledger.stage(name) for name in bricks}
        return next((stage for stage in DEAREST_FIRST if stage in stages), None)

    # --- answers ------------------------------------------------------------------------------------------------------

    def verdict(self) -> Verdict:
        """The last verdict: that of all there is."""
        return self._verdict

    def stage(self, brick: BodyId) -> Stage | None:
        """Which stage proved a brick; None while none has."""
        self._reject_unknown([brick])
        return self._ledger.stage(brick)

    def contacts(self, brick: BodyId) -> Sequence[Contact]:
        """The contacts of a brick, with bricks and planes."""
        self._reject_unknown([brick])
        return tuple(self._structure.touching[brick].values())

    def all_contacts(self) -> Sequence[Contact]:
        """Every contact, each once."""
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
        return tuple(rests_on(self._structure, self._ledger, brick))

    def problem(self, bricks: Collection[BodyId] | None = None) -> Problem:
        """The equilibrium of some bricks, all others held fixed, or of all."""
        group = list(self._structure.bricks) if bricks is None else sorted(bricks)
        return self._structure.problem(group, self._structure.contacts_of(group))

    def forces(self) -> Forces | None:
        """Contact forces that balance all there is, one entry for each of `all_contacts()`, checked by arithmetic.

        None unless the verdict is STABLE. Such forces are not unique.
        """
        if self._unproven:
            return None
        from stability.statics.proof import check_forces  # noqa: PLC0415 -- it brings numpy, and verdicts do without

        problem = self.problem()
        forces = total_forces(self._structure, self._ledger, list(problem.contacts))
        check = check_forces(problem, forces, self._rounded(problem))
        if not check.holds:
            raise ArithmeticError(f"the proof of the assembly does not hold: {check}")
        return forces

    def _rounded(self, problem: Problem) -> Tolerances:
        """The tolerances, with what is lost of a residual because coordinates far from the origin are rounded."""
        tolerances = self._structure.tolerances
        furthest = max((abs(part) for p in problem.bricks.values() for part in p.pose.position_W), default=0.0)
        smallest = min((max(p.brick.size) for p in problem.bricks.values()), default=1.0)
        return replace(tolerances, residual=tolerances.residual + LOST_DIGITS * furthest / smallest)

    def shares(self, brick: BodyId) -> Mapping[BodyId, float]:
        """What a brick rests on, and which part of its load goes there; see `brick_graph` on what these mean."""
        self._reject_unknown([brick])
        return self.all_shares(self._structure.with_all_above([brick]))[brick]

    def all_shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """The same of all bricks, or of some as if nothing else were there."""
        return brick_graph(self._structure, self._ledger, self._structure.bricks if bricks is None else bricks)


def _by_height(placed: Placed) -> tuple[float, BodyId]:
    return placed.pose.position_W[2], placed.brick.id
