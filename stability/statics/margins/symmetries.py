"""Turns and mirrors about an upright axis that map a structure onto itself: so one bearing tells of others.

Bricks are piled in grids, so many a load is its own mirror image. What forces hold along one bearing, and what a motion
rules out, is then known along its images without a solver. Nothing is taken for granted: the images are checked
by the arithmetic that checks what is solved, so that a structure that is only nearly its own image proves no less.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, cos, pi, sin

import numpy as np

from stability.geometry.rotations import rotate
from stability.statics.facts import Motion, Problem
from stability.statics.margins.acceleration_cut import Heading, Shaken
from stability.statics.margins.rough_headings import proven_cut
from stability.statics.solvers.wrench_matrix import Array, Cones, Indices, wrench_array

ALIKE = 1e-9  # of the size of a structure, and of its loads: by so much an image may be off
FEWEST = 12  # bricks: what is smaller is solved as soon as it is mirrored
EIGHTH = pi / 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Symmetry:
    """A turn or mirror about an upright axis, and what it maps each brick and each cone of a structure onto."""

    matrix: Array  # (3, 3)
    bricks: Indices  # (bricks,) the image of each
    cones: Indices  # (cones,) the image of each
    signs: Array  # (cones,) -1 where the image is of the force on the other body

    def image(self, case: Shaken, one: Heading, angle: float) -> Heading | None:
        """What was found in one direction as it holds in its image, at this angle; None if it is not proven there."""
        x, y = one.reach * cos(angle), one.reach * sin(angle)
        rows = self._rows(case, one.rows)
        if not case.holds(x, y, rows):
            return None
        cut = None if one.cut is None else proven_cut(case, self._motion(case, one.cut.motion))
        return None if cut is None and one.cut is not None else Heading(angle, one.reach, rows, one.slips, cut)

    def angle(self, angle: float) -> float:
        """The image of a bearing [rad], from 0 on."""
        x, y, _ = self.matrix @ np.array([cos(angle), sin(angle), 0.0])
        return atan2(y, x) % (2.0 * pi)

    def _rows(self, case: Shaken, rows: Array) -> Array:
        system = case.system
        forces = np.zeros((len(self.cones), 3))
        forces[self.cones] = self.signs[:, None] * (system.forces_W(rows) @ self.matrix.T)
        return system.rows_of(forces)

    def _motion(self, case: Shaken, motion: Motion) -> Motion:
        """Spins are axial: a mirror turns them round."""
        names, turn = case.system.names, float(np.linalg.det(self.matrix)) * self.matrix
        image = {name: names[self.bricks[number]] for number, name in enumerate(names)}
        return Motion(
            {
                image[name]: (_vector(self.matrix @ np.array(velocity)), _vector(turn @ np.array(spin)))
                for name, (velocity, spin) in motion.velocity.items()
            }
        )


def _vector(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return (x, y, z)


def symmetries(case: Shaken) -> Sequence[Symmetry]:
    """Those of the turns and mirrors of a square, in the plan of one of the bricks, that a structure has."""
    names = case.system.names
    if len(names) < FEWEST:
        return ()
    centres = np.array([case.problem.bricks[name].pose.position_W for name in names])
    centre = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    size = float(np.abs(centres - centre).max()) or 1.0
    found = (_symmetry(case, matrix, (centres - centre) / size, centre, size) for matrix in _candidates(case.problem))
    return tuple(one for one in found if one is not None)


def _candidates(problem: Problem) -> Iterator[Array]:
    """Three quarter turns, and the mirrors along the sides and the diagonals of the first brick."""
    first = problem.bricks[min(problem.bricks)]
    x, y, _ = rotate(first.pose.orientation, (1.0, 0.0, 0.0))
    along = atan2(y, x)
    for quarter in (1, 2, 3):
        c, s = cos(quarter * pi / 2.0), sin(quarter * pi / 2.0)
        yield np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    for eighth in range(4):
        c, s = cos(2.0 * (along + eighth * EIGHTH)), sin(2.0 * (along + eighth * EIGHTH))
        yield np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, 1.0]])


def _symmetry(case: Shaken, matrix: Array, places: Array, centre: Array, size: float) -> Symmetry | None:
    """The symmetry of this matrix; None if it maps some brick, load or cone onto none."""
    forces, torques, weights = _loads(case, size)
    turn = float(np.linalg.det(matrix)) * matrix
    bricks = _onto(
        np.hstack([places @ matrix.T, forces @ matrix.T, torques @ turn.T, weights]),
        np.hstack([places, forces, torques, weights]),
    )
    if bricks is None:
        return None
    points = (case.system.cones.points_W - centre) / size
    onto = _cones_onto(case.system.cones, matrix, points, np.append(bricks, len(bricks)))
    if onto is None or len(np.unique(onto % len(points))) < len(points):
        return None
    return Symmetry(matrix, bricks, onto % len(points), np.where(onto < len(points), 1.0, -1.0))


def _loads(case: Shaken, size: float) -> tuple[Array, Array, Array]:
    """Forces, torques and weights of the bricks, in shares of the largest; lengths in those of the structure."""
    names = case.system.names
    loads = wrench_array(names, case.problem.loads) / np.array([1.0, 1.0, 1.0, size, size, size])
    weights = np.array([[case.weights.get(name, 0.0)] for name in names])
    unit = float(max(np.abs(loads).max(initial=0.0), np.abs(weights).max(initial=0.0))) or 1.0
    return loads[:, :3] / unit, loads[:, 3:] / unit, weights / unit


def _cones_onto(cones: Cones, matrix: Array, points: Array, image: Indices) -> Indices | None:
    """Which cone each is mapped onto; further on by the number of cones where lower and upper body are exchanged.

    `image` is the image of each brick, and of what is fixed, which has the number after the last.
    """
    normals, lower, upper, friction = cones.axes_W[:, 0], cones.lower, cones.upper, cones.friction
    mapped = np.column_stack([points @ matrix.T, normals @ matrix.T, image[lower], image[upper], friction])
    as_they_are = np.column_stack([points, normals, lower, upper, friction])
    exchanged = np.column_stack([points, -normals, upper, lower, friction])
    return _onto(mapped, np.vstack([as_they_are, exchanged]))


def _onto(rows: Array, others: Array) -> Indices | None:
    """Which of the other rows each row is like; None if one is like none, or two are like the same."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 -- slow to import, and few need it

    distance, which = cKDTree(others).query(rows, distance_upper_bound=ALIKE)
    found: Indices = np.asarray(which, dtype=np.int64)
    return found if np.isfinite(distance).all() and len(np.unique(found)) == len(found) else None
