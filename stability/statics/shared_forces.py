"""Greatest sums of the forces that balance one set of loads: many conic programs with the same constraints.

An interior-point method of our own solves them together. The forces that contacts can bear and that balance the loads
are a convex set, which is bounded if some motion opens all contacts. Its analytic centre is computed once, and with it
such a motion: for any sum, a multiple of this motion and forces near the centre lie close to the central path. All
forces after that balance the loads and all motions are admissible, so a program stops as soon as the sum that its
forces reach is close enough to the sum that its motion permits. A step costs one banded factorization, and all other
arithmetic is done for a batch of programs at once.

The steps are those of Mehrotra in the scaling of Nesterov and Todd: Andersen, Roos and Terlaky, "On implementing a
primal-dual interior-point method for conic quadratic optimization", Mathematical Programming 95 (2003).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from typing import Final, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.geometry.rows import Array, Indices
from stability.statics.conic_program import Matrix, quick_solve
from stability.statics.load_factor import central_forces
from stability.statics.wrench_matrix import WrenchMatrix
from stability.work_limit import add_program

BATCH: Final = 16  # programs at once: their numbers stay in the cache of a core
MOST_ENTRIES: Final = 4_000_000  # of all banded matrices of a batch; a larger one is left to a sparse solver
ROUGH: Final = 1e-5  # accuracy of the forces from which the centre is found
CENTRED: Final = 1e-3  # largest step at the centre, in the local norm
MOST_CENTRINGS: Final = 50
MOST_STEPS: Final = 60
SHORTEST: Final = 1e-3  # a program that takes a shorter step gains nothing more
WITHIN: Final = 0.995  # share of the way to the border that a step may take
TOWARDS_CENTRE: Final = 0.7  # likewise of a step to the centre
AT_START: Final = 0.9  # distance from the centre at which a program starts, in the local norm
ROUNDING: Final = 1e-14  # share that is added to the diagonal of a matrix that may be singular within rounding
NOISE: Final = 1e-11  # share of a sum below which forces cannot change it
DECIDED: Final = 1e-4  # share of the permitted difference within which a sum starts that equilibrium alone decides
CORRECTIONS: Final = 2
ALIKE: Final = 1e-9  # greatest difference of unit vectors that count as the same
VISITS: Final = 25_000  # of bricks, in all orders that are tried
OF_A_BRICK: Final = 6  # columns
SIGNS: Final = np.array([1.0, -1.0, -1.0]).reshape(3, 1, 1)
PAIRS: Final = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # entries of a symmetric matrix of three rows

Vectors: TypeAlias = Array  # (3, cones, programs) normal and tangential parts, in which cones have unit slope


@dataclass(frozen=True, slots=True, eq=False)
class Greatest:
    """Forces and motions that bound sums from below and from above."""

    rows: Array  # (rows, programs) forces that balance the loads
    columns: Array  # (columns, programs) admissible motions


@dataclass(frozen=True, slots=True, eq=False)
class SharedForces:
    """All forces that contacts can bear and that balance the loads of a system, with their analytic centre."""

    _balance: "_Balance"
    _centre: "_Centre"

    @classmethod
    def of(cls, system: WrenchMatrix) -> Self | None:
        """Return the forces of a system.

        None if its contacts are not all cones, if some contact is forced to its border, or if the banded matrix of the
        system is too large.
        """
        if not len(system.rows) or system.bounded is not None or len(system.most_tension):
            return None
        balance = _Balance(system)
        rough = central_forces(system, system.loads, ROUGH, quick_solve) if balance.square.programs else ""
        centre = None if isinstance(rough, str) else balance.centre(balance.vectors(rough[:, None]))
        return None if centre is None else cls(balance, centre)

    @property
    def central_rows(self) -> Array:
        """Return (rows,) the forces at the centre."""
        return self._balance.by_row(self._centre.forces, self._centre.motion).rows[:, 0]

    def greatest(self, sums: Array, accuracy: float, least: float) -> Greatest:
        """Return forces and motions between whose values of `sums` (rows, programs) the greatest ones lie.

        These values differ at most by `accuracy`, as a share of the value at the centre, or of `least` if that is
        greater, unless rounding prevents it. Raises TooMuchWorkError.
        """
        balance, scaling = self._balance, self._centre.scaling
        vectors = balance.vectors(sums)
        known = self._centre.factors.solve(balance.onto(scaling.squared(vectors)))
        free = scaling.factor(vectors - balance.slips(known))
        free *= _farthest(free) > NOISE * _farthest(scaling.factor(vectors))
        permitted = accuracy * np.maximum(np.abs(_total(vectors * self._centre.forces)), least)
        of, times = _multiples(free.reshape(-1, len(permitted)))
        np.minimum.at(permitted, of, permitted / times)
        forces, motions = np.empty_like(vectors), np.empty_like(known)
        solved = np.unique(of)
        parts = vectors[..., solved], known[:, solved], free[..., solved]
        forces[..., solved], motions[:, solved] = self._optimized(*parts, permitted[solved])
        # Forces balance the same loads, so a multiple of what equilibrium leaves free is greatest where that is.
        forces = self._corrected(forces[..., of])
        return balance.by_row(forces, known + times * (motions - known)[:, of])

    def _optimized(self, sums: Vectors, known: Array, free: Vectors, permitted: Array) -> tuple[Vectors, Array]:
        """Return forces and motions of some sums.

        Motions `known` (columns, programs) give the part of each sum that equilibrium decides; `free` is the rest,
        scaled by the centre. Sums that are decided end where they start, far within the `permitted` difference.
        """
        size = self._balance.square.programs
        points, waiting = _Points(np.empty_like(sums), np.empty_like(known)), np.arange(len(permitted))
        while len(waiting) or len(points.numbers):
            if len(waiting) and len(points.numbers) <= size // 2:
                some, waiting = np.split(waiting, [size - len(points.numbers)])
                points.add(some, *self._started(known[:, some], free[..., some], permitted[some]))
            slips = self._balance.slips(points.motions) - sums[..., points.numbers]
            gap = _total(points.forces * slips)
            wide = (gap > permitted[points.numbers]) & (points.steps < MOST_STEPS)
            points.keep(wide)
            if not wide.any():
                continue
            with np.errstate(divide="ignore", invalid="ignore"):  # on a border, within rounding
                forces, motions, length = self._step(points, slips[..., wide], gap[wide])
            moves = length > SHORTEST
            points.keep(moves)
            points.move(forces[..., moves], motions[:, moves])
        return points.last_forces, points.last_motions

    def _started(self, known: Array, free: Vectors, permitted: Array) -> tuple[Vectors, Array]:
        """Return forces and motions near the central path, as near to its end as the centre allows."""
        for _ in permitted:
            add_program(self._balance.matrix.nnz)
        share = np.maximum(_farthest(free) / AT_START, DECIDED * permitted / free.shape[1])
        forces = self._corrected(self._centre.forces + self._centre.scaling.factor(free) / share)
        return forces, share * self._centre.motion + known

    def _step(self, points: "_Points", slips: Vectors, gap: Array) -> tuple[Vectors, Array, Array]:
        """Return the next forces and motions, and the length of the shorter of both steps, up to 1."""
        balance, forces = self._balance, points.forces
        scaling = _Scaling.between(forces, slips)
        factors = balance.square.factorized(scaling)
        # First towards products of zero; how far that leads decides how much the step is centred.
        turn = balance.slips(factors.solve(-balance.loads))
        change = -forces - scaling.squared(turn)
        lengths = [np.minimum(1.0, _length(*each)) for each in ((forces, change), (slips, turn))]
        left = _total((forces + lengths[0] * change) * (slips + lengths[1] * turn)) / gap
        both = scaling.factor(slips)
        product = _product(both, both) + _product(scaling.inverse(change), scaling.factor(turn))
        product[0] -= left**3 * gap / forces.shape[1]
        wanted = scaling.factor(_quotient(-product, both))
        faster = factors.solve(balance.onto(wanted) - balance.missing(forces))
        turn = balance.slips(faster)
        change = wanted - scaling.squared(turn)
        lengths = [np.minimum(1.0, WITHIN * _length(*each)) for each in ((forces, change), (slips, turn))]
        return forces + lengths[0] * change, points.motions + lengths[1] * faster, np.minimum(*lengths)

    def _corrected(self, forces: Vectors) -> Vectors:
        """Return forces without the errors of rounding by which they do not balance the loads."""
        balance, centre = self._balance, self._centre
        for _ in range(CORRECTIONS):
            motions = centre.factors.solve(balance.missing(forces))
            forces = forces + centre.scaling.squared(balance.slips(motions))
        return forces


class _Balance:
    """The balance of loads and forces, with columns in an order in which touching bricks are near each other."""

    def __init__(self, system: WrenchMatrix) -> None:
        round_, flat, count = system.rows.round, system.rows.flat, len(system.rows)
        normals = system.rows.normals
        none = np.full(flat, count)  # an empty row
        self._places = np.stack([normals, *(np.append(normals[:round_] + axis, none) for axis in (1, 2))])
        self._rows = count
        self._order = _narrow_order(system)
        self.loads = -system.loads[self._order][:, None]
        self.matrix = _with_empty_row(system.matrix)[self._places.ravel()][:, self._order].tocsr()
        self._transposed = self.matrix.T.tocsr()
        self.square = _BandedSquare(self.matrix, round_ + flat, _columns_of(system, self._order))

    def vectors(self, rows: Array) -> Vectors:
        """Return the parts of rows (rows, programs)."""
        vectors: Vectors = np.vstack([rows, np.zeros((1, rows.shape[1]))])[self._places]
        return vectors

    def by_row(self, forces: Vectors, motions: Array) -> Greatest:
        """Return forces and motions in the order of the system."""
        rows, columns = np.empty((self._rows + 1, motions.shape[1])), np.empty_like(motions)
        rows[self._places] = forces
        columns[self._order] = motions
        return Greatest(rows[:-1], columns)

    def slips(self, motions: Array) -> Vectors:
        """Return the slips of motions."""
        slips: Vectors = (self.matrix @ motions).reshape(*self._places.shape, -1)
        return slips

    def onto(self, forces: Vectors) -> Array:
        """Return the loads (columns, programs) that forces balance."""
        balanced: Array = self._transposed @ forces.reshape(self._places.size, -1)
        return balanced

    def missing(self, forces: Vectors) -> Array:
        """Return the loads that forces do not balance."""
        return self.loads - self.onto(forces)

    def centre(self, forces: Vectors) -> "_Centre | None":
        """Return the analytic centre, by Newton's method from forces of one program; None if there is none."""
        for _ in range(MOST_CENTRINGS):
            size = _size(forces)
            if not (np.isfinite(size).all() and (size > 0.0).all() and (forces[0] > 0.0).all()):
                return None
            slips = SIGNS * forces / size**2  # minus the gradient of the barrier
            scaling = _Scaling.between(forces, slips)
            factors = self.square.factorized(scaling)
            motion = factors.solve(self.onto(scaling.squared(slips)) - self.missing(forces))
            change = scaling.squared(slips - self.slips(motion))
            if np.square(scaling.inverse(change)).sum() < CENTRED**2:
                return _Centre(forces, motion, scaling, factors.copy())
            forces = forces + np.minimum(1.0, TOWARDS_CENTRE * _length(forces, change)) * change
        return None


