"""Draws a scene as SVG shapes, by parallel projection and in painter's order."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from math import hypot
from typing import Final
from xml.sax.saxutils import escape

import numpy as np

from stability.geometry.rows import Array, cross_rows
from stability.geometry.vectors import rotate
from stability.model import BodyId, ConvexShape, Pose
from stability.work_limit import add_work
from stackdsl.trace import EventKind
from stackdsl.viewing.run_view import RunView, ShownProof

# Views: parallel projections, without perspective.


@dataclass(frozen=True)
class View:
    """A direction of view."""

    name: str
    towards: Array  # (3,) unit vector to the viewer
    right: Array  # (3,) unit vector, to the right on paper
    up: Array  # (3,) unit vector, upwards on paper

    @classmethod
    def of(cls, name: str, towards: tuple[float, float, float], up: tuple[float, float, float]) -> "View":
        """Return the view from a direction, with another one upwards on paper; both of any length."""
        to = np.array(towards) / np.linalg.norm(towards)
        right = np.cross(up, to)
        right /= np.linalg.norm(right)
        return cls(name, to, right, np.cross(to, right))

    def on_paper(self, points_W: Array) -> Array:
        """Project points (n, 3) in W to (n, 2) on paper, right and up [m]."""
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


# Painter's order: solids behind are painted before those in front. The order is exact.
#
# Two convex solids that do not overlap are separated by a plane, and the one on its far side is painted first. Only
# pairs that overlap on paper need this test. If three or more solids cover each other in a cycle, no order of whole
# solids is right; the farthest is painted first.


TOUCHING = 1e-6  # share of a solid's size by which two may overlap and still count as separated
PARALLEL = 1e-6  # sine of the angle below which two edges are parallel
COMPARED, SWEPT = 250.0, 0.3  # units of work for a pair of solids that overlap on paper, and in x alone
FLAT = 1e-9  # cosine deviation below which two directions are equal


@dataclass(frozen=True)
class Solid:
    """The geometry of a placed brick."""

    corners: Array  # (n, 3) in W [m]
    normals: Array  # (faces, 3) in W, unit, outwards
    edges: Array  # (directions, 3) in W, unit
    faces: tuple[tuple[int, ...], ...]  # indices of corners

    @classmethod
    def of(cls, shape: ConvexShape, pose: Pose) -> "Solid":
        """Return the solid of a shape at a pose."""
        corners = np.array([rotate(pose.orientation, corner) for corner in shape.corners]) + pose.position_W
        normals = np.array([rotate(pose.orientation, face.normal) for face in shape.faces])
        edges = np.array([corners[b] - corners[a] for a, b in shape.edges])
        edges /= np.linalg.norm(edges, axis=1, keepdims=True)
        return cls(corners, normals, _different(edges), tuple(face.corners for face in shape.faces))


def painters_order(solids: Sequence[Solid], view: View) -> list[int]:
    """Return the indices of solids in the order in which they are painted. Raises TooMuchWorkError."""
    behind: list[set[int]] = [set() for _ in solids]  # solids to paint before each
    covers: list[list[int]] = [[] for _ in solids]
    for a, b in _on_each_other(solids, view):
        add_work(COMPARED)
        way = _in_front(solids[a], solids[b], view)
        if way:
            first, last = (a, b) if way > 0 else (b, a)
            behind[last].add(first)
            covers[first].append(last)
    return _sorted(behind, covers, [float((solid.corners @ view.towards).mean()) for solid in solids])


def _sorted(behind: list[set[int]], covers: list[list[int]], near: Sequence[float]) -> list[int]:
    """Sort topologically: a solid follows all those behind it; a cycle starts with the farthest."""
    waiting = set(range(len(behind)))
    ready: list[tuple[float, int]] = [(near[place], place) for place in waiting if not behind[place]]
    ready.sort()
    order = []
    while waiting:
        if not ready:
            heappush(ready, min((near[place], place) for place in _ring(behind, waiting)))
        _, place = heappop(ready)
        if place not in waiting:
            continue
        waiting.remove(place)
        order.append(place)
        for other in covers[place]:
            behind[other].discard(place)
            if not behind[other]:
                heappush(ready, (near[other], other))
    return order


def _ring(behind: Sequence[set[int]], waiting: set[int]) -> list[int]:
    """Return a cycle of solids that cover each other; every waiting solid has another one behind it."""
    path = [min(waiting)]
    while True:
        further = min(behind[path[-1]])
        if further in path:
            return path[path.index(further) :]
        path.append(further)


def _on_each_other(solids: Sequence[Solid], view: View) -> Iterator[tuple[int, int]]:
    """Yield pairs whose bounding boxes on paper overlap, by a sweep from left to right."""
    if not solids:
        return
    low = np.array([view.on_paper(solid.corners).min(axis=0) for solid in solids])
    high = np.array([view.on_paper(solid.corners).max(axis=0) for solid in solids])
    slack = TOUCHING * float((high - low).max())
    order = np.argsort(low[:, 0], kind="stable")
    open_now: list[int] = []
    for place in order.tolist():
        add_work(SWEPT * len(open_now))
        open_now = [other for other in open_now if high[other, 0] > low[place, 0] + slack]
        for other in open_now:
            if min(high[other, 1], high[place, 1]) > max(low[other, 1], low[place, 1]) + slack:
                yield other, place
        open_now.append(place)


def _in_front(a: Solid, b: Solid, view: View) -> int:
    """Return 1 if b is in front of a, -1 if a is in front of b, 0 if neither covers the other.

    The decision uses the separating plane with the largest gap, so solids that overlap by rounding still have one.
    """
    slack = TOUCHING * float(np.ptp(a.corners, axis=0).max())
    if _room(a, b, _crossed(np.concatenate((a.edges, b.edges)), view.towards[None, :])).max() >= -slack:
        return 0  # a plane seen edge-on separates them on paper
    normals = np.concatenate((a.normals, -b.normals, _crossed(a.edges, b.edges)))
    room, faces = _room(a, b, normals), normals @ view.towards
    apart = room >= room.max() - slack
    return 1 if faces[np.argmax(np.where(apart, np.abs(faces), -1.0))] > 0.0 else -1


def _room(a: Solid, b: Solid, normals: Array) -> Array:
    """Return the gap between a and b along each direction [m]; negative if they overlap."""
    gap: Array = (b.corners @ normals.T).min(axis=0) - (a.corners @ normals.T).max(axis=0)
    return gap


def _crossed(a: Array, b: Array) -> Array:
    """Return the unit cross products of all pairs of edges, with both signs."""
    crossed = cross_rows(np.repeat(a, len(b), axis=0), np.tile(b, (len(a), 1)))
    length = np.linalg.norm(crossed, axis=1)
    crossed = crossed[length > PARALLEL] / length[length > PARALLEL][:, None]
    return np.concatenate((crossed, -crossed))


def _different(directions: Array) -> Array:
    """Return each direction once, regardless of sign."""
    unique: list[Array] = []
    for direction in directions:
        if not any(abs(abs(float(direction @ other)) - 1.0) < FLAT for other in unique):
            unique.append(direction)
    return np.array(unique)


# A run at one time as shapes on paper: bricks in painter's order, the ground, and the forces of the proof.


HELD, AWAKE, RIDING, FALLEN, THROWN = "#dcbd8f", "#6fb9e8", "#35ab85", "#e0763a", "#cf8fb4"
EDGE, GROUND, FORCE = "#4d4536", "#8a8577", "#c4232b"
LIGHT = (-0.35, -0.6, 0.72)  # direction to the light
LONGEST = 0.6  # length of the arrow of the largest force, in longest sides of the bricks
EDGE_ON = 1e-6  # cosine below which a plane counts as seen edge-on
SHORTEST = 3.0  # [px] least length of an arrow; a force along the view has none
SMALLEST = 0.01  # share of the largest force below which no arrow is drawn


@dataclass(frozen=True)
class Frame:
    """The view and time of a drawing."""

    view: View
    time: float  # [s]
    forces: bool = False


@dataclass(frozen=True)
class DrawingArea:
    """The part of the plane of projection that is drawn, and its scale."""

    low: Array  # (2,) corner at the bottom left [m]
    scale: float  # [px/m]
    height: float  # [px]

    def place(self, points: Array) -> Array:
        """Map points (n, 2) of the plane of projection to the paper, from its top left [px]."""
        at = (points - self.low) * self.scale
        return np.column_stack((at[:, 0], self.height - at[:, 1]))


def solids_at(run: RunView, time: float) -> dict[BodyId, Solid]:
    """Return the bricks that are present at a time [s]."""
    poses = run.recording.at(time)
    solids = {}
    for number, brick in enumerate(run.recording.bricks):
        if not np.isnan(poses.positions[number, 0]):
            x, y, z = poses.positions[number].tolist()
            pose = Pose((x, y, z), tuple(poses.orientations[number].tolist()))
            solids[brick.id] = Solid.of(brick.shape, pose)
    return solids


def drawn(run: RunView, frame: Frame, paper: DrawingArea) -> Iterator[str]:
    """Yield SVG elements, from the back to the front."""
    solids = solids_at(run, frame.time)
    yield from _ground(run, frame.view, paper)
    names, colours = list(solids), Colours(run, frame.time)
    for place in painters_order(list(solids.values()), frame.view):
        name = names[place]
        yield from _brick(solids[name], colours.of(name), frame.view, paper, name)
    if frame.forces:
        proof = next((proof for proof in run.proofs.standing if proof.begin <= frame.time < proof.end), None)
        if proof is not None:
            yield from _forces(run, proof, frame.view, paper)


class Colours:
    """Colours of bricks by their state at a time."""

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
        """Return the colour of a brick."""
        left_at = self._run.trace.tracks[brick].left_at
        if left_at is not None and self._time >= left_at:
            return FALLEN
        return THROWN if brick in self._hitting else self._states.get(brick, AWAKE)


def _brick(solid: Solid, colour: str, view: View, paper: DrawingArea, name: BodyId) -> Iterator[str]:
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


def _ground(run: RunView, view: View, paper: DrawingArea) -> Iterator[str]:
    """Yield planes seen edge-on, as lines across the paper."""
    for plane in run.timeline.world.planes:
        normal = np.array(plane.normal_W)
        if abs(normal @ view.towards) > EDGE_ON:
            continue
        along = np.cross(normal, view.towards)
        ends = np.array(plane.point_W) + np.outer((-1e3 / paper.scale, 1e3 / paper.scale), along)
        (x1, y1), (x2, y2) = paper.place(view.on_paper(ends))
        yield f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{GROUND}"/>'


def _forces(run: RunView, proof: ShownProof, view: View, paper: DrawingArea) -> Iterator[str]:
    """Yield arrows at contact points, with lengths in proportion to the forces."""
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
