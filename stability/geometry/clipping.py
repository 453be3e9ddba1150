"""Cutting convex polygons, lines and cones by half-planes: the one clipper (Sutherland and Hodgman, 1974)."""

from collections.abc import Callable, Sequence
from typing import TypeVar, cast

P = TypeVar("P", bound=tuple[float, ...])  # a point or a direction, of any dimension


def between(one: P, other: P, part: float) -> P:
    """The point on the line from one to the other, at this part of it."""
    return cast(P, tuple([a + part * (b - a) for a, b in zip(one, other, strict=True)]))


def cut(
    corners: Sequence[P],
    depths: Sequence[float],
    slack: float = 0.0,
    crossing: Callable[[P, P, float], P] = between,
) -> list[P]:
    """The part of a convex polygon on the inner side of a line; two corners, or one, count as a polygon.

    `depths` says how far inside each corner is. What is no further outside than `slack` lies on the line, and stays.
    Where the border crosses the line, `crossing` makes the corner, always from the inner one to the outer one, so that
    two polygons that share a side get the same.
    """
    kept: list[P] = []
    least = -slack
    before, depth_before = corners[-1], depths[-1]
    for corner, depth in zip(corners, depths, strict=True):
        if depth >= least:
            if depth > slack and depth_before < least:
                kept.append(crossing(corner, before, depth / (depth - depth_before)))
            kept.append(corner)
        elif depth_before > slack:
            kept.append(crossing(before, corner, depth_before / (depth_before - depth)))
        before, depth_before = corner, depth
    return kept


def within_rectangle(corners: Sequence[P], half_x: float, half_y: float) -> Sequence[P]:
    """The part whose first two coordinates are within these limits: of a polygon, of a line, or of a point."""
    for axis, limit in ((0, half_x), (1, half_y)):
        along = [corner[axis] for corner in corners]
        if along and min(along) < -limit:
            corners = cut(corners, [limit + each for each in along], crossing=_on_border(axis, -limit))
            along = [corner[axis] for corner in corners]
        if along and max(along) > limit:
            corners = cut(corners, [limit - each for each in along], crossing=_on_border(axis, limit))
    return corners


def _on_border(axis: int, value: float) -> Callable[[P, P, float], P]:
    """The crossing with a side of the rectangle: exactly on it, whatever rounding says."""
    across = 1 - axis

    def crossing(inner: P, outer: P, part: float) -> P:
        beside = inner[across] + part * (outer[across] - inner[across])
        place = (beside, value) if axis else (value, beside)
        return cast(P, place if len(inner) == len(place) else (*place, *between(inner[2:], outer[2:], part)))

    return crossing
