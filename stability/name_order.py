"""Natural order of names: L2.1 comes before L10.1."""

import re
from collections.abc import Iterable
from itertools import zip_longest

from stability.model import BodyId

_NUMBER = re.compile(r"(\d+)")
NO_NUMBER = "-1"  # stands for a missing last number, so that a name comes before its continuations


def natural_key(name: BodyId) -> tuple[tuple[tuple[str, int], ...], str]:
    """Return the sort key of a name: pairs of letters and the following number, then the name itself."""
    parts = _NUMBER.split(name)  # letters and numbers alternate
    pairs = zip_longest(parts[::2], parts[1::2], fillvalue=NO_NUMBER)
    return tuple((letters, int(number)) for letters, number in pairs), name


def in_order(names: Iterable[BodyId]) -> list[BodyId]:
    """Sort names in natural order."""
    return sorted(names, key=natural_key)
