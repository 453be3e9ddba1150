"""Does a part of one sample tip as one body? Asked of the part that the forces of all samples could not hold."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stability.friction_law import GivenFriction, law_of
from stability.geometry.touching import reach_between
from stability.model import BodyId, Plane
from stability.statics.contacts.touch import contact_between, contact_with_plane, solid
from stability.statics.facts import Contact, Placed, Problem, Tolerances, Wrench
from stability.statics.proof import check_motion
from stability.statics.tipping import Fall, tipping


@dataclass(frozen=True, slots=True)
class Site:
    """What bricks are built on and of, and what pulls at them."""

    planes: Sequence[Plane]
    friction: GivenFriction  # of brick on brick
    gravity: float  # [m/s2]
    tolerances: Tolerances = Tolerances()  # noqa: RUF009 -- frozen


def falls_as_one(moving: Sequence[Placed], rest: Sequence[Placed], site: Site) -> Fall | None:
    """The fall of some bricks as one body while all the rest stays where it is, checked by arithmetic."""
    bricks: Mapping[BodyId, Placed] = {placed.brick.id: placed for placed in moving}
    border = _between(moving, rest, site)
    for placed in moving:
        own, name = solid(placed), placed.brick.id
        found = [contact_with_plane(own, p, site.tolerances, law_of(site.friction).on(name, p)) for p in site.planes]
        border += [contact for contact in found if contact is not None]
    fall = tipping(bricks, border)
    if fall is None:
        return None
    loads = {name: Wrench((0.0, 0.0, -placed.brick.mass * site.gravity)) for name, placed in bricks.items()}
    # What moves as one body does not move in itself, so contacts between its bricks have nothing to say.
    return fall if check_motion(Problem(bricks, border, loads), fall.motion, site.tolerances).holds else None


def _between(moving: Sequence[Placed], rest: Sequence[Placed], site: Site) -> list[Contact]:
    """The contacts of what moves with what does not."""
    if not rest:
        return []
    reach = reach_between(max(p.brick.shape.least_thickness for p in (*moving, *rest)), share=site.tolerances.gap)
    places = [np.array([(*p.pose.position_W, p.brick.shape.bounding_radius) for p in part]) for part in (moving, rest)]
    away = places[0][:, None, :3] - places[1][None, :, :3]
    limit = places[0][:, None, 3] + places[1][None, :, 3] + reach
    found = []
    for one, other in zip(*np.nonzero((away**2).sum(axis=2) <= limit**2), strict=True):
        friction = law_of(site.friction).of(moving[one].brick.id, rest[other].brick.id)
        contact = contact_between(solid(moving[one]), solid(rest[other]), friction, site.tolerances)
        if contact is not None:
            found.append(contact)
    return found
