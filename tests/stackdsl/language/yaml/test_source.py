"""Reading of a scenario file into values with places."""

import os
import pickle
from pathlib import Path

import pytest

from stackdsl.language.yaml.source import MAX_BYTES, load, parse
from tests.stackdsl.language.yaml.sources import each_parser, found, marked, only, values

__all__ = ["each_parser"]  # used by every test here


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


def test_a_missing_value_has_the_place_of_its_closest_ancestor() -> None:
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
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    (tmp_path / "a.yaml").touch()
    monkeypatch.setattr(os, "open", refuse)  # the tests may run as root, who may read everything
    assert load(tmp_path / "a.yaml").diagnostics[0].message == "cannot read the file: Permission denied"


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        ("a: 1\nb: é\n".encode("latin-1"), "SD002 2:4"),
        ("± 😀: ".encode() + b"\xff\n", "SD002 1:6"),
        (b"a: 1\r\nb: \xe2\x82", "SD002 2:4"),  # cut in the middle of a character
        (b"\xef\xbb\xbfa: \xff", "SD002 1:4"),
        (b"a: \xed\xa0\x80\n", "SD002 1:4"),  # a surrogate
    ],
)
def test_invalid_utf8_has_the_place_of_its_first_bad_byte(tmp_path: Path, data: bytes, expected: str) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(data)
    loaded = load(path)
    assert found(loaded) == [expected]
    assert marked(loaded.diagnostics[0].span) == "\N{REPLACEMENT CHARACTER}"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\x00\x01PNG", "the file is not a text file"),
        (b"PK\x03\x04 a workbook", "the file is not a text file"),
        ("a: 1\n".encode("utf-16"), "the text of the file is UTF-16"),
    ],
)
def test_a_file_of_another_kind_has_one_message(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(data)
    (mistake,) = load(path).diagnostics
    assert (mistake.code, mistake.message) == ("SD002", message)


def test_a_file_is_measured_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes("±".encode() * (MAX_BYTES // 2 + 1))
    assert found(load(path)) == ["SD006 1:1"]


def test_every_value_and_key_of_a_source_has_a_span() -> None:
    source = only(parse(PLACES, "a.yaml"))
    assert set(source.key_spans) == {path for path in source.value_spans if path and isinstance(path[-1], str)}
    assert len(source.value_spans) == 18


def test_sources_travel_to_worker_processes() -> None:
    source = only(parse(PLACES, "a.yaml"))
    assert pickle.loads(pickle.dumps(source)) == source
