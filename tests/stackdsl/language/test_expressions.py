"""Expressions: arithmetic with units."""

from contextlib import suppress
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stackdsl.language.expressions import evaluate, interpolate
from stackdsl.language.quantities import ANGLE, LENGTH, MASS, Dimension, InputError, parse_quantity, unit_amount

NAMES = {
    "n": unit_amount("") * 3,
    "length": unit_amount("mm") * Fraction("117.6"),
    "step": unit_amount("mm") * 11,
    "slope": unit_amount("deg") * 30,
}
patient = settings(deadline=None)  # the first quantity imports pint


def refused(expression: str) -> InputError:
    with pytest.raises(InputError) as caught:
        evaluate(expression, NAMES)
    assert caught.value.code == "SD109"
    return caught.value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("${2 * 11 mm}", "22 mm"),
        ("${117.6 mm / 2}", "58.8 mm"),
        ("${length - 2 * step}", "95.6 mm"),
        ("${length / step}", 10.690909090909091),
        ("level ${floor(length / step) + 1}", "level 11"),
        ("${n + 1} .. ${2 * n}", "4 .. 6"),
        ("${step} ± ${step / 11}", "11 mm ± 1 mm"),
        ("${n * n}", 9),
        ("${n / 2}", 1.5),
        ("${-n}", -3),
        ("${-2 ** 2}", -4),
        ("${2 ** 3 ** 2}", 512),
        ("${(1 + 2) * 3}", 9),
        ("${10 mm*n}", "30 mm"),
        ("${1 mm*min(2, n)}", "2 mm"),
        ("${3 min}", "180 s"),
        ("${10 m / 2 m/s}", "5 s"),
        ("${557 kg/m³ * 2}", "1114 kg/m3"),
        ("${9.81 m/s^2 / 6}", "1.635 m/s2"),
        ("${50 % * n}", 1.5),
        ("${max(step, 1 cm)}", "11 mm"),
        ("${abs(step - length)}", "106.6 mm"),
        ("${sqrt(4 m2)}", "2 m"),
        ("${cos(90 deg)}", 0),
        ("${2 * pi}", 6.283185307179586),
        ("${ceil(2.1)} ${floor(-2.1)} ${round(2.4)}", "3 -3 2"),
        ("${slope}", "30 deg"),
        ("${-11.9 g * 2}", "-0.0238 kg"),
        ("${2 * length * 10}", "2.352 m"),
        ("${length / 11}", "10.69090909090909090909 mm"),
        ("${1e-30 m * 1}", "1e-30 m"),
        ("${1e30 m * 1}", "1e+30 m"),
        ("plain", "plain"),
    ],
)
def test_expressions_are_evaluated(text: str, value: object) -> None:
    result = interpolate(text, NAMES)
    assert result == value
    assert type(result) is type(value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("${floor(0.3 m / 0.1 m)}", 3),  # 2.9999999999999996 in floats
        ("${floor(2 * sin(30 deg))}", 1),  # 0.9999999999999999
        ("${floor(sqrt(2) ** 2 * 1000)}", 2000),
        ("${0.1 + 0.2}", 0.3),
        ("${round(2.5)}", 3),
        ("${tan(45 deg)}", 1),
    ],
)
def test_arithmetic_is_exact(text: str, value: object) -> None:
    assert interpolate(text, NAMES) == pytest.approx(value, abs=0, rel=1e-14 if "sqrt" in text else 0)


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("step + 1", "cannot add a length and a number"),
        ("step - 1 s", "cannot subtract a length and a duration"),
        ("slope + 1", "cannot add an angle and a number"),
        ("floor(step)", "the argument of floor must be a number, not a length"),
        ("sin(0.5)", "sin takes an angle, not a number"),
        ("sqrt(-1)", "the argument of sqrt is negative"),
        ("min(1, 1 mm)", "all arguments of min must have the same kind of unit"),
        ("min()", "all arguments of min must have the same kind of unit"),
        ("floor(1, 2)", "floor takes one argument, not 2"),
        ("2 ** (1 mm)", "an exponent must be a number, not a length"),
        ("1 / 0", "division by zero"),
        ("0 ** -1", "division by zero"),
        ("tan(90 deg)", "the tangent of 90 deg is undefined"),
        ("2 ** 0.5", "an exponent must be an integer from -64 to 64"),
        ("2 ** 65", "an exponent must be an integer from -64 to 64"),
        ("9 ** 9 ** 9", "an exponent must be an integer from -64 to 64"),
        ("(9 ** 64) ** 64", "a number becomes too large, or has too many digits"),
        ("1e999", "a number becomes too large, or has too many digits"),
        ("11 mm ** 2", "'11 mm **' is ambiguous"),
        ("2 mmm", "'mmm' is not a unit"),
        ("stepp", "unknown variable 'stepp'"),
        ("flor(2)", "unknown function 'flor'"),
        ("n" + " + n" * 60, "the expression is longer than 160 characters"),
    ],
)
def test_failing_expression_reports_the_cause(expression: str, message: str) -> None:
    assert refused(expression).message == message


