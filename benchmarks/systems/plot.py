"""Draws speed against error: one panel per measure, one line per system, and the Pareto front.

Both axes are logarithmic. A logarithmic axis has no zero, so the bottom of a panel is a band for errors of zero.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, log10

from benchmarks.figures.data import Row, Rows
from benchmarks.systems.measured import ERRORS
from benchmarks.systems.points import MEASURES, PERCENT
from stackdsl.viewing.plots import Axis, grid_of
from stackdsl.viewing.svg import GRID, INK, svg_of, text_at

TITLES: Mapping[str, str] = {
    "wrong": "wrong verdicts [%]",
    "levels": "level of collapse, largest error [levels]",
    "creep": "creep of what should stand, largest [mm]",
    "mm": "lengths, largest error [mm]",
    "deg": "angles, largest error [deg]",
    "seconds": "times, largest error [s]",
}
COLOURS = (  # with a contrast of 3 to the ground; dark pages replace some (svg.py)
    "#1a56b0",
    "#cf5a1c",
    "#0f8f72",
    "#9a5fb8",
    "#a06a10",
    "#4b4f55",
    "#b3261e",
    "#1f7f99",
    "#6b8e23",
)
ACROSS = 2  # panels side by side
PANEL = (560.0, 330.0)  # [px]
LEGEND = 60.0  # [px] height
BAND = 18.0  # [px] height of the band for errors of zero
LEAST_FLOOR, MOST_FLOOR = 1e-9, 1.0


def floor_of(errors: Sequence[float]) -> float:
    """Return a power of ten below all non-zero errors: the upper end of the band for zeros."""
    least = min((error for error in errors if error > 0.0), default=1.0)
    return min(MOST_FLOOR, max(LEAST_FLOOR, 10.0 ** (ceil(log10(least)) - 1)))


@dataclass(frozen=True, slots=True)
class _Point:
    """Point of the plot, from a row of the stored results."""

    system: str
    pace: float  # [s] wall time for a simulated second
    errors: Mapping[str, float]  # by measure; without those that are not known
    fronts: frozenset[str]  # the measures for which it is on the Pareto front


def _point(row: Row, pace: float) -> _Point:
    errors = {measure: float(row[key] or 0.0) for measure, key in ERRORS.items() if row[key] is not None}
    if row["known"]:
        errors["wrong"] = PERCENT * float(row["wrong"] or 0) / float(row["known"])
    return _Point(str(row["system"]), pace, errors, frozenset(str(row["front"]).split(", ")))


def drawn(rows: Rows) -> bytes:
    """Return the picture of stored points as SVG; points without a pace are left out."""
    points = [_point(row, float(row["pace"])) for row in rows.values() if row["pace"] is not None]
    measures = [measure for measure in MEASURES if any(measure in point.errors for point in points)]
    systems = list(dict.fromkeys(point.system for point in points))
    colours = dict(zip(systems, COLOURS * len(systems), strict=False))
    shapes: list[str] = []
    for number, measure in enumerate(measures):
        left, top = PANEL[0] * (number % ACROSS), PANEL[1] * (number // ACROSS)
        shapes.append(f'<g transform="translate({left:.0f} {top:.0f})">')
        shapes += [*_panel(measure, points, colours), "</g>"]
    height = PANEL[1] * ceil(len(measures) / ACROSS)
    for number, (system, colour) in enumerate((*colours.items(), ("Pareto front", FRONT))):
        x, y = 64.0 + 170.0 * (number % 6), height + 20.0 + 20.0 * (number // 6)
        shapes.append(f'<circle cx="{x:.0f}" cy="{y:.0f}" r="4" fill="{colour}"/>')
        shapes.append(text_at(x + 10, y + 4, system))
    return svg_of(ACROSS * PANEL[0], height + LEGEND, shapes).encode()


FRONT = "#bbbbb4"


def _panel(measure: str, points: Sequence[_Point], colours: Mapping[str, str]) -> Iterator[str]:
    told = [point for point in points if measure in point.errors]
    errors, paces = [point.errors[measure] for point in told], [point.pace for point in told]
    floor_at = floor_of(errors)
    across = Axis(min(paces) / 1.2, max(paces) * 1.2, 64, PANEL[0] - 20, logarithmic=True)
    up = Axis(floor_at, max(*errors, 2.0 * floor_at) * 1.3, PANEL[1] - 60 - BAND, 40, logarithmic=True)
    bottom = up.begin + BAND

    def place(point: _Point) -> tuple[float, float]:
        error = point.errors[measure]
        return across.place(point.pace), up.place(error) if error > floor_at else up.begin + BAND / 2.0

    box = f'x="64" y="{up.begin:.1f}" width="{PANEL[0] - 84:.0f}" height="{BAND}"'
    yield f'<rect {box} fill="{GRID}" fill-opacity=".5"/>'
    yield text_at(PANEL[0] - 24, bottom - 5, "no error", "end")
    yield from grid_of(across, up, "", "", below=BAND)
    yield text_at(64, 22, TITLES[measure], colour=INK, font_size="13", font_weight="600")
    yield text_at(PANEL[0] - 20, bottom + 34, "wall time for a simulated second [s]", "end")
    front = [point for point in told if measure in point.fronts]
    steps = [place(point) for point in sorted(front, key=lambda point: (point.pace, point.errors[measure]))]
    path = "".join(f"H{x:.1f}V{y:.1f}" if number else f"M{x:.1f} {y:.1f}" for number, (x, y) in enumerate(steps))
    yield f'<path d="{path}" fill="none" stroke="{FRONT}" stroke-width="5"/>'
    for system, colour in colours.items():
        places = [place(point) for point in told if point.system == system]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        yield f'<polyline points="{line}" fill="none" stroke="{colour}"/>'
        yield from (f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>' for x, y in places)
