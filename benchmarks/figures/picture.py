"""Draws the picture of README: its scenario before the fall, with the proof in forces, and the start of the fall.

Drawn from a run of the scenario, as docs/leaning-column.svg: `python -m benchmarks.figures.picture` or `make pictures`.
The final positions are not drawn, since they differ between processors. Letters are large, as a phone shows the picture
at less than half of its size.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from benchmarks.figures.pages import ROOT
from stability.model import BodyId, Pose
from stackdsl.checking.cases import Case, cases_of
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.language.yaml.source import parse
from stackdsl.simulation.recording import Recorder
from stackdsl.viewing.drawing import (
    NO_FILL,
    VIEWS,
    DrawingArea,
    ForceScale,
    ScaleBar,
    Solid,
    State,
    arrow_shape,
    arrow_shapes,
    brick_shapes,
    faces_of,
    force_text,
    ground_shapes,
    proof_at,
    rim_of,
    round_below,
)
from stackdsl.viewing.run_view import RunView, view_of
from stackdsl.viewing.style import token
from stackdsl.viewing.svg import GRID, INK, RED, svg_of, text_at

PATH = ROOT / "docs" / "leaning-column.svg"
VIEW = VIEWS["front"]
WIDE, HIGH = 396.0, 232.0  # of a panel [px]
MARGIN, GAP, TOP = 12.0, 16.0, 48.0  # beside panels, between them, and above them [px]
SCALE = 1600.0  # [px/m]
LEFT, FOOT = 101.0, 90.0  # position of the origin in a panel, from its bottom left [px]
TITLE, NOTE = 26.0, 21.0  # sizes of letters [px]


def main() -> None:
    """Play and draw."""
    PATH.write_text(drawn(played()), encoding="utf-8")


def scenario() -> Case:
    """Return the first scenario of README."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    match = re.search(r"```yaml\n(.*?)```", readme, re.DOTALL)
    assert match is not None
    turns = "  - pivots: {about: L1.1, within: 5 deg}\n"  # so that the run measures the start of the fall
    return cases_of(parse(match[1] + turns, "README.md"))[0][0]


def played() -> RunView:
    """Play the scenario."""
    case, recorder = scenario(), Recorder()
    trace = play_case(case.timeline, case.system, recorder=recorder)
    return view_of(case, trace, recorder.recording(), judged(case, trace))


def drawn(run: RunView) -> str:
    """Draw the structure before the last brick, and after it."""
    shapes = [*_standing(run, MARGIN), *_falling(run, MARGIN + WIDE + GAP)]
    return svg_of(2.0 * (MARGIN + WIDE) + GAP, TOP + HIGH + 70.0, shapes)


def _standing(run: RunView, left: float) -> Iterator[str]:
    """Yield the panel of the structure that stands, with the forces that prove it."""
    last = _last(run)
    time = next(placement.time for placement in run.timeline.placements if placement.brick.id == last) - 0.1
    proof = proof_at(run, time)
    assert proof is not None
    forces = ForceScale.of([(proof, VIEW)], run.recording.bricks)
    assert forces is not None
    area = _area()
    shapes = [*_scene(run, _solids(run, {name: run.trace.tracks[name].rest for name in proof.bricks}))]
    shapes += arrow_shapes(forces.arrows(proof, VIEW), area)
    unit = round_below(forces.most)
    length = unit / forces.most * forces.longest * SCALE
    shapes += arrow_shape((280.0 - length, HIGH - 22.0), (280.0, HIGH - 22.0), unit / forces.most)
    shapes.append(text_at(292.0, HIGH - 15.0, force_text(unit), colour=INK, font_size=f"{NOTE:g}"))
    title, notes = (
        f"{len(proof.bricks)} planks stand",
        ("The proof: contact forces that", "balance the weight of each plank"),
    )
    yield from _panel(left, title, notes, shapes)


