"""Settings of the rigid-body engine; importing them does not import the engine."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from stability.engines.protocol import EngineSettings, Package
from stability.engines.scene_scale import SceneScale, power_of_two


@dataclass(frozen=True, slots=True)
class Solving:
    """Accuracy to which the impulses of a time step are solved."""

    parts: int  # sub-steps of a time step
    sweeps: int  # most sweeps of Gauss-Seidel over the contact points in a sub-step
    accuracy: float  # [m/s] change of a closing speed in a sweep that ends them


@dataclass(frozen=True, kw_only=True)
class RigidSettings(EngineSettings):
    """Settings of the rigid-body engine."""

    package: ClassVar[Package] = Package("numba", "pip install numba")  # compiles the engine
    name: ClassVar[str] = "rigid"
    world: ClassVar[str] = "stability.engines.rigid.world:RigidWorld"
    most_gain: ClassVar[float] = 0.001
    records_steps: ClassVar[bool] = True

    falling: Solving  # before the first hit, with hard contacts: small errors at the start of a fall grow
    struck: Solving  # later, with soft contacts, which share out the load among many points
    hit: float  # [m/s] least change of a closing speed in a hit
    recovery: float  # [m/s] largest speed at which overlapping bodies separate
    edge_radius: float  # [m] of edges that meet, at most a fiftieth of the smallest side of a body

    def numerics(self) -> Iterator[str]:
        yield f"{self.falling.parts} sub-steps of up to {self.falling.sweeps} sweeps before a hit"
        yield f"{self.struck.parts} of up to {self.struck.sweeps} after it"
        yield f"edge radius {1000.0 * self.edge_radius:g} mm"

    def refined(self) -> Self:
        return replace(
            super().refined(),
            falling=replace(self.falling, sweeps=2 * self.falling.sweeps),
            struck=replace(self.struck, sweeps=2 * self.struck.sweeps),
        )

    def scaled(self, scene: SceneScale) -> Self:
        """Adapt the time step as for every engine; lengths scale with the median brick, speeds with its toppling speed.

        Thin bricks need no shorter steps, as gaps may close within a step and no more.
        """
        size, slower = power_of_two(scene.median_diagonal), power_of_two(scene.slower)
        speed = size / slower
        return replace(
            super().scaled(scene),
            most_travel=None if self.most_travel is None else self.most_travel * size,
            falling=replace(self.falling, accuracy=self.falling.accuracy * speed),
            struck=replace(self.struck, accuracy=self.struck.accuracy * speed),
            hit=self.hit * speed,
            recovery=self.recovery * speed,
            edge_radius=self.edge_radius * size,
        )
