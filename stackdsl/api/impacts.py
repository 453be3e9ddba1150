"""Impacts: one function per impact, generated from the models of the language.

docs/language.md describes every key. An argument that is omitted or None has the default described there. Quantities
are strings with units, as in YAML: "12 mm".
"""

from collections.abc import Callable

from stackdsl.api.words import IMPACT_WORDS
from stackdsl.api.written import Written

__all__ = list(IMPACT_WORDS.names())


def __getattr__(name: str) -> Callable[..., Written]:
    return IMPACT_WORDS.function(name)


def __dir__() -> list[str]:
    return __all__
