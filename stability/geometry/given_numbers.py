"""Numbers as a caller gives them: told what was expected, where they are none, too few, or infinite."""

from collections.abc import Sequence
from math import isfinite
from numbers import Real
from typing import TypeGuard


def is_number(value: object) -> TypeGuard[float]:
    """Whether something is one number, of Python or of numpy; a truth value is none."""
    return isinstance(value, Real) and not isinstance(value, bool)


def admit_number(what: str, value: object, remedy: str) -> None:
    """Raise TypeError for what is no number; `what` is what has it, such as `brick 'a' has the mass`."""
    if not is_number(value):
        raise TypeError(f"{what} {value!r}; {remedy}")


def admit_numbers(what: str, value: object, count: int, remedy: str) -> None:
    """Raise TypeError for what is no sequence of numbers, and ValueError for other than so many finite ones."""
    parts = _parts(value)
    if parts is None or not all(map(is_number, parts)):
        raise TypeError(f"{what} {value!r}; {remedy}, as {count} numbers")
    if len(parts) != count or not all(map(isfinite, parts)):
        raise ValueError(f"{what} {tuple(parts)}; {remedy}")


def _parts(value: object) -> Sequence[float] | None:
    """The parts of what can be gone through in order; None of anything else, such as a text."""
    if isinstance(value, str | bytes | dict | set) or not (hasattr(value, "__len__") and hasattr(value, "__iter__")):
        return None
    return list(value)
