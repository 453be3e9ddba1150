"""Build steps with layouts: one function per layout, generated from the models of the language.

docs/language.md describes every key. An argument that is omitted or None has the default described there. Quantities
are strings with units, as in YAML: "12 mm".
"""

from collections.abc import Callable

from stackdsl.api.words import LAYOUT_WORDS
from stackdsl.api.written import Written

__all__ = list(LAYOUT_WORDS.names())


def __getattr__(name: str) -> Callable[..., Written]:
    return LAYOUT_WORDS.function(name)


def __dir__() -> list[str]:
    return __all__
