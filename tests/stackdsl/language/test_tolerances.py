"""Reading of tolerances."""

from dataclasses import FrozenInstanceError, replace
from math import inf, nan

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from stackdsl.language.quantities import COUNT, DURATION, EXTENT, LENGTH, LEVEL, SHARE, Dimension, InputError
from stackdsl.language.tolerances import Tolerance, parse_lower_bound, parse_tolerance


def mistake(written: object, dimension: Dimension) -> InputError:
    with pytest.raises(InputError) as caught:
        parse_tolerance(written, dimension)
    return caught.value


@pytest.mark.parametrize(
    ("written", "dimension", "low", "high"),
    [
        ("9 ± 1", COUNT, 8, 10),
        ("9 +- 1", COUNT, 8, 10),
        ("9 +/- 1", COUNT, 8, 10),
        ("9±1", COUNT, 8, 10),
        (12, COUNT, 12, 12),
        ("12", COUNT, 12, 12),
        (">= 20", COUNT, 20, inf),
        ("≥ 20", COUNT, 20, inf),
        ("<= 2", COUNT, -inf, 2),
        ("5 .. 7", COUNT, 5, 7),
        ("5..7", COUNT, 5, 7),
        ("level 9 ± 1", LEVEL, 8, 10),
        ("level  9", LEVEL, 9, 9),
        ("level >= 9", LEVEL, 9, inf),
        ("5 s .. 7 s", DURATION, 5.0, 7.0),
        ("5 .. 7 s", DURATION, 5.0, 7.0),
        ("500 ms .. 1 s", DURATION, 0.5, 1.0),
        ("200 mm ± 1 mm", EXTENT, 0.199, 0.201),
        ("200 ± 1 mm", EXTENT, 0.199, 0.201),
        ("20 cm ± 1 mm", EXTENT, 0.199, 0.201),
        ("50 % ± 2 %", SHARE, 0.48, 0.52),
        ("0.25 ± 0.02", SHARE, 0.23, 0.27),
        ("0.25 ± 2 %", SHARE, 0.23, 0.27),
        (">= 100 %", SHARE, 1.0, inf),
        ("<= 0 mm", EXTENT, -inf, 0.0),
    ],
)
def test_tolerances_are_read(written: object, dimension: Dimension, low: float, high: float) -> None:
    tolerance = parse_tolerance(written, dimension)
    assert tolerance == Tolerance(low, high, low_open=False, high_open=False, text=str(written))


@pytest.mark.parametrize(
    ("written", "low", "high", "low_open", "high_open"),
    [("> 5 mm", 0.005, inf, True, False), ("< 5 mm", -inf, 0.005, False, True)],
)
def test_strict_bound_excludes_itself(written: str, low: float, high: float, low_open: bool, high_open: bool) -> None:
    tolerance = parse_tolerance(written, EXTENT)
    assert tolerance == Tolerance(low, high, low_open, high_open, written)
    assert not tolerance.holds(0.005)
    assert tolerance.margin(0.005) == 0.0


@pytest.mark.parametrize(
    ("written", "dimension", "code"),
    [
        ("12 mm", EXTENT, "SD107"),  # exact
        ("12 mm .. 12 mm", EXTENT, "SD107"),
        ("12 mm ± 0 mm", EXTENT, "SD107"),
        ("0.5", SHARE, "SD107"),
        ("7 s .. 5 s", DURATION, "SD107"),  # reversed
        ("9 ± -1", COUNT, "SD107"),
        ("> 5 .. 7", COUNT, "SD107"),
        (">= 5 ± 1", COUNT, "SD107"),
        ("5 .. 7 .. 9", COUNT, "SD107"),
        ("about 9", COUNT, "SD107"),
        ("", COUNT, "SD107"),
        ("12.5", COUNT, "SD107"),  # nothing can hold
        ("0.2 .. 0.8", COUNT, "SD107"),
        ("< 0", COUNT, "SD107"),
        ("level < 1", LEVEL, "SD107"),
        ("< 0 mm", EXTENT, "SD107"),
        ("> 1", SHARE, "SD107"),
        ("50 ± 2 %", SHARE, "SD107"),
        ("5 ± 1", DURATION, "SD105"),
        ("> 5", DURATION, "SD105"),
        ("200 mm ± 1", EXTENT, "SD105"),
        ("9 ± 1", LEVEL, "SD105"),
        (9, LEVEL, "SD105"),
        (5, DURATION, "SD105"),
        ("5 mm .. 7 mm", DURATION, "SD106"),
        ("200 mm ± 2 %", EXTENT, "SD107"),
        ("9 ± 1 mm", COUNT, "SD106"),
        (True, COUNT, "SD103"),
        (None, COUNT, "SD103"),
    ],
)
def test_ambiguous_tolerance_is_rejected(written: object, dimension: Dimension, code: str) -> None:
    assert mistake(written, dimension).code == code


@pytest.mark.parametrize(
    ("written", "dimension"),
    [
        ("1e400 mm", EXTENT),
        (">= 1e400 mm", EXTENT),
        ("< 1e400 mm", EXTENT),
        ("0 mm .. 1e400 mm", EXTENT),
        ("1 mm ± 1e400 mm", EXTENT),
        ("1e308 m ± 1e308 m", EXTENT),  # each would do alone
        ("<= 1e400 %", SHARE),
        ("1 ± 1e400", SHARE),
    ],
)
def test_a_tolerance_beyond_all_doubles_is_out_of_range(written: str, dimension: Dimension) -> None:
    found = mistake(written, dimension)
    assert (found.code, found.message) == ("SD104", f"the tolerance '{written}' is out of range")
    assert found.hint.startswith("write a value between 0 and ")


