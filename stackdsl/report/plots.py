"""Plots of fragility curves and of survival by bearing."""

from collections.abc import Sequence
from contextlib import chdir
from io import BytesIO
from math import inf
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stackdsl.judging.proofs import Survival
    from stackdsl.studies.fragility_curve import Fragility


# Makes figures with matplotlib, as bytes, and ignores the settings file of the working directory.


HINT: Final = "pip install 'stackdsl[plot]'"  # installs matplotlib


def new_figure(size: tuple[float, float], layout: str | None = None) -> "Figure":
    """Return an empty figure of a width and height [inch], in a layout of matplotlib.

    Raises ModuleNotFoundError without matplotlib.

    On import, matplotlib reads `matplotlibrc` of the working directory before any other settings, and versions before
    3.10.9 run a part of it as Python. So it is imported in an empty directory: the settings of the user apply, but not
    those of a project, which may be untrusted.
    """
    with TemporaryDirectory() as empty, chdir(empty):
        import matplotlib as mpl  # noqa: PLC0415 -- an optional extra
        from matplotlib.figure import Figure  # noqa: PLC0415 -- likewise
    mpl.rcParams["svg.hashsalt"] = "stackdsl"
    return Figure(figsize=size, layout=layout)


def encoded(figure: "Figure", suffix: str) -> bytes:
    """Return a figure as `.svg` or `.png`; the SVG does not depend on the time of drawing."""
    form = suffix.lower().removeprefix(".")
    file = BytesIO()
    figure.savefig(file, format=form, metadata={"Date": None} if form == "svg" else None)
    return file.getvalue()


# A fragility curve as a picture: points with their intervals, and the lognormal curve through them.


FRAGILITY_SIZE = (6.0, 4.0)  # [inch]
MOST_TICKS = 8
SMOOTH = 200  # points of the drawn curve


def drawn_fragility(name: str, fragility: "Fragility", suffix: str) -> bytes:
    """Return a plot of a fragility curve as `.svg` or `.png`. Raises ModuleNotFoundError without matplotlib."""
    figure = new_figure(FRAGILITY_SIZE)  # before any other module of matplotlib is loaded
    from matplotlib.ticker import NullFormatter  # noqa: PLC0415 -- an optional extra

    shown, unit = fragility.intensity.shown, fragility.intensity.shown_unit
    axes = figure.subplots()
    known = [point for point in fragility.points if point.count > point.unknown]
    values, shares = [shown(point.value) for point in known], [point.share for point in known]
    below = [max(0.0, point.share - point.within.low) for point in known]
    above = [max(0.0, point.within.high - point.share) for point in known]
    axes.errorbar(values, shares, yerr=[below, above], fmt="o", markersize=4, capsize=3, label="samples")
    if fragility.curve is not None:
        from stackdsl.studies.fragility_curve import spaced  # noqa: PLC0415 -- imports scipy

        smooth = [float(value) for value in spaced(known[0].value, known[-1].value, SMOOTH)]
        curve = [fragility.share(value) for value in smooth]
        label = f"lognormal, median {shown(fragility.curve.median):.4g} {unit}".rstrip()
        axes.plot([shown(value) for value in smooth], curve, "-", label=label)
    if known[0].value > 0.0:
        axes.set_xscale("log")
        axes.set_xticks(values[:: 1 + len(values) // MOST_TICKS], minor=False)
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:.3g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(-0.02, 1.02)
    axes.set_xlabel(" ".join(filter(None, [fragility.intensity.name, f"[{unit}]" * bool(unit)])))
    axes.set_ylabel("share of samples that fall")
    axes.set_title(name, fontsize=9)
    axes.legend(fontsize=8)
    figure.tight_layout()
    return encoded(figure, suffix)


# The survived acceleration by bearing, as a polar plot: proven to stand, and proven to fall.


SURVIVAL_SIZE = (5.0, 5.0)  # [inch]


def drawn_survival(name: str, survival: "Survival", suffix: str) -> bytes:
    """Return a plot of survival by bearing as `.svg` or `.png`. Raises ModuleNotFoundError without matplotlib."""
    figure = new_figure(SURVIVAL_SIZE)
    axes = figure.subplots(subplot_kw={"projection": "polar"})
    bearings = [each.bearing for each in survival.along]
    for label, values, style in (
        ("survived", [each.survived for each in survival.along], "-"),
        ("falls", [each.fails for each in survival.along], ":"),
    ):
        axes.plot(*_closed(bearings, values), style, label=label)
    axes.set_title(f"{name}\nhorizontal acceleration [g] by bearing from +x", fontsize=9)
    axes.legend(loc="lower left", fontsize=8)
    return encoded(figure, suffix)


def _closed(bearings: Sequence[float], values: Sequence[float]) -> tuple[list[float], list[float]]:
    """Return a closed line around; bearings without a fall are left out."""
    shown = [value if value < inf else float("nan") for value in values]
    return [*bearings, bearings[0]], [*shown, shown[0]]
