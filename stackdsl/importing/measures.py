"""Lengths and masses of a file: numbers within reason, or what is wrong with them, in its place."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from stackdsl.diagnostics import Span
from stackdsl.importing.json_text import JsonText, Node, Numeral
from stackdsl.importing.load import Exact3, LoadReading
from stackdsl.importing.numbers import number_of

FURTHEST: Final = Fraction(10_000)  # [m]
SHORTEST: Final = Fraction(1, 1_000_000)  # [m]
HEAVIEST: Final = Fraction(1_000_000_000)  # [kg]
ROUGHEST: Final = 10  # Coulomb coefficient
LONGEST_TOLD: Final = 40  # [characters]


@dataclass(frozen=True, slots=True)
class Measures:
    """Reads what is measured in some units."""

    reading: LoadReading
    metre: Fraction  # of a unit of length [m]
    kilogram: Fraction = Fraction(1)  # of a unit of mass [kg]

    def number(self, text: str, span: Span, what: str) -> tuple[Fraction, Fraction] | None:
        """A number, and the unit of its last digit; told and None if it is none."""
        found = number_of(text.strip())
        if found is None:
            shown = text if len(text) <= LONGEST_TOLD else f"{text[:LONGEST_TOLD]}..."
            why = "there is no number" if not text.strip() else f"'{shown}' is no number"
            hint = "write digits, with a point before decimals, and no unit"
            self.reading.wrong(span, f"{what}: {why}", hint)
        return found

    def place(self, text: str, span: Span, what: str, metre: Fraction | None = None) -> Fraction | None:
        """A coordinate [m]."""
        found = self.number(text, span, what)
        if found is None:
            return None
        unit = self.metre if metre is None else metre
        value = found[0] * unit
        if abs(value) > FURTHEST:
            self.reading.wrong(span, f"{what} of {text.strip()} is more than 10 km", "mend the number, or its unit")
            return None
        self.reading.digit(found[1] * unit)
        return value

    def side(self, text: str, span: Span, what: str, metre: Fraction | None = None) -> Fraction | None:
        """Length of a side [m], which is more than nothing."""
        value = self.place(text, span, what, metre)
        if value is not None and value < SHORTEST:
            self.reading.wrong(span, f"{what} of {text.strip()} is no length of a box", "write more than zero")
            return None
        return value

    def mass(self, text: str, span: Span, what: str, kilogram: Fraction | None = None) -> Fraction | None:
        """A mass [kg], which is more than nothing."""
        found = self.number(text, span, what)
        if found is None:
            return None
        value = found[0] * (self.kilogram if kilogram is None else kilogram)
        if not 0 < value <= HEAVIEST:
            self.reading.wrong(span, f"{what} of {text.strip()} is no mass of a box", "write more than zero")
            return None
        return value

    # --- of JSON ------------------------------------------------------------------------------------------------------

    def places(self, json: JsonText, nodes: Sequence[Node | None], what: str, side: bool = False) -> Exact3 | None:
        """Three coordinates, or three sides [m]; None if any is missing or wrong, which is told."""
        found = [self._one(json, node, f"{what} {axis}", side) for node, axis in zip(nodes, "xyz", strict=True)]
        x, y, z = found
        return None if x is None or y is None or z is None else (x, y, z)

    def deck(self, json: JsonText, nodes: Sequence[Node | None], what: str) -> tuple[Fraction, Fraction] | None:
        """Length and width of a deck [m], whose digits say nothing of those of boxes; None if any is wrong."""
        found: list[Fraction] = []
        for node in nodes:
            text = self._text(json, node, what)
            number = self.number(text, json.span(node), what) if node is not None and text is not None else None
            if node is None or number is None:
                return None
            if not SHORTEST <= number[0] * self.metre <= FURTHEST:
                self.reading.wrong(json.span(node), f"{what} of {text} is no side of a deck", "write more than zero")
                return None
            found.append(number[0] * self.metre)
        return (found[0], found[1])

    def weight(self, json: JsonText, node: Node | None, what: str) -> Fraction | None:
        """A mass [kg]."""
        text = self._text(json, node, what)
        return None if node is None or text is None else self.mass(text, json.span(node), what)

    def _one(self, json: JsonText, node: Node | None, what: str, side: bool) -> Fraction | None:
        text = self._text(json, node, what)
        if node is None or text is None:
            return None
        return (self.side if side else self.place)(text, json.span(node), what)

    def _text(self, json: JsonText, node: Node | None, what: str) -> str | None:
        if node is None:
            return None
        if isinstance(node.value, Numeral):
            return node.value.text
        self.reading.wrong(json.span(node), f"{what} is no number", "write it without quotes")
        return None


def chosen(
    json: JsonText, loads: Mapping[str, Node], wanted: str | None, noun: str, start: Node
) -> tuple[str, Node] | None:
    """The load that is meant of those in a file; told and None if that is not said."""
    if wanted is not None and wanted in loads:
        return wanted, loads[wanted]
    if wanted is None and len(loads) == 1:
        return next(iter(loads.items()))
    listed = ", ".join(f"'{name}'" for name in list(loads)[:16]) + (", ..." if len(loads) > 16 else "")  # noqa: PLR2004
    if not loads:
        json.reading.wrong(json.span(start), f"there is no {noun} in it", "name a file with one")
    elif wanted is None:
        message = f"there are {len(loads)} {noun}s in it: {listed}"
        json.reading.open(json.span(start), message, f"say which, such as load: '{next(iter(loads))}'")
    else:
        message = f"there is no {noun} '{wanted}' in it"
        json.reading.open(json.span(start), message, f"choose from: {listed}")
    return None
