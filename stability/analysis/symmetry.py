"""Symmetries of an assembly, which map proven results of one horizontal direction to others without a solver."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sin

import numpy as np

from stability.analysis.acceleration_cut import AcceleratedProblem, Cut, Heading
from stability.geometry.rows import Array, Indices
from stability.geometry.vectors import rotate
from stability.problem import ZERO, Motion, Problem, Wrench
from stability.statics.wrench_matrix import Cones, wrench_array

# Rotations and reflections about a vertical axis that map a structure onto itself: one bearing gives the result of
# others.
#
# Bricks are piled in grids, so many loads are mirror-symmetric. The forces along one bearing and the limits of its
# motion then hold along the images of the bearing without a solver. The images are checked by the arithmetic that
# checks solved results, so a nearly symmetric structure leads to no wrong proof.


IMAGE_ACCURACY = 1e-9  # accepted error of an image, relative to the size of a structure and to its loads
FEWEST = 12  # bricks: a smaller structure is solved as fast as it is mirrored
EIGHTH = pi / 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Symmetry:
    """Rotation or reflection about a vertical axis, with the images of all bricks and cones of a structure."""

    matrix: Array  # (3, 3)
    bricks: Indices  # (bricks,) the image of each
    cones: Indices  # (cones,) the image of each
    signs: Array  # (cones,) -1 where the image is of the force on the other body

    def image(self, case: AcceleratedProblem, one: Heading, angle: float) -> Heading | None:
        """Return the image of a direction's result at this angle; None if it is not proven there."""
        x, y = one.reach * cos(angle), one.reach * sin(angle)
        rows = self._rows(case, one.rows)
        if not case.holds(x, y, rows):
            return None
        cut = None if one.cut is None else proven_cut(case, self._motion(case, one.cut.motion))
        if cut is None:
            return None if one.cut is not None else Heading(angle, one.reach, rows, np.zeros(len(rows)), None)
        return Heading(angle, one.reach, rows, case.system.matrix @ case.system.columns_of(cut.motion), cut)

    def angle(self, angle: float) -> float:
        """Return the image of a bearing [rad], not negative."""
        x, y, _ = self.matrix @ np.array([cos(angle), sin(angle), 0.0])
        return atan2(y, x) % (2.0 * pi)

    def _rows(self, case: AcceleratedProblem, rows: Array) -> Array:
        system = case.system
        forces = np.zeros((len(self.cones), 3))
        forces[self.cones] = self.signs[:, None] * (system.forces_W(rows) @ self.matrix.T)
        return system.rows_of(forces)

    def _motion(self, case: AcceleratedProblem, motion: Motion) -> Motion:
        """Return the image of a motion; spins are axial vectors, so a reflection reverses them."""
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


def symmetries(case: AcceleratedProblem) -> Sequence[Symmetry]:
    """Return the symmetries of a square, aligned with a brick in plan, that a structure has."""
    names = case.system.names
    if len(names) < FEWEST:
        return ()
    centres = np.array([case.problem.bricks[name].pose.position_W for name in names])
    centre = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    size = float(np.abs(centres - centre).max()) or 1.0
    results = (_symmetry(case, matrix, (centres - centre) / size, centre, size) for matrix in _candidates(case.problem))
    return tuple(one for one in results if one is not None)


def _candidates(problem: Problem) -> Iterator[Array]:
    """Yield three quarter rotations, and the reflections at the sides and the diagonals of the first brick."""
    first = problem.bricks[min(problem.bricks)]
    x, y, _ = rotate(first.pose.orientation, (1.0, 0.0, 0.0))
    along = atan2(y, x)
    for quarter in (1, 2, 3):
        c, s = cos(quarter * pi / 2.0), sin(quarter * pi / 2.0)
        yield np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    for eighth in range(4):
        c, s = cos(2.0 * (along + eighth * EIGHTH)), sin(2.0 * (along + eighth * EIGHTH))
        yield np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, 1.0]])


def _symmetry(case: AcceleratedProblem, matrix: Array, places: Array, centre: Array, size: float) -> Symmetry | None:
    """Return the symmetry of this matrix; None if a brick, load or cone has no image."""
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


def _loads(case: AcceleratedProblem, size: float) -> tuple[Array, Array, Array]:
    """Return forces, torques and weights of the bricks in dimensionless units.

    The units are the largest load and the size of the structure.
    """
    names = case.system.names
    loads = wrench_array(names, case.problem.loads) / np.array([1.0, 1.0, 1.0, size, size, size])
    weights = np.array([[case.weights.get(name, 0.0)] for name in names])
    unit = float(max(np.abs(loads).max(initial=0.0), np.abs(weights).max(initial=0.0))) or 1.0
    return loads[:, :3] / unit, loads[:, 3:] / unit, weights / unit


def _cones_onto(cones: Cones, matrix: Array, points: Array, image: Indices) -> Indices | None:
    """Return the image of each cone, plus the number of cones if lower and upper body are exchanged.

    `image` has the image of each brick and, as its last entry, of the fixed bodies.
    """
    normals, lower, upper, friction = cones.axes_W[:, 0], cones.lower, cones.upper, cones.friction
    mapped = np.column_stack([points @ matrix.T, normals @ matrix.T, image[lower], image[upper], friction])
    as_they_are = np.column_stack([points, normals, lower, upper, friction])
    exchanged = np.column_stack([points, -normals, upper, lower, friction])
    return _onto(mapped, np.vstack([as_they_are, exchanged]))


def _onto(rows: Array, others: Array) -> Indices | None:
    """Return the index of the equal row among the others for each row; None if one has none or two have the same."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 -- slow to import, and few need it

    distance, which = cKDTree(others).query(rows, distance_upper_bound=IMAGE_ACCURACY)
    indices: Indices = np.asarray(which, dtype=np.int64)
    return indices if np.isfinite(distance).all() and len(np.unique(indices)) == len(indices) else None


# The nearest cut that a motion proves.


FURTHER = (4.0, 100.0, 1e4, 1e6)  # multiples of the least gain of a proof, tried in turn


def proven_cut(case: AcceleratedProblem, motion: Motion) -> Cut | None:
    """Return the nearest half-plane that a motion proves: there its gain is the least one that a proof needs."""
    momentum, resisted, size = _powers(case, motion)
    along = hypot(*momentum)
    if not along > 0.0:
        return None
    x, y = momentum[0] / along, momentum[1] / along
    distance = max(0.0, resisted / along)
    for times in FURTHER:
        proven = distance + times * case.tolerances.gain * size * (1.0 + distance) / along
        if case.falls(proven * x, proven * y, motion).holds:
            return Cut((x, y), proven, 0.0, motion)
    return None


def _powers(case: AcceleratedProblem, motion: Motion) -> tuple[tuple[float, float], float, float]:
    """Return the power of a motion under 1 g along x and y, the loss of the loads, and the sum of sizes [W]."""
    gained, resisted, size = np.zeros(2), 0.0, 0.0
    for name, (velocity, spin) in sorted(motion.velocity.items()):
        weight, load = case.weights.get(name, 0.0), case.problem.loads.get(name, Wrench(ZERO))
        gained += weight * np.array(velocity[:2])
        resisted -= float(np.dot(load.force_W, velocity) + np.dot(load.torque_W, spin))
        size += (hypot(*load.force_W) + weight) * hypot(*velocity) + hypot(*load.torque_W) * hypot(*spin)
    return (float(gained[0]), float(gained[1])), resisted, size
