"""Rows of contacts in conic programs: three for each cone with friction, then one for each contact point without."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from stability.contact_law import Coulomb
from stability.geometry.rows import Array, Indices
from stability.statics.conic_program import ConicProgram, Matrix

UNIT = Coulomb(1.0)
# Factors on the squared components of a force in a cone of unit slope: their sum and the first component are not
# negative.
SQUARES = np.array([1.0, -1.0, -1.0])

Number = TypeVar("Number", bound=np.generic)


def with_and_without(friction: Array) -> tuple[Indices, Indices]:
    """Return the indices of the cones with friction, which are round, and of those without, which are rays."""
    rubs = friction > 0.0
    return np.flatnonzero(rubs), np.flatnonzero(~rubs)


def row_units(friction: Array) -> Array:
    """Return (cones, 3) the units of normal and tangential forces in which each cone has unit slope."""
    ones = np.ones(len(friction))
    return np.stack([ones, friction, friction], axis=1)


@dataclass(frozen=True, slots=True)
class ConeRows:
    """Positions of the forces or slips of contacts among the rows of a vector or a matrix.

    In `row_units` every cone has unit slope, for forces and for slips: the first of its three rows, the normal one, is
    at least the norm of the other two.
    """

    round: int  # number of cones with friction, with rows 3 i to 3 i + 2
    flat: int  # number of cones without friction, with rows 3 round + i

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.of_round + self.flat

    @property
    def of_round(self) -> int:
        """Return the number of rows of the cones with friction, which come first."""
        return 3 * self.round

    @property
    def normals(self) -> Indices:
        """Return (cones,) the rows of normal forces."""
        return np.append(np.arange(0, self.of_round, 3), np.arange(self.of_round, len(self)))

    def triples(self, rows: Array) -> Array:
        """Return (..., round, 3) the rows of the cones with friction: a view."""
        return rows[..., : self.of_round].reshape(*rows.shape[:-1], self.round, 3)

    def singles(self, rows: Array) -> Array:
        """Return (..., flat) the rows of the cones without friction: a view."""
        return rows[..., self.of_round :]

    def joined(self, triples: NDArray[Number], singles: NDArray[Number]) -> NDArray[Number]:
        """Return the rows of (round, 3) and (flat,)."""
        return np.append(triples.ravel(), singles)

    def by_row(self, of_cones: NDArray[Number]) -> NDArray[Number]:
        """Return the number of the cone of each row."""
        return np.append(np.repeat(of_cones[: self.round], 3), of_cones[self.round :])

    def spare(self, rows: Array) -> Array:
        """Return (cones,) the distance of each force or slip from the border of its cone; negative outside."""
        triples = self.triples(rows)
        return np.append(triples[:, 0] - np.hypot(triples[:, 1], triples[:, 2]), self.singles(rows))

    def project(self, rows: Array) -> Array:
        """Return the nearest forces or slips within their cones."""
        triples = self.triples(rows)
        tangential = np.hypot(triples[:, 1], triples[:, 2])
        normal, kept = UNIT.project(triples[:, 0], tangential)
        share = np.where(kept == tangential, 1.0, kept / np.where(tangential > 0.0, tangential, 1.0))
        nearest = np.stack([normal, triples[:, 1] * share, triples[:, 2] * share], axis=1)
        return self.joined(nearest, np.maximum(self.singles(rows), 0.0))

    def least_share(self, rows: Array, deep: Array) -> float:
        """Return the least share of forces deep in their cones that brings others into their cones."""
        outside = self.spare(rows)[: self.round] < 0.0
        own, change = self.triples(rows)[outside], self.triples(deep - rows)[outside]
        # (t + s dt)^2 = (n + s dn)^2: the cone is entered at the last root; an earlier root lies on the opposite cone.
        squared, mixed, first = ((x * y) @ -SQUARES for x, y in ((change, change), (own, change), (own, own)))
        root = np.sqrt(np.maximum(mixed * mixed - squared * first, 0.0))
        larger = -(mixed + np.copysign(root, mixed))
        with np.errstate(divide="ignore", invalid="ignore"):
            crossings = np.stack([larger / squared, first / larger])
            flat = -self.singles(rows) / self.singles(deep - rows)
        crossings[~((crossings >= 0.0) & (crossings <= 1.0))] = 0.0
        flat = np.where(self.singles(rows) < 0.0, flat, 0.0)
        return float(max(crossings.max(initial=0.0), flat.max(initial=0.0)))

    def barrier(self, rows: Array) -> tuple[Array, Array]:
        """Return the gradient and the inverse Hessian of minus the logarithm of the slacks of forces.

        The inverse Hessian is z z' - (q / 2) J for each cone with friction, (round, 3, 3), then a number for each
        without.
        """
        triples, singles = self.triples(rows), self.singles(rows)
        spare = (triples * triples) @ SQUARES
        gradient = self.joined(-2.0 * SQUARES * triples / spare[:, None], -1.0 / singles)
        blocks = triples[:, :, None] * triples[:, None, :] - 0.5 * spare[:, None, None] * np.diag(SQUARES)
        return gradient, np.append(blocks.ravel(), singles * singles)

    def program(  # noqa: PLR0913 -- a program, spelt out
        self,
        cost: Array,
        matrix: Matrix,
        offset: Array,
        *,
        equal: int = 0,
        norms: Sequence[int] = (),
        positive: int = 0,
        curvature: Matrix = None,
        semidefinite: int = 0,
    ) -> ConicProgram:
        """Return the program whose rows are `equal` equalities, these rows, and other rows.

        Other round cones, of the sizes `norms`, come between the cones with friction and those without; `positive` rows
        that must not be negative come after these, and the semidefinite cone last.
        """
        sizes = [3] * self.round + [*norms]
        return ConicProgram(cost, matrix, offset, equal, sizes, self.flat + positive, curvature, semidefinite)
