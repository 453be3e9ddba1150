"""Checks numbers and lists that a caller gives: each error says what was expected."""

from collections.abc import Iterable, Sequence
from math import isfinite
from numbers import Integral, Rational, Real
from typing import Final, TypeGuard, TypeVar

Given = TypeVar("Given")

SHORTEST, LONGEST = 1e-9, 1e9  # [m] of sides and distances: beyond, their squares and products lose their digits
TOLD: Final = 80  # [characters] of a value in a message


def is_number(value: object) -> TypeGuard[float]:
    """True for a number of Python or numpy; False for booleans and fractions."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    return isinstance(value, Integral) or not isinstance(value, Rational)


def is_finite(value: float) -> bool:
    """Whether a number is finite, and a double can hold it, which not every integer of Python fits."""
    try:
        return isfinite(value)
    except OverflowError:
        return False


def told(value: object) -> str:
    """A value as its author would write it, shortened."""
    try:
        text = repr(value)
    except ValueError:  # an integer of more digits than Python writes
        text = f"a number of {value.bit_length()} bits" if isinstance(value, int) else f"a {type(value).__name__}"
    if text.startswith("<"):  # what says no more than where it is in memory
        text = type(value).__name__
    return text if len(text) <= TOLD else f"{text[: TOLD - 1]}…"


def admit_number(what: str, value: object, remedy: str) -> None:
    """Raise TypeError for what is no number; `what` is what has it, such as `brick 'a' has the mass`."""
    if not is_number(value):
        raise TypeError(f"{what} {told(value)}; {remedy}")


def admit_in_range(what: str, value: object, least: float, most: float, remedy: str) -> None:
    """Raise TypeError for what is not a number, and ValueError for a number out of range."""
    admit_number(what, value, remedy)
    assert is_number(value)
    if not least <= value <= most:  # nor is what is no number
        raise ValueError(f"{what} {told(value)}; {remedy}")


def admit_numbers(what: str, value: object, count: int, remedy: str) -> None:
    """Raise TypeError for what is no sequence of numbers, and ValueError for other than so many finite ones."""
    parts = _parts(value)
    if parts is None or not all(map(is_number, parts)):
        raise TypeError(f"{what} {told(value)}; {remedy}, as {count} numbers")
    if len(parts) != count or not all(map(is_finite, parts)):
        raise ValueError(f"{what} {told(tuple(parts))}; {remedy}")


def _parts(value: object) -> Sequence[float] | None:
    """The parts of what can be gone through in order; None of anything else, such as a text."""
    if isinstance(value, str | bytes | dict | set) or not (hasattr(value, "__len__") and hasattr(value, "__iter__")):
        return None
    try:
        return list(value)
    except TypeError:  # an array of numpy without an axis
        return None


def listed(given: Iterable[Given], what: str) -> tuple[Given, ...]:
    """All items of an iterable. Raises TypeError, with what was expected, for anything else."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise TypeError(f"expected a collection of {what}, not {told(given)}")
    try:
        return tuple(given)
    except TypeError as error:  # an array of numpy without an axis
        raise TypeError(f"expected a collection of {what}, not {told(given)}") from error
