"""Quantities and tolerances, read as people write them."""

import re
import subprocess
import sys
from contextlib import suppress
from dataclasses import FrozenInstanceError
from fractions import Fraction
from math import inf, nan, pi

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter

from stackdsl.quantities import (
    ACCELERATION,
    ANGLE,
    COUNT,
    DENSITY,
    DURATION,
    EXTENT,
    LENGTH,
    LEVEL,
    MASS,
    SHARE,
    Dimension,
    LengthTolerance,
    MistakeError,
    Tolerance,
    parse_lower_bound,
    parse_quantity,
    parse_tolerance,
    quantity_pattern,
    unit_amount,
)

DIMENSIONS = [LENGTH, DURATION, ANGLE, DENSITY, MASS, ACCELERATION]
patient = settings(deadline=None)  # the first quantity imports pint


def mistake(written: object, dimension: Dimension) -> MistakeError:
    with pytest.raises(MistakeError) as caught:
        parse_quantity(written, dimension)
    return caught.value


def tolerance_mistake(written: object, dimension: Dimension) -> MistakeError:
    with pytest.raises(MistakeError) as caught:
        parse_tolerance(written, dimension)
    return caught.value


@pytest.mark.parametrize(
    ("written", "dimension", "si"),
    [
        ("13.5 mm", LENGTH, 0.0135),
        ("13.5mm", LENGTH, 0.0135),
        ("-2 cm", LENGTH, -0.02),
        (".5 m", LENGTH, 0.5),
        ("1e-3 km", LENGTH, 1.0),
        ("1.5 min", DURATION, 90.0),
        ("250 ms", DURATION, 0.25),
        ("180 deg", ANGLE, pi),
        ("180°", ANGLE, pi),
        ("1 rad", ANGLE, 1.0),
        ("11.9 g", MASS, 0.0119),
        ("1 g0", ACCELERATION, 9.80665),
        *((f"9.81 m/s{power}", ACCELERATION, 9.81) for power in ("2", "^2", "²")),
        *((f"557 kg/m{power}", DENSITY, 557.0) for power in ("3", "^3", "³")),
        ("0.557 g/cm3", DENSITY, 557.0),
        ("25 %", SHARE, 0.25),
        (0.25, SHARE, 0.25),
    ],
)
def test_a_quantity_is_read_into_si_to_the_last_bit(written: object, dimension: Dimension, si: float) -> None:
    assert parse_quantity(written, dimension) == si


@pytest.mark.parametrize("written", [13.5, 0, "13.5", "-1"])
def test_a_bare_number_is_told_which_unit_it_wants(written: object) -> None:
    found = mistake(written, LENGTH)
    assert found.code == "SD105"
    assert found.hint == "write a length with its unit, such as 13.5 mm"


@pytest.mark.parametrize(
    ("written", "hint"),
    [
        ("5 mmm", "did you mean 'mm'?"),
        ("5 s", "choose from: mm, cm, m, km"),
        ("5 MM", "choose from: mm, cm, m, km"),
        ("5 %", "choose from: mm, cm, m, km"),
    ],
)
def test_another_unit_is_told_the_right_ones(written: str, hint: str) -> None:
    found = mistake(written, LENGTH)
    assert (found.code, found.hint) == ("SD106", hint)


@pytest.mark.parametrize(
    "written",
    ["", "mm", "abc", "inf mm", "nan mm", "1,5 mm", "1 000 mm", "0x10 mm", "1e5000 mm", "9" * 5000 + " mm",
     "5 mm long", "5 kg / m3", True, None, [], {}, inf, nan],
)  # fmt: skip
def test_what_is_no_quantity_is_refused(written: object) -> None:
    assert mistake(written, LENGTH).code == "SD103"


@pytest.mark.parametrize(
    ("written", "dimension"),
    [("11 km", LENGTH), ("1e999 m", LENGTH), ("-1 s", DURATION), ("2 km", ANGLE), ("0 kg/m3", DENSITY), ("-1 g", MASS)],
)
def test_a_quantity_out_of_range_is_refused(written: str, dimension: Dimension) -> None:
    assert mistake(written, dimension).code == ("SD106" if dimension is ANGLE else "SD104")


@given(st.integers(-10_000, 10_000), st.integers(0, 6), st.sampled_from(LENGTH.units))
@patient
@example(135, 1, "mm")
def test_a_unit_scales_its_number_exactly(digits: int, decimals: int, unit: str) -> None:
    number = f"{'-' * (digits < 0)}{abs(digits) // 10**decimals}.{abs(digits) % 10**decimals:0{max(decimals, 1)}}"
    factor = {"mm": Fraction(1, 1000), "cm": Fraction(1, 100), "m": Fraction(1), "km": Fraction(1000)}[unit]
    if abs(Fraction(number) * factor) <= 10_000:
        assert parse_quantity(f"{number} {unit}", LENGTH) == float(Fraction(number) * factor)


