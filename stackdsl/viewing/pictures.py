"""Pictures and films of a run: SVG, PNG, GIF, WebP, MP4."""

import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from itertools import pairwise
from math import ceil
from pathlib import Path
from typing import Final

import numpy as np

from stability.geometry.rows import Array
from stability.model import BodyId
from stability.name_order import in_order, names_text
from stability.stabilizers.approach import IMMINENT, OVERLOADED
from stackdsl.shown_text import visible
from stackdsl.simulation.recording import NUMBER, POSITION, TIME, Rows
from stackdsl.timeline import Arrival, Timeline
from stackdsl.trace import Event, EventKind
from stackdsl.viewing.drawing import (
    DASHES,
    EDGE_ON,
    NO_FILL,
    NOTHING,
    TIE,
    VIEWS,
    DrawingArea,
    ForceScale,
    Frame,
    Overlay,
    ScaleBar,
    Solid,
    State,
    View,
    arrow_shape,
    arrow_shapes,
    brick_shapes,
    faces_of,
    force_text,
    ground_shapes,
    hinge_shape,
    joint_uses,
    joint_uses_at,
    load_arrows,
    load_scale,
    moving_at,
    names_on,
    proof_at,
    pulled_out_at,
    rim_of,
    round_below,
    solids_at,
    states_at,
    thrust_shapes,
    tie_shapes,
)
from stackdsl.viewing.run_view import RunView
from stackdsl.viewing.studs import pitches
from stackdsl.viewing.style import token
from stackdsl.viewing.svg import FAINT, GRID, INK, png, svg_of, text_at, width_of
from stackdsl.wording import how_many

# Pictures of a run: a title, panels at one scale, and a legend of what occurs in them.


WIDEST, HIGHEST = 600.0, 760.0  # of the panels of a picture; a wider one is hard to read on a narrow page [px]
LEAST_WIDE, LEAST_HIGH, MOST_HIGH = 150.0, 120.0, 440.0  # of a panel [px]
MARGIN, FOOT = 12.0, 36.0  # around a drawing, and below it, where its scale stands [px]
GAP = 8.0  # between panels [px]
TEXT, LINE, SWATCH = 14.0, 19.0, 12.0  # sizes of letters, lines, and squares of the legend [px]
NAME = 16.0  # [px] size of the name of a run
BAR = 90.0  # [px] longest bar of a scale
MOST_COLUMNS = 4
ALIKE = 0.85  # scales that differ by less than this factor are about the same
AROUND = 1.0  # distance up to which flying bricks are on the paper, in largest extents of the structure


@dataclass(frozen=True)
class Panel:
    """One drawing, and what stands below it: a title, and what happens."""

    frame: Frame
    title: str
    text: str = ""


def picture(run: RunView, heading: str, panels: Sequence[Panel]) -> str:
    """Return panels as SVG, in rows below the name of the run and a heading. Raises TooMuchWorkError."""
    return Sheet(run, heading, panels, len(panels)).drawn(panels)


