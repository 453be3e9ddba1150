"""All starts of boxes in a plane by all combinations of modes of contact: an enumeration that shares nothing with ours.

At each point of a section y = 0 the bodies separate, stick, or slide one way or the other. Each combination is a linear
program: is there a motion in it that is not rest?
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import linprog

from stability.geometry.box import Box
from stability.problem import Problem

MOVES = 1e-6  # of g
SEPARATES, STICKS, FORWARDS, BACKWARDS = "separates", "sticks", "slides forwards", "slides backwards"


@dataclass(frozen=True)
class Section:
    """Masses, loads and points of contact in the plane x, z: three columns a brick."""

    mass: Any
    loads: Any
    points: list[tuple[Any, Any, float]]  # rows of the normal and tangential acceleration, and friction


def section(problem: Problem) -> Section:
    names = sorted(problem.bricks)
    mass, loads = np.zeros(3 * len(names)), np.zeros(3 * len(names))
    for number, name in enumerate(names):
        brick = problem.bricks[name].brick
        assert isinstance(brick.shape, Box)
        across, _, up = brick.shape.size
        inertia = brick.mass * (across**2 + up**2) / 12.0
        mass[3 * number : 3 * number + 3] = brick.mass, brick.mass, inertia
        loads[3 * number + 1] = problem.loads[name].force_W[2]
    return Section(np.diag(mass), loads, list(_points(problem, names)))


def _points(problem: Problem, names: list[str]) -> Iterator[tuple[Any, Any, float]]:
    for contact in problem.contacts:
        (nx, _, nz), *_ = contact.normals_W
        for x, z in sorted({(round(x, 9), round(z, 9)) for x, _, z in contact.points_W}):
            rows = []
            for dx, dz in ((nx, nz), (nz, -nx)):
                row = np.zeros(3 * len(names))
                for body, sign in ((contact.upper, 1.0), (contact.lower, -1.0)):
                    if body in problem.bricks:
                        first, (px, _, pz) = 3 * names.index(body), problem.bricks[body].pose.position_W
                        row[first : first + 3] += sign * np.array([dx, dz, dz * (x - px) - dx * (z - pz)])
                rows.append(row)
            yield rows[0], rows[1], contact.law.friction


def starts(problem: Problem) -> Iterator[tuple[str, ...]]:
    """The combinations of modes in which there is a motion."""
    found = section(problem)
    for modes in product((SEPARATES, STICKS, FORWARDS, BACKWARDS), repeat=len(found.points)):
        if _moves(found, modes):
            yield modes


def _moves(found: Section, modes: tuple[str, ...]) -> bool:
    size, count = len(found.loads), len(found.points)
    forces = np.array([row for normal, tangent, _ in found.points for row in (normal, tangent)])
    equal, right = [*np.hstack([found.mass, -forces.T])], [*found.loads]
    less: list[Any] = []
    moving = np.zeros(size + 2 * count)
    for number, ((normal, tangent, friction), mode) in enumerate(zip(found.points, modes, strict=True)):
        opening, sliding = np.append(normal, np.zeros(2 * count)), np.append(tangent, np.zeros(2 * count))
        pressed, braked = np.eye(size + 2 * count)[size + 2 * number : size + 2 * number + 2]
        if mode == SEPARATES:
            equal += [pressed, braked]
            less.append(-opening)
            moving -= opening
        elif mode == STICKS:
            equal += [opening, sliding]
            less += [-pressed, braked - friction * pressed, -braked - friction * pressed]
        else:
            way = 1.0 if mode == FORWARDS else -1.0
            equal += [opening, braked + way * friction * pressed]
            less += [-pressed, -way * sliding]
            moving -= way * sliding
        right += [0.0] * (len(equal) - len(right))
    answer = linprog(moving, np.array(less), np.zeros(len(less)), np.array(equal), right, (None, None))
    fastest = MOVES * np.abs(found.loads).max()
    return bool(answer.status == 3 or (answer.status == 0 and -answer.fun > fastest))
