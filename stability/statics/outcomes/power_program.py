"""The conic program for multipliers that prove that nothing starts in a branch; see `virtual_power` on what they are.

The unknowns are the matrix of the virtual motion and the multipliers of all products; coefficients must agree, and one
matrix must be positive semidefinite.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from math import sqrt

import numpy as np

from stability.statics.outcomes.branch import Branch, Known, known
from stability.statics.outcomes.start_equations import Array, Indices, StartEquations, frame
from stability.statics.solvers.conic_program import ConicProgram
from stability.statics.solvers.wrench_matrix import Sparse


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Where the unknowns of each kind begin among the columns."""

    left: Known
    pairs: tuple[tuple[int, int], ...]  # of parts whose product has a multiplier
    contacts: tuple[int, ...]
    virtual: int
    of_loads: int
    of_parts: int
    of_contacts: int  # three each: the braking, and that along two tangents
    of_forces: int  # three for each point and part: along its axes
    columns: int

    def force(self, point: int, row: int) -> int:
        """The first of the three columns of a point that is pressed and a part."""
        return self.of_forces + 3 * (self.left.pressed.index(point) * len(self.left.rows) + row)


@dataclass(frozen=True, slots=True, eq=False)
class PowerProgram:
    """The program of a branch, and what its columns and equalities are."""

    equations: StartEquations
    places: Places
    equalities: Sparse
    cones: tuple[Indices, Array]  # the first column of each round cone, and its least ratio to the norm of the next two
    conic: ConicProgram


