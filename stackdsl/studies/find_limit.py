"""`find`: the largest or least value of a number with which a scenario stands."""

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
from stability.notebook import Printed
from stability.problem import Motion, Problem, Stability
from stability.statics.assembly import Assembly
from stability.statics.fall_description import described
from stability.statics.round_borders import inscribed
from stackdsl.checking.cases import Case
from stackdsl.diagnostics import did_you_mean, meant_choice
from stackdsl.judging.numbers import ScenarioNumber, ScenarioNumbers
from stackdsl.judging.proofs import proofs_of
from stackdsl.judging.remedies import with_friction, with_mass
from stackdsl.language.expressions import constant, unit_text
from stackdsl.language.quantities import COEFFICIENT, MASS, InputError, in_si
from stackdsl.studies.large_motion import settled_in
from stackdsl.studies.limit_search import (
    EVERYWHERE,
    LARGE,
    Compiled,
    Range,
    SearchError,
    SearchResult,
    SearchStart,
    SearchTarget,
    TrialVerdict,
    Tried,
    VerdictCache,
    search,
    short_reason,
)
from stackdsl.timeline import Timeline, leaves_to_engine

# Numbers that can have a limit.
#
# A name is looked up first among the variables, then among the other numbers of the file (parameters of layouts, the
# tilt, positions of single bricks), then among the numbers that every scenario has (friction, the mass of a brick).


FRICTION: Final = "friction"
SHAKEN: Final = ("acceleration", "tilt")  # of the whole finished structure
BUILT_IN: Final = (FRICTION, *SHAKEN, "mass of BRICK", "settlement")
PLAYED: Final = "; statics ends before a throw, push or drop; vary its numbers with `matrix`"
USUAL: Final[Mapping[str, float]] = {"m": 0.01, "rad": 0.02, "kg": 0.01}  # size of the first steps from zero, in SI
GRAM: Final = 1e-3  # [kg]

_MASS: Final = re.compile(r"mass\s+of\s+(?P<brick>.+)")


@dataclass(frozen=True, slots=True)
class SearchVariable:
    """One number that can be varied."""

    name: str
    number: float  # as written, in its unit
    unit: str  # empty for a bare number
    compiled: Compiled
    domain: Range = EVERYWHERE
    is_whole: bool = False  # whether it is written as a whole number without a unit
    place: str = ""  # its position in the file; empty if it is not written there
    others: str = ""  # note on related numbers that stay fixed or change with it
    guess: Callable[[], float | None] = lambda: None

    @property
    def scale(self) -> float:
        """The value of one unit in SI."""
        return float(in_si(self.unit)) if self.unit else 1.0

    @property
    def size(self) -> float:
        """A typical size of such numbers, in its unit."""
        return USUAL.get(_si_unit(self.unit), 1.0) / self.scale

    def text(self, value: float, digits: int = 9) -> str:
        """Return a value as an author would write it."""
        return f"{value:.{digits}g} {self.unit}".rstrip()

    def start(self, whole: bool) -> SearchStart:
        """Return the start of a search."""
        return SearchStart(float(round(self.number)) if whole else self.number, self.size, whole)

    def value(self, written: str) -> float:
        """Return a written value in the unit of this number. Raises SearchError."""
        try:
            amount = constant(written)
        except InputError as mistake:
            raise SearchError(f"{mistake.message}; write, for example, {self.text(self.number, 4)}") from mistake
        if unit_text(amount) != _si_unit(self.unit) and amount.magnitude != 0:
            example = self.text(self.number, 4)
            raise SearchError(f"'{written}' has the wrong unit for '{self.name}'; write, for example, {example}")
        return float(amount.magnitude / in_si(self.unit)) if self.unit else float(amount.magnitude)


def _si_unit(unit: str) -> str:
    return unit_text(constant(f"1 {unit}")) if unit else ""


def search_variable_of(case: Case, name: str, wants_more: bool) -> SearchVariable:
    """Return the number of this name in a case; `wants_more` if the largest value is searched. Raises SearchError."""
    scenario_numbers = ScenarioNumbers(case.scenario, case.variant)
    if name in scenario_numbers.variables():
        return _variable(scenario_numbers, name)
    written = [number for number in _all(case, scenario_numbers) if number.name == name]
    if len(written) > 1:
        lines = ", ".join(str(number.span) for number in written)
        raise SearchError(f"'{name}' is written in {len(written)} places: {lines}; make it a variable of `let`")
    if written:
        return _of_number(scenario_numbers, written[0])
    if name == FRICTION:
        return _friction(case.timeline, wants_more)
    if match := _MASS.fullmatch(name):
        return _mass(case.timeline, match["brick"], wants_more)
    names = [*names_in(case), *BUILT_IN]
    played = any(map(leaves_to_engine, case.timeline.as_set_down().actions)) and not meant_choice(name, names)
    raise SearchError(f"unknown number '{name}'; {_instead(name, names)}{PLAYED * played}")


