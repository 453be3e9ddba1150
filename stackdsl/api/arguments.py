"""Checks the arguments of a call: each error names the argument and what to give."""

from collections.abc import Callable
from functools import wraps
from inspect import signature
from types import UnionType
from typing import ParamSpec, TypeVar

from stackdsl.diagnostics import meant_choice

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def with_remedy(remedy: str) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """Return a decorator that adds a remedy to the TypeError for missing or unknown arguments.

    The remedy for a misspelt keyword is the right one, and `remedy` is that of all other mistakes.
    """

    def decorated(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
        has = signature(function)
        name = function.__qualname__.removesuffix(".__init__")

        @wraps(function)
        def called(*values: Parameters.args, **named: Parameters.kwargs) -> Result:
            try:
                has.bind(*values, **named)
            except TypeError as error:
                unknown = next((each for each in named if each not in has.parameters), "")
                meant = meant_choice(unknown, list(has.parameters))
                raise TypeError(f"{name} {error}; {f'did you mean {meant!r}?' if meant else remedy}") from None
            return function(*values, **named)

        return called

    return decorated


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
