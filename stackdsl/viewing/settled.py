"""Pictures of motions by finite displacements: the first and the last position, with thrust and hinges."""

from math import ceil

import numpy as np

from stability.analysis.large_motion import Position
from stability.model import BodyId, Brick
from stackdsl.checking.cases import Case
from stackdsl.report.large_motion import ending_text
from stackdsl.studies.large_motion import FollowedMotion
from stackdsl.viewing.drawing import (
    VIEWS,
    DrawingArea,
    ScaleBar,
    Solid,
    State,
    brick_shapes,
    faces_of,
    ground_shapes,
    hinge_shape,
    rim_of,
    thrust_shapes,
)
from stackdsl.viewing.style import token
from stackdsl.viewing.svg import FAINT, INK, encoded, svg_of, text_at
from stackdsl.viewing.thrust import JointForces, Thrust, thrust_of

WIDE = 440.0  # [px] of a panel
MARGIN, HEAD, FOOT = 14.0, 62.0, 44.0  # [px]
BAR = 90.0  # [px] longest bar of a scale


def drawn_positions(found: FollowedMotion, case: Case, suffix: str) -> bytes:
    """Return the first and the last position, seen from the front, as `.svg` or `.png`.

    Raises ModuleNotFoundError without resvg for `.png`.
    """
    view, bricks = VIEWS["front"], {each.brick.id: each.brick for each in case.timeline.placements}
    shown = [found.motion.positions[0], found.motion.positions[-1]]
    solids = [_solids(position, bricks) for position in shown]
    corners = np.concatenate([view.on_paper(solid.corners) for each in solids for solid in each.values()])
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = (WIDE - 2.0 * MARGIN) / float((high - low).max())
    tall = float((high - low)[1]) * scale + MARGIN + FOOT
    shapes = [text_at(MARGIN, 26.0, found.case, colour=INK, font_size="16", font_weight="600")]
    shapes.append(text_at(MARGIN, 46.0, ending_text(found), colour=FAINT, font_size="13"))
    for number, (position, each) in enumerate(zip(shown, solids, strict=True)):
        area = DrawingArea(low - np.array((MARGIN, FOOT)) / scale, scale, WIDE, tall)
        grid = ScaleBar.of(view, scale, BAR).length
        faces = faces_of(each, dict.fromkeys(each, State.STANDS.colour), view, area)
        inner = [f'<rect width="100%" height="100%" fill="{token("scene")}"/>']
        inner += ground_shapes(case.timeline.world.planes, each.values(), view, area, grid)
        inner += brick_shapes(faces, rim_of(bricks.values(), scale))
        inner += thrust_shapes(_thrust(position), view, area)
        x = number * (WIDE + MARGIN)
        shapes += [f'<svg x="{x:.1f}" y="{HEAD:.1f}" width="{WIDE:g}" height="{tall:.1f}">', *inner, "</svg>"]
        text = f"{found.movement(position.amount):.4g} {found.unit}"
        shapes.append(text_at(x + MARGIN, HEAD + tall + 20.0, text, colour=INK, font_size="14"))
    y = HEAD + tall + 44.0
    line = f'<path d="M0 6H24" stroke="{token("fail")}" stroke-width="2.5"/>'
    shapes += [f'<g transform="translate({MARGIN:g} {y - 10.0:.1f})">{line}</g>']
    shapes.append(text_at(MARGIN + 30.0, y, "line of thrust", font_size="14"))
    shapes += [f'<g transform="translate({MARGIN + 150.0:g} {y - 10.0:.1f})">{hinge_shape(6.0, 6.0)}</g>']
    shapes.append(text_at(MARGIN + 168.0, y, "hinge", font_size="14"))
    wide = max(2.0 * WIDE + MARGIN, 0.0)
    return encoded(svg_of(ceil(wide), ceil(y + MARGIN), shapes), suffix)


def _solids(position: Position, bricks: dict[BodyId, Brick]) -> dict[BodyId, Solid]:
    return {name: Solid.of(bricks[name].shape, pose) for name, pose in position.poses.items()}


def _thrust(position: Position) -> Thrust:
    """Return the line of thrust of a position, with its open joints as hinges."""
    joints = [JointForces(*pair, (point,), (force,)) for pair, (force, point) in position.pressures.items()]
    hinges = tuple((hinge.upper, hinge.point_W) for hinge in position.hinges)
    return Thrust(thrust_of(joints, position.poses.keys()).lines, hinges)
