"""Kinds: what an author may write under a key of its own, each registered by the one module that knows all of it.

There are kinds of layouts, of claims and of impacts. Who meets one asks it, and nobody lists them.
"""

from collections.abc import Iterator, Mapping
from typing import Generic, TypeVar

from pydantic import Field, create_model

from stackdsl.language.author_models import Choice

Entry = TypeVar("Entry")
Model = TypeVar("Model", bound=Choice)


class Kinds(Mapping[str, Entry], Generic[Entry]):
    """By the key that an author writes, in the order in which they registered: that of the JSON Schema."""

    def __init__(self, noun: str) -> None:
        self._noun, self._entries = noun, dict[str, Entry]()

    def __getitem__(self, key: str) -> Entry:
        return self._entries[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def register(self, key: str, entry: Entry) -> None:
        """Let a kind be known. Raises ValueError if its key is taken."""
        if key in self._entries:
            raise ValueError(f"there is a {self._noun} '{key}' already")
        self._entries[key] = entry

    def forget(self, key: str) -> None:
        """Let a kind be unknown again. Raises KeyError if it is."""
        del self._entries[key]


def with_kinds(base: type[Model], keys: Mapping[str, tuple[type, str]], *others: str) -> type[Model]:
    """The choice with a key for each kind, whose value is read by a type and described in a phrase, beside others.

    The keys of the base come first, in its JSON Schema as well.
    """
    fields = {key: (value | None, Field(None, description=summary)) for key, (value, summary) in keys.items()}
    made: type[Model] = create_model(  # type: ignore[call-overload]  # likewise
        base.__name__, __base__=base, __doc__=base.__doc__, __module__=base.__module__, **fields
    )
    made.one_of = (*keys, *others)
    return made
