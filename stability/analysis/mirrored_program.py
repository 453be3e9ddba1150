"""Mirror symmetries of an assembly in plan, which shrink its conic programs.

A convex program that a mirror maps onto itself has a mirrored solution, as the mean of a solution and its image is one
too. So one variable and one row of each orbit are enough. A structure that is not quite symmetric has other solutions;
what a caller takes from one is checked by arithmetic on the whole structure.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from stability.geometry.rows import Array, Indices
from stability.statics.conic_program import ConicProgram, clarabel_solve

Sparse: TypeAlias = Any  # scipy's matrices have no types

EXACT = 1e-9  # relative error of an image
MIRRORS = ((-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))  # signs of x and y: both mirrors, and the half turn


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """Equal parts of a structure, such as its contacts, that mirrors may map onto each other."""

    vectors: Array  # (parts, 2 k) vectors in plan from the middle, such as places: x and y in turn
    scalars: Array  # (parts, k) numbers that an image shares

    def images(self, mirror: tuple[float, float]) -> Indices | None:
        """Return the image of each part; None if one has none."""
        from scipy.spatial import cKDTree  # noqa: PLC0415 -- slow to import, and few need it

        if not len(self.vectors):
            return np.zeros(0, dtype=np.int64)
        largest = np.abs(self.vectors).reshape(len(self.vectors), -1, 2).max(axis=(0, 2))  # of each vector
        sizes = np.append(np.repeat(largest, 2), np.abs(self.scalars).max(axis=0))
        there = np.hstack([self.vectors, self.scalars]) / np.where(sizes > 0.0, sizes, 1.0)
        signs = np.append(np.tile(mirror, self.vectors.shape[1] // 2), np.ones(self.scalars.shape[1]))
        distance, which = cKDTree(there).query(there * signs, distance_upper_bound=EXACT)
        images: Indices = np.asarray(which, dtype=np.int64)
        return images if np.isfinite(distance).all() and len(np.unique(images)) == len(images) else None


# the parts, and for each of their rows or columns whether a mirror of x and a mirror of y reverse its sign
Block: TypeAlias = tuple[Parts, Sequence[tuple[bool, bool]]]


@dataclass(frozen=True, slots=True, eq=False)
class Folded:
    """Program of one part of each orbit, and the solution of the whole program from its solution."""

    program: ConicProgram
    columns: Sparse  # (columns, folded columns)

    def whole(self, accuracy: float) -> Array:
        """Return the solution of the whole program."""
        x: Array = self.columns @ clarabel_solve(self.program, accuracy).x
        return x


def folded(program: ConicProgram, rows: Sequence[Block], columns: Sequence[Block]) -> Folded | None:
    """Return a folded program; None without a symmetry. Round cones are blocks of their size."""
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import, and few need it

    mirrors = [mirror for mirror in MIRRORS if all(part.images(mirror) is not None for part, _ in (*rows, *columns))]
    if not mirrors:
        return None
    first, sign = _orbits(columns, mirrors)
    free, number = np.unique(first[sign != 0.0], return_inverse=True)
    place = np.flatnonzero(sign)
    spread = csc_matrix((sign[place], (place, number)), shape=(len(first), len(free)))
    first, sign = _orbits(rows, mirrors)
    is_cone = np.zeros(len(first), dtype=bool)
    is_cone[program.equal : program.equal + sum(program.round)] = True
    kept = (first == np.arange(len(first))) & ((sign != 0.0) | is_cone)
    cones = np.cumsum([program.equal, *program.round[:-1]]) if program.round else np.zeros(0, dtype=np.int64)
    round_kept = [size for size, begin in zip(program.round, cones.tolist(), strict=True) if kept[begin]]
    positive = len(first) - program.positive
    smaller = replace(
        program,
        cost=program.cost @ spread,
        matrix=(program.matrix @ spread)[kept].tocsc(),
        offset=program.offset[kept],
        equal=int(kept[: program.equal].sum()),
        round=round_kept,
        positive=int(kept[positive:].sum()),
    )
    return Folded(smaller, spread)


def _orbits(blocks: Sequence[Block], mirrors: Sequence[tuple[float, float]]) -> tuple[Indices, Array]:
    """Return the first row of the orbit of each, and its sign relative to that one: 0 if an image is its opposite."""
    firsts, signs, start = [], [], 0
    for part, odd in blocks:
        own = np.arange(len(part.vectors))
        first, sign = np.repeat(own[:, None], len(odd), axis=1), np.ones((len(own), len(odd)))
        opposite = np.zeros(sign.shape, dtype=bool)
        for mirror in mirrors:
            images = part.images(mirror)
            assert images is not None  # such mirrors are left out
            turned = np.array([mirror[0] ** x * mirror[1] ** y for x, y in odd])
            nearer = images[:, None] < first
            first = np.where(nearer, images[:, None], first)
            sign = np.where(nearer, turned, sign)
            opposite |= (images == own)[:, None] & (turned < 0.0)
        firsts.append((start + first * len(odd) + np.arange(len(odd))).ravel())
        signs.append(np.where(opposite, 0.0, sign).ravel())
        start += sign.size
    return np.concatenate(firsts), np.concatenate(signs)
