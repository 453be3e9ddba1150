"""Finds the weakest brick: the mechanism that opens at the least horizontal acceleration, and that acceleration.

This is the only definition of the weakest brick. Other measures have other names: the placement margin with its
limiting joint, and the clearance of a brick's centre.
"""

from dataclasses import dataclass, replace
from math import degrees, pi, radians
from typing import TYPE_CHECKING

from stability.geometry.vectors import dot
from stability.model import BodyId, Vec3
from stability.name_order import in_order, natural_key
from stability.problem import Contact, Problem
from stability.statics.fall_description import described, really_moving, sliding_supports

if TYPE_CHECKING:
    from stability.analysis.acceleration_margin import AccelerationMargin

DIGITS = 6  # of a bearing in degrees, and of heights in metres: with more, rounding would choose the named brick

STEEP = 0.5**0.5  # z of a unit normal at 45 deg
UP: Vec3 = (0.0, 0.0, 1.0)
UPRIGHT = 1e-3  # cosine between the normals of a side face and of a bed: larger for the joints of an arch
# Coulomb coefficient in place of infinity. With 10, limits would be lower by up to about 1 %. With 1000, the forces on
# a load that carries a heavy carton are found only to 4 %.
NO_SLIDING = 300.0


@dataclass(frozen=True, slots=True)
class Weakest:
    """First mechanism of a structure that is proven to stand."""

    brick: BodyId  # the lowest brick of the mechanism, ties by name
    bricks: tuple[BodyId, ...]  # all bricks that begin to move, in natural order
    acceleration: float  # horizontal, survived in every direction [g]
    fails: float  # horizontal acceleration at which the mechanism is proven to open [g]
    bearing: float  # of the pull on the bricks, from +x towards +y, from 0 to 2 pi [rad]
    gives_way: str  # description of the motion: "L5.1, L5.2 tip over L4.1"
    slides_on: tuple[BodyId, ...] = ()  # if all bricks slide together: the bodies on which they slide
    friction: float = 0.0  # the least Coulomb coefficient between the bricks and `slides_on`


def weakest(problem: Problem, gravity: float | None = None) -> Weakest | None:
    """Return the first mechanism; None if it is held on all sides or not proven to stand. See `acceleration`."""
    from stability.analysis.acceleration_margin import acceleration  # noqa: PLC0415 -- it brings numpy

    margin = acceleration(problem, gravity=gravity)
    return None if margin is None else weakest_at(problem, margin)


def weakest_at(problem: Problem, margin: "AccelerationMargin") -> Weakest | None:
    """Return the same for a known margin of acceleration."""
    if margin.motion is None:
        return None
    bricks = in_order(really_moving(problem, margin.motion))
    heights = {name: round(problem.bricks[name].pose.position_W[2], DIGITS) for name in bricks}
    lowest = min(bricks, key=lambda name: (heights[name], natural_key(name)))
    bearing = radians(round(degrees(margin.bearing), DIGITS)) % (2.0 * pi)
    words = described(problem, margin.motion)
    supports = sliding_supports(problem, margin.motion)
    frictions = [contact.law.friction for contact in problem.contacts if {contact.lower, contact.upper} & {*supports}]
    friction = float(min(frictions, default=0.0))
    return Weakest(lowest, tuple(bricks), margin.value, margin.upper, bearing, words, supports, friction)


@dataclass(frozen=True, slots=True)
class Apart:
    """Behaviour of a structure that stands, without friction between the side faces of bricks."""

    acceleration: float | None  # horizontal, survived in every direction [g]; None if the structure falls at rest
    gives_way: str  # description of the first mechanism, or of the fall


def _carries(contact: Contact) -> bool:
    """Return whether the normals of a contact are closer to the vertical than to the horizontal."""
    return all(abs(normal[2]) > STEEP for normal in contact.normals_W)


def without_neighbours(problem: Problem, gravity: float | None = None) -> Apart | None:
    """Return what a structure that stands survives without friction between the side faces of bricks.

    None if no such faces touch with friction, or if the structure needs this friction at rest by its shape, as an arch
    does. Faces that touch exactly, as in tables of nominal sizes, carry part of the weight of a neighbour by friction,
    which a small gap takes away.
    """
    apart = without_side_friction(problem)
    if apart is None:
        return None
    first = weakest(apart, gravity)
    return fall_without_neighbours(problem) if first is None else Apart(first.acceleration, first.gives_way)


def fall_without_neighbours(problem: Problem) -> Apart | None:
    """Return the fall of a structure that stands only by friction between vertical faces; None if there is none."""
    from stability.statics.equilibrium import falling_motion  # noqa: PLC0415 -- it brings numpy
    from stability.statics.mechanism import smallest_mechanism  # noqa: PLC0415 -- it brings numpy

    apart = without_side_friction(problem)
    if apart is None or not _is_upright(problem):
        return None
    motion = falling_motion(apart)
    return None if motion is None else Apart(None, described(apart, smallest_mechanism(apart, motion)))


def _is_beside(problem: Problem, contact: Contact) -> bool:
    return contact.lower in problem.bricks and contact.upper in problem.bricks and not _carries(contact)


def without_side_friction(problem: Problem) -> Problem | None:
    """Return the problem without friction between the side faces of bricks; None if it has none."""
    if not any(_is_beside(problem, contact) and contact.law.friction for contact in problem.contacts):
        return None
    contacts = [
        replace(contact, law=contact.law.with_friction(0.0)) if _is_beside(problem, contact) else contact
        for contact in problem.contacts
    ]
    return replace(problem, contacts=tuple(contacts))


def _is_upright(problem: Problem) -> bool:
    """Return whether all side faces in contact are at right angles to the beds of their bricks, as those of boxes."""
    beds: dict[BodyId, list[Vec3]] = {}
    for contact in filter(_carries, problem.contacts):
        for name in (contact.lower, contact.upper):
            beds.setdefault(name, []).extend(contact.normals_W)
    return all(
        abs(dot(side, bed)) <= UPRIGHT
        for contact in problem.contacts
        if _is_beside(problem, contact)
        for name in (contact.lower, contact.upper)
        for bed in beds.get(name, [UP])
        for side in contact.normals_W
    )


def first_tipping(problem: Problem, gravity: float | None = None) -> Weakest | None:
    """Return the first mechanism if no brick could slide on the one below; None if that mechanism slides, too.

    Contacts between neighbours get no friction: bricks that cannot slide could wedge their neighbours with arbitrarily
    large forces, which would keep them from tipping, and nothing makes sure that these forces exist.
    """
    contacts = [
        replace(contact, law=contact.law.with_friction(NO_SLIDING if _carries(contact) else 0.0))
        for contact in problem.contacts
    ]
    first = weakest(replace(problem, contacts=tuple(contacts)), gravity)
    return None if first is None or first.slides_on else first