class Sheet:
    """Paper whose layout and legend suit all of some panels, of which a number is drawn at once."""

    def __init__(self, run: RunView, heading: str, panels: Sequence[Panel], at_once: int) -> None:
        frames = [panel.frame for panel in panels]
        self._run, self._forces = run, _force_scale(run, frames)
        self._loads = _load_scale(run, frames)
        self._layout = layout = Layout.of(run, frames, self._forces, self._loads, at_once)
        self._wide = max(layout.columns * (layout.wide + GAP) - GAP, width_of(run.name, NAME), 2.0 * LEAST_WIDE)
        self._headings = wrapped(heading, self._wide)
        self._legend = list(_legend(run, frames, self._forces, layout.scale))
        self._legend += _marks_in_legend(run, frames, self._loads, layout.scale)
        self._least_lines = max(map(self._lines, panels)) if at_once == 1 else 0  # all frames of a film have one size

    def drawn(self, panels: Sequence[Panel]) -> str:
        """Return some of the panels as SVG. Raises TooMuchWorkError."""
        layout, named = self._layout, set[BodyId]()
        title = visible(self._run.name)
        shapes = [text_at(MARGIN, 25.0, title, colour=INK, font_size=f"{NAME:g}", font_weight="600")]
        shapes += [_line(MARGIN, 45.0 + LINE * number, text) for number, text in enumerate(self._headings)]
        y = 36.0 + LINE * len(self._headings)
        for first in range(0, len(panels), layout.columns):
            row = panels[first : first + layout.columns]
            for column, panel in enumerate(row):
                has_bar = first + column == 0 or layout.views > 1
                names, drawing = self._panel(panel, MARGIN + column * (layout.wide + GAP), y, has_bar)
                named |= names
                shapes += drawing
            y += layout.high + LINE * (1 + max(self._least_lines, *map(self._lines, row))) + GAP
        legend = [*self._legend]
        if Overlay.NAMES in panels[0].frame.overlays:
            present = {name for panel in panels for name in solids_at(self._run, panel.frame.time)}
            if unnamed := len(present - named):
                legend.append(([], 0.0, f"no room for the names of {how_many(unnamed, 'brick')}"))
        x = MARGIN
        for symbol, symbol_wide, text in legend:
            indent = symbol_wide + 6.0 if symbol_wide else 0.0
            wide = indent + width_of(text, TEXT)
            if x > MARGIN and x + wide > self._wide + MARGIN:
                x, y = MARGIN, y + LINE
            shapes += [f'<g transform="translate({x:.1f} {y:.1f})">', *symbol, "</g>"]
            shapes.append(_line(x + indent, y + 11.0, text))
            x += wide + 2.0 * MARGIN
        return svg_of(ceil(self._wide + 2.0 * MARGIN), ceil(y + LINE + MARGIN / 2.0), shapes)

    def _panel(self, panel: Panel, x: float, y: float, has_bar: bool) -> tuple[set[BodyId], list[str]]:
        """Return the bricks that bear their names in a panel, and its shapes."""
        layout, view = self._layout, panel.frame.view
        drawing, named = _drawing(self._run, panel.frame, layout.area(view), self._forces, self._loads)
        size = f'x="{x:g}" y="{y:g}" width="{layout.wide:g}" height="{layout.high:g}"'
        shapes = [f"<svg {size}>", *drawing, *(_bar_shapes(view, layout) if has_bar else ()), "</svg>"]
        shapes.append(f'<rect {size} fill="none" stroke="{GRID}"/>')
        y += layout.high + 15.0
        shapes.append(text_at(x, y, panel.title, colour=INK, font_size=f"{TEXT:g}", font_weight="600"))
        lines = wrapped(panel.text, layout.wide)
        shapes += [_line(x, y + LINE * number, text) for number, text in enumerate(lines, start=1)]
        return named, shapes

    def _lines(self, panel: Panel) -> int:
        return len(wrapped(panel.text, self._layout.wide))


def thumbnail(run: RunView, frame: Frame, width: float, height: float) -> str:
    """Return a drawing without texts as SVG. Raises TooMuchWorkError."""
    area = _filled(*_bounds(run, [frame], None, None), width, height)
    return svg_of(width, height, _drawing(run, frame, area, None, None)[0], adapts=False)


def design(timeline: Timeline, width: float, height: float) -> str:
    """Return a drawing of the bricks of a build at their planned places as SVG. Raises TooMuchWorkError."""
    view = VIEWS["three-quarter"]
    placed = [each for each in timeline.placements if not each.hits]
    studs = pitches(timeline.world.joints)
    solids = {each.brick.id: Solid.of(each.brick.shape, each.pose, studs.get(each.brick.id)) for each in placed}
    points = np.concatenate([view.on_paper(solid.corners) for solid in solids.values()] or [np.array([(0, 0), (1, 1)])])
    area = _filled(points.min(axis=0), points.max(axis=0), width, height)
    faces = faces_of(solids, dict.fromkeys(solids, token("wood")), view, area)
    shapes = [f'<rect width="100%" height="100%" fill="{token("scene")}"/>']
    shapes += ground_shapes(
        timeline.world.planes, solids.values(), view, area, ScaleBar.of(view, area.scale, BAR).length
    )
    shapes += brick_shapes(faces, rim_of([each.brick for each in placed], area.scale))
    return svg_of(width, height, shapes, adapts=False)


def _filled(low: Array, high: Array, width: float, height: float) -> DrawingArea:
    """Return the paper of a size [px] that a rectangle [m] fills."""
    size = np.array((width, height))
    scale = float(((size - 2.0 * MARGIN) / (high - low)).min())
    return DrawingArea((low + high) / 2.0 - size / scale / 2.0, scale, width, height)


