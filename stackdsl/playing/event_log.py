"""What is told of a run while it goes on: its events, what proved the bricks, and how each was carried at first."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from stability.model import BodyId
from stability.watching.extension import Update
from stackdsl.playing.together import Tells
from stackdsl.playing.watch import Watch
from stackdsl.trace import ACTIONS, Edge, Event, EventKind

OnEvent = Callable[[Event], None]


@dataclass
class EventLog:
    """The events of one run, told as they come."""

    on_event: OnEvent
    events: list[Event] = field(default_factory=list, init=False)
    carried_at_first: dict[BodyId, tuple[Edge, ...]] = field(default_factory=dict, init=False)
    _proofs: Counter[str] = field(default_factory=Counter, init=False)  # bricks by what proved them

    def tell(self, event: Event) -> None:
        """Something has happened."""
        self.events.append(event)
        self.on_event(event)

    def tell_update(self, now: float, update: Update) -> None:
        """What the extension has frozen and woken in one pass."""
        stays = tuple(brick for brick in update.frozen if brick not in update.woken)
        if stays:
            self._proofs[update.proof] += len(stays)
            self.tell(Event(now, EventKind.FROZEN, stays, update.proof))
        if update.woken:
            self.tell(Event(now, EventKind.WOKEN, update.woken, update.reason, riding=update.riding))

    def close_placement(self, extension: Tells, watch: Watch) -> None:
        """Before the next bricks come: note how the last ones were carried, and how safely the stack stood."""
        if extension.awake():
            return  # what still moves has no margin, and who carries whom is about to change
        for index in range(len(self.events) - 1, -1, -1):
            if self.events[index].kind in ACTIONS - {EventKind.PLACED}:
                return  # the bricks placed before it were looked at when it came
            if self.events[index].kind is EventKind.PLACED:
                placed = self.events[index].bricks
                if any(watch.bricks[brick].placement.hits for brick in placed):
                    return  # nor is who carries a missile
                self.events[index] = replace(self.events[index], margin=extension.least_margin())
                shares = extension.shares(placed)
                self.carried_at_first |= {brick: edges_of(brick, shares.get(brick, {})) for brick in placed}
                return

    def in_order(self) -> tuple[Event, ...]:
        """By time: parts of a scene tell what happened in them when it is their turn."""
        return tuple(sorted(self.events, key=lambda event: event.time))

    def last_placed(self) -> tuple[BodyId, ...]:
        """The bricks of the last action, if that was to place some."""
        last = next((event for event in reversed(self.events) if event.kind in ACTIONS), None)
        return last.bricks if last is not None and last.kind is EventKind.PLACED else ()

    def proofs(self) -> Mapping[str, int]:
        """How many bricks were proven by what."""
        return {proof: count for proof, count in sorted(self._proofs.items()) if proof}


def edges_of(brick: BodyId, shares: Mapping[BodyId, float]) -> tuple[Edge, ...]:
    """Who carries a brick, and which part of its load."""
    return tuple(Edge(brick, on, shares[on]) for on in sorted(shares))
