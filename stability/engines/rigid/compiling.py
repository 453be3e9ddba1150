"""Compilation of the inner loops by numba."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Return the function as machine code, which is kept for later processes."""
    return cast("Function", njit(cache=True, error_model="numpy")(function))
