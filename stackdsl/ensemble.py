"""What became of many samples of one case: plain counts, which the judge, the snapshot and the report read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

OnDrawn: TypeAlias = Callable[[str, int, int], None]  # told of a case: its name, samples drawn, and how many may be


def untold(name: str, drawn: int, planned: int) -> None:
    """Nobody is told."""


@dataclass(frozen=True, slots=True)
class Ensemble:
    """The samples that were judged, from the first on, and what became of them."""

    drawn: int
    planned: int  # how many may be drawn at most
    seed: int
    stood: int
    fell: Mapping[int, int]  # by the level under construction
    undecided: int = 0  # of which statics proves neither
    unfit: int = 0  # of which hands found no place for a brick beside others
    ways: Mapping[str, int] = field(default_factory=dict)  # how many samples each way decided
    cpu_time: float = field(default=0.0, compare=False)  # [s], of all processes together

    @property
    def unknown(self) -> int:
        """The samples that may have gone either way."""
        return self.undecided + self.unfit

    @property
    def summary(self) -> str:
        """What became of most of them, in words."""
        return f"{self.stood} of {self.drawn} stand"