@pytest.mark.parametrize("written", ["> 1e400 mm", "< 1e400 mm"])
def test_a_lower_bound_beyond_all_doubles_is_out_of_range(written: str) -> None:
    with pytest.raises(InputError, match="out of range"):
        parse_lower_bound(written, EXTENT)


@pytest.mark.parametrize(
    ("written", "fault"),
    [
        ("7 .. 5", "has its bounds in the wrong order"),
        ("9 ± -1", "has a negative width"),
        ("> 5 .. 7", "cannot be read at '5 .. 7'"),
        ("< 0", "cannot be met by a count"),
    ],
)
def test_malformed_tolerance_reports_the_cause(written: str, fault: str) -> None:
    assert fault in mistake(written, COUNT).message


def test_single_value_of_a_quantity_is_rejected() -> None:
    found = mistake("12 mm", EXTENT)
    assert "a measurement never equals exactly" in found.message
    assert "±" in found.hint


@pytest.mark.parametrize("written", ["< 5 mm", "5 mm ± 1 mm", "1 mm .. 2 mm"])
def test_a_lower_bound_has_no_upper_end(written: str) -> None:
    with pytest.raises(InputError, match="not a lower bound"):
        parse_lower_bound(written, EXTENT)
    assert parse_lower_bound("> 5 mm", EXTENT).low == 0.005


@pytest.mark.parametrize(
    ("written", "hint"),
    [
        ("5 mm", 'write "> 5 mm"'),
        ("< 2 cm", 'write "> 20 mm"'),
        ("5 mm ± 1 mm", 'write "> 4 mm"'),
        ("-5 mm", 'write "> 0 mm"'),
    ],
)
def test_upper_bound_in_place_of_a_lower_bound_has_a_remedy(written: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_lower_bound(written, EXTENT)
    assert caught.value.hint == hint


@pytest.mark.parametrize(
    ("written", "dimension", "hint"),
    [
        ("< 0 mm", EXTENT, "write a value between 0 and 10000 m"),
        ("> 1", SHARE, "write a value between 0 and 1"),
        ("level < 1", LEVEL, "write whole numbers; the minimum is 1"),
        ("12.5", COUNT, "write whole numbers; the minimum is 0"),
    ],
)
def test_tolerance_that_never_holds_reports_the_range(written: str, dimension: Dimension, hint: str) -> None:
    assert mistake(written, dimension).hint == hint


bounds = st.floats(-1e6, 1e6)
tolerances = st.one_of(
    st.tuples(bounds, bounds).map(lambda pair: Tolerance(min(pair), max(pair), False, False, "")),
    st.builds(lambda low, is_open: Tolerance(low, inf, is_open, False, ""), bounds, st.booleans()),
    st.builds(lambda high, is_open: Tolerance(-inf, high, False, is_open, ""), bounds, st.booleans()),
)


@given(tolerances, bounds)
@example(Tolerance(12.0, 12.0, False, False, "12"), 12.0)
@example(Tolerance(12.0, 12.0, False, False, "12"), 12.000000000000002)
@example(Tolerance(5.0, inf, True, False, "> 5"), 5.0)
def test_sign_of_the_margin_agrees_with_holds(tolerance: Tolerance, value: float) -> None:
    margin = tolerance.margin(value)
    at_an_open_bound = margin == 0 and (tolerance.low_open or tolerance.high_open)
    assert tolerance.holds(value) is (margin >= 0 and not at_an_open_bound)


@given(tolerances, bounds)
def test_the_margin_is_the_distance_to_the_nearest_bound(tolerance: Tolerance, value: float) -> None:
    nearest = min(abs(value - bound) for bound in (tolerance.low, tolerance.high))
    assert abs(tolerance.margin(value)) == nearest


def test_an_exact_count_has_margin_zero_or_less() -> None:
    twelve = parse_tolerance("12", COUNT)
    assert [twelve.margin(value) for value in (11, 12, 14)] == [-1.0, 0.0, -2.0]


def test_no_tolerance_accepts_nan() -> None:
    assert not parse_tolerance(">= 20", COUNT).holds(nan)


def test_tolerances_are_immutable() -> None:
    with pytest.raises(FrozenInstanceError):
        parse_tolerance("12", COUNT).low = 0.0  # type: ignore[misc]  # what must not work


@pytest.mark.parametrize(
    ("text", "least", "most", "same"),
    [
        ("2 .. 4", 2.0, 4.0, True),
        ("2 .. 4", 3.0, 5.0, False),
        ("2 .. 4", 5.0, 9.0, True),
        ("2 .. 4", 0.0, 1.0, True),
        ("2 .. 4", 0.0, 9.0, False),  # neither end holds, and what is between does
        (">= 2", 2.0, inf, True),
        ("> 2", 2.0, inf, False),
        ("< 2", 2.0, 3.0, True),
        ("<= 2", 2.0, 3.0, False),
    ],
)
def test_same_for_compares_all_values_of_an_interval(text: str, least: float, most: float, same: bool) -> None:
    assert parse_tolerance(text, COUNT).same_for(least, most) is same


def test_least_value_of_a_dimension_may_be_exact() -> None:
    nothing = parse_tolerance("0 mm", EXTENT)
    assert nothing.holds(0.0)
    assert not nothing.holds(1e-12)
    assert parse_tolerance(0, EXTENT) == replace(nothing, text="0")
    assert mistake("0 mm", LENGTH).code == "SD107"  # which may be less


@pytest.mark.parametrize("written", ["12 mm", "12mm", "12 .. 12 mm", "12 mm ± 0 mm"])
def test_the_remedy_for_a_tolerance_without_width_has_the_unit_of_its_value(written: str) -> None:
    assert mistake(written, EXTENT).hint.startswith("add a width, such as ± 0.1 mm")
