"""What there is to show now, under a few names: whoever looks gets all of it, and then whatever changes."""

import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from time import monotonic


@dataclass
class Board:
    """Texts by name, each the newest of its name; written by one thread, read by any number."""

    _texts: dict[str, tuple[int, str]] = field(default_factory=dict)  # with the number of the change that brought each
    _changes: int = 0
    _changed: threading.Condition = field(default_factory=threading.Condition)

    def put(self, name: str, text: str) -> None:
        """Show a text under a name, instead of what was there."""
        with self._changed:
            self._changes += 1
            self._texts[name] = self._changes, text
            self._changed.notify_all()

    def drop(self, name: str) -> None:
        """Show nothing under a name any more; who has seen it is not told."""
        with self._changed:
            self._texts.pop(name, None)

    def follow(self, patience: float) -> Iterator[tuple[str, str]]:
        """All that is there, and then every change, in their order and without what was overtaken meanwhile.

        An empty pair whenever nothing has changed for so long [s].
        """
        seen = 0
        while True:
            news, seen = self._news(seen, patience)
            yield from news or [("", "")]

    def _news(self, seen: int, patience: float) -> tuple[list[tuple[str, str]], int]:
        until = monotonic() + patience
        with self._changed:
            while self._changes == seen and (left := until - monotonic()) > 0.0:
                self._changed.wait(left)
            fresh = sorted((number, name, text) for name, (number, text) in self._texts.items() if number > seen)
            return [(name, text) for _, name, text in fresh], self._changes
