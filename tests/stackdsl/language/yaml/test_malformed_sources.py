"""Files that are no YAML, have many mistakes, or are made to do harm."""

import pytest

from stackdsl.diagnostics import CODES
from stackdsl.language.yaml.parsing import MAX_DEPTH, MAX_MISTAKES
from stackdsl.language.yaml.source import MAX_ALIASED, MAX_BYTES, parse
from tests.stackdsl.language.yaml.sources import each_parser, mistakes, values

__all__ = ["each_parser"]  # used by every test here


# --- malformed text ---------------------------------------------------------------------------------------------------


UNSEEN = "is invisible, or changes the appearance of the line"


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("a: b: c\n", "1:5", "unexpected ':'; a value cannot contain a second key on this line"),
        ("a: 1\n b: 2\n", "2:2", "`b` is indented by 1 space, and so belongs to no mapping"),
        ("9 ± 1 😀: b: c\n", "1:11", "unexpected ':'; a value cannot contain a second key on this line"),
        ("a: 1\n\tb: 2\n", "2:1", "tabs are not allowed"),
        ("a: 1 \t# aligned\n", "1:6", "tabs are not allowed"),
        ("a: \0\n", "1:4", "the character U+0000 is not allowed in a scenario"),
        ("# \x1b[31m\n", "1:3", "the character U+001B is not allowed in a scenario"),
        ("a: b\u202e# c\n", "1:5", f"the character U+202E RIGHT-TO-LEFT OVERRIDE {UNSEEN}"),
        ("a: 1  # \u202etxt\n", "1:9", f"the character U+202E RIGHT-TO-LEFT OVERRIDE {UNSEEN}"),
        ("# a\n# b \u2066c\n", "2:5", f"the character U+2066 LEFT-TO-RIGHT ISOLATE {UNSEEN}"),
        ("a: 'b\u061c'\n", "1:6", f"the character U+061C ARABIC LETTER MARK {UNSEEN}"),
        ("st\u200bands: 1\n", "1:3", f"the character U+200B ZERO WIDTH SPACE {UNSEEN}"),
        ("st\u200dands: 1\n", "1:3", f"the character U+200D ZERO WIDTH JOINER {UNSEEN}"),
        ("# \U000e0041\n", "1:3", f"the character U+E0041 TAG LATIN CAPITAL LETTER A {UNSEEN}"),
        ("a: \u3164\n", "1:4", f"the character U+3164 HANGUL FILLER {UNSEEN}"),
        ("a: b\ufeff\n", "1:5", "the character U+FEFF ZERO WIDTH NO-BREAK SPACE is not allowed in a scenario"),
        ("a: b\u2028c: d\n", "1:5", "the character U+2028 LINE SEPARATOR is not allowed in a scenario"),
        ("a: \ud800\n", "1:4", "the character U+D800 is not allowed in a scenario"),
        ("a: @b\n", "1:4", "a value cannot begin with '@'"),
        ("a: %b\n", "1:4", "a value cannot begin with '%'"),
        ("a: }\n", "1:4", "a value cannot begin with '}'"),
        ('b: 1\na: "x\n', "2:4", "the quoted text is not closed"),
        ("a: 'x\n---\nb: 1\n", "1:4", "the quoted text is not closed"),
        ('a: "b \\q"\n', "1:7", "the escape sequence is not part of YAML"),
        ("a: 'it's'\n", "1:8", "the line does not continue the mapping that begins in line 1"),
        ('a:\n  b: "x" y\n', "2:10", "the line does not continue the mapping that begins in line 2"),
        ("a:\n  - 1\n  b: 2\n", "3:3", "the line does not continue the list that begins in line 2"),
        ("a: |\n  x\nb\n", "3:1", "the key has no ':'"),
        ("a: |\n  x\nb\nc: 1\n", "3:1", "the key has no ':'"),
        ("a: {b: 1 c: 2}\n", "1:10", "a ',' is missing before `c`"),
        ("a: {b: 1}}\n", "1:10", "one '}' too many"),
        ("b: 2\na:1\n", "2:2", "a space is missing after ':'"),
        ("a: {b: \u201c1\u201d}}\n", "1:8", "\u201c is not a quote of YAML"),
        ("a:\n  - b: {c: 1}\n   d: 2\n", "3:4", "`d` is indented by 3 spaces, and so belongs to no mapping"),
        ("a: [1, 2\nb: 3\n", "1:8", "the '[' of 1:4 is not closed"),
        ("a:\n  - [1, 2", "2:9", "the '[' of 2:5 is not closed"),
        ("a: [${x}, 1]\n", "1:5", "${x} needs quotes in braces or brackets"),
        ("a: {b: 1\n", "1:8", "the '{' of 1:4 is not closed"),
        ("a: [1,, 2]\n", "1:7", "a value or a closing bracket is missing"),
        ("a: [", "1:4", "a value or a closing bracket is missing"),
        ("a: - 5\n", "1:4", "a list cannot begin here"),
        ("a: ? b\n", "1:4", "the '?' has no key"),
        ("a: *\n", "1:4", "the alias or anchor has no name"),
        ("a: &.b 1\n", "1:4", "the alias or anchor has no name"),
        ("a: 1\n...\nb: 2\n", "3:1", "unexpected text after the end of a document"),
        ("a: &b 1\nc: *d\n", "2:4", "the alias 'd' has no anchor above it"),
        ("a: *b\nc: &b 1\n", "1:4", "the alias 'b' has no anchor above it"),
        ("a: &b 1\n---\nc: *b\n", "3:4", "the alias 'b' has no anchor above it"),
    ],
)
def test_malformed_yaml_reports_place_and_cause(text: str, place: str, message: str) -> None:
    (diagnostic,) = parse(text, "a.yaml").diagnostics
    assert (diagnostic.code, str(diagnostic.span), diagnostic.message) == ("SD004", f"a.yaml:{place}", message)
    assert diagnostic.hint


