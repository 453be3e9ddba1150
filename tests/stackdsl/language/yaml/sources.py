"""Scenario files as tests read them, with each of the parsers that PyYAML may have."""

from collections.abc import Iterator

import pytest
import yaml

from stackdsl.diagnostics import Span
from stackdsl.language.yaml import source as source_module
from stackdsl.language.yaml.source import Loaded, Plain, Source, parse

PARSERS = [yaml.SafeLoader, *([yaml.CSafeLoader] if yaml.__with_libyaml__ else [])]

# Plain scalars that versions of YAML read differently, each with the remedy that is told.
TRUE_LIKE = ["yes", "Yes", "YES", "on", "On", "y", "Y", "True", "TRUE", "tRUE"]
FALSE_LIKE = ["no", "No", "NO", "off", "OFF", "n", "N", "False", "FALSE"]
REMEDIES = [
    *[(text, "write true, or quote it if it is text") for text in TRUE_LIKE],
    *[(text, "write false, or quote it if it is text") for text in FALSE_LIKE],
    *[(text, "write the value, or remove the key") for text in ("null", "Null", "NULL", "~")],
    *[
        (text, f"write {number}, or quote it if it is text")
        for text, number in [
            ("012", "12"),
            ("-007", "-7"),
            ("00", "0"),
            ("00.5", "0.5"),
            ("1_000", "1000"),
            ("1_000.5", "1000.5"),
            (".5", "0.5"),
            ("-.5", "-0.5"),
            ("5.", "5.0"),
            ("5.e3", "5.0e3"),
            (".5e3", "0.5e3"),
            ("+5", "5"),
            ("+0.5", "0.5"),
        ]
    ],
    *[
        (text, "write it in decimal, or quote it if it is text")
        for text in ("0o17", "0x1F", "0b1", "-0x1f", "0XFF", "0O7", "0B1", "0x_ff")
    ],
    *[
        (text, "write a time with its unit, such as 90 s, or quote it if it is text")
        for text in ("1:30", "1:30:00", "-1:30", "1:30.5", "16:9")
    ],
    *[
        (text, "write a finite number, or quote it if it is text")
        for text in (".inf", "-.inf", "+.Inf", ".nan", ".NaN", "inf", "-inf", "nan", "NaN", "Infinity")
    ],
    *[
        (text, "write fewer digits, or quote it if it is text")
        for text in ("1e999", "-1e999", "1e-999", "9007199254740993", "-9007199254740993", "9" * 5000)
    ],
    *[(text, "quote it") for text in ("2020-01-01", "2020-1-1", "2020-01-01 12:00:00", "2001-12-14t21:59:43.10-05:00")],
    *[(text, "quote it") for text in ("<<", "=")],
]


@pytest.fixture(params=PARSERS, ids=lambda parser: parser.__name__, autouse=True, scope="module")
def each_parser(request: pytest.FixtureRequest) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(source_module, "YAML_LOADER", request.param)
        yield


def only(loaded: Loaded) -> Source:
    assert loaded.diagnostics == ()
    (source,) = loaded.sources
    return source


def values(text: str) -> dict[str, Plain]:
    return only(parse(text, "a.yaml")).values


def found(loaded: Loaded) -> list[str]:
    """Each mistake as `code line:column`."""
    return [f"{each.code} {each.span.line}:{each.span.column}" for each in loaded.diagnostics]


def mistakes(text: str) -> list[str]:
    return found(parse(text, "a.yaml"))


def marked(span: Span) -> str:
    """The characters that the caret of a span would underline."""
    start = span.column - span.excerpt_column
    return span.excerpt[start : start + span.end_column - span.column]
