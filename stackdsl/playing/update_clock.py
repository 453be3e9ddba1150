"""How long does one update of the extension take? Whoever plays with bricks while it watches them waits for each."""

from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import median
from time import perf_counter
from typing import ParamSpec

from stability.watching.extension import Update
from stackdsl.trace import Updates

Asked = ParamSpec("Asked")


@dataclass
class UpdateClock:
    """Times every update of one run."""

    _took: list[float] = field(default_factory=list)  # [s]

    def timed(self, update: Callable[Asked, Update], *asked: Asked.args, **more: Asked.kwargs) -> Update:
        """Carry out an update."""
        began = perf_counter()
        done = update(*asked, **more)
        self._took.append(perf_counter() - began)
        return done

    def absorb(self, other: "UpdateClock") -> None:
        """Count those of another one as well."""
        self._took += other._took

    def updates(self) -> Updates | None:
        """What they took; None if there were none."""
        return Updates(median(self._took), max(self._took)) if self._took else None
