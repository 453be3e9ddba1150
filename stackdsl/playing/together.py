"""What the extensions of several parts say of the whole scene."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from stability.model import BodyId
from stability.statics.facts import Motion, Stability, Stage, Verdict
from stability.watching.extension import Extension

WORST_FIRST = (Stability.UNSTABLE, Stability.UNDECIDED, Stability.STABLE)
Shares = Mapping[BodyId, Mapping[BodyId, float]]


class Tells(Protocol):
    """What is told of bricks that are held, as an `Extension` tells it."""

    def awake(self) -> list[BodyId]:
        """The bricks that an engine moves, by name."""

    def is_frozen(self, brick: BodyId) -> bool:
        """Whether a brick is held fixed."""

    def shares(self, bricks: Collection[BodyId] | None = None) -> Shares:
        """Which part of its load goes to each body that it rests on, for every frozen brick, or those of some."""

    def least_margin(self) -> float | None:
        """The smallest tipping margin of what is frozen [m]; None where no model has one."""

    def verdict(self) -> Verdict | None:
        """What was proven when bricks were last set down or taken out; None where nothing proves."""

    def giving_way(self) -> Mapping[BodyId, str]:
        """Why bricks that an engine moves are proven not to stand."""


@dataclass(frozen=True)
class Together:
    """Several as one."""

    of: Callable[[BodyId], Extension | None]  # by brick
    extensions: Sequence[Extension]
    acted: Sequence[Extension]  # those with whose bricks something was done last

    def awake(self) -> list[BodyId]:
        """The bricks that an engine moves, by name."""
        return sorted(name for each in self.extensions for name in each.awake())

    def is_frozen(self, brick: BodyId) -> bool:
        """Whether a brick is held fixed."""
        extension = self.of(brick)
        return extension is not None and extension.is_frozen(brick)

    def shares(self, bricks: Collection[BodyId] | None = None) -> Shares:
        """Which part of its load goes to each body that it rests on, for every frozen brick, or those of some."""
        found: dict[BodyId, Mapping[BodyId, float]] = {}
        for each in self.extensions:
            found |= each.shares(None if bricks is None else [name for name in bricks if self.of(name) is each])
        return found

    def least_margin(self) -> float | None:
        """The smallest tipping margin of what is frozen [m]; None where no model has one."""
        margins = [margin for each in self.extensions if (margin := each.least_margin()) is not None]
        return min(margins, default=None)

    def verdict(self) -> Verdict | None:
        """What was proven when bricks were last set down or taken out: the worst, of all that fail so."""
        verdicts = [verdict for each in self.acted if (verdict := each.verdict()) is not None]
        if not verdicts:
            return None
        worst = min((verdict.stability for verdict in verdicts), key=WORST_FIRST.index)
        return _as_one([verdict for verdict in verdicts if verdict.stability is worst])

    def giving_way(self) -> Mapping[BodyId, str]:
        """Why bricks that an engine moves are proven not to stand."""
        return {name: reason for each in self.extensions for name, reason in each.giving_way().items()}


def _as_one(verdicts: Sequence[Verdict]) -> Verdict:
    """Verdicts of the same stability."""
    if len(verdicts) == 1:
        return verdicts[0]
    stages = [verdict.stage for verdict in verdicts if verdict.stage is not None]
    motions = [verdict.motion for verdict in verdicts if verdict.motion is not None]
    velocity = {name: how for motion in motions for name, how in motion.velocity.items()}
    return replace(
        verdicts[0],
        stage=max(stages, key=tuple(Stage).index, default=None),
        reason="; ".join(dict.fromkeys(filter(None, (verdict.reason for verdict in verdicts)))),
        moving=tuple(sorted(name for verdict in verdicts for name in verdict.moving)),
        motion=Motion(velocity) if motions else None,
        seconds=sum(verdict.seconds for verdict in verdicts),
    )
