"""The turn that takes the axes of W to three others."""

import numpy as np
from numpy.typing import NDArray

from stability.model import Quaternion


def orientation_of(axes: NDArray[np.float64]) -> Quaternion:
    """The turn whose matrix (3, 3) this is: an eigenvector (Bar-Itzhack), which no angle makes singular."""
    xx, yy, zz = np.diag(axes)
    skew = (axes[2, 1] - axes[1, 2], axes[0, 2] - axes[2, 0], axes[1, 0] - axes[0, 1])
    of = np.zeros((4, 4))
    of[:3, :3] = axes + axes.T
    of[0, 0], of[1, 1], of[2, 2], of[3, 3] = xx - yy - zz, yy - xx - zz, zz - xx - yy, xx + yy + zz
    of[3, :3] = of[:3, 3] = skew
    x, y, z, w = np.linalg.eigh(of)[1][:, 3]
    return (float(x), float(y), float(z), float(w))
