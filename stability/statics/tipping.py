"""Decides whether a brick and all that it carries tip as one body: the cheapest proof that an assembly falls.

If the common centre of mass lies outside the hull of the contacts below, the body may rotate about the hull edge with
the largest overhang (or simply drops if it has no contact). That motion loses height; it is a proof if no contact with
the fixed rest hinders it, by penetration or by friction: the contact must open at least as fast as friction times the
slip.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt

from stability.geometry.polygons import Point2, convex_hull
from stability.geometry.vectors import cross, dot, scale, subtract
from stability.model import BodyId, Vec3
from stability.problem import ZERO, Contact, Motion, Placed
from stability.statics.load_core import carries_upright

OVERHANG = 1e-11  # share of the support's extent: a smaller overhang is rounding
SLIP = 1e-10  # of the speed at a contact: rounding error at a point on the axis


@dataclass(frozen=True, slots=True)
class Fall:
    """Motion of some bricks as one body: a rotation about an axis through a point, or straight down."""

    bricks: tuple[BodyId, ...]
    motion: Motion


def tipping(bricks: Mapping[BodyId, Placed], border: Sequence[Contact]) -> Fall | None:
    """Return the fall of these bricks as one body; `border` are their contacts with all fixed bodies.

    None if they do not tip as one body; they may fall in another way.
    """
    if not border:
        return _falling(bricks)
    below = [c for c in border if c.upper in bricks and carries_upright(c)]
    centre = centre_of_mass(bricks.values())
    for one, other in _edges_hung_over(centre, [point for contact in below for point in contact.around_W]):
        axis = subtract(other, one)
        lever = subtract(centre, one)
        # Downwards at the centre: (axis x lever)_z must be negative.
        sign = -1.0 if axis[0] * lever[1] - axis[1] * lever[0] > 0.0 else 1.0
        angular_velocity = scale(sign / sqrt(dot(axis, axis)), axis)
        if all(_opens(contact, one, angular_velocity, bricks.keys()) for contact in border):
            return Fall(tuple(sorted(bricks)), _turning_about(one, angular_velocity, bricks))
    return None


def lies_over(bricks: Mapping[BodyId, Placed], border: Sequence[Contact]) -> bool:
    """Return whether the common centre of mass lies over the hull of the contacts below: they hold a single brick."""
    points = [point for c in border if c.upper in bricks and carries_upright(c) for point in c.points_W]
    centre = centre_of_mass(bricks.values())
    return len(convex_hull([point[:2] for point in points])) > 2 and not _edges_hung_over(centre, points)  # noqa: PLR2004


def centre_of_mass(bricks: Collection[Placed]) -> Vec3:
    """Return the common centre of mass [m, in W]."""
    total = sum(placed.brick.mass for placed in bricks)
    x, y, z = (sum(p.brick.mass * p.pose.position_W[axis] for p in bricks) / total for axis in range(3))
    return (x, y, z)


def _falling(bricks: Mapping[BodyId, Placed]) -> Fall:
    return Fall(tuple(sorted(bricks)), Motion(dict.fromkeys(sorted(bricks), ((0.0, 0.0, -1.0), ZERO))))


def _edges_hung_over(centre: Vec3, points_W: Sequence[Vec3]) -> list[tuple[Vec3, Vec3]]:
    """Return the edges of the hull of the supporting points in plan that the centre lies outside of, furthest first.

    A line or a point has one such edge: the line itself, or a short level edge across the direction to the centre.
    """
    heights: dict[Point2, Vec3] = {(x, y): (x, y, z) for x, y, z in points_W}
    border = [heights[corner] for corner in convex_hull(heights)]
    if not border:
        return []
    reach = max(max(abs(p[axis] - border[0][axis]) for p in border) for axis in (0, 1))
    if len(border) == 1 or reach == 0.0:
        dx, dy = centre[0] - border[0][0], centre[1] - border[0][1]
        x, y, z = border[0]
        other = (x - dy, y + dx, z)
        return [(border[0], other)] if other != border[0] else []  # above the point, up to rounding
    edges = list(zip(border, border[1:] + border[:1], strict=True))
    outside = sorted((-_hangs_over(centre, edge), number) for number, edge in enumerate(edges))
    if len(border) == 2:  # noqa: PLR2004 -- a line: only the side with the centre counts
        outside = [max(outside, key=lambda item: -item[0])]
    return [edges[number] for distance, number in outside if -distance > OVERHANG * reach][:2]


def _hangs_over(centre: Vec3, edge: tuple[Vec3, Vec3]) -> float:
    """Return the distance of the centre outside an edge of a counter-clockwise hull [m]; negative inside."""
    (ax, ay, _), (bx, by, _) = edge
    dx, dy = bx - ax, by - ay
    return (dy * (centre[0] - ax) - dx * (centre[1] - ay)) / sqrt(dx * dx + dy * dy)


def _opens(contact: Contact, on_axis: Vec3, angular_velocity: Vec3, moving: Collection[BodyId]) -> bool:
    """Return whether a rotation of the moving side about an axis opens a contact, or leaves it, against friction."""
    sign = 1.0 if contact.upper in moving else -1.0
    for point in contact.around_W:
        velocity = scale(sign, cross(angular_velocity, subtract(point, on_axis)))
        speed_squared = dot(velocity, velocity)
        for normal in contact.normals_W:
            separating = dot(normal, velocity)
            slip = sqrt(max(0.0, speed_squared - separating * separating))
            if contact.law.shortfall(separating, slip) > SLIP * _reach(point, on_axis):
                return False
    return True


def _reach(point: Vec3, origin: Vec3) -> float:
    return max(abs(point[axis] - origin[axis]) for axis in range(3))


def _turning_about(on_axis: Vec3, angular_velocity: Vec3, bricks: Mapping[BodyId, Placed]) -> Motion:
    return Motion(
        {
            name: (cross(angular_velocity, subtract(bricks[name].pose.position_W, on_axis)), angular_velocity)
            for name in sorted(bricks)
        }
    )
