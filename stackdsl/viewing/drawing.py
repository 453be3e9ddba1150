"""Draws a scene as flat shapes: parallel projection and painter's order."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import product
from math import hypot
from typing import Final
from xml.sax.saxutils import escape

import numpy as np

from stability.geometry.rows import Array
from stability.geometry.vectors import rotate
from stability.model import BodyId, ConvexShape, Pose
from stackdsl.trace import EventKind
from stackdsl.viewing.run_view import RunView, ShownProof

# From where a scene is looked at, and where its points are on paper: parallel projections, without perspective.


@dataclass(frozen=True)
class View:
    """A direction to look from."""

    name: str
    towards: Array  # (3,) unit, to who looks
    right: Array  # (3,) unit
    up: Array  # (3,) unit

    @classmethod
    def of(cls, name: str, towards: tuple[float, float, float], up: tuple[float, float, float]) -> "View":
        """Looked at from a direction of any length, with another one upwards on paper."""
        to = np.array(towards) / np.linalg.norm(towards)
        right = np.cross(up, to)
        right /= np.linalg.norm(right)
        return cls(name, to, right, np.cross(to, right))

    def on_paper(self, points_W: Array) -> Array:
        """Points (n, 3) in W to (n, 2) on paper, right and up [m]."""
        return points_W @ np.column_stack((self.right, self.up))


VIEWS: Final = {
    view.name: view
    for view in (
        View.of("three-quarter", (0.75, -1.0, 0.55), (0.0, 0.0, 1.0)),
        View.of("front", (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
        View.of("side", (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        View.of("plan", (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    )
}


# Which solids are painted first, so that none that is behind covers one in front of it: painter's order, exactly.
#
# Two convex solids that do not overlap have a plane between them, and whoever is on its far side is painted first. Only
# pairs that cover each other on paper need one. Where three or more cover each other in a ring, no order is right for
# whole solids; the farthest of them goes first.


TOUCHING = 1e-6  # share of a solid's size by which two may overlap and still have a plane between them
PARALLEL = 1e-6  # sine of the angle between two edges that span no plane
FLAT = 1e-9  # of the direction to who looks along the normal of a plane that is seen edge-on


@dataclass(frozen=True)
class Solid:
    """A brick in its place."""

    corners: Array  # (n, 3) in W [m]
    normals: Array  # (faces, 3) in W, unit, outwards
    edges: Array  # (directions, 3) in W, unit
    faces: tuple[tuple[int, ...], ...]  # places among the corners

    @classmethod
    def of(cls, shape: ConvexShape, pose: Pose) -> "Solid":
        """A shape in a pose."""
        corners = np.array([rotate(pose.orientation, corner) for corner in shape.corners]) + pose.position_W
        normals = np.array([rotate(pose.orientation, face.normal) for face in shape.faces])
        edges = np.array([corners[b] - corners[a] for a, b in shape.edges])
        edges /= np.linalg.norm(edges, axis=1, keepdims=True)
        return cls(corners, normals, _different(edges), tuple(face.corners for face in shape.faces))


def painters_order(solids: Sequence[Solid], view: View) -> list[int]:
    """The places of solids, from the first that is painted to the last."""
    behind: list[set[int]] = [set() for _ in solids]  # who is painted before each
    covers: list[list[int]] = [[] for _ in solids]
    for a, b in _on_each_other(solids, view):
        way = _in_front(solids[a], solids[b], view)
        if way:
            first, last = (a, b) if way > 0 else (b, a)
            behind[last].add(first)
            covers[first].append(last)
    return _sorted(behind, covers, [float((solid.corners @ view.towards).mean()) for solid in solids])


def _sorted(behind: list[set[int]], covers: list[list[int]], near: Sequence[float]) -> list[int]:
    """Those with nobody unpainted behind them first; of a ring the farthest."""
    waiting = set(range(len(behind)))
    ready: list[tuple[float, int]] = [(near[place], place) for place in waiting if not behind[place]]
    ready.sort()
    found = []
    while waiting:
        if not ready:
            heappush(ready, min((near[place], place) for place in _ring(behind, waiting)))
        _, place = heappop(ready)
        if place not in waiting:
            continue
        waiting.remove(place)
        found.append(place)
        for other in covers[place]:
            behind[other].discard(place)
            if not behind[other]:
                heappush(ready, (near[other], other))
    return found


def _ring(behind: Sequence[set[int]], waiting: set[int]) -> list[int]:
    """Some that cover each other in a ring, of those that all have somebody behind them."""
    way = [min(waiting)]
    while True:
        further = min(behind[way[-1]])
        if further in way:
            return way[way.index(further) :]
        way.append(further)


def _on_each_other(solids: Sequence[Solid], view: View) -> Iterator[tuple[int, int]]:
    """Pairs whose boxes on paper overlap, by a sweep from the left to the right."""
    if not solids:
        return
    low = np.array([view.on_paper(solid.corners).min(axis=0) for solid in solids])
    high = np.array([view.on_paper(solid.corners).max(axis=0) for solid in solids])
    slack = TOUCHING * float((high - low).max())
    order = np.argsort(low[:, 0], kind="stable")
    open_now: list[int] = []
    for place in order.tolist():
        open_now = [other for other in open_now if high[other, 0] > low[place, 0] + slack]
        for other in open_now:
            if min(high[other, 1], high[place, 1]) > max(low[other, 1], low[place, 1]) + slack:
                yield other, place
        open_now.append(place)


def _in_front(a: Solid, b: Solid, view: View) -> int:
    """1 if b is in front of a, -1 if a is in front of b, 0 if neither covers the other.

    Of the planes between them, that with most room: so what overlaps by a rounding still has one.
    """
    slack = TOUCHING * float(np.ptp(a.corners, axis=0).max())
    if _room(a, b, _crossed(np.concatenate((a.edges, b.edges)), view.towards[None, :])).max() >= -slack:
        return 0  # a plane that is seen edge-on keeps them apart on paper
    normals = np.concatenate((a.normals, -b.normals, _crossed(a.edges, b.edges)))
    room, faces = _room(a, b, normals), normals @ view.towards
    apart = room >= room.max() - slack
    return 1 if faces[np.argmax(np.where(apart, np.abs(faces), -1.0))] > 0.0 else -1


def _room(a: Solid, b: Solid, normals: Array) -> Array:
    """How far b begins beyond a along each direction [m]; negative where they overlap."""
    found: Array = (b.corners @ normals.T).min(axis=0) - (a.corners @ normals.T).max(axis=0)
    return found


def _crossed(a: Array, b: Array) -> Array:
    """The directions across an edge of each, both ways."""
    crossed = np.array([np.cross(first, second) for first, second in product(a, b)])
    length = np.linalg.norm(crossed, axis=1)
    crossed = crossed[length > PARALLEL] / length[length > PARALLEL][:, None]
    return np.concatenate((crossed, -crossed))


def _different(directions: Array) -> Array:
    """Directions, each once, whichever way it points."""
    found: list[Array] = []
    for direction in directions:
        if not any(abs(abs(float(direction @ other)) - 1.0) < FLAT for other in found):
            found.append(direction)
    return np.array(found)


# A run at a time as shapes on paper: its bricks in painter's order, the ground, and the forces of the proof.


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

    low: Array  # (2,) the corner at the bottom left [m]
    scale: float  # [px/m]
    height: float  # [px]

    def place(self, points: Array) -> Array:
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


def _lit(colour: str, normal: Array) -> str:
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
