"""Pictures and films of a run: SVG, PNG, GIF, WebP, MP4."""

import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from math import ceil
from pathlib import Path
from typing import Final
from xml.sax.saxutils import escape

import numpy as np

from stability.geometry.rows import Array
from stackdsl.simulation.recording import NUMBER, POSITION, TIME, Rows
from stackdsl.trace import EventKind
from stackdsl.viewing.drawing import EDGE, FORCE, DrawingArea, Frame, View, drawn, solids_at
from stackdsl.viewing.run_view import RunView

# Pictures of a run: one panel per view and time, in rows, at one scale.


MARGIN, CAPTION = 10.0, 20.0  # [px]
MOST_WIDE, MOST_HIGH = 420.0, 320.0  # of the drawing in a panel [px]
MOST_IN_ROW = 1300.0  # [px]
AROUND = 1.0  # distance up to which flying bricks are on the paper, in largest extents of the structure
FONTS = "DejaVu Sans, Liberation Sans, Noto Sans, Arial, Helvetica, sans-serif"
TIP = (
    f'<defs><marker id="tip" viewBox="0 0 6 6" refX="5" refY="3" markerWidth="5" markerHeight="5" orient="auto">'
    f'<path d="M0 0 6 3 0 6z" fill="{FORCE}"/></marker></defs>'
)


@dataclass(frozen=True)
class Panel:
    """One drawing with a line of text below."""

    frame: Frame
    caption: str


def picture(
    run: RunView, panels: Sequence[Panel], width: float = MOST_WIDE, among: Sequence[Panel] | None = None
) -> str:
    """Return panels as SVG, in rows; each view has one paper, which fits all panels of `among`."""
    papers = {panel.frame.view.name: _paper(run, among or panels, panel.frame.view, width) for panel in panels}
    cells = [(panel, *papers[panel.frame.view.name]) for panel in panels]
    rows: list[list[str]] = [[]]
    left, top, high, widest = 0.0, 0.0, 0.0, 0.0
    for panel, paper, wide in cells:
        if left and left + wide > MOST_IN_ROW:
            left, top, high = 0.0, top + high, 0.0
        rows.append(list(_panel(run, panel, paper, wide, (left, top))))
        left += wide
        high = max(high, paper.height + CAPTION)
        widest = max(widest, left)
    size = f'width="{ceil(widest)}" height="{ceil(top + high)}"'
    box = f'viewBox="0 0 {ceil(widest)} {ceil(top + high)}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} {box} font-family="{FONTS}" font-size="12">'
    paper_ = '<rect width="100%" height="100%" fill="#fff"/>'
    return "\n".join([head, TIP, paper_, *(line for row in rows for line in row), "</svg>"]) + "\n"


def _panel(run: RunView, panel: Panel, paper: DrawingArea, width: float, corner: tuple[float, float]) -> Iterator[str]:
    wide, high = ceil(width), ceil(paper.height + CAPTION)
    yield f'<svg x="{corner[0]:.1f}" y="{corner[1]:.1f}" width="{wide}" height="{high}">'
    yield f'<g stroke="{EDGE}" stroke-width="0.5" stroke-linejoin="round">'
    yield from drawn(run, panel.frame, paper)
    yield "</g>"
    yield f'<text x="{MARGIN}" y="{paper.height + 12:.1f}" fill="#333">{escape(panel.caption)}</text></svg>'


def _paper(run: RunView, panels: Sequence[Panel], view: View, width: float) -> tuple[DrawingArea, float]:
    """Return the paper that fits all panels of a view, and the width of its panel [px]."""
    hitting = {placement.brick.id for placement in run.timeline.placements if placement.hits}
    seen: list[Array] = [np.zeros((0, 2))]
    hits: list[Array] = []
    for time in {panel.frame.time for panel in panels if panel.frame.view is view}:
        for name, solid in solids_at(run, time).items():
            (hits if name in hitting else seen).append(view.on_paper(solid.corners))
    points = np.concatenate(seen)
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(2), np.ones(2))
    reach = AROUND * (high - low).max()  # flying bricks may come from far away
    near = [
        corners
        for corners in hits
        if (low - reach <= corners.mean(axis=0)).all() and (corners.mean(axis=0) <= high + reach).all()
    ]
    low, high = (
        np.min([low, *(corners.min(axis=0) for corners in near)], axis=0),
        np.max([high, *(corners.max(axis=0) for corners in near)], axis=0),
    )
    size = np.maximum(high - low, 1e-9)
    scale = min(width / size[0], MOST_HIGH / size[1])
    low = low - MARGIN / scale
    return DrawingArea(low, scale, size[1] * scale + 2 * MARGIN), max(size[0] * scale + 2 * MARGIN, 120.0)


def panels_at(run: RunView, views: Sequence[View], time: float | None, forces: bool) -> list[Panel]:
    """Return one panel per view, at a time [s], or at the end."""
    at = run.trace.cost.simulated_time if time is None else time
    return [Panel(Frame(view, at, forces), f"{run.name}, {view.name}, {at:g} s") for view in views]


def strip(run: RunView, view: View, count: int, forces: bool = False) -> list[Panel]:
    """Return panels from just before the first motion to the end, with equal motion in between.

    A run without motion gets panels of its build.
    """
    begin, end = moving_span(run)
    if not _beginnings(run):
        return _panels(view, np.linspace(begin, end, count).tolist(), forces)
    return _panels(view, times_of_motion(run.recording.keys, begin, end, count), forces)


