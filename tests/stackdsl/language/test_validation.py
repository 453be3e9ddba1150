"""Diagnostics of wrong scenarios: every mistake once, with place and remedy."""

import json
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path as FilePath
from typing import cast

import jsonschema
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stackdsl.diagnostics import CODES, Diagnostic, Span
from stackdsl.language.json_schema import json_schema, keys_at, schema_text
from stackdsl.language.quantities import LENGTH
from stackdsl.language.validation import validate
from stackdsl.language.variants import Variant, expand
from stackdsl.language.yaml.source import KeyPath, Plain, Source, parse
from tests.paths import ROOT
from tests.stackdsl.language.test_schema import EVERYTHING

HEAD = "scenario: a\n"
EDITOR = jsonschema.Draft202012Validator(json_schema())
PUBLISHED = jsonschema.Draft7Validator(json.loads(schema_text()))
BUILD = "build: [{column: {levels: 3}}]\n"


def source(text: str) -> Source:
    loaded = parse(text, "a.yaml")
    assert loaded.diagnostics == ()
    return loaded.sources[0]


def diagnosed(text: str) -> list[Diagnostic]:
    """Return all diagnostics of `expand` and `validate` for the first variant."""
    read = source(text)
    variants, diagnostics = expand(read)
    scenario, more = validate(read, variants[0])
    assert (scenario is None) is bool(diagnostics or more)
    return [*diagnostics, *more]


def marked(diagnostic: Diagnostic) -> str:
    span = diagnostic.span
    start = span.column - span.excerpt_column
    return span.excerpt[start : start + span.end_column - span.column]


def told(text: str) -> list[tuple[str, str, str]]:
    """Code, marked text and message of each mistake."""
    return [(each.code, marked(each), each.message) for each in diagnosed(text)]


