"""A run at a time as shapes on paper: its bricks in painter's order, the ground, and the forces of the proof."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot
from xml.sax.saxutils import escape

import numpy as np

from stability.model import BodyId, Pose
from stackdsl.trace import EventKind
from stackdsl.viewing.pictures.painting import Solid, painters_order
from stackdsl.viewing.pictures.views import Floats, View
from stackdsl.viewing.run_view import RunView
from stackdsl.viewing.shown_proofs import ShownProof

HELD, AWAKE, RIDING, FALLEN, THROWN = "#dcbd8f", "#6fb9e8", "#35ab85", "#e0763a", "#cf8fb4"
EDGE, GROUND, FORCE = "#4d4536", "#8a8577", "#c4232b"
LIGHT = (-0.35, -0.6, 0.72)  # where light comes from; what it does not meet has half of it
LONGEST = 0.6  # of the arrow of the largest force, in the longest side of the bricks
EDGE_ON = 1e-6  # of a unit normal along the direction to who looks
SHORTEST = 3.0  # [px] of an arrow; what points to who looks has no length
SMALLEST = 0.01  # share of the largest force below which no arrow is drawn


@dataclass(frozen=True)
class Frame:
    """What is drawn of a run, and how."""

    view: View
    time: float  # [s]
    forces: bool = False


@dataclass(frozen=True)
class Paper:
    """Which part of the plane of projection is on the paper, and how large."""

    low: Floats  # (2,) the corner at the bottom left [m]
    scale: float  # [px/m]
    height: float  # [px]

    def place(self, points: Floats) -> Floats:
        """Points (n, 2) of the plane of projection on the paper, from its top left [px]."""
        at = (points - self.low) * self.scale
        return np.column_stack((at[:, 0], self.height - at[:, 1]))


def solids_at(run: RunView, time: float) -> dict[BodyId, Solid]:
    """The bricks that are there at a time [s]."""
    poses = run.recording.at(time)
    found = {}
    for number, brick in enumerate(run.recording.bricks):
        if not np.isnan(poses.positions[number, 0]):
            x, y, z = poses.positions[number].tolist()
            pose = Pose((x, y, z), tuple(poses.orientations[number].tolist()))
            found[brick.id] = Solid.of(brick.shape, pose)
    return found


def drawn(run: RunView, frame: Frame, paper: Paper) -> Iterator[str]:
    """The shapes of SVG, from the back to the front."""
    solids = solids_at(run, frame.time)
    yield from _ground(run, frame.view, paper)
    names, colours = list(solids), Colours(run, frame.time)
    for place in painters_order(list(solids.values()), frame.view):
        name = names[place]
        yield from _brick(solids[name], colours.of(name), frame.view, paper, name)
    if frame.forces:
        proof = next((one for one in run.proofs.standing if one.begin <= frame.time < one.end), None)
        if proof is not None:
            yield from _forces(run, proof, frame.view, paper)


class Colours:
    """What bricks are coloured by: their state at a time."""

    def __init__(self, run: RunView, time: float) -> None:
        self._run, self._time = run, time
        self._hitting = {placement.brick.id for placement in run.timeline.placements if placement.hits}
        self._states: dict[BodyId, str] = {}
        for event in run.trace.events:
            if event.time > time:
                break
            if event.kind is EventKind.FROZEN:
                self._states |= dict.fromkeys(event.bricks, HELD)
            elif event.kind is EventKind.WOKEN:
                self._states |= dict.fromkeys(event.bricks, AWAKE) | dict.fromkeys(event.riding, RIDING)

    def of(self, brick: BodyId) -> str:
        """The colour of a brick."""
        left_at = self._run.trace.tracks[brick].left_at
        if left_at is not None and self._time >= left_at:
            return FALLEN
        return THROWN if brick in self._hitting else self._states.get(brick, AWAKE)


def _brick(solid: Solid, colour: str, view: View, paper: Paper, name: BodyId) -> Iterator[str]:
    on_paper = paper.place(view.on_paper(solid.corners))
    paths = []
    for normal, face in zip(solid.normals, solid.faces, strict=True):
        if normal @ view.towards > EDGE_ON:
            points = " ".join(f"{x:.1f},{y:.1f}" for x, y in on_paper[list(face)])
            paths.append(f'<polygon points="{points}" fill="{_lit(colour, normal)}"/>')
    yield f"<g><title>{escape(name)}</title>{''.join(paths)}</g>"


def _lit(colour: str, normal: Floats) -> str:
    light = 0.72 + 0.28 * float(normal @ np.array(LIGHT)) / float(np.linalg.norm(LIGHT))
    parts = (min(255, round(light * int(colour[at : at + 2], 16))) for at in (1, 3, 5))
    return "#" + "".join(f"{part:02x}" for part in parts)


def _ground(run: RunView, view: View, paper: Paper) -> Iterator[str]:
    """Planes that are seen edge-on, as lines across the paper."""
    for plane in run.timeline.world.planes:
        normal = np.array(plane.normal_W)
        if abs(normal @ view.towards) > EDGE_ON:
            continue
        along = np.cross(normal, view.towards)
        ends = np.array(plane.point_W) + np.outer((-1e3 / paper.scale, 1e3 / paper.scale), along)
        (x1, y1), (x2, y2) = paper.place(view.on_paper(ends))
        yield f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{GROUND}"/>'


def _forces(run: RunView, proof: ShownProof, view: View, paper: Paper) -> Iterator[str]:
    """Arrows from where bodies press on each other, each as long as its force beside the largest."""
    pairs = [
        (point, force)
        for contact in proof.contacts
        for point, force in zip(contact.points_W, contact.forces_W, strict=True)
    ]
    most = max((float(np.linalg.norm(force)) for _, force in pairs), default=0.0)
    longest = LONGEST * max(brick.shape.length for brick in run.recording.bricks)
    for point, force in pairs:
        if np.linalg.norm(force) <= SMALLEST * most:
            continue
        ends = np.array([point, np.array(point) + np.array(force) * longest / most])
        (x1, y1), (x2, y2) = paper.place(view.on_paper(ends))
        if hypot(x2 - x1, y2 - y1) < SHORTEST:
            continue
        yield (
            f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{FORCE}" stroke-width="1.6" '
            'marker-end="url(#tip)"/>'
        )
