"""Do forces that were found in some directions hold in all directions between?

With t = tan(angle / 2), (1 + t^2) (1, cos angle, sin angle) is a polynomial of degree 2 in t. What balances 1 and an
acceleration of a given size in three directions or more therefore balances it, times 1 + t^2, in all directions, if
interpolated as a polynomial after being multiplied with 1 + t^2. Whether that stays within the cones on an arc is
shown by coefficients in Bernstein's basis: a polynomial of which none is negative is not negative between 0 and 1.
"""

from collections.abc import Sequence
from functools import cache
from math import comb, tan

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Of forces in units of what bricks may carry: what is outside a cone by less is rounding, as it is for `proof`.
ROUNDING = 1e-12


def stay_inside(forces: Array, round_cones: int, angles: Sequence[float], half: float) -> bool:
    """Whether forces interpolated between those at `angles` are within their cones from -`half` to `half` [rad].

    `forces` (angles, rows): three rows for each round cone, which is of unit slope, then the normals of the others.
    """
    edge = tan(0.5 * half)
    nodes = np.array([tan(0.5 * angle) for angle in angles])
    degree = len(angles) - 1
    basis = _bernstein(degree, 0.5 + 0.5 * nodes / edge)
    controls = np.linalg.solve(basis, forces * (1.0 + nodes * nodes)[:, None])
    held = 3 * round_cones
    if (controls[:, held:] < -ROUNDING).any():
        return False
    cones = controls[:, :held].reshape(degree + 1, -1, 3)
    if (cones[:, :, 0] < -ROUNDING).any():
        return False
    signed = cones * np.array([1.0, -1.0, -1.0])
    spare = np.einsum("mij,ikc,jkc->mk", _products(degree), signed, cones, optimize=True)
    return bool((spare >= -ROUNDING * np.maximum(cones[:, :, 0].max(axis=0), 1.0)).all())


def _bernstein(degree: int, at: Array) -> Array:
    """(points, degree + 1) Bernstein's polynomials."""
    return np.stack([comb(degree, i) * at**i * (1.0 - at) ** (degree - i) for i in range(degree + 1)], axis=1)


@cache
def _products(degree: int) -> Array:
    """(2 degree + 1, degree + 1, degree + 1): the coefficients of a product of two polynomials."""
    table = np.zeros((2 * degree + 1, degree + 1, degree + 1))
    for i in range(degree + 1):
        for j in range(degree + 1):
            table[i + j, i, j] = comb(degree, i) * comb(degree, j) / comb(2 * degree, i + j)
    return table
