"""Charts of measured quantities over the variables of scenarios."""

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from html import escape
from math import isfinite

from stackdsl.language.quantities import SIGNED, UNIT, in_si, unit_amount
from stackdsl.report.text import margin_text
from stackdsl.results import VariantResult
from stackdsl.viewing.plots import Axis
from stackdsl.wording import how_many, significant

# A measured quantity over the variables of a scenario.
#
# If all cases collapse, the quantity is the level of collapse. Otherwise it is the margin of a claim: above zero it
# passes, and the result changes where a line crosses zero. The unit of a margin may differ between cases, such as
# millimetres for standing and bricks for fallen ones: the most frequent unit is drawn; other cases only pass or fail.


FEWEST = 3  # values of a variable to draw a line
WRITTEN = re.compile(rf"(?P<number>{SIGNED})\s*(?P<unit>{UNIT})?")


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable with several numbers."""

    name: str
    unit: str  # of the first value
    values: Mapping[str, float]  # in that unit, by written value; in increasing order

    @property
    def title(self) -> str:
        """The label of its axis."""
        return f"{self.name}, {self.unit}" if self.unit else self.name


@dataclass(frozen=True, slots=True)
class ChartPoint:
    """The measurement of one case."""

    at: tuple[str, ...]  # values of the variables, as written
    value: float | None  # in the unit of the chart; None if it was measured in another unit
    passed: bool
    text: str  # the measurement in words


@dataclass(frozen=True, slots=True)
class Study:
    """One quantity over one or two variables."""

    scenario: str
    quantity: str
    unit: str
    variables: tuple[Variable, ...]
    series: Mapping[str, Sequence[ChartPoint]]  # by system and other differing variables

    @property
    def title(self) -> str:
        """The label of its axis."""
        return f"{self.quantity}, {self.unit}" if self.unit else self.quantity


@dataclass(frozen=True, slots=True)
class _Measured:
    """One measured quantity."""

    name: str
    unit: str
    claim: int | None  # number of the claim; None for the level of collapse
    left: bool = False  # whether it is what is left of the shift or tilt of a fall, and not a safety margin

    def of(self, run: VariantResult) -> float | None:
        if self.claim is None:
            return float(run.collapse.level) if run.collapse is not None else None
        outcome = run.outcomes[self.claim]
        alike = outcome.unit == self.unit and bool(outcome.moved) is self.left
        return outcome.margin if alike and isfinite(outcome.margin) else None

    def passed(self, run: VariantResult) -> bool:
        return run.met == len(run.outcomes) if self.claim is None else run.outcomes[self.claim].passed


def studies(results: Iterable[VariantResult]) -> Iterator[Study]:
    """Yield a study for each scenario with numeric variables and a measurable claim."""
    by_scenario: defaultdict[str, list[VariantResult]] = defaultdict(list)
    for result in results:
        if result.outcomes and result.parameters:
            by_scenario[result.scenario].append(result)
    for scenario, runs in by_scenario.items():
        variables = _worth_drawing(_variables(runs))
        measured = _measured(runs)
        if variables and measured is not None:
            yield Study(scenario, measured.name, measured.unit, variables, _series(runs, variables, measured))


def _worth_drawing(variables: Sequence[Variable]) -> tuple[Variable, ...]:
    """Return the two variables with the most values, or the only one if it has enough values for a line."""
    most = sorted(variables, key=lambda variable: -len(variable.values))[:2]
    return tuple(most) if len(most) > 1 or any(len(variable.values) >= FEWEST for variable in most) else ()


def _variables(runs: Sequence[VariantResult]) -> list[Variable]:
    """Return the variables with several values that are all numbers of one dimension."""
    written: defaultdict[str, dict[str, None]] = defaultdict(dict)
    for run in runs:
        for name, text in run.parameters:
            written[name][text] = None
    variables = (_variable(name, texts) for name, texts in written.items() if len(texts) > 1)
    return [variable for variable in variables if variable is not None]


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
    """Return the level of collapse, or the first claim that has a margin in one unit for the most cases."""
    if all(run.collapse is not None for run in runs):
        return _Measured("level of collapse", "", None)
    candidates = []
    for claim in range(min(len(run.outcomes) for run in runs)):
        outcomes = [run.outcomes[claim] for run in runs if isfinite(run.outcomes[claim].margin)]
        for (unit, left), count in Counter((each.unit, bool(each.moved)) for each in outcomes).most_common(1):
            candidates.append((-count, claim, unit, left))
    if not candidates:
        return None
    _, claim, unit, left = min(candidates)
    quantity = f"{'tilt' if unit == 'deg' else 'shift'} left until a fall" if left else "margin"
    return _Measured(f"{quantity} of {runs[0].outcomes[claim].name}", unit, claim, left)


def _series(
    runs: Sequence[VariantResult], variables: Sequence[Variable], measured: _Measured
) -> Mapping[str, Sequence[ChartPoint]]:
    names = [variable.name for variable in variables]
    others = {name for run in runs for name, _ in run.parameters if name not in names}
    differing = {name for name in others if len({dict(run.parameters).get(name) for run in runs}) > 1}
    series: defaultdict[str, list[ChartPoint]] = defaultdict(list)
    for run in runs:
        chosen = dict(run.parameters)
        if not chosen.keys() >= {*names}:
            continue
        name = ", ".join([run.system, *(f"{key} {text}" for key, text in chosen.items() if key in differing)])
        at = tuple(chosen[key] for key in names)
        series[name].append(ChartPoint(at, measured.of(run), measured.passed(run), _text(run, measured)))
    return series


def _text(run: VariantResult, measured: _Measured) -> str:
    if measured.claim is None:
        return run.name
    outcome = run.outcomes[measured.claim]
    return f"{run.name}: {outcome.measured}{margin_text(outcome)}"


# One quantity over one variable as a line: axes with units, and a cross for a case without a number in that unit.


WIDE, HIGH = 520.0, 250.0  # [px]
LEFT, RIGHT, TOP, BOTTOM = 52.0, 508.0, 22.0, 210.0  # [px] of the plot area, inside the labels
COLOURS = ("#1a6fb8", "#b5661b", "#0f8f72", "#9a5fb8", "#77787a")
MARK = 4.0  # [px] half the size of a mark


def line_chart(study: Study) -> str:
    """Return a line chart as HTML."""
    variable = study.variables[0]
    points = [point for of_series in study.series.values() for point in of_series]
    measured = [0.0, *(point.value for point in points if point.value is not None)]
    across = Axis(min(variable.values.values()), max(variable.values.values()), LEFT, RIGHT)
    frame = _Frame(variable, across, Axis(min(measured), max(measured), BOTTOM, TOP))
    named = list(zip(study.series.items(), COLOURS * len(study.series), strict=False))
    shapes = [*frame.drawn(study.title)]
    for (name, of_series), colour in named:
        shapes += _Series(frame, name, colour).drawn(of_series)
    keys = "".join(_key(name, colour) for (name, _), colour in named)
    others = sum(point.value is None for point in points)
    about = f"{study.scenario}: {study.quantity} over {variable.name}"
    about += (
        f"; {how_many(others, 'case')} without a value in {study.unit or 'this unit'}: crosses failed, ticks passed"
        if others
        else ""
    )
    svg = f'<svg viewBox="0 0 {WIDE:.0f} {HIGH:.0f}" width="{WIDE:.0f}" role="img">{"".join(shapes)}</svg>'
    return f"<figure><figcaption>{escape(about)}</figcaption>{svg}{keys}</figure>"


def _key(name: str, colour: str) -> str:
    line = f'<svg width="14" height="10"><path d="M0 5H14" stroke="{colour}" stroke-width="3"/></svg>'
    return f'<span class="key">{line} {escape(name)}</span>'


@dataclass(frozen=True, slots=True)
class _Frame:
    """The axes."""

    variable: Variable
    across: Axis
    up: Axis

    def drawn(self, title: str) -> Iterator[str]:
        """Yield grid lines, numbers and units, and the region beyond the limit."""
        limit = self.up.place(0.0)
        if limit < BOTTOM:
            size = f'width="{RIGHT - LEFT:.0f}" height="{BOTTOM - limit:.1f}"'
            yield f'<rect class="beyond" x="{LEFT:.0f}" y="{limit:.1f}" {size}/>'
        for value in self.across.ticks():
            x = self.across.place(value)
            yield f'<path class="grid" d="M{x:.1f} {TOP:.0f}V{BOTTOM:.0f}"/>'
            yield f'<text x="{x:.1f}" y="{BOTTOM + 14:.0f}" text-anchor="middle">{significant(value)}</text>'
        for value in self.up.ticks():
            y = self.up.place(value)
            yield f'<path class="{"grid" if value else "zero"}" d="M{LEFT:.0f} {y:.1f}H{RIGHT:.0f}"/>'
            yield f'<text x="{LEFT - 6:.0f}" y="{y + 4:.1f}" text-anchor="end">{significant(value)}</text>'
        middle = f'x="{(LEFT + RIGHT) / 2:.0f}" y="{HIGH - 6:.0f}" text-anchor="middle"'
        yield f"<text {middle}>{escape(self.variable.title)}</text>"
        yield f'<text x="4" y="13">{escape(title)}</text>'

    def placed(self, points: Sequence[ChartPoint]) -> list[tuple[float, ChartPoint]]:
        """Return the points of a series from left to right, each with its position [px]."""
        placed = [(self.across.place(self.variable.values[point.at[0]]), point) for point in points]
        return sorted(placed, key=lambda item: item[0])


@dataclass(frozen=True, slots=True)
class _Series:
    """One line, with gaps at points without a number."""

    frame: _Frame
    name: str
    colour: str

    def drawn(self, points: Sequence[ChartPoint]) -> Iterator[str]:
        placed, stretch = self.frame.placed(points), list[str]()
        for x, point in placed:
            if point.value is not None:
                stretch.append(f"{x:.1f},{self.frame.up.place(point.value):.1f}")
            else:
                yield self._stretch(stretch)
                stretch = []
        yield self._stretch(stretch)
        yield from (self._mark(x, point) for x, point in placed)

    def _stretch(self, places: Sequence[str]) -> str:
        title = f"<title>{escape(self.name)}</title>"
        return f'<polyline points="{" ".join(places)}" stroke="{self.colour}">{title}</polyline>' if places[1:] else ""

    def _mark(self, x: float, point: ChartPoint) -> str:
        title = f"<title>{escape(point.text)}</title>"
        if point.value is not None:
            y = self.frame.up.place(point.value)
            return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{self.colour}">{title}</circle>'
        y = TOP if point.passed else BOTTOM  # a case that passed never stands where the worst would
        shape = f"l{MARK:.0f} {MARK:.0f}l{2 * MARK:.0f} -{2 * MARK:.0f}" if point.passed else _CROSS
        return f'<path class="mark" d="M{x - MARK:.1f} {y:.1f}{shape}" stroke="{self.colour}">{title}</path>'


_CROSS = f"m0 -{MARK:.0f}l{2 * MARK:.0f} {2 * MARK:.0f}m0 -{2 * MARK:.0f}l-{2 * MARK:.0f} {2 * MARK:.0f}"


# Charts of scenarios: a line over one variable, a table of coloured cells over two.


MOST_MAPS = 12  # of one scenario


def charts(results: Iterable[VariantResult]) -> str:
    """Return a chart for each scenario with numeric variables, as HTML; empty if there are none."""
    drawn = [line_chart(study) if len(study.variables) == 1 else _maps(study) for study in studies(results)]
    return f'<section class="charts">{"".join(drawn)}</section>' if drawn else ""


def _maps(study: Study) -> str:
    """Return one table per series, as a cell has one colour."""
    drawn = [_map(study, name, points) for name, points in list(study.series.items())[:MOST_MAPS]]
    more = len(study.series) - len(drawn)
    return "".join(drawn) + (f"<p>{more} more tables of {escape(study.scenario)} are not shown</p>" if more > 0 else "")


def _map(study: Study, name: str, points: Sequence[ChartPoint]) -> str:
    cells = {point.at: point for point in points}
    across, down = study.variables
    most = max((abs(point.value) for point in points if point.value is not None), default=0.0)
    head = f"<tr><th>{escape(down.name)} \\ {escape(across.name)}</th>"
    head += "".join(f"<th>{escape(text)}</th>" for text in across.values) + "</tr>"
    body = ""
    for row in down.values:
        body += f"<tr><th>{escape(row)}</th>"
        body += "".join(_cell(cells.get((column, row)), most) for column in across.values) + "</tr>"
    caption = f"<caption>{escape(study.scenario)} on {escape(name)}: {escape(study.title)}</caption>"
    return f'<figure><table class="map">{caption}{head}{body}</table></figure>'


def _cell(point: ChartPoint | None, most: float) -> str:
    """Return a cell; for a point without a number it only shows whether it passed."""
    if point is None:
        return "<td></td>"
    good = point.passed if point.value is None else point.value >= 0.0
    depth = 4 if point.value is None else min(4, 1 + int(4 * abs(point.value) / (most or 1.0)))
    label = ("holds" if good else "fails") if point.value is None else significant(point.value)
    return f'<td class="{"above" if good else "below"}{depth}" title="{escape(point.text)}">{label}</td>'
