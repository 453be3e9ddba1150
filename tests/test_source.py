"""A scenario file as values with places: what is accepted, which traps are refused, and what hostile files do."""

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from stackdsl.diagnostics import CODES, Span
from stackdsl.reading import source as source_module
from stackdsl.reading.source import (
    MAX_ALIASED,
    MAX_BYTES,
    MAX_DEPTH,
    MAX_MISTAKES,
    MAX_VALUES,
    Loaded,
    Plain,
    Source,
    load,
    parse,
)

PARSERS = [yaml.SafeLoader, *([yaml.CSafeLoader] if yaml.__with_libyaml__ else [])]


@pytest.fixture(params=PARSERS, ids=lambda parser: parser.__name__, autouse=True, scope="module")
def _each_parser(request: pytest.FixtureRequest) -> Iterator[None]:
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


# --- values -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12),
        ("0", 0),
        ("-3", -3),
        ("9007199254740992", 2**53),
        ("0.5", 0.5),
        ("-0.25", -0.25),
        ("1e3", 1000.0),
        ("1E3", 1000.0),
        ("1.5e-3", 0.0015),
        ("1e+2", 100.0),
        ("true", True),
        ("false", False),
    ],
)
def test_numbers_as_json_writes_them_and_booleans_are_values(text: str, value: float) -> None:
    read = values(f"a: {text}")["a"]
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    "text",
    [
        "13.5 mm",
        "9 ± 1",
        "9 +- 1",
        "5 s .. 7 s",
        "<= 2",
        "-5 mm",
        "+5 mm",
        "${a + 2 mm}",
        "level 9",
        "L3.2",
        "1.5.2",
        "e3",
        "1e",
        "none",
        "nothing",
        "yes please",
        "2020-01-01 to 2020-02-01",
        "1:30 min",
        "0.4 N*s",
        "٣",  # a digit to Python, but not to JSON
        "1٣",
        "_1",
        "a.b-c/d.yaml",
        "1#2",
        "😀",
    ],
)
def test_everything_else_is_text(text: str) -> None:
    assert values(f"a: {text}") == {"a": text}


@pytest.mark.parametrize("text", ["no", "12", "null", "", "1:30", "0x1F", "<<", "true", "2020-01-01", "#", "a: b"])
def test_quoted_scalars_are_always_text(text: str) -> None:
    assert values(f"a: \"{text}\"\nb: '{text}'") == {"a": text, "b": text}


def test_block_scalars_are_always_text() -> None:
    assert values("a: |\n  12\nb: >-\n  no\n  yes\n") == {"a": "12\n", "b": "no yes"}


def test_lists_and_mappings_nest_in_either_style() -> None:
    block = "a:\n  - b: 1\n    c: [x, {d: 2}]\n  - - 3\ne: {}\nf: []\n"
    assert values(block) == {"a": [{"b": 1, "c": ["x", {"d": 2}]}, [3]], "e": {}, "f": []}


def test_each_document_is_a_scenario() -> None:
    sources = parse("a: 1\n---\na: 2\n...\n---\na: 3\n", "a.yaml").sources
    assert [source.values for source in sources] == [{"a": 1}, {"a": 2}, {"a": 3}]


@pytest.mark.parametrize("text", ["\ufeffa: 1\nb: 2\n", "a: 1\r\nb: 2\r\n", "a: 1\rb: 2\r", "a: 1\nb: 2"])
def test_byte_order_mark_and_line_ends_change_nothing(text: str) -> None:
    source = only(parse(text, "a.yaml"))
    assert source.values == {"a": 1, "b": 2}
    assert str(source.span_of(("b",))) == "a.yaml:2:4"
    assert source.span_of(("a",)).excerpt == "a: 1"


# --- places -----------------------------------------------------------------------------------------------------------

PLACES = """\
scenario: slant
friction: 9 ± 1  # 😀
build:
  - four_stack: {levels: 12, step: 11 mm}
    every: "1 s"
  - - 5
note: |
  two
  lines
flow: [1,\x20
  2]
world:
  ground: &g
    friction: 0.5
"""


