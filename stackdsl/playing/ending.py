"""When does a run end? So long after what is done last, or after a collapse, or as soon as all that is asked is known.

A collapse is what everybody asks about first, so a run that has none goes on to its end. One that has is followed for a
while in any case: what fell is kept in golden files, and told. Beyond, it goes on for what is still asked alone.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from stackdsl.playing.after_collapse import last_arrival, time_of
from stackdsl.timeline import Action, Moment, Timeline
from stackdsl.trace import Collapse, EarlyEnd, Trace

KEPT = 1.0  # [s] after a collapse that are seen in any case: golden files keep what fell by then
BETWEEN_QUESTIONS = 0.1  # [s] between asking whether all is known, which takes as long as some looks do
Known: TypeAlias = Callable[[Trace], bool]  # whether nothing that may still happen changes what is asked of a run


def nothing_is_known(_trace: Trace) -> bool:
    """Of a run of which nothing is asked, everything is worth seeing."""
    return False


@dataclass
class Ending:
    """Until when one run goes on."""

    timeline: Timeline
    is_known: Known
    last_action: float = 0.0  # [s]
    last_arrival: float = 0.0  # of what has to fly to the structure [s]
    early: EarlyEnd | None = None
    _asked: float = 0.0  # when it was last asked whether all is known [s]
    _planned: float = field(init=False)  # when it ends if nothing collapses [s]

    def __post_init__(self) -> None:
        self._planned = self.timeline.end  # which is asked for at every step

    def acted(self, moment: Moment) -> None:
        """Something was done."""
        self.last_action = time_of(moment)
        self.last_arrival = max(self.last_arrival, last_arrival(moment))

    def until(self, collapse: Collapse | None, hit: bool) -> float:
        """Until when there is something to see, as far as is known by now [s]; `hit`: something hit the structure."""
        if self.early is not None:
            return self.early.time
        if collapse is None:
            return self._planned
        aftermath = collapse.time + (self.timeline.followed if self.timeline.aftermath else 0.0)
        goes_on = hit or self.last_action > collapse.time
        return max(aftermath, self.last_arrival + self.timeline.hold) if goes_on else aftermath

    def may_be_early(self, now: float, collapse: Collapse | None) -> bool:
        """Whether it is worth asking if all is known."""
        if collapse is None or self.early is not None:
            return False
        return now >= max(collapse.time + KEPT, self._asked + BETWEEN_QUESTIONS)

    def ask(self, so_far: Trace, planned: float, to_come: Sequence[Moment]) -> None:
        """End now if all is known; `to_come` is what is still to be done, `planned` when it ends without that [s]."""
        early = self.if_it_ended(so_far, planned, to_come)
        self._asked = early.time
        if early.planned > early.time and self.is_known(replace(so_far, early_end=early)):
            self.early = early

    def if_it_ended(self, so_far: Trace, planned: float, to_come: Sequence[Moment]) -> EarlyEnd:
        """What an end now would leave out."""
        if to_come:
            planned = max(planned, max(map(last_arrival, to_come)) + self.timeline.hold)
        return EarlyEnd(so_far.cost.simulated_time, planned, tuple(_actions(to_come)))


def _actions(moments: Iterable[Moment]) -> Iterable[Action]:
    for moment in moments:
        yield from moment if isinstance(moment, tuple) else (moment,)
