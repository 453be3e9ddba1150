"""Bricks in their places, and what is proven of them: the statics API.

    >>> assembly = Assembly()
    >>> plank = Brick("a", Box((0.12, 0.024, 0.008)), 0.0115)
    >>> assembly.add(plank, Pose((0.0, 0.0, 0.004))).stability
    <Stability.STABLE: 'stable'>

No engine takes part. Bricks come, go and move one by one or together, and only what that can affect is judged again.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, floor, inf, log10
from time import perf_counter
from types import MappingProxyType

from stability.friction_law import GivenFriction
from stability.garbage import rarely_collected
from stability.geometry.touching import BESIDE
from stability.model import EARTH, GROUND, BodyId, Brick, Plane, Pose
from stability.statics.admission import admit_brick, admit_names, admit_overlap, admit_site, listed
from stability.statics.assembly_answers import AssemblyAnswers
from stability.statics.facts import Contact, Placed, Stability, Tolerances, Verdict, by_place
from stability.statics.intrusion import OVERLAP, refuse_overlaps
from stability.statics.prover import Prover, ProverState
from stability.statics.structure import Structure

DIGITS = 3  # of the least width of gaps that a verdict counts on, rounded up
NOISE = 1e-9  # share of a width that is rounding: it does not make 1 mm 1.01 mm

LEVEL_GROUND = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction=0.5)


@dataclass(frozen=True, slots=True)
class AssemblyState:
    """Where all bricks of an assembly are, and all that is proven of them, as it was when `state` was asked."""

    of: "Assembly"
    known: ProverState
    verdict: Verdict


@dataclass(slots=True)
class CountedGaps:
    """How wide gaps must count as contact for bricks to be STABLE. It is answered when first asked, then remembered.

    Bricks that are measured, or cut of wood, have gaps of some hundredths of a millimetre, and settle: so gaps count as
    contact. A verdict that would be another without them says that it counts on them.
    """

    bricks: Sequence[Placed]
    contacts: Sequence[Contact]  # those across gaps
    planes: tuple[Plane, ...]
    friction: GivenFriction
    gravity: float  # [m/s2]
    tolerances: Tolerances
    tables: tuple[Placed, ...]
    _answer: float | None = field(default=None, init=False)

    def within(self) -> float:
        """The least `Tolerances.within` [m] with which the bricks are proven stable, rounded up to three digits."""
        if self._answer is None:
            self._answer = self._searched()
            self.bricks, self.contacts = (), ()
        return self._answer

    def _searched(self) -> float:
        if self._is_stable(0.0):
            return 0.0
        widths = sorted({_rounded_up(width) for contact in self.contacts for width in _widths(contact)})
        below, enough = -1, len(widths)
        while enough - below > 1:
            middle = (below + enough) // 2
            if self._is_stable(widths[middle]):
                enough = middle
            else:
                below = middle
        return widths[min(enough, len(widths) - 1)]

    def _is_stable(self, within: float) -> bool:
        tolerances = replace(self.tolerances, within=min(within, self.tolerances.within))
        assembly = Assembly(self.planes, self.friction, self.gravity, tolerances, self.tables, overlap=inf)
        return assembly.add_all(self.bricks, names_smallest=False).stability is Stability.STABLE


def _widths(contact: Contact) -> Iterable[float]:
    """By point, the least `Tolerances.within` [m] with which its gap counts; see `gap_bridged`."""
    share = min(1.0, max(BESIDE, *(abs(normal[2]) for normal in contact.normals_W)))
    return (gap / share for gap in contact.gaps if gap > 0.0)


def _rounded_up(width: float) -> float:
    unit = 10.0 ** (floor(log10(width)) - DIGITS + 1)
    return float(f"{ceil(width / unit * (1.0 - NOISE)) * unit:.{DIGITS}g}")


class Assembly(AssemblyAnswers):
    """Bricks, what they stand on, and the proof of each brick."""

    def __init__(  # noqa: PLR0913 -- all that a site is made of
        self,
        planes: Iterable[Plane] = (LEVEL_GROUND,),
        friction: GivenFriction = 0.5,
        gravity: float = EARTH,
        tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
        tables: Iterable[Placed] = (),
        *,
        overlap: float = OVERLAP,
    ) -> None:
        """Begin with the fixed bodies alone: planes, and `tables`, which are boxes that never move.

        `friction` is the Coulomb coefficient of brick on brick and on tables, or a `Friction` where it differs by brick
        or by pair; `gravity` is along -z [m/s2]. A brick that is to come deeper than `overlap` [m] into another body is
        a ValueError, and so is one so deep that the two would not count as touching; with `inf` none is.
        """
        planes, tables = listed(planes, "planes, such as [Plane(...)]"), listed(tables, "tables, such as [Placed(...)]")
        admit_site(planes, tables, friction, gravity)
        admit_overlap(overlap)
        self._overlap = overlap
        self._structure = Structure(planes, tables, friction, gravity, tolerances)
        self._fixed = {plane.id for plane in self.planes} | {table.brick.id for table in self.tables}
        self._prover = Prover(self._structure)
        self._verdict = Verdict(Stability.STABLE)
        self.bricks = MappingProxyType(self._structure.bricks)

    def copied(self) -> "Assembly":
        """Another with the same bricks and proofs, which changes by itself."""
        site = self.planes, self.friction, self.gravity, self._structure.tolerances, self.tables
        other = Assembly(*site, overlap=self._overlap)
        other._prover.restore(self._prover.state())
        other._verdict = self._verdict
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

    def would(self, brick: Brick, pose: Pose) -> Verdict:
        """What `add` would say, and nothing is changed."""
        return self._tried(lambda: self.add(brick, pose))

    def would_all(self, bricks: Iterable[Placed], *, names_smallest: bool = True) -> Verdict:
        """What `add_all` would say, and nothing is changed."""
        return self._tried(lambda: self.add_all(bricks, names_smallest=names_smallest))

    def would_without(self, bricks: Collection[BodyId], *, names_smallest: bool = True) -> Verdict:
        """What `remove` would say, and nothing is changed."""
        return self._tried(lambda: self.remove(bricks, names_smallest=names_smallest))

    def _tried(self, change: Callable[[], Verdict]) -> Verdict:
        before = self.state()
        try:
            return change()
        finally:
            self.restore(before)

    def state(self) -> AssemblyState:
        """All bricks in their places with their proofs, to be restored whenever that is wanted, as often as it is."""
        return AssemblyState(self, self._prover.state(), self._verdict)

    def restore(self, state: AssemblyState) -> None:
        """Let all be as it was, proofs as well, to the bit. Raises ValueError for the state of another assembly."""
        if not isinstance(state, AssemblyState):
            raise TypeError(f"expected what `state()` gave, not {state!r}")
        if state.of is not self:
            raise ValueError("this is the state of another assembly; restore it there")
        self._prover.restore(state.known)
        self._verdict = state.verdict

    @rarely_collected()
    def _set_down(self, bricks: Sequence[Placed], names_smallest: bool) -> Verdict:
        started = perf_counter()
        for placed in bricks:
            admit_brick(placed)
        admit_names([placed.brick.id for placed in bricks], self._structure.bricks)
        admit_names([placed.brick.id for placed in bricks], self._fixed)
        if self._overlap < inf:
            refuse_overlaps(self._structure, bricks, self._overlap)
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
        self._reject_unknown(names)
        return self._judged(started, self._prover.take(names), names_smallest)

    def move(self, brick: BodyId, pose: Pose) -> Verdict:
        """Put a brick somewhere else, at rest. Raises LookupError for none that is there, and ValueError as `add`."""
        started = perf_counter()
        self._reject_unknown([brick])
        placed = Placed(self._structure.bricks[brick].brick, pose)
        admit_brick(placed)
        if self._overlap < inf:
            refuse_overlaps(self._structure, [placed], self._overlap, leaving=brick)
        again = self._prover.take([brick])
        self._prover.put([placed])
        return self._judged(started, [*again, brick], names_smallest=True)

    def _judged(self, started: float, changed: Sequence[BodyId], names_smallest: bool) -> Verdict:
        """Prove what is not proven yet, as far as it can be."""
        found = None if self._prover.all_proven() else self._prover.prove(names_smallest)
        if found is None:
            stage = self._prover.dearest(changed)
            seconds = perf_counter() - started
            self._verdict = Verdict(Stability.STABLE, stage, seconds=seconds, gaps=self._gap_question())
        else:
            self._verdict = replace(found, seconds=perf_counter() - started)
        return self._verdict

    def _gap_question(self) -> tuple[CountedGaps, ...]:
        """Whether the proof of all there is counts on gaps as contact; none where there are no gaps."""
        structure = self._structure
        across = tuple(structure.across_gaps.values())
        if not across:
            return ()
        bricks, site = tuple(structure.bricks.values()), (self.planes, self.friction, self.gravity)
        return (CountedGaps(bricks, across, *site, structure.tolerances, self.tables),)
