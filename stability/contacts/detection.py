"""Contacts of bodies from their poses and shapes: the entry point of contact detection."""

from stability.contact_law import Coulomb
from stability.contacts.bodies import BoxSolid, Solid, as_hull, solid
from stability.contacts.box_contacts import closeness, level_patch, points_below, side_patch
from stability.contacts.convex_contacts import Closeness, convex_contact, points_on_plane
from stability.contacts.gap_bridging import gaps_of, run_flush
from stability.geometry.box_distance import NO_GAP, gap_bridged, reach_between
from stability.model import Plane
from stability.problem import Contact, Tolerances

__all__ = ["Solid", "contact_between", "contact_with_plane", "solid"]


def contact_between(a: Solid, b: Solid, friction: float, tolerances: Tolerances) -> Contact | None:
    """Return the contact of two bodies, independent of their order; None if they do not touch."""
    reach, within = reach_between(a.shortest, b.shortest, tolerances.gap), tolerances.within
    if _bounds_apart(a, b, reach):
        return None
    if a.id > b.id:
        a, b = b, a
    if isinstance(a, BoxSolid) and isinstance(b, BoxSolid):
        lower, upper = (a, b) if a.pose.position_W[2] <= b.pose.position_W[2] else (b, a)
        patch = level_patch(lower, upper, reach, within)
        if patch is None:
            lower, upper, patch = a, b, side_patch(a, b, reach, within)
        if patch is not None:
            points, normal, gap = patch
            gaps = (gap,) * len(points) if gap > NO_GAP * reach else ()
            return Contact(lower.id, upper.id, points, (normal,), Coulomb(friction), gaps) if points else None
    close = _closeness(a, b, reach)
    return convex_contact(close, friction, reach, within) if close is not None else None


def contact_with_plane(a: Solid, plane: Plane, tolerances: Tolerances, friction: float | None = None) -> Contact | None:
    """Return the contact of a body with a fixed half-space, which always counts as the lower body.

    `friction` replaces the plane's own coefficient.
    """
    reach = reach_between(a.shortest, share=tolerances.gap)
    widest = gap_bridged(reach, plane.normal_W[2], tolerances.within)
    below = points_below(a, plane, reach, widest) if isinstance(a, BoxSolid) else None
    points, heights = below or points_on_plane(a, plane, reach, widest)
    if not points:
        return None
    mu = plane.friction if friction is None else friction
    return Contact(plane.id, a.id, points, (plane.normal_W,), Coulomb(mu), gaps_of(heights, reach))


def flush_within(a: Solid, b: Solid, reach: float, overlap: float) -> bool:
    """Check that two touching bodies would transfer no force if they overlapped by `overlap` [m] less."""
    close = _closeness(a, b, reach)
    return close is not None and run_flush(close.faces(), overlap)


def _closeness(a: Solid, b: Solid, reach: float) -> Closeness | None:
    """Compute the gaps of two bodies; None if their gap or overlap exceeds `reach` [m]."""
    if isinstance(a, BoxSolid) and isinstance(b, BoxSolid):
        return closeness(a, b, reach)
    from stability.contacts.hull_contacts import hull_closeness  # noqa: PLC0415 -- boxes do without numpy

    return hull_closeness(as_hull(a), as_hull(b), reach)


def _bounds_apart(a: Solid, b: Solid, reach: float) -> bool:
    """Check that the bounding boxes are apart, which decides most pairs without contact."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz), (dx, dy, dz) = a.low_W, a.high_W, b.low_W, b.high_W
    return (
        cz - bz > reach or az - dz > reach or cx - bx > reach or ax - dx > reach or cy - by > reach or ay - dy > reach
    )