@pytest.mark.parametrize(
    ("path", "line", "column", "underlined"),
    [
        (("scenario",), 1, 11, "slant"),
        (("friction",), 2, 11, "9 ± 1"),
        (("build",), 3, 1, "build"),  # a block list or mapping is its key
        (("build", 0), 4, 5, "four_stack"),  # or its first key
        (("build", 0, "four_stack"), 4, 17, "{levels: 12, step: 11 mm}"),
        (("build", 0, "four_stack", "step"), 4, 36, "11 mm"),
        (("build", 0, "every"), 5, 12, '"1 s"'),
        (("build", 1), 6, 5, "-"),
        (("build", 1, 0), 6, 7, "5"),
        (("note",), 7, 7, "|"),
        (("flow",), 10, 7, "[1,"),
        (("flow", 1), 11, 3, "2"),
        (("world",), 12, 1, "world"),
        (("world", "ground"), 13, 3, "ground"),
        ((), 1, 1, "scenario"),
    ],
)
def test_every_value_has_its_place(path: tuple[str | int, ...], line: int, column: int, underlined: str) -> None:
    span = only(parse(PLACES, "a.yaml")).span_of(path)
    assert (span.line, span.column, marked(span)) == (line, column, underlined)


@pytest.mark.parametrize(
    ("path", "line", "column", "underlined"),
    [
        (("friction",), 2, 1, "friction"),
        (("build", 0, "four_stack", "step"), 4, 30, "step"),
        (("build", 0), 4, 5, "four_stack"),  # an item has no key
        (("build", 0, "four_stack", "speed"), 4, 17, "{levels: 12, step: 11 mm}"),  # nor has what is missing
    ],
)
def test_every_key_has_its_place(path: tuple[str | int, ...], line: int, column: int, underlined: str) -> None:
    span = only(parse(PLACES, "a.yaml")).key_span_of(path)
    assert (span.line, span.column, marked(span)) == (line, column, underlined)


def test_what_is_missing_is_placed_at_its_closest_ancestor() -> None:
    source = only(parse(PLACES, "a.yaml"))
    assert source.span_of(("build", 0, "every", "x", 3)) == source.span_of(("build", 0, "every"))
    assert source.span_of(("impacts", 0)) == source.span_of(())


def test_columns_count_characters_and_not_bytes() -> None:
    span = only(parse("± 😀: {ä: 5 ± 1, b: 7}\n", "a.yaml")).span_of(("± 😀", "b"))
    assert (span.column, marked(span)) == (20, "7")


def test_a_repeated_value_is_placed_at_its_alias_and_its_parts_where_they_are_written() -> None:
    source = only(parse("a: &x {b: 1}\nc: *x\nd: [*x]\n", "a.yaml"))
    assert source.values == {"a": {"b": 1}, "c": {"b": 1}, "d": [{"b": 1}]}
    assert marked(source.span_of(("c",))) == "*x"
    assert str(source.span_of(("d", 0, "b"))) == "a.yaml:1:11"
    assert str(source.key_span_of(("d", 0, "b"))) == "a.yaml:1:8"


def test_a_long_line_is_cut_around_the_place() -> None:
    text = "a: [" + "x, " * 300 + "no, " + "z, " * 300 + "z]\n"
    (diagnostic,) = parse(text, "a.yaml").diagnostics
    span = diagnostic.span
    assert (span.column, marked(span), len(span.excerpt)) == (905, "no", 200)
    assert (span.excerpt[0], span.excerpt[-1]) == ("…", "…")


@pytest.mark.parametrize(("before", "after"), [(3, 600), (600, 0)])
def test_a_long_line_is_cut_on_one_side_near_its_ends(before: int, after: int) -> None:
    text = "a: [" + "x, " * before + "no" + ", z" * after + "]\n"
    (diagnostic,) = parse(text, "a.yaml").diagnostics
    assert marked(diagnostic.span) == "no"
    assert (len(diagnostic.span.excerpt), diagnostic.span.excerpt.count("…")) == (200, 1)


# --- traps ------------------------------------------------------------------------------------------------------------

