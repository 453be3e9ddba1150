"""The text of a Wavefront OBJ file as corners and faces: of all that such a file may hold, its `v` and `f` lines."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Final

from stackdsl.language.mistakes import MistakeError, shown

MOST_LINES: Final = 100_000
LEAST_PARTS: Final = 3  # of a corner, and of a face
_CORNER: Final = re.compile(r"[-+]?[0-9]{1,18}(?=/|$)")


@dataclass(slots=True)
class ObjMesh:
    """What an OBJ file describes."""

    points: list[tuple[float, float, float]] = field(default_factory=list)
    loops: list[tuple[int, ...]] = field(default_factory=list)  # corners of each face, from 0


def obj_mesh(text: str, file: str) -> ObjMesh:
    """The mesh of a file. Raises MistakeError, with the line, for what is no corner and no face."""
    mesh = ObjMesh()
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        raise MistakeError("SD104", f"{file} has {len(lines)} lines, and {MOST_LINES} is the most", "simplify the mesh")
    for number, line in enumerate(lines, start=1):
        kind, *parts = line.partition("#")[0].split() or [""]
        try:
            if kind == "v":
                mesh.points.append(_point(parts))
            elif kind == "f":
                mesh.loops.append(_loop(parts, len(mesh.points)))
        except ValueError as error:
            hint = "a corner is `v 0.1 0 0.05`, and a face `f 1 2 3`, by the numbers of corners above it"
            raise MistakeError("SD104", f"{file}:{number}: {error}", hint) from None
    if not mesh.loops:
        raise MistakeError("SD104", f"{file} has no faces", "export it as a mesh, with `v` and `f` lines")
    return mesh


def _point(parts: Sequence[str]) -> tuple[float, float, float]:
    if len(parts) < LEAST_PARTS:
        raise ValueError(f"a corner of {len(parts)} numbers")
    x, y, z = (_number(part) for part in parts[:LEAST_PARTS])  # a weight or a colour may follow
    return (x, y, z)


def _number(part: str) -> float:
    try:
        number = float(part)
    except ValueError:
        raise ValueError(f"{shown(part)} is no number") from None
    if not part.isascii() or "_" in part:  # as Python would read
        raise ValueError(f"{shown(part)} is no number")
    if not isfinite(number):
        raise ValueError(f"{shown(part)} is no number that means a place")
    return number


def _loop(parts: Sequence[str], known: int) -> tuple[int, ...]:
    if len(parts) < LEAST_PARTS:
        raise ValueError(f"a face of {len(parts)} corners")
    loop = tuple(_corner(part, known) for part in parts)
    if len(set(loop)) < len(loop):
        raise ValueError("a face that has one corner twice")
    return loop


def _corner(part: str, known: int) -> int:
    """Of `3/1/2`, where texture and normal follow; -1 is the last corner so far."""
    number = corner_number(part)
    if number is None:
        raise ValueError(f"{shown(part)} names no corner")
    index = number - 1 if number > 0 else known + number
    if number == 0 or not 0 <= index < known:
        raise ValueError(f"there is no corner {number}: {known} stand above")
    return index


def corner_number(part: str) -> int | None:
    """The number of a corner in a part of a face, such as 3 of `3/1/2`; None if there is none."""
    match = _CORNER.match(part)
    return int(match[0]) if match else None
