"""Contacts of bodies from their poses and shapes: the entry point of contact detection."""

from collections.abc import Iterator
from itertools import combinations, product
from typing import TYPE_CHECKING, Union

from stability.contact_law import Coulomb
from stability.contacts.bodies import (
    AnySolid,
    BoxSolid,
    CompoundSolid,
    Solid,
    as_hull,
    convex_parts,
    convex_solid,
    is_round,
    solid,
)
from stability.contacts.box_contacts import closeness, level_patch, points_below, side_patch
from stability.contacts.convex_contacts import Closeness, convex_contact, points_on_plane
from stability.contacts.gap_bridging import gaps_of, run_flush
from stability.geometry.box_distance import NO_GAP, gap_bridged, reach_between
from stability.geometry.compound import Compound
from stability.geometry.placed_shape import part_pose
from stability.model import Brick, Plane, Vec3
from stability.problem import Contact, Placed, Tolerances

if TYPE_CHECKING:
    from stability.contacts.hull_contacts import HullSolid
    from stability.contacts.round_contacts import RoundBody

Flat = Union[BoxSolid, "HullSolid"]  # with flat faces only

__all__ = ["AnySolid", "Solid", "contact_between", "contacts_between", "contacts_with_plane", "seams", "solid"]


def contacts_between(a: AnySolid, b: AnySolid, friction: float, tolerances: Tolerances) -> tuple[Contact, ...]:
    """Return the contacts of two bodies, independent of their order; of two convex bodies there is at most one."""
    if not isinstance(a, CompoundSolid) and not isinstance(b, CompoundSolid):
        contact = contact_between(a, b, friction, tolerances)
        return () if contact is None else (contact,)
    reach = reach_between(a.shortest, b.shortest, tolerances.gap)
    if _bounds_apart(a, b, reach):
        return ()
    from stability.contacts.compound_contacts import without_seams  # noqa: PLC0415 -- boxes do without numpy

    if a.id > b.id:
        a, b = b, a
    pairs = product(enumerate(convex_parts(a)), enumerate(convex_parts(b)))
    found = [((i, j), contact_between(part, other, friction, tolerances)) for (i, part), (j, other) in pairs]
    contacts = [(numbers, contact) for numbers, contact in found if contact is not None]
    return tuple(without_seams(contacts, (a, b), reach))


def seams(placed: Placed) -> Iterator[tuple[Vec3, ...]]:
    """Yield the corners of the areas in which the parts of a compound touch [m, W]; none for a convex body."""
    if isinstance(placed.brick.shape, Compound):
        parts = [
            convex_solid(Placed(Brick(f"{number}", part.shape, 0.0), part_pose(part, placed.pose)))
            for number, part in enumerate(placed.brick.shape.parts)
        ]
        for one, other in combinations(parts, 2):
            contact = contact_between(one, other, 0.0, Tolerances())
            if contact is not None and len(contact.points_W) > 2:  # noqa: PLR2004 -- an area
                yield contact.points_W


def contacts_with_plane(
    a: AnySolid, plane: Plane, tolerances: Tolerances, friction: float | None = None
) -> tuple[Contact, ...]:
    """Return the contacts of a body with a fixed half-space, which always counts as the lower body.

    `friction` replaces the plane's own coefficient.
    """
    found = (contact_with_plane(part, plane, tolerances, friction) for part in convex_parts(a))
    return tuple(contact for contact in found if contact is not None)


def contact_between(a: Solid, b: Solid, friction: float, tolerances: Tolerances) -> Contact | None:
    """Return the contact of two bodies, independent of their order; None if they do not touch."""
    reach, within = reach_between(a.shortest, b.shortest, tolerances.gap), tolerances.within
    if _bounds_apart(a, b, reach):
        return None
    if a.id > b.id:
        a, b = b, a
    if is_round(a) or is_round(b):
        from stability.contacts.round_contacts import round_contact  # noqa: PLC0415 -- boxes do without numpy

        return round_contact(_meeting(a), _meeting(b), friction, reach, within)
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
    mu = plane.friction if friction is None else friction
    if is_round(a):
        from stability.contacts.round_contacts import round_on_plane  # noqa: PLC0415 -- boxes do without numpy

        return round_on_plane(a, plane, mu, reach, widest)
    below = points_below(a, plane, reach, widest) if isinstance(a, BoxSolid) else None
    points, heights = below or points_on_plane(a, plane, reach, widest)
    if not points:
        return None
    return Contact(plane.id, a.id, points, (plane.normal_W,), Coulomb(mu), gaps_of(heights, reach))


def flush_within(a: Solid, b: Solid, reach: float, overlap: float) -> bool:
    """Check that two touching bodies would transfer no force if they overlapped by `overlap` [m] less."""
    if is_round(a) or is_round(b):
        from stability.contacts.round_contacts import flush  # noqa: PLC0415 -- boxes do without numpy

        return flush(_meeting(a), _meeting(b), overlap)
    close = _closeness(a, b, reach)
    return close is not None and run_flush(close.faces(), overlap)


def _meeting(body: Solid) -> "RoundBody | HullSolid":
    return body if is_round(body) else as_hull(body)


def _closeness(a: Flat, b: Flat, reach: float) -> Closeness | None:
    """Compute the gaps of two bodies; None if their gap or overlap exceeds `reach` [m]."""
    if isinstance(a, BoxSolid) and isinstance(b, BoxSolid):
        return closeness(a, b, reach)
    from stability.contacts.hull_contacts import hull_closeness  # noqa: PLC0415 -- boxes do without numpy

    return hull_closeness(as_hull(a), as_hull(b), reach)


def _bounds_apart(a: AnySolid, b: AnySolid, reach: float) -> bool:
    """Check that the bounding boxes are apart, which decides most pairs without contact."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz), (dx, dy, dz) = a.low_W, a.high_W, b.low_W, b.high_W
    return (
        cz - bz > reach or az - dz > reach or cx - bx > reach or ax - dx > reach or cy - by > reach or ay - dy > reach
    )
