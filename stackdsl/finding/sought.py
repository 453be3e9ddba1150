"""What a limit may be asked of: a number of the file, the friction, or the mass of a brick.

A variable comes first, then what layouts are made of, the tilt and the places of single bricks, as they are written;
then what every scenario has, written or not.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import isfinite, pi
from typing import Final

from stability.friction_law import law_of
from stability.statics.assembly import Assembly
from stability.statics.facts import Stability
from stability.statics.margins.counterweight import counterweight
from stability.statics.margins.friction import least_friction
from stackdsl.checking.gathering import Case
from stackdsl.diagnostics import did_you_mean
from stackdsl.finding.asking import Compiled
from stackdsl.finding.search import EVERYWHERE, Range, Start
from stackdsl.judging.knobs import Knob, Knobs
from stackdsl.judging.proofs import proofs_of
from stackdsl.judging.remedies import with_friction, with_mass
from stackdsl.language.expressions import constant, unit_text
from stackdsl.language.mistakes import MistakeError
from stackdsl.language.quantities import COEFFICIENT, MASS, in_si
from stackdsl.timeline import Timeline

FRICTION: Final = "friction"
SHAKEN: Final = ("acceleration", "tilt")  # of the finished structure, as a whole
BUILT_IN: Final = (FRICTION, *SHAKEN, "mass of BRICK")
USUAL: Final[Mapping[str, float]] = {"m": 0.01, "rad": 0.02, "kg": 0.01}  # of numbers that are zero, in SI
GRAM: Final = 1e-3  # [kg]

_MASS: Final = re.compile(r"mass\s+of\s+(?P<brick>.+)")


class SoughtError(ValueError):
    """Nothing of this scenario is called so, or no limit can be asked of it."""


@dataclass(frozen=True, slots=True)
class Sought:
    """One number that may be otherwise."""

    name: str
    number: float  # as it is written, in its unit
    unit: str  # empty for a bare number
    compiled: Compiled
    domain: Range = EVERYWHERE
    is_whole: bool = False  # whether whole numbers are all that it may be, as far as its looks go
    place: str = ""  # where it is written; empty for what is not
    others: str = ""  # what stays as it is, or goes with it
    guess: Callable[[], float | None] = lambda: None

    @property
    def scale(self) -> float:
        """How many SI units one of its unit is."""
        return float(in_si(self.unit)) if self.unit else 1.0

    @property
    def size(self) -> float:
        """Of usual numbers of its kind, in its unit."""
        return USUAL.get(_si_unit(self.unit), 1.0) / self.scale

    def text(self, value: float, digits: int = 9) -> str:
        """A value as an author would write it."""
        return f"{value:.{digits}g} {self.unit}".rstrip()

    def start(self, whole: bool) -> Start:
        """Where a search begins."""
        return Start(float(round(self.number)) if whole else self.number, self.size, whole)

    def value(self, written: str) -> float:
        """What somebody wrote, in its unit. Raises SoughtError."""
        try:
            amount = constant(written)
        except MistakeError as mistake:
            raise SoughtError(f"{mistake.message}; write such as {self.text(self.number, 4)}") from mistake
        if unit_text(amount) != _si_unit(self.unit) and amount.magnitude != 0:
            raise SoughtError(f"'{written}' is no value of '{self.name}'; write such as {self.text(self.number, 4)}")
        return float(amount.magnitude / in_si(self.unit)) if self.unit else float(amount.magnitude)


def _si_unit(unit: str) -> str:
    return unit_text(constant(f"1 {unit}")) if unit else ""


def sought_of(case: Case, name: str, wants_more: bool) -> Sought:
    """What is called so in a case; `wants_more` is whether the largest is asked for. Raises SoughtError."""
    knobs = Knobs(case.scenario, case.variant)
    if name in knobs.variables():
        return _variable(knobs, name)
    written = [knob for knob in _all(case, knobs) if knob.name == name]
    if len(written) > 1:
        lines = ", ".join(str(knob.span) for knob in written)
        raise SoughtError(f"'{name}' is written in {len(written)} places: {lines}; make it a variable of `let`")
    if written:
        return _of_knob(knobs, written[0])
    if name == FRICTION:
        return _friction(case.timeline, wants_more)
    if match := _MASS.fullmatch(name):
        return _mass(case.timeline, match["brick"], wants_more)
    raise SoughtError(f"nothing is called '{name}'; {_instead(name, [*names_in(case), *BUILT_IN])}")


def is_shaken(case: Case, name: str) -> bool:
    """Whether what is asked for is how far the finished structure may be tilted, or accelerated."""
    return name in SHAKEN and name not in names_in(case)


def names_in(case: Case) -> tuple[str, ...]:
    """The numbers that are written in a case, each once: variables, then the others."""
    knobs = Knobs(case.scenario, case.variant)
    numbers = [name for name in knobs.variables() if any(knobs.variable(name))]
    return tuple(dict.fromkeys([*numbers, *(knob.name for knob in _all(case, knobs))]))


def _instead(name: str, names: list[str]) -> str:
    return did_you_mean(name, names) or f"there are {', '.join(names)}"


def _all(case: Case, knobs: Knobs) -> Iterator[Knob]:
    variables = knobs.variables()
    bricks = {each.brick.id for each in case.timeline.placements}
    return (knob for knob in knobs.found(bricks) if knob.name not in variables)


# --- numbers of the file ----------------------------------------------------------------------------------------------


def _variable(knobs: Knobs, name: str) -> Sought:
    """A variable. Raises SoughtError for one that is no number, or that only says when."""
    knob = next(knobs.variable(name), None)
    if knob is None:
        value = knobs.variables()[name]
        if _is_of_time(value):
            raise SoughtError(f"'{name}' is {value}: nothing stands or falls by when it comes, or how fast")
        raise SoughtError(f"'{name}' is the word '{value}', and a limit is asked of a number")
    return _of_knob(knobs, knob)


def _is_of_time(value: object) -> bool:
    try:
        return "s" in re.findall("[A-Za-z]+", unit_text(constant(str(value))))
    except MistakeError:
        return False


def _of_knob(knobs: Knobs, knob: Knob) -> Sought:
    exact = replace(knob, whole=False)  # a whole number that is written may be a coefficient
    return Sought(
        knob.name,
        knob.number,
        knob.unit,
        lambda value: knobs.compiled(knob if value == int(value) else exact, value),
        _half_a_turn(knob.unit) if _si_unit(knob.unit) == "rad" else EVERYWHERE,
        is_whole=knob.whole,
        place=str(knob.span),
        others=_others_of(knobs, knob),
    )


def _others_of(knobs: Knobs, knob: Knob) -> str:
    """What becomes of numbers that hang together with this one; empty if none do."""
    if "cases" in knobs.variant.written.values and knob.name in _cases(knobs):
        kept = [f"{name} = {value}" for name, value in _cases(knobs).items() if name != knob.name]
        return f"the rest of its case stays: {', '.join(kept)}" if kept else ""
    return "it is worked out from others there, and is set apart from them here" if _is_worked_out(knobs, knob) else ""


def _half_a_turn(unit: str) -> Range:
    """To either side: beyond, it is the same again."""
    return Range(-pi / float(in_si(unit)), pi / float(in_si(unit)))


def _cases(knobs: Knobs) -> dict[str, object]:
    cases = knobs.variant.written.values.get("cases")
    first = cases[0] if isinstance(cases, list) and cases else {}
    names = list(first) if isinstance(first, dict) else []
    return {name: knobs.variant.choice[name] for name in names if name in knobs.variant.choice}


def _is_worked_out(knobs: Knobs, knob: Knob) -> bool:
    lets = knobs.variant.written.values.get("let")
    written = lets.get(knob.name) if isinstance(lets, dict) and knob.path[0] == "let" else None
    return isinstance(written, str) and "${" in written


# --- what every scenario has ------------------------------------------------------------------------------------------


def _friction(timeline: Timeline, wants_more: bool) -> Sought:
    """Of brick on brick, with all other coefficients in proportion."""
    world = timeline.world
    law = law_of(world.friction)
    number = law.usual or world.roughest
    if not number:
        raise SoughtError("all friction is 0, so there is none to make more of; write another number as `friction`")
    alike = not law.differs and all(plane.friction == number for plane in world.planes)

    def guess() -> float | None:
        if wants_more:
            return None
        found = least_friction(_judged(timeline).problem(), tolerance=1e-9)
        factor = 0.5 * (found.factor + found.too_little)
        return factor * number if isfinite(factor) else None

    return Sought(
        FRICTION,
        number,
        "",
        lambda value: (with_friction(timeline, value / number), ()),
        Range(0.0, COEFFICIENT.most),
        others="" if alike else "all coefficients in proportion",
        guess=guess,
    )


def _mass(timeline: Timeline, brick: str, wants_more: bool) -> Sought:
    """Of one brick. Raises SoughtError if there is none of this name."""
    masses = {each.brick.id: each.brick.mass for each in timeline.placements}
    if brick not in masses:
        raise SoughtError(f"there is no brick '{brick}'; {did_you_mean(brick, list(masses))}".rstrip("; "))
    unit = "kg" if masses[brick] >= 1.0 else "g"
    scale = 1.0 if unit == "kg" else GRAM

    def guess() -> float | None:
        assembly = _judged(timeline)
        if wants_more or assembly.verdict().stability is not Stability.UNSTABLE or brick not in assembly.bricks:
            return None
        found = counterweight(assembly.problem(), brick)
        more = None if found is None else 0.5 * (found.weight + found.too_little) / timeline.world.gravity
        return None if more is None else (masses[brick] + more) / scale

    return Sought(
        f"mass of {brick}",
        masses[brick] / scale,
        unit,
        lambda value: (with_mass(timeline, brick, value * scale), ()),
        Range(1e-9 * masses[brick] / scale, MASS.most / scale),
        guess=guess,
    )


def _judged(timeline: Timeline) -> Assembly:
    return proofs_of(timeline, names_smallest=False).assembly
