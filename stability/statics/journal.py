"""Atomic changes: after an interrupt at any place either the whole change or none of it remains.

Before each write, the journal notes how to undo it. A change ends with one assignment, that of an empty journal; the
next access undoes an interrupted change if the journal is not empty. Undoing may itself be interrupted and start again,
so that each note can be applied twice.
"""

from collections.abc import Callable, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from stability.geometry.spatial_grid import Neighbours
from stability.model import BodyId, Vec3

K = TypeVar("K")
V = TypeVar("V")


class _Notes:
    def __init__(self) -> None:
        self.undo: list[tuple[Callable[..., object], tuple[Any, ...]]] = []
        self.ordered: set[int] = set()  # by id, the dicts whose order is already noted


class Journal:
    """Notes that undo all writes since the last completed change."""

    def __init__(self) -> None:
        """Start with an empty journal."""
        self._notes = _Notes()

    def note(self, undo: Callable[..., object], *arguments: object) -> None:
        """Note how to undo the next write, complete or not; undoing must be repeatable."""
        self._notes.undo.append((undo, arguments))

    def note_order(self, held: dict[K, V]) -> None:
        """Note the order of the items of a dict before one is removed."""
        if id(held) not in self._notes.ordered:
            self.note(_reorder, held, tuple(held), [])
            self._notes.ordered.add(id(held))

    def keep(self) -> None:
        """Make all writes since the last `keep` permanent."""
        self._notes = _Notes()

    def undo(self) -> None:
        """Undo all writes since the last `keep`."""
        if not self._notes.undo:
            return
        for undo, arguments in reversed(self._notes.undo):
            undo(*arguments)
        self._notes = _Notes()


class JournaledDict(dict[K, V]):
    """Dict that notes previous values in a journal. Values must not be changed in place."""

    __slots__ = ("_journal", "_ordered")

    def __init__(self, journal: Journal, *, ordered: bool = False) -> None:
        """Make an empty dict; with `ordered`, an item that the journal restores gets its old position."""
        self._journal = journal
        self._ordered = ordered

    def __setitem__(self, key: K, value: V) -> None:
        """Set an item as in any dict."""
        if key in self:
            self._journal.note(dict.__setitem__, self, key, self[key])
        else:
            self._journal.note(dict.pop, self, key, None)
        dict.__setitem__(self, key, value)

    def __delitem__(self, key: K) -> None:
        """Delete an item as in any dict."""
        if self._ordered:
            self._journal.note_order(self)
        self._journal.note(dict.__setitem__, self, key, self[key])
        dict.__delitem__(self, key)

    def replace(self, items: Mapping[K, V]) -> None:
        """Replace all items by these, in this order."""
        self._journal.note(_refill, self, dict(self))
        _refill(self, items)

    def __ior__(self, items: Mapping[K, V]) -> "JournaledDict[K, V]":  # type: ignore[override,misc]
        """Update the dict as any dict."""
        self.update(items)
        return self

    def pop(self, key: K, *default: V | None) -> V:  # type: ignore[override]
        """Remove an item as from any dict and return its value."""
        if key not in self and default:
            return default[0]  # type: ignore[return-value]
        value = self[key]
        del self[key]
        return value

    # All other writing methods call those above.
    popitem = MutableMapping.popitem
    clear = MutableMapping.clear
    update = MutableMapping.update
    setdefault = MutableMapping.setdefault


def _refill(held: dict[K, V], items: Mapping[K, V]) -> None:
    dict.clear(held)
    dict.update(held, items)


def _reorder(held: dict[K, V], order: Sequence[K], items: list[Mapping[K, V]]) -> None:
    """Restore the order of a dict; `items` keeps its items from the first call, so that it can be repeated."""
    if not items:
        items.append({key: held[key] for key in order})
    _refill(held, items[0])


@dataclass(slots=True)
class JournaledNeighbours(Neighbours[BodyId]):
    """Bodies by place, with changes noted in a journal."""

    journal: Journal = field(default_factory=Journal)

    def add(self, name: BodyId, low_W: Vec3, high_W: Vec3) -> None:
        """Add a body and note how to undo it."""
        self.journal.note(self.discard, name, low_W, high_W)
        Neighbours.add(self, name, low_W, high_W)

    def remove(self, name: BodyId) -> None:
        """Remove a body and note how to undo it."""
        self.journal.note(Neighbours.add, self, name, *self._bounds[name])
        Neighbours.remove(self, name)
