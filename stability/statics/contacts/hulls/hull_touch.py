"""The contact of two bodies of which one at least is no box, and of a hull and a plane."""

from collections.abc import Iterator
from operator import itemgetter

import numpy as np

from stability.geometry.hulls import hull
from stability.geometry.polyhedra import Array, vector
from stability.geometry.touching import NO_GAP
from stability.geometry.vectors import cross, scale, unit
from stability.model import Plane
from stability.statics.contacts.bridging import all_bridged, gaps_of
from stability.statics.contacts.faces import LEVEL, Slack
from stability.statics.contacts.features import Meeting
from stability.statics.contacts.flush import run_flush
from stability.statics.contacts.hulls.hull_closeness import HullCloseness, closeness, disturbance
from stability.statics.contacts.hulls.hull_features import meeting_of_edges, meeting_on_face
from stability.statics.contacts.hulls.hull_patches import face_on_face
from stability.statics.contacts.on_planes import PointsOnPlane
from stability.statics.contacts.solids import HullSolid, Solid, as_hull, rounding
from stability.statics.facts import Contact

# Share of the gap tolerance that noise may displace an edge sideways before it is another edge.
SIDEWAYS = 0.5
ASKEW = 0.9  # cosine below which two directions span a plane well


def hull_contact(a: Solid, b: Solid, friction: float, reach: float, within: float) -> Contact | None:
    """The contact of two bodies whose upright boxes touch; None if they do not. The same whichever comes first."""
    if a.id > b.id:
        a, b = b, a
    close = closeness(as_hull(a), as_hull(b), reach)
    if close is None or run_flush(close.faces(), NO_GAP * reach) or not all_bridged(close.apart(), reach, within):
        return None
    off, exact = disturbance(close, reach), rounding(a, b)
    sideways = min(off, SIDEWAYS * reach) + exact
    slack = Slack(sideways, off + exact, reach, within)
    patch = face_on_face(close, slack, exact)
    if patch is not None:
        lower, upper = (a, b) if patch.a_is_lower else (b, a)
        gaps = gaps_of(patch.heights, reach)
        return Contact(lower.id, upper.id, patch.points_W, (patch.normal_W,), friction, gaps)
    found = _best_meeting(close, slack)
    # What a gap as wide as the tolerance has displaced further still touches.
    found = found or _best_meeting(close, Slack(reach, reach, reach, within))
    return _of_meeting(a, b, found, friction, gaps_of(found.gaps_beside(close.gap), reach)) if found else None


def hulls_flush(a: Solid, b: Solid, reach: float, overlap: float) -> bool:
    """Whether two bodies that touch would carry nothing if they overlapped by `overlap` less [m]."""
    close = closeness(as_hull(a), as_hull(b), reach)
    return close is not None and run_flush(close.faces(), overlap)


def _of_meeting(a: Solid, b: Solid, found: Meeting, friction: float, gaps: tuple[float, ...]) -> Contact:
    if sum(normal[2] for normal in found.normals_AB_W) >= -LEVEL:
        return Contact(a.id, b.id, found.points_W, found.normals_AB_W, friction, gaps)
    downwards = tuple(scale(-1.0, normal) for normal in found.normals_AB_W)
    return Contact(b.id, a.id, found.points_W, downwards, friction, gaps)


def _best_meeting(close: HullCloseness, slack: Slack) -> Meeting | None:
    """The meeting along the direction of the largest gap along which features face each other; faces win near ties."""
    sideways = slack.sideways
    for rank, kind, number in sorted(_directions(close, sideways), key=itemgetter(0), reverse=True):
        gap = rank if kind == "edges" else rank - sideways
        if gap < close.gap - 2.0 * sideways or gap < -slack.reach:
            continue
        if kind == "edges":
            found = meeting_of_edges(close, number, slack)
        else:
            found = meeting_on_face(close, kind == "a", number, slack)
        if found:
            return found
    return None


def _directions(close: HullCloseness, sideways: float) -> Iterator[tuple[float, str, int]]:
    for kind, gaps in (("a", close.gaps_a), ("b", close.gaps_b)):
        yield from ((gap + sideways, kind, number) for number, gap in enumerate(gaps.tolist()))
    yield from ((gap, "edges", number) for number, gap in enumerate(close.edges.gaps.tolist()))


def hull_on_plane(body: HullSolid, plane: Plane, reach: float, widest: float) -> PointsOnPlane:
    """The points of the plane that a hull touches, as `points_on_plane` gives those of a box."""
    own, normal = body.hull, np.array(plane.normal_W)
    height = float((np.array(own.p_WC) - np.array(plane.point_W)) @ normal)
    rises = own.heights(normal)
    gap = height + float(rises.min())
    if gap > widest or gap < -reach:
        return (), ()
    low = own.corners[rises + height <= widest]
    above = (low @ normal) + height
    on_plane = np.array(own.p_WC) + low - above[:, None] * normal
    around = _around(low, normal)
    return tuple(vector(on_plane[n]) for n in around), tuple(float(above[n]) for n in around)


def _around(points: Array, normal: Array) -> list[int]:
    """Of corners that lie in a plane up to the tolerance, those that bound them, in order: an area, a line, a point."""
    if len(points) <= 2:  # noqa: PLR2004 -- a line has two ends
        return list(range(len(points)))
    up = vector(normal)
    first = unit(cross((0.0, 1.0, 0.0) if abs(up[1]) < ASKEW else (1.0, 0.0, 0.0), up))
    flat = [(x, y) for x, y in (points @ np.array((first, cross(up, first))).T).tolist()]
    around = hull(flat)
    if around:
        return [flat.index(corner) for corner in around]
    apart = np.linalg.norm(points[:, None, :] - points[None, :, :], axis=2)
    one, other = np.unravel_index(int(apart.argmax()), apart.shape)
    return [int(one), int(other)]
