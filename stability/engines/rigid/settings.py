"""Settings of the rigid-body engine; importing them does not import the engine."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from stability.engines.protocol import EngineSettings, Package
from stability.engines.scene_scale import SceneScale, power_of_two


@dataclass(frozen=True, kw_only=True)
class RigidSettings(EngineSettings):
    """Settings of the rigid-body engine."""

    package: ClassVar[Package] = Package("numba", "pip install numba")  # compiles the engine
    name: ClassVar[str] = "rigid"
    world: ClassVar[str] = "stability.engines.rigid.world:RigidWorld"

    parts: int  # sub-steps of a time step
    sweeps: int  # of Gauss-Seidel over the contact points, in each sub-step at least
    most_sweeps: int  # in each sub-step, as long as a sweep changes a closing speed by more than the accuracy
    accuracy: float  # [m/s]
    recovery: float  # [m/s] largest speed at which overlapping bodies separate
    edge_radius: float  # [m] of edges that meet, at most a fiftieth of the smallest side of a body

    def numerics(self) -> Iterator[str]:
        yield f"{self.parts} sub-steps of {self.sweeps} sweeps"
        yield f"edge radius {1000.0 * self.edge_radius:g} mm"

    def refined(self) -> Self:
        return replace(super().refined(), sweeps=2 * self.sweeps)

    def scaled(self, scene: SceneScale) -> Self:
        """Adapt the time step as for every engine; lengths scale with the median brick, speeds with its toppling speed.

        Thin bricks need no shorter steps, as gaps may close within a step and no more.
        """
        size, slower = power_of_two(scene.median_diagonal), power_of_two(scene.slower)
        return replace(
            super().scaled(scene),
            most_travel=None if self.most_travel is None else self.most_travel * size,
            accuracy=self.accuracy * size / slower,
            recovery=self.recovery * size / slower,
            edge_radius=self.edge_radius * size,
        )