@given(st.floats(-1e4, 1e4))
@patient
def test_a_quantity_written_in_si_reads_back_the_same(metres: float) -> None:
    assert parse_quantity(f"{metres!r} m", LENGTH) == pytest.approx(metres, abs=0.0, rel=0.0)


@pytest.mark.parametrize("dimension", DIMENSIONS, ids=lambda dimension: dimension.noun)
def test_every_dimension_reads_its_own_example_and_no_other_does(dimension: Dimension) -> None:
    parse_quantity(dimension.example, dimension)
    for other in DIMENSIONS:
        if other is not dimension:
            assert mistake(dimension.example, other).code == "SD106"


@pytest.mark.parametrize("dimension", DIMENSIONS, ids=lambda dimension: dimension.noun)
def test_all_units_of_a_dimension_are_commensurable(dimension: Dimension) -> None:
    first, *others = (unit_amount(unit).units for unit in dimension.units)
    assert all(unit == first for unit in others)


@given(st.sampled_from(DIMENSIONS), st.data())
@patient
def test_editors_accept_every_quantity_that_is_accepted(dimension: Dimension, data: st.DataObject) -> None:
    number = data.draw(st.from_regex(r"[+-]?[0-9]{1,3}(\.[0-9]{1,2})?(e-[0-9])?", fullmatch=True))
    text = number + data.draw(st.sampled_from(["", " "])) + data.draw(st.sampled_from(dimension.units))
    with suppress(MistakeError):  # out of range
        parse_quantity(text, dimension)
    assert re.fullmatch(quantity_pattern(dimension), text)


def test_units_are_not_made_before_they_are_needed() -> None:
    code = "import sys, stackdsl.quantities; sys.exit('pint' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# --- tolerances -------------------------------------------------------------------------------------------------------


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
def test_a_tolerance_is_read_as_people_mean_it(written: object, dimension: Dimension, low: float, high: float) -> None:
    tolerance = parse_tolerance(written, dimension)
    assert tolerance == Tolerance(low, high, low_open=False, high_open=False, text=str(written))


@pytest.mark.parametrize(
    ("written", "low", "high", "low_open", "high_open"),
    [("> 5 mm", 0.005, inf, True, False), ("< 5 mm", -inf, 0.005, False, True)],
)
def test_a_strict_bound_does_not_hold_itself(
    written: str, low: float, high: float, low_open: bool, high_open: bool
) -> None:
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
        ("200 mm ± 2 %", EXTENT, "SD106"),
        ("9 ± 1 mm", COUNT, "SD106"),
        (True, COUNT, "SD103"),
        (None, COUNT, "SD103"),
    ],
)
def test_a_tolerance_that_says_nothing_clear_is_refused(written: object, dimension: Dimension, code: str) -> None:
    assert tolerance_mistake(written, dimension).code == code


@pytest.mark.parametrize(
    ("written", "fault"),
    [
        ("7 .. 5", "has its bounds the wrong way round"),
        ("9 ± -1", "has a negative width"),
        ("> 5 .. 7", "cannot be read at '5 .. 7'"),
        ("< 0", "can never hold for a count"),
    ],
)
def test_a_malformed_tolerance_is_told_its_fault(written: str, fault: str) -> None:
    assert fault in tolerance_mistake(written, COUNT).message


def test_a_real_quantity_is_told_that_it_needs_a_tolerance() -> None:
    found = tolerance_mistake("12 mm", EXTENT)
    assert "a measured value is never exact" in found.message
    assert "±" in found.hint


@pytest.mark.parametrize("written", ["< 5 mm", "5 mm ± 1 mm", "1 mm .. 2 mm"])
def test_a_lower_bound_has_no_upper_end(written: str) -> None:
    with pytest.raises(MistakeError, match="not a lower bound"):
        parse_lower_bound(written, EXTENT)
    assert parse_lower_bound("> 5 mm", EXTENT).low == 0.005


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
def test_the_sign_of_the_margin_tells_whether_it_holds(tolerance: Tolerance, value: float) -> None:
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


def test_nothing_holds_for_a_value_that_is_not_known() -> None:
    assert not parse_tolerance(">= 20", COUNT).holds(nan)


def test_a_tolerance_is_a_fact() -> None:
    with pytest.raises(FrozenInstanceError):
        parse_tolerance("12", COUNT).low = 0.0  # type: ignore[misc]  # what must not work


@pytest.mark.parametrize("written", ["200 mm ± 1 mm", "200 ± 1 mm", "> 5 mm", "5 .. 7 cm", "≤ 2.5 mm", "1 +- .5 m"])
def test_editors_accept_tolerances(written: str) -> None:
    pattern = str(TypeAdapter(LengthTolerance).json_schema()["pattern"])
    assert re.search(pattern, written)
    assert not re.search(pattern, "12 mm")
    assert not re.search(pattern, "5 ± 1")
