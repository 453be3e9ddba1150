"""Programs and proofs that no motion starts in one branch of the contact conditions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations_with_replacement
from math import sqrt
from typing import TypeAlias

import numpy as np

from stability.geometry.rows import Array, Indices
from stability.model import Vec3
from stability.statics.cone_rows import ConeRows, row_units
from stability.statics.conic_program import ConicProgram, SolverPoint
from stability.statics.initial_motion import StartEquations, frame
from stability.statics.wrench_matrix import Sparse

# Branches of a case distinction over the start of motion at contact points: together they are complete.
#
# A point either opens without force, or stays shut. A shut point slides to one side of a line or to the other; rest and
# the line itself belong to both sides.


SHUT = 1e-9  # share of the largest: a smaller combination of normal accelerations counts as free


class ContactMode(StrEnum):
    """Assumption about a contact point in a branch."""

    OPENS = "opens"  # the normal acceleration is not negative, and no force acts
    SHUT = "stays shut"  # the normal acceleration is zero
    TOWARDS = "goes towards"  # the relative acceleration has no component against a direction


@dataclass(frozen=True, slots=True)
class Condition:
    """One of the two cases at a contact point; the other case is its `opposite`."""

    point: int
    how: ContactMode
    towards: Vec3 = (0.0, 0.0, 0.0)  # of TOWARDS, in W

    @property
    def opposite(self) -> "Condition":
        """Return the opposite condition."""
        if self.how is ContactMode.TOWARDS:
            x, y, z = self.towards
            return Condition(self.point, ContactMode.TOWARDS, (-x, -y, -z))
        return Condition(self.point, ContactMode.SHUT if self.how is ContactMode.OPENS else ContactMode.OPENS)


Branch: TypeAlias = tuple[Condition, ...]


@dataclass(frozen=True, slots=True, eq=False)
class BranchConstraints:
    """Constraints on accelerations in a branch: they are `basis @ b`, and no entry of `rows @ b` is negative."""

    basis: Array  # (D, d)
    rows: Array  # (l, d)
    owners: tuple[int, ...]  # per row, the point of a normal acceleration; -1 for any other row
    pressed: tuple[int, ...]  # the points at which forces may act


def branch_constraints(equations: StartEquations, branch: Branch) -> BranchConstraints:
    """Return the constraints of a branch.

    The last row states that loads have positive power, as in any start from rest.
    """
    single = [point for point, normals in enumerate(equations.normals) if len(normals) == 1]
    shut = [each.point for each in branch if each.how is ContactMode.SHUT]
    opened = {each.point for each in branch if each.how is ContactMode.OPENS}
    basis = _free(equations, shut)
    opening = {point: equations.axes[point, 0] @ equations.slips[point] @ basis for point in single}
    owners = [point for point in single if point not in shut and np.abs(opening[point]).max(initial=0.0) > SHUT]
    sides = [
        np.array(each.towards) @ equations.slips[each.point] @ basis
        for each in branch
        if each.how is ContactMode.TOWARDS
    ]
    return BranchConstraints(
        basis,
        np.array([*(opening[point] for point in owners), *sides, equations.loads @ basis]),
        (*owners, *(-1 for _ in sides), -1),
        tuple(point for point in range(len(equations.normals)) if point not in opened),
    )


def _free(equations: StartEquations, shut: Sequence[int]) -> Array:
    """Return an orthonormal basis of the accelerations that keep these points shut; a larger space if in doubt."""
    if not shut:
        return np.identity(len(equations.loads))
    rows = np.array([equations.axes[point, 0] @ equations.slips[point] for point in shut])
    _, sizes, turned = np.linalg.svd(rows)
    basis: Array = turned[int((sizes > SHUT * sizes[0]).sum()) :].T
    return basis


def cover_every_case(branches: Sequence[Branch], depth: int = 0) -> bool:
    """Return whether branches are all leaves of one tree of case distinctions, so that they cover every case."""
    if len(branches) == 1 and len(branches[0]) == depth:
        return True
    if not branches or any(len(branch) <= depth for branch in branches):
        return False
    first = branches[0][depth]
    one = [branch for branch in branches if branch[depth] == first]
    other = [branch for branch in branches if branch[depth] == first.opposite]
    both = len(one) + len(other) == len(branches)
    return both and cover_every_case(one, depth + 1) and cover_every_case(other, depth + 1)


# The conic program for multipliers that prove that no motion starts in a branch; `Multipliers` defines them.
#
# The unknowns are the matrix of the virtual motion and the multipliers of all products; coefficients must agree, and
# one matrix must be positive semidefinite.


@dataclass(frozen=True, slots=True, eq=False)
class ColumnOffsets:
    """Start of each kind of unknown among the columns."""

    left: BranchConstraints
    pairs: tuple[tuple[int, int], ...]  # of rows whose product has a multiplier
    contacts: tuple[int, ...]
    virtual: int
    of_loads: int
    of_parts: int
    of_contacts: int  # three each: friction, and its components along two tangents
    of_forces: int  # three per point and row: along its axes
    columns: int

    def force(self, point: int, row: int) -> int:
        """Return the first of the three columns of a pressed point and a row."""
        return self.of_forces + 3 * (self.left.pressed.index(point) * len(self.left.rows) + row)


@dataclass(frozen=True, slots=True, eq=False)
class PowerProgram:
    """Program of a branch, with the meaning of its columns and equalities."""

    equations: StartEquations
    places: ColumnOffsets
    equalities: Sparse
    # the first column of each round cone, and the least ratio of its value to the norm of the next two
    cones: tuple[Indices, Array]
    conic: ConicProgram


def power_program(equations: StartEquations, branch: Branch) -> PowerProgram:
    """Return the program of a branch with possible motions."""
    from scipy.sparse import csc_matrix, vstack  # noqa: PLC0415 -- slow to import

    places = _places(equations, branch_constraints(equations, branch))
    signed = range(places.of_contacts - places.of_loads)
    equal, round_rows = _equalities(equations, places), _round(equations, places)
    positive = _entries([(row, places.of_loads + row, -1.0) for row in signed], len(signed), places)
    definite, offset = _definite(equations, places)
    matrix = csc_matrix(vstack([equal, round_rows, positive, definite]))
    offsets = np.append(np.zeros(matrix.shape[0] - len(offset)), offset)
    cost = np.zeros(places.columns)
    cost[places.of_loads : places.of_parts] = cost[places.of_contacts : places.of_forces : 3] = 1.0
    duals, size = ConeRows(round_rows.shape[0] // 3, 0), places.left.basis.shape[1]
    conic = duals.program(cost, matrix, offsets, equal=equal.shape[0], positive=len(signed), semidefinite=size)
    return PowerProgram(equations, places, equal, _cones(equations, places), conic)


def _cones(equations: StartEquations, places: ColumnOffsets) -> tuple[Indices, Array]:
    first = [places.of_contacts + 3 * number for number in range(len(places.contacts))]
    friction = [equations.law_of_contact(contact).friction for contact in places.contacts]
    slope = [1.0 / each if each else np.inf for each in friction]
    for point, row in _multiplied(places):
        first.append(places.force(point, row))
        slope.append(equations.law_at(point).friction)
    return np.array(first, dtype=np.int64), np.array(slope)


def _multiplied(places: ColumnOffsets) -> Iterator[tuple[int, int]]:
    """Yield each pressed point with each row that is not its own."""
    for point in places.left.pressed:
        yield from ((point, row) for row, owner in enumerate(places.left.owners) if owner != point)


def _places(equations: StartEquations, left: BranchConstraints) -> ColumnOffsets:
    rows = len(left.rows)
    pairs = tuple(combinations_with_replacement(range(rows), 2))
    contacts = tuple(sorted({int(equations.contact[point]) for point in left.pressed}))
    of_loads = left.basis.size
    of_contacts = of_loads + rows + len(pairs)
    of_forces = of_contacts + 3 * len(contacts)
    columns = of_forces + 3 * rows * len(left.pressed)
    return ColumnOffsets(left, pairs, contacts, 0, of_loads, of_loads + rows, of_contacts, of_forces, columns)


def _entries(entries: Sequence[tuple[int, int, float]], height: int, places: ColumnOffsets) -> Sparse:
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import

    rows, columns, values = zip(*entries, strict=True) if entries else ((), (), ())
    return csc_matrix((values, (rows, columns)), shape=(height, places.columns))


def _equalities(equations: StartEquations, places: ColumnOffsets) -> Sparse:
    """Return the coefficients, which must vanish, of accelerations times loads and times each force along its axes."""
    from scipy.sparse import csc_matrix, vstack  # noqa: PLC0415 -- slow to import

    left = places.left
    coefficients = np.zeros((left.basis.shape[1], places.columns))
    _put_virtual(coefficients, places, equations.loads)
    coefficients[:, places.of_loads : places.of_parts] = left.rows.T
    blocks = [csc_matrix(coefficients)]
    for point in left.pressed:
        blocks += [csc_matrix(_of_force(equations, places, point, axis)) for axis in range(3)]
    return vstack(blocks, format="csc")


def _put_virtual(coefficients: Array, places: ColumnOffsets, row: Array) -> None:
    """Add the coefficients of `row @ virtual`."""
    size = places.left.basis.shape[1]
    for part in range(size):
        coefficients[part, places.virtual + part : places.of_loads : size] = row


def _of_force(equations: StartEquations, places: ColumnOffsets, point: int, axis: int) -> Array:
    """Return (d, columns) the coefficients of a point's force along an axis; zero across one without friction."""
    left = places.left
    coefficients = np.zeros((left.basis.shape[1], places.columns))
    several, friction = len(equations.normals[point]) > 1, equations.law_at(point).friction
    if axis > 0 and friction == 0.0 and not several:
        return coefficients
    slip = equations.axes[point] @ equations.slips[point]
    _put_virtual(coefficients, places, slip[axis])
    for row, values in enumerate(left.rows):
        coefficients[:, places.force(point, row) + axis] = values
    first = places.of_contacts + 3 * places.contacts.index(int(equations.contact[point]))
    on_basis = slip @ left.basis
    if several or axis > 0:
        coefficients[:, first] = -on_basis[axis]
    elif friction > 0.0:
        coefficients[:, first + 1 : first + 3] = -on_basis[1:].T
    return coefficients


