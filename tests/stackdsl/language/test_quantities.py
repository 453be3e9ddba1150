"""Reading of quantities with units."""

import re
import subprocess
import sys
from contextlib import suppress
from fractions import Fraction
from math import inf, nan, pi

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stackdsl.language.quantities import (
    ACCELERATION,
    ANGLE,
    DENSITY,
    DURATION,
    FREQUENCY,
    LENGTH,
    MASS,
    SHARE,
    SIDE,
    SLOPE,
    SPEED,
    STRENGTH,
    UNITS,
    Dimension,
    InputError,
    in_si,
    parse_quantity,
    quantity_pattern,
    unit_amount,
)

DIMENSIONS = [LENGTH, DURATION, FREQUENCY, ANGLE, DENSITY, MASS, ACCELERATION]
patient = settings(deadline=None)  # the first quantity imports pint


def mistake(written: object, dimension: Dimension) -> InputError:
    with pytest.raises(InputError) as caught:
        parse_quantity(written, dimension)
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
        ("2.5 Hz", FREQUENCY, 2.5),
        ("50 um", LENGTH, 5e-5),
        ("50 \N{MICRO SIGN}m", LENGTH, 5e-5),
        ("50 \N{GREEK SMALL LETTER MU}m", LENGTH, 5e-5),
        (0, LENGTH, 0.0),
        ("0", DURATION, 0.0),
        ("-0.0", ANGLE, 0.0),
        ("180 deg", ANGLE, pi),
        ("180°", ANGLE, pi),
        ("1 rad", ANGLE, 1.0),
        ("11.9 g", MASS, 0.0119),
        ("1 g0", ACCELERATION, 9.80665),
        ("0.5 g", ACCELERATION, 4.903325),
        ("0.5 g", MASS, 0.0005),
        *((f"9.81 m/s{power}", ACCELERATION, 9.81) for power in ("2", "^2", "²")),
        *((f"557 kg/m{power}", DENSITY, 557.0) for power in ("3", "^3", "³")),
        ("0.557 g/cm3", DENSITY, 557.0),
        ("25 %", SHARE, 0.25),
        (0.25, SHARE, 0.25),
    ],
)
def test_a_quantity_is_read_into_si_to_the_last_bit(written: object, dimension: Dimension, si: float) -> None:
    assert parse_quantity(written, dimension) == si


@pytest.mark.parametrize(
    ("written", "likely"),
    [(13.5, "13.5 mm"), ("13.5", "13.5 mm"), ("-1", "-1 mm"), (0.012, "12 mm for 0.012 m")],
)
def test_number_without_unit_has_a_remedy(written: object, likely: str) -> None:
    found = mistake(written, LENGTH)
    assert found.code == "SD105"
    assert found.hint == f"write a length with its unit, such as {likely}"


@pytest.mark.parametrize(
    ("written", "hint"),
    [
        (0.1, "such as 0.1 MPa"),
        (200000, "such as 0.2 MPa for 200000 Pa"),
        ("30 GPa", "write 30000 MPa"),
        ("145 psi", "write 999.74 kPa"),
        ("5 N/m²", "write 5 Pa"),
    ],
)
def test_strength_without_a_known_unit_has_a_remedy(written: object, hint: str) -> None:
    assert mistake(written, STRENGTH).hint.endswith(hint)


@pytest.mark.parametrize(
    ("written", "hint"),
    [
        ("5 mmm", "did you mean 'mm'?"),
        ("5 s", "choose from: mm, cm, m, km, um"),
        ("5 MM", "did you mean 'mm'?"),
        ("5 %", "choose from: mm, cm, m, km, um"),
    ],
)
def test_wrong_unit_has_a_suggestion(written: str, hint: str) -> None:
    found = mistake(written, LENGTH)
    assert (found.code, found.hint) == ("SD106", hint)


