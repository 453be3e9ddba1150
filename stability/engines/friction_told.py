"""What an engine says of frictions that it cannot give: of which two bodies, and how far off."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from stability.model import BodyId


@dataclass(frozen=True, slots=True)
class WrongFriction:
    """The worst coefficient that an engine has had for two bodies which press on each other."""

    one: BodyId
    other: BodyId
    asked: float
    had: float
    time: float  # on the engine's clock [s]

    @property
    def error(self) -> float:
        """How far off it was."""
        return abs(self.had - self.asked)


@dataclass
class FrictionRecord:
    """What is kept of it while a world is stepped."""

    worst: WrongFriction | None = None

    def note(self, wrong: WrongFriction) -> None:
        """Keep the worst."""
        if self.worst is None or wrong.error > self.worst.error:
            self.worst = wrong


@runtime_checkable
class TellsFriction(Protocol):
    """A world whose engine may not have the friction that is asked of every pair, and which notes what it had."""

    frictions: FrictionRecord


def wrong_friction_of(world: object) -> WrongFriction | None:
    """The worst friction that a world has had, if it says so; None where all had what was asked."""
    return world.frictions.worst if isinstance(world, TellsFriction) else None