def test_misspelt_variable_has_a_suggestion() -> None:
    assert refused("stepp").hint == "did you mean 'step'?"
    assert refused("flor(2)").hint == "did you mean 'floor'?"
    assert refused("2 mmm").hint == "did you mean 'mm'?"


@pytest.mark.parametrize("name", ["from", "in", "if", "lambda", "None", "True", "and", "is", "for", "print", "n_"])
def test_reserved_words_of_python_are_valid_variables(name: str) -> None:
    assert interpolate(f"${{2 * {name} + max({name}, 1)}}", {name: unit_amount("") * 3}) == 9


@pytest.mark.parametrize(
    ("expression", "message", "hint"),
    [
        ("n ^ 2", "'^ 2'", "**"),
        ("n % 2", "'% 2'", "floor"),
        ("n == 2", "'== 2'", "no comparisons"),
        ("'n'", "'n'", "cannot contain quoted text"),
        (" ", "is empty", "2 * (n + 1)"),
        ("n if n else n", "'n if n else n'", "use numbers"),
        ("n and n", "'n and n'", "use numbers"),
        ("_n", "'_n'", "begin the name of a variable with a letter"),
        ("1 / 0", "division by zero", "is never 0"),
    ],
)
def test_unreadable_expression_has_a_remedy(expression: str, message: str, hint: str) -> None:
    mistake = refused(expression)
    assert message in mistake.message
    assert hint in mistake.hint


@pytest.mark.parametrize(
    "expression",
    ["", "1 +", "(1", "1)", "1 2", "n n", "2 n", "1, 2", "n.real", "n[0]", "[n]", "{n}", "'n'", "n if n else n",
     "n = 3", "lambda", "True", "not n", "n < 3", "n // 2", "n % 2", "n and n", "min(*n)", "min(n, key=n)", "(n)(n)",
     "min", "__import__('os')", "_0", "0x10", "1_000", "1j", "é", "1 ; 2", "n @ n", "~n", "*n", "**n"],
)  # fmt: skip
def test_only_arithmetic_is_evaluated(expression: str) -> None:
    refused(expression)


@pytest.mark.parametrize("expression", ["(" * 79 + "1" + ")" * 79, "-" * 150 + "1", "+".join("1" * 80)])
def test_longest_expression_may_be_nested_to_any_depth(expression: str) -> None:
    evaluate(expression, NAMES)


@given(st.text(max_size=160))
@patient
def test_any_text_is_evaluated_or_rejected(expression: str) -> None:
    with suppress(InputError):
        evaluate(expression, NAMES)


trees = st.recursive(
    st.integers(0, 50).map(str),
    lambda inner: st.tuples(inner, st.sampled_from(["+", "-", "*"]), inner).map(lambda parts: f"({' '.join(parts)})"),
    max_leaves=12,
)


@given(trees)
@patient
def test_integer_arithmetic_agrees_with_python(expression: str) -> None:
    assert interpolate(f"${{{expression}}}", {}) == eval(expression)


@given(
    st.decimals(-1000, 1000, places=4, allow_nan=False),
    st.integers(1, 99),
    st.sampled_from([(LENGTH, "mm"), (LENGTH, "m"), (MASS, "g"), (ANGLE, "deg")]),
)
@patient
def test_a_quantity_survives_being_written_out(number: Decimal, divisor: int, kind: tuple[Dimension, str]) -> None:
    dimension, unit = kind
    exact = abs(Fraction(number)) * unit_amount(unit).magnitude / divisor
    text = interpolate(f"${{({abs(number):f} {unit}) / {divisor}}}", {})
    assert number == 0 or parse_quantity(text, dimension) == float(exact)


@pytest.mark.parametrize("text", ["${", "a ${n", "${a ${n}}", "${n} ${"])
def test_unclosed_expression_is_rejected(text: str) -> None:
    with pytest.raises(InputError, match="is not closed"):
        interpolate(text, NAMES)
