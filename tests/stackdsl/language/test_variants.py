"""Variants of a scenario by `let:` and `matrix:`."""

from itertools import product

import pytest

from stackdsl.diagnostics import Diagnostic
from stackdsl.language.repeats import MAX_VARIANTS
from stackdsl.language.variants import Variant, expand, repeated
from stackdsl.language.yaml.source import Source, parse


def source(text: str) -> Source:
    loaded = parse(text, "a.yaml")
    assert loaded.diagnostics == ()
    return loaded.sources[0]


def expanded(text: str) -> tuple[Variant, ...]:
    variants, diagnostics = expand(source(text))
    assert diagnostics == ()
    return variants


def mistakes(text: str) -> list[str]:
    """Each mistake as `code marked text: message`."""
    return [f"{each.code} {marked(each)}: {each.message}" for each in expand(source(text))[1]]


def marked(diagnostic: Diagnostic) -> str:
    span = diagnostic.span
    return span.excerpt[span.column - 1 : span.end_column - 1]


def test_a_scenario_without_variables_is_its_own_only_variant() -> None:
    text = "{scenario: a, build: [{column: {levels: 3}}]}"
    assert expanded(text) == (Variant((), source(text).values, source(text), source(text), {}),)


def test_a_matrix_gives_each_combination_in_the_order_of_the_author() -> None:
    variants = expanded('{matrix: {step: [12 mm, 10 mm], n: [2, 1]}, build: ["${n * step}"]}')
    assert [variant.parameters for variant in variants] == [
        (("step", step), ("n", n)) for step, n in product(["12 mm", "10 mm"], ["2", "1"])
    ]
    assert [variant.values["build"] for variant in variants] == [["24 mm"], ["12 mm"], ["20 mm"], ["10 mm"]]


def test_let_may_use_the_matrix_and_the_lines_above() -> None:
    (variant,) = expanded("""
        {matrix: {step: [12 mm]}, let: {half: "${step / 2}", share: 25 %, n: "${step / half}"}, a: ["${n}", "${share}"]}
        """)
    assert variant.values["a"] == [2, 0.25]
    assert variant.values["let"] == {"half": "6 mm", "share": "25 %", "n": 2}


def test_the_source_is_left_as_it_was() -> None:
    text = '{let: {n: 2}, a: ["${n}", {b: "${n}"}]}'
    given_source = source(text)
    expand(given_source)
    assert given_source.values == source(text).values


