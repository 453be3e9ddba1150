"""OBJ files as 3D programs export them: each object (`o`), or each group (`g`) where there are no objects, is a brick.

Lengths have no unit, no axis is said to point up, and nothing says how heavy anything is: the author does. Of what
says nothing of statics, normals, textures and materials are passed over.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final

from stackdsl.diagnostics import Span
from stackdsl.importing.load import Exact3, ImportedLoad, LoadReading
from stackdsl.importing.measures import Measures
from stackdsl.importing.meshes import Mesh, brick_name, density_of, merged, metre_of, solid_brick
from stackdsl.language.imports import Import
from stackdsl.language.obj_text import corner_number

_LOOKS: Final = {"vt", "vn", "usemtl", "mtllib", "s", "usemap", "maplib", "lod", "shadow_obj", "trace_obj"}
LEAST_PARTS: Final = 3  # of a corner, and of a face


@dataclass(slots=True)
class _Part:
    """The faces between two lines that name an object or a group."""

    name: str
    span: Span
    faces: list[tuple[int, ...]] = field(default_factory=list)  # places among all corners of the file


def read_obj(reading: LoadReading, asked: Import) -> ImportedLoad:
    """The bricks of a file, in its order. Raises UnreadableLoadError."""
    metre, density = metre_of(reading, asked), density_of(reading, asked)
    if asked.up is None:
        hint = "say which: `up: +z`, or `up: +y`, as Blender and others write it unless told otherwise"
        reading.open(reading.page.span(0, 0), "an OBJ file does not say which of its axes points up", hint)
    lines = _Lines(reading, Measures(reading, metre), asked.up == "+y")
    lines.read()
    reading.end()
    made = [solid_brick(reading, mesh, density) for mesh in lines.meshes()]
    return reading.load([brick for brick in made if brick is not None])


class _Lines:
    """Reads one line after the other."""

    def __init__(self, reading: LoadReading, measures: Measures, y_is_up: bool) -> None:
        self._reading, self._measures, self._y_is_up = reading, measures, y_is_up
        self._named_by = "o" if any(line.split()[:1] == ["o"] for line in reading.page.lines) else "g"
        self._corners: list[Exact3] = []
        self._parts: dict[str, _Part] = {}
        self._part: _Part | None = None

    def read(self) -> None:
        """All of the file; what is mistaken is told."""
        number, lines = 0, self._reading.page.lines
        while number < len(lines):
            first, text = number, lines[number].partition("#")[0]
            while text.endswith("\\") and number + 1 < len(lines):
                number += 1
                text = text[:-1] + lines[number].partition("#")[0]
            number += 1
            if text.strip():
                self._line(self._reading.page.span(first, len(text) - len(text.lstrip())), text.split())

    def _line(self, span: Span, words: Sequence[str]) -> None:
        kind, *parts = words
        if kind == "v":
            self._corners.append(self._corner(span, parts) or (Fraction(0), Fraction(0), Fraction(0)))
        elif kind == "f":
            self._face(span, parts)
        elif kind == self._named_by:
            self._begin(span, " ".join(parts))
        else:
            self._reading.leave(kind, span, known=kind in _LOOKS or kind == "g")

    def _begin(self, span: Span, written: str) -> None:
        name = brick_name(written, f"brick-{len(self._parts) + 1}")
        part = self._parts.setdefault(name, _Part(name, span))
        if part.span != span and part is not self._part and part.faces:
            kind = "objects" if self._named_by == "o" else "groups"
            self._reading.wrong(span, f"two {kind} come to the name '{name}'", "call them apart")
        self._part = part

    def _corner(self, span: Span, parts: Sequence[str]) -> Exact3 | None:
        if len(parts) < LEAST_PARTS:
            hint = "a corner is such as `v 0.1 0 0.05`"
            self._reading.wrong(span, f"a corner of {len(parts)} numbers", hint)
            return None
        found = [self._measures.place(part, span, "the corner") for part in parts[:LEAST_PARTS]]  # then may be colours
        x, y, z = found
        if x is None or y is None or z is None:
            return None
        return (x, -z, y) if self._y_is_up else (x, y, z)

    def _face(self, span: Span, parts: Sequence[str]) -> None:
        if self._part is None:
            self._begin(span, "")
        assert self._part is not None
        loop = [self._place(part) for part in parts]
        known = [place for place in loop if place is not None]
        if len(known) < len(loop):
            hint = "a face is `f 1 2 3`, by the numbers of corners above it"
            self._reading.wrong(span, f"the face names a corner that is not among the {len(self._corners)} above", hint)
        elif len(loop) < LEAST_PARTS or len(set(known)) < len(known):
            self._reading.wrong(span, "the face has fewer than three corners, or one twice", "mend the face")
        else:
            self._part.faces.append(tuple(known))

    def _place(self, part: str) -> int | None:
        """Of `3/1/2`, where texture and normal follow; -1 is the last corner so far."""
        number = corner_number(part)
        if number is None:
            return None
        place = number - 1 if number > 0 else len(self._corners) + number
        return place if number != 0 and 0 <= place < len(self._corners) else None

    def meshes(self) -> list[Mesh]:
        """What was read, but for what is to be ignored and what has no faces."""
        found = []
        for part in self._parts.values():
            if part.name in self._reading.ignored:
                self._reading.leave(part.name, part.span, known=False)
            elif part.faces:
                found.append(Mesh(part.name, *merged(self._corners, part.faces), part.span))
            else:
                self._reading.leave(f"{part.name}, which has no faces", part.span, known=True)
        return found
