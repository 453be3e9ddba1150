"""`find`: the greatest or least value of a number with which a scenario stands."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import atan, degrees, inf, isfinite, pi
from typing import Final

from stability.analysis.acceleration_margin import acceleration
from stability.analysis.bearings import along_bearings
from stability.analysis.margins import counterweight, least_friction
from stability.contact_law import as_friction
from stability.problem import Motion, Problem, Stability
from stability.statics.assembly import Assembly
from stability.statics.fall_description import described
from stackdsl.checking.cases import Case
from stackdsl.diagnostics import did_you_mean
from stackdsl.judging.numbers import ScenarioNumber, ScenarioNumbers
from stackdsl.judging.proofs import proofs_of
from stackdsl.judging.remedies import with_friction, with_mass
from stackdsl.language.expressions import constant, unit_text
from stackdsl.language.quantities import COEFFICIENT, MASS, MistakeError, in_si
from stackdsl.studies.limit_search import (
    EVERYWHERE,
    LARGE,
    Compiled,
    Range,
    SearchResult,
    SearchStart,
    SearchTarget,
    TrialVerdict,
    Tried,
    VerdictCache,
    search,
    told_shortly,
)
from stackdsl.timeline import Timeline

# What a limit may be asked of: a number of the file, the friction, or the mass of a brick.
#
# A variable comes first, then what layouts are made of, the tilt and the places of single bricks, as they are written;
# then what every scenario has, written or not.


FRICTION: Final = "friction"
SHAKEN: Final = ("acceleration", "tilt")  # of the finished structure, as a whole
BUILT_IN: Final = (FRICTION, *SHAKEN, "mass of BRICK")
USUAL: Final[Mapping[str, float]] = {"m": 0.01, "rad": 0.02, "kg": 0.01}  # of numbers that are zero, in SI
GRAM: Final = 1e-3  # [kg]

_MASS: Final = re.compile(r"mass\s+of\s+(?P<brick>.+)")


class SearchError(ValueError):
    """Nothing of this scenario is called so, or no limit can be asked of it."""


@dataclass(frozen=True, slots=True)
class SearchVariable:
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

    def start(self, whole: bool) -> SearchStart:
        """Where a search begins."""
        return SearchStart(float(round(self.number)) if whole else self.number, self.size, whole)

    def value(self, written: str) -> float:
        """What somebody wrote, in its unit. Raises SearchError."""
        try:
            amount = constant(written)
        except MistakeError as mistake:
            raise SearchError(f"{mistake.message}; write such as {self.text(self.number, 4)}") from mistake
        if unit_text(amount) != _si_unit(self.unit) and amount.magnitude != 0:
            raise SearchError(f"'{written}' is no value of '{self.name}'; write such as {self.text(self.number, 4)}")
        return float(amount.magnitude / in_si(self.unit)) if self.unit else float(amount.magnitude)


def _si_unit(unit: str) -> str:
    return unit_text(constant(f"1 {unit}")) if unit else ""


def search_variable_of(case: Case, name: str, wants_more: bool) -> SearchVariable:
    """What is called so in a case; `wants_more` is whether the largest is asked for. Raises SearchError."""
    knobs = ScenarioNumbers(case.scenario, case.variant)
    if name in knobs.variables():
        return _variable(knobs, name)
    written = [knob for knob in _all(case, knobs) if knob.name == name]
    if len(written) > 1:
        lines = ", ".join(str(knob.span) for knob in written)
        raise SearchError(f"'{name}' is written in {len(written)} places: {lines}; make it a variable of `let`")
    if written:
        return _of_knob(knobs, written[0])
    if name == FRICTION:
        return _friction(case.timeline, wants_more)
    if match := _MASS.fullmatch(name):
        return _mass(case.timeline, match["brick"], wants_more)
    raise SearchError(f"nothing is called '{name}'; {_instead(name, [*names_in(case), *BUILT_IN])}")


def is_shaken(case: Case, name: str) -> bool:
    """Whether what is asked for is how far the finished structure may be tilted, or accelerated."""
    return name in SHAKEN and name not in names_in(case)


def names_in(case: Case) -> tuple[str, ...]:
    """The numbers that are written in a case, each once: variables, then the others."""
    knobs = ScenarioNumbers(case.scenario, case.variant)
    numbers = [name for name in knobs.variables() if any(knobs.variable(name))]
    return tuple(dict.fromkeys([*numbers, *(knob.name for knob in _all(case, knobs))]))


def _instead(name: str, names: list[str]) -> str:
    return did_you_mean(name, names) or f"there are {', '.join(names)}"


def _all(case: Case, knobs: ScenarioNumbers) -> Iterator[ScenarioNumber]:
    variables = knobs.variables()
    bricks = {each.brick.id for each in case.timeline.placements}
    return (knob for knob in knobs.found(bricks) if knob.name not in variables)


# --- numbers of the file ----------------------------------------------------------------------------------------------


def _variable(knobs: ScenarioNumbers, name: str) -> SearchVariable:
    """A variable. Raises SearchError for one that is no number, or that only says when."""
    knob = next(knobs.variable(name), None)
    if knob is None:
        value = knobs.variables()[name]
        if _is_of_time(value):
            raise SearchError(f"'{name}' is {value}: nothing stands or falls by when it comes, or how fast")
        raise SearchError(f"'{name}' is the word '{value}', and a limit is asked of a number")
    return _of_knob(knobs, knob)


def _is_of_time(value: object) -> bool:
    try:
        return "s" in re.findall("[A-Za-z]+", unit_text(constant(str(value))))
    except MistakeError:
        return False


def _of_knob(knobs: ScenarioNumbers, knob: ScenarioNumber) -> SearchVariable:
    exact = replace(knob, whole=False)  # a whole number that is written may be a coefficient
    return SearchVariable(
        knob.name,
        knob.number,
        knob.unit,
        lambda value: knobs.compiled(knob if value == int(value) else exact, value),
        _half_a_turn(knob.unit) if _si_unit(knob.unit) == "rad" else EVERYWHERE,
        is_whole=knob.whole,
        place=str(knob.span),
        others=_others_of(knobs, knob),
    )


def _others_of(knobs: ScenarioNumbers, knob: ScenarioNumber) -> str:
    """What becomes of numbers that hang together with this one; empty if none do."""
    if "cases" in knobs.variant.written.values and knob.name in _cases(knobs):
        kept = [f"{name} = {value}" for name, value in _cases(knobs).items() if name != knob.name]
        return f"the rest of its case stays: {', '.join(kept)}" if kept else ""
    return "it is worked out from others there, and is set apart from them here" if _is_worked_out(knobs, knob) else ""


def _half_a_turn(unit: str) -> Range:
    """To either side: beyond, it is the same again."""
    return Range(-pi / float(in_si(unit)), pi / float(in_si(unit)))


def _cases(knobs: ScenarioNumbers) -> dict[str, object]:
    cases = knobs.variant.written.values.get("cases")
    first = cases[0] if isinstance(cases, list) and cases else {}
    names = list(first) if isinstance(first, dict) else []
    return {name: knobs.variant.choice[name] for name in names if name in knobs.variant.choice}


def _is_worked_out(knobs: ScenarioNumbers, knob: ScenarioNumber) -> bool:
    lets = knobs.variant.written.values.get("let")
    written = lets.get(knob.name) if isinstance(lets, dict) and knob.path[0] == "let" else None
    return isinstance(written, str) and "${" in written


# --- what every scenario has ------------------------------------------------------------------------------------------


def _friction(timeline: Timeline, wants_more: bool) -> SearchVariable:
    """Of brick on brick, with all other coefficients in proportion."""
    world = timeline.world
    law = as_friction(world.friction)
    number = law.usual or world.roughest
    if not number:
        raise SearchError("all friction is 0, so there is none to make more of; write another number as `friction`")
    alike = not law.differs and all(plane.friction == number for plane in world.planes)

    def guess() -> float | None:
        if wants_more:
            return None
        found = least_friction(_judged(timeline).problem(), tolerance=1e-9)
        factor = 0.5 * (found.factor + found.too_little)
        return factor * number if isfinite(factor) else None

    return SearchVariable(
        FRICTION,
        number,
        "",
        lambda value: (with_friction(timeline, value / number), ()),
        Range(0.0, COEFFICIENT.most),
        others="" if alike else "all coefficients in proportion",
        guess=guess,
    )


def _mass(timeline: Timeline, brick: str, wants_more: bool) -> SearchVariable:
    """Of one brick. Raises SearchError if there is none of this name."""
    masses = {each.brick.id: each.brick.mass for each in timeline.placements}
    if brick not in masses:
        raise SearchError(f"there is no brick '{brick}'; {did_you_mean(brick, list(masses))}".rstrip("; "))
    unit = "kg" if masses[brick] >= 1.0 else "g"
    scale = 1.0 if unit == "kg" else GRAM

    def guess() -> float | None:
        assembly = _judged(timeline)
        if wants_more or assembly.verdict().stability is not Stability.UNSTABLE or brick not in assembly.bricks:
            return None
        found = counterweight(assembly.problem(), brick)
        more = None if found is None else 0.5 * (found.weight + found.too_little) / timeline.world.gravity
        return None if more is None else (masses[brick] + more) / scale

    return SearchVariable(
        f"mass of {brick}",
        masses[brick] / scale,
        unit,
        lambda value: (with_mass(timeline, brick, value * scale), ()),
        Range(1e-9 * masses[brick] / scale, MASS.most / scale),
        guess=guess,
    )


def _judged(timeline: Timeline) -> Assembly:
    return proofs_of(timeline, names_smallest=False).assembly


# The largest or the least number with which a scenario stands, of one case.
#
# What is asked is what `check --statics` asks: whether the build stands at each of its steps, as far as statics can
# judge. Nothing is played, so what something hits, or a hand holds, is judged up to that moment.


ACCURACY: Final = 1e-7  # how far the sides of a limit may be apart, relative to it
FINEST: Final = 1e-9  # what verdicts are sure of
SHAKEN_UNITS: Final = {"tilt": "deg", "acceleration": "g"}


class Want(StrEnum):
    """Which number is asked for."""

    LARGEST = "largest"
    LEAST = "least"
    MOST = "most"  # the largest whole number


class End(StrEnum):
    """What a limit was found to be, or why there is none."""

    LIMIT = "limit"  # it stands on one side, and falls on the other
    EDGE = "edge"  # it stands up to the last number with which it is a scenario
    NONE = "no limit"  # it stands with all that were tried on that side
    NOWHERE = "nowhere"  # it falls with all that were tried
    OPEN = "undecided"  # it is proven to stand with none that was tried, and some are undecided
    NO_EFFECT = "no effect"  # the same is built with every number
    NOTHING = "nothing"  # there is nothing that statics can judge


@dataclass(frozen=True, slots=True)
class FoundLimit:
    """What was found of one number of one case."""

    case: str
    want: Want
    name: str
    unit: str  # of all numbers here; empty for none
    written: float | None  # the number of the scenario; None where it has none
    end: End
    stands: float | None = None  # proven to stand; None if none is, inf if everything stands
    beyond: float | None = None  # proven to fall; at an edge, no scenario; None if it stands to the end of the search
    scale: float = 1.0  # SI units in one of the unit
    low: float = 0.0  # the least and the largest number that were tried
    high: float = 0.0
    why: str = ""  # what gives way beyond the limit, and how; or why no number is beyond
    by_program: bool = False  # whether a conic program told where, rather than halving
    verdicts: int = 0  # of statics that were asked
    is_open: bool = False  # whether numbers between the two sides could not be judged
    contradicting: Sequence[tuple[float, str]] = ()  # numbers with which it is other than on their side, and how
    judged: int = 0  # bricks that statics judged
    bricks: int = 0  # bricks that are built
    place: str = ""  # where the number is written
    others: str = ""  # what stays as it is, or goes with it
    moment: float | None = None  # when that is set down with which it falls [s]


@dataclass(frozen=True, slots=True)
class Wish:
    """What is asked for."""

    want: Want
    name: str
    low: str = ""  # as an author writes it; empty: as far as is searched
    high: str = ""
    accuracy: float = ACCURACY
    bearing: float | None = None  # downhill [rad], of a tilt or an acceleration; None: the worst


def find_in(case: Case, name: str, wish: Wish, told: Callable[[int], None] = lambda _: None) -> FoundLimit:
    """The limit of one case that is called `name`; `told` hears how many numbers were tried. Raises SearchError."""
    if wish.want is not Want.MOST and is_shaken(case, wish.name):
        return _shaken(case, name, wish)
    if wish.bearing is not None:
        raise SearchError("a bearing is asked of the tilt or the acceleration of what is finished")
    sought = search_variable_of(case, wish.name, wish.want is not Want.LEAST)
    within = _range(sought, wish)
    built = len(case.timeline.placements)
    asking = VerdictCache(sought.compiled, inf if within.given else max(LARGE, 4 * built), told)
    whole = _is_whole(sought, wish, asking)
    guess = None if whole else sought.guess()
    found = search(asking, sought.start(whole), SearchTarget(wish.want is not Want.LEAST, wish.accuracy, within, guess))
    _refuse_what_was_never_a_scenario(sought, asking)
    return _finding(name, wish, sought, found, asking)


def _refuse_what_was_never_a_scenario(sought: SearchVariable, asking: VerdictCache) -> None:
    if not asking.verdicts:
        first = next(iter(asking.tried.values()))
        why = f"with {sought.text(first.value)}, {first.why}"
        raise SearchError(f"it is no scenario with any number that was tried; {why}")


def _range(sought: SearchVariable, wish: Wish) -> Range:
    low, high = (sought.value(text) if text else None for text in (wish.low, wish.high))
    least, most = sought.domain.low, sought.domain.high
    low, high = (least if low is None else max(low, least)), (most if high is None else min(high, most))
    if low >= high:
        raise SearchError(f"from {sought.text(low)} to {sought.text(high)} there is nothing to search")
    return Range(low, high, given=bool(wish.low or wish.high))


def _is_whole(sought: SearchVariable, wish: Wish, asking: VerdictCache) -> bool:
    """Whether whole numbers are tried: those that look whole, and can be nothing else."""
    if wish.want is Want.MOST:
        if not sought.is_whole:
            raise SearchError(f"'{sought.name}' is {sought.text(sought.number)}: ask for the --largest, not the --most")
        return True
    return sought.is_whole and asking(sought.number + 0.5).answer is TrialVerdict.NO_SCENARIO


# --- what came of it --------------------------------------------------------------------------------------------------


def _finding(name: str, wish: Wish, sought: SearchVariable, found: SearchResult, asking: VerdictCache) -> FoundLimit:
    stands, beyond = found.stands, found.beyond
    end = _end(found, asking)
    tried = sorted(value for value, each in asking.tried.items() if each.answer not in _NOT_TRIED)
    shown = stands or next(iter(asking.tried.values()))
    return FoundLimit(
        name,
        wish.want,
        sought.name,
        sought.unit,
        sought.number,
        end,
        stands.value if stands is not None else None,
        beyond.value if beyond is not None and end in (End.LIMIT, End.EDGE) else None,
        sought.scale,
        tried[0] if tried else sought.number,
        tried[-1] if tried else sought.number,
        _why(end, beyond, asking),
        found.guessed,
        asking.verdicts,
        found.is_open,
        tuple((each.value, each.answer.value) for each in found.contradicting),
        shown.judged,
        shown.bricks,
        sought.place,
        sought.others,
        beyond.moment if beyond is not None and beyond.answer is TrialVerdict.FALLS else None,
    )


_NOT_TRIED: Final = (TrialVerdict.NO_SCENARIO, TrialVerdict.TOO_LARGE)


def _end(found: SearchResult, asking: VerdictCache) -> End:
    built = [each for each in asking.tried.values() if each.timeline is not None]
    if built and not any(each.judged for each in built):
        return End.NOTHING
    if found.beyond is not None and found.beyond.answer is TrialVerdict.FALLS:
        return End.LIMIT
    if len(built) > 1 and all(each.shape == built[0].shape for each in built):
        return End.NO_EFFECT
    if found.stands is None:
        is_open = any(each.answer is TrialVerdict.OPEN for each in built)
        return End.OPEN if is_open else End.NOWHERE
    return End.EDGE if found.beyond is not None and found.beyond.answer is not TrialVerdict.TOO_LARGE else End.NONE


def _why(end: End, beyond: Tried | None, asking: VerdictCache) -> str:
    if beyond is not None:
        return told_shortly(beyond) if end is End.LIMIT else beyond.why
    if end in (End.NOWHERE, End.OPEN):
        answer = TrialVerdict.OPEN if end is End.OPEN else TrialVerdict.FALLS
        return next((told_shortly(each) for each in asking.tried.values() if each.answer is answer), "")
    return ""


# --- what is finished, as a whole -------------------------------------------------------------------------------------


def _shaken(case: Case, name: str, wish: Wish) -> FoundLimit:
    """How far the finished structure may be tilted, or accelerated: forces prove it, and a motion that no more."""
    if wish.want is Want.LEAST:
        raise SearchError(f"what is finished stands from no {wish.name} on: ask for the --largest")
    if wish.low or wish.high:
        raise SearchError(f"a program tells the {wish.name} of what is finished: leave out --from and --to")
    proofs = proofs_of(case.timeline)
    assembly, unit = proofs.assembly, SHAKEN_UNITS[wish.name]
    bricks = sum(not each.hits for each in case.timeline.placements)
    judged = sum(len(each.bricks) for each in proofs.judged)
    nothing = FoundLimit(name, wish.want, wish.name, unit, None, End.NOTHING, judged=judged, bricks=bricks)
    if not assembly.bricks:
        return nothing
    if assembly.verdict().stability is not Stability.STABLE:
        return FoundLimit(
            name,
            wish.want,
            wish.name,
            unit,
            None,
            End.NOWHERE,
            why=proofs.verdict.reason,
            bricks=bricks,
            verdicts=1,
        )
    limit = _limit(assembly.problem(), wish, assembly.gravity)
    if limit is None:
        return nothing
    stands, falls, motion = limit
    turned = (lambda share: degrees(atan(share))) if wish.name == "tilt" else float
    return FoundLimit(
        name,
        wish.want,
        wish.name,
        unit,
        None,
        End.NONE if stands == inf else End.LIMIT,
        turned(stands),
        None if falls == inf else turned(falls),
        atan(1.0) / 45.0 if wish.name == "tilt" else 1.0,
        high=turned(stands),
        why="" if motion is None else described(assembly.problem(), motion),
        by_program=True,
        verdicts=1,
        is_open=falls < inf
        and falls - stands > 1.01 * wish.accuracy * falls,  # as programs keep to it, but for rounding
        judged=judged,
        bricks=bricks,
    )


def _limit(problem: Problem, wish: Wish, gravity: float) -> tuple[float, float, Motion | None] | None:
    """What is survived, what is not, and how it then moves [g]."""
    if wish.bearing is None:
        worst = acceleration(problem, wish.accuracy, gravity)
        return None if worst is None else (worst.value, worst.upper, worst.motion)
    found = along_bearings(problem, [wish.bearing], wish.accuracy, gravity)
    return None if found is None else (found[0].value, found[0].upper, found[0].motion)
