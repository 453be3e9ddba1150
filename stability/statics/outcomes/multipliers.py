"""Solving for multipliers that prove that nothing starts in a branch, or for a guess of what does.

The solver's multipliers are moved into their ranges and their coefficients made to agree, so that little is left for
the check to find. Where there is no proof the dual of the program is a mean of products of accelerations and forces,
and its strongest part a guess of how the group starts.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stability.statics.outcomes.power_program import PowerProgram, upper_triangle
from stability.statics.outcomes.start_equations import Array
from stability.statics.outcomes.virtual_power import Multipliers
from stability.statics.solvers.conic_program import Point

MOST_CORRECTIONS = 3
FAINT = 1e-12  # share of a multiplier by which even one that is at the end of its range may be corrected


@dataclass(frozen=True, slots=True, eq=False)
class Guess:
    """How a group may start where there is no proof that it does not; nothing of it is proven."""

    moments: Array  # (D, D) means of products of accelerations
    acceleration: Array  # (D,)
    forces: Array  # (points, 3) in W


def multipliers(program: PowerProgram, point: Point) -> Iterator[Multipliers]:
    """What the solver found, then this corrected again and again; none of it is proven."""
    if not np.isfinite(point.x).all():
        return
    matrix = program.equalities.toarray()
    columns, room = _in_range(program, point.x)
    yield _taken_apart(program, columns)
    for _ in range(MOST_CORRECTIONS):
        scaled = matrix * room
        square = scaled @ scaled.T
        square[np.diag_indices_from(square)] += FAINT * max(float(square.diagonal().max()), FAINT)  # some say the same
        columns, room = _in_range(program, columns - room * (scaled.T @ np.linalg.solve(square, matrix @ columns)))
        yield _taken_apart(program, columns)


def guess(program: PowerProgram, point: Point) -> Guess | None:
    """The strongest part of the means that the dual gives."""
    if not np.isfinite(point.dual).all():
        return None
    left, equations = program.places.left, program.equations
    size = left.basis.shape[1]
    moments = _unpacked(point.dual[len(point.dual) - size * (size + 1) // 2 :], size)
    own = np.linalg.eigh(moments)[1][:, -1]
    own = own * (1.0 if own @ left.rows[-1] > 0.0 else -1.0)
    means = point.dual[: program.conic.equal].reshape(-1, size) @ own
    if not abs(means[0]) > 0.0:
        return None
    forces, pressed = np.zeros((len(equations.normals), 3)), list(left.pressed)
    forces[pressed] = np.einsum("pk,pkj->pj", means[1:].reshape(-1, 3) / means[0], equations.axes[pressed])
    strength = max(float(own @ moments @ own), 0.0)
    return Guess(left.basis @ moments @ left.basis.T, left.basis @ own * (strength / abs(float(means[0]))), forces)


def _in_range(program: PowerProgram, given: Array) -> tuple[Array, Array]:
    """Columns moved into their ranges, and by how much each may be changed."""
    places, columns = program.places, given.copy()
    signed = slice(places.of_loads, places.of_contacts)
    columns[signed] = np.maximum(columns[signed], 0.0)
    room = np.ones(len(columns))
    room[signed] = columns[signed] + FAINT
    first, slope = program.cones
    cones = columns[first[:, None] + np.arange(3)]
    cones[slope == np.inf, 1:] = 0.0
    across = np.where(slope == np.inf, 0.0, slope) * np.hypot(cones[:, 1], cones[:, 2])
    cones[:, 0] = np.maximum(cones[:, 0], across)
    columns[first[:, None] + np.arange(3)] = cones
    room[first[:, None] + np.arange(3)] = (cones[:, 0] - across + FAINT)[:, None]
    return columns, room


def _taken_apart(program: PowerProgram, columns: Array) -> Multipliers:
    places, equations = program.places, program.equations
    rows, pressed = len(places.left.rows), list(places.left.pressed)
    of_parts = np.zeros((rows, rows))
    of_parts[tuple(zip(*places.pairs, strict=True))] = columns[places.of_parts : places.of_contacts]
    of_forces = np.zeros((len(equations.normals), rows, 3))
    own = columns[places.of_forces :].reshape(-1, rows, 3)
    of_forces[pressed] = np.einsum("prk,pkj->prj", own, equations.axes[pressed])
    braking, along = _of_contacts(program, columns)
    virtual = columns[places.virtual : places.of_loads].reshape(places.left.basis.shape)
    return Multipliers(virtual, columns[places.of_loads : places.of_parts], of_parts, of_forces, braking, along)


def _of_contacts(program: PowerProgram, columns: Array) -> tuple[Array, Array]:
    places, equations = program.places, program.equations
    count = int(equations.contact.max(initial=-1)) + 1
    braking, along = np.zeros(count), np.zeros((count, 3))
    for number, contact in enumerate(places.contacts):
        first, axes = places.of_contacts + 3 * number, equations.axes[int(np.argmax(equations.contact == contact))]
        braking[contact] = columns[first]
        along[contact] = columns[first + 1 : first + 3] @ axes[1:]
    return braking, along


def _unpacked(packed: Array, size: int) -> Array:
    rows, columns, scale = upper_triangle(size)
    found = np.zeros((size, size))
    found[rows, columns] = found[columns, rows] = packed / scale
    return found
