"""Whether a contact resists a motion: the slip there lies outside of the dual of its friction cone."""

from collections.abc import Mapping

from stability.geometry.vectors import add, cross, dot, norm, scale, subtract
from stability.model import BodyId, Vec3
from stability.statics.facts import ZERO, Contact, Motion, Placed, Tolerances

VIOLATION = Tolerances().violation  # share of the speed there, as in the check of every proof


def resists(contact: Contact, motion: Motion, bricks: Mapping[BodyId, Placed]) -> bool:
    """Whether forces of a contact could take power from a motion; bodies that it does not name are at rest."""
    for point in contact.points_W:
        upper, lower = (_velocity(body, point, motion, bricks) for body in (contact.upper, contact.lower))
        slip = subtract(upper, lower)
        slack = VIOLATION * (norm(upper) + norm(lower))
        for normal in contact.normals_W:
            opening = dot(slip, normal)
            sliding = norm(subtract(slip, scale(opening, normal)))
            if contact.friction * sliding - opening > slack:
                return True
    return False


def _velocity(body: BodyId, point: Vec3, motion: Motion, bricks: Mapping[BodyId, Placed]) -> Vec3:
    if body not in motion.velocity:
        return ZERO
    velocity, spin = motion.velocity[body]
    return add(velocity, cross(spin, subtract(point, bricks[body].pose.position_W)))
