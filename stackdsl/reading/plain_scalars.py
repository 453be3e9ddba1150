"""What a plain scalar means: a value only where no YAML version and no eye reads it otherwise.

Those are numbers as JSON writes them, `true` and `false`. What remains is text, or else a trap (`no`, `012`, `1:30`, an
empty value): an error with its remedy.
"""

import re
from dataclasses import dataclass
from math import isfinite
from typing import Final, TypeAlias

Scalar: TypeAlias = bool | int | float | str | None

MAX_EXACT: Final = 2**53  # the largest integer up to which a double, and so every JSON reader, is exact
QUOTE_WIDTH: Final = 40  # [characters] of the author's text in a message

KEYS: Final = ("y", "n", "Y", "N", "on")  # no scenario has true or false for a key

INTEGER = re.compile(r"-?(0|[1-9]\d*)", re.ASCII)
FLOAT = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][-+]?\d+)?", re.ASCII)
# What may follow the digits begins with a dot, so that there is one way to read them: two ways take quadratic time.
LOOSE_NUMBER = re.compile(r"[-+]?(\d[\d_]*(\.[\d_]*)?|\.\d[\d_]*)([eE][-+]?\d+)?", re.ASCII)


@dataclass(frozen=True, slots=True)
class Trap:
    """Why a plain scalar is ambiguous, and what to write instead."""

    meaning: str
    remedy: str


TRUE = Trap("is true to some YAML readers and text to others", "write true, or quote it if it is text")
FALSE = Trap("is false to some YAML readers and text to others", "write false, or quote it if it is text")
NULL = Trap("is a missing value", "write the value, or leave out the key")
NOT_FINITE = Trap("is not a finite number", "write a finite number, or quote it if it is text")
OUT_OF_RANGE = Trap("is beyond what a number can hold", "write fewer digits, or quote it if it is text")
MERGE = Trap("has a meaning of its own in YAML 1.1", "quote it")
TRAP_WORDS: Final = {
    **dict.fromkeys(("true", "yes", "on", "y"), TRUE),
    **dict.fromkeys(("false", "no", "off", "n"), FALSE),
    **dict.fromkeys(("null", "~", ""), NULL),
    **dict.fromkeys((sign + word for sign in ("", "+", "-") for word in (".inf", "inf", "infinity")), NOT_FINITE),
    **dict.fromkeys((".nan", "nan"), NOT_FINITE),
    **dict.fromkeys(("<<", "="), MERGE),
}
TRAP_SHAPES: Final = (
    (
        re.compile(r"[-+]?0([oO][0-7_]+|[xX][\da-fA-F_]+|[bB][01_]+)", re.ASCII),
        Trap("is a number in another base to some YAML readers", "write it in decimal, or quote it if it is text"),
    ),
    (
        re.compile(r"[-+]?[\d_]+(:\d+)+(\.[\d_]*)?", re.ASCII),
        Trap("is a number to base 60 in YAML 1.1", "write a time with its unit, as in 90 s, or quote it if it is text"),
    ),
    (
        re.compile(r"\d{4}-\d\d?-\d\d?(([Tt]|[ \t]+)\d\d?:\d\d(:\d\d)?.*)?", re.ASCII),
        Trap("is a date to some YAML readers", "quote it"),
    ),
)


def plain_value(text: str) -> Scalar | Trap:
    """What a plain scalar means; a number or boolean only if nobody reads it otherwise."""
    if text in ("true", "false"):
        return text == "true"
    if FLOAT.fullmatch(text):
        return _number(text)
    if LOOSE_NUMBER.fullmatch(text):
        remedy = f"write {shown(_strict_number(text))}, or quote it if it is text"
        return Trap("is not a number to every YAML reader", remedy)
    shaped = (trap for shape, trap in TRAP_SHAPES if shape.fullmatch(text))
    return TRAP_WORDS.get(text.lower()) or next(shaped, text)


def _number(text: str) -> int | float | Trap:
    """The number that a strict text stands for, unless that loses digits or leaves the range of doubles."""
    if INTEGER.fullmatch(text):
        # The length first: Python refuses to convert very long integers.
        exact = len(text) <= len(str(-MAX_EXACT)) and abs(int(text)) <= MAX_EXACT
        return int(text) if exact else OUT_OF_RANGE
    value = float(text)
    vanished = value == 0 and re.search("[1-9]", re.split("[eE]", text)[0])
    return OUT_OF_RANGE if vanished or not isfinite(value) else value


def _strict_number(text: str) -> str:
    """A loosely written number as JSON writes it: `+012` as 12, `.5` as 0.5, `1_000.` as 1000.0."""
    sign = "-" if text.startswith("-") else ""
    digits = text.lstrip("+-").replace("_", "").lstrip("0")
    whole = digits if digits[:1].isdigit() else f"0{digits}"
    return sign + re.sub(r"\.(?!\d)", ".0", whole)


def key_trap(key: str) -> Trap | None:
    """Why a plain key is ambiguous; `y` and `n` name coordinates and counts, and `on` says on what a brick lies."""
    value = key if key in KEYS else plain_value(key)
    if isinstance(value, str):
        return None
    meaning = value.meaning if isinstance(value, Trap) else "is not text"
    return Trap(meaning, f'quote it: "{shown(key)}"')


def shown(text: str) -> str:
    """The author's text in a message, cut to a bearable length."""
    return text if len(text) <= QUOTE_WIDTH else text[: QUOTE_WIDTH - 1] + "…"
