"""One quantity over one variable as a line: axes with their units, and a cross for what has no number in that unit."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

from stackdsl.report.outcome_text import significant
from stackdsl.viewing.check_report.axes import Axis
from stackdsl.viewing.check_report.variables import Point, Study, Variable

WIDE, HIGH = 520.0, 250.0  # [px]
LEFT, RIGHT, TOP, BOTTOM = 52.0, 508.0, 22.0, 210.0  # [px] of what is drawn; around it something is written
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8c8c8c")
CROSS = 4.0  # [px]


def line_chart(study: Study) -> str:
    """A figure as HTML."""
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
    about += f"; crosses: {others} without a number in {study.unit or 'this unit'}" if others else ""
    svg = f'<svg viewBox="0 0 {WIDE:.0f} {HIGH:.0f}" width="{WIDE:.0f}" role="img">{"".join(shapes)}</svg>'
    return f"<figure>{svg}<figcaption>{escape(about)}<br>{keys}</figcaption></figure>"


def _key(name: str, colour: str) -> str:
    line = f'<svg width="14" height="10"><path d="M0 5H14" stroke="{colour}"/></svg>'
    return f'<span class="key">{line} {escape(name)}</span>'


@dataclass(frozen=True, slots=True)
class _Frame:
    """The axes."""

    variable: Variable
    across: Axis
    up: Axis

    def drawn(self, title: str) -> Iterator[str]:
        """Lines, numbers and units."""
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

    def placed(self, points: Sequence[Point]) -> list[tuple[float, Point]]:
        """The points of a series from left to right, each with where it is [px]."""
        found = [(self.across.place(self.variable.values[point.at[0]]), point) for point in points]
        return sorted(found, key=lambda item: item[0])


@dataclass(frozen=True, slots=True)
class _Series:
    """One line, which is broken where nothing was measured."""

    frame: _Frame
    name: str
    colour: str

    def drawn(self, points: Sequence[Point]) -> Iterator[str]:
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

    def _mark(self, x: float, point: Point) -> str:
        title = f"<title>{escape(point.told)}</title>"
        if point.value is not None:
            y = self.frame.up.place(point.value)
            return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{self.colour}">{title}</circle>'
        strokes = "".join(
            f"M{x - CROSS:.1f} {BOTTOM - way:.1f}L{x + CROSS:.1f} {BOTTOM + way:.1f}" for way in (CROSS, -CROSS)
        )
        return f'<path class="cross" d="{strokes}" stroke="{self.colour}">{title}</path>'
