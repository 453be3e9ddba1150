"""Draws the scenario of README seen from the side, with the start of its fall, as docs/leaning-column.svg.

Drawn from a run of the scenario, as plain SVG; `python -m benchmarks.figures.picture`. The final positions are not
drawn, since they differ between processors.
"""

import re
from collections.abc import Iterator, Mapping
from math import atan2

from benchmarks.figures.pages import ROOT
from stability.geometry.vectors import rotate
from stability.model import BodyId, Brick, Pose
from stackdsl.checking.cases import Case, cases_of
from stackdsl.checking.play_case import play_case
from stackdsl.language.yaml.source import parse
from stackdsl.trace import Trace

PATH = ROOT / "docs" / "leaning-column.svg"
SCALE = 1500.0  # [px/m]
WIDTH, HEIGHT = 440.0, 190.0  # of a panel [px]
LEFT, GROUND = 100.0, 150.0  # position of the origin in a panel [px]
STANDS, MOVES, NOTHING = "#8fb996", "#e0a458", "none"


def main() -> None:
    """Play and draw."""
    PATH.write_text(drawn(play_case(scenario().timeline, "exact")), encoding="utf-8")


def scenario() -> Case:
    """Return the first scenario of README."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    found = re.search(r"```yaml\n(.*?)```", readme, re.DOTALL)
    assert found is not None
    turns = "  - pivots: {about: L1.1, within: 5 deg}\n"  # so that the run measures the start of the fall
    return cases_of(parse(found[1] + turns, "README.md"))[0][0]


def drawn(trace: Trace) -> str:
    """Draw the structure before the last brick, and after it."""
    bricks = {name: track.brick for name, track in trace.tracks.items()}
    assert trace.collapse is not None
    assert trace.onset is not None
    last, names = trace.collapse.brick, list(trace.tracks)
    stood = {name: trace.tracks[name].rest for name in names[: names.index(last)]}
    moving = trace.onset.poses
    kept = {name: pose for name, pose in stood.items() if name not in moving}
    turns = f"with {last}, {len(moving)} planks turn about {', '.join(trace.onset.about)}; here by 5 deg"
    after = [
        *_shapes(bricks, kept, STANDS),
        *_shapes(bricks, {name: poses[0] for name, poses in moving.items()}, NOTHING),
        *_shapes(bricks, {name: poses[1] for name, poses in moving.items()}, MOVES),
    ]
    panels = [
        *_panel(0, f"{len(stood)} planks stand: every one is proven", list(_shapes(bricks, stood, STANDS))),
        *_panel(1, turns, after),
    ]
    size = f'width="{2 * WIDTH:.0f}" height="{HEIGHT:.0f}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="13">'
    return "\n".join([head, *panels, "</svg>"]) + "\n"


def _panel(number: int, title: str, shapes: list[str]) -> Iterator[str]:
    yield f'<g transform="translate({number * WIDTH:.0f} 0)">'
    yield f'<line x1="10" x2="{WIDTH - 20.0:.0f}" y1="{GROUND:.0f}" y2="{GROUND:.0f}" stroke="#777"/>'
    yield from shapes
    yield f'<text x="10" y="{GROUND + 25.0:.0f}">{title}</text>'
    yield "</g>"


def _shapes(bricks: Mapping[BodyId, Brick], poses: Mapping[BodyId, Pose], fill: str) -> Iterator[str]:
    style = f'fill="{fill}" stroke="#555"' if fill != NOTHING else 'fill="none" stroke="#aaa" stroke-dasharray="3 2"'
    for name, pose in poses.items():
        yield f'<polygon points="{_outline(bricks[name], pose)}" {style}/>'


def _outline(brick: Brick, pose: Pose) -> str:
    """Return the corners of the front face in order: planks here rotate about the line of sight only."""
    nearest = min(corner[1] for corner in brick.shape.corners)
    face = [corner for corner in brick.shape.corners if corner[1] == nearest]
    found = []
    for corner in sorted(face, key=lambda corner: atan2(corner[2], corner[0])):
        moved = rotate(pose.orientation, corner)
        x, z = pose.position_W[0] + moved[0], pose.position_W[2] + moved[2]
        found.append(f"{LEFT + SCALE * x:.1f},{GROUND - SCALE * z:.1f}")
    return " ".join(found)


if __name__ == "__main__":
    main()
