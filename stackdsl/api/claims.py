"""Claims for `expect` and `truth`: one function per claim, generated from the models of the language.

docs/language.md describes every key. An argument that is omitted or None has the default described there. Quantities
are strings with units, as in YAML: "12 mm".
"""

from collections.abc import Callable

from stackdsl.api.words import CLAIM_WORDS
from stackdsl.api.written import Written

__all__ = list(CLAIM_WORDS.names())


def __getattr__(name: str) -> Callable[..., Written]:
    return CLAIM_WORDS.function(name)


def __dir__() -> list[str]:
    return __all__
