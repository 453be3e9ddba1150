"""Load factors of LEGO structures by the rule of StableLego (Liu et al., 2024), a linear program.

A stud pushes without bound and pulls up to 0.98 N at each of three points of a brick that is two or more studs wide,
and of four of a brick that is one wide; sideways it takes any force, in the faces of both bricks. Neighbours in a layer
push at half height (in the program of its authors, at their lower edge). Moments about the vertical are not balanced.
The three points are not symmetric, and do not turn with the brick, so a mirrored structure may have another load
factor.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix

from stability.model import EARTH

PULL: Final = 0.98  # [N] at each point
WIDE: Final = ((0.125, -0.125), (-0.25, 0.0), (0.125, 0.125))  # from the stud, in pitches
NARROW: Final = ((0.0, -0.25), (-0.25, 0.0), (0.0, 0.25), (0.25, 0.0))
MOST: Final = 1e4  # a larger load factor is not computed
EQUATIONS: Final = 5  # of a brick: forces along x, y, z, moments about x, y
Cell = tuple[int, int, int]


@dataclass(frozen=True)
class LegoBrick:
    """A brick by its lowest cell, in studs and bricks, and its extents in studs."""

    at: Cell
    size: tuple[int, int]
    mass: float  # [kg]


@dataclass
class _Program:
    """Equations of balance of all bricks, in unknown forces."""

    bricks: Sequence[LegoBrick]
    pitch: float  # [m]
    height: float  # of a brick [m]
    entries: list[tuple[int, int, float]] = field(default_factory=list)
    bounds: list[tuple[float | None, float | None]] = field(default_factory=list)

    def _push(self, number: int, sign: float, direction: int, point: tuple[float, float, float]) -> None:
        """Add the newest force to a brick, along x, y or z (0, 1, 2), at a point from its middle."""
        x, y, z = point
        moments = {0: (0.0, z), 1: (-z, 0.0), 2: (y, -x)}[direction]
        for row, value in ((direction, 1.0), (3, moments[0]), (4, moments[1])):
            self.entries.append((EQUATIONS * number + row, len(self.bounds), sign * value))

    def hold(
        self, cell: Cell, upper: int, lower: int | None, points: Sequence[tuple[float, float]], pull: float
    ) -> None:
        """Add the forces of the stud in a cell, between two bricks, or a brick and the base plate."""
        for direction, aside in [(0, (0.0, 0.0)), (1, (0.0, 0.0)), *((2, point) for point in points)]:
            for body, sign, side in ((upper, 1.0, -0.5), (lower, -1.0, 0.5)):
                if body is not None:
                    middle = _middle(self.bricks[body])
                    x, y = (self.pitch * (cell[axis] + aside[axis] - middle[axis]) for axis in (0, 1))
                    self._push(body, sign, direction, (x, y, side * self.height))
            self.bounds.append((-pull, None) if direction == 2 else (None, None))  # noqa: PLR2004 -- along z

    def part(self, one: int, other: int, direction: int) -> None:
        """Add the push of two neighbours along x or y (0, 1), at half height."""
        self._push(other, 1.0, direction, (0.0, 0.0, 0.0))
        self._push(one, -1.0, direction, (0.0, 0.0, 0.0))
        self.bounds.append((0.0, None))

    def load_factor(self) -> float:
        """Return the largest multiple of the weights. Raises ArithmeticError."""
        weight = max(brick.mass for brick in self.bricks) * EARTH
        for number, brick in enumerate(self.bricks):
            self.entries.append((EQUATIONS * number + 2, len(self.bounds), -brick.mass * EARTH))
        rows, columns, values = zip(*self.entries, strict=True)
        shape = (EQUATIONS * len(self.bricks), len(self.bounds) + 1)
        scale = np.where(np.arange(shape[0]) % EQUATIONS < 3, weight, weight * self.pitch)  # noqa: PLR2004 -- forces
        matrix = coo_matrix((np.array(values) / scale[list(rows)], (rows, columns)), shape).tocsr()
        cost = np.zeros(shape[1])
        cost[-1] = -1.0
        bounds = [*self.bounds, (0.0, MOST)]
        found = linprog(cost, A_eq=matrix, b_eq=np.zeros(shape[0]), bounds=bounds, method="highs")
        if found.status != 0:
            raise ArithmeticError(f"the linear program is not solved: {found.message}")
        return float(found.x[-1])


def rule_load_factor(
    bricks: Sequence[LegoBrick], pitch: float, height: float, mirrored: bool = False, pull: float = PULL
) -> float:
    """Return the largest multiple of its weight that a structure on a base plate bears, at most MOST.

    `mirrored` exchanges x and -x of the structure, by exchanging those of the points. Raises ArithmeticError.
    """
    cells = {cell: number for number, brick in enumerate(bricks) for cell in _cells(brick)}
    program = _Program(bricks, pitch, height)
    for (x, y, z), number in cells.items():
        below = cells.get((x, y, z - 1))
        if z == 0 or below is not None:
            points = WIDE if min(bricks[number].size) > 1 else NARROW
            turned = [(-a, b) for a, b in points] if mirrored else points
            program.hold((x, y, z), number, below, turned, pull)
        for direction, neighbour in ((0, (x + 1, y, z)), (1, (x, y + 1, z))):
            other = cells.get(neighbour, number)
            if other != number:
                program.part(number, other, direction)
    return program.load_factor()


def _cells(brick: LegoBrick) -> list[Cell]:
    x, y, z = brick.at
    return [(x + i, y + j, z) for i in range(brick.size[0]) for j in range(brick.size[1])]


def _middle(brick: LegoBrick) -> tuple[float, float]:
    """Return the middle of a brick, in the coordinates of the studs."""
    return brick.at[0] + 0.5 * (brick.size[0] - 1), brick.at[1] + 0.5 * (brick.size[1] - 1)
