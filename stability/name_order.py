"""The order in which people count names: L2.1 comes before L10.1."""

import re
from collections.abc import Iterable
from itertools import zip_longest

from stability.model import BodyId

_NUMBER = re.compile(r"(\d+)")
NO_NUMBER = "-1"  # after the last letters: a name comes before those that go on


def as_counted(name: BodyId) -> tuple[tuple[tuple[str, int], ...], str]:
    """A key to sort names by: letters and the number after them, pair by pair, then the name as it is written."""
    parts = _NUMBER.split(name)  # letters and numbers in turn
    pairs = zip_longest(parts[::2], parts[1::2], fillvalue=NO_NUMBER)
    return tuple((letters, int(number)) for letters, number in pairs), name


def in_order(names: Iterable[BodyId]) -> list[BodyId]:
    """Names as people count them."""
    return sorted(names, key=as_counted)
