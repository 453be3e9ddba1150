"""The extension where what was far apart comes near: what one has proven and seen, another goes on with."""

from dataclasses import dataclass
from typing import Self

from stability.exact.handled_stability import HandledStability
from stability.exact.release import release_until_stable


@dataclass
class MergedStability(HandledStability):
    """Watches the bricks of one engine into which those of others may come; see `HandledStability`."""

    def absorb(self, other: Self) -> None:
        """Go on with the bricks of another extension, which have come into this one's engine by now.

        What stood by itself stands beside others that it does not touch.
        """
        self._observers.absorb(other._observers)
        standing = [other.assembly.bricks[name] for name in sorted(other.assembly.bricks)]
        if standing:
            self._give_back(release_until_stable(self.assembly, self.assembly.add_all(standing)).released)
