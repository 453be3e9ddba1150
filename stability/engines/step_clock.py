"""The clock of a world that takes its steps in parts, while something is fast."""

from dataclasses import dataclass

from stability.engines.settings import EngineSettings


@dataclass
class StepClock:
    """What time it is, and in how many parts the next step is taken."""

    settings: EngineSettings
    time: float = 0.0  # [s]
    parts: int = 1

    def limit_travel(self, fastest: float) -> None:
        """Say how fast the bodies of the coming steps are at most [m/s], so that none passes through another."""
        self.parts = self.settings.parts_for_travel(fastest)

    def pass_step(self) -> int:
        """Go on by a step; returns in how many parts the engine has to take it."""
        self.time += self.settings.time_step
        return self.parts
