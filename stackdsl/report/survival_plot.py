"""What a structure survives by bearing, as a polar picture: what is proven to stand, and what is proven to fall."""

from collections.abc import Sequence
from math import inf
from pathlib import Path

from stackdsl.judging.survival import Survival

HINT = "pip install 'stackdsl[bench]'"  # what brings matplotlib
SIZE = (5.0, 5.0)  # [inch]


def draw(name: str, survival: Survival, path: Path) -> None:
    """Write it as SVG or PNG, by the ending of the path. Raises ModuleNotFoundError without matplotlib."""
    import matplotlib as mpl  # noqa: PLC0415 -- an optional extra

    mpl.use("agg")
    mpl.rcParams["svg.hashsalt"] = "stackdsl"
    from matplotlib import pyplot  # noqa: PLC0415 -- likewise

    figure, axes = pyplot.subplots(figsize=SIZE, subplot_kw={"projection": "polar"})
    bearings = [each.bearing for each in survival.along]
    for label, values, style in (
        ("survived", [each.survived for each in survival.along], "-"),
        ("brings it down", [each.fails for each in survival.along], ":"),
    ):
        axes.plot(*_closed(bearings, values), style, label=label)
    axes.set_title(f"{name}\nhorizontal acceleration [g] by bearing from +x", fontsize=9)
    axes.legend(loc="lower left", fontsize=8)
    figure.savefig(path, metadata={"Date": None} if path.suffix.lower() == ".svg" else None)
    pyplot.close(figure)


def _closed(bearings: Sequence[float], values: Sequence[float]) -> tuple[list[float], list[float]]:
    """The line around, back to where it began; what nothing brings down is left out."""
    shown = [value if value < inf else float("nan") for value in values]
    return [*bearings, bearings[0]], [*shown, shown[0]]
