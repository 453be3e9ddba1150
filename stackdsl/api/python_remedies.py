"""Remedies for authors in Python: the remedies of the language are written as YAML."""

import re
from collections.abc import Callable
from dataclasses import replace
from keyword import iskeyword
from typing import Final

import yaml

from stackdsl.diagnostics import Diagnostic

FLOW: Final = re.compile(r"(?<=\s)(?:- )?(?:\{.*\}|\[.*\])")  # a mapping or a list in YAML on one line
WORDS: Final[tuple[tuple[re.Pattern[str], str | Callable[[re.Match[str]], str]], ...]] = (
    (re.compile(r"begin each item with `- `"), "put it into a list, [...]"),
    (re.compile(r"write `(?:- )?(\w+): (\w+)`"), r'write \1("\2")'),
    (re.compile(r"write `(?:- )?(\w+):? ?` and its value"), r"write \1(...)"),
    (re.compile(r"^write all, or add (one of .*)$"), lambda found: f'write "all", or add {_own_names(found[1])}'),
    (re.compile(r"define it under `let`, above this place"), "define it in `let={...}`"),
    (re.compile(r"; systems of other packages are chosen with --system"), ""),
    (re.compile(r"^add `scenario`, .*$"), "give it a name, the first argument"),
    (re.compile(r"^add `(\w+)`"), lambda found: f"give `{python_name(found[1])}=`"),
    (re.compile(r"^quote it$"), "write a text"),
    (re.compile(r"such as (\d[\w.]* [\w/*%^]+)"), r'such as "\1"'),
)


def python_name(key: str) -> str:
    """Return the parameter of this package for a key; reserved words of Python have other names."""
    return f"{key}_" if iskeyword(key) else key


def _own_names(words: str) -> str:
    return ", ".join(python_name(word) for word in words.split(", "))


def in_python(found: Diagnostic) -> Diagnostic:
    """Return the diagnostic with a remedy in Python, if its position is in Python."""
    if not (found.span.key or found.span.file.endswith((".py", ">"))):
        return found
    hint = FLOW.sub(_value, found.hint)
    for pattern, written in WORDS:
        hint = pattern.sub(written, hint)
    return replace(found, hint=hint)


def _value(found: re.Match[str]) -> str:
    """Return a value of YAML in Python's syntax; unchanged if it is no value, such as a placeholder."""
    text = found[0]
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        return text
    return repr(value).replace("'", '"') if "..." not in text and "x, y, z" not in text else text
