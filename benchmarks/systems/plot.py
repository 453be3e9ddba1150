"""Draws speed against error: one panel per measure, one line per system, and the Pareto front.

Both axes are logarithmic. A logarithmic axis has no zero, so the bottom of a panel is a band for errors of zero.
"""

from collections.abc import Mapping, Sequence
from math import ceil, log10
from typing import TYPE_CHECKING

from benchmarks.systems.points import MEASURES, Point, fronts_of
from stackdsl.report.plots import encoded, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLES: Mapping[str, str] = {
    "wrong": "wrong verdicts [%]",
    "levels": "level of collapse, largest error [levels]",
    "creep": "creep of what should stand, largest [mm]",
    "mm": "lengths, largest error [mm]",
    "deg": "angles, largest error [deg]",
    "seconds": "times, largest error [s]",
}
MARKERS = "osD^vP*X"
ACROSS = 2  # panels side by side
PANEL = (6.0, 4.2)  # [inch]
LEAST_FLOOR, MOST_FLOOR = 1e-9, 1.0


def floor_of(errors: Sequence[float]) -> float:
    """Return a power of ten below all non-zero errors: the upper end of the band for zeros."""
    least = min((error for error in errors if error > 0.0), default=1.0)
    return min(MOST_FLOOR, max(LEAST_FLOOR, 10.0 ** (ceil(log10(least)) - 1)))


def shown_at(error: float, floor_at: float) -> float:
    """Return the drawn value of an error: the middle of the band for zero."""
    return error if error > floor_at else floor_at / 10.0**0.5


def drawn(points: Sequence[Point]) -> bytes:
    """Return the picture as SVG. Raises ModuleNotFoundError without matplotlib."""
    fronts = fronts_of(points)
    measures = [measure for measure in MEASURES if measure in fronts]
    down = ceil(len(measures) / ACROSS)
    figure = new_figure((ACROSS * PANEL[0], down * PANEL[1]), "constrained")
    panels = figure.subplots(down, ACROSS, squeeze=False)
    for panel, measure in zip(panels.flat, measures, strict=False):
        _draw_panel(panel, measure, points, fronts[measure])
    for panel in panels.flat[len(measures) :]:
        panel.set_axis_off()
    figure.legend(*panels.flat[0].get_legend_handles_labels(), loc="outside lower center", ncols=6, frameon=False)
    return encoded(figure, "svg")


def _draw_panel(panel: "Axes", measure: str, points: Sequence[Point], front: Sequence[Point]) -> None:
    told = [point for point in points if point.pace is not None and point.errors[measure] is not None]
    floor_at = floor_of([_error(point, measure) for point in told])
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.axhspan(floor_at / 10.0, floor_at, color="0.92", zorder=0)
    panel.text(0.01, floor_at / 9.0, "no error", transform=panel.get_yaxis_transform(), color="0.5", va="bottom")
    # Numbered over all points, so that a system keeps its colour if another is missing.
    for number, system in enumerate(dict.fromkeys(point.system for point in points if point.pace is not None)):
        places = [_place(point, measure, floor_at) for point in told if point.system == system]
        style = {"marker": MARKERS[number % len(MARKERS)], "color": f"C{number}"}
        panel.plot(*(zip(*places, strict=True) if places else ((), ())), linewidth=0.8, label=system, **style)
    places = [_place(point, measure, floor_at) for point in front]
    panel.step(*zip(*places, strict=True), where="post", color="black", linewidth=2.5, alpha=0.25, label="Pareto front")
    panel.set_ylim(bottom=floor_at / 10.0)
    top = panel.get_ylim()[1]
    panel.set_yticks([tick for tick in panel.get_yticks() if floor_at <= tick <= top])  # the band has no scale
    panel.tick_params(which="minor", labelsize=6)
    panel.set_title(TITLES[measure], fontsize=10)
    panel.set_xlabel("wall time for a simulated second [s]", fontsize=9)
    panel.grid(which="major", color="0.9", linewidth=0.5)


def _error(point: Point, measure: str) -> float:
    error = point.errors[measure]
    assert error is not None
    return error


def _place(point: Point, measure: str, floor_at: float) -> tuple[float, float]:
    assert point.pace is not None
    return point.pace, shown_at(_error(point, measure), floor_at)
