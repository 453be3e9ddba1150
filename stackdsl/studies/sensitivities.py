"""What a margin depends on most: places and masses of bricks, friction of joints, numbers of the file.

Slopes come from the forces and motions at the limit, without solving anything anew. Those that matter most are held
against differences: the margin is asked again with a little less and a little more. Where that says otherwise the
margin has a kink, or forces that are not unique, and the differences are what is told.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf
from typing import Final

from stability.analysis.acceleration_margin import acceleration
from stability.analysis.margins import least_friction
from stability.analysis.sensitivity import MarginLimit, acceleration_limits, friction_limits, slopes
from stability.geometry.vectors import add_scaled, cross, unit
from stability.model import BodyId, Pose, Vec3
from stability.problem import Contact, Placed, Problem, Stability, Wrench
from stability.statics.assembly import Assembly
from stability.statics.structure import Structure
from stackdsl.checking.cases import Case
from stackdsl.judging.proofs import Proofs, proofs_of
from stackdsl.studies.find_limit import SearchError, SearchVariable, names_in, search_variable_of

SHARE: Final = 0.01  # of each number: what is compared
NEAR: Final = 1e-6  # of each number: how far data are compared for slopes
APART: Final = 1e-3  # of each number: how far the margin is asked anew
AGREE: Final = 0.02  # of a slope: how far it may be off what differences say, which are a thousandth off themselves
FINE: Final = 1e-8  # to which margins are asked
ROUNDING: Final = 1e-9  # of a margin: no change
CHECKED: Final = 10  # slopes, unless told otherwise


class MarginKind(StrEnum):
    """Which margin."""

    ACCELERATION = "acceleration"  # [g] that is survived in every direction; of a tilt, its tangent
    FRICTION = "friction"  # the least coefficient with which it stands


class SlopeSource(StrEnum):
    """Where slopes come from."""

    DUALS = "duals"  # from forces and motions at the limit; not held against differences
    CHECKED = "checked"  # the same, and differences say so too
    DIFFERENCES = "differences"  # the margin was asked anew, as forces or motions are not unique, or touch elsewhere
    NONE = "none"  # there is no margin on one of the sides


@dataclass(frozen=True, slots=True)
class Effect:
    """How a margin changes with one number."""

    what: str
    unit: str  # of the number; empty for none
    size: float  # of the number, or of the brick that is moved, in its unit
    less: float | None  # change of the margin by a unit, to the side of less
    more: float | None  # to the side of more
    source: SlopeSource

    @property
    def matters(self) -> float:
        """By how much the margin changes at most, by a hundredth of the number."""
        return SHARE * abs(self.size) * max(abs(self.less or 0.0), abs(self.more or 0.0))

    @property
    def counts(self) -> bool:
        """Whether it matters at all, beyond rounding."""
        return self.less is None or self.more is None or self.matters > ROUNDING

    @property
    def has_kink(self) -> bool:
        """Whether it changes otherwise to one side than to the other."""
        if self.less is None or self.more is None:
            return True
        return self.counts and abs(self.less - self.more) > AGREE * max(abs(self.less), abs(self.more))


@dataclass(frozen=True, slots=True)
class Sensitivities:
    """What one margin of one case depends on, the most first."""

    case: str
    of: MarginKind
    margin: float
    effects: Sequence[Effect]
    judged: int = 0  # bricks that statics judged
    bricks: int = 0  # bricks that are built

    @property
    def in_doubt(self) -> bool:
        """Whether differences contradicted a slope, so that others that were not checked, or are none, may be off."""
        return {SlopeSource.DIFFERENCES, SlopeSource.DUALS} <= {each.source for each in self.effects}


@dataclass(frozen=True, slots=True)
class _Number:
    """What may be changed."""

    what: str
    unit: str
    size: float
    problem: Callable[[float], Problem | None]  # with so much more of it, in its unit


def sensitivities_of(
    case: Case,
    name: str,
    of: MarginKind,
    checked: int = CHECKED,
    told: Callable[[int, int], None] = lambda done, all_: None,
) -> Sensitivities:
    """What a margin of a case depends on; `told` hears of how many numbers enough is known, of how many.

    Raises SearchError for what has no such margin.
    """
    proofs = proofs_of(case.timeline)
    _refuse(proofs)
    margins = _Margins(proofs.assembly, of)
    if not margins.limits:
        raise SearchError(f"it has no limit of {of.value}, so that nothing matters to it")
    numbers = [*_places(proofs.assembly), *_masses(proofs.assembly), *_joints(proofs.assembly), *_variables(case)]
    effects = []
    for done, number in enumerate(numbers):
        effects.append(margins.effect(number))
        told(done, len(numbers))
    order = sorted(range(len(numbers)), key=lambda i: -effects[i].matters)
    for rank, index in enumerate(order):
        if rank < checked or effects[index].source is SlopeSource.NONE:
            effects[index] = margins.held_against_differences(numbers[index], effects[index])
        told(rank, len(numbers))
    ranked = sorted(effects, key=lambda each: -each.matters)
    bricks = sum(not each.hits for each in case.timeline.placements)
    return Sensitivities(name, of, margins.value, ranked, len(proofs.assembly.bricks), bricks)


def _refuse(proofs: Proofs) -> None:
    verdict = proofs.verdict
    if not proofs.assembly.bricks:
        raise SearchError("nothing is set down at rest, so there is nothing that statics could judge")
    if verdict.stability is not Stability.STABLE:
        raise SearchError(f"{verdict.stability.upper()}: {verdict.reason}; what does not stand has no margin")


# --- the margin -------------------------------------------------------------------------------------------------------


class _Margins:
    """One margin of an assembly, and of what is nearly the same."""

    def __init__(self, assembly: Assembly, of: MarginKind) -> None:
        self._of, self._gravity = of, assembly.gravity
        problem = assembly.problem()
        self._unit = (
            1.0 if of is MarginKind.ACCELERATION else max((c.law.friction for c in problem.contacts), default=0.0)
        )
        found = (
            acceleration_limits(problem, self._gravity) if of is MarginKind.ACCELERATION else friction_limits(problem)
        )
        self.value: float = found[0] * self._unit if found[0] < inf else inf
        self.limits: Sequence[MarginLimit] = found[1]
        self._exact = self._asked(problem) or self.value

    def effect(self, number: _Number) -> Effect:
        """What one number changes, from the limits alone."""
        step = NEAR * number.size
        found = slopes(self.limits, number.problem(-step), number.problem(step), step)
        if found is None:
            return Effect(number.what, number.unit, number.size, None, None, SlopeSource.NONE)
        less, more = found.less * self._unit, found.more * self._unit
        return Effect(number.what, number.unit, number.size, less, more, SlopeSource.DUALS)

    def held_against_differences(self, number: _Number, effect: Effect) -> Effect:
        """The same, held against the margin with a little less and a little more."""
        step = APART * number.size
        below, above = (self._asked(number.problem(side)) for side in (-step, step))
        less = None if below is None else (self._exact - below) / step
        more = None if above is None else (above - self._exact) / step
        if effect.less is not None and effect.more is not None and less is not None and more is not None:
            largest = max(map(abs, (less, more, effect.less, effect.more)))
            off = max(abs(less - effect.less), abs(more - effect.more))
            if off <= AGREE * largest + FINE * self._exact / step:
                return replace(effect, source=SlopeSource.CHECKED)
        source = SlopeSource.NONE if less is None and more is None else SlopeSource.DIFFERENCES
        return replace(effect, less=less, more=more, source=source)

    def _asked(self, problem: Problem | None) -> float | None:
        """The margin of a problem; None if it has none."""
        if problem is None:
            return None
        if self._of is MarginKind.ACCELERATION:
            found = acceleration(problem, FINE, self._gravity)
            return None if found is None or found.upper == inf else found.upper
        factor = least_friction(problem, FINE)
        return None if factor.factor == inf else 0.5 * (factor.factor + factor.too_little) * self._unit


# --- what may be changed ----------------------------------------------------------------------------------------------


def _places(assembly: Assembly) -> Iterator[_Number]:
    """Where bricks lie, along two axes of the ground."""
    moved = _Moved(assembly)
    normal = assembly.planes[0].normal_W if assembly.planes else (0.0, 0.0, 1.0)
    across = unit(cross(normal, (1.0, 0.0, 0.0)))
    axes = {"x": cross(across, normal), "y": across}
    for name, placed in assembly.bricks.items():
        for letter, axis in axes.items():
            size = 1000.0 * placed.brick.shape.length
            yield _Number(f"{letter} of {name}", "mm", size, _shifted(moved, name, axis))


def _shifted(moved: "_Moved", brick: BodyId, axis: Vec3) -> Callable[[float], Problem]:
    return lambda millimetres: moved.problem(brick, add_scaled((0.0, 0.0, 0.0), 1e-3 * millimetres, axis))


class _Moved:
    """An assembly with one brick elsewhere: only what that touches is found anew, and nothing is proven."""

    def __init__(self, assembly: Assembly) -> None:
        self._structure = Structure(
            assembly.planes, assembly.tables, assembly.friction, assembly.gravity, assembly.tolerances
        )
        for placed in assembly.bricks.values():
            self._structure.put(placed)

    def problem(self, brick: BodyId, shift: Vec3) -> Problem:
        """The problem with a brick shifted [m]."""
        here = self._structure.bricks[brick]
        there = Pose(add_scaled(here.pose.position_W, 1.0, shift), here.pose.orientation)
        self._structure.take(brick)
        self._structure.put(Placed(here.brick, there))
        names = sorted(self._structure.bricks)
        found = self._structure.problem(names, self._structure.contacts_of(names))
        self._structure.take(brick)
        self._structure.put(here)
        return found


def _masses(assembly: Assembly) -> Iterator[_Number]:
    problem = assembly.problem()
    for name, placed in assembly.bricks.items():
        yield _Number(f"mass of {name}", "g", 1000.0 * placed.brick.mass, _heavier(problem, name, assembly.gravity))


def _heavier(problem: Problem, name: BodyId, gravity: float) -> Callable[[float], Problem]:
    placed = problem.bricks[name]

    def with_more(grams: float) -> Problem:
        mass = placed.brick.mass + 1e-3 * grams
        bricks = {**problem.bricks, name: replace(placed, brick=replace(placed.brick, mass=mass))}
        return replace(problem, bricks=bricks, loads={**problem.loads, name: Wrench((0.0, 0.0, -mass * gravity))})

    return with_more


def _joints(assembly: Assembly) -> Iterator[_Number]:
    problem = assembly.problem()
    for number, contact in enumerate(problem.contacts):
        if contact.law.friction > 0.0:
            what = f"friction of {contact.upper} on {contact.lower}"
            yield _Number(what, "", contact.law.friction, _rougher(problem, number, contact))


def _rougher(problem: Problem, number: int, contact: Contact) -> Callable[[float], Problem]:
    def with_more(coefficient: float) -> Problem:
        contacts = list(problem.contacts)
        contacts[number] = replace(contact, law=contact.law.with_friction(contact.law.friction + coefficient))
        return replace(problem, contacts=contacts)

    return with_more


def _variables(case: Case) -> Iterator[_Number]:
    """Numbers of the file that need not be whole, but for places of single bricks, which are there already."""
    places = {f"{axis} of {each.brick.id}" for axis in "xy" for each in case.timeline.placements}
    for name in names_in(case):
        if name in places:
            continue
        try:
            sought = search_variable_of(case, name, wants_more=True)
        except SearchError:  # such as one that is written twice
            continue
        size = abs(sought.number) or sought.size
        if _built(sought, NEAR * size) is not None:
            yield _Number(name, sought.unit, size, _other(sought))


def _other(sought: SearchVariable) -> Callable[[float], Problem | None]:
    return lambda more: _built(sought, more)


def _built(sought: SearchVariable, more: float) -> Problem | None:
    timeline, _ = sought.compiled(sought.number + more)
    if timeline is None:
        return None
    proofs = proofs_of(timeline, names_smallest=False)
    return proofs.assembly.problem() if proofs.assembly.bricks else None
