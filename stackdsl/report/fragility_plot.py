"""A fragility curve as a picture: points with their intervals, and the lognormal curve through them."""

from stackdsl.judging.fragility import Fragility, spaced
from stackdsl.report.matplotlib_figures import encoded, new_figure

SIZE = (6.0, 4.0)  # [inch]
MOST_TICKS = 8
SMOOTH = 200  # points that the curve is drawn by


def drawn(name: str, fragility: Fragility, suffix: str) -> bytes:
    """It as `.svg` or `.png`. Raises ModuleNotFoundError without matplotlib."""
    figure = new_figure(SIZE)  # before any other module of matplotlib is loaded
    from matplotlib.ticker import NullFormatter  # noqa: PLC0415 -- an optional extra

    shown, unit = fragility.intensity.shown, fragility.intensity.shown_unit
    axes = figure.subplots()
    known = [point for point in fragility.points if point.count > point.unknown]
    values, shares = [shown(point.value) for point in known], [point.share for point in known]
    below = [max(0.0, point.share - point.within.low) for point in known]
    above = [max(0.0, point.within.high - point.share) for point in known]
    axes.errorbar(values, shares, yerr=[below, above], fmt="o", markersize=4, capsize=3, label="samples")
    if fragility.curve is not None:
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
    axes.set_ylabel("share that falls")
    axes.set_title(name, fontsize=9)
    axes.legend(fontsize=8)
    figure.tight_layout()
    return encoded(figure, suffix)