TRUE_LIKE = ["yes", "Yes", "YES", "on", "On", "y", "Y", "True", "TRUE", "tRUE"]
FALSE_LIKE = ["no", "No", "NO", "off", "OFF", "n", "N", "False", "FALSE"]
REMEDIES = [
    *[(text, "write true, or quote it if it is text") for text in TRUE_LIKE],
    *[(text, "write false, or quote it if it is text") for text in FALSE_LIKE],
    *[(text, "write the value, or leave out the key") for text in ("null", "Null", "NULL", "~")],
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
        (text, "write a time with its unit, as in 90 s, or quote it if it is text")
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


@pytest.mark.parametrize(("text", "remedy"), REMEDIES, ids=lambda text: text[:30])
def test_what_yaml_versions_read_differently_is_refused_with_the_remedy(text: str, remedy: str) -> None:
    (diagnostic,) = parse(f"b: 1\na: {text}  # why\n", "a.yaml").diagnostics
    assert (diagnostic.code, str(diagnostic.span)) == ("SD009", "a.yaml:2:4")
    assert diagnostic.span.end_column == 4 + len(text)
    assert diagnostic.hint == remedy


@pytest.mark.parametrize(
    ("text", "place", "underlined"),
    [
        ("a:\nb: 1\n", "1:1", "a"),
        ("b: 1\na:   # later\n", "2:1", "a"),
        ("a: {b: , c: 1}\n", "1:5", "b"),
        ("a: {b, c: 1}\n", "1:5", "b"),
        ("a:\n  - 1\n  -\n", "3:3", "-"),
        ("a: &x\nb: 1\n", "1:1", "a"),
    ],
)
def test_an_empty_value_is_refused_at_its_key_or_dash(text: str, place: str, underlined: str) -> None:
    (diagnostic,) = parse(text, "a.yaml").diagnostics
    assert (diagnostic.code, diagnostic.message) == ("SD009", "a value is missing")
    assert str(diagnostic.span) == f"a.yaml:{place}"
    assert marked(diagnostic.span) == underlined


def test_a_colon_without_its_space_is_named_as_the_reason() -> None:
    (in_braces,) = parse("a: {x:1}\n", "a.yaml").diagnostics
    (as_root,) = parse("a:1\n", "a.yaml").diagnostics
    assert in_braces.hint == as_root.hint == "put a space after the colon"


@pytest.mark.parametrize("key", ["1", "-3", "0.5", "1e3", "true", "True", "no", "on", "null", "~", "1:30", "012", ".5"])
def test_a_key_that_does_not_look_like_text_must_be_quoted(key: str) -> None:
    (diagnostic,) = parse(f"b: 1\n{key}: x\n", "a.yaml").diagnostics
    assert (diagnostic.code, str(diagnostic.span)) == ("SD009", "a.yaml:2:1")
    assert diagnostic.hint == f'quote it: "{key}"'
    assert diagnostic.message.startswith(f"the key '{key}' is ")
    assert values(f'"{key}": x\n') == {key: "x"}


@pytest.mark.parametrize("key", ["x", "y", "n", "Y", "level 9", "L1.2", "9 ± 1"])
def test_coordinates_and_counts_may_be_keys(key: str) -> None:
    assert values(f"{key}: 1\n") == {key: 1}


def test_an_unquoted_comparison_is_not_swallowed_by_a_text_block() -> None:
    (tight,) = parse("a: >5\nb: 1\n", "a.yaml").diagnostics
    assert mistakes("a: &x >5\nb: 1\n") == ["SD009 1:4"]
    (loose,) = parse("a: >= 20\nb: 1\n", "a.yaml").diagnostics
    assert (tight.code, str(tight.span), tight.hint) == ("SD009", "a.yaml:1:4", 'quote a comparison: ">5"')
    assert (loose.code, str(loose.span), loose.hint) == ("SD004", "a.yaml:1:4", 'quote a comparison: ">= 20"')


# --- refused features -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a: 1\nb: !!str 1\n", "SD010 2:4"),
        ("a: !local {b: 1}\n", "SD010 1:4"),
        ("a: ! 1\n", "SD010 1:4"),
        ("!!map\na: 1\n", "SD010 1:1"),
        ("!!str a: 1\n", "SD010 1:1"),
        ("a: !e!x 1\n", "SD010 1:4"),  # a tag handle that nobody defined
        ("a: !<x 1\n", "SD010 1:4"),  # a tag that is not closed
        ("a: &x {b: 1}\nc:\n  <<: *x\n", "SD010 3:3"),
        ("? [a, b]\n: 1\n", "SD010 1:3"),
        ("? {a: b}\n: 1\n", "SD010 1:3"),
        ("? |\n  a\n: 1\n", "SD010 1:3"),
        ("? a\n  b\n: 1\n", "SD010 1:3"),
        ("a: &x 1\n*x : 1\n", "SD010 2:1"),
        ("&x a: 1\n", "SD010 1:1"),
        ("a: &x 1\nb: &x 2\n", "SD010 2:4"),
        ("%YAML 1.1\n---\na: 1\n", "SD010 1:1"),
        ("%TAG ! tag:x:\n---\na: 1\n", "SD010 1:1"),
        ("%YAML 2.0\n---\na: 1\n", "SD010 1:1"),
        ("%OWN x\n---\na: 1\n", "SD010 1:1"),
    ],
)
def test_yaml_features_that_scenarios_do_without_are_refused(text: str, expected: str) -> None:
    assert mistakes(text) == [expected]