@pytest.mark.parametrize(
    ("text", "code", "mark", "message", "hint"),
    [
        (HEAD + BUILD + "tag: [b]", "SD101", "tag", "unknown key 'tag'", "did you mean 'tags'?"),
        (HEAD + BUILD + "world: {acceleration: 0.5 g}", "SD101", "acceleration", "unknown", "acceleration: 0.5 g, fre"),
        (HEAD + BUILD + "braking: 0.5 g", "SD101", "braking", "unknown key", '`margin: {acceleration: ">= 0.5 g"}`'),
        (HEAD + BUILD + "expect: [{margin: 0.5 g}]", "SD103", "0.5 g", "a mapping", '{acceleration: ">= 0.5 g"}'),
        (HEAD + BUILD + "world: {shake: 0.5 g}", "SD103", "0.5 g", "a mapping", "0.5 g, frequency: 2 Hz, for: 2 s}"),
        (HEAD + BUILD + "world: {gravitiy: 1 g0}", "SD101", "gravitiy", "unknown key", "did you mean 'gravity'?"),
        (HEAD + "build: [{colum: {levels: 3}}]", "SD101", "colum", "unknown key", "did you mean 'column'?"),
        (HEAD + "build: [{column: {levels: 1, pitch: 3}}]", "SD101", "pitch", "unknown key", "origin, heading"),
        (HEAD + BUILD + "expect: [{drift: {is: < 1 mm, most: 1}}]", "SD101", "most", "unknown key", "is, bricks"),
        (HEAD, "SD102", "scenario", "missing key 'build'", "steps of building, in order"),
        (HEAD + "build: [{column: {step: 1 mm}}]", "SD102", "{step: 1 mm}", "missing key 'levels'", "number of planks"),
        (HEAD + BUILD + "expect: [{stands: {}}]", "SD102", "{}", "the mapping is empty", "write all, or add one"),
        (HEAD + BUILD + "tags: x", "SD103", "x", "expected a list, not 'x'", ""),
        (HEAD + BUILD + "friction: high", "SD103", "high", "expected a number, not 'high'", "Coulomb"),
        (HEAD + BUILD + "friction: true", "SD103", "true", "expected a number, not true", ""),
        (HEAD + "build: [{column: {levels: 2.5}}]", "SD103", "2.5", "expected a whole number, not 2.5", "planks"),
        (HEAD + "build: [{column: {levels: '3'}}]", "SD103", "'3'", "expected a whole number, not '3'", ""),
        (HEAD + "build: [{column: 3}]", "SD103", "3", "expected a mapping, not 3", "levels"),
        (HEAD + "build: [3]", "SD103", "3", "expected a mapping, not 3", "four_stack"),
        (HEAD + "build: [{bricks: [{at: [1 mm, 2 mm]}]}]", "SD103", "[1 mm, 2 mm]", "z is missing", "[x, y, z]"),
        (HEAD + BUILD + "expect: [{rests_on: {brick: 3, support: a}}]", "SD103", "3", "the name of a brick", "letter"),
        (HEAD + BUILD + "expect: [{drift: [1]}]", "SD103", "[1]", "not a list", "is (the largest shift)"),
        (HEAD + BUILD + "friction: -1", "SD104", "-1", "-1 is below the minimum of 0", ""),
        (HEAD + BUILD + "friction: 11", "SD104", "11", "11 exceeds the maximum of 10", ""),
        (HEAD + "build: [{column: {levels: 10001}}]", "SD104", "10001", "10001 exceeds the maximum of 10000", ""),
        (HEAD + "build: []", "SD104", "[]", "the list has 0 items; the minimum is 1", ""),
        (HEAD + "build: [{bricks: [{at: [1 mm, 1 mm, 1 mm, 1 mm]}]}]", "SD104", "[1 mm", "the maximum is 3", ""),
        (HEAD + BUILD + "systems: [stok]", "SD104", "stok", "not a permitted value", "did you mean 'stock'?"),
        (HEAD + BUILD + "systems: [stock, stock]", "SD104", "[stock, stock]", "a system twice", "once"),
        (HEAD + BUILD + "brick: kaplaa", "SD104", "kaplaa", "no brick 'kaplaa'", "did you mean 'kapla'?"),
        (HEAD + BUILD + "brick_types: {slab: kaplaa}\nbrick: slab", "SD104", "kaplaa", "no brick 'kaplaa'", "'kapla'?"),
        (HEAD + BUILD + "brick_types: {slab: kapla}\nbrick: slabb", "SD104", "slabb", "no brick 'slabb'", "'slab'?"),
        (HEAD + BUILD + "brick_types: {kapla: kapla}", "SD104", "kapla", "a brick in the catalogue", "another name"),
        (HEAD + BUILD + "brick_types: {1x: kapla}", "SD104", "1x", "not a valid name of a kind", "begin with a letter"),
        (
            HEAD + BUILD + "brick_types: {slab: {size: [1 m, 1 m, 1 m], mas: 1 kg}}\nbrick: slab",
            *("SD101", "mas", "unknown key 'mas'", "did you mean 'mass'?"),
        ),
        (HEAD + BUILD + "description: ''", "SD104", "''", "the text is empty", ""),
        (BUILD + "scenario: A b", "SD104", "A b", "'A b' is not a valid name", "lower-case letters"),
        (HEAD + BUILD + "expect: [{stands: al}]", "SD104", "al", "expected 'all' or a mapping", "write all"),
        (HEAD + BUILD + "world: {tilt: 95 deg}", "SD104", "95 deg", "out of range", "between 0 and 90 deg"),
        (HEAD + BUILD + "world: {gravity: 0 m/s2}", "SD104", "0 m/s2", "not greater than zero", "greater than zero"),
        (HEAD + "build: [{column: {levels: 1}, every: -1 s}]", "SD104", "-1 s", "not greater", "greater than zero"),
        (HEAD + BUILD + "brick: {size: [-1 cm, 1 cm, 1 cm], mass: 1 g}", "SD104", "-1 cm", "not", "greater than zero"),
        (HEAD + "build: [{harmonic: {bricks: 2, share: 3}}]", "SD104", "3", "out of range", "between 0 and 2"),
        (HEAD + BUILD + "expect: [{sway: {}}]", "SD102", "{}", "empty", "amplitude, frequency"),
        (HEAD + BUILD + "expect: [{sway: {frequency: <= 5}}]", "SD105", "<= 5", "unit", "Hz"),
        (HEAD + BUILD + "expect: [{penetration: <= 0.1}]", "SD105", "<= 0.1", "unit", "mm"),
        (HEAD + BUILD + "expect: [{displaced: {bricks: 1, by: 5 mm}}]", "SD107", "5 mm", "bound", 'write "> 5 mm"'),
        (
            HEAD + BUILD + "systems: [exact, tuned]\nexpect: [{verdict: stable}]",
            *("SD104", "verdict", "system 'tuned' does not have", "system: exact"),
        ),
        (
            HEAD + BUILD + "systems: [tuned]\ntruth: [{margin: {tilt: '> 1 deg'}, source: me}]",
            *("SD104", "margin", "is never compared", "add exact to `systems`"),
        ),
        (HEAD + BUILD + "expect: [{margin: {}}]", "SD102", "{}", "the mapping is empty", "acceleration, tilt"),
        (HEAD + BUILD + "expect: [{stands: all, system: stock}]", "SD104", "stock", "does not run on 'stock'", "exact"),
        (HEAD + "build: [{wall: {levels: 1, bricks: 1, gap: 1 m}}]", "SD104", "{levels", "shorter than a plank", "0.2"),
        (HEAD + BUILD + "world: {gravity: 9.81}", "SD105", "9.81", "expected an acceleration", "9.81 m/s2"),
        (HEAD + BUILD + "expect: [{drift: 5}]", "SD105", "5", "has no unit; expected a length", "<= 5 mm"),
        (HEAD + BUILD + "expect: [{collapses: {at: 9}}]", "SD105", "9", "does not begin with 'level'", "level 9 ± 1"),
        (HEAD + "build: [{column: {levels: 1}, every: 1 mm}]", "SD106", "1 mm", "not a unit of a duration", "ms, s"),
        (HEAD + BUILD + "expect: [{drift: 5 mm}]", "SD107", "5 mm", "a measurement never equals exactly", "±"),
        (HEAD + BUILD + "expect: [{displaced: {bricks: 1, by: < 5 mm}}]", "SD107", "< 5 mm", "not a lower bound", ">"),
        (HEAD + "build: [{name: a}]", "SD108", "{name: a}", "keys four_stack", "add one of them"),
        (HEAD + "build: [{column: {levels: 1}, harmonic: {bricks: 1}}]", "SD108", "{column", "column and harmonic", ""),
        (HEAD + "build: [{column: {levels: 1}, at: 1 s, after: built}]", "SD108", "{column", "exclude each other", ""),
        (HEAD + BUILD + "expect: [{system: thesis}]", "SD108", "{system: thesis}", "of the keys stands", ""),
        (HEAD + BUILD + "brick: {size: [1 mm, 1 mm, 1 mm]}", "SD108", "{size", "density, mass", "add one of them"),
        (HEAD + "build: [{column: {levels: '${n}'}}]", "SD109", "'${n}'", "unknown variable 'n'", "under `let`"),
        (HEAD + "build: [{column: {levels: 1}, after: 2 s}]", "SD110", "2 s", "'2 s' is not an event", "use `at`"),
        (HEAD + "build: [{wall: {levels: 9999, bricks: 99}}]", "SD206", "{levels", "999900 bricks", "several steps"),
        (HEAD + "build: [{column: {}, every: 1 s}]", "SD102", "{}", "missing key 'levels'", "number of planks"),
        (HEAD + "build: [{harmonic: {}, every: 1 s}]", "SD102", "{}", "missing key 'bricks'", "number of planks"),
        (HEAD + "build: [{wall: {}, every: 1 s, until: collapse}]", "SD102", "{}", "key 'bricks'", "half planks"),
        (HEAD + "build: [{column: {}, until: collapse}]", "SD102", "{column", "needs `every`", "every: 1 s"),
        (HEAD + "build: [{column: {}, every: 1 s, until: fall}]", "SD104", "fall", "not a permitted value", "collapse"),
        (HEAD + "build: [{bricks: [{at: [0 m, 0 m, 3.9 mm]}], every: 1 s, until: collapse}]",
         "SD108", "{bricks", "needs a layout", "replace the bricks by a layout"),
        (HEAD + "build: [{column: {}, every: 1 s, until: collapse}, {column: {levels: 1}}]",
         "SD104", "collapse", "must be the last step", "move it"),
        (HEAD + "build: [{column: {}, every: 1 s, until: collapse}]\nimpacts: [{at: 9 s, remove: {brick: L1.1}}]",
         "SD205", "impacts", "impacts cannot follow a step with `until: collapse`", "number of levels"),
        (HEAD + BUILD + "expect: [{stands: all}]\ntruth: [{stands: all, system: stock, source: x}]",
         "SD101", "system", "unknown key 'system'", ""),
    ],
)  # fmt: skip
def test_a_mistake_has_a_code_a_place_a_cause_and_a_remedy(
    text: str, code: str, mark: str, message: str, hint: str
) -> None:
    (only,) = diagnosed(text)
    assert only.code == code
    assert marked(only).startswith(mark)
    assert message in only.message
    assert hint in only.hint


