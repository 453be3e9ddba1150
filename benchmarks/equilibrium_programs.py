"""Verifies the stability of piles of axis-aligned boxes by linear programs that are independent of the statics.

Contacts are the common rectangles of faces, computed here from the extents of the boxes. At each corner a force acts
within a friction pyramid: inside the cone, which proves that a pile stands, or around it, which proves that it falls.
Between the two the result is None. A prop pushes a box upwards where no other box touches its underside: the underside
is divided into cells along all sides of the boxes below, and forces act at the corners of the free cells.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from math import cos, pi

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import coo_matrix, csc_matrix

SIDES = 16
TOUCH = 1e-7  # [m]
GRAVITY = 9.81
OPTIMAL, INFEASIBLE = 0, 2  # status codes of linprog
SOLVERS = (("highs", True), ("highs-ds", False), ("highs-ipm", True))  # the next is tried if one reaches its limits

Array = NDArray[np.float64]
Normal = tuple[float, float, float]
# Lower body or None for a fixed body, upper body, the normal towards the upper body, and corners [m].
Touch = tuple[int | None, int, Normal, list[tuple[float, ...]]]
AXES: tuple[Normal, Normal, Normal] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
UP = AXES[2]


@dataclass(frozen=True)
class UprightBox:
    """Axis-aligned box."""

    middle: tuple[float, float, float]  # [m]
    size: tuple[float, float, float]  # [m]
    mass: float  # [kg]


def answer(
    boxes: Sequence[UprightBox], friction: float, props: Sequence[Touch] = (), sides: int = SIDES
) -> bool | None:
    """Return whether boxes stand; None if friction pyramids inside and outside the cone disagree."""
    return answer_of(boxes, [*contacts_of(boxes), *props], friction, sides)


def answer_of(
    boxes: Sequence[UprightBox], contacts: Sequence[Touch], friction: float, sides: int = SIDES
) -> bool | None:
    """Return the same for bodies in any orientation with these contacts."""
    if _balances(boxes, contacts, friction, sides):
        return True
    return None if _balances(boxes, contacts, friction / cos(pi / sides), sides) else False


def prop_contacts(boxes: Sequence[UprightBox], propped: Collection[int]) -> list[Touch]:
    """Return the contacts of props below some of the boxes, for all boxes present at the end."""
    extents = _extents(boxes)
    return [
        (None, index, UP, _rectangle([(x0, x1), (y0, y1)], 2, extents[index][2][0]))
        for index in propped
        for x0, x1, y0, y1 in _free_cells(index, extents)
    ]


def _free_cells(index: int, extents: Sequence[Sequence[tuple[float, float]]]) -> Iterator[tuple[float, ...]]:
    """Yield the cells of the underside of a box without contact."""
    xs, ys, (bottom, _) = extents[index]
    if abs(bottom) < TOUCH:
        return
    below = [other for other in extents if abs(other[2][1] - bottom) < TOUCH]
    cuts = [
        sorted({side[0], side[1], *(end for other in below for end in other[axis] if side[0] < end < side[1])})
        for axis, side in enumerate((xs, ys))
    ]
    for x0, x1 in pairwise(cuts[0]):
        for y0, y1 in pairwise(cuts[1]):
            middle = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
            if not any(all(o[a][0] < middle[a] < o[a][1] for a in (0, 1)) for o in below):
                yield x0, x1, y0, y1


def _balances(boxes: Sequence[UprightBox], contacts: Sequence[Touch], friction: float, sides: int) -> bool:
    """Return whether forces in pyramids with edges of this friction balance all weights."""
    rows: list[int] = []
    columns: list[int] = []
    values: list[float] = []
    column = 0
    angles = 2.0 * pi * np.arange(sides) / sides
    for lower, upper, towards, corners in contacts:
        normal = np.array(towards)
        one = np.cross(normal, AXES[int(np.argmin(np.abs(normal)))])
        one /= np.linalg.norm(one)
        other = np.cross(normal, one)
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
    return balanced(matrix, loads)


def balanced(matrix: csc_matrix, loads: Array) -> bool:
    """Return whether some compressive forces balance loads. Raises ArithmeticError if no solver decides it."""
    for method, presolve in SOLVERS:
        found = linprog(
            np.ones(matrix.shape[1]), A_eq=matrix, b_eq=loads, method=method, options={"presolve": presolve}
        )
        if found.status in {OPTIMAL, INFEASIBLE}:
            return bool(found.status == OPTIMAL)
    raise ArithmeticError("the linear programme was not solved")


def _extents(boxes: Sequence[UprightBox]) -> list[list[tuple[float, float]]]:
    return [[(m - 0.5 * s, m + 0.5 * s) for m, s in zip(box.middle, box.size, strict=True)] for box in boxes]


def contacts_of(boxes: Sequence[UprightBox]) -> list[Touch]:
    """Return the contacts of boxes with each other and with the ground."""
    found: list[Touch] = []
    extents = _extents(boxes)
    for index, extent in enumerate(extents):
        if abs(extent[2][0]) < TOUCH:
            found.append((None, index, UP, _rectangle(extent[:2], 2, 0.0)))
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
                        found.append((low, high, AXES[axis], _rectangle(shared, axis, extents[low][axis][1])))
    return found


def _rectangle(sides: Sequence[tuple[float, float]], axis: int, height: float) -> list[tuple[float, ...]]:
    corners = [[x, y] for x in sides[0] for y in sides[1]]
    return [(*corner[:axis], height, *corner[axis:]) for corner in corners]
