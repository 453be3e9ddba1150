"""Impacts: one function each, generated from the models of the language.

docs/language.md describes every key. An omitted key, or None, is not written and has its default there. Quantities are
texts with their units, as in YAML: "12 mm".
"""

from collections.abc import Callable

from stackdsl.api.words import IMPACT_WORDS
from stackdsl.api.written import Written

__all__ = list(IMPACT_WORDS.names())


def __getattr__(name: str) -> Callable[..., Written]:
    return IMPACT_WORDS.function(name)


def __dir__() -> list[str]:
    return __all__
