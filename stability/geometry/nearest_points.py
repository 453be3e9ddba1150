"""The points of two convex bodies that are nearest to each other, and so the shortest way between them.

The shortest vector of the difference of both bodies, of which nothing is asked but which point of each lies farthest
along a direction (Wolfe's algorithm, 1976, on the supports of Gilbert, Johnson and Keerthi, 1988). It ends after a few
supports, also where edges or faces are almost parallel and going to and fro between two bodies would take thousands.
"""

from collections.abc import Callable, Sequence
from typing import TypeAlias

from stability.geometry.vectors import cross, dot, scale, subtract
from stability.model import Vec3

Support: TypeAlias = Callable[[Vec3], Vec3]  # from a direction to the point of a body that lies farthest along it [m]

ENOUGH = 1e-10  # of the square of the distance: a further corner that shortens it by less ends the search
ROUNDING = 1e-14  # of the square of how far the farthest corner is: what is shortened by less may be rounding
TOUCHING = 1e-7  # of how far that corner is: what is nearer overlaps
MOST_SUPPORTS = 64  # boxes take four to eight
A_TRIANGLE = 3  # corners

# A corner of the difference of both bodies, and the points of both of which it is that.
_Corner: TypeAlias = tuple[Vec3, Vec3, Vec3]


def nearest_points(support_a: Support, support_b: Support, start_W: Vec3) -> tuple[Vec3, Vec3] | None:
    """The points of two bodies that are nearest to each other; None if the bodies overlap.

    `start_W` is any vector towards the first from the second, such as that between their middles.
    """
    corners = [_corner(support_a, support_b, start_W)]
    shares: Sequence[float] = (1.0,)
    far = dot(corners[0][0], corners[0][0])  # [m2] of the farthest corner
    for _ in range(MOST_SUPPORTS):
        shortest = _mixed(shares, [corner[0] for corner in corners])
        square = dot(shortest, shortest)
        ahead = _corner(support_a, support_b, shortest)
        far = max(far, dot(ahead[0], ahead[0]))
        if square <= TOUCHING**2 * far:
            return None
        reached = min(dot(shortest, corner[0]) for corner in corners)  # the square, but for rounding
        if reached - dot(shortest, ahead[0]) <= ENOUGH * square + ROUNDING * far:
            break
        corners.append(ahead)
        shares, corners = _inside(corners, (*shares, 0.0))
        if len(corners) > A_TRIANGLE:
            return None
    return _mixed(shares, [corner[1] for corner in corners]), _mixed(shares, [corner[2] for corner in corners])


def _corner(support_a: Support, support_b: Support, away_W: Vec3) -> _Corner:
    """The corner of the difference that lies least along a direction."""
    on_a, on_b = support_a(scale(-1.0, away_W)), support_b(away_W)
    return subtract(on_a, on_b), on_a, on_b


def _inside(corners: list[_Corner], shares: Sequence[float]) -> tuple[Sequence[float], list[_Corner]]:
    """The shares of those of some corners between which the shortest vector to all lies, and these corners."""
    while True:
        wanted = _affine_shares([corner[0] for corner in corners])
        if min(wanted) >= 0.0:
            return wanted, corners
        # As far towards that as all shares stay; the first that is used up goes.
        changes = list(zip(shares, wanted, strict=True))
        part, drops = min((has / (has - to), i) for i, (has, to) in enumerate(changes) if to < 0.0)
        shares = [has + part * (to - has) for has, to in changes]
        shares = [max(share, 0.0) for i, share in enumerate(shares) if i != drops]
        corners = [corner for i, corner in enumerate(corners) if i != drops]


def _affine_shares(points: Sequence[Vec3]) -> Sequence[float]:
    """The shares, of a sum of one, of up to four points whose mixture is the shortest vector of all they span."""
    first, *others = points
    match [subtract(other, first) for other in others]:
        case []:
            return (1.0,)
        case [u]:
            share = -dot(first, u) / dot(u, u)
            return 1.0 - share, share
        case [u, v]:
            across = cross(u, v)
            area = dot(across, across)
            two = -dot(cross(first, v), across) / area, -dot(cross(u, first), across) / area
            return 1.0 - (two[0] + two[1]), *two
        case [u, v, w]:
            across = cross(v, w)
            volume = dot(u, across)
            three = (
                -dot(first, across) / volume,
                -dot(u, cross(first, w)) / volume,
                -dot(u, cross(v, first)) / volume,
            )
            return 1.0 - (three[0] + three[1] + three[2]), *three
        case _:
            raise ValueError("corners in space span a tetrahedron at most")


def _mixed(shares: Sequence[float], points: Sequence[Vec3]) -> Vec3:
    """The mean of points, by their shares."""
    x = y = z = 0.0
    for share, (a, b, c) in zip(shares, points, strict=True):
        x, y, z = x + share * a, y + share * b, z + share * c
    return x, y, z
