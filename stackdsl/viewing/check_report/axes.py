"""An axis of a chart: where a value lies on it, and which round values are written beside it."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, floor, log10

ABOUT = 6  # ticks
ROUND = (1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True, slots=True)
class Axis:
    """From a least to a largest value, which lie at two places [px]."""

    least: float
    largest: float
    begin: float
    end: float

    def place(self, value: float) -> float:
        """Where a value lies [px]; in the middle, if there is only one."""
        wide = self.largest - self.least
        part = (value - self.least) / wide if wide > 0.0 else 0.5
        return self.begin + part * (self.end - self.begin)

    def ticks(self) -> Iterator[float]:
        """Round values within, some six."""
        wide = self.largest - self.least
        if wide <= 0.0:
            yield self.least
            return
        power = 10.0 ** floor(log10(wide / ABOUT))
        step = next(factor * power for factor in ROUND if factor * power * ABOUT >= wide * (1.0 - 1e-9))
        rounding = 1e-9 * wide
        for number in range(ceil((self.least - rounding) / step), floor((self.largest + rounding) / step) + 1):
            yield number * step
