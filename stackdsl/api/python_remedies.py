"""Rewrites the hints of diagnostics for authors of Python, since those of the language show YAML."""

import re
from collections.abc import Callable
from dataclasses import replace
from keyword import iskeyword
from typing import Final

import yaml

from stackdsl.diagnostics import Diagnostic
from stackdsl.language.claims.claim_kind import CLAIMS

FLOW: Final = re.compile(r"(?<=\s)(?:- )?(?:\{.*\}|\[.*\])")  # a mapping or a list in YAML flow style
WORDS: Final[tuple[tuple[re.Pattern[str], str | Callable[[re.Match[str]], str]], ...]] = (
    (re.compile(r"begin each item with `- `"), "put it into a list, [...]"),
    (
        re.compile(r"write `(?:- )?(\w+): (\w+)`"),
        lambda match: f'write {"claims." * (match[1] in CLAIMS)}{match[1]}("{match[2]}")',
    ),
    (re.compile(r"write `(?:- )?(\w+):? ?` and its value"), r"write \1(...)"),
    (
        re.compile(r"^write (\w+), or a mapping with the keys (.*)$"),
        lambda match: f'write "{match[1]}", or give keys: {_own_names(match[2])}',
    ),
    (re.compile(r"^write ([a-z]+)$"), r'write "\1"'),
    (re.compile(r"^write all, or add (one of .*)$"), lambda match: f'write "all", or add {_own_names(match[1])}'),
    (re.compile(r"define it under `let`, above this place"), "define it in `let={...}`"),
    (
        re.compile(r"systems of other packages are chosen with --system"),
        "`play(case.on(SYSTEM))` of stackdsl.api.run plays a case on a system of another package",
    ),
    (re.compile(r"^add `scenario: .*$"), "give it a name, the first argument"),
    (
        re.compile(r"^add `(\w+)(?:: ([^`]*))?`"),
        lambda match: f"give `{python_name(match[1])}={_literal(match[2] or '')}`",
    ),
    (re.compile(r"^quote it$"), "write a text"),
    (re.compile(r"such as (\d[\w.]* [\w/*%^]+)"), r'such as "\1"'),
)


def _literal(text: str) -> str:
    """Return a scalar of YAML as a Python literal; a mapping or a list is one already."""
    if not text or text[0] in '{["':
        return text
    return repr(yaml.safe_load(text)).replace("'", '"')


def python_name(key: str) -> str:
    """Return the parameter name of a key: Python keywords get an underscore at the end."""
    return f"{key}_" if iskeyword(key) else key


def _own_names(words: str) -> str:
    return ", ".join(python_name(word) for word in words.split(", "))


def in_python(diagnostic: Diagnostic) -> Diagnostic:
    """Return the diagnostic with a hint for Python, if its place is in Python code."""
    if not (diagnostic.span.key or diagnostic.span.file.endswith((".py", ">"))):
        return diagnostic
    hint = FLOW.sub(_value, diagnostic.hint)
    for pattern, written in WORDS:
        hint = pattern.sub(written, hint)
    return replace(diagnostic, hint=hint)


def _value(match: re.Match[str]) -> str:
    """Return a YAML value as a Python literal; unchanged if it is no YAML, or a placeholder such as `[x, y, z]`."""
    text = match[0]
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        return text
    return repr(value).replace("'", '"') if "..." not in text and "x, y, z" not in text else text
