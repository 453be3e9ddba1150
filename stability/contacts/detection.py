"""Finds the contacts of bodies from their poses and shapes: the entry to all contact detection."""

from operator import itemgetter

from stability.contact_law import Coulomb
from stability.contacts.bodies import BoxSolid, HullSolid, Solid, rounding, solid
from stability.contacts.box_contacts import (
    LEVEL,
    BoxCloseness,
    FeatureContact,
    PointsOnPlane,
    Slack,
    closeness,
    disturbance,
    face_on_face,
    level_patch,
    meeting,
    points_on_plane,
    side_patch,
)
from stability.contacts.gap_bridging import all_bridged, gaps_of, run_flush
from stability.geometry.box_distance import NO_GAP, gap_bridged, reach_between
from stability.geometry.vectors import scale
from stability.model import Plane, Vec3
from stability.problem import Contact, Tolerances

__all__ = ["Solid", "contact_between", "contact_with_plane", "solid"]

# Share of the gap tolerance that noise may displace an edge sideways before it is another edge: 0.08 mm for a plank of
# 7.8 mm, where engines leave 0.01 mm and turns of up to a thousandth, which move the end of a short edge by 0.05 mm.
SIDEWAYS = 0.5
UP_ONLY: tuple[Vec3, ...] = ((0.0, 0.0, 1.0),)


def contact_between(a: Solid, b: Solid, friction: float, tolerances: Tolerances) -> Contact | None:
    """The contact of two bodies; None if they do not touch. The same whichever comes first."""
    reach = reach_between(a.shortest, b.shortest, tolerances.gap)
    if _boxes_apart(a, b, reach):
        return None
    if not (isinstance(a, BoxSolid) and isinstance(b, BoxSolid)):
        from stability.contacts.hull_contacts import hull_contact  # noqa: PLC0415 -- boxes do without numpy

        return hull_contact(a, b, friction, reach, tolerances.within)
    lower, upper = (a, b) if a.pose.position_W[2] <= b.pose.position_W[2] else (b, a)
    within = tolerances.within
    level = level_patch(lower, upper, reach, within)
    if level is not None:
        points, gap = level
        gaps = (gap,) * len(points) if gap > NO_GAP * reach else ()
        return Contact(lower.id, upper.id, points, UP_ONLY, Coulomb(friction), gaps) if points else None
    a, b = (b, a) if a.id > b.id else (a, b)
    side = side_patch(a, b, reach, within)
    if side is None:
        return _general_contact(a, b, friction, reach, within)
    points, normal, gap = side
    gaps = (gap,) * len(points) if gap > NO_GAP * reach else ()
    return Contact(a.id, b.id, points, (normal,), Coulomb(friction), gaps) if points else None


def contact_with_plane(a: Solid, plane: Plane, tolerances: Tolerances, friction: float | None = None) -> Contact | None:
    """The contact of a body with a fixed half-space, which counts as the lower body whichever way it faces.

    `friction` is that of this body on it, where it is another than the plane's own.
    """
    reach = reach_between(a.shortest, share=tolerances.gap)
    widest = gap_bridged(reach, plane.normal_W[2], tolerances.within)
    if isinstance(a, BoxSolid):
        points, heights = points_on_plane(a, plane, reach, widest)
    else:
        points, heights = _hull_on_plane(a, plane, reach, widest)
    if not points:
        return None
    mu = plane.friction if friction is None else friction
    return Contact(plane.id, a.id, points, (plane.normal_W,), Coulomb(mu), gaps_of(heights, reach))


def flush_within(a: Solid, b: Solid, reach: float, overlap: float) -> bool:
    """Whether two bodies that touch would carry nothing if they overlapped by `overlap` less [m]."""
    if isinstance(a, BoxSolid) and isinstance(b, BoxSolid):
        close = closeness(a, b, reach)
        return close is not None and run_flush(close.faces(), overlap)
    from stability.contacts.hull_contacts import hulls_flush  # noqa: PLC0415 -- boxes do without numpy

    return hulls_flush(a, b, reach, overlap)


def _hull_on_plane(body: HullSolid, plane: Plane, reach: float, widest: float) -> PointsOnPlane:
    from stability.contacts.hull_contacts import hull_on_plane  # noqa: PLC0415 -- boxes do without numpy

    return hull_on_plane(body, plane, reach, widest)


def _boxes_apart(a: Solid, b: Solid, reach: float) -> bool:
    """Whether the upright boxes around them are: what a pair that is not in contact costs."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz), (dx, dy, dz) = a.low_W, a.high_W, b.low_W, b.high_W
    return (
        cz - bz > reach or az - dz > reach or cx - bx > reach or ax - dx > reach or cy - by > reach or ay - dy > reach
    )


def _general_contact(a: BoxSolid, b: BoxSolid, friction: float, reach: float, within: float) -> Contact | None:
    """The contact of two boxes in any pose; a comes first by name."""
    close = closeness(a, b, reach)
    if close is None or run_flush(close.faces(), NO_GAP * reach) or not all_bridged(close.apart(), reach, within):
        return None
    off, exact = disturbance(close, max(a.longest, b.longest), reach), rounding(a, b)
    sideways = min(off, SIDEWAYS * reach) + exact
    patch = face_on_face(a, b, close, Slack(sideways, off + exact, reach, within))
    if patch:
        gaps = gaps_of(patch.heights, reach)
        return Contact(patch.lower.id, patch.upper.id, patch.points_W, (patch.normal_W,), Coulomb(friction), gaps)
    found = _best_meeting(a, b, close, Slack(sideways, off + exact, reach, within))
    # What a gap as wide as the tolerance has displaced further still touches.
    found = found or _best_meeting(a, b, close, Slack(reach, reach, reach, within))
    return _of_meeting(a, b, found, friction, gaps_of(found.gaps_beside(close.gap), reach)) if found else None


def _best_meeting(a: BoxSolid, b: BoxSolid, close: BoxCloseness, slack: Slack) -> FeatureContact | None:
    """The meeting along the axis of the largest gap along which features face each other; faces win near ties."""
    sideways = slack.sideways
    axes = [(axis.gap + sideways, axis) for axis in (*close.faces_a, *close.faces_b)]
    axes += [(axis.gap, axis) for axis in close.edges]
    for _, axis in sorted(axes, key=itemgetter(0), reverse=True):
        if axis.gap >= close.gap - 2.0 * sideways and axis.gap >= -slack.reach:
            found = meeting(a, b, axis, slack)
            if found:
                return found
    return None


def _of_meeting(a: BoxSolid, b: BoxSolid, found: FeatureContact, friction: float, gaps: tuple[float, ...]) -> Contact:
    upwards = sum(normal[2] for normal in found.normals_AB_W)
    if upwards >= -LEVEL:
        return Contact(a.id, b.id, found.points_W, found.normals_AB_W, Coulomb(friction), gaps)
    downwards = tuple(scale(-1.0, normal) for normal in found.normals_AB_W)
    return Contact(b.id, a.id, found.points_W, downwards, Coulomb(friction), gaps)
