"""Bounds the load factor of joined axis-aligned boxes by linear programs that share no code with the statics.

Contacts are common rectangles of faces, computed from the extents of the boxes (`equilibrium_programs`). Forces at
their corners push and rub, and side faces of studded boxes push at half height; those of a joint act at points of its
own, within n >= -tension and |t| <= min(cohesion + mu n, shear). Polygons replace the circles of friction: polygons
inside the circles bound the load factor from below, and polygons around them bound it from above.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import cos, inf, pi, sin

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix

from benchmarks.equilibrium_programs import AXES, GRAVITY, SOLVERS, Touch, UprightBox, contacts_of

SIDES = 16
MOST = 1e4  # a larger load factor is not computed
OPTIMAL, INFEASIBLE = 0, 2


@dataclass(frozen=True)
class Strength:
    """Joint of two boxes, in the words of the programs: `kind` is bond, pull or studs."""

    kind: str
    numbers: tuple[float, ...]  # tension, cohesion and shear [Pa] of a bond; [N] of a corner; pitch [m], pull and shear

    def times(self, factor: float) -> "Strength":
        """Return a joint with another strength."""
        geometric = 1 if self.kind == "studs" else 0
        return Strength(self.kind, (*self.numbers[:geometric], *(factor * each for each in self.numbers[geometric:])))


Force = tuple[tuple[float, ...], float, float, float, float]  # point [m], friction, tension, cohesion, shear [N]
JointOf = Callable[[int | None, int | None], Strength | None]


def load_factors(boxes: Sequence[UprightBox], friction: float, joint_of: JointOf) -> tuple[float, float]:
    """Return a lower and an upper bound of the load factor; infinite for more than `MOST`.

    Raises ArithmeticError if no solver finds them.
    """
    return _load_factor(boxes, friction, joint_of, cos(pi / SIDES)), _load_factor(boxes, friction, joint_of, 1.0)


def _load_factor(boxes: Sequence[UprightBox], friction: float, joint_of: JointOf, inside: float) -> float:
    forces = [(touch, force) for touch in contacts_of(boxes) for force in _forces(boxes, touch, friction, joint_of)]
    weight = sum(box.mass for box in boxes) * GRAVITY / len(boxes)
    entries: list[tuple[int, int, float]] = []
    limits: list[tuple[list[tuple[int, float]], float]] = []
    for number, ((lower, upper, towards, _), (point, mu, tension, cohesion, shear)) in enumerate(forces):
        normal = np.array(towards)
        one = np.roll(normal, 1)
        axes = (normal, one, np.cross(normal, one))
        for part, axis in enumerate(axes):
            for body, sign in ((upper, 1.0), (lower, -1.0)):
                if body is not None:
                    arm = np.array(point) - np.array(boxes[body].middle)
                    wrench = sign * np.concatenate([axis, np.cross(arm, axis) / max(boxes[body].size)])
                    entries += [(6 * body + row, 3 * number + part, value) for row, value in enumerate(wrench)]
        limits.append(([(3 * number, -1.0)], tension / weight))
        for side in range(SIDES):
            angle = 2.0 * pi * side / SIDES
            rubbed = [(3 * number + 1, cos(angle)), (3 * number + 2, sin(angle))]
            limits.append(([*rubbed, (3 * number, -inside * mu)], inside * cohesion / weight))
            if shear < inf:
                limits.append((rubbed, inside * shear / weight))
    columns = 3 * len(forces) + 1
    entries += [(6 * body + 2, columns - 1, -box.mass * GRAVITY / weight) for body, box in enumerate(boxes)]
    rows, places, values = zip(*entries, strict=True)
    equal = coo_matrix((values, (rows, places)), shape=(6 * len(boxes), columns)).tocsc()
    table = [(row, column, value) for row, (terms, _) in enumerate(limits) for column, value in terms]
    rows, places, values = zip(*table, strict=True) if table else ((), (), ())
    above = coo_matrix((values, (rows, places)), shape=(len(limits), columns)).tocsc()
    cost = np.zeros(columns)
    cost[-1] = -1.0
    bounds = [(None, None)] * (columns - 1) + [(0.0, MOST)]
    for method, presolve in SOLVERS:
        solved = linprog(
            cost,
            above,
            [bound for _, bound in limits],
            equal,
            np.zeros(6 * len(boxes)),
            bounds,
            method=method,
            options={"presolve": presolve},
        )
        if solved.status == OPTIMAL:
            return inf if solved.x[-1] >= 0.999 * MOST else float(solved.x[-1])
    raise ArithmeticError("the linear program was not solved")


def _forces(boxes: Sequence[UprightBox], touch: Touch, friction: float, joint_of: JointOf) -> Iterator[Force]:
    lower, upper, towards, corners = touch
    joint = joint_of(lower, upper)
    if joint is not None and joint.kind == "studs" and towards != AXES[2]:
        for x, y in sorted({(corner[0], corner[1]) for corner in corners}):
            yield (x, y, 0.5 * (min(c[2] for c in corners) + max(c[2] for c in corners))), 0.0, 0.0, 0.0, inf
        return
    for corner in corners:
        yield corner, friction, 0.0, 0.0, inf
    if joint is None:
        return
    match joint.kind, joint.numbers:
        case "pull", (force,):
            for corner in corners:
                yield corner, friction, force, friction * force, inf
        case "bond", strengths:
            yield from _of_bond(corners, friction, strengths)
        case "studs", strengths:
            yield from _of_studs(corners, strengths)


def _of_bond(corners: Sequence[tuple[float, ...]], friction: float, strengths: tuple[float, ...]) -> Iterator[Force]:
    tension, cohesion, shear = strengths
    middle = [sum(corner[axis] for corner in corners) / len(corners) for axis in range(3)]
    spans = [max(c[axis] for c in corners) - min(c[axis] for c in corners) for axis in range(3)]
    area = 0.25 * float(np.prod([span for span in spans if span > 0.0]))
    for corner in corners:
        centre = tuple(0.5 * (m + c) for m, c in zip(middle, corner, strict=True))
        yield centre, friction, tension * area, cohesion * area, shear * area


def _of_studs(corners: Sequence[tuple[float, ...]], strengths: tuple[float, ...]) -> Iterator[Force]:
    pitch, pull, shear = strengths
    (low_x, low_y), (high_x, high_y) = ([end(c[axis] for c in corners) for axis in range(2)] for end in (min, max))
    for i in range(round((high_x - low_x) / pitch)):
        for j in range(round((high_y - low_y) / pitch)):
            for dx, dy in product((0.25, 0.75), repeat=2):
                point = (low_x + (i + dx) * pitch, low_y + (j + dy) * pitch, corners[0][2])
                yield point, 0.0, 0.25 * pull, 0.25 * shear, inf
