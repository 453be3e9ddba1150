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
# Times the squares of the three parts of a force in a cone of unit slope: their sum is not negative, nor is the first.
SQUARES = np.array([1.0, -1.0, -1.0])

Number = TypeVar("Number", bound=np.generic)


def with_and_without(friction: Array) -> tuple[Indices, Indices]:
    """Which cones have friction, and are round, and which have none, and are rays."""
    rubs = friction > 0.0
    return np.flatnonzero(rubs), np.flatnonzero(~rubs)


def row_units(friction: Array) -> Array:
    """(cones, 3) the units of the normal and the tangential forces of each, in which its cone is of unit slope."""
    ones = np.ones(len(friction))
    return np.stack([ones, friction, friction], axis=1)


@dataclass(frozen=True, slots=True)
class ConeRows:
    """Where the forces of contacts, or their slips, are among the rows of a vector or a matrix.

    In `row_units` every cone is of unit slope, of forces as of slips: the first of its three rows, the normal one, is
    no less than the norm of the other two.
    """

    round: int  # cones with friction, which have rows 3 i to 3 i + 2
    flat: int  # those without, which have rows 3 round + i

    def __len__(self) -> int:
        """How many rows there are."""
        return self.of_round + self.flat

    @property
    def of_round(self) -> int:
        """How many rows the cones with friction have, which come first."""
        return 3 * self.round

    @property
    def normals(self) -> Indices:
        """(cones,) the rows of normal forces."""
        return np.append(np.arange(0, self.of_round, 3), np.arange(self.of_round, len(self)))

    def triples(self, rows: Array) -> Array:
        """(..., round, 3) those of the cones with friction: a view."""
        return rows[..., : self.of_round].reshape(*rows.shape[:-1], self.round, 3)

    def singles(self, rows: Array) -> Array:
        """(..., flat) those of the cones without: a view."""
        return rows[..., self.of_round :]

    def joined(self, triples: NDArray[Number], singles: NDArray[Number]) -> NDArray[Number]:
        """The rows of (round, 3) and (flat,)."""
        return np.append(triples.ravel(), singles)

    def by_row(self, of_cones: NDArray[Number]) -> NDArray[Number]:
        """For each row the number of its cone."""
        return np.append(np.repeat(of_cones[: self.round], 3), of_cones[self.round :])

    def spare(self, rows: Array) -> Array:
        """(cones,) how far each force, or slip, is inside its cone; negative outside."""
        triples = self.triples(rows)
        return np.append(triples[:, 0] - np.hypot(triples[:, 1], triples[:, 2]), self.singles(rows))

    def project(self, rows: Array) -> Array:
        """The nearest forces, or slips, in their cones."""
        triples = self.triples(rows)
        tangential = np.hypot(triples[:, 1], triples[:, 2])
        normal, kept = UNIT.project(triples[:, 0], tangential)
        share = np.where(kept == tangential, 1.0, kept / np.where(tangential > 0.0, tangential, 1.0))
        nearest = np.stack([normal, triples[:, 1] * share, triples[:, 2] * share], axis=1)
        return self.joined(nearest, np.maximum(self.singles(rows), 0.0))

    def least_share(self, rows: Array, deep: Array) -> float:
        """The least share of forces deep in their cones that brings others into these."""
        outside = self.spare(rows)[: self.round] < 0.0
        own, change = self.triples(rows)[outside], self.triples(deep - rows)[outside]
        # (t + s dt)^2 = (n + s dn)^2: the way in is the last crossing, as one before is of the cone upside down.
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
        """Of minus the logarithm of all that forces have to spare, the gradient and the inverse of the Hessian.

        The latter is z z' - (q / 2) J for each cone with friction, (round, 3, 3), then a number for each without.
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
        """The program whose rows are `equal` equalities, these, and others.

        Other round cones, of the sizes `norms`, stand between the cones with friction and those without; `positive`
        rows that must not be negative come after these, and the semidefinite cone last.
        """
        sizes = [3] * self.round + [*norms]
        return ConicProgram(cost, matrix, offset, equal, sizes, self.flat + positive, curvature, semidefinite)
