"""Which solids are painted first, so that none that is behind covers one in front of it: painter's order, exactly.

Two convex solids that do not overlap have a plane between them, and whoever is on its far side is painted first. Only
pairs that cover each other on paper need one. Where three or more cover each other in a ring, no order is right for
whole solids; the farthest of them goes first.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import product

import numpy as np

from stability.geometry.rotations import rotate
from stability.model import ConvexShape, Pose
from stackdsl.viewing.pictures.views import Floats, View

TOUCHING = 1e-6  # share of a solid's size by which two may overlap and still have a plane between them
PARALLEL = 1e-6  # sine of the angle between two edges that span no plane
FLAT = 1e-9  # of the direction to who looks along the normal of a plane that is seen edge-on


@dataclass(frozen=True)
class Solid:
    """A brick in its place."""

    corners: Floats  # (n, 3) in W [m]
    normals: Floats  # (faces, 3) in W, unit, outwards
    edges: Floats  # (directions, 3) in W, unit
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


def _room(a: Solid, b: Solid, normals: Floats) -> Floats:
    """How far b begins beyond a along each direction [m]; negative where they overlap."""
    found: Floats = (b.corners @ normals.T).min(axis=0) - (a.corners @ normals.T).max(axis=0)
    return found


def _crossed(a: Floats, b: Floats) -> Floats:
    """The directions across an edge of each, both ways."""
    crossed = np.array([np.cross(first, second) for first, second in product(a, b)])
    length = np.linalg.norm(crossed, axis=1)
    crossed = crossed[length > PARALLEL] / length[length > PARALLEL][:, None]
    return np.concatenate((crossed, -crossed))


def _different(directions: Floats) -> Floats:
    """Directions, each once, whichever way it points."""
    found: list[Floats] = []
    for direction in directions:
        if not any(abs(abs(float(direction @ other)) - 1.0) < FLAT for other in found):
            found.append(direction)
    return np.array(found)
