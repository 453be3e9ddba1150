"""What the steps of a run take, by counts, and whether what is ahead of it is more than a run may take."""

from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING

from stability.engines.scene_scale import SAMPLING
from stackdsl import work
from stackdsl.playing.clearance import Blocked, BlockedPlacementError
from stackdsl.systems.systems import Method, System

if TYPE_CHECKING:
    from stackdsl.playing.part import Part


@dataclass(frozen=True, slots=True)
class Done:
    """What has been done, in counts that only grow."""

    steps: int = 0  # of an engine
    known: int = 0  # steps of motions that are known without one
    looks: int = 0  # at bricks that hands lower
    landings: int = 0

    @classmethod
    def by(cls, parts: "list[Part]") -> "Done":
        """By these parts."""
        each = ((part.steps, part.known, part.hands.looks, part.falling.proven) for part in parts)
        return cls(*map(sum, zip(*each, strict=True)))

    def since(self, before: "Done") -> "Done":
        """What was done since then."""
        return Done(*(now - then for now, then in zip(astuple(self), astuple(before), strict=True)))


@dataclass
class Effort:
    """Counted in units of one moving brick in one step."""

    system: System
    done: float = 0.0
    _before: Done = Done()

    def __post_init__(self) -> None:
        proven = self.system.method is Method.PROVEN
        self._most, self._step = (work.MOST_STEPS, work.STEP) if proven else (work.MOST_STEPS_BARE, work.STEP_BARE)
        self._dearer = self._most / work.MOST_STEPS  # what is not a step of an engine takes as long on every system

    def look(self, parts: "list[Part]", part: "Part", end: float) -> None:
        """Count what was done since the last look, and refuse what is ahead up to a time [s].

        Raises BlockedPlacementError, before so many bricks have moved for long.
        """
        now = Done.by(parts)
        new, self._before = now.since(self._before), now
        moving = sum(each.one_by_one for each in parts)
        each_step = self._step + moving + self._dearer * (part.splits - 1) * (work.SPLIT + work.SPLIT_MOVING * moving)
        beside = work.KNOWN * new.known + work.LOOK * new.looks + work.LANDING * new.landings
        self.done += new.steps * each_step + self._dearer * beside
        by_hand = part.hands.busy_for()
        seconds = max(self._seconds(part, end) if moving and now.steps else 0.0, by_hand if part.hands.steps else 0.0)
        # How fast it is, and so how finely it is stepped, soon changes: ahead it counts as if it were slow.
        steady = self._step + moving
        ahead = seconds / part.world.settings.time_step * steady + self._dearer * work.LOOK * by_hand / SAMPLING
        if self.done + ahead > self._most * work.allowed():
            raise BlockedPlacementError(self._refused(part, moving, (seconds, by_hand), self.done + ahead))

    def _refused(self, part: "Part", moving: int, ahead: tuple[float, float], much: float) -> Blocked:
        seconds, by_hand = ahead
        many = f"{moving} brick{'s' if moving != 1 else ''} move{'s' if moving == 1 else ''}"
        if by_hand > seconds or (by_hand and not moving):
            many, seconds = "a hand is on its way", by_hand
        said = f"{many} at {part.time:.3g} s" + (f", for {seconds:.3g} s and more" if seconds else "")
        told = f"{much:.2g} steps of a brick in all are estimated, and {self._most * work.allowed():.2g} are allowed"
        brick = min(part.answers.moving() or part.hands.in_hand or part.measures.watch.present)
        return Blocked(brick, part.time, brick, 0.0, too_much=f"{said}: {told}")

    def _seconds(self, part: "Part", end: float) -> float:
        """For how long what moves will move: shaken, or with nobody who holds it at rest, as long as that goes on."""
        left = max(0.0, end - part.time)
        if part.ground.motion is not None:
            return min(left, max(work.AHEAD, part.ground.motion.ends - part.time))
        return left if part.extension is None else min(left, work.AHEAD)
