"""How supports share a load that none could bear alone: merge cases 2 and 3, and a rule that keeps moments.

Source: the stack-stability thesis, section 3.3.6; equation numbers are its own. `stability.published.readings` names
what its text leaves open.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import dist

from stability.geometry.plan import Point2
from stability.model import BodyId
from stability.published.contact_areas import ContactArea
from stability.published.readings import ActsAt, Closest, Merge, Readings


@dataclass(frozen=True, slots=True)
class Share:
    """Part of a load that goes to one support."""

    on: BodyId
    mass: float  # equivalent mass [kg], Eq. 9
    at: Point2  # where it acts, in plan [m]


def shares_of_two(mass: float, com: Point2, one: ContactArea, other: ContactArea, readings: Readings) -> list[Share]:
    """What each of two supports is given of a load [kg] whose centre lies above neither, in plan [m]."""
    if readings.merge is Merge.LEVER_RULE:
        return _lever_rule(mass, com, one, other)
    return [
        Share(area.on, mass * _lever(com, area, beside, readings.pivot), _acts_at(area, com, readings.acts_at))
        for area, beside in ((one, other), (other, one))
    ]


def equal_shares(mass: float, com: Point2, areas: Sequence[ContactArea], readings: Readings) -> list[Share]:
    """What each of more than two supports is given of a load [kg]: merge case 2."""
    return [Share(area.on, mass / len(areas), _acts_at(area, com, readings.equal_acts_at)) for area in areas]


def _acts_at(area: ContactArea, com: Point2, where: ActsAt) -> Point2:
    return area.centre if where is ActsAt.CONTACT else com


def _lever(com: Point2, area: ContactArea, other: ContactArea, closest: Closest) -> float:
    """Eq. 3 to 9: which part of the load a force on `area` must hold up, so that nothing turns about `other`.

    |torque| / (|lever| sin theta) with gravity vertical leaves horizontal distances only.
    """
    pivot = _closest(other, com, closest)
    return dist(com, pivot) / dist(area.centre, pivot)


def _closest(area: ContactArea, com: Point2, closest: Closest) -> Point2:
    corners = [(x, y) for x, y, _ in area.points_W]
    if closest is Closest.POINT:
        corners = [_on_segment(a, b, com) for a, b in pairwise((*area.polygon, area.polygon[0]))]
    return min(corners, key=lambda point: (dist(point, com), point))


def _on_segment(a: Point2, b: Point2, com: Point2) -> Point2:
    """The point between a and b that is closest to a centre of mass."""
    along = min(1.0, max(0.0, _along(a, b, com)))
    return (a[0] + along * (b[0] - a[0]), a[1] + along * (b[1] - a[1]))


def _along(a: Point2, b: Point2, com: Point2) -> float:
    """How far along from a to b a centre of mass lies beside, as a share of that way."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    return ((com[0] - a[0]) * dx + (com[1] - a[1]) * dy) / (dx * dx + dy * dy)


def _lever_rule(mass: float, com: Point2, one: ContactArea, other: ContactArea) -> list[Share]:
    """Between the centres of both contacts by the lever rule, both moved by as much as com lies off that line.

    So the shares add up to the load, and have its moment about every axis. Neither is negative.
    """
    part = min(1.0, max(0.0, _along(one.centre, other.centre, com)))
    on_line = _on_segment(one.centre, other.centre, com)
    off = (com[0] - on_line[0], com[1] - on_line[1])
    return [
        Share(area.on, mass * share, (area.centre[0] + off[0], area.centre[1] + off[1]))
        for area, share in ((one, 1.0 - part), (other, part))
    ]
