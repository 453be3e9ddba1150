"""What statics say of a scenario with another number in it: asked once a number, and remembered."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import Final, TypeAlias

from stability.statics.facts import Stability
from stackdsl.diagnostics import Diagnostic
from stackdsl.judging.proofs import proofs_of
from stackdsl.timeline import Timeline

LARGE: Final = 250  # bricks: more, and more than four times what is built, are tried only if somebody says how far

Compiled: TypeAlias = Callable[[float], tuple[Timeline | None, Sequence[Diagnostic]]]


class Answer(StrEnum):
    """What came of one number."""

    STANDS = "stands"  # at each step of building, as far as statics can judge, by proof
    FALLS = "falls"  # likewise, by a motion that was checked
    OPEN = "undecided"
    NO_SCENARIO = "is no scenario"
    TOO_LARGE = "is not tried"  # as it has so many bricks


ANSWERS: Final = {
    Stability.STABLE: Answer.STANDS,
    Stability.UNSTABLE: Answer.FALLS,
    Stability.UNDECIDED: Answer.OPEN,
}


@dataclass(frozen=True, slots=True)
class Tried:
    """One number, and what came of it."""

    value: float
    answer: Answer
    why: str = ""  # what moves and how, what is in doubt, or why it is no scenario
    timeline: Timeline | None = None
    judged: int = 0  # bricks that statics judged
    bricks: int = 0  # bricks that are built
    moment: float = 0.0  # when the bricks were set down with which it falls [s]

    @property
    def shape(self) -> object:
        """What is built, and on what; numbers with which that is the same have no effect."""
        if self.timeline is None:
            return None
        return self.timeline.world, [(each.brick, each.pose) for each in self.timeline.placements if not each.hits]


@dataclass
class Asking:
    """Asks, and keeps what came of it."""

    compiled: Compiled
    largest: float = inf  # bricks: what has more is left alone
    told: Callable[[int], None] = lambda _: None  # of how many were asked, as it goes on
    tried: dict[float, Tried] = field(default_factory=dict)

    @property
    def verdicts(self) -> int:
        """How many verdicts were asked of statics."""
        return sum(each.timeline is not None for each in self.tried.values())

    def __call__(self, value: float) -> Tried:
        """What comes of a number."""
        if value not in self.tried:
            self.tried[value] = self._ask(value)
            self.told(len(self.tried))
        return self.tried[value]

    def holds(self, value: float) -> bool | None:
        """Whether it stands; None where that cannot be said."""
        answer = self(value).answer
        return answer is Answer.STANDS if answer in (Answer.STANDS, Answer.FALLS) else None

    def _ask(self, value: float) -> Tried:
        timeline, mistakes = self.compiled(value)
        if timeline is None:
            why = next((f"{each.code}: {each.message}" for each in mistakes), "")
            return Tried(value, Answer.NO_SCENARIO, why)
        bricks = sum(not each.hits for each in timeline.placements)
        if bricks > self.largest:
            return Tried(value, Answer.TOO_LARGE, f"it has {bricks} bricks")
        proofs = proofs_of(timeline, names_smallest=False)
        verdict = proofs.assembly.verdict()
        judged = sum(len(each.bricks) for each in proofs.judged)
        when = timeline.as_set_down().actions[max(0, proofs.done - 1)].time
        return Tried(value, ANSWERS[verdict.stability], verdict.reason, timeline, judged, bricks, when)


def told_shortly(tried: Tried) -> str:
    """How what falls begins to."""
    if tried.timeline is None or tried.answer is not Answer.FALLS:
        return tried.why
    return proofs_of(tried.timeline).verdict.reason or tried.why