def test_a_tag_is_named_as_it_is_written() -> None:
    (diagnostic,) = parse("a: !!str 1\n", "a.yaml").diagnostics
    assert diagnostic.message == "the tag '!!str'"


def test_a_duplicate_key_names_the_first() -> None:
    (diagnostic,) = parse('bricks:\n  {top: 1, "top": 2}\n', "a.yaml").diagnostics
    assert (diagnostic.code, str(diagnostic.span)) == ("SD003", "a.yaml:2:12")
    assert diagnostic.message == "duplicate key 'top', first defined at 2:4"


def test_equal_keys_of_different_mappings_are_no_duplicates() -> None:
    assert values("a: {x: 1}\nb: {x: 2}\n") == {"a": {"x": 1}, "b": {"x": 2}}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "SD005 1:1"),
        ("\ufeff", "SD005 1:1"),
        ("# only\n\n# comments\n", "SD005 1:1"),
        ("---\n", "SD005 1:1"),
        ("---\n# nothing\n---\na: 1\n", "SD005 1:1"),
        ("a: 1\n---\n", "SD005 2:1"),
        ("- a\n- b\n", "SD004 1:1"),
        ("just text\n", "SD004 1:1"),
        ("[a]\n", "SD004 1:1"),
        ("no\n", "SD004 1:1"),
        ('""\n', "SD004 1:1"),
        ("a: 1\n--- 12\n", "SD004 2:5"),
    ],
)
def test_a_document_without_a_scenario_is_refused(text: str, expected: str) -> None:
    assert mistakes(text) == [expected]