def _round(equations: StartEquations, places: ColumnOffsets) -> Sparse:
    """Return three rows for each round cone: of friction, then of the multipliers of forces."""
    blocks = [
        (places.of_contacts + 3 * number, np.diag([equations.law_of_contact(contact).friction or 1.0, 1.0, 1.0]))
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
    """Return the map (3, 3) of a multiplier along the axes of a point to cone form: the first part bounds the rest."""
    own: Array = frame(normal) @ equations.axes[point].T
    return own * row_units(equations.law.friction[point : point + 1]).T


def _definite(equations: StartEquations, places: ColumnOffsets) -> tuple[Sparse, Array]:
    """Return the rows of the semidefinite cone: the virtual power of inertia minus products of rows, minus the mass."""
    left = places.left
    rows, columns, scale = upper_triangle(left.basis.shape[1])
    on_basis = equations.mass @ left.basis
    coefficients = np.zeros((len(rows), places.columns))
    size = left.basis.shape[1]
    for place, (i, j, factor) in enumerate(zip(rows, columns, scale, strict=True)):
        coefficients[place, places.virtual + i : places.of_loads : size] -= 0.5 * factor * on_basis[:, j]
        coefficients[place, places.virtual + j : places.of_loads : size] -= 0.5 * factor * on_basis[:, i]
    for number, (one, other) in enumerate(places.pairs):
        product = np.outer(left.rows[one], left.rows[other])
        coefficients[:, places.of_parts + number] = scale * 0.5 * (product + product.T)[rows, columns]
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import

    return csc_matrix(coefficients), -scale * (left.basis.T @ on_basis)[rows, columns]


def upper_triangle(size: int) -> tuple[Indices, Indices, Array]:
    """Return rows and columns of an upper triangle, column by column, and the factor of each of its entries."""
    columns, rows = np.tril_indices(size)
    return rows, columns, np.where(rows == columns, 1.0, sqrt(2.0))


# A proof that rest is the only possibility in a branch: the power of forces on a virtual motion, checked by arithmetic.
#
# Let bricks at rest start with accelerations a under loads g and contact forces f, so that M a = g + J' f. Take T a as
# a virtual motion, with any matrix T, and compare powers:
#
#     a' T' M a  =  g . T a  +  sum over points of f . J T a.
#
# For every start some products of a with loads and forces are known not to be positive:
#
# - for each row l with l . a >= 0 (points do not open inwards, the loads gain, the sides of the branch), -(l .
#   a) and -(l . a) (k . f) for every k in the dual of the friction cone; for a point's own normal row any k, of any
#   sign, since a force acts only where nothing opens;
# - for every contact, friction brakes at least as if it pointed along one direction: the sum of f_t . a_t + f_n (w .
#   a_t) for any w not longer than the friction coefficient. With w constant this holds of pressure anywhere on a patch;
# - where edges or corners meet, with several normals, f . a alone.
#
# If the right side is a sum of such products, as a polynomial in a, g and f, then a' T' M a is not positive; and if T'
# M minus a sum of products (l . a) (m . a) is at least M / 2, then a' M a <= 0: no motion starts. The multipliers are a
# proof because the coefficients agree; their rounding error bounds the acceleration of any start.


STILL = 1e-9  # of the largest load over the largest mass, per load in contact: a slower start counts as none


@dataclass(frozen=True, slots=True, eq=False)
class Multipliers:
    """Multipliers that write the power of forces on a virtual motion as a sum of products that are not positive.

    They are zero for points without pressure, and for the own normal rows of points in branches where these vanish.
    """

    virtual: Array  # (D, d): T, on the accelerations that remain in the branch
    of_loads: Array  # (l,) of each row that is not negative
    of_parts: Array  # (l, l) of products of two such rows
    of_forces: Array  # (points, l, 3) k of each row and point, in W
    braking: Array  # (contacts,) of friction, or of all forces at contacts with several normals
    along: Array  # (contacts, 3) w times that, in W


@dataclass(frozen=True, slots=True, eq=False)
class ProvenBranch:
    """Branch in which no motion starts, with the proof."""

    branch: Branch
    multipliers: Multipliers


def proof_without_motion(equations: StartEquations, branch: Branch) -> Multipliers:
    """Return the proof of a branch without possible accelerations."""
    left, points = branch_constraints(equations, branch), len(equations.normals)
    rows, contacts = len(left.rows), int(equations.contact.max(initial=-1)) + 1
    of_contacts = np.zeros(contacts), np.zeros((contacts, 3))
    return Multipliers(left.basis, np.zeros(rows), np.zeros((rows, rows)), np.zeros((points, rows, 3)), *of_contacts)


def check_branch(equations: StartEquations, proven: ProvenBranch) -> bool:
    """Return whether multipliers prove that no motion starts in their branch."""
    return proof_error(equations, proven) <= STILL


def proof_error(equations: StartEquations, proven: ProvenBranch) -> float:
    """Return the error of a proof by rounding: the largest sum of coefficient differences and sign violations."""
    left, multipliers = branch_constraints(equations, proven.branch), proven.multipliers
    if not all(np.isfinite(each).all() for each in _arrays(multipliers)) or not _definite_power(
        equations, left, multipliers
    ):
        return np.inf
    of_loads = multipliers.virtual.T @ equations.loads + multipliers.of_loads @ left.rows
    lacks = [_size(of_loads), _negative(multipliers.of_loads), _negative(multipliers.of_parts)]
    for point in left.pressed:
        short = sum(
            _outside(equations, point, multipliers.of_forces[point, row])
            for row, owner in enumerate(left.owners)
            if owner != point
        )
        lacks.append(_size(_coefficients(equations, left, multipliers, point)) + short)
    lacks += [_too_far(equations, multipliers, contact) for contact in sorted(set(equations.contact.tolist()))]
    return float(sum(lacks))


def _arrays(multipliers: Multipliers) -> tuple[Array, ...]:
    of_contacts = (multipliers.braking, multipliers.along)
    return (multipliers.virtual, multipliers.of_loads, multipliers.of_parts, multipliers.of_forces, *of_contacts)


def _definite_power(equations: StartEquations, left: BranchConstraints, multipliers: Multipliers) -> bool:
    """Return whether T' M minus the products of rows is at least half of M."""
    on_basis = equations.mass @ left.basis
    square = multipliers.virtual.T @ on_basis - left.rows.T @ multipliers.of_parts @ left.rows
    square = 0.5 * (square + square.T) - 0.5 * left.basis.T @ on_basis
    return bool(np.linalg.eigvalsh(square).min(initial=0.0) >= 0.0)


def _coefficients(equations: StartEquations, left: BranchConstraints, multipliers: Multipliers, point: int) -> Array:
    """Return (3, d) the remaining coefficients of a force times accelerations.

    A point without friction has a force along its normal only, so only this component counts.
    """
    slip, contact = equations.slips[point] @ left.basis, equations.contact[point]
    rest = equations.slips[point] @ multipliers.virtual + multipliers.of_forces[point].T @ left.rows
    if len(equations.normals[point]) > 1:
        difference: Array = rest - multipliers.braking[contact] * slip
        return difference
    normal = equations.normals[point][0]
    if equations.law_at(point).friction == 0.0:
        pressed: Array = np.outer(normal, normal @ rest)
        return pressed
    across = slip - np.outer(normal, normal @ slip)
    braked = multipliers.braking[contact] * across + np.outer(normal, multipliers.along[contact] @ across)
    left_over: Array = rest - braked
    return left_over


def _outside(equations: StartEquations, point: int, dual: Array) -> float:
    """Return by how much a vector violates the dual of every friction cone of a point."""
    law, shorts = equations.law_at(point), [0.0]
    for normal in equations.normals[point]:
        along = float(normal @ dual)
        shorts.append(law.shortfall(along, _size(dual - along * normal)))
    return max(shorts)


def _too_far(equations: StartEquations, multipliers: Multipliers, contact: int) -> float:
    """Return by how much the multiplier of friction exceeds its bound."""
    braking = float(multipliers.braking[contact])
    most = equations.law_of_contact(contact).greatest_friction(max(braking, 0.0))
    return float(max(0.0, -braking, _size(multipliers.along[contact]) - most))


def _negative(values: Array) -> float:
    return float(-np.minimum(values, 0.0).sum())


def _size(values: Array) -> float:
    return float(np.sqrt((values * values).sum()))


# Solves for multipliers that prove that no motion starts in a branch, or for a guess of a start.
#
# The solver's multipliers are moved into their ranges and their coefficients are made to agree, so that the check finds
# only a small error. Without a proof the dual of the program is a mean of products of accelerations and forces, and its
# strongest component is a guess of a start of the group.


MOST_CORRECTIONS = 3
FAINT = 1e-12  # share of a multiplier by which even a value at the end of its range may be corrected


@dataclass(frozen=True, slots=True, eq=False)
class Guess:
    """Guess of the start of a group without a proof of rest; nothing in it is proven."""

    moments: Array  # (D, D) means of products of accelerations
    acceleration: Array  # (D,)
    forces: Array  # (points, 3) in W


def multipliers(program: PowerProgram, point: SolverPoint) -> Iterator[Multipliers]:
    """Yield the multipliers of the solver, then repeated corrections of them, all unproven."""
    if not np.isfinite(point.x).all():
        return
    matrix = program.equalities.toarray()
    columns, room = _in_range(program, point.x)
    yield _taken_apart(program, columns)
    for _ in range(MOST_CORRECTIONS):
        scaled = matrix * room
        square = scaled @ scaled.T
        # some equations are linearly dependent
        square[np.diag_indices_from(square)] += FAINT * max(float(square.diagonal().max()), FAINT)
        columns, room = _in_range(program, columns - room * (scaled.T @ np.linalg.solve(square, matrix @ columns)))
        yield _taken_apart(program, columns)


def guess(program: PowerProgram, point: SolverPoint) -> Guess | None:
    """Return the strongest component of the means in the dual solution."""
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


def _in_range(program: PowerProgram, values: Array) -> tuple[Array, Array]:
    """Return the columns moved into their ranges, and the largest change of each."""
    places, columns = program.places, values.copy()
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
    matrix = np.zeros((size, size))
    matrix[rows, columns] = matrix[columns, rows] = packed / scale
    return matrix