def test_values_are_rounded_in_reports_only() -> None:
    text = """{let: {x: 117.6 mm}, a: {share: "${0.5 - 5/14} ± 0.02", plain: 0.123456789 ± 1, n: "${1/3}",
        whole: "${7}", list: ["${x / 11} .. ${x/7}", "L3.${1}.1234567", "${x / 11}..${x / 9}"]}}"""
    (variant,) = expanded(text)
    used = variant.values["a"]
    assert isinstance(used, dict)
    assert (used["share"], used["n"]) == ("0.14285714285714285 ± 0.02", 1 / 3)
    assert repeated(source(text).values["a"], used) == {
        "share": "0.142857 ± 0.02",
        "plain": "0.123456789 ± 1",
        "n": 0.333333,
        "whole": 7,
        "list": ["10.6909 mm .. 16.8 mm", "L3.1.1234567", "10.6909 mm..13.0667 mm"],
    }


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("matrix: 5", ["SD103 5: expected a mapping of variables to values"]),
        ("let: []", ["SD103 []: expected a mapping of variables to values"]),
        ("matrix: {n: 5}", ["SD103 5: expected a list of values or a range, not 5"]),
        ("matrix: {n: []}", ["SD103 []: expected a list of values or a range, not an empty list"]),
        ("matrix: {n: [1, 1 one]}", ["SD109 1 one: '1 one' is neither a number nor a quantity"]),
        ("matrix: {n: [1, true]}", ["SD109 true: true is neither a number nor a quantity"]),
        ("matrix: {n: [1, 2, 1]}", ["SD104 1: the list contains 1 twice"]),
        ("matrix: {n: [1, 1.0]}", ["SD104 1.0: the list contains 1.0 twice"]),
        ("matrix: {n: [10 mm, '10mm']}", ["SD104 '10mm': the list contains '10mm' twice"]),  # they name one case
        ("matrix: {n: [1, '1']}", ["SD104 '1': the list contains '1' twice"]),
        ("matrix: {mm: [1]}", ["SD109 mm: 'mm' is a unit in expressions, and cannot be the name of a variable"]),
        ("let: {pi: 3}", ["SD109 pi: 'pi' is a constant in expressions, and cannot be the name of a variable"]),
        ("let: {min: 3}", ["SD109 min: 'min' is a unit in expressions, and cannot be the name of a variable"]),
        ("let: {a-b: 3}", ["SD109 a-b: 'a-b' is not a valid name of a variable"]),
        ("let: {sqrt: 3}", ["SD109 sqrt: 'sqrt' is a function in expressions, and cannot be the name of a variable"]),
        ("let: {a: 2 * 3}", ["SD109 2 * 3: '2 * 3' is neither a number nor a quantity"]),
        ("let: {a: 3 miles}", ["SD109 3 miles: '3 miles' is neither a number nor a quantity"]),
        ("let: {a: '${b}', b: 1}", ["SD109 '${b}': unknown variable 'b'"]),
        ("let: {a: '${a}'}", ["SD109 '${a}': unknown variable 'a'"]),
        ("{matrix: {a: [1]}, let: {a: 2}}", ["SD109 a: 'a' is already a variable of the matrix"]),
        ("let: {a: mm}", ["SD109 mm: 'mm' is a reserved word of expressions"]),
        ("{let: {a: 1, b: a}, c: '${b}'}", ["SD109 a: 'a' is the name of a variable, not a value"]),
        ("{matrix: {n: ['${2}', 3]}}", ["SD109 '${2}': '${2}' is neither a number nor a quantity"]),
        ("{matrix: {n: [10 mm, 1 cm]}, c: '${n}'}", ["SD104 1 cm: the list contains '1 cm' twice"]),
        ("{let: {a: kapla}, c: '${a + 1}'}", ["SD109 '${a + 1}': the value of 'a' is the word 'kapla', not a number"]),
        (
            "{matrix: {n: [1, 2]}, let: {a: 1}}",
            ["SD112 n: the variable 'n' is unused", "SD112 a: the variable 'a' is unused"],
        ),
        ("scenario: tower-${1}", ["SD109 tower-${1}: the name of a scenario cannot contain expressions"]),
        ("build: [{a: '${1 / 0}'}]", ["SD109 '${1 / 0}': division by zero"]),
    ],
)
def test_mistakes_are_shown_where_they_are(text: str, expected: list[str]) -> None:
    assert mistakes(text) == expected


def test_mistakes_are_reported_in_the_order_of_the_text() -> None:
    text = "{a: ['${b}', '${c}', '${d}', '${e}'], let: {f: 1 x}, matrix: {k: [1 v, 1 w]}}"
    places = [each.span.column for each in expand(source(text))[1]]
    assert len(places) == 7
    assert places == sorted(places)


def test_consequences_of_a_mistake_are_not_reported() -> None:
    text = "{let: {a: 1 x, b: '${2 * a}'}, c: '${b + 1}', d: '${a}'}"
    assert mistakes(text) == ["SD109 1 x: '1 x' is neither a number nor a quantity"]
    assert expand(source(text))[0][0].values["c"] == "${b + 1}"


def test_mistake_in_several_variants_is_reported_once() -> None:
    text = "{matrix: {n: [1, 2, 3]}, a: '${1 m + n}', b: '${1 / (n - 2)}'}"
    assert mistakes(text) == [
        "SD109 '${1 m + n}': cannot add a length and a number",
        "SD109 '${1 / (n - 2)}': division by zero",
    ]


def test_variants_are_limited() -> None:
    row = ", ".join(str(number) for number in range(16))
    full = f"{{matrix: {{a: [{row}], b: [{row}]}}, c: '${{a + b}}'}}"
    assert len(expanded(full)) == MAX_VARIANTS
    variants, (diagnostic,) = expand(source(f"{{matrix: {{a: [{row}], b: [{row}], d: [1, 2]}}, c: '${{a}}'}}"))
    assert diagnostic.code == "SD206"
    assert "maximum of 256 combinations" in diagnostic.message
    assert len(variants) == 1  # so that the rest can still be validated


def test_a_number_of_combinations_with_thousands_of_digits_is_one_mistake() -> None:
    rows = ", ".join(f"r{number}: [1, 2]" for number in range(15_000))  # 2 to this power has 4516 digits
    (diagnostic,) = expand(source(f"{{matrix: {{{rows}}}}}"))[1]
    assert (diagnostic.code, "more than 256" in diagnostic.message) == ("SD206", True)