# --- malformed text ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("a: b: c\n", "1:5", "a ':' where no key can stand"),
        ("a: 1\n b: 2\n", "2:3", "a ':' where no key can stand"),
        ("9 ± 1 😀: b: c\n", "1:11", "a ':' where no key can stand"),
        ("a: 1\n\tb: 2\n", "2:1", "a tab"),
        ("a: 1 \t# aligned\n", "1:6", "a tab"),
        ("a: \0\n", "1:4", "the character U+0000 cannot stand in a scenario"),
        ("# \x1b[31m\n", "1:3", "the character U+001B cannot stand in a scenario"),
        ("a: b\ufeff\n", "1:5", "the character U+FEFF ZERO WIDTH NO-BREAK SPACE cannot stand in a scenario"),
        ("a: b\u2028c: d\n", "1:5", "the character U+2028 LINE SEPARATOR cannot stand in a scenario"),
        ("a: \ud800\n", "1:4", "the character U+D800 cannot stand in a scenario"),
        ("a: @b\n", "1:4", "a value cannot begin with '@'"),
        ("a: %b\n", "1:4", "a value cannot begin with '%'"),
        ("a: }\n", "1:4", "a value cannot begin with '}'"),
        ('b: 1\na: "x\n', "2:4", "a quoted text is not closed"),
        ("a: 'x\n---\nb: 1\n", "1:4", "a quoted text is not closed"),
        ('a: "b \\q"\n', "1:7", "an escape that YAML does not know"),
        ("a: 'it's'\n", "1:8", "neither a key of the mapping from line 1 nor its end"),
        ('a:\n  b: "x" y\n', "2:10", "neither a key of the mapping from line 2 nor its end"),
        ("a:\n  - 1\n  b: 2\n", "3:3", "neither an item of the list from line 2 nor its end"),
        ("a: |\n  x\nb\n", "3:1", "a key without its ':'"),
        ("a: |\n  x\nb\nc: 1\n", "3:1", "a key without its ':'"),
        ("a: [1, 2\nb: 3\n", "2:2", "the list that opens in line 1 lacks a ',' or ']'"),
        ("a:\n  - [1, 2", "2:5", "the list that opens in line 2 lacks a ',' or ']'"),
        ("a: [${x}, 1]\n", "1:6", "the list that opens in line 1 lacks a ',' or ']'"),
        ("a: {b: 1\n", "1:4", "the mapping that opens in line 1 lacks a ',' or '}'"),
        ("a: [1,, 2]\n", "1:7", "a value or a closing bracket is missing"),
        ("a: [", "1:4", "a value or a closing bracket is missing"),
        ("a: - 5\n", "1:4", "a list cannot begin here"),
        ("a: ? b\n", "1:4", "a '?' that begins no key"),
        ("a: *\n", "1:4", "an alias or anchor without a name"),
        ("a: &.b 1\n", "1:4", "an alias or anchor without a name"),
        ("a: 1\n...\nb: 2\n", "3:1", "text after the end of a document"),
        ("a: &b 1\nc: *d\n", "2:4", "there is no anchor 'd' before this alias"),
        ("a: *b\nc: &b 1\n", "1:4", "there is no anchor 'b' before this alias"),
        ("a: &b 1\n---\nc: *b\n", "3:4", "there is no anchor 'b' before this alias"),
    ],
)
def test_malformed_yaml_is_placed_and_told_in_plain_words(text: str, place: str, message: str) -> None:
    (diagnostic,) = parse(text, "a.yaml").diagnostics
    assert (diagnostic.code, str(diagnostic.span), diagnostic.message) == ("SD004", f"a.yaml:{place}", message)
    assert diagnostic.hint


@pytest.mark.parametrize("escape", ["\\ud800", "\\U00110000", "\\UFFFFFFFF"])
def test_an_escape_beyond_unicode_is_refused(escape: str) -> None:
    (diagnostic,) = parse(f'a: "{escape}"\n', "a.yaml").diagnostics
    assert (diagnostic.code, diagnostic.message) == ("SD004", "an escape that YAML does not know")


def test_a_misspelt_alias_is_told_the_name_it_meant() -> None:
    (diagnostic,) = parse("a: &plank 1\nb: *plnk\n", "a.yaml").diagnostics
    assert diagnostic.hint == "did you mean 'plank'?"


# --- several mistakes -------------------------------------------------------------------------------------------------

MANY = "a: no\nb: [1, 0x1F]\na: 2\n1: x\n---\nok: 1\n---\nc: ~\nd: !t 1\ne: b: c\n---\nf: no\n"


def test_all_mistakes_are_reported_in_the_order_of_the_text_until_it_becomes_unreadable() -> None:
    expected = ["SD009 1:4", "SD009 2:8", "SD003 3:1", "SD009 4:1", "SD009 8:4", "SD010 9:4", "SD004 10:5"]
    assert mistakes(MANY) == expected


def test_only_documents_without_a_mistake_become_sources() -> None:
    assert [source.values for source in parse(MANY, "a.yaml").sources] == [{"ok": 1}]


def test_a_mistake_inside_a_repeated_value_is_reported_once() -> None:
    assert mistakes("a: &x {b: no}\nc: *x\nd: *x\n") == ["SD009 1:11"]


def test_values_inside_refused_features_are_still_checked() -> None:
    assert mistakes("? [no]\n: yes\na: !t off\na: 012\n") == [
        "SD010 1:3",
        "SD009 1:4",
        "SD009 2:3",
        "SD009 3:4",
        "SD010 3:4",
        "SD003 4:1",
        "SD009 4:4",
    ]


def test_every_code_is_in_the_table() -> None:
    assert {diagnostic.code for diagnostic in parse(MANY, "a.yaml").diagnostics} <= set(CODES)


