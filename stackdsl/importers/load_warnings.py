"""Warns about a load that is read as the author hardly means it: implausible sizes or densities, and overhangs."""

from collections.abc import Iterator
from fractions import Fraction
from typing import Final

from stackdsl.diagnostics import ScenarioWarning
from stackdsl.importers.load import ImportedBox, ImportedLoad, digits
from stackdsl.importers.overhang import overhang_warnings
from stackdsl.importers.text_positions import IN_METRES
from stackdsl.language.imports import Import

LONGEST_SIDES: Final = (Fraction(1, 1000), Fraction(20))  # [m] of a brick, from a toy to a block of a quarry
LIKELY_SIDES: Final = (Fraction(1, 10), Fraction(3))  # [m]
NEARLY: Final = Fraction(5, 1000)  # [m] between the height of a pallet and that of the lowest box
DENSITIES: Final = (1, 25_000)  # [kg/m3], from air to more than any metal in use


def load_warnings(load: ImportedLoad, options: Import) -> Iterator[ScenarioWarning]:
    """Yield all warnings about a load."""
    yield from _implausible(load, options)
    if load.likely_point not in ("", options.point):
        lowest = {"corner": "is 0", "centre": "is half their height"}[load.likely_point]
        message = f"z of the lowest boxes {lowest}, so x, y, z are hardly the {options.point} of a box"
        yield ScenarioWarning(load.boxes[0].span, message, f"write `point: {load.likely_point}` if that is so")
    yield from _level(load, options)
    yield from overhang_warnings(load, options)


def _level(load: ImportedLoad, options: Import) -> Iterator[ScenarioWarning]:
    """Yield one warning if the boxes hang as high above their deck as the pallet is high."""
    if options.deck is None or options.deck.surface is None or options.deck.level != 0.0:
        return
    lowest = min(load.boxes, key=lambda box: box.centre[2] - box.size[2] / 2)
    height, base = Fraction(repr(options.deck.height)), Fraction(repr(options.origin[2]))
    above = lowest.centre[2] - lowest.size[2] / 2 - base - height
    if abs(above - height) <= max(load.precision, NEARLY):
        message = f"z of the lowest box is {digits(1000 * above)} mm, the height of the pallet"
        hint = f"if z counts from the floor, write `deck: {{level: {digits(1000 * height)} mm}}`"
        yield ScenarioWarning(lowest.span, message, hint)


def _implausible(load: ImportedLoad, options: Import) -> Iterator[ScenarioWarning]:
    """Yield one warning if the sizes or densities of boxes are implausible, at the first of them."""
    # Bricks with studs have no unit of length to be mistaken, and may be weights.
    box = next((box for box in load.boxes if not box.has_studs and not _is_plausible(box)), None)
    if box is None:
        return
    longest, density = max(box.size), _density(box)
    name = f"'{box.name}'" if box.name else "this box"
    heavy = f" and a density of {float(density):.3g} kg/m3" if density is not None else ""
    message = f"{name} has a longest side of {float(longest):.4g} m{heavy}, which is implausible"
    yield ScenarioWarning(box.span, message, _other_units(longest, options))


def _is_plausible(box: ImportedBox) -> bool:
    density = _density(box)
    is_dense = density is None or DENSITIES[0] <= density <= DENSITIES[1]
    return is_dense and LONGEST_SIDES[0] <= max(box.size) <= LONGEST_SIDES[1]


def _density(box: ImportedBox) -> Fraction | None:
    """Return the density [kg/m3]; None for a solid, whose volume is unknown here."""
    length, width, height = box.size
    return None if box.corners is not None or box.curved is not None else box.mass / (length * width * height)


def _other_units(longest: Fraction, options: Import) -> str:
    """Return the remedy: the unit of lengths with which the longest side is likely, or both units."""
    used = options.units.length if options.units is not None else None
    for unit in ("mm", "cm", "m") if used else ():
        side = longest * IN_METRES[unit] / IN_METRES[used or "m"]
        if unit != used and LIKELY_SIDES[0] <= side <= LIKELY_SIDES[1]:
            return f"check the units of the file; with `units: {{length: {unit}}}` this side is {float(side):.4g} m"
    return "check the units of lengths and masses of the file"
