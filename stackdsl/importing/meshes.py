"""Convex solids from the corners and faces of meshes, and what files of meshes leave open.

Such files say neither in which unit their lengths are nor how heavy their blocks are, so the author does.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Final

from stability.geometry.vectors import subtract
from stability.shapes.not_a_solid import NotASolidError
from stackdsl.diagnostics import Span
from stackdsl.importing.load import Exact3, ImportedBox, LoadReading
from stackdsl.importing.numbers import IN_METRES
from stackdsl.language.author_types import NAME
from stackdsl.language.imports import Import

LONGEST_NAME: Final = 64  # [characters]
LEAST_CORNERS: Final = 3  # of a face
EVEN: Final = 1e-5  # of a size: a centre of mass as near to that of an even filling is that


@dataclass(frozen=True, slots=True)
class Mesh:
    """A solid of a file: its corners [m], and its faces as places among these, counter-clockwise seen from outside."""

    name: str
    corners: Sequence[Exact3]
    faces: Sequence[Sequence[int]]
    span: Span


def metre_of(reading: LoadReading, asked: Import) -> Fraction:
    """One of the file's units of length [m]; asked for if it is not said."""
    said = asked.units.length if asked.units is not None else None
    if said is None:
        message = "the file does not say in which unit its lengths are"
        reading.open(reading.page.span(0, 0), message, "say which, such as `units: {length: m}`")
    return IN_METRES[said or "m"]


def density_of(reading: LoadReading, asked: Import) -> Fraction:
    """What a cubic metre weighs [kg]; asked for if it is not said."""
    if asked.density is None:
        message = "the file does not say how heavy its blocks are"
        reading.open(reading.page.span(0, 0), message, "say it, such as `density: 2400 kg/m3`")
    return Fraction(repr(asked.density or 1.0))


def solid_brick(
    reading: LoadReading,
    mesh: Mesh,
    density: Fraction = Fraction(1),
    mass: Fraction | None = None,
    heavy_at: Exact3 | None = None,
) -> ImportedBox | None:
    """A mesh as a brick, if it is a convex solid; told and None if it is not.

    `mass` [kg] in place of the density [kg/m3]; `heavy_at` is the centre of mass, by default that of an even filling.
    """
    from stability.shapes.solid_making import solid_of_mesh  # noqa: PLC0415 -- boxes do without scipy

    try:
        made = solid_of_mesh([_floats(corner) for corner in mesh.corners], mesh.faces)
    except NotASolidError as error:
        hint = f"{error.hint}; or, if it may be passed over, write ignore: ['{mesh.name}']"
        reading.wrong(mesh.span, f"'{mesh.name}': {error.message}", hint)
        return None
    used = dict.fromkeys(mesh.corners[corner] for face in mesh.faces for corner in face)
    lows, highs = zip(*((min(along), max(along)) for along in zip(*used, strict=True)), strict=True)
    centre = _exact3([(low + high) / 2 for low, high in zip(lows, highs, strict=True)])
    size = _exact3([high - low for low, high in zip(lows, highs, strict=True)])
    corners = None
    if set(used) != set(product(*zip(lows, highs, strict=True))):  # else it is an upright box, which may settle
        corners = tuple(_exact3([part - at for part, at in zip(corner, centre, strict=True)]) for corner in used)
    weighs = density * Fraction(made.shape.volume) if mass is None else mass
    off = None
    if heavy_at is not None and max(map(abs, subtract(made.centre_of_mass, _floats(heavy_at)))) > EVEN * max(size):
        off = _exact3([part - at for part, at in zip(heavy_at, centre, strict=True)])
    return ImportedBox(mesh.name, size, centre, weighs, mesh.span, corners=corners, heavy_at=off)


def merged(corners: Sequence[Exact3], faces: Sequence[Sequence[int]]) -> tuple[list[Exact3], list[tuple[int, ...]]]:
    """A mesh in which corners in one place are one: files may list those of each face apart."""
    places: dict[Exact3, int] = {}
    loops = [tuple(places.setdefault(corners[corner], len(places)) for corner in face) for face in faces]
    solid = [tuple(dict.fromkeys(loop)) for loop in loops]
    return list(places), [loop for loop in solid if len(loop) >= LEAST_CORNERS]


def brick_name(written: str, otherwise: str) -> str:
    """A name that a brick can have, as near to what is written as that goes."""
    plain = re.sub(r"[^A-Za-z0-9_.-]+", "-", written.strip()).strip("-")[:LONGEST_NAME]
    if not plain:
        return otherwise
    return plain if re.fullmatch(NAME, plain) else f"{otherwise.partition('-')[0]}-{plain}"[:LONGEST_NAME]


def _floats(corner: Exact3) -> tuple[float, float, float]:
    x, y, z = map(float, corner)
    return (x, y, z)


def _exact3(parts: Sequence[Fraction]) -> Exact3:
    x, y, z = parts
    return (x, y, z)
