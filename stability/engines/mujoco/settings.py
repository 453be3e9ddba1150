"""Settings of MuJoCo; importing them does not import the engine."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from stability.engines.protocol import EngineSettings, Package
from stability.engines.scene_scale import SceneScale, power_of_two
from stability.model import Vec3


@dataclass(frozen=True, kw_only=True)
class MuJoCoSettings(EngineSettings):
    """Settings of MuJoCo, whose contacts are springs that overlap slightly."""

    package: ClassVar[Package] = Package("mujoco", "pip install 'stackdsl[mujoco]'")
    world: ClassVar[str] = "stability.engines.mujoco.world:MuJoCoWorld"

    iterations: int  # of the contact solver, per step, at most
    contact_time: float  # [s] time constant of a contact's critically damped spring (first value of `solref`)
    impedance_range: (
        Vec3  # of a contact: at no overlap, at full overlap, and that overlap [m] (first values of `solimp`)
    )
    friction_impedance: float  # relative to that of the normal force: contacts creep less with a larger value
    tolerance: float  # at which the solver stops

    def numerics(self) -> Iterator[str]:
        yield f"{self.iterations} iterations"
        yield f"contact time {1000.0 * self.contact_time:g} ms"
        yield f"impedance {' '.join(f'{part:g}' for part in self.impedance_range)}"
        yield f"friction impedance {self.friction_impedance:g}, tolerance {self.tolerance:g}"

    def refined(self) -> Self:
        return replace(super().refined(), iterations=2 * self.iterations)

    def scaled(self, scene: SceneScale) -> Self:
        """Adapt as for every engine; contact times scale with the time step, overlaps with the median brick."""
        free, full, overlap = self.impedance_range
        return replace(
            super().scaled(scene),
            contact_time=self.contact_time * power_of_two(scene.slower),
            impedance_range=(free, full, overlap * power_of_two(scene.median_diagonal)),
        )
