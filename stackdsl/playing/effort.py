"""What the steps of a run take, by counts, and whether what is ahead of it is more than a run may take."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stackdsl import work
from stackdsl.playing.clearance import Blocked, BlockedPlacementError
from stackdsl.systems.systems import Method, System

if TYPE_CHECKING:
    from stackdsl.playing.part import Part


@dataclass
class Effort:
    """Counted in units of one moving brick in one step."""

    system: System
    done: float = 0.0
    _steps: int = 0  # of the engine, when it was counted last

    def look(self, steps: int, moving: int, part: "Part", end: float) -> None:
        """Count what was done since the last look, and refuse what is ahead up to a time [s].

        Raises BlockedPlacementError, before so many bricks have moved for long.
        """
        proven = self.system.method is Method.PROVEN
        most, step = (work.MOST_STEPS, work.STEP) if proven else (work.MOST_STEPS_BARE, work.STEP_BARE)
        self.done += (steps - self._steps) * (step + moving)
        self._steps = steps
        if not moving or not steps:
            return
        seconds = self._seconds(part, end)
        ahead = self.done + seconds / part.world.settings.time_step * (step + moving)
        if ahead > most * work.allowed():
            many = f"{moving} brick{'s' if moving != 1 else ''} move{'s' if moving == 1 else ''}"
            said = f"{many} at {part.time:.3g} s, for {seconds:.3g} s and more"
            much = f"{ahead:.2g} steps of a brick in all are estimated, and {most * work.allowed():.2g} are allowed"
            brick = min(part.answers.moving())
            raise BlockedPlacementError(Blocked(brick, part.time, brick, 0.0, too_much=f"{said}: {much}"))

    def _seconds(self, part: "Part", end: float) -> float:
        """For how long what moves will move: shaken, or with nobody who holds it at rest, as long as that goes on."""
        left = max(0.0, end - part.time)
        if part.ground.motion is not None:
            return min(left, max(work.AHEAD, part.ground.motion.ends - part.time))
        return left if part.extension is None else min(left, work.AHEAD)