def is_shaken(case: Case, name: str) -> bool:
    """Return whether a name is the tilt or acceleration of the finished structure, rather than a number of the file."""
    return name in SHAKEN and name not in names_in(case)


def names_in(case: Case) -> tuple[str, ...]:
    """Return the names of the numbers of a case, each once: variables, then the others."""
    scenario_numbers = ScenarioNumbers(case.scenario, case.variant)
    names = [name for name in scenario_numbers.variables() if any(scenario_numbers.variable(name))]
    return tuple(dict.fromkeys([*names, *(number.name for number in _all(case, scenario_numbers))]))


def _instead(name: str, names: list[str]) -> str:
    return did_you_mean(name, names) or f"the numbers are {', '.join(names)}"


def _all(case: Case, scenario_numbers: ScenarioNumbers) -> Iterator[ScenarioNumber]:
    variables = scenario_numbers.variables()
    bricks = {each.brick.id for each in case.timeline.placements}
    return (number for number in scenario_numbers.numbers(bricks) if number.name not in variables)


# --- numbers of the file ----------------------------------------------------------------------------------------------


def _variable(scenario_numbers: ScenarioNumbers, name: str) -> SearchVariable:
    """Return a variable. Raises SearchError if it is no number, or a time."""
    number = next(scenario_numbers.variable(name), None)
    if number is None:
        value = scenario_numbers.variables()[name]
        if _is_of_time(value):
            why = "statics does not depend on times or speeds, so it has no limit; vary it with `matrix`"
            raise SearchError(f"'{name}' is {value}; {why}")
        raise SearchError(f"'{name}' is the word '{value}'; only a number has a limit")
    return _of_number(scenario_numbers, number)


def _is_of_time(value: object) -> bool:
    try:
        return "s" in re.findall("[A-Za-z]+", unit_text(constant(str(value))))
    except InputError:
        return False


def _of_number(scenario_numbers: ScenarioNumbers, number: ScenarioNumber) -> SearchVariable:
    exact = replace(number, whole=False)  # a number written as a whole one may be a coefficient
    return SearchVariable(
        number.name,
        number.number,
        number.unit,
        lambda value: scenario_numbers.compiled(number if value == int(value) else exact, value),
        _half_a_turn(number.unit) if _si_unit(number.unit) == "rad" else EVERYWHERE,
        is_whole=number.whole,
        place=str(number.span),
        others=_others_of(scenario_numbers, number),
    )


def _others_of(scenario_numbers: ScenarioNumbers, number: ScenarioNumber) -> str:
    """Return a note on numbers that are related to this one; empty if none are."""
    if "cases" in scenario_numbers.variant.written.values and number.name in _cases(scenario_numbers):
        others = [f"{name} = {value}" for name, value in _cases(scenario_numbers).items() if name != number.name]
        return f"other values of its case are unchanged: {', '.join(others)}" if others else ""
    is_computed = _is_computed(scenario_numbers, number)
    return "computed from other numbers in the file; set directly here" if is_computed else ""


def _half_a_turn(unit: str) -> Range:
    """Return the range of half a turn to either side."""
    return Range(-pi / float(in_si(unit)), pi / float(in_si(unit)))


def _cases(scenario_numbers: ScenarioNumbers) -> dict[str, object]:
    cases = scenario_numbers.variant.written.values.get("cases")
    first = cases[0] if isinstance(cases, list) and cases else {}
    names = list(first) if isinstance(first, dict) else []
    return {name: scenario_numbers.variant.choice[name] for name in names if name in scenario_numbers.variant.choice}


def _is_computed(scenario_numbers: ScenarioNumbers, number: ScenarioNumber) -> bool:
    lets = scenario_numbers.variant.written.values.get("let")
    written = lets.get(number.name) if isinstance(lets, dict) and number.path[0] == "let" else None
    return isinstance(written, str) and "${" in written


# --- numbers of every scenario ----------------------------------------------------------------------------------------


