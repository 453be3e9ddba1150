"""Ambiguous values and unsupported features of YAML are rejected with a remedy."""

import pytest

from stackdsl.language.yaml.source import parse
from tests.stackdsl.language.yaml.sources import REMEDIES, each_parser, marked, mistakes, values

__all__ = ["each_parser"]  # used by every test here


# --- traps ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("text", "remedy"), REMEDIES, ids=lambda text: text[:30])
def test_scalars_that_yaml_versions_read_differently_are_refused_with_the_remedy(text: str, remedy: str) -> None:
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


@pytest.mark.parametrize(
    "key", ["1", "-3", "0.5", "1e3", "true", "True", "no", "On", "off", "null", "~", "1:30", "012", ".5"]
)
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
    assert (tight.code, str(tight.span), tight.hint) == ("SD009", "a.yaml:1:4", 'write ">5"')
    assert (loose.code, str(loose.span), loose.hint) == ("SD004", "a.yaml:1:4", 'write ">= 20"')


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
    assert diagnostic.message == "the YAML tag '!!str' is not supported"


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
