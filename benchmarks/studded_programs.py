"""Judges structures of studded bricks by linear programs that share no code with the statics.

One program has the model of the statics: a brick presses at the corners of the common rectangle of two faces and at the
points of its studs, which also pull up to a bound; side faces press at half height. Forces along studs are bounded by
squares within their circles for a lower bound of the load factor, and unbounded for an upper one; friction adds nothing
to unbounded forces.

The other one is the peer: the published score of StableLego (Liu et al., 2024), written anew as a linear program. It
minimises the residuals of all bricks, a thousandth of the sum of the greatest pull on each brick, and a millionth of
the sum of all pulls. A structure is stable if no residual is left and no point is pulled by its capacity or more.
Products that exclude pull and pressure at one point are left out, since no optimum has both. Its points are three
beside each stud of a brick that is two or more wide, and four of a narrower one; these and side faces press without
bound.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import coo_matrix, csc_matrix, hstack, identity, vstack

from benchmarks.equilibrium_programs import GRAVITY, UP, Touch, UprightBox, contacts_of

PITCH = 0.008  # [m]
OPTIMAL = 0
MOST = 1e4  # a larger load factor is not computed
RESIDUAL = 1e-6  # of the mean weight: what an interior solver leaves of zero
THREE = ((0.125, -0.125), (-0.25, 0.0), (0.125, 0.125))  # points beside a stud, in units of the pitch
FOUR = ((0.0, -0.25), (-0.25, 0.0), (0.0, 0.25), (0.25, 0.0))
MOST_PULL_COST, PULL_COST = 1e-3, 1e-6

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StudStrength:
    """Strength of one stud [N]."""

    pull: float
    narrow_pull: float  # under a brick that is one stud wide
    shear: float

    def times(self, factor: float) -> "StudStrength":
        """Return a stud with another strength."""
        return StudStrength(factor * self.pull, factor * self.narrow_pull, factor * self.shear)

    def of(self, box: UprightBox) -> float:
        """Return the pull of a stud under a box."""
        return self.narrow_pull if is_narrow(box) else self.pull


def is_narrow(box: UprightBox) -> bool:
    """Return whether a box is one stud wide."""
    return min(box.size[:2]) < 1.5 * PITCH


@dataclass(frozen=True)
class _Force:
    """Force of a box on another one."""

    lower: int | None
    upper: int
    point: Sequence[float]  # [m]
    along: Sequence[float]  # direction of the force on the upper box
    least: float  # [N]
    most: float


def load_factors(boxes: Sequence[UprightBox], strength: StudStrength) -> tuple[float, float]:
    """Return a lower and an upper bound of the load factor; inf above `MOST`.

    Raises ArithmeticError if no solver finds them.
    """
    touches = contacts_of(boxes)
    low, high = (_largest(boxes, list(_forces(boxes, touches, strength, most))) for most in (strength.shear, inf))
    return low, high


def _forces(
    boxes: Sequence[UprightBox], touches: Sequence[Touch], strength: StudStrength, shear: float
) -> Iterator[_Force]:
    for lower, upper, towards, corners in touches:
        if towards != UP:
            low, high = (end(corner[2] for corner in corners) for end in (min, max))
            for x, y in {(corner[0], corner[1]) for corner in corners}:
                yield _Force(lower, upper, (x, y, 0.5 * (low + high)), towards, 0.0, inf)
            continue
        for corner in corners:
            yield _Force(lower, upper, corner, UP, 0.0, inf)
        points = [(x + dx * PITCH, y + dy * PITCH, z) for x, y, z in studs_of(corners) for dx, dy in _QUARTERS]
        for point in points:
            yield _Force(lower, upper, point, UP, -0.25 * strength.of(boxes[upper]), inf)
        square = 0.25 * shear / sqrt(2.0)
        for point in {end(points) for end in (min, max)} | {end(points, key=_across) for end in (min, max)}:
            for along in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
                yield _Force(lower, upper, point, along, -square, square)


_QUARTERS = tuple(product((-0.25, 0.25), repeat=2))


def _across(point: Sequence[float]) -> float:
    return point[0] - point[1]


def studs_of(corners: Sequence[Sequence[float]]) -> list[tuple[float, float, float]]:
    """Return the centres of the studs within a rectangle [m]."""
    (low_x, low_y), (high_x, high_y) = ([end(c[axis] for c in corners) for axis in (0, 1)] for end in (min, max))
    return [
        (low_x + (i + 0.5) * PITCH, low_y + (j + 0.5) * PITCH, corners[0][2])
        for i in range(round((high_x - low_x) / PITCH))
        for j in range(round((high_y - low_y) / PITCH))
    ]


def _matrix(boxes: Sequence[UprightBox], forces: Sequence[_Force]) -> csc_matrix:
    """Return the wrenches of unit forces, with torques in units of the pitch."""
    points, along = (np.array([getattr(force, name) for force in forces], dtype=float) for name in ("point", "along"))
    middles = np.array([box.middle for box in boxes] + [(0.0, 0.0, 0.0)])
    rows, columns, values = [], [], []
    for name, sign in (("upper", 1.0), ("lower", -1.0)):
        body = np.array([-1 if getattr(force, name) is None else getattr(force, name) for force in forces])
        wrench = sign * np.hstack([along, np.cross(points - middles[body], along) / PITCH])
        used = (wrench != 0.0) & (body >= 0)[:, None]
        rows.append((6 * body[:, None] + np.arange(6))[used])
        columns.append(np.broadcast_to(np.arange(len(forces))[:, None], used.shape)[used])
        values.append(wrench[used])
    places = (np.concatenate(rows), np.concatenate(columns))
    return coo_matrix((np.concatenate(values), places), shape=(6 * len(boxes), len(forces))).tocsc()


def _weights(boxes: Sequence[UprightBox]) -> Array:
    loads = np.zeros(6 * len(boxes))
    loads[2::6] = [-box.mass * GRAVITY for box in boxes]
    return loads


def _largest(boxes: Sequence[UprightBox], forces: Sequence[_Force]) -> float:
    """Return the largest factor of the weights that forces within their bounds balance; inf above `MOST`."""
    loads = _weights(boxes)
    unit = -float(loads.sum()) / len(boxes)
    matrix = hstack([_matrix(boxes, forces), csc_matrix(loads[:, None] / unit)], format="csc")
    cost = np.zeros(matrix.shape[1])
    cost[-1] = -1.0
    bounds = [(force.least / unit, force.most / unit) for force in forces] + [(0.0, MOST)]
    for method in ("highs-ipm", "highs-ds", "highs"):
        solved = linprog(cost, A_eq=matrix, b_eq=np.zeros(len(loads)), bounds=bounds, method=method)
        if solved.status == OPTIMAL:
            return inf if solved.x[-1] > 0.999 * MOST else float(solved.x[-1])
    raise ArithmeticError("the linear program was not solved")


def _points_of_peer(boxes: Sequence[UprightBox], touches: Sequence[Touch]) -> list[_Force]:
    forces = []
    for lower, upper, towards, corners in touches:
        if towards != UP:
            low, high = (end(corner[2] for corner in corners) for end in (min, max))
            axis = 1 if towards[0] else 0  # it presses at the middle of each stud's side
            (start, stop) = (end(corner[axis] for corner in corners) for end in (min, max))
            for number in range(round((stop - start) / PITCH)):
                point = [corners[0][0], corners[0][1], 0.5 * (low + high)]
                point[axis] = start + (number + 0.5) * PITCH
                forces.append(_Force(lower, upper, point, towards, 0.0, inf))
            continue
        for x, y, z in studs_of(corners):
            for dx, dy in FOUR if is_narrow(boxes[upper]) else THREE:
                forces.append(_Force(lower, upper, (x + dx * PITCH, y + dy * PITCH, z), UP, -inf, inf))
            for along in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
                forces.append(_Force(lower, upper, (x, y, z), along, -inf, inf))
    return forces


def scored(boxes: Sequence[UprightBox], capacity: float) -> bool:
    """Return the verdict of the published score: whether a structure is stable with this pull of a point [N]."""
    forces = _points_of_peer(boxes, contacts_of(boxes))
    loads = _weights(boxes)
    unit = -float(loads.sum()) / len(boxes)
    kept = np.flatnonzero(np.arange(len(loads)) % 6 != 5)  # it has no torque about the vertical  # noqa: PLR2004
    matrix, loads = _matrix(boxes, forces).tocsr()[kept].tocsc(), loads[kept] / unit
    pulls = np.flatnonzero([force.least == -inf and force.along == UP for force in forces])
    above = np.array([forces[i].upper for i in pulls], dtype=np.int64)
    rows, count = len(loads), len(pulls)
    most = csc_matrix((np.ones(count), (np.arange(count), above)), shape=(count, len(boxes)))
    each = identity(rows)
    # variables: forces, of which pulls are apart; residuals of both signs; the greatest pull on each box
    equal = hstack([matrix, -matrix[:, pulls], each, -each, csc_matrix((rows, len(boxes)))], format="csc")
    above_pulls = hstack([csc_matrix((count, len(forces))), identity(count), csc_matrix((count, 2 * rows)), -most])
    cost = np.concatenate(
        [np.zeros(len(forces)), np.full(count, PULL_COST), np.ones(2 * rows), np.full(len(boxes), MOST_PULL_COST)]
    )
    free = np.array([force.least == -inf and force.along != UP for force in forces])
    lower = np.concatenate([np.where(free, -np.inf, 0.0), np.zeros(count + 2 * rows + len(boxes))])
    bounds = np.stack([lower, np.full(len(lower), np.inf)], axis=1)
    solved = linprog(cost, vstack([above_pulls], format="csc"), np.zeros(count), equal, -loads, bounds, method="highs")
    if solved.status != OPTIMAL:
        raise ArithmeticError("the program of the score was not solved")
    residual = solved.x[len(forces) + count : len(forces) + count + 2 * rows]
    pulled = solved.x[len(forces) : len(forces) + count]
    return bool(residual.max() <= RESIDUAL and unit * pulled.max(initial=0.0) < capacity)


def capacity_factor(boxes: Sequence[UprightBox], capacity: float) -> float:
    """Return the load factor of the peer's own points, each with this pull [N]."""
    forces = [
        _Force(each.lower, each.upper, each.point, each.along, -capacity, inf)
        if each.least == -inf and each.along == UP
        else each
        for each in _points_of_peer(boxes, contacts_of(boxes))
    ]
    return _largest(boxes, forces)