def _friction(timeline: Timeline, wants_more: bool) -> SearchVariable:
    """Return the friction between bricks; all other coefficients change in proportion."""
    world = timeline.world
    law = as_friction(world.friction)
    number = law.usual or world.roughest
    if not number:
        raise SearchError("all friction is 0 and cannot be scaled; write another number as `friction`")
    alike = not law.differs and all(plane.friction == number for plane in world.planes)

    def guess() -> float | None:
        if wants_more:
            return None
        margin = least_friction(inscribed(_judged(timeline).problem()), tolerance=1e-9)
        factor = 0.5 * (margin.factor + margin.too_little)
        return factor * number if isfinite(factor) else None

    return SearchVariable(
        FRICTION,
        number,
        "",
        lambda value: (with_friction(timeline, value / number), ()),
        Range(0.0, COEFFICIENT.most),
        others="" if alike else "all coefficients change in proportion",
        guess=guess,
    )


def _mass(timeline: Timeline, brick: str, wants_more: bool) -> SearchVariable:
    """Return the mass of a brick. Raises SearchError if there is no brick of this name."""
    masses = {each.brick.id: each.brick.mass for each in timeline.placements}
    if brick not in masses:
        raise SearchError(f"unknown brick '{brick}'; {did_you_mean(brick, list(masses))}".rstrip("; "))
    unit = "kg" if masses[brick] >= 1.0 else "g"
    scale = 1.0 if unit == "kg" else GRAM

    def guess() -> float | None:
        assembly = _judged(timeline)
        if wants_more or assembly.verdict().stability is not Stability.UNSTABLE or brick not in assembly.bricks:
            return None
        weight = counterweight(inscribed(assembly.problem()), brick)
        more = None if weight is None else 0.5 * (weight.weight + weight.too_little) / timeline.world.gravity
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


# The largest or the least number with which one case stands.
#
# Verdicts are those of `check --statics`: the build must stand at each step that statics can judge. Nothing is played,
# so a build is judged up to its first impact or the first action of a hand.


ACCURACY: Final = 1e-7  # relative distance between both sides of a limit
FINEST: Final = 1e-9  # accuracy of verdicts
SHAKEN_UNITS: Final = {"tilt": "deg", "acceleration": "g"}


class Want(StrEnum):
    """The limit that is searched for."""

    LARGEST = "largest"
    LEAST = "least"
    MOST = "most"  # the largest whole number


class End(StrEnum):
    """The kind of result of a search."""

    LIMIT = "limit"  # the case stands on one side, and falls on the other
    EDGE = "edge"  # it stands up to the last number with which the scenario is valid
    NONE = "no limit"  # it stands with all numbers tried on that side
    NOWHERE = "nowhere"  # it falls with all numbers tried
    OPEN = "undecided"  # it is proven to stand with no number tried, and some are undecided
    NO_EFFECT = "no effect"  # the build is the same with every number
    NOTHING = "nothing"  # statics cannot judge any brick


@dataclass(frozen=True, slots=True)
class FoundLimit(Printed):
    """The result of a search for the limit of one number of one case."""

    case: str
    want: Want
    name: str
    unit: str  # of all numbers here; empty for none
    written: float | None  # the number of the scenario; None if it has none
    end: End
    stands: float | None = None  # proven to stand; None if none is, inf if everything stands
    beyond: float | None = None  # proven to fall; at an edge, invalid; None if it stands to the end of the search
    scale: float = 1.0  # size of the unit in SI
    low: float = 0.0  # least number tried
    high: float = 0.0  # largest number tried
    why: str = ""  # mechanism of the fall beyond the limit, or the reason why there is no number beyond
    by_program: bool = False  # whether a conic program gave the limit, rather than bisection
    verdicts: int = 0  # number of verdicts
    is_open: bool = False  # whether numbers between the two sides are undecided
    contradicting: Sequence[tuple[float, str]] = ()  # numbers with another verdict than their side, and that verdict
    judged: int = 0  # number of judged bricks
    bricks: int = 0  # number of bricks
    place: str = ""  # position of the number in the file
    others: str = ""  # note on related numbers that stay fixed or change with it
    moment: float | None = None  # time of the placement at which it falls [s]

    @property
    def limit(self) -> float | None:
        """The last number proven to stand, in `unit`; None if no limit was found."""
        return self.stands if self.end is End.LIMIT else None


@dataclass(frozen=True, slots=True)
class LimitRequest:
    """The limit to search for."""

    want: Want
    name: str
    low: str = ""  # start of the range, as an author writes it; empty for the default
    high: str = ""  # end of the range
    accuracy: float = ACCURACY
    bearing: float | None = None  # downhill direction of a tilt or an acceleration [rad]; None for the worst


SETTLEMENT: Final = "settlement"


