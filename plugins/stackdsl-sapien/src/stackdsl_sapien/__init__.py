"""Systems of StackDSL on PhysX 5 through SAPIEN. The engine is imported when a world is opened."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from stability.engines.protocol import EngineSettings, Package
from stability.engines.scene_scale import SceneScale, power_of_two
from stackdsl.simulation.systems import Method, System


@dataclass(frozen=True, kw_only=True)
class SapienSettings(EngineSettings):
    """Settings of PhysX, which solves for positions first, and for velocities after them."""

    package: ClassVar[Package] = Package("sapien", "pip install stackdsl-sapien")
    world: ClassVar[str] = "stackdsl_sapien.world:SapienWorld"

    iterations: int  # of positions, per step
    velocity_iterations: int
    contact_offset: float  # [m] shapes whose distance is below twice this value have contacts

    def numerics(self) -> Iterator[str]:
        yield f"{self.iterations} iterations"
        yield f"{self.velocity_iterations} velocity iterations"
        yield f"contact offset {1000.0 * self.contact_offset:g} mm"

    def refined(self) -> Self:
        return replace(super().refined(), iterations=2 * self.iterations)

    def scaled(self, scene: SceneScale) -> Self:
        """Return the settings for a scene of another scale; the contact offset scales with the thickness of a brick."""
        return replace(super().scaled(scene), contact_offset=self.contact_offset * power_of_two(scene.median_diagonal))


# The most stable settings in trials. Steps are split while a body moves more than 1 mm per step, as for `exact`.
SETTINGS = SapienSettings(
    time_step=1.0 / 960.0, iterations=20, velocity_iterations=1, contact_offset=0.001, most_travel=0.001
)
SAPIEN = System("sapien", "PhysX 5 with settings tuned for stacks", SETTINGS, method=None)
SAPIEN_THESIS = System("sapien-thesis", "PhysX 5 with the published stack-stability method", SETTINGS, Method.PUBLISHED)