# --- hostile files ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("[" * 100_000, "1:65"),
        ("a: " + "[" * 100_000, "1:67"),
        ("{a: " * 100_000, "1:257"),
        ("- " * 100_000, "1:129"),
        ("a:\n  " + "- " * 100_000, "2:129"),
    ],
    ids=["brackets", "brackets in a mapping", "braces", "dashes", "dashes in a mapping"],
)
def test_deep_nesting_stops_at_once(text: str, place: str) -> None:
    assert mistakes(text) == [f"SD007 {place}"]


def test_deep_complex_keys_stop_at_once() -> None:
    assert "SD007 1:129" in mistakes("? " * 100_000)


def test_the_deepest_nesting_allowed_is_read() -> None:
    depth = MAX_DEPTH - 1
    assert "a" in values("a: " + "[" * depth + "1" + "]" * depth)
    assert mistakes("a: " + "[" * (depth + 1) + "]" * (depth + 1)) == [f"SD007 1:{4 + depth}"]


def chain(length: int) -> str:
    """Each definition is two deep, and yet builds on the one before."""
    return "a0: &a0 [x]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, length))


def test_aliases_cannot_nest_deeper_than_brackets() -> None:
    assert len(values(chain(MAX_DEPTH - 1))) == MAX_DEPTH - 1
    assert mistakes(chain(3000)) == [f"SD007 {MAX_DEPTH}:12"]  # the alias that first reaches too deep


def bomb(levels: int) -> str:
    steps = (f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, levels))
    return "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(steps)


def test_an_alias_bomb_is_defused() -> None:
    (mistake,) = mistakes(bomb(levels=12))
    assert mistake.startswith("SD008")
    assert len(values(bomb(levels=3))) == 3


def test_aliases_may_repeat_a_bounded_number_of_values_in_one_file() -> None:
    most = "a: &a 1\nb: [" + "*a," * MAX_ALIASED + "]\n"
    assert len(values(most)) == 2
    assert [mistake[:5] for mistake in mistakes(f"{most}---\na: &a 1\nb: *a\n")] == ["SD008"]


@pytest.mark.parametrize("text", ["a: &x [*x]\n", "a: &x {b: [1, *x]}\n"])
def test_a_value_cannot_repeat_itself(text: str) -> None:
    (mistake,) = mistakes(text)
    assert mistake.startswith("SD008 1:")


def test_a_large_file_is_refused_and_the_largest_allowed_is_read() -> None:
    fitting = "a: " + "x" * (MAX_BYTES - 3)
    assert len(str(values(fitting)["a"])) == MAX_BYTES - 3
    assert mistakes(f"{fitting}x") == ["SD006 1:1"]


def test_a_file_of_too_many_values_is_refused() -> None:
    (mistake,) = mistakes("a: [" + "0," * MAX_VALUES + "]\n")
    assert mistake == f"SD006 1:{5 + 2 * (MAX_VALUES - 2)}"  # the mapping and the list are values too


@pytest.mark.parametrize("line", ["a: 1\n", "---\n", "\0\n"], ids=["duplicates", "documents", "characters"])
def test_the_number_of_mistakes_is_bounded(line: str) -> None:
    assert len(mistakes(line * 50_000)) == MAX_MISTAKES


def test_a_misspelt_alias_among_many_long_anchors_is_found_at_once() -> None:
    anchors = "".join(f"- &{'a' * 5000}{i} 1\n" for i in range(100))
    assert len(mistakes(f"a:\n{anchors}" + "- *b\n" * 100)) == 100


# --- files ------------------------------------------------------------------------------------------------------------


def test_a_file_is_read_and_named_as_it_was_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes("\ufeffa: 9 ± 1\r\n".encode())
    source = only(load(path))
    assert source.values == {"a": "9 ± 1"}
    assert source.file == source.span_of(("a",)).file == path.as_posix()


@pytest.mark.parametrize("name", ["missing.yaml", ".", "nul\0.yaml", "x" * 5000])
def test_a_file_that_cannot_be_read_is_a_diagnostic(tmp_path: Path, name: str) -> None:
    loaded = load(tmp_path / name)
    assert found(loaded) == ["SD001 1:1"]
    assert loaded.diagnostics[0].message.startswith("cannot read the file: ")