def find_in(
    case: Case, name: str, request: LimitRequest, on_trial: Callable[[int], None] = lambda _: None
) -> FoundLimit:
    """Search for a limit in a case called `name`. Raises SearchError.

    `on_trial` is called with the number of trials so far.
    """
    if request.want is not Want.MOST and is_shaken(case, request.name):
        return _shaken(case, name, request)
    if request.name == SETTLEMENT and case.timeline.world.supports and SETTLEMENT not in names_in(case):
        return _settled(case, name, request)
    if request.bearing is not None:
        raise SearchError("a bearing applies only to the tilt or acceleration of the finished structure; remove it")
    variable = search_variable_of(case, request.name, request.want is not Want.LEAST)
    within = _range(variable, request)
    built = len(case.timeline.placements)
    trials = VerdictCache(variable.compiled, inf if within.given else max(LARGE, 4 * built), on_trial)
    whole = _is_whole(variable, request, trials)
    guess = None if whole else variable.guess()
    result = search(
        trials, variable.start(whole), SearchTarget(request.want is not Want.LEAST, request.accuracy, within, guess)
    )
    _refuse_always_invalid(variable, trials)
    found = _found_limit(name, request, variable, result, trials)
    if found.end is End.NO_EFFECT and any(map(leaves_to_engine, case.timeline.as_set_down().actions)):
        raise SearchError(
            f"`{request.name}` changes nothing before the first action that needs an engine, and `find` judges no "
            f"more; to run several values, write `matrix: {{{request.name}: [1, 2, 3]}}` with the values of interest"
        )
    return found


def _refuse_always_invalid(variable: SearchVariable, trials: VerdictCache) -> None:
    if not trials.verdicts:
        first = next(iter(trials.tried.values()))
        raise SearchError(
            f"the scenario is invalid with every number tried; with {variable.text(first.value)}, {first.why}"
        )


def _range(variable: SearchVariable, request: LimitRequest) -> Range:
    low, high = (variable.value(text) if text else None for text in (request.low, request.high))
    least, most = variable.domain.low, variable.domain.high
    low, high = (least if low is None else max(low, least)), (most if high is None else min(high, most))
    if low >= high:
        raise SearchError(f"the range from {variable.text(low)} to {variable.text(high)} is empty")
    return Range(low, high, given=bool(request.low or request.high))


def _is_whole(variable: SearchVariable, request: LimitRequest, trials: VerdictCache) -> bool:
    """Return whether only whole numbers are tried: the number is written as a whole one, and fractions are invalid."""
    if request.want is Want.MOST:
        if not variable.is_whole:
            number = variable.text(variable.number)
            raise SearchError(f"'{variable.name}' is {number}, not a whole number; use --largest instead of --most")
        return True
    return variable.is_whole and trials(variable.number + 0.5).answer is TrialVerdict.NO_SCENARIO


# --- results ----------------------------------------------------------------------------------------------------------


def _found_limit(
    name: str, request: LimitRequest, variable: SearchVariable, result: SearchResult, trials: VerdictCache
) -> FoundLimit:
    stands, beyond = result.stands, result.beyond
    end = _end(result, trials)
    tried = sorted(value for value, each in trials.tried.items() if each.answer not in _NOT_TRIED)
    shown = stands or next(iter(trials.tried.values()))
    return FoundLimit(
        name,
        request.want,
        variable.name,
        variable.unit,
        variable.number,
        end,
        stands.value if stands is not None else None,
        beyond.value if beyond is not None and end in (End.LIMIT, End.EDGE) else None,
        variable.scale,
        tried[0] if tried else variable.number,
        tried[-1] if tried else variable.number,
        _why(end, beyond, trials),
        result.guessed,
        trials.verdicts,
        result.is_open,
        tuple((each.value, each.answer.value) for each in result.contradicting),
        shown.judged,
        shown.bricks,
        variable.place,
        variable.others,
        beyond.moment if beyond is not None and beyond.answer is TrialVerdict.FALLS else None,
    )


_NOT_TRIED: Final = (TrialVerdict.NO_SCENARIO, TrialVerdict.TOO_LARGE)


def _end(result: SearchResult, trials: VerdictCache) -> End:
    built = [each for each in trials.tried.values() if each.timeline is not None]
    if built and not any(each.judged for each in built):
        return End.NOTHING
    if result.beyond is not None and result.beyond.answer is TrialVerdict.FALLS:
        return End.LIMIT
    if len(built) > 1 and all(each.shape == built[0].shape for each in built):
        return End.NO_EFFECT
    if result.stands is None:
        is_open = any(each.answer is TrialVerdict.OPEN for each in built)
        return End.OPEN if is_open else End.NOWHERE
    return End.EDGE if result.beyond is not None and result.beyond.answer is not TrialVerdict.TOO_LARGE else End.NONE