@dataclass(frozen=True, slots=True, eq=False)
class _Centre:
    """The analytic centre of all forces that balance the loads."""

    forces: Vectors  # of one program
    motion: Array  # (columns, 1) whose slips are minus the gradient of the barrier
    scaling: "_Scaling"
    factors: "_Factors"


class _Points:
    """Forces and motions of programs that are not finished, and the last ones of those that are."""

    def __init__(self, last_forces: Vectors, last_motions: Array) -> None:
        self.last_forces, self.last_motions = last_forces, last_motions
        self.forces, self.motions = last_forces[..., :0], last_motions[:, :0]
        self.numbers = self.steps = np.arange(0)

    def add(self, numbers: Indices, forces: Vectors, motions: Array) -> None:
        """Begin with the programs of these numbers."""
        self.numbers, self.steps = np.append(self.numbers, numbers), np.append(self.steps, np.zeros_like(numbers))
        self.forces = np.concatenate([self.forces, forces], axis=2)
        self.motions = np.concatenate([self.motions, motions], axis=1)

    def keep(self, going: NDArray[np.bool_]) -> None:
        """Store the points of all other programs as their last ones."""
        if going.all():
            return
        ended = self.numbers[~going]
        self.last_forces[..., ended], self.last_motions[:, ended] = self.forces[..., ~going], self.motions[:, ~going]
        self.forces, self.motions = self.forces[..., going], self.motions[:, going]
        self.numbers, self.steps = self.numbers[going], self.steps[going]

    def move(self, forces: Vectors, motions: Array) -> None:
        """Take the next points."""
        self.forces, self.motions, self.steps = forces, motions, self.steps + 1


