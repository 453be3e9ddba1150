"""Changes to the text of a snapshot, as a golden file might differ from a run."""

import json
from collections.abc import Callable
from typing import Any, TypeAlias

from stackdsl.goldens.file_format import canonical_text
from stackdsl.goldens.snapshot import Snapshot
from stackdsl.trace import BrickState
from tests.stackdsl.goldens.towers import FALL, taken, tower, track

Document: TypeAlias = dict[str, Any]  # the tests change it in many places
Change: TypeAlias = Callable[[Document], object]

STANDS = taken(tower())
FALLS = taken(tower(track("L3.1", 3, BrickState.FALLEN, shift=1.0), collapse=FALL))


def changed(change: Change, snapshot: Snapshot = STANDS) -> Document:
    whole: Document = json.loads(canonical_text(snapshot))
    change(whole)
    return whole


def put(*path: str | int, value: object) -> Change:
    def change(whole: Document) -> None:
        inner: Any = whole
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = value

    return change


def drop(*path: str | int) -> Change:
    def change(whole: Document) -> None:
        inner: Any = whole
        for key in path[:-1]:
            inner = inner[key]
        del inner[path[-1]]

    return change


BRICK = ("bricks", "L2.1")
PLACED = ("events", 1, "placed", "L2.1")
