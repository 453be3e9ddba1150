"""Makes figures with matplotlib, as bytes, and ignores the settings file of the working directory."""

from contextlib import chdir
from io import BytesIO
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HINT: Final = "pip install 'stackdsl[bench]'"  # what brings matplotlib


def new_figure(size: tuple[float, float], layout: str | None = None) -> "Figure":
    """An empty figure of this width and height [inch], in a layout of matplotlib.

    Raises ModuleNotFoundError without matplotlib.

    When it is loaded, matplotlib reads `matplotlibrc` of the working directory before any other settings, and versions
    before 3.10.9 run a part of it as Python. So it is loaded where there is no such file: settings of the user count,
    and those of a project that somebody else sent do not.
    """
    with TemporaryDirectory() as empty, chdir(empty):
        import matplotlib as mpl  # noqa: PLC0415 -- an optional extra
        from matplotlib.figure import Figure  # noqa: PLC0415 -- likewise
    mpl.rcParams["svg.hashsalt"] = "stackdsl"
    return Figure(figsize=size, layout=layout)


def encoded(figure: "Figure", suffix: str, dpi: int | None = None) -> bytes:
    """A figure as `.svg` or `.png`; the SVG is the same whenever it is drawn."""
    form = suffix.lower().removeprefix(".")
    file = BytesIO()
    figure.savefig(file, format=form, dpi=dpi or "figure", metadata={"Date": None} if form == "svg" else None)
    return file.getvalue()
