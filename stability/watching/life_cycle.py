"""The life cycle of a brick under a stability extension, and the one way in which its parts hear of it.

A brick is set down or appears, is frozen when it is found to stand, woken when it is not any more, and gone at last.
The extension changes the engine first, then tells its observers in a fixed order, and each of them draws its own
conclusions. What observers are told is a fact; they answer nothing and change no brick.
"""

from collections.abc import Collection, Iterable
from typing import Self

from stability.model import BodyId


class BrickObserver:
    """Hears what becomes of the bricks of one engine. A subclass overrides the events to which it reacts."""

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """These bricks were set down at rest: they may be judged at once, before any step."""

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """These bricks were found to stand, and are held fixed in the engine now."""

    def woken(self, bricks: Collection[BodyId]) -> None:
        """These bricks were frozen, and the engine moves them again, one by one or as rigid groups.

        There may be none: then bricks were judged together with what is frozen, and nothing was released.
        """

    def gone(self, bricks: Collection[BodyId]) -> None:
        """These bricks are no longer in the engine, or other ones are there under their names."""

    def absorb(self, other: Self) -> None:
        """The bricks of which another one of its kind hears come into this engine, with all that is known of them."""


class Observers(BrickObserver):
    """Several observers as one: each event is told to all of them, in the order in which they are given."""

    def __init__(self, observers: Iterable[BrickObserver]) -> None:
        """The order is fixed from here on."""
        self._observers = tuple(observers)

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """Tell all observers that these bricks were set down."""
        for observer in self._observers:
            observer.set_down(bricks)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Tell all observers that these bricks were frozen."""
        for observer in self._observers:
            observer.frozen(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Tell all observers that these bricks were woken."""
        for observer in self._observers:
            observer.woken(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """Tell all observers that these bricks are gone."""
        for observer in self._observers:
            observer.gone(bricks)

    def absorb(self, other: Self) -> None:
        """Let each take over from the one in its place."""
        for own, others in zip(self._observers, other._observers, strict=True):
            own.absorb(others)