@dataclass(frozen=True, slots=True, eq=False)
class _Scaling:
    """The symmetric matrices of Nesterov and Todd, one for each cone, whose squares map slips to forces."""

    axes: Vectors
    unit: Array  # (cones, programs)

    @classmethod
    def between(cls, forces: Vectors, slips: Vectors) -> Self:
        """Return the matrices that scale slips and forces to the same vectors."""
        of_forces, of_slips = _size(forces), _size(slips)
        one, other = forces / of_forces, slips / of_slips
        axes = (one + SIGNS * other) / np.sqrt(2.0 + 2.0 * (one * other).sum(axis=0))
        return cls(axes, np.sqrt(of_forces / of_slips))

    def factor(self, vectors: Vectors) -> Vectors:
        """Return the products of the matrices with vectors."""
        normal, first, second = self.axes
        along = first * vectors[1] + second * vectors[2]
        part = vectors[0] + along / (1.0 + normal)
        product: Vectors = self.unit * np.stack(
            [normal * vectors[0] + along, vectors[1] + first * part, vectors[2] + second * part]
        )
        return product

    def inverse(self, vectors: Vectors) -> Vectors:
        """Return the products of the inverse matrices with vectors."""
        return _Scaling(SIGNS * self.axes, 1.0 / self.unit).factor(vectors)

    def squared(self, vectors: Vectors) -> Vectors:
        """Return the products of the squares of the matrices with vectors."""
        along = (self.axes * vectors).sum(axis=0)
        squared: Vectors = self.unit**2 * (2.0 * self.axes * along - SIGNS * vectors)
        return squared

    def squares(self) -> Array:
        """Return (6 cones, programs) the entries of these squares, by `PAIRS`."""
        unit = self.unit**2
        entries = [2.0 * unit * self.axes[i] * self.axes[j] for i, j in PAIRS]
        for axis, sign in enumerate(SIGNS.ravel()):
            entries[axis] -= sign * unit
        return np.concatenate(entries)