def power_program(equations: StartEquations, branch: Branch) -> PowerProgram:
    """The program of a branch in which something is left that could move."""
    from scipy.sparse import csc_matrix, vstack  # noqa: PLC0415 -- slow to import

    places = _places(equations, known(equations, branch))
    signed = range(places.of_contacts - places.of_loads)
    equal, round_rows = _equalities(equations, places), _round(equations, places)
    positive = _entries([(row, places.of_loads + row, -1.0) for row in signed], len(signed), places)
    definite, offset = _definite(equations, places)
    matrix = csc_matrix(vstack([equal, round_rows, positive, definite]))
    offsets = np.append(np.zeros(matrix.shape[0] - len(offset)), offset)
    cost = np.zeros(places.columns)
    cost[places.of_loads : places.of_parts] = cost[places.of_contacts : places.of_forces : 3] = 1.0
    rounds, size = [3] * (round_rows.shape[0] // 3), places.left.basis.shape[1]
    conic = ConicProgram(cost, matrix, offsets, equal.shape[0], rounds, len(signed), semidefinite=size)
    return PowerProgram(equations, places, equal, _cones(equations, places), conic)


def _cones(equations: StartEquations, places: Places) -> tuple[Indices, Array]:
    first = [places.of_contacts + 3 * number for number in range(len(places.contacts))]
    friction = [_friction(equations, contact) for contact in places.contacts]
    slope = [1.0 / each if each else np.inf for each in friction]
    for point, row in _multiplied(places):
        first.append(places.force(point, row))
        slope.append(float(equations.friction[point]))
    return np.array(first, dtype=np.int64), np.array(slope)


def _multiplied(places: Places) -> Iterator[tuple[int, int]]:
    """Each point that is pressed with each part that is not its own."""
    for point in places.left.pressed:
        yield from ((point, row) for row, owner in enumerate(places.left.owners) if owner != point)


def _friction(equations: StartEquations, contact: int) -> float:
    return float(equations.friction[int(np.argmax(equations.contact == contact))])


def _places(equations: StartEquations, left: Known) -> Places:
    rows = len(left.rows)
    pairs = tuple(combinations_with_replacement(range(rows), 2))
    contacts = tuple(sorted({int(equations.contact[point]) for point in left.pressed}))
    of_loads = left.basis.size
    of_contacts = of_loads + rows + len(pairs)
    of_forces = of_contacts + 3 * len(contacts)
    columns = of_forces + 3 * rows * len(left.pressed)
    return Places(left, pairs, contacts, 0, of_loads, of_loads + rows, of_contacts, of_forces, columns)


def _entries(entries: Sequence[tuple[int, int, float]], height: int, places: Places) -> Sparse:
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import

    rows, columns, values = zip(*entries, strict=True) if entries else ((), (), ())
    return csc_matrix((values, (rows, columns)), shape=(height, places.columns))


def _equalities(equations: StartEquations, places: Places) -> Sparse:
    """The coefficients of accelerations with loads, then with each force along its axes, must be nothing."""
    from scipy.sparse import csc_matrix, vstack  # noqa: PLC0415 -- slow to import

    left = places.left
    found = np.zeros((left.basis.shape[1], places.columns))
    _put_virtual(found, places, equations.loads)
    found[:, places.of_loads : places.of_parts] = left.rows.T
    blocks = [csc_matrix(found)]
    for point in left.pressed:
        blocks += [csc_matrix(_of_force(equations, places, point, axis)) for axis in range(3)]
    return vstack(blocks, format="csc")


def _put_virtual(found: Array, places: Places, row: Array) -> None:
    """The coefficients of `row @ virtual`."""
    size = places.left.basis.shape[1]
    for part in range(size):
        found[part, places.virtual + part : places.of_loads : size] = row


def _of_force(equations: StartEquations, places: Places, point: int, axis: int) -> Array:
    """(d, columns) the coefficients of the force of a point along one of its axes; none across one without friction."""
    left = places.left
    found = np.zeros((left.basis.shape[1], places.columns))
    several, friction = len(equations.normals[point]) > 1, equations.friction[point]
    if axis > 0 and friction == 0.0 and not several:
        return found
    slip = equations.axes[point] @ equations.slips[point]
    _put_virtual(found, places, slip[axis])
    for row, values in enumerate(left.rows):
        found[:, places.force(point, row) + axis] = values
    first = places.of_contacts + 3 * places.contacts.index(int(equations.contact[point]))
    on_basis = slip @ left.basis
    if several or axis > 0:
        found[:, first] = -on_basis[axis]
    elif friction > 0.0:
        found[:, first + 1 : first + 3] = -on_basis[1:].T
    return found


def _round(equations: StartEquations, places: Places) -> Sparse:
    """Three rows for each round cone: of what friction brakes, then of the multipliers of forces."""
    blocks = [
        (places.of_contacts + 3 * number, np.diag([_friction(equations, contact) or 1.0, 1.0, 1.0]))
        for number, contact in enumerate(places.contacts)
    ]
    duals = {
        point: [_dual(equations, point, normal) for normal in equations.normals[point]] for point in places.left.pressed
    }
    blocks += [(places.force(point, row), dual) for point, row in _multiplied(places) for dual in duals[point]]
    entries = [
        (3 * number + i, first + j, -float(block[i, j]))
        for number, (first, block) in enumerate(blocks)
        for i in range(3)
        for j in range(3)
        if block[i, j]
    ]
    return _entries(entries, 3 * len(blocks), places)


def _dual(equations: StartEquations, point: int, normal: Array) -> Array:
    """(3, 3) what turns a multiplier along the axes of a point into one whose first part is not less than the rest."""
    own: Array = frame(normal) @ equations.axes[point].T
    own[1:] *= equations.friction[point]
    return own


def _definite(equations: StartEquations, places: Places) -> tuple[Sparse, Array]:
    """Rows of the semidefinite cone: the virtual power of inertia less products of parts, less the mass."""
    left = places.left
    rows, columns, scale = upper_triangle(left.basis.shape[1])
    on_basis = equations.mass @ left.basis
    found = np.zeros((len(rows), places.columns))
    size = left.basis.shape[1]
    for place, (i, j, factor) in enumerate(zip(rows, columns, scale, strict=True)):
        found[place, places.virtual + i : places.of_loads : size] -= 0.5 * factor * on_basis[:, j]
        found[place, places.virtual + j : places.of_loads : size] -= 0.5 * factor * on_basis[:, i]
    for number, (one, other) in enumerate(places.pairs):
        product = np.outer(left.rows[one], left.rows[other])
        found[:, places.of_parts + number] = scale * 0.5 * (product + product.T)[rows, columns]
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import

    return csc_matrix(found), -scale * (left.basis.T @ on_basis)[rows, columns]


def upper_triangle(size: int) -> tuple[Indices, Indices, Array]:
    """Rows and columns of an upper triangle, column by column, and the factor of each of its entries."""
    columns, rows = np.tril_indices(size)
    return rows, columns, np.where(rows == columns, 1.0, sqrt(2.0))
