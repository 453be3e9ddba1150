"""Systems of StackDSL on PhysX 5, by way of SAPIEN. Nothing here needs the engine until a world is opened."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from stability.engines.protocol import EngineSettings, Package
from stability.engines.scene_scale import SceneScale, power_of_two
from stackdsl.simulation.systems import Method, System


@dataclass(frozen=True, kw_only=True)
class SapienSettings(EngineSettings):
    """PhysX solves for positions first, and for velocities after them."""

    package: ClassVar[Package] = Package("sapien", "pip install stackdsl-sapien")
    world: ClassVar[str] = "stackdsl_sapien.world:SapienWorld"

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


# What stacked best in trials. Steps are split while a body gets further than 1 mm in one, as for `exact`.
SETTINGS = SapienSettings(
    time_step=1.0 / 960.0, iterations=20, velocity_iterations=1, contact_offset=0.001, most_travel=0.001
)
SAPIEN = System("sapien", "PhysX 5 with the settings that stack best", SETTINGS, method=None)
SAPIEN_THESIS = System("sapien-thesis", "PhysX 5 with the published stack-stability method", SETTINGS, Method.PUBLISHED)