class _BandedSquare:
    """The product of the transposed matrix, squared scalings and the matrix, as the lower half of a banded matrix."""

    def __init__(self, matrix: Matrix, cones: int, columns: Indices) -> None:
        """Store the places of all entries; `columns` (cones, 12) are those of each cone, or -1."""
        from scipy.sparse import csr_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

        self._count = matrix.shape[1]
        present = columns >= 0
        places = np.where(present, columns, 0)
        rows = np.arange(3 * cones).reshape(3, cones)
        entries = np.stack([_entries(matrix, each, places) * present for each in rows])
        one, other = np.tril_indices(columns.shape[1])
        late, early = np.maximum(places[:, one], places[:, other]), np.minimum(places[:, one], places[:, other])
        met = present[:, one] & present[:, other]
        self._width = 1 + int((late - early)[met].max(initial=0))
        at = early * self._width + late - early
        parts = [
            entries[i][:, one] * entries[j][:, other] + (i != j) * entries[j][:, one] * entries[i][:, other]
            for i, j in PAIRS
        ]
        used = [np.nonzero(part) for part in parts]
        entry = np.concatenate([at[which] for which in used])
        self._at = np.flatnonzero(np.bincount(entry))
        number = np.empty(self._count * self._width, dtype=np.int64)
        number[self._at] = np.arange(len(self._at))
        squares = np.concatenate([pair * cones + cone for pair, (cone, _) in enumerate(used)])
        factors = np.concatenate([part[which] for part, which in zip(parts, used, strict=True)])
        self._sums = csr_matrix((factors, (number[entry], squares)), shape=(len(self._at), len(PAIRS) * cones))
        self._bands = np.empty((min(BATCH, MOST_ENTRIES // (self._count * self._width)), self._count * self._width))

    @property
    def programs(self) -> int:
        """Return the number of programs whose matrices there is space for."""
        return len(self._bands)

    def factorized(self, scaling: _Scaling) -> "_Factors":
        """Return the Cholesky factors of the matrices of all programs, valid until the next call; None without one."""
        from scipy.linalg.lapack import dpbtrf  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

        factors = []
        every = np.ascontiguousarray((self._sums @ scaling.squares()).T)
        bands = self._bands[: len(every)]
        bands.fill(0.0)
        for band, entries in zip(bands, every, strict=True):
            band[self._at] = entries
            lower = band.reshape(self._count, self._width).T
            lower[0] *= 1.0 + ROUNDING
            factor, fault = dpbtrf(lower, lower=1, overwrite_ab=1)
            factors.append(None if fault else factor)
        return _Factors(factors)


@dataclass(frozen=True, slots=True, eq=False)
class _Factors:
    """Banded Cholesky factors of programs, or the only one that they share."""

    factors: Sequence[Array | None]

    def copy(self) -> Self:
        """Return the same factors in memory of their own."""
        return type(self)([None if factor is None else factor.copy("F") for factor in self.factors])

    def solve(self, loads: Array) -> Array:
        """Return the solutions for loads (columns, programs), or for one that all share; NaN without a factor."""
        from scipy.linalg.lapack import dpbtrs  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

        if len(self.factors) == 1 and self.factors[0] is not None:
            solved: Array = dpbtrs(self.factors[0], loads, lower=1)[0]
            return solved
        every = np.broadcast_to(loads.T, (len(self.factors), len(loads)))
        each = [
            np.full(len(own), nan) if factor is None else dpbtrs(factor, own, lower=1)[0]
            for factor, own in zip(self.factors, every, strict=True)
        ]
        return np.stack(each, axis=1)


def _with_empty_row(matrix: Matrix) -> Matrix:
    from scipy.sparse import csr_matrix, vstack  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    return vstack([matrix, csr_matrix((1, matrix.shape[1]))], format="csr")


def _columns_of(system: WrenchMatrix, order: Indices) -> Indices:
    """Return (cones, 12) the places in an order of the columns of the two bricks of each cone, or -1."""
    bricks = len(system.names)
    places = np.full(OF_A_BRICK * (bricks + 1), -1)
    places[system.kept[order]] = np.arange(len(order))
    which = np.append(system.round, system.flat)
    bodies = np.stack([system.cones.lower[which], system.cones.upper[which]], axis=1)
    columns: Indices = places.reshape(-1, OF_A_BRICK)[bodies].reshape(len(which), -1)
    return columns


def _narrow_order(system: WrenchMatrix) -> Indices:
    """Return an order of the columns in which those of touching bricks are close to each other.

    Bricks are visited breadth-first, those with few neighbours first (Cuthill and McKee), from some first bricks.
    """
    count = len(system.names)
    beside: list[set[int]] = [set() for _ in range(count)]
    pairs = set(zip(system.cones.lower.tolist(), system.cones.upper.tolist(), strict=True))
    between = [pair for pair in pairs if max(pair) < count]
    for one, other in between:
        beside[one].add(other)
        beside[other].add(one)
    near = [sorted(each, key=lambda brick: (len(beside[brick]), brick)) for each in beside]
    best, least = np.arange(count), count
    one, other = np.array(between, dtype=np.int64).reshape(-1, 2).T
    for first in range(0, count, max(1, count**2 // VISITS)):
        place = np.empty(count, dtype=np.int64)
        place[_visited(near, first)] = np.arange(count)
        widest = int(np.abs(place[one] - place[other]).max(initial=0))
        if widest < least:
            best, least = place, widest
    order: Indices = np.argsort(OF_A_BRICK * best[system.kept // OF_A_BRICK] + system.kept % OF_A_BRICK)
    return order


def _visited(near: Sequence[Sequence[int]], first: int) -> list[int]:
    """Return all bricks in the order in which they are visited."""
    seen, visited = [False] * len(near), list[int]()
    for start in (first, *range(len(near))):
        if seen[start]:
            continue
        seen[start] = True
        last = len(visited)
        visited.append(start)
        while last < len(visited):
            for brick in near[visited[last]]:
                if not seen[brick]:
                    seen[brick] = True
                    visited.append(brick)
            last += 1
    return visited


def _multiples(rows: Array) -> tuple[Indices, Array]:
    """Return for each column the first one of which it is a positive multiple, and the factor; itself if it is zero."""
    size = np.sqrt(np.einsum("ij,ij->j", rows, rows))
    of, times = np.arange(len(size)), np.ones(len(size))
    units = rows / np.where(size > 0.0, size, 1.0)
    alike = units.T @ units > 1.0 - ALIKE
    for number in np.flatnonzero(size > 0.0).tolist():
        for first in np.flatnonzero(alike[number, :number]).tolist():
            if of[first] == first and np.abs(units[:, number] - units[:, first]).max() < ALIKE:
                of[number], times[number] = first, size[number] / size[first]
                break
    return of, times


def _total(products: Vectors) -> Array:
    """Return the sum of products of all cones by program."""
    total: Array = products.sum(axis=(0, 1))
    return total


def _size(vectors: Vectors) -> Array:
    """Return (cones, programs) the roots of n^2 - t^2 of vectors within cones; NaN outside."""
    sliding = np.hypot(vectors[1], vectors[2])
    size: Array = np.sqrt((vectors[0] - sliding) * (vectors[0] + sliding))
    return size


def _farthest(vectors: Vectors) -> Array:
    """Return by program the greatest norm of a vector of a cone: the distance within which a centre has room."""
    farthest: Array = (np.abs(vectors[0]) + np.hypot(vectors[1], vectors[2])).max(axis=0)
    return farthest


def _length(vectors: Vectors, change: Vectors) -> Array:
    """Return by program the share of a change that leads the first vector to the border of its cone; NaN stays NaN."""
    squared, mixed, first = _square(change, change), _square(vectors, change), _square(vectors, vectors)
    inner = mixed * mixed - squared * first
    nearer = np.sqrt(np.maximum(inner, 0.0)) - mixed
    leaves = (inner >= 0.0) & ((squared < 0.0) | (mixed < 0.0))
    # The inverse of the length: rounding may leave 0 / 0 where nothing changes.
    inverse = np.divide(nearer, first, out=np.zeros_like(mixed), where=leaves)
    with np.errstate(divide="ignore"):
        shortest: Array = 1.0 / (inverse.max(axis=0) + 0.0 * mixed.sum(axis=0))
    return shortest


def _square(one: Vectors, other: Vectors) -> Array:
    """Return (cones, programs) the products of the normal parts less those of the tangential ones."""
    square: Array = one[0] * other[0] - one[1] * other[1] - one[2] * other[2]
    return square


def _product(one: Vectors, other: Vectors) -> Vectors:
    """Return the products of vectors in the algebra of the cones."""
    normal = (one * other).sum(axis=0)
    return np.stack([normal, one[0] * other[1] + other[0] * one[1], one[0] * other[2] + other[0] * one[2]])


def _quotient(product: Vectors, one: Vectors) -> Vectors:
    """Return the vectors whose products with `one` are given."""
    along = one[1] * product[1] + one[2] * product[2]
    normal = (one[0] * product[0] - along) / _size(one) ** 2
    return np.stack([normal, *((product[i] - normal * one[i]) / one[0] for i in (1, 2))])


def _entries(matrix: Matrix, rows: Indices, columns: Indices) -> Array:
    """Return the entries of a matrix in the given columns (rows, n) of some rows."""
    found = matrix[np.repeat(rows, columns.shape[1]), columns.ravel()]
    return np.asarray(found).reshape(columns.shape)