def building(run: RunView, view: View, count: int) -> list[Panel]:
    """Return evenly spaced panels from the first brick to the end."""
    return _panels(view, np.linspace(0.0, run.trace.cost.simulated_time, count).tolist())


def _panels(view: View, times: Sequence[float], forces: bool = False) -> list[Panel]:
    return [Panel(Frame(view, time, forces), f"{time:.2f} s") for time in times]


def moving_frames(run: RunView, view: View, rate: float, most: int, forces: bool = False) -> list[Panel]:
    """Return `rate` panels per second of motion, at most `most` in all."""
    begin, end = moving_span(run)
    count = max(2, min(most, round((end - begin) * rate)))
    return _panels(view, np.linspace(begin, end, count).tolist(), forces)


def moving_span(run: RunView) -> tuple[float, float]:
    """Return begin and end of the motion [s]."""
    began = _beginnings(run)
    end = run.trace.cost.simulated_time
    last = run.recording.times.max(initial=0.0)
    return (max(0.0, min(began) - 0.001), min(end, last)) if began else (0.0, max(last, min(end, 1e-3)))


def _beginnings(run: RunView) -> list[float]:
    """Return the times at which a motion begins [s]."""
    moving = (EventKind.WOKEN, EventKind.PUSHED, EventKind.COLLAPSED)
    hits = [placement.time for placement in run.timeline.placements if placement.hits]
    return [event.time for event in run.trace.events if event.kind in moving] + hits


def times_of_motion(keys: Rows, begin: float, end: float, count: int) -> list[float]:
    """Return times [s] with equal total path of all bricks in between; evenly spaced if nothing moves.

    So a short fall fills a strip, and the rest after it takes one picture.
    """
    parts = np.linspace(0.0, 1.0, count)
    ways = np.linalg.norm(np.diff(keys[:, POSITION], axis=0), axis=1)
    ways[np.diff(keys[:, NUMBER]) != 0.0] = 0.0  # from the last pose of a brick to the first of the next
    times = keys[1:, TIME]
    moving = np.flatnonzero((ways > 0.0) & (times > begin) & (times <= end))
    order = moving[np.argsort(times[moving], kind="stable")]
    path = np.concatenate(([0.0], np.cumsum(ways[order])))
    if path[-1] == 0.0:
        return list((begin + parts * (end - begin)).tolist())
    spaced = np.interp(parts * path[-1], path, np.concatenate(([begin], times[order])))
    return [*spaced[:-1].tolist(), end]


# SVG -> PNG, and several SVGs -> animated GIF or WebP, by libraries of an extra.


HINT = "pip install 'stackdsl[picture]'"


def png(svg: str, zoom: float = 2.0) -> bytes:
    """Return a PNG with `zoom` pixels per SVG pixel along each side. Raises ModuleNotFoundError without resvg."""
    import resvg_py  # noqa: PLC0415 -- an extra

    return bytes(resvg_py.svg_to_bytes(svg_string=svg, zoom=zoom))


def moving(svgs: Sequence[str], rate: float, form: str) -> bytes:
    """Return an endless animation of pictures, `rate` per second, as `gif` or `webp`."""
    from PIL import Image  # noqa: PLC0415 -- likewise

    frames = [Image.open(BytesIO(png(svg, zoom=1.0))).convert("RGB") for svg in svgs]
    animation = BytesIO()
    settings = {"quality": 80, "method": 4} if form == "webp" else {"optimize": True}
    frames[0].save(
        animation, form, save_all=True, append_images=frames[1:], duration=round(1000.0 / rate), loop=0, **settings
    )
    return animation.getvalue()


# SVGs -> MP4, by the ffmpeg of this machine.


PROGRAM: Final = "ffmpeg"
REMEDY: Final = "install ffmpeg (https://ffmpeg.org; on Debian: apt install ffmpeg), or write a .webp or .gif"
# Players need even sides and chroma at half resolution. The encoder is the default of ffmpeg.
SETTINGS: Final = ("-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p", "-movflags", "+faststart")


class FilmError(RuntimeError):
    """There is no ffmpeg, or it failed; the message has the reason."""


def film_maker() -> str:
    """Return the path of ffmpeg. Raises FilmError if there is none."""
    path = shutil.which(PROGRAM)
    if path is None:
        raise FilmError(f".mp4 needs {PROGRAM}, which is not on the PATH; {REMEDY}")
    return path


def mp4(svgs: Sequence[str], rate: float) -> bytes:
    """Return a film of pictures of one size, `rate` per second.

    Raises FilmError, and ModuleNotFoundError without resvg.
    """
    program = film_maker()
    frames = b"".join(png(svg) for svg in svgs)
    with tempfile.TemporaryDirectory() as folder:  # a file, as ffmpeg finally rewrites the index at its head
        film = Path(folder) / "film.mp4"
        source = ("-hide_banner", "-loglevel", "error", "-f", "image2pipe", "-c:v", "png", "-framerate", f"{rate:g}")
        command = [program, *source, "-i", "-", *SETTINGS, str(film)]
        try:
            done = subprocess.run(command, input=frames, capture_output=True, check=False)
        except OSError as error:
            raise FilmError(f"{program} cannot be started: {error.strerror}; {REMEDY}") from error
        if done.returncode or not film.is_file():
            errors = done.stderr.decode("utf-8", "replace").strip().splitlines() or ["unknown error"]
            raise FilmError(f"{program} failed to write the film: {errors[-1]}; {REMEDY}")
        return film.read_bytes()
