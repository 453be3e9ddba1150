"""What was measured over the variables of a scenario: which variables those are, and which one quantity.

Measured is at which level it collapsed, where all cases do; else how far a claim is from its threshold: above zero it
passed, and where a line crosses zero the answer flips. A claim may count millimetres of what stands and bricks of what
fell: then those in the unit of most are measured, and the others only passed or failed.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isfinite

from stackdsl.language.quantities import SIGNED, UNIT, in_si, unit_amount
from stackdsl.outcome import VariantResult

FEWEST = 3  # values of a variable that are worth a line
WRITTEN = re.compile(rf"(?P<number>{SIGNED})\s*(?P<unit>{UNIT})?")


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable that runs through numbers."""

    name: str
    unit: str  # as it was written first
    values: Mapping[str, float]  # in that unit, by what was written; from the least to the largest

    @property
    def title(self) -> str:
        """For an axis."""
        return f"{self.name}, {self.unit}" if self.unit else self.name


@dataclass(frozen=True, slots=True)
class Point:
    """What was measured of one case."""

    at: tuple[str, ...]  # the values of the variables, as written
    value: float | None  # in the one unit; None where it was measured in another
    passed: bool
    told: str  # all of it, in words


@dataclass(frozen=True, slots=True)
class Study:
    """One quantity over one variable, or over two."""

    scenario: str
    quantity: str
    unit: str
    variables: tuple[Variable, ...]
    series: Mapping[str, Sequence[Point]]  # by system, and by what else differs

    @property
    def title(self) -> str:
        """For an axis."""
        return f"{self.quantity}, {self.unit}" if self.unit else self.quantity


@dataclass(frozen=True, slots=True)
class _Measured:
    """One quantity of some cases."""

    name: str
    unit: str
    claim: int | None  # which of the claims; None for the level of collapse

    def of(self, run: VariantResult) -> float | None:
        if self.claim is None:
            return float(run.collapse.level) if run.collapse is not None else None
        outcome = run.outcomes[self.claim]
        return outcome.margin if outcome.unit == self.unit and isfinite(outcome.margin) else None

    def passed(self, run: VariantResult) -> bool:
        return run.met == len(run.outcomes) if self.claim is None else run.outcomes[self.claim].passed


def studies(results: Iterable[VariantResult]) -> Iterator[Study]:
    """One for each scenario that runs through numbers and claims something that can be measured."""
    by_scenario: defaultdict[str, list[VariantResult]] = defaultdict(list)
    for result in results:
        if result.outcomes and result.parameters:
            by_scenario[result.scenario].append(result)
    for scenario, runs in by_scenario.items():
        variables = _worth_drawing(_variables(runs))
        measured = _measured(runs)
        if variables and measured is not None:
            yield Study(scenario, measured.name, measured.unit, variables, _series(runs, variables, measured))


def _worth_drawing(found: Sequence[Variable]) -> tuple[Variable, ...]:
    """The two with the most values, or the one, if it has enough for a line."""
    most = sorted(found, key=lambda variable: -len(variable.values))[:2]
    return tuple(most) if len(most) > 1 or any(len(variable.values) >= FEWEST for variable in most) else ()


def _variables(runs: Sequence[VariantResult]) -> list[Variable]:
    """The variables that have several values, all of them numbers of one kind."""
    written: defaultdict[str, dict[str, None]] = defaultdict(dict)
    for run in runs:
        for name, text in run.parameters:
            written[name][text] = None
    found = (_variable(name, texts) for name, texts in written.items() if len(texts) > 1)
    return [variable for variable in found if variable is not None]


def _variable(name: str, texts: Iterable[str]) -> Variable | None:
    matches = {text: WRITTEN.fullmatch(text) for text in texts}
    units = [match["unit"] or "" for match in matches.values() if match]
    if len(units) < len(matches) or not _are_of_one_kind(set(units)):
        return None
    numbers = {
        text: float(Fraction(match["number"]) * in_si(match["unit"] or "") / in_si(units[0]))
        for text, match in matches.items()
        if match
    }
    return Variable(name, units[0], dict(sorted(numbers.items(), key=lambda item: item[1])))


def _are_of_one_kind(units: set[str]) -> bool:
    return len(units) == 1 or len({str(unit_amount(unit).dimensionality) for unit in units}) == 1


def _measured(runs: Sequence[VariantResult]) -> _Measured | None:
    """The level of collapse, or the first of the claims that is told in one unit in the most cases."""
    if all(run.collapse is not None for run in runs):
        return _Measured("level of collapse", "", None)
    found = []
    for claim in range(min(len(run.outcomes) for run in runs)):
        outcomes = [run.outcomes[claim] for run in runs if isfinite(run.outcomes[claim].margin)]
        for unit, count in Counter(outcome.unit for outcome in outcomes).most_common(1):
            found.append((-count, claim, unit))
    if not found:
        return None
    _, claim, unit = min(found)
    return _Measured(f"margin of {runs[0].outcomes[claim].name}", unit, claim)


def _series(
    runs: Sequence[VariantResult], variables: Sequence[Variable], measured: _Measured
) -> Mapping[str, Sequence[Point]]:
    names = [variable.name for variable in variables]
    others = {name for run in runs for name, _ in run.parameters if name not in names}
    differing = {name for name in others if len({dict(run.parameters).get(name) for run in runs}) > 1}
    series: defaultdict[str, list[Point]] = defaultdict(list)
    for run in runs:
        chosen = dict(run.parameters)
        if not chosen.keys() >= {*names}:
            continue
        name = ", ".join([run.system, *(f"{key} {text}" for key, text in chosen.items() if key in differing)])
        at = tuple(chosen[key] for key in names)
        series[name].append(Point(at, measured.of(run), measured.passed(run), _told(run, measured)))
    return series


def _told(run: VariantResult, measured: _Measured) -> str:
    if measured.claim is None:
        return run.name
    outcome = run.outcomes[measured.claim]
    return f"{run.name}: {outcome.measured}, margin {outcome.margin:.3g} {outcome.unit}".rstrip()
