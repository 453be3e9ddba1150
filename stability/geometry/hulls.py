"""The convex hull of points in plan: the one algorithm, exact or to rounding. Monotone chain (Andrew, 1979)."""

from collections.abc import Iterable, Sequence
from fractions import Fraction

from stability.geometry.plan import ROUNDING, Point2, Polygon, extent


def convex_hull(points: Iterable[Point2]) -> Polygon:
    """The corners of the convex hull, exactly; two points if all lie on a line, one if all coincide."""
    return _corners(points, exact=True)


def hull(points: Iterable[Point2]) -> Polygon:
    """The convex hull without corners that stick out by rounding only; empty if all lie on a line to rounding."""
    corners = _corners(points, exact=False)
    return corners if len(corners) > 2 else ()  # noqa: PLR2004 -- a polygon has three corners


def _corners(points: Iterable[Point2], exact: bool) -> Polygon:
    """Counter-clockwise. Exact, none is missing, however little it sticks out: a tolerance would drop extreme ones."""
    ordered = sorted(set(points))
    if len(ordered) <= 2:  # noqa: PLR2004 -- a point or a line has no inside
        return tuple(ordered)
    slack = ROUNDING * extent(ordered)
    lower = _chain(ordered, slack, exact)
    ordered.reverse()
    upper = _chain(ordered, slack, exact)
    return (*lower[:-1], *upper[:-1])


def _chain(ordered: Sequence[Point2], slack: float, exact: bool) -> list[Point2]:
    chain = [ordered[0], ordered[1]]
    for point in ordered[2:]:
        x, y = point
        while len(chain) > 1:
            (ox, oy), (ax, ay) = chain[-2], chain[-1]
            dx, dy = x - ox, y - oy
            turn, unclear = (ax - ox) * dy - (ay - oy) * dx, slack * (abs(dx) + abs(dy))
            # So close to the line, rounding may decide on which side of it a corner lies.
            if turn > unclear or (exact and turn >= -unclear and _turns_left(chain[-2], chain[-1], point)):
                break
            chain.pop()
        chain.append(point)
    return chain


def _turns_left(a: Point2, b: Point2, c: Point2) -> bool:
    """Whether a, b, c run counter-clockwise, in exact arithmetic."""
    (ax, ay), (bx, by), (cx, cy) = ((Fraction(x), Fraction(y)) for x, y in (a, b, c))
    return (bx - ax) * (cy - ay) > (by - ay) * (cx - ax)
