"""What a structure survives by bearing, as a polar picture: what is proven to stand, and what is proven to fall."""

from collections.abc import Sequence
from math import inf

from stackdsl.judging.survival import Survival
from stackdsl.report.matplotlib_figures import encoded, new_figure

SIZE = (5.0, 5.0)  # [inch]


def drawn(name: str, survival: Survival, suffix: str) -> bytes:
    """It as `.svg` or `.png`. Raises ModuleNotFoundError without matplotlib."""
    figure = new_figure(SIZE)
    axes = figure.subplots(subplot_kw={"projection": "polar"})
    bearings = [each.bearing for each in survival.along]
    for label, values, style in (
        ("survived", [each.survived for each in survival.along], "-"),
        ("brings it down", [each.fails for each in survival.along], ":"),
    ):
        axes.plot(*_closed(bearings, values), style, label=label)
    axes.set_title(f"{name}\nhorizontal acceleration [g] by bearing from +x", fontsize=9)
    axes.legend(loc="lower left", fontsize=8)
    return encoded(figure, suffix)


def _closed(bearings: Sequence[float], values: Sequence[float]) -> tuple[list[float], list[float]]:
    """The line around, back to where it began; what nothing brings down is left out."""
    shown = [value if value < inf else float("nan") for value in values]
    return [*bearings, bearings[0]], [*shown, shown[0]]
