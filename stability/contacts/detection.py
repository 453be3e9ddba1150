"""Contacts of bodies from their poses and shapes: the entry point of contact detection."""

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
    feature_contact,
    level_patch,
    points_on_plane,
    side_patch,
)
from stability.contacts.gap_bridging import all_bridged, gaps_of, run_flush
from stability.geometry.box_distance import NO_GAP, gap_bridged, reach_between
from stability.geometry.vectors import scale
from stability.model import Plane, Vec3
from stability.problem import Contact, Tolerances

__all__ = ["Solid", "contact_between", "contact_with_plane", "solid"]

# Largest sideways offset of coinciding edges by noise, as a share of the gap tolerance: 0.08 mm for a plank of 7.8 mm.
# Engines leave offsets of 0.01 mm, and rotations of up to a thousandth, which move the end of a short edge by 0.05 mm.
SIDEWAYS = 0.5
UP_ONLY: tuple[Vec3, ...] = ((0.0, 0.0, 1.0),)


def contact_between(a: Solid, b: Solid, friction: float, tolerances: Tolerances) -> Contact | None:
    """Return the contact of two bodies, independent of their order; None if they do not touch."""
    reach = reach_between(a.shortest, b.shortest, tolerances.gap)
    if _bounds_apart(a, b, reach):
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
    """Return the contact of a body with a fixed half-space, which always counts as the lower body.

    `friction` replaces the plane's own coefficient.
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
    """Check that two touching bodies would transfer no force if they overlapped by `overlap` [m] less."""
    if isinstance(a, BoxSolid) and isinstance(b, BoxSolid):
        close = closeness(a, b, reach)
        return close is not None and run_flush(close.faces(), overlap)
    from stability.contacts.hull_contacts import hulls_flush  # noqa: PLC0415 -- boxes do without numpy

    return hulls_flush(a, b, reach, overlap)


def _hull_on_plane(body: HullSolid, plane: Plane, reach: float, widest: float) -> PointsOnPlane:
    from stability.contacts.hull_contacts import hull_on_plane  # noqa: PLC0415 -- boxes do without numpy

    return hull_on_plane(body, plane, reach, widest)


def _bounds_apart(a: Solid, b: Solid, reach: float) -> bool:
    """Check that the bounding boxes are apart, which decides most pairs without contact."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz), (dx, dy, dz) = a.low_W, a.high_W, b.low_W, b.high_W
    return (
        cz - bz > reach or az - dz > reach or cx - bx > reach or ax - dx > reach or cy - by > reach or ay - dy > reach
    )


def _general_contact(a: BoxSolid, b: BoxSolid, friction: float, reach: float, within: float) -> Contact | None:
    """Return the contact of two boxes in any pose; a is first by name."""
    close = closeness(a, b, reach)
    if close is None or run_flush(close.faces(), NO_GAP * reach) or not all_bridged(close.separations(), reach, within):
        return None
    off, exact = disturbance(close, max(a.longest, b.longest), reach), rounding(a, b)
    sideways = min(off, SIDEWAYS * reach) + exact
    patch = face_on_face(a, b, close, Slack(sideways, off + exact, reach, within))
    if patch:
        gaps = gaps_of(patch.heights, reach)
        return Contact(patch.lower.id, patch.upper.id, patch.points_W, (patch.normal_W,), Coulomb(friction), gaps)
    contact = _best_feature_contact(a, b, close, Slack(sideways, off + exact, reach, within))
    # Try again with larger tolerances, as a gap of the largest size displaces edges further.
    contact = contact or _best_feature_contact(a, b, close, Slack(reach, reach, reach, within))
    return (
        _directed_contact(a, b, contact, friction, gaps_of(contact.gaps_beside(close.gap), reach)) if contact else None
    )


def _best_feature_contact(a: BoxSolid, b: BoxSolid, close: BoxCloseness, slack: Slack) -> FeatureContact | None:
    """Return the contact along the axis of the largest gap with features that face each other; faces win near ties."""
    sideways = slack.sideways
    axes = [(axis.gap + sideways, axis) for axis in (*close.faces_a, *close.faces_b)]
    axes += [(axis.gap, axis) for axis in close.edges]
    for _, axis in sorted(axes, key=itemgetter(0), reverse=True):
        if axis.gap >= close.gap - 2.0 * sideways and axis.gap >= -slack.reach:
            contact = feature_contact(a, b, axis, slack)
            if contact:
                return contact
    return None


def _directed_contact(
    a: BoxSolid, b: BoxSolid, features: FeatureContact, friction: float, gaps: tuple[float, ...]
) -> Contact:
    upwards = sum(normal[2] for normal in features.normals_AB_W)
    if upwards >= -LEVEL:
        return Contact(a.id, b.id, features.points_W, features.normals_AB_W, Coulomb(friction), gaps)
    downwards = tuple(scale(-1.0, normal) for normal in features.normals_AB_W)
    return Contact(b.id, a.id, features.points_W, downwards, Coulomb(friction), gaps)
