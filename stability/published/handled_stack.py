"""The published method where hands take bricks, move them, hold them and let them go.

In the publication a brick that a user moves is one that the engine moves: it is no part of the stack, and nothing that
rests or leans on it is. What it touches is woken only if it hits hard enough (section 3.6), so that a brick which is
moved slowly would pass through the stack; here all that a hand may move is woken, and what rests on that.
"""

from collections.abc import Collection
from dataclasses import dataclass

from stability.model import BodyId
from stability.published.stack_stability import StackStability
from stability.watching.extension import Update


@dataclass
class HandledStack(StackStability):
    """The published method on the bricks of one engine some of which may be in hands; see `StackStability`."""

    def taken(self, brick: BodyId) -> Update:
        """Say that a hand takes a brick: what rests on it is woken with it (section 3.3.7)."""
        woken = self.wake([brick])
        self.engine.freeze(brick)
        self.in_hands.add(brick)
        return Update((), woken, reason=f"{brick} taken by a hand" if woken else "")

    def held(self, bricks: Collection[BodyId]) -> Update:
        """Say that hands hold bricks: what is in a hand is no part of the stack, so what rests on it is not either."""
        found = Update()
        for brick in bricks:
            found = found.then(self.taken(brick))
        return found

    def let_go(self, bricks: Collection[BodyId], set_down: bool) -> Update:
        """Say that hands let bricks go; what they brought may be tested at once."""
        self.in_hands.difference_update(bricks)
        if set_down:
            self.set_down(bricks)
        return Update()

    def handled(self, bricks: Collection[BodyId], reason: str) -> Update:
        """Say which bricks hands may move: they are woken, and not tested while they are named."""
        self._stillness.handled = bricks
        frozen = [brick for brick in bricks if brick in self.stack]
        woken = self.wake(frozen) if frozen else ()
        return Update((), woken, reason=reason if woken else "")
