"""How SAPIEN steps; no engine is needed to say so."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from stability.engines.protocol import EngineSettings, Package
from stability.engines.scene_scale import SceneScale, power_of_two


@dataclass(frozen=True, kw_only=True)
class SapienSettings(EngineSettings):
    """PhysX solves for positions first, and for velocities after them."""

    package: ClassVar[Package] = Package("sapien", "pip install 'stackdsl[sapien]'")
    world: ClassVar[str] = "stability.engines.sapien.world:SapienWorld"

    iterations: int  # of positions, per step
    velocity_iterations: int
    contact_offset: float  # [m] shapes closer to each other than twice this have contacts

    def numerics(self) -> Iterator[str]:
        yield f"{self.iterations} iterations"
        yield f"{self.velocity_iterations} of velocities"
        yield f"contact offset {1000.0 * self.contact_offset:g} mm"

    def refined(self) -> Self:
        return replace(super().refined(), iterations=2 * self.iterations)

    def scaled(self, scene: SceneScale) -> Self:
        """As of every engine; contacts are found as early, in thicknesses of a brick."""
        return replace(super().scaled(scene), contact_offset=self.contact_offset * power_of_two(scene.median_diagonal))
