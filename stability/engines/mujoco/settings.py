"""How MuJoCo steps; no engine is needed to say so."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from stability.engines.protocol import EngineSettings, Package
from stability.engines.scene_scale import SceneScale, power_of_two
from stability.model import Vec3


@dataclass(frozen=True, kw_only=True)
class MuJoCoSettings(EngineSettings):
    """The contacts of MuJoCo are springs, and may overlap a little."""

    package: ClassVar[Package] = Package("mujoco", "pip install 'stackdsl[mujoco]'")
    world: ClassVar[str] = "stability.engines.mujoco.world:MuJoCoWorld"

    iterations: int  # of the contact solver, per step, at most
    contact_time: float  # [s] of the spring of a contact (the first of `solref`), which is damped critically
    impedance_range: Vec3  # of a contact: without overlap, with some, and with how much [m] (the first of `solimp`)
    friction_impedance: float  # of friction, in units of that of the normal: the more, the less a contact creeps
    tolerance: float  # of the solver, which stops at it

    def numerics(self) -> Iterator[str]:
        yield f"{self.iterations} iterations"
        yield f"contacts of {1000.0 * self.contact_time:g} ms"
        yield f"impedance {' '.join(f'{part:g}' for part in self.impedance_range)}"
        yield f"friction {self.friction_impedance:g} times as stiff, tolerance {self.tolerance:g}"

    def refined(self) -> Self:
        return replace(super().refined(), iterations=2 * self.iterations)

    def scaled(self, scene: SceneScale) -> Self:
        """As of every engine; springs take as many steps as ever, and overlaps are the same share of a brick."""
        free, full, overlap = self.impedance_range
        return replace(
            super().scaled(scene),
            contact_time=self.contact_time * power_of_two(scene.slower),
            impedance_range=(free, full, overlap * power_of_two(scene.median_diagonal)),
        )
