"""Numbers of a file, exactly as they are written, with the unit of their last digit."""

import re
from fractions import Fraction
from typing import Final

from stackdsl.language.quantities import SIGNED

IN_METRES: Final = {"mm": Fraction(1, 1000), "cm": Fraction(1, 100), "m": Fraction(1)}
IN_KILOGRAMS: Final = {"g": Fraction(1, 1000), "kg": Fraction(1), "t": Fraction(1000)}
MOST_POWER: Final = 30  # of ten: beyond, it is no size, place or mass of anything


def number_of(text: str) -> tuple[Fraction, Fraction] | None:
    """A number and the unit of its last digit; None if it is none, or beyond all reason."""
    if not re.fullmatch(SIGNED, text):
        return None
    mantissa, _, power = text.lower().partition("e")
    shift = int(power or 0)
    if abs(shift) > MOST_POWER:
        return None
    places = len(mantissa.partition(".")[2].rstrip("0"))
    return Fraction(mantissa) * Fraction(10) ** shift, Fraction(10) ** (shift - places)
