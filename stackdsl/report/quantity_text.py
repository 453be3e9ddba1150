"""A variable of a matrix as numbers: `10 mm` is 10, in mm, and 0.01 in units of the SI."""

from stackdsl.language.quantities import QUANTITY, in_si


def quantity_of(written: str) -> dict[str, object]:
    """What was written, and the number, unit and SI value of it; all three None where it is a word."""
    found = QUANTITY.fullmatch(written.strip())
    if found is None:
        return {"written": written, "number": None, "unit": None, "si": None}
    number, unit = float(found["number"]), found["unit"] or ""
    factor = float(in_si(unit)) if unit else 1.0
    return {"written": written, "number": number, "unit": unit, "si": number * factor}