@pytest.mark.parametrize(
    "written",
    ["", "mm", "abc", "inf mm", "nan mm", "1,5 mm", "1 000 mm", "0x10 mm", "1e5000 mm", "9" * 5000 + " mm",
     "5 mm long", "5 kg / m3", True, None, [], {}, inf, nan],
)  # fmt: skip
def test_malformed_quantity_is_rejected(written: object) -> None:
    assert mistake(written, LENGTH).code == "SD103"


@pytest.mark.parametrize(
    ("written", "dimension"),
    [("11 km", LENGTH), ("1e999 m", LENGTH), ("-1 s", DURATION), ("2 km", ANGLE), ("0 kg/m3", DENSITY), ("-1 g", MASS),
     ("1e-999 kg", MASS), ("1e-999 m/s", SPEED)],
)  # fmt: skip
def test_a_quantity_out_of_range_is_refused(written: str, dimension: Dimension) -> None:
    assert mistake(written, dimension).code == ("SD106" if dimension is ANGLE else "SD104")


@pytest.mark.parametrize(
    ("written", "dimension", "hint"),
    [
        ("11 km", LENGTH, "write a value between -10000 and 10000 m"),
        ("-1 s", DURATION, "write a value between 0 and 86400 s"),
        ("95 deg", SLOPE, "write a value between 0 and 90 deg"),
        ("-1 deg", SLOPE, "write a value between 0 and 90 deg"),
        ("1e9 deg", ANGLE, "write a value between -36000 and 36000 deg"),
        ("101 %", SHARE, "write a value between 0 and 1"),
        ("0 m/s2", ACCELERATION, "write a value greater than zero"),
        ("-1 g", MASS, "write a value greater than zero"),
        ("1e7 kg/m3", DENSITY, "write a value greater than zero, at most 1000000 kg/m3"),
    ],
)
def test_quantity_out_of_range_reports_the_range(written: str, dimension: Dimension, hint: str) -> None:
    assert mistake(written, dimension).hint == hint


@pytest.mark.parametrize(
    ("written", "dimension"),
    [("90 deg", SLOPE), ("0 deg", SLOPE), ("-36000 deg", ANGLE), ("10 km", LENGTH), ("1e-9 m", SIDE)],
)
def test_the_ends_of_a_range_belong_to_it(written: str, dimension: Dimension) -> None:
    parse_quantity(written, dimension)


@given(st.integers(-10_000, 10_000), st.integers(0, 6), st.sampled_from(LENGTH.units))
@patient
@example(135, 1, "mm")
def test_a_unit_scales_its_number_exactly(digits: int, decimals: int, unit: str) -> None:
    number = f"{'-' * (digits < 0)}{abs(digits) // 10**decimals}.{abs(digits) % 10**decimals:0{max(decimals, 1)}}"
    factor = {
        "mm": Fraction(1, 1000),
        "cm": Fraction(1, 100),
        "m": Fraction(1),
        "km": Fraction(1000),
        "um": Fraction(1, 10**6),
    }[unit]
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
        if other is not dimension and not (dimension is MASS and other.gravities):  # both have a unit g
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
    with suppress(InputError):  # out of range
        parse_quantity(text, dimension)
    assert re.fullmatch(quantity_pattern(dimension), text)


@pytest.mark.parametrize("unit", sorted({*UNITS, *(unit for dimension in DIMENSIONS for unit in dimension.units), ""}))
def test_units_agree_with_pint(unit: str) -> None:
    assert in_si(unit) == unit_amount(unit).magnitude


def test_a_quantity_is_read_without_making_units() -> None:
    code = """
import sys
from stackdsl.language.quantities import LENGTH, parse_quantity
assert parse_quantity('13.5 mm', LENGTH) == 0.0135
sys.exit('pint' in sys.modules)
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("written", ["１２ mm", "1２ mm", "١٢ mm", "1.５ mm", "1e１ mm"])
def test_digits_of_other_scripts_are_rejected(written: str) -> None:
    # Python's float() reads them; no other reader of a scenario does, and an eye may take one for another.
    assert mistake(written, LENGTH).code == "SD103"
    assert re.fullmatch(quantity_pattern(LENGTH), written) is None
