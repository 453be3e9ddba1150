"""What was measured over the variables of scenarios, drawn: a line over one variable, a map of cells over two."""

from collections.abc import Iterable, Sequence
from html import escape

from stackdsl.outcome import VariantResult
from stackdsl.report.outcome_text import significant
from stackdsl.viewing.check_report.line_chart import line_chart
from stackdsl.viewing.check_report.variables import Point, Study, studies

MOST_MAPS = 12  # of one scenario
FEW = 3  # scenarios whose charts are shown at once; of more, one click shows them


def charts(results: Iterable[VariantResult]) -> str:
    """A chart for each scenario that runs through numbers, as HTML; nothing where there is none."""
    drawn = [line_chart(study) if len(study.variables) == 1 else _maps(study) for study in studies(results)]
    if not drawn:
        return ""
    opened = " open" if len(drawn) <= FEW else ""
    count = f"{len(drawn)} scenarios" if len(drawn) > 1 else "1 scenario"
    summary = f"what was measured over the variables of {count}"
    return f'<details class="studies"{opened}><summary>{summary}</summary>{"".join(drawn)}</details>'


def _maps(study: Study) -> str:
    """A table for each series, as a cell has one colour."""
    drawn = [_map(study, name, points) for name, points in list(study.series.items())[:MOST_MAPS]]
    more = len(study.series) - len(drawn)
    return "".join(drawn) + (f"<p>and {more} more of {escape(study.scenario)}</p>" if more > 0 else "")


def _map(study: Study, name: str, points: Sequence[Point]) -> str:
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
    return f'<table class="map">{caption}{head}{body}</table>'


def _cell(point: Point | None, most: float) -> str:
    """Of a point without a number only whether it passed."""
    if point is None:
        return "<td></td>"
    good = point.passed if point.value is None else point.value >= 0.0
    depth = 4 if point.value is None else min(4, 1 + int(4 * abs(point.value) / (most or 1.0)))
    told = ("holds" if good else "fails") if point.value is None else significant(point.value)
    return f'<td class="{"above" if good else "below"}{depth}" title="{escape(point.told)}">{told}</td>'