def test_all_mistakes_are_reported_in_the_order_of_the_text() -> None:
    found = diagnosed("""
scenario: A b
systems: [stok, thesis]
build:
  - {four_stack: {levels: many, step: 11}, every: 1 mm}
  - {colum: {levels: 3}}
expect:
  - drift: 5 mm
  - {collapses: {at: 9}, system: tund}
""")
    assert [(each.code, each.span.line) for each in found] == [
        ("SD104", 2), ("SD104", 3), ("SD103", 5), ("SD105", 5), ("SD106", 5), ("SD101", 6), ("SD107", 8), ("SD105", 9),
        ("SD104", 9),
    ]  # fmt: skip


def test_list_with_invalid_items_is_not_reported_as_too_short() -> None:
    # Pydantic counts the items that are valid, and there are none.
    assert [code for code, *_ in told(HEAD + "build: [{bricks: [{at: 1 mm}]}]")] == ["SD103"]


def test_two_missing_items_are_reported_once() -> None:
    assert len(told(HEAD + "build: [{bricks: [{at: [1 mm]}]}]")) == 1


def test_value_with_a_mistaken_expression_is_reported_once() -> None:
    text = HEAD + 'build: [{column: {levels: "${1 / 0}", step: "${1 mm + 1}"}, name: "${x}", brick: "${x}"}]'
    assert {code for code, *_ in told(text)} == {"SD109"}
    assert len(told(text)) == 4