def _why(end: End, beyond: Tried | None, trials: VerdictCache) -> str:
    if beyond is not None:
        return short_reason(beyond) if end is End.LIMIT else beyond.why
    if end in (End.NOWHERE, End.OPEN):
        answer = TrialVerdict.OPEN if end is End.OPEN else TrialVerdict.FALLS
        return next((short_reason(each) for each in trials.tried.values() if each.answer is answer), "")
    return ""


# --- tilt and acceleration of the finished structure ------------------------------------------------------------------


def _shaken(case: Case, name: str, request: LimitRequest) -> FoundLimit:
    """Return the limit of tilt or acceleration of the finished structure, proven by forces and by a motion."""
    if request.want is Want.LEAST:
        raise SearchError(f"the {request.name} of the finished structure has no least value; use --largest")
    if request.low or request.high:
        raise SearchError(
            f"the {request.name} of the finished structure is computed without a search; remove --from and --to"
        )
    proofs = proofs_of(case.timeline)
    assembly, unit = proofs.assembly, SHAKEN_UNITS[request.name]
    bricks = sum(not each.hits for each in case.timeline.placements)
    judged = sum(len(each.bricks) for each in proofs.judged)
    nothing = FoundLimit(name, request.want, request.name, unit, None, End.NOTHING, judged=judged, bricks=bricks)
    if not assembly.bricks:
        return nothing
    if assembly.verdict().stability is not Stability.STABLE:
        return FoundLimit(
            name,
            request.want,
            request.name,
            unit,
            None,
            End.NOWHERE,
            why=proofs.verdict.reason,
            bricks=bricks,
            verdicts=1,
        )
    if assembly.strengths:
        raise SearchError(f"the {request.name} of bricks with a `strength` is not searched for; vary another number")
    if request.name == "tilt" and assembly.ties:
        raise SearchError(
            "a tilt of tied bricks is not searched for; write `world: {tilt: ...}` with a variable, and vary it"
        )
    limit = _limit(assembly.problem(), request, assembly.gravity)
    if limit is None:
        return nothing
    stands, falls, motion = limit
    turned = (lambda share: degrees(atan(share))) if request.name == "tilt" else float
    return FoundLimit(
        name,
        request.want,
        request.name,
        unit,
        None,
        End.NONE if stands == inf else End.LIMIT,
        turned(stands),
        None if falls == inf else turned(falls),
        atan(1.0) / 45.0 if request.name == "tilt" else 1.0,
        high=turned(stands),
        why="" if motion is None else described(assembly.problem(), motion),
        by_program=True,
        verdicts=1,
        is_open=falls < inf
        and falls - stands > 1.01 * request.accuracy * falls,  # programs reach the accuracy except for rounding
        judged=judged,
        bricks=bricks,
    )


def _settled(case: Case, name: str, request: LimitRequest) -> FoundLimit:
    """Return the largest movement of the supports, in proportion to what is written."""
    if request.want is not Want.LARGEST or request.low or request.high or request.bearing is not None:
        raise SearchError("the settlement is followed from zero to the fall; use --largest settlement alone")
    followed = settled_in(case, name)
    motion = followed.motion
    if motion.ends:
        raise SearchError(
            f"the movement is followed to {followed.movement(motion.holds):.6g} {followed.unit}: {motion.ends}"
        )
    bricks = len(case.timeline.placements)
    end, stands = (End.NONE, motion.holds) if motion.falls == inf else (End.LIMIT, motion.holds)
    return FoundLimit(
        name,
        request.want,
        request.name,
        followed.unit,
        followed.scale,
        end,
        followed.movement(stands),
        None if motion.falls == inf else followed.movement(motion.falls),
        pi / 180.0 if followed.unit == "deg" else 1e-3,
        high=followed.movement(stands),
        why=followed.why,
        by_program=True,
        verdicts=len(motion.positions),
        judged=bricks,
        bricks=bricks,
    )


def _limit(problem: Problem, request: LimitRequest, gravity: float) -> tuple[float, float, Motion | None] | None:
    """Return the survived acceleration [g], the least proven to fail [g], and the motion of that fall."""
    if request.bearing is None:
        worst = acceleration(problem, request.accuracy, gravity)
        return None if worst is None else (worst.value, worst.upper, worst.motion)
    margins = along_bearings(problem, [request.bearing], request.accuracy, gravity)
    return None if margins is None else (margins[0].value, margins[0].upper, margins[0].motion)
