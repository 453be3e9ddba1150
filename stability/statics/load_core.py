"""The load core of a brick: the region in plan where the bricks below carry any vertical load to the ground.

K(plane) is the whole plane. K(brick) is the convex hull of the intersections of its contact patches with the cores of
the bodies below. A load inside K is a convex combination of loads inside the cores of the bodies below, and so on down
to the ground: vertical pushing forces within the friction cones. Forces are additive, so such a load does not affect
the support of other loads, and a brick with its centre of mass inside its core may be added to any assembly that
stands. Bricks above are not used, so stepped and counterweighted stacks need another proof.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot
from typing import TypeAlias

from stability.geometry.polygons import Point2, Polygon, clip, clip_line, depth, doubled_area, extent, holds, hull
from stability.model import BodyId
from stability.problem import Contact

UPRIGHT = 1e-12  # slack of a unit normal's slope against friction: rounding error of its components
USUAL = 2  # typical number of supports of a brick
ON_THE_BORDER = 1e-12  # share of a core's extent: nearer to the border, rounding decides between inside and outside


Pieces: TypeAlias = Sequence[tuple[Contact, tuple[Point2, ...]]]  # the part of each contact: patch, line or point


@dataclass(slots=True, eq=False)
class LoadCore:
    """Core of one brick; empty if nothing below carries it. Its pieces and its hull are computed on first use."""

    _below: "Sequence[tuple[Contact, LoadCore | None]]"  # supports with the cores below; None for a fixed body
    _pieces: Pieces | None = None
    _polygon: Polygon | None = None
    _slack: float = 0.0  # [m]

    def __reduce__(self) -> tuple[object, ...]:
        """Return the core without those below, of which there may be too many for pickle's recursion."""
        return LoadCore, ((), self.pieces, self._polygon, self._slack)

    @property
    def pieces(self) -> Pieces:
        """Return the part of each contact that the core below carries."""
        waiting = [self] if self._pieces is None else []
        while waiting:
            core = waiting[-1]
            unknown = next((each for _, each in core._below if each is not None and each._pieces is None), None)
            if unknown is not None:
                waiting.append(unknown)
                continue
            parts = ((contact, piece(plan(contact), below)) for contact, below in core._below)
            core._pieces = [(contact, points) for contact, points in parts if points]
            core._below = ()
            waiting.pop()
        assert self._pieces is not None
        return self._pieces

    @property
    def polygon(self) -> Polygon:
        """Return the core in plan [m]."""
        if self._polygon is None:
            self._polygon = _hull_of(self.pieces)
            self._slack = ON_THE_BORDER * extent(self._polygon) if self._polygon else 0.0
        return self._polygon

    @property
    def slack(self) -> float:
        """Return the distance outside the core up to which a point counts as on the border [m]."""
        return self._slack if self.polygon else 0.0

    def carries(self, point: Point2) -> bool:
        """Return whether a vertical load at a point in plan is carried to the ground."""
        if self._polygon is None and len(self.pieces) == USUAL:
            (_, one), (_, other) = self.pieces
            if _is_amid(point, one, other):
                return True
        return bool(self.polygon) and depth(point, self.polygon) >= -self._slack


def _is_amid(point: Point2, one: Sequence[Point2], other: Sequence[Point2]) -> bool:
    """Return whether a point lies on the line between the middles of two pieces: then it is inside without a hull."""
    px, py = point
    ax, ay = sum([x for x, _ in one]) / len(one) - px, sum([y for _, y in one]) / len(one) - py
    bx, by = sum([x for x, _ in other]) / len(other) - px, sum([y for _, y in other]) / len(other) - py
    dx, dy = bx - ax, by - ay
    return abs(ax * by - ay * bx) <= ON_THE_BORDER * (dx * dx + dy * dy) and ax * bx + ay * by <= 0.0


def _hull_of(pieces: Pieces) -> Polygon:
    if len(pieces) == 1:  # already a polygon, if it has an area
        points = pieces[0][1]
        return points if len(points) > 2 else ()  # noqa: PLR2004 -- a polygon has three corners
    return hull(point for _, points in pieces for point in points)


def carries_upright(contact: Contact) -> bool:
    """Return whether the contact bears vertical forces of any size from the lower body on the upper one."""
    return upright_normal(contact) is not None


def upright_normal(contact: Contact) -> int | None:
    """Return the index of a normal whose cone has vertical forces of any size and that opens on lifting; or None.

    None if the law is no cone, since proofs by vertical forces add forces. With friction above 1 a contact may be so
    steep that lifting the body does not open it: then vertical forces may be self-stress, which other stages check.
    """
    law = contact.law
    if not law.is_cone:
        return None
    for index, (nx, ny, nz) in enumerate(contact.normals_W):
        if nx == 0.0 and ny == 0.0 and nz > 0.0:
            return index
        # not from nz, which is 1 in floating point for all normals that are tilted by less than 1e-8
        across = hypot(nx, ny)
        if nz > 0.0 and across <= law.greatest_friction(nz) + UPRIGHT and law.shortfall(nz, across) < 0.0:
            return index
    return None


def plan(contact: Contact) -> tuple[Point2, ...]:
    """Return the points of a contact in plan; a patch runs counter-clockwise, or is a line if it is vertical."""
    points = tuple([(x, y) for x, y, _ in contact.points_W])
    if len(points) < 3:  # noqa: PLR2004 -- a patch has three corners
        return points
    area, reach = doubled_area(points)
    if abs(area) > UPRIGHT * reach * reach:
        return points if area > 0.0 else points[::-1]
    return hull(points) or _ends(points)


def _ends(points: Sequence[Point2]) -> tuple[Point2, ...]:
    return (min(points), max(points))


def piece(points: tuple[Point2, ...], below: LoadCore | None) -> tuple[Point2, ...]:
    """Return the part of a contact over the core of the body below; None is the core of a fixed body."""
    if below is None:
        return points
    if len(points) > 2:  # noqa: PLR2004 -- a patch
        return points if holds(below.polygon, points, below.slack) else clip(points, below.polygon)
    if len(points) == 2:  # noqa: PLR2004 -- a line
        return clip_line(points, below.polygon, below.slack)
    return points if points and below.carries(points[0]) else ()


def core_of(supports: Sequence[Contact], cores: Mapping[BodyId, LoadCore]) -> LoadCore:
    """Return the core of a brick from its supporting contacts and the cores of the bricks below.

    A body without a core is fixed; the supports must not include a brick whose core is not known yet.
    """
    return LoadCore([(contact, cores.get(contact.lower)) for contact in supports])