@dataclass(frozen=True)
class Layout:
    """The places of panels, which all have one size and one scale."""

    columns: int
    scale: float  # [px/m]
    wide: float  # of a panel [px]
    high: float  # [px]
    bottoms: Mapping[str, Array]  # middle of the lower edge of a drawing, by view [m]

    @classmethod
    def of(
        cls,
        run: RunView,
        frames: Sequence[Frame],
        forces: ForceScale | None,
        loads: ForceScale | None,
        at_once: int,
    ) -> "Layout":
        """Return the layout with the largest scale; of those of about the same scale, the one with most columns."""
        views = {frame.view.name: frame.view for frame in frames}
        bounds = {
            name: _bounds(run, [frame for frame in frames if frame.view is view], forces, loads)
            for name, view in views.items()
        }
        most = np.max([high - low for low, high in bounds.values()], axis=0)

        def scale_of(columns: int) -> float:
            wide = (WIDEST - GAP * (columns - 1)) / columns - 2.0 * MARGIN
            high = max(LEAST_HIGH, min(MOST_HIGH, HIGHEST / ceil(at_once / columns) - 3.0 * LINE)) - MARGIN - FOOT
            return float(min(wide / most[0], high / most[1]))

        columns = 1
        for more in range(2, 1 + min(at_once, MOST_COLUMNS)):
            columns = more if scale_of(more) >= ALIKE * scale_of(columns) else columns
        scale = scale_of(columns)
        wide, high = (most * scale + (2.0 * MARGIN, MARGIN + FOOT)).tolist()
        least = LEAST_WIDE if at_once > 1 else 2.0 * LEAST_WIDE
        bottoms = {}
        for name, (lowest, highest) in bounds.items():
            free = 0.0 if abs(views[name].towards[2]) < EDGE_ON else most[1] - (highest - lowest)[1]  # on the ground
            bottoms[name] = np.array(((lowest[0] + highest[0]) / 2.0, lowest[1] - free / 2.0))
        return cls(columns, scale, ceil(max(wide, least)), ceil(high), bottoms)

    @property
    def views(self) -> int:
        """The number of different views."""
        return len(self.bottoms)

    def area(self, view: View) -> DrawingArea:
        """Return the paper of a panel."""
        foot = np.array((self.wide / 2.0, FOOT))
        return DrawingArea(self.bottoms[view.name] - foot / self.scale, self.scale, self.wide, self.high)


def _bounds(
    run: RunView, frames: Sequence[Frame], forces: ForceScale | None, loads: ForceScale | None
) -> tuple[Array, Array]:
    """Return two corners (2,) of a rectangle around all that frames of one view show [m]."""
    hitting = {placement.brick.id for placement in run.timeline.placements if placement.hits}
    view, seen, hits = frames[0].view, [np.zeros((0, 2))], list[Array]()
    for time in {frame.time for frame in frames}:
        for name, solid in solids_at(run, time).items():
            (hits if name in hitting else seen).append(view.on_paper(solid.corners))
        if forces is not None and (proof := proof_at(run, time)) is not None:
            seen += [np.array((arrow.tail, arrow.tip)) for arrow in forces.arrows(proof, view)]
        if loads is not None and (proof := proof_at(run, time)) is not None:
            seen += [np.array((arrow.tail, arrow.tip)) for arrow in load_arrows(proof, view, loads)]
    points = np.concatenate(seen)
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(2), np.ones(2))
    reach = AROUND * (high - low).max()  # flying bricks may come from far away
    for corners in hits:
        middle = corners.mean(axis=0)
        if (low - reach <= middle).all() and (middle <= high + reach).all():
            low, high = np.minimum(low, corners.min(axis=0)), np.maximum(high, corners.max(axis=0))
    return low, np.maximum(high, low + 1e-9)