def test_the_value_of_an_expression_is_checked_where_it_is_written() -> None:
    text = HEAD + 'let: {n: 3}\nbuild: [{column: {levels: "${n / 2}", step: "${n * 2}"}}]'
    assert told(text) == [
        ("SD103", '"${n / 2}"', "the expression gives 1.5, not a whole number"),
        ("SD105", '"${n * 2}"', "the expression gives 6, without a unit; expected a length"),
    ]


def test_the_value_of_an_expression_is_shown_as_an_author_would_write_it() -> None:
    text = HEAD + 'let: {h: 3 mm}\nbuild: [{column: {levels: "${h}"}}]'
    assert told(text) == [("SD103", '"${h}"', "the expression gives '3 mm', not a whole number")]


def test_keys_are_known_along_a_path() -> None:
    assert keys_at(("world",)) == ("gravity", "ground", "walls", "tilt", "shake", "friction", "touching")
    assert keys_at(("world", "walls", 3)) == ("bearing", "distance", "friction")
    assert keys_at(("expect", 0, "stands")) == ("levels", "bricks", "for", "share")
    assert keys_at(("build", 0, "bricks", 0, "at", 1)) == ()
    assert keys_at(("nowhere", "at", "all")) == ()


@pytest.mark.parametrize(
    ("step", "right"),
    [
        ("{column: {}, every: 1 s, until: collapse}", True),
        ("{harmonic: {share: 1.1}, every: 1 s, until: collapse}", True),
        ("{card_house: {levels: 4, angle: 65 deg}, every: 1 s, until: collapse}", True),
        ("{column: {}, every: 1 s}", False),
        ("{harmonic: {share: 1.1}}", False),
    ],
)
def test_count_is_optional_with_until_collapse_only(step: str, right: bool) -> None:
    text = f"{HEAD}build: [{step}]"
    assert (diagnosed(text) == []) is right
    assert EDITOR.is_valid(source(text).values) is right


