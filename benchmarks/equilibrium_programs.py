"""Does a pile of upright boxes stand? Linear programmes written apart from the statics that they judge.

Contacts are the rectangles that faces of boxes share, worked out here from their extents. At each corner a force acts
within a friction pyramid of 16 sides: inside the cone, so that what balances stands, or around it, so that what does
not balance falls. Between the two nothing is said.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import cos, pi

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import coo_matrix

SIDES = 16
TOUCH = 1e-7  # [m]
GRAVITY = 9.81

Array = NDArray[np.float64]


@dataclass(frozen=True)
class UprightBox:
    """A box with its sides along the axes."""

    middle: tuple[float, float, float]  # [m]
    size: tuple[float, float, float]  # [m]
    mass: float  # [kg]


def answer(boxes: Sequence[UprightBox], friction: float) -> bool | None:
    """Whether they stand; None where friction pyramids inside and outside of the cone disagree."""
    if balances(boxes, friction):
        return True
    return None if balances(boxes, friction / cos(pi / SIDES)) else False


def balances(boxes: Sequence[UprightBox], friction: float) -> bool:
    """Whether forces in pyramids whose edges have this friction balance all weights."""
    rows: list[int] = []
    columns: list[int] = []
    values: list[float] = []
    column = 0
    angles = 2.0 * pi * np.arange(SIDES) / SIDES
    for lower, upper, axis, corners in _contacts(boxes):
        normal = np.eye(3)[axis]
        one, other = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        for corner in corners:
            for angle in angles:
                force = normal + friction * (cos(angle) * one + np.sin(angle) * other)
                for body, sign in ((upper, 1.0), (lower, -1.0)):
                    if body is not None:
                        arm = np.array(corner) - np.array(boxes[body].middle)
                        wrench = sign * np.concatenate([force, np.cross(arm, force) / max(boxes[body].size)])
                        rows += range(6 * body, 6 * body + 6)
                        columns += [column] * 6
                        values += wrench.tolist()
                column += 1
    if column == 0:
        return False
    weight = sum(box.mass for box in boxes) * GRAVITY / len(boxes)
    loads = np.zeros(6 * len(boxes))
    loads[2::6] = [box.mass * GRAVITY / weight for box in boxes]
    matrix = coo_matrix((values, (rows, columns)), shape=(len(loads), column)).tocsc()
    return bool(linprog(np.ones(column), A_eq=matrix, b_eq=loads, method="highs").status == 0)


def _contacts(boxes: Sequence[UprightBox]) -> list[tuple[int | None, int, int, list[tuple[float, ...]]]]:
    """Lower body or None for the ground, upper body, axis of the normal, and corners."""
    found: list[tuple[int | None, int, int, list[tuple[float, ...]]]] = []
    extents = [[(m - 0.5 * s, m + 0.5 * s) for m, s in zip(box.middle, box.size, strict=True)] for box in boxes]
    for index, extent in enumerate(extents):
        if abs(extent[2][0]) < TOUCH:
            found.append((None, index, 2, _rectangle(extent[:2], 2, 0.0)))
    for a, b in combinations(range(len(boxes)), 2):
        for axis in range(3):
            for low, high in ((a, b), (b, a)):
                if abs(extents[low][axis][1] - extents[high][axis][0]) < TOUCH:
                    others = [other for other in range(3) if other != axis]
                    shared = [
                        (max(extents[a][o][0], extents[b][o][0]), min(extents[a][o][1], extents[b][o][1]))
                        for o in others
                    ]
                    if all(end - start > TOUCH for start, end in shared):
                        found.append((low, high, axis, _rectangle(shared, axis, extents[low][axis][1])))
    return found


def _rectangle(sides: Sequence[tuple[float, float]], axis: int, height: float) -> list[tuple[float, ...]]:
    corners = [[x, y] for x in sides[0] for y in sides[1]]
    return [(*corner[:axis], height, *corner[axis:]) for corner in corners]
