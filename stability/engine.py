"""What stability needs from a physics engine, and nothing more. SI units, world frame W, z up."""

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

from stability.model import BodyId, BodyState, ContactPoint


class Engine(Protocol):
    """A running engine, reached only through its public interface.

    Bodies that the engine holds fixed from the start (ground, walls) are no bricks; they may appear in contacts.
    """

    def time(self) -> float:
        """The engine's clock [s]."""

    def masses(self) -> Mapping[BodyId, float]:
        """The mass of every brick, frozen or not [kg]. New bricks appear here as soon as they exist."""

    def states(self, bricks: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        """Pose and motion of these bricks."""

    def contacts(self, bricks: Collection[BodyId]) -> Sequence[ContactPoint]:
        """The contact points that involve at least one of these bricks, as of the last step; each once."""

    def freeze(self, brick: BodyId) -> None:
        """Hold a brick where it is, without velocity; it goes on colliding."""

    def wake(self, brick: BodyId) -> None:
        """Give a frozen brick back to the engine, at rest, with the mass that it had."""
