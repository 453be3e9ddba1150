"""Strength of bricks against crushing."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import inf
from types import MappingProxyType
from typing import Final

from stability.geometry.vectors import admit_number, short_repr
from stability.model import BodyId


@dataclass(frozen=True, slots=True)
class Strength:
    """Strength of one brick. A brick that has reached it yields at this force, as in limit analysis."""

    pressure: float = inf  # at any place of a face in contact [Pa]
    stack: float = inf  # greatest sum of the forces by which others lie on it [N]


NO_STRENGTHS: Final[Mapping[BodyId, Strength]] = MappingProxyType({})


def admit_strengths(strengths: object) -> None:
    """Raise ValueError for a strength that is not positive, TypeError for anything but strengths by brick."""
    if not isinstance(strengths, Mapping):
        raise TypeError(f"expected a mapping, such as {{'a': Strength(pressure=2e5)}}, not {short_repr(strengths)}")
    for name, strength in strengths.items():
        if not isinstance(strength, Strength):
            raise TypeError(f"the strength of '{name}' is {short_repr(strength)}; write Strength(pressure=2e5)")
        for each in fields(strength):
            number = getattr(strength, each.name)
            what = f"the {each.name} that '{name}' bears is"
            admit_number(what, number, "write a positive number")
            if not number > 0.0:
                raise ValueError(f"{what} {short_repr(number)}; write a positive number")