def _drawing(
    run: RunView, frame: Frame, area: DrawingArea, forces: ForceScale | None, loads: ForceScale | None
) -> tuple[list[str], set[BodyId]]:
    """Return the shapes of one drawing, and the bricks that bear their names in it."""
    solids = solids_at(run, frame.time)
    colours = {name: state.colour for name, state in states_at(run, frame.time).items()}
    if Overlay.JOINTS in frame.overlays:
        colours |= {name: use.colour for name, use in joint_uses_at(run, frame.time).items()}
    pulled_out = pulled_out_at(run, frame.time)
    faces = faces_of(solids | pulled_out, {**colours, **dict.fromkeys(pulled_out, NO_FILL)}, frame.view, area)
    grid = ScaleBar.of(frame.view, area.scale, BAR).length
    shapes = [f'<rect width="100%" height="100%" fill="{token("scene")}"/>']
    shapes += ground_shapes(run.timeline.world.planes, solids.values(), frame.view, area, grid)
    shapes += brick_shapes(faces, rim_of(run.recording.bricks, area.scale))
    shapes += tie_shapes((tie for tie in run.timeline.world.ties if tie.around <= solids.keys()), frame.view, area)
    proof = proof_at(run, frame.time)
    arrows = [] if forces is None or proof is None else forces.arrows(proof, frame.view)
    shapes += arrow_shapes(arrows, area)
    if proof is not None and Overlay.THRUST in frame.overlays:
        shapes += thrust_shapes(proof.thrust, frame.view, area)
    if proof is not None and loads is not None:
        loaded = load_arrows(proof, frame.view, loads)
        shapes += arrow_shapes(loaded, area, token(LOADS))
        arrows += loaded
    covers = [area.place(np.array((arrow.tail, arrow.tip))) for arrow in arrows]
    names = names_on(faces, covers) if Overlay.NAMES in frame.overlays else {}
    shapes += names.values()
    return shapes, set(names)


def _force_scale(run: RunView, frames: Sequence[Frame]) -> ForceScale | None:
    """Return the common scale of the forces in all frames; None if they show none."""
    shown = [frame for frame in frames if Overlay.FORCES in frame.overlays]
    proofs = [(proof, frame.view) for frame in shown if (proof := proof_at(run, frame.time)) is not None]
    return ForceScale.of(proofs, run.recording.bricks)


LOADED = Overlay.FORCES | Overlay.THRUST  # marks with which loads are drawn
LOADS = "accent"  # their colour


def _load_scale(run: RunView, frames: Sequence[Frame]) -> ForceScale | None:
    """Return the common scale of the loads in all frames; None if they show none."""
    shown = [frame for frame in frames if LOADED & frame.overlays]
    proofs = [(proof, frame.view) for frame in shown if (proof := proof_at(run, frame.time)) is not None]
    return load_scale(proofs, run.recording.bricks)


def _marks_in_legend(
    run: RunView, frames: Sequence[Frame], loads: ForceScale | None, scale: float
) -> Iterator[tuple[Sequence[str], float, str]]:
    """Yield symbol, its width [px] and text of ties, lines of thrust, hinges and loads."""
    if run.timeline.world.ties:
        yield [f'<path d="M0 6H24" stroke="{token("accent")}" stroke-width="{TIE:g}"/>'], 24.0, "tie"
    shown = [frame for frame in frames if Overlay.THRUST in frame.overlays]
    thrusts = [proof.thrust for frame in shown if (proof := proof_at(run, frame.time)) is not None]
    if any(thrust.lines for thrust in thrusts):
        yield [f'<path d="M0 6H24" stroke="{token("fail")}" stroke-width="2.5"/>'], 24.0, "line of thrust of the proof"
    if any(thrust.hinges for thrust in thrusts):
        yield [hinge_shape(6.0, 6.0)], SWATCH, "thrust at an edge: a hinge"
    if loads is not None:
        force = round_below(loads.most)
        length = force / loads.most * loads.longest * scale
        yield list(arrow_shape((0.0, 6.0), (length, 6.0), 0.5, token(LOADS))), length, f"{force_text(force)}: loads"


def _bar_shapes(view: View, layout: Layout) -> Iterator[str]:
    """Yield the scale of a panel, at its bottom right."""
    bar = ScaleBar.of(view, layout.scale, min(BAR, 0.4 * layout.wide))
    x, y = layout.wide - MARGIN, layout.high - MARGIN
    yield from bar.shapes(x - bar.way[0], y - max(bar.way[1], 0.0))
    halo = {"stroke": token("halo"), "stroke_width": "3", "paint_order": "stroke"}
    yield text_at(x - bar.way[0] - 8.0, y + 4.0, bar.text, "end", INK, font_size=f"{TEXT:g}", **halo)


