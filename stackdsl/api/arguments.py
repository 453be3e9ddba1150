"""Checks the arguments of a call: each error names the argument and what to give."""

from types import UnionType


def refuse_other_types(kind: type | UnionType, wanted: str, **values: object) -> None:
    """Raise TypeError for values of another type; `wanted` describes the right ones."""
    for name, value in values.items():
        if not isinstance(value, kind):
            raise TypeError(f"{name} must be {wanted}, not {value!r}")


def refuse_outside(name: str, value: float, least: float, most: float, kind: type = float) -> None:
    """Raise TypeError for a value that is no number, and ValueError for one outside of its range."""
    if not isinstance(value, kind | int) or isinstance(value, bool):
        raise TypeError(f"{name} must be a {'whole ' * (kind is int)}number from {least:g} to {most:g}, not {value!r}")
    if not least <= value <= most:
        raise ValueError(f"{name} must be from {least:g} to {most:g}, not {value!r}")