@pytest.mark.parametrize(
    ("value", "written"),
    [
        ("{b: <= ${x}}", "<= ${x}"),
        ("{b: 1, c: ${x} .. ${y + 1} mm, d: 2}  # e", "${x} .. ${y + 1} mm"),
        ("[1, ${max(x, y)}]", "${max(x, y)}"),
        ('{b: 1, c: <= "${x}", d: 2}', "<= ${x}"),
    ],
)
def test_a_value_with_an_expression_is_quoted_whole(value: str, written: str) -> None:
    (diagnostic,) = parse(f"a: {value}\n", "a.yaml").diagnostics
    assert diagnostic.hint == f'write "{written}"'


@pytest.mark.parametrize("escape", ["\\ud800", "\\U00110000", "\\UFFFFFFFF"])
def test_an_escape_beyond_unicode_is_refused(escape: str) -> None:
    (diagnostic,) = parse(f'a: "{escape}"\n', "a.yaml").diagnostics
    assert (diagnostic.code, diagnostic.message) == ("SD004", "the escape sequence is not part of YAML")


def test_misspelt_alias_has_a_suggestion() -> None:
    (diagnostic,) = parse("a: &plank 1\nb: *plnk\n", "a.yaml").diagnostics
    assert diagnostic.hint == "did you mean 'plank'?"


# --- several mistakes -------------------------------------------------------------------------------------------------

MANY = "a: no\nb: [1, 0x1F]\na: 2\n1: x\n---\nok: 1\n---\nc: ~\nd: !t 1\ne: b: c\n---\nf: no\n"


def test_joiners_stand_where_a_script_or_an_emoji_needs_them() -> None:
    text = "می\u200cشود ⚠\ufe0f 👩\u200d🔬"
    (source,) = parse(f"a: {text}  # {text}\n", "a.yaml").sources
    assert source.values["a"] == text


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


def test_a_file_of_too_many_values_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    most = 1000  # a hundred times as many take a parser written in Python seconds, and are told alike
    monkeypatch.setattr("stackdsl.language.yaml.parsing.MAX_VALUES", most)
    assert mistakes("a: [" + "0," * (most - 2) + "]\n") == []
    (mistake,) = mistakes("a: [" + "0," * most + "]\n")
    assert mistake == f"SD006 1:{5 + 2 * (most - 2)}"  # the mapping and the list are values too


@pytest.mark.parametrize("line", ["a: 1\n", "---\n", "\0\n"], ids=["duplicates", "documents", "characters"])
def test_the_number_of_mistakes_is_bounded(line: str) -> None:
    assert len(mistakes(line * 50_000)) == MAX_MISTAKES


def test_a_misspelt_alias_among_many_long_anchors_is_found_at_once() -> None:
    anchors = "".join(f"- &{'a' * 5000}{i} 1\n" for i in range(100))
    assert len(mistakes(f"a:\n{anchors}" + "- *b\n" * 100)) == 100
