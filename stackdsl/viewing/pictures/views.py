"""From where a scene is looked at, and where its points are on paper: parallel projections, without perspective."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class View:
    """A direction to look from."""

    name: str
    towards: Floats  # (3,) unit, to who looks
    right: Floats  # (3,) unit
    up: Floats  # (3,) unit

    @classmethod
    def of(cls, name: str, towards: tuple[float, float, float], up: tuple[float, float, float]) -> "View":
        """Looked at from a direction of any length, with another one upwards on paper."""
        to = np.array(towards) / np.linalg.norm(towards)
        right = np.cross(up, to)
        right /= np.linalg.norm(right)
        return cls(name, to, right, np.cross(to, right))

    def on_paper(self, points_W: Floats) -> Floats:
        """Points (n, 3) in W to (n, 2) on paper, right and up [m]."""
        return points_W @ np.column_stack((self.right, self.up))


VIEWS: Final = {
    view.name: view
    for view in (
        View.of("three-quarter", (0.75, -1.0, 0.55), (0.0, 0.0, 1.0)),
        View.of("front", (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
        View.of("side", (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        View.of("plan", (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    )
}