def _falling(run: RunView, left: float) -> Iterator[str]:
    """Yield the panel of the start of the fall, with the weight that tips it."""
    trace, last = run.trace, _last(run)
    assert trace.onset is not None
    begin, turned = ({name: poses[k] for name, poses in trace.onset.poses.items()} for k in (0, 1))
    (edge,) = trace.onset.about
    placed = list(trace.tracks)[: list(trace.tracks).index(last)]
    standing = {name: trace.tracks[name].rest for name in placed if name not in begin}
    pivot = max(_solids(run, standing)[edge].corners.tolist(), key=lambda corner: (corner[2], corner[0]))
    over = _centre(run, begin)[0] - pivot[0]
    x, y = _area().place(VIEW.on_paper(_centre(run, turned)[None, :]))[0].tolist()
    ((pivot_x, pivot_y),) = _area().place(VIEW.on_paper(np.array(pivot)[None, :])).tolist()
    shapes = [*_scene(run, _solids(run, standing | turned), _solids(run, begin))]
    shapes += _weight(x, y, pivot_y + 40.0)
    shapes.append(f'<circle cx="{pivot_x:.1f}" cy="{pivot_y:.1f}" r="5" fill="{INK}" stroke="{token("halo")}"/>')
    bar = ScaleBar.of(VIEW, SCALE, 100.0)
    shapes += bar.shapes(280.0 - bar.way[0], HIGH - 22.0)
    shapes.append(text_at(292.0, HIGH - 15.0, bar.text, colour=INK, font_size=f"{NOTE:g}"))
    title = f"The {len(placed) + 1}th makes {len(turned)} tip"
    notes = (f"Their weight acts {1000.0 * over:.1f} mm", "beyond the edge below them")
    yield from _panel(left, title, notes, shapes)


def _weight(x: float, y: float, to: float) -> Iterator[str]:
    for colour, width in ((token("halo"), 7.0), (RED, 3.5)):
        yield (
            f'<path d="M{x:.1f} {y:.1f}V{to - 8.0:.1f}M{x - 5.0:.1f} {to - 12.0:.1f}L{x:.1f} {to:.1f}'
            f'L{x + 5.0:.1f} {to - 12.0:.1f}Z" fill="{colour}" stroke="{colour}" stroke-width="{width:g}"/>'
        )
    yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="{RED}" stroke="{token("halo")}" stroke-width="1.5"/>'


def _scene(
    run: RunView, solids: Mapping[BodyId, Solid], before: Mapping[BodyId, Solid] = MappingProxyType({})
) -> Iterator[str]:
    """Yield the ground, outlines of the moving bricks where they were before, and all bricks."""
    yield f'<rect width="100%" height="100%" fill="{token("scene")}"/>'
    yield from ground_shapes(run.timeline.world.planes, solids.values(), VIEW, _area(), 1.0)
    yield from brick_shapes(faces_of(before, dict.fromkeys(before, NO_FILL), VIEW, _area()), 1.0)
    colours = {name: (State.MOVES if name in before else State.STANDS).colour for name in solids}
    yield from brick_shapes(faces_of(solids, colours, VIEW, _area()), rim_of(run.recording.bricks, SCALE))


def _panel(left: float, title: str, notes: Sequence[str], shapes: Sequence[str]) -> Iterator[str]:
    size = f'x="{left:g}" y="{TOP:g}" width="{WIDE:g}" height="{HIGH:g}"'
    yield text_at(left, 34.0, title, colour=INK, font_size=f"{TITLE:g}", font_weight="600")
    yield from (f"<svg {size}>", *shapes, "</svg>", f'<rect {size} fill="none" stroke="{GRID}"/>')
    for line, note in enumerate(notes):
        yield text_at(left, TOP + HIGH + 26.0 + 26.0 * line, note, font_size=f"{NOTE:g}")


def _area() -> DrawingArea:
    return DrawingArea(np.array((-LEFT, -FOOT)) / SCALE, SCALE, WIDE, HIGH)


def _solids(run: RunView, poses: Mapping[BodyId, Pose | None]) -> dict[BodyId, Solid]:
    shapes = {brick.id: brick.shape for brick in run.recording.bricks}
    return {name: Solid.of(shapes[name], pose) for name, pose in poses.items() if pose is not None}


def _centre(run: RunView, poses: Mapping[BodyId, Pose]) -> np.ndarray:
    """Return the common centre of mass (3,) of bricks [m]."""
    masses = {brick.id: brick.mass for brick in run.recording.bricks}
    return np.average([pose.position_W for pose in poses.values()], axis=0, weights=[masses[name] for name in poses])


def _last(run: RunView) -> BodyId:
    """Return the brick with which the structure falls."""
    assert run.trace.collapse is not None
    return run.trace.collapse.brick


if __name__ == "__main__":
    main()
