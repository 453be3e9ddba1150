"""Sensitivity of a margin to positions and masses of bricks, friction of contacts, and numbers of the file.

Slopes follow from the forces and motions at the limit, without another solution. The largest ones are checked against
finite differences: the margin is computed with a little less and a little more. If both disagree, the margin has a kink
or its forces are not unique, and the finite differences are reported.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from math import inf
from typing import Final

from stability.analysis.acceleration_margin import acceleration
from stability.analysis.load_factor import load_factor
from stability.analysis.margins import least_friction
from stability.analysis.sensitivity import MarginLimit, acceleration_limits, friction_limits, slopes
from stability.contact_law import MohrCoulomb
from stability.geometry.vectors import add_scaled, cross, unit
from stability.model import BodyId, Pose, Vec3
from stability.notebook import Printed
from stability.problem import Contact, Placed, Problem, Stability, Wrench
from stability.statics.assembly import Assembly
from stability.statics.round_borders import inscribed
from stability.statics.structure import Structure
from stackdsl.checking.cases import Case
from stackdsl.judging.proofs import NO_MARGIN, RIGID, TIED, Proofs, proofs_of
from stackdsl.studies.find_limit import SearchVariable, names_in, search_variable_of
from stackdsl.studies.limit_search import SearchError

SHARE: Final = 0.01  # of each number: the change by which effects are compared
NEAR: Final = 1e-6  # of each number: step for derivatives of the problem data
APART: Final = 1e-3  # of each number: step of finite differences of the margin
AGREE: Final = 0.02  # relative difference of a slope from finite differences, which have an error of a thousandth
FINE: Final = 1e-8  # accuracy of margins
ROUNDING: Final = 1e-9  # of a margin: smaller changes are rounding
UNPROVEN: Final = 2e-5  # of a load factor: by so much its bounds may differ
CHECKED: Final = 10  # default number of checked slopes


class MarginKind(StrEnum):
    """The kind of margin."""

    ACCELERATION = "acceleration"  # [g] survived in every direction; for a tilt, its tangent
    FRICTION = "friction"  # the least coefficient with which the structure stands
    LOAD_FACTOR = "load_factor"  # multiple of its own weight that a structure with joints bears


class SlopeSource(StrEnum):
    """The source of a slope."""

    DUALS = "duals"  # forces and motions at the limit; not checked
    CHECKED = "checked"  # forces and motions at the limit, confirmed by finite differences
    DIFFERENCES = "differences"  # finite differences, as forces, motions or contacts are not unique
    NONE = "none"  # no margin on one of the sides


@dataclass(frozen=True, slots=True)
class Effect:
    """The effect of one number on a margin."""

    what: str  # name of the number
    unit: str  # of the number; empty for none
    size: float  # of the number, or of the moved brick, in that unit
    less: float | None  # slope for a smaller number, per unit
    more: float | None  # slope for a larger number, per unit
    source: SlopeSource

    @property
    def matters(self) -> float:
        """Largest change of the margin if the number changes by a hundredth."""
        return SHARE * abs(self.size) * max(abs(self.less or 0.0), abs(self.more or 0.0))

    @property
    def counts(self) -> bool:
        """Whether the effect is larger than rounding."""
        return self.less is None or self.more is None or self.matters > ROUNDING

    @property
    def has_kink(self) -> bool:
        """Whether the slopes of both sides differ."""
        if self.less is None or self.more is None:
            return True
        return self.counts and abs(self.less - self.more) > AGREE * max(abs(self.less), abs(self.more))


@dataclass(frozen=True, slots=True)
class Sensitivities(Printed):
    """The effects of all numbers on one margin of one case, the largest first."""

    case: str
    of: MarginKind
    margin: float
    effects: Sequence[Effect]
    judged: int = 0  # number of judged bricks
    bricks: int = 0  # number of bricks
    left: int = 0  # numbers without an effect, as the study was interrupted
    unchecked: int = 0  # effects that were to be checked, likewise

    @property
    def in_doubt(self) -> bool:
        """Whether a check contradicted a slope, so that unchecked slopes may be wrong too."""
        return {SlopeSource.DIFFERENCES, SlopeSource.DUALS} <= {each.source for each in self.effects}


@dataclass(frozen=True, slots=True)
class _Number:
    """A number that can be changed."""

    what: str  # its name
    unit: str
    size: float
    problem: Callable[[float], Problem | None]  # the problem, by the change of the number in its unit


def sensitivities_of(
    case: Case,
    name: str,
    of: MarginKind,
    checked: int = CHECKED,
    on_progress: Callable[[int, int], None] = lambda done, all_: None,
) -> Sensitivities:
    """Return the effects of all numbers on a margin of a case. Raises SearchError if there is no such margin.

    `on_progress` is called with the finished part of the work and its total: half for the effects, half for the checks.
    """
    *_, last = sensitivities_so_far(case, name, of, checked, on_progress)
    return last()


def sensitivities_so_far(
    case: Case,
    name: str,
    of: MarginKind,
    checked: int = CHECKED,
    on_progress: Callable[[int, int], None] = lambda done, all_: None,
) -> Iterator[Callable[[], Sensitivities]]:
    """Yield a function after each number and after each check, which returns what is computed, at the end everything.

    So a caller that is interrupted keeps this. See `sensitivities_of`.
    """
    proofs = proofs_of(case.timeline)
    _refuse(proofs, of)
    margins = _LoadFactors(proofs.assembly) if of is MarginKind.LOAD_FACTOR else _Margins(proofs.assembly, of)
    if not margins.limits:
        raise SearchError(f"the structure has no limit of {of.value}, so there are no sensitivities")
    joints = _strengths(proofs.assembly) if of is MarginKind.LOAD_FACTOR else _joints(proofs.assembly)
    numbers = [*_places(proofs.assembly), *_masses(proofs.assembly), *joints, *_variables(case)]
    pulled = set(case.timeline.pulled_out)
    bricks = sum(not each.hits and each.brick.id not in pulled for each in case.timeline.placements)

    def so_far(unchecked: int) -> Sensitivities:
        ranked = sorted(effects, key=lambda each: -each.matters)
        left = len(numbers) - len(effects)
        return Sensitivities(name, of, margins.value, ranked, len(proofs.assembly.bricks), bricks, left, unchecked)

    effects: list[Effect] = []
    yield partial(so_far, checked)
    for number in numbers:
        effects.append(margins.effect(number))
        on_progress(len(effects), 2 * len(numbers))
        yield partial(so_far, checked)
    order = sorted(range(len(numbers)), key=lambda i: -effects[i].matters)
    due = [i for rank, i in enumerate(order) if rank < checked or effects[i].source is SlopeSource.NONE]
    for done, index in enumerate(due, 1):
        effects[index] = margins.checked(numbers[index], effects[index])
        on_progress(len(numbers) * (len(due) + done), 2 * len(numbers) * len(due))
        yield partial(so_far, len(due) - done)


def _refuse(proofs: Proofs, of: MarginKind) -> None:
    verdict = proofs.verdict
    if not proofs.assembly.bricks:
        raise SearchError("no brick is set down at rest, so statics has nothing to judge")
    if verdict.stability is not Stability.STABLE:
        raise SearchError(f"{verdict.stability.upper()}: {verdict.reason}; {NO_MARGIN}")
    if proofs.assembly.strengths:
        raise SearchError(RIGID)
    if proofs.assembly.ties:
        raise SearchError(TIED)
    if proofs.assembly.problem().applied:
        raise SearchError("sensitivities are not computed for bricks under `loads`")
    if of is not MarginKind.LOAD_FACTOR and proofs.assembly.problem().has_joints:
        raise SearchError(
            f"sensitivities of the margin of {of.value} are not computed for bricks with joints; "
            f"use --of {MarginKind.LOAD_FACTOR.value}"
        )


# --- the margin -------------------------------------------------------------------------------------------------------


class _Margins:
    """One margin of an assembly and of its slight changes."""

    def __init__(self, assembly: Assembly, of: MarginKind) -> None:
        self._of, self._gravity = of, assembly.gravity
        problem = inscribed(assembly.problem())
        self._unit = (
            1.0 if of is MarginKind.ACCELERATION else max((c.law.friction for c in problem.contacts), default=0.0)
        )
        value, limits = (
            acceleration_limits(problem, self._gravity) if of is MarginKind.ACCELERATION else friction_limits(problem)
        )
        self.value: float = value * self._unit if value < inf else inf
        self.limits: Sequence[MarginLimit] = limits
        self._exact = self._margin(problem) or self.value

    def effect(self, number: _Number) -> Effect:
        """Return the effect of a number, from the forces and motions at the limit."""
        step = NEAR * number.size
        both = slopes(self.limits, number.problem(-step), number.problem(step), step)
        if both is None:
            return Effect(number.what, number.unit, number.size, None, None, SlopeSource.NONE)
        less, more = both.less * self._unit, both.more * self._unit
        return Effect(number.what, number.unit, number.size, less, more, SlopeSource.DUALS)

    def checked(self, number: _Number, effect: Effect) -> Effect:
        """Return the effect checked against finite differences of the margin, or corrected by these."""
        step = APART * number.size
        below, above = (self._margin(number.problem(side)) for side in (-step, step))
        less = None if below is None else (self._exact - below) / step
        more = None if above is None else (above - self._exact) / step
        if effect.less is not None and effect.more is not None and less is not None and more is not None:
            largest = max(map(abs, (less, more, effect.less, effect.more)))
            off = max(abs(less - effect.less), abs(more - effect.more))
            if off <= AGREE * largest + FINE * self._exact / step:
                return replace(effect, source=SlopeSource.CHECKED)
        source = SlopeSource.NONE if less is None and more is None else SlopeSource.DIFFERENCES
        return replace(effect, less=less, more=more, source=source)

    def _margin(self, problem: Problem | None) -> float | None:
        """Return the margin of a problem; None if it has none."""
        if problem is None:
            return None
        if self._of is MarginKind.ACCELERATION:
            worst = acceleration(problem, FINE, self._gravity)
            return None if worst is None or worst.value == inf else worst.value
        friction = least_friction(problem, FINE)
        return None if friction.factor == inf else 0.5 * (friction.factor + friction.too_little) * self._unit


class _LoadFactors:
    """The load factor of an assembly and of its slight changes. Its slopes are finite differences."""

    def __init__(self, assembly: Assembly) -> None:
        found = load_factor(inscribed(assembly.problem()))
        if found is None or not 0.0 < found.factor < inf:
            raise SearchError("the structure bears any multiple of its own weight, so there are no sensitivities")
        self.value, self.limits = found.factor, (found,)

    def effect(self, number: _Number) -> Effect:
        """Return the effect of a number."""
        step = APART * number.size
        below, above = (self._factor(number.problem(side)) for side in (-step, step))
        less = None if below is None else self._change(self.value - below) / step
        more = None if above is None else self._change(above - self.value) / step
        source = SlopeSource.NONE if less is None and more is None else SlopeSource.DIFFERENCES
        return Effect(number.what, number.unit, number.size, less, more, source)

    def checked(self, _number: _Number, effect: Effect) -> Effect:
        """Return the effect, which is a finite difference already."""
        return effect

    def _change(self, change: float) -> float:
        return change if abs(change) > UNPROVEN * self.value else 0.0

    def _factor(self, problem: Problem | None) -> float | None:
        """Return the load factor of a problem; None if it has none."""
        found = None if problem is None else load_factor(problem)
        return None if found is None or found.factor in {0.0, inf} else found.factor


# --- numbers that can be changed --------------------------------------------------------------------------------------


def _places(assembly: Assembly) -> Iterator[_Number]:
    """Yield the positions of bricks, along two axes of the ground."""
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
    """An assembly with one shifted brick: only the contacts of that brick are recomputed, and nothing is proven."""

    def __init__(self, assembly: Assembly) -> None:
        self._structure = Structure(
            assembly.planes,
            assembly.tables,
            assembly.friction,
            assembly.gravity,
            assembly.tolerances,
            assembly.joints,
            assembly.loads,
        )
        for placed in assembly.bricks.values():
            self._structure.put(placed)

    def problem(self, brick: BodyId, shift: Vec3) -> Problem:
        """Return the problem with a shifted brick [m]."""
        original = self._structure.bricks[brick]
        pose = Pose(add_scaled(original.pose.position_W, 1.0, shift), original.pose.orientation)
        self._structure.take(brick)
        self._structure.put(Placed(original.brick, pose))
        names = sorted(self._structure.bricks)
        problem = self._structure.problem(names, self._structure.contacts_of(names))
        self._structure.take(brick)
        self._structure.put(original)
        return inscribed(problem)


def _masses(assembly: Assembly) -> Iterator[_Number]:
    problem = inscribed(assembly.problem())
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
    problem = inscribed(assembly.problem())
    for number, contact in enumerate(problem.contacts):
        if contact.law.friction > 0.0:
            what = f"friction of {contact.upper} on {contact.lower}"
            yield _Number(what, "", contact.law.friction, _rougher(problem, number, contact))


def _strengths(assembly: Assembly) -> Iterator[_Number]:
    """Yield the strength of each joint, in percent of the present one."""
    problem = assembly.problem()
    pairs = dict.fromkeys((each.lower, each.upper) for each in problem.contacts if not each.law.is_cone)
    for lower, upper in pairs:
        yield _Number(f"strength of the joint of {upper} on {lower}", "%", 100.0, _stronger(problem, lower, upper))


def _stronger(problem: Problem, lower: BodyId, upper: BodyId) -> Callable[[float], Problem]:
    def with_more(percent: float) -> Problem:
        contacts = [
            replace(contact, law=contact.law.times(1.0 + 0.01 * percent))
            if isinstance(contact.law, MohrCoulomb) and (contact.lower, contact.upper) == (lower, upper)
            else contact
            for contact in problem.contacts
        ]
        return replace(problem, contacts=contacts)

    return with_more


def _rougher(problem: Problem, number: int, contact: Contact) -> Callable[[float], Problem]:
    def with_more(coefficient: float) -> Problem:
        contacts = list(problem.contacts)
        contacts[number] = replace(contact, law=contact.law.with_friction(contact.law.friction + coefficient))
        return replace(problem, contacts=contacts)

    return with_more


def _variables(case: Case) -> Iterator[_Number]:
    """Yield the numbers of the file that can be fractions, without positions of bricks, which `_places` yields."""
    places = {f"{axis} of {each.brick.id}" for axis in "xy" for each in case.timeline.placements}
    for name in names_in(case):
        if name in places:
            continue
        try:
            variable = search_variable_of(case, name, wants_more=True)
        except SearchError:  # for example, a number that is written twice
            continue
        size = abs(variable.number) or variable.size
        if _built(variable, NEAR * size) is not None:
            yield _Number(name, variable.unit, size, _other(variable))


def _other(variable: SearchVariable) -> Callable[[float], Problem | None]:
    return lambda more: _built(variable, more)


def _built(variable: SearchVariable, more: float) -> Problem | None:
    timeline, _ = variable.compiled(variable.number + more)
    if timeline is None:
        return None
    proofs = proofs_of(timeline, names_smallest=False)
    return inscribed(proofs.assembly.problem()) if proofs.assembly.bricks else None