def test_the_example_of_all_keys_has_no_mistake() -> None:
    in_full = EVERYTHING.replace("    until: collapse\n", "").replace("structure: {", "structure: {levels: 9, ")
    assert diagnosed(in_full) == []
    (only,) = diagnosed(EVERYTHING)  # all but one: impacts do not go with a build until it falls
    assert (only.code, marked(only)) == ("SD205", "impacts")


# --- anything at all --------------------------------------------------------------------------------------------------


def places(values: Plain, path: KeyPath = ()) -> Iterator[KeyPath]:
    if path:
        yield path
    members = values.items() if isinstance(values, dict) else enumerate(values) if isinstance(values, list) else ()
    for key, member in members:
        yield from places(member, (*path, key))


def replaced(values: Plain, path: KeyPath, new: Plain) -> Plain:
    """A copy with another value at a path."""
    if not path:
        return new
    copy = deepcopy(values)
    inside = cast("dict[str | int, Plain]", copy)
    inside[path[0]] = replaced(inside[path[0]], path[1:], new)
    return copy


FIRST = source(EVERYTHING)
VALUES = expand(FIRST)[0][0].values
words = st.sampled_from(
    ["", "all", "any", "kapla", "thesis", "built", "level 9", "level 9 ± 1", "5 mm", "5 s", "5 deg", "9 ± 1", "< 5 mm",
     "> 5 mm ± 1", "50 %", "L1.1", "ground", "a", "A b", "1e999 mm", "5", "±", ".. 3"]
)  # fmt: skip
scalars: st.SearchStrategy[Plain] = st.one_of(
    st.none(), st.booleans(), st.integers(-5, 20_000), st.floats(), words, st.text(max_size=8)
)
keys = st.sampled_from(["levels", "bricks", "is", "at", "for", "angle", "size", "density", "column", "stands", "x"])
anything: st.SearchStrategy[Plain] = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(keys, inner, max_size=4), max_leaves=8
)


# What `let` and `matrix` hold is judged by `expand`.
PLACES = sorted((path for path in places(cast("Plain", VALUES)) if path[0] not in {"let", "matrix"}), key=str)


@given(st.sampled_from(PLACES), anything)
@settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.too_slow])
def test_mutated_scenario_is_accepted_or_diagnosed(path: KeyPath, new: Plain) -> None:
    values = cast("dict[str, Plain]", replaced(cast("Plain", VALUES), path, new))
    nowhere = Source("a.yaml", values, {(): Span("a.yaml", 1, 1, 2)}, {})
    scenario, diagnostics = validate(nowhere, Variant((), values, nowhere, nowhere, {}))
    echo = isinstance(new, str) and "${" in new
    assert (scenario is None) is bool(diagnostics) or echo
    for diagnostic in diagnostics:
        assert diagnostic.code in CODES
        assert diagnostic.message
    if scenario is not None:  # then editors do not complain either
        EDITOR.validate(values)


def test_json_schema_rejects_mistakes_too() -> None:
    """The schema is plain JSON, without infinities."""
    json.dumps(json_schema(), allow_nan=False)
    assert LENGTH.example in json.dumps(json_schema())


@pytest.mark.parametrize("file", sorted((ROOT / "scenarios").rglob("*.yaml")), ids=lambda file: file.stem)
def test_the_scenarios_of_this_project_are_accepted_by_editors(file: FilePath) -> None:
    for read in parse(file.read_text(encoding="utf-8"), file.name).sources:
        if isinstance(read.values, dict) and "extends" not in read.values:  # what it extends has the rest
            EDITOR.validate(read.values)
            PUBLISHED.validate(read.values)
