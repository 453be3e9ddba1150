"""A Sphinx extension: shows members, parameters and fields as lists, as docstrings of this project write them.

A docstring has lines `name: meaning` for parameters, and a field of a data class has its meaning in a comment.
"""

import inspect
import re
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import Final

from sphinx.application import Sphinx
from sphinx.util.inspect import getmro

PARAMETER: Final = re.compile(r"(\w+): (?=\S)")
FIELD: Final = re.compile(r"    (\w+): .*?  # (.+)")


def with_lists(app: Sphinx, kind: str, name: str, value: object, options: object, lines: list[str]) -> None:  # noqa: PLR0913, PLR0917 -- what Sphinx passes
    """Write the parameters of a function, and the fields of a data class, as field lists."""
    if kind == "function":
        names = inspect.signature(value).parameters if callable(value) else ()
        lines[:] = [
            f":param {line}" if (match := PARAMETER.match(line)) and match[1] in names else line for line in lines
        ]
    elif kind == "class" and is_dataclass(value) and isinstance(value, type):
        found = [FIELD.match(line) for line in inspect.getsource(value).splitlines()]
        lines += ["", *(f":ivar {match[1]}: {match[2]}" for match in found if match), ""]


def with_short_callables(  # noqa: PLR0913, PLR0917 -- likewise
    app: Sphinx, kind: str, name: str, value: object, options: object, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """Shorten the names of types around a callable, which Sphinx leaves as `~collections.abc.Callable`."""
    if signature is not None and "Callable[[" in signature:
        signature = re.sub(r"~[\w.]+\.", "", signature)
    return signature, returned


def own(fullname: str, members: Sequence[str]) -> list[str]:
    """Return the members of a class that this project defines, without the fields of a data class, in their order."""
    module, _, name = fullname.rpartition(".")
    kind = getattr(import_module(module), name)
    listed = {field.name for field in fields(kind)} if is_dataclass(kind) else set()
    ours = [each for each in getmro(kind) if each.__module__.split(".")[0] in ("stackdsl", "stability")]
    names = dict.fromkeys(name for each in ours for name in vars(each))
    return [name for name in names if name in members and name not in listed and name != "__init__"]


def setup(app: Sphinx) -> dict[str, bool]:
    """Attach the functions above."""
    app.config.autosummary_context = {"own": own}
    app.connect("autodoc-process-docstring", with_lists)
    app.connect("autodoc-process-signature", with_short_callables)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
