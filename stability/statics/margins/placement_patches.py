"""Which contacts still carry after every brick was put down a little off its place, in plan.

A contact counts where vertical forces are admissible (its slope is less than its friction) on a patch that has area in
plan; lines and single points vanish with the first error. A brick that is put down off its place must still lie on all
that it lay on, so the faces on which it rests must be parallel: if they are not, only its level ones count.
"""

from collections.abc import Collection
from dataclasses import dataclass
from math import hypot

import numpy as np
from numpy.typing import NDArray

from stability.geometry.hulls import hull
from stability.geometry.plan import Point2, Polygon
from stability.model import BodyId, Vec3
from stability.statics.facts import Contact, Problem

LEVEL = 1e-6  # horizontal part of a unit normal up to which a face is level: a shift of 1 mm lifts a brick by 1 nm


@dataclass(frozen=True, slots=True, eq=False)
class PlanPatch:
    """A contact in plan: its border as lines, and how far each line comes in when bricks are off their places."""

    lower: BodyId
    upper: BodyId
    corners: Polygon  # [m]
    height: float  # mean z of the corners [m]
    friction: float
    level: bool
    moving: bool  # on a plane without end: the patch goes where its brick goes, and loses nothing
    inward: NDArray[np.float64]  # (edges, 2) unit normals of the border lines
    depth: NDArray[np.float64]  # (edges,) of `centre` behind them [m]

    @property
    def centre(self) -> Point2:
        """The mean of the corners."""
        xs, ys = zip(*self.corners, strict=True)
        return (sum(xs) / len(xs), sum(ys) / len(ys))

    @property
    def reach(self) -> float:
        """How far the corners lie from the centre, at most [m]."""
        x, y = self.centre
        return max(hypot(a - x, b - y) for a, b in self.corners)


def plan_patches(problem: Problem, planes: Collection[BodyId]) -> list[PlanPatch]:
    """The contacts that count, ordered by name and place so that no result depends on how they were listed."""
    steep = _on_unlike_faces(problem)
    patches = []
    for contact in problem.contacts:
        corners = hull((x, y) for x, y, _ in contact.points_W)
        if not corners or not _carries_upright(contact):
            continue
        if not _is_level(contact) and not steep.isdisjoint((contact.lower, contact.upper)):
            continue
        patches.append(_patch(contact, corners, planes))
    return sorted(patches, key=lambda patch: (patch.lower, patch.upper, patch.corners))


def _patch(contact: Contact, corners: Polygon, planes: Collection[BodyId]) -> PlanPatch:
    points = np.array(corners)
    along = np.roll(points, -1, axis=0) - points
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(along[:, 0], along[:, 1])[:, None]
    depth = ((points.mean(axis=0) - points) * inward).sum(axis=1)
    height = sum(point[2] for point in contact.points_W) / len(contact.points_W)
    return PlanPatch(
        contact.lower,
        contact.upper,
        corners,
        height,
        contact.friction,
        _is_level(contact),
        not {contact.lower, contact.upper}.isdisjoint(planes),
        inward,
        depth,
    )


def _carries_upright(contact: Contact) -> bool:
    """Whether a vertical force lies in the cone of its only normal."""
    (x, y, z), *others = contact.normals_W
    return not others and z > 0.0 and hypot(x, y) <= max(contact.friction, LEVEL) * z


def _is_level(contact: Contact) -> bool:
    x, y, _ = contact.normals_W[0]
    return hypot(x, y) <= LEVEL


def _on_unlike_faces(problem: Problem) -> set[BodyId]:
    """The bodies whose faces that carry are not parallel."""
    first: dict[BodyId, Vec3] = {}
    unlike: set[BodyId] = set()
    for contact in filter(_carries_upright, problem.contacts):
        normal = contact.normals_W[0]
        for body in (contact.lower, contact.upper):
            known = first.setdefault(body, normal)
            if body in problem.bricks and max(abs(a - b) for a, b in zip(normal, known, strict=True)) > LEVEL:
                unlike.add(body)
    return unlike