def _legend(
    run: RunView, frames: Sequence[Frame], forces: ForceScale | None, scale: float
) -> Iterator[tuple[Sequence[str], float, str]]:
    """Yield symbol, its width [px] and text of all that occurs in frames, with counts if all show one time."""
    times = {frame.time for frame in frames}
    by_joints = Overlay.JOINTS in frames[0].overlays and run.limit is not None
    states = [] if by_joints else [state for time in times for state in states_at(run, time).values()]
    uses = [use for time in times for use in joint_uses_at(run, time).values()] if by_joints else []
    entries = [(str(state), state.colour, states.count(state)) for state in State]
    entries += [(use.text, use.colour, uses.count(use)) for use in joint_uses(run).values()] if by_joints else []
    for text, colour, count in entries:
        if count:
            square = f'<rect width="{SWATCH:g}" height="{SWATCH:g}" rx="2" fill="{colour}"/>'
            yield [square], SWATCH, f"{text} ({count})" if len(times) == 1 else text
    if pulled := max(len(pulled_out_at(run, time)) for time in times):
        square = (
            f'<rect width="{SWATCH:g}" height="{SWATCH:g}" fill="none" stroke="{FAINT}" stroke-dasharray="{DASHES}"/>'
        )
        yield [square], SWATCH, f"pulled out ({pulled})" if len(times) == 1 else "pulled out"
    if forces is not None:
        force = round_below(forces.most)
        length = force / forces.most * forces.longest * scale
        arrow = arrow_shape((0.0, 6.0), (length, 6.0), force / forces.most)
        yield list(arrow), length, f"{force_text(force)}: forces of the proof"


def _line(x: float, y: float, text: str) -> str:
    return text_at(x, y, text, font_size=f"{TEXT:g}")


def wrapped(text: str, width: float) -> list[str]:
    """Return the lines of a text, broken between words; a longer word stays whole."""
    lines: list[str] = []
    for word in visible(text).split():
        if lines and width_of(f"{lines[-1]} {word}", TEXT) <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines


# Captions of panels: the events before the time of a panel, in words.


PHRASES: Final = (  # by importance
    EventKind.HIT,
    EventKind.WOKEN,
    EventKind.COLLAPSED,
    EventKind.REMOVED,
    EventKind.CUT,
    EventKind.JOINED,
    EventKind.SET,
    EventKind.LOADED,
    EventKind.PUSHED,
    EventKind.SHAKEN,
    EventKind.TAKEN,
    EventKind.LET_GO,
    EventKind.PLACED,
)
MOST_PHRASES = 2  # below one panel
AT_ONCE = 1e-9  # [s]
DONE: Final = {  # to bricks
    EventKind.REMOVED: "pulled out",
    EventKind.CUT: "cut apart",
    EventKind.JOINED: "joined",
    EventKind.SET: "held by joints that have set",
    EventKind.LOADED: "loaded",
    EventKind.PUSHED: "pushed",
    EventKind.TAKEN: "taken by a hand",
    EventKind.LET_GO: "released by a hand",
    EventKind.PLACED: "set down",
}
ARRIVED: Final = {Arrival.DROPPED: "dropped", Arrival.THROWN: "thrown"}
STATE_WORDS: Final = {  # of one brick, and of several
    State.STANDS: ("stands", "stand"),
    State.MOVES: ("moves", "move"),
    State.RIDES: ("rides on another", "ride on others"),
    State.LEFT: ("has fallen", "have fallen"),
    State.THROWN: ("thrown or dropped", "thrown or dropped"),
}


def happening(run: RunView, after: float, until: float) -> str:
    """Return what happens in a time span [s]; at the end of the run, or if nothing does, what the bricks do then."""
    if until >= _end(run):
        return f"end: {summary(run, until)}"
    if phrases := _phrases(run, after, until):
        return phrases
    moving = len(moving_at(run, until))
    return f"{how_many(moving, 'brick')} {STATE_WORDS[State.MOVES][moving > 1]}" if moving else summary(run, until)


def _phrases(run: RunView, after: float, until: float) -> str:
    """Return the most important events of a time span [s] in words; empty without any."""
    arrivals = {placement.brick.id: ARRIVED.get(placement.arrival) for placement in run.timeline.placements}
    assembly, phrases, bricks = set[BodyId](), dict[EventKind, str](), dict[EventKind, list[BodyId]]()
    for event in run.trace.events:
        if event.time > until:
            break
        assembly |= set(event.bricks)
        if event.time > after and event.kind in PHRASES:
            of_kind = bricks.setdefault(event.kind, [])
            of_kind += event.bricks
            named = names_text(in_order(of_kind), among=assembly)
            if event.kind in (EventKind.HIT, EventKind.COLLAPSED):
                phrases[event.kind] = event.reason.partition(";")[0]
            elif event.kind is EventKind.WOKEN:
                if not any(ahead in event.reason for ahead in (IMMINENT, OVERLOADED)):  # else they may stay at rest
                    phrases.setdefault(event.kind, _woken(event, named))
            elif event.kind is EventKind.SHAKEN:
                phrases[event.kind] = "the ground shakes"
            else:
                phrases[event.kind] = f"{named} {arrivals.get(of_kind[0]) or DONE[event.kind]}"
        if event.kind is EventKind.REMOVED:
            assembly -= set(event.bricks)
    if set(bricks.get(EventKind.PLACED, [])) == set(bricks.get(EventKind.WOKEN, [])):
        phrases.pop(EventKind.PLACED, None)  # that they move tells it
    shown = sorted(phrases, key=PHRASES.index)[:MOST_PHRASES]
    return "; ".join(phrase for kind, phrase in phrases.items() if kind in shown)


