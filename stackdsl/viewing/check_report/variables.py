"""What was measured over the variables of a scenario: a line over one, a map of cells over two.

Measured is at which level it collapsed, where all cases of a scenario do; else how far the first claim of each was from
its threshold: above zero it passed, and where the line crosses zero the answer flips.
"""

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from math import isfinite

from stackdsl.outcome import VariantResult
from stackdsl.report.outcome_text import significant

FEWEST = 3  # values of a variable that are worth a line
WIDE, HIGH, EDGE = 420.0, 150.0, 34.0  # [px]
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8c8c8c")
NUMBER = re.compile(r"[-+]?[0-9]+(?:\.[0-9]+)?(?:e[-+]?[0-9]+)?")


@dataclass(frozen=True, slots=True)
class Measured:
    """What is drawn of some runs."""

    name: str
    of: Callable[[VariantResult], float]
    unit_of: Callable[[VariantResult], str] = lambda run: ""  # a claim may count bricks in one run, and mm in another


def measured(runs: Sequence[VariantResult]) -> Measured:
    """What there is to draw of these runs."""
    if all(run.collapse is not None for run in runs):
        return Measured("level of collapse", lambda run: float(run.collapse.level) if run.collapse else 0.0)
    claim = runs[0].outcomes[0]
    name = f"margin of {claim.name}{f' in {claim.unit}' if claim.unit else ''}"
    return Measured(name, lambda run: run.outcomes[0].margin, lambda run: run.outcomes[0].unit)


def charts(results: Sequence[VariantResult]) -> Iterator[str]:
    """One chart for each scenario that runs through numbers, as HTML."""
    by_scenario: defaultdict[str, list[VariantResult]] = defaultdict(list)
    for result in results:
        if result.outcomes and result.parameters and isfinite(result.outcomes[0].margin):
            by_scenario[result.scenario].append(result)
    for scenario, runs in by_scenario.items():
        varied = _varied(runs)
        if len(varied) == 1 and len({_value(run, varied[0]) for run in runs}) >= FEWEST:
            yield _line(scenario, varied[0], runs)
        elif len(varied) == 2:  # noqa: PLR2004 -- a map has two sides
            yield _map(scenario, varied, runs)


def _varied(runs: Sequence[VariantResult]) -> list[str]:
    """The variables that have several values, all of them numbers."""
    values: defaultdict[str, set[float | None]] = defaultdict(set)
    for run in runs:
        for name, _ in run.parameters:
            values[name].add(_value(run, name))
    return [name for name, found in values.items() if len(found) > 1 and None not in found]


def _value(run: VariantResult, name: str) -> float | None:
    """The number that a variable has in a run, in whatever unit it is written."""
    found = NUMBER.match(dict(run.parameters).get(name, ""))
    return float(found[0]) if found else None


def _line(scenario: str, name: str, runs: Sequence[VariantResult]) -> str:
    what = measured(runs)
    unit = what.unit_of(runs[0])
    others = sum(what.unit_of(run) != unit for run in runs)
    lines: defaultdict[str, list[tuple[float, float]]] = defaultdict(list)
    for run in runs:
        value = _value(run, name)
        if value is not None and what.unit_of(run) == unit:
            lines[run.system].append((value, what.of(run)))
    xs = [x for points in lines.values() for x, _ in points]
    ys = [0.0, *(y for points in lines.values() for _, y in points)]
    (left, right), (low, high) = (min(xs), max(xs)), (min(ys), max(ys) if max(ys) > min(ys) else min(ys) + 1.0)

    def place(x: float, y: float) -> str:
        across = EDGE + (x - left) / (right - left) * (WIDE - 2 * EDGE)
        return f"{across:.1f},{HIGH - 20 - (y - low) / (high - low) * (HIGH - 40):.1f}"

    shapes = [f'<polyline points="{place(left, 0.0)} {place(right, 0.0)}" stroke="#888" stroke-dasharray="4"/>']
    for (system, points), colour in zip(lines.items(), COLOURS * len(lines), strict=False):
        told = " ".join(place(x, y) for x, y in sorted(points))
        shapes.append(f'<polyline points="{told}" stroke="{colour}"><title>{escape(system)}</title></polyline>')
        shapes += [_dot(place(x, y), colour, f"{system}: {significant(x)}, {significant(y)}") for x, y in points]
    ends = f'<text x="{EDGE}" y="{HIGH - 4}">{significant(left)}</text><text x="{WIDE - EDGE}" y="{HIGH - 4}" '
    ends += f'text-anchor="end">{significant(right)}</text><text x="2" y="14">{significant(high)}</text>'
    drawn = f'<svg viewBox="0 0 {WIDE:.0f} {HIGH:.0f}" width="{WIDE:.0f}" fill="none">{"".join(shapes)}'
    drawn += f'<g fill="currentColor" font-size="11">{ends}</g></svg>'
    about = f"{scenario}: {what.name} over {name}" + (f", without {others} in another unit" if others else "")
    keys = ", ".join(lines)
    return f"<figure>{drawn}<figcaption>{escape(about)} ({escape(keys)})</figcaption></figure>"


def _dot(place: str, colour: str, about: str) -> str:
    x, y = place.split(",")
    return f'<circle cx="{x}" cy="{y}" r="3" fill="{colour}"><title>{escape(about)}</title></circle>'


def _map(scenario: str, names: Sequence[str], runs: Sequence[VariantResult]) -> str:
    """A table of two variables; one system each, as a cell has one colour. In another unit, a cell says so."""
    parts, what = [], measured(runs)
    unit = what.unit_of(runs[0])
    for system in dict.fromkeys(run.system for run in runs):
        of_system = [run for run in runs if run.system == system]
        cells = {tuple(_text(run, name) for name in names): run for run in of_system}
        columns = dict.fromkeys(_text(run, names[0]) for run in of_system)
        rows = dict.fromkeys(_text(run, names[1]) for run in of_system)
        most: defaultdict[str, float] = defaultdict(float)  # by unit
        for run in of_system:
            most[what.unit_of(run)] = max(most[what.unit_of(run)], abs(what.of(run)))
        head = f"<tr><th>{escape(names[1])} \\ {escape(names[0])}</th>"
        head += "".join(f"<th>{escape(column)}</th>" for column in columns) + "</tr>"
        body = ""
        for row in rows:
            told = [cells.get((column, row)) for column in columns]
            body += f"<tr><th>{escape(row)}</th>"
            body += "".join(_cell(what, run, most, unit) if run is not None else "<td></td>" for run in told) + "</tr>"
        caption = f"<caption>{escape(scenario)} on {escape(system)}: {escape(what.name)}</caption>"
        parts.append(f'<table class="map">{caption}{head}{body}</table>')
    return "".join(parts)


def _cell(what: Measured, run: VariantResult, most: Mapping[str, float], usual: str) -> str:
    value, unit = what.of(run), what.unit_of(run)
    depth = min(4, 1 + int(4 * abs(value) / (most[unit] or 1.0)))
    told = significant(value) if unit == usual else f"{significant(value)} {unit}"
    return f'<td class="{"above" if value >= 0.0 else "below"}{depth}">{escape(told)}</td>'


def _text(run: VariantResult, name: str) -> str:
    return dict(run.parameters).get(name, "")
