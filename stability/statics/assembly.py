"""Bricks in their places, and what is proven of them: the statics API.

    >>> assembly = Assembly()
    >>> plank = Brick("a", Box((0.12, 0.024, 0.008)), 0.0115)
    >>> assembly.add(plank, Pose((0.0, 0.0, 0.004))).stability
    <Stability.STABLE: 'stable'>

No engine takes part. Bricks come, go and move one by one or together, and only what that can affect is judged again.
Each change takes effect at once or not at all: what an interrupt breaks off leaves nothing behind.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from math import ceil, floor, inf, log10
from time import perf_counter
from typing import Any

from stability.blas_threads import one_thread
from stability.friction_law import GivenFriction
from stability.garbage import rarely_collected
from stability.geometry.given_numbers import listed, told
from stability.geometry.touching import BESIDE
from stability.model import EARTH, GROUND, BodyId, Brick, Plane, Pose
from stability.statics.admission import admit_brick, admit_names, admit_overlap, admit_site
from stability.statics.assembly_answers import LAST, AssemblyAnswers
from stability.statics.facts import Contact, Placed, Stability, Tolerances, Verdict, by_place
from stability.statics.intrusion import OVERLAP, refuse_overlaps
from stability.statics.journal import Kept
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
    """The question how wide gaps must count as contact for bricks to be STABLE. The answer is found on demand and kept.

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
        if not isinstance(tolerances, Tolerances):
            raise TypeError(f"expected Tolerances(...), not {told(tolerances)}")
        self._overlap = overlap
        self._fixed = {plane.id for plane in planes} | {table.brick.id for table in tables}
        self._working = Prover(Structure(planes, tables, friction, gravity, tolerances))
        self._said: Kept[str, Verdict] = Kept(self._working.structure.journal)  # the last verdict
        self._said[LAST] = Verdict(Stability.STABLE)
        self._working.structure.journal.keep()

    def copied(self) -> "Assembly":
        """Another with the same bricks and proofs, which changes by itself; `copy` and `pickle` make such ones too."""
        make, arguments = self.__reduce__()
        return make(*arguments)

    def __copy__(self) -> "Assembly":
        """As `copied`: nothing that an assembly holds is changed in place, so copies may share it."""
        return self.copied()

    def __deepcopy__(self, memo: dict[int, object]) -> "Assembly":
        """As `copy`."""
        return self.copied()

    def __reduce__(self) -> "tuple[Callable[..., Assembly], tuple[object, ...]]":
        """The site, and all that is known."""
        structure = self._structure
        site = self.planes, self.friction, self.gravity, structure.tolerances, self.tables, self._overlap
        return _made_again, (type(self), site, self._prover.state(), self._verdict)

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
        return self._set_down((Placed(brick, pose),), names_smallest=True, keep=False)

    def would_all(self, bricks: Iterable[Placed], *, names_smallest: bool = True) -> Verdict:
        """What `add_all` would say, and nothing is changed."""
        return self._set_down(listed(bricks, "bricks, such as [Placed(brick, pose)]"), names_smallest, keep=False)

    def would_without(self, bricks: Collection[BodyId], *, names_smallest: bool = True) -> Verdict:
        """What `remove` would say, and nothing is changed."""
        return self._removed(bricks, names_smallest, keep=False)

    @contextmanager
    def _changing(self) -> Iterator[Prover]:
        """Make a change that takes effect only when the journal keeps it.

        An interrupt that comes while this undoes what was broken off leaves the rest to whoever asks next.
        """
        working = self._prover
        try:
            yield working
        finally:
            working.structure.journal.undo()

    def state(self) -> AssemblyState:
        """All bricks in their places with their proofs, to be restored whenever that is wanted, as often as it is."""
        return AssemblyState(self, self._prover.state(), self._verdict)

    def restore(self, state: AssemblyState) -> None:
        """Let all be as it was, proofs as well, to the bit. Raises ValueError for the state of another assembly."""
        if not isinstance(state, AssemblyState):
            raise TypeError(f"expected what `state()` gave, not {told(state)}")
        if state.of is not self:
            raise ValueError("this is the state of another assembly; restore it there")
        with self._changing() as prover:
            prover.restore(state.known)
            self._said[LAST] = state.verdict
            prover.structure.journal.keep()

    @one_thread()
    @rarely_collected()
    def _set_down(self, bricks: Sequence[Placed], names_smallest: bool, keep: bool = True) -> Verdict:
        started = perf_counter()
        for placed in bricks:
            admit_brick(placed)
        with self._changing() as prover:
            admit_names([placed.brick.id for placed in bricks], prover.structure.bricks)
            admit_names([placed.brick.id for placed in bricks], self._fixed)
            if self._overlap < inf:
                refuse_overlaps(prover.structure, bricks, self._overlap)
            coming = sorted(bricks, key=by_place) if len(bricks) > 1 else bricks
            prover.put(coming)
            return self._judged(prover, started, [placed.brick.id for placed in coming], names_smallest, keep)

    def remove(self, bricks: Collection[BodyId], *, names_smallest: bool = True) -> Verdict:
        """Take bricks away. What they carried, or held by their weight, is judged again; see `add_all`."""
        return self._removed(bricks, names_smallest)

    @one_thread()
    @rarely_collected()
    def _removed(self, bricks: Collection[BodyId], names_smallest: bool, keep: bool = True) -> Verdict:
        started = perf_counter()
        if isinstance(bricks, str):
            raise TypeError(f"give a collection of names, such as ['{bricks}']")
        names = listed(bricks, "names, such as ['a']")
        self._reject_unknown(names)
        with self._changing() as prover:
            return self._judged(prover, started, prover.take(sorted(set(names))), names_smallest, keep)

    @one_thread()
    def move(self, brick: BodyId, pose: Pose) -> Verdict:
        """Put a brick somewhere else, at rest. Raises LookupError for none that is there, and ValueError as `add`."""
        started = perf_counter()
        self._reject_unknown([brick])
        with self._changing() as prover:
            placed = Placed(prover.structure.bricks[brick].brick, pose)
            admit_brick(placed)
            if self._overlap < inf:
                refuse_overlaps(prover.structure, [placed], self._overlap, leaving=brick)
            again = prover.take([brick])
            prover.put([placed])
            return self._judged(prover, started, [*again, brick], names_smallest=True)

    def _judged(
        self, prover: Prover, started: float, changed: Sequence[BodyId], names_smallest: bool, keep: bool = True
    ) -> Verdict:
        """Prove what is not proven yet, as far as it can be, and let it all take effect if that is wanted."""
        found = None if prover.all_proven() else prover.prove(names_smallest)
        if found is None:
            found = Verdict(Stability.STABLE, prover.dearest(changed), gaps=self._gap_question(prover.structure))
        said = self._said[LAST] = replace(found, seconds=perf_counter() - started)
        if keep:
            prover.structure.journal.keep()
        return said

    def _gap_question(self, structure: Structure) -> tuple[CountedGaps, ...]:
        """Whether the proof of all there is counts on gaps as contact; none where there are no gaps."""
        across = tuple(structure.across_gaps.values())
        if not across:
            return ()
        bricks, site = tuple(structure.bricks.values()), (structure.planes, structure.friction, structure.gravity)
        return (CountedGaps(bricks, across, *site, structure.tolerances, structure.tables),)


def _made_again(kind: type[Assembly], site: tuple[Any, ...], known: ProverState, verdict: Verdict) -> Assembly:
    *others, overlap = site
    made = kind(*others, overlap=overlap)
    made.restore(AssemblyState(made, known, verdict))
    return made