def _woken(event: Event, named: str) -> str:
    """Return why bricks begin to move, as far as a few words tell it."""
    moves = f"{named} {STATE_WORDS[State.MOVES][len(event.bricks) > 1]}"
    if not event.reason or ";" in event.reason:
        return moves
    return event.reason if event.reason.startswith(f"{named} ") else f"{moves}: {event.reason}"


def summary(run: RunView, time: float) -> str:
    """Return how many bricks are in which state at a time [s]."""
    states = list(states_at(run, time).values())
    counts = [(state, count) for state in State if (count := states.count(state))]
    if not counts:
        return "no brick is placed yet"
    parts = [f"{count} {STATE_WORDS[state][count > 1]}" for state, count in counts]
    state, count = counts[0]
    everything = "all " if len(counts) == 1 and count > 2 else ""  # noqa: PLR2004 -- for two, it is "both"
    parts[0] = f"{everything}{how_many(count, 'brick')} {STATE_WORDS[state][count > 1]}"
    return ", ".join(parts)


def _end(run: RunView) -> float:
    return run.trace.cost.simulated_time


# The panels of a picture, a strip and a film.


def panels_at(views: Sequence[View], time: float, overlays: Overlay = NOTHING) -> list[Panel]:
    """Return one panel per view, at a time [s]."""
    return [Panel(Frame(view, time, overlays), f"{view.name} view") for view in views]


def heading_at(run: RunView, time: float) -> str:
    """Return the heading of a picture of one time [s]."""
    return f"{time:.4g} s: {summary(run, time)}"


def heading_of(run: RunView, view: View) -> str:
    """Return the heading of a strip or a film."""
    return f"{run.verdict}; {view.name} view"


def strip(run: RunView, view: View, count: int, overlays: Overlay = NOTHING) -> list[Panel]:
    """Return panels from just before the first motion to the end, with equal motion in between.

    A run without motion gets panels of its build.
    """
    begin, end = moving_span(run)
    if not _beginnings(run):
        return _panels(run, view, np.linspace(begin, end, count).tolist(), overlays)
    times = times_of_motion(run.recording.keys, begin, end, count)
    return _panels(run, view, [*times[:-1], _end(run)], overlays)


def building(run: RunView, view: View, count: int) -> list[Panel]:
    """Return evenly spaced panels from the first brick to the end."""
    return _panels(run, view, np.linspace(0.0, _end(run), count).tolist())


def _panels(run: RunView, view: View, times: Sequence[float], overlays: Overlay = NOTHING) -> list[Panel]:
    """Return panels with what happens from one time to the next; the first tells what happens or is at that time."""
    first = _phrases(run, times[0] - AT_ONCE, times[0]) or summary(run, times[0])
    texts = [first, *(happening(run, *span) for span in pairwise(times))]
    return [Panel(Frame(view, time, overlays), f"{time:.2f} s", text) for time, text in zip(times, texts, strict=True)]


def moving_frames(run: RunView, view: View, rate: float, most: int, overlays: Overlay = NOTHING) -> list[Panel]:
    """Return `rate` panels per second of motion, at most `most` in all; each tells what happened last."""
    begin, end = moving_span(run)
    times = np.linspace(begin, end, max(2, min(most, round((end - begin) * rate)))).tolist()
    changes = [event.time for event in run.trace.events if event.kind in PHRASES]
    panels = []
    for time in [*times[:-1], _end(run)]:
        last = max((change for change in changes if change <= time), default=0.0)
        panels.append(Panel(Frame(view, time, overlays), f"{time:.2f} s", happening(run, last - AT_ONCE, time)))
    return panels


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