def test_a_file_that_may_not_be_read_is_a_diagnostic(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)  # the tests may run as root, who may read everything
    assert load(tmp_path / "a.yaml").diagnostics[0].message == "cannot read the file: Permission denied"


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        ("a: 1\nb: é\n".encode("latin-1"), "SD002 2:4"),
        ("± 😀: ".encode() + b"\xff\n", "SD002 1:6"),
        (b"a: 1\r\nb: \xe2\x82", "SD002 2:4"),  # cut in the middle of a character
        (b"\xef\xbb\xbfa: \xff", "SD002 1:4"),
        ("a: 1\n".encode("utf-16"), "SD002 1:1"),
        (b"a: \xed\xa0\x80\n", "SD002 1:4"),  # a surrogate
    ],
)
def test_what_is_not_utf8_is_placed_at_the_first_bad_byte(tmp_path: Path, data: bytes, expected: str) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(data)
    loaded = load(path)
    assert found(loaded) == [expected]
    assert marked(loaded.diagnostics[0].span) == "\N{REPLACEMENT CHARACTER}"


def test_a_file_is_measured_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes("±".encode() * (MAX_BYTES // 2 + 1))
    assert found(load(path)) == ["SD006 1:1"]


# --- properties -------------------------------------------------------------------------------------------------------

SCALARS = st.one_of(
    st.text(max_size=30),
    st.sampled_from([text for text, _ in REMEDIES]),
    st.integers(-(2**53), 2**53),
    st.floats(allow_nan=False, allow_infinity=False),
    st.booleans(),
)
KEYS = st.text(max_size=20) | st.sampled_from(["no", "1", "<<", "1:30", "null"])
NESTED = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4), max_leaves=20
)
SCENARIOS = st.dictionaries(KEYS, NESTED, max_size=5)
YAML_TEXTS = st.lists(
    st.sampled_from(["a", "1", " ", "  ", "\n", ": ", "- ", "[", "]", "{", "}", ", ", '"', "'", "|", ">", "&x ", "*x"])
    | st.sampled_from(
        ["!t ", "? ", " #", "\\", "%", "\t", "---\n", "...\n", "±", "\r\n", "~", "@", "<<: ", "\0", "no"]
    ),
    max_size=20,
).map("".join)


class QuotingDumper(yaml.SafeDumper):
    """Quotes all text, for PyYAML would leave some traps plain, such as `1e3` or `y`."""


QuotingDumper.add_representer(
    str, lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"')
)


@given(scenario=SCENARIOS, flow=st.booleans())
@example(scenario={"a": "1e3", "y": "y", "b": ["", {}, []]}, flow=False)
@example(scenario={"a": "\x85\u2028\ufeff\t\r\n\x00"}, flow=True)
def test_what_is_dumped_is_read_back(scenario: dict[str, Any], flow: bool) -> None:
    text = yaml.dump(
        scenario, Dumper=QuotingDumper, default_flow_style=flow, sort_keys=False, width=10**6
    )  # a key is one line
    assert repr(values(text)) == repr(scenario)  # by text, for True == 1 == 1.0


@given(YAML_TEXTS)
def test_any_text_is_either_read_or_refused_and_twice_the_same(text: str) -> None:
    loaded = parse(text, "a.yaml")
    assert loaded.sources or loaded.diagnostics
    assert parse(text, "a.yaml") == loaded
    assert all(diagnostic.hint and diagnostic.span.column >= 1 for diagnostic in loaded.diagnostics)


@given(YAML_TEXTS)
def test_mistakes_come_in_the_order_of_the_text(text: str) -> None:
    places = [(each.span.line, each.span.column) for each in parse(text, "a.yaml").diagnostics]
    assert places == sorted(places)


def test_every_value_and_key_of_a_source_has_a_span() -> None:
    source = only(parse(PLACES, "a.yaml"))
    assert set(source.key_spans) == {path for path in source.value_spans if path and isinstance(path[-1], str)}
    assert len(source.value_spans) == 18


def test_sources_travel_to_worker_processes() -> None:
    source = only(parse(PLACES, "a.yaml"))
    assert pickle.loads(pickle.dumps(source)) == source
