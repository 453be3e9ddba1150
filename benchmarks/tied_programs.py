"""Decides by linear programs whether tied axis-aligned boxes stand, independently of the statics.

Contacts are those of `equilibrium_programs`. A tie is the convex hull of the rectangles in which its plane cuts its
boxes; at each corner of the hull it pulls the box there by its tension towards both neighbouring corners. Its tension
is a variable between two bounds. Forces at the corners of contacts act within friction pyramids inside or around the
cone.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix
from scipy.spatial import ConvexHull

from benchmarks.equilibrium_programs import AXES, GRAVITY, INFEASIBLE, OPTIMAL, SOLVERS, Array, UprightBox, contacts_of

SIDES = 32
NEAR = 1e-9  # [m]


@dataclass(frozen=True)
class Loop:
    """Closed tie around boxes, in a plane across an axis."""

    around: tuple[int, ...]
    axis: int
    offset: float  # [m]
    tension: float  # [N]
    strength: float

    def pulls(self, boxes: Sequence[UprightBox]) -> list[tuple[int, Array, Array]]:
        """Return box, point and force of each pull at a tension of 1 N."""
        u, v = (axis for axis in range(3) if axis != self.axis)
        corners = [
            (index, boxes[index].middle[u] + a * boxes[index].size[u] / 2, boxes[index].middle[v] + b * half)
            for index in self.around
            if abs(boxes[index].middle[self.axis] - self.offset) <= boxes[index].size[self.axis] / 2
            for half in [boxes[index].size[v] / 2]
            for a in (-1, 1)
            for b in (-1, 1)
        ]
        if not corners:
            return []
        points = np.array([corner[1:] for corner in corners])
        order = ConvexHull(points).vertices
        found = []
        for place, vertex in enumerate(order):
            here = points[vertex]
            ways = [points[order[(place + step) % len(order)]] - here for step in (-1, 1)]
            flat = sum(way / np.hypot(*way) for way in ways)
            owners = sorted(
                {i for (i, *_), point in zip(corners, points, strict=True) if np.abs(point - here).max() < NEAR}
            )
            for owner in owners:
                point, force = np.empty(3), np.zeros(3)
                point[[self.axis, u, v]] = self.offset, *here
                force[[u, v]] = flat / len(owners)
                found.append((owner, point, force))
        return found


@dataclass(frozen=True)
class Tied:
    """Tied boxes, with a horizontal force at the centre of one of them."""

    boxes: Sequence[UprightBox]
    loops: Sequence[Loop]
    friction: float
    pushed: int = 0
    push: tuple[float, float] = (0.0, 0.0)  # [N]


def least_tension(case: Tied, inside: bool) -> float | None:
    """Return the least sum of the tensions above their lower bounds that balances boxes [N]; None if none does.

    Raises ArithmeticError if no solver decides it.
    """
    boxes = case.boxes
    weight = sum(box.mass for box in boxes) * GRAVITY / len(boxes)
    slope = case.friction if inside else case.friction / cos(pi / SIDES)
    columns: list[Array] = []

    def wrench(body: int, point: Array, force: Array) -> Array:
        column = np.zeros(6 * len(boxes))
        arm = point - np.array(boxes[body].middle)
        column[6 * body : 6 * body + 6] = np.concatenate([force, np.cross(arm, force) / max(boxes[body].size)])
        return column

    for lower, upper, towards, corners in contacts_of(boxes):
        normal = np.array(towards)
        one = np.cross(normal, AXES[int(np.argmin(np.abs(normal)))])
        one /= np.linalg.norm(one)
        other = np.cross(normal, one)
        for corner in corners:
            for side in range(SIDES):
                angle = 2.0 * pi * side / SIDES
                force = normal + slope * (cos(angle) * one + sin(angle) * other)
                column = wrench(upper, np.array(corner), force)
                columns.append(column if lower is None else column - wrench(lower, np.array(corner), force))
    loads = np.zeros(6 * len(boxes))
    loads[2::6] = [-box.mass * GRAVITY / weight for box in boxes]
    loads[6 * case.pushed : 6 * case.pushed + 2] += np.array(case.push) / weight
    bounds: list[tuple[float, float | None]] = [(0.0, None)] * len(columns)
    for loop in case.loops:
        pull = sum((wrench(*each) for each in loop.pulls(boxes)), np.zeros(6 * len(boxes)))
        loads += loop.tension / weight * pull
        columns.append(pull)
        bounds.append((0.0, (loop.strength - loop.tension) / weight))
    cost = np.zeros(len(columns))
    cost[len(columns) - len(case.loops) :] = 1.0
    matrix = coo_matrix(np.array(columns).T).tocsc()
    for method, presolve in SOLVERS:
        found = linprog(cost, A_eq=matrix, b_eq=-loads, bounds=bounds, method=method, options={"presolve": presolve})
        if found.status == INFEASIBLE:
            return None
        if found.status == OPTIMAL:
            return float(found.fun) * weight
    raise ArithmeticError("the linear program was not solved")
