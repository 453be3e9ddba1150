"""What the settings of every engine have in common; each engine adds its own, and nothing is left to defaults."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib.util import find_spec
from math import ceil
from typing import ClassVar, Self

from stability.engines.scene_scale import SceneScale, power_of_two


@dataclass(frozen=True, slots=True)
class Package:
    """A Python package that not everybody has."""

    name: str  # as it is imported
    remedy: str  # what brings it, as one types it

    @property
    def installed(self) -> bool:
        """Whether the package is there; it is not imported."""
        return find_spec(self.name) is not None


@dataclass(frozen=True, kw_only=True)
class EngineSettings(ABC):
    """How an engine steps, which engine it is, and how its settings follow the scene. Times and lengths are in SI.

    Settings can be made, scaled and told where the engine is not installed: a world is imported when it is opened.
    """

    package: ClassVar[Package]  # what the engine comes with
    world: ClassVar[str]  # `module:class` of its worlds, which is an `OpensWorlds` of `stability.engines.protocol`

    time_step: float  # [s]
    # [m] A body must not get further in one step, or it passes through a plank; steps are split while one is that fast.
    most_travel: float | None = None

    @abstractmethod
    def numerics(self) -> Iterator[str]:
        """What matters of the settings beside the time step, each in a few words."""

    def summary(self) -> str:
        """The settings in words."""
        return ", ".join((f"step 1/{1.0 / self.time_step:g} s", *self.numerics()))

    def at_step(self, factor: float) -> Self:
        """So many times the time step; all else as it was."""
        return replace(self, time_step=factor * self.time_step)

    def refined(self) -> Self:
        """Settings that err less: half the time step, and twice the iterations where an engine iterates."""
        return self.at_step(0.5)

    def scaled(self, scene: SceneScale) -> Self:
        """Settings that were chosen for the usual scene, for one of another size or gravity (Froude).

        The time that a brick takes to topple goes with its diagonal, and how deep it may be struck with its smallest
        side. All go by powers of two, so that scenes which hardly differ are stepped alike.
        """
        travel = self.most_travel
        return replace(
            self,
            time_step=self.time_step * power_of_two(scene.slower),
            most_travel=None if travel is None else travel * power_of_two(scene.smallest_side),
        )

    def suffice_for(self, wanted: Self) -> bool:
        """Whether a world with these settings may go on where these others would be chosen."""
        finer = self.time_step <= wanted.time_step
        return finer and (self.most_travel or 0.0) <= (wanted.most_travel or 0.0)

    def parts_for_travel(self, fastest: float) -> int:
        """Into how many parts a step is split while a body is so fast [m/s], so that none passes through another."""
        if self.most_travel is None:
            return 1
        return max(1, ceil(fastest * self.time_step / self.most_travel))
