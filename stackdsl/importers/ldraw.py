"""Reads and writes LDraw files: models of LEGO parts, with models inside of models.

Lengths are in units of 0.4 mm: a stud is 20 wide, a brick 24 and a plate 8 high. The y axis points down. The origin of
a brick is in the middle of its upper face, without studs, and its length is along x.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import isclose
from pathlib import PurePosixPath
from typing import Final, TypeAlias

from stability.geometry.box import box_of
from stability.geometry.vectors import add, body_axes, rotate, scale
from stability.model import BodyId, ConvexShape, Pose
from stability.name_order import names_text
from stackdsl.diagnostics import Diagnostic, Page, Span, page_of
from stackdsl.importers.lego import lego_box
from stackdsl.importers.load import ImportedBox, ImportedLoad, LoadReading
from stackdsl.importers.text_positions import FURTHEST, number_of
from stackdsl.language.lego import LEGO
from stackdsl.language.value_types import MAX_BRICKS
from stackdsl.language.yaml.source import BOM, decoded

UNIT: Final = Fraction(4, 10_000)  # [m]
SQUARE: Final = Fraction(1, 1000)  # largest deviation of the parts of a rotation, written with few digits, from 0 or 1
DEEPEST: Final = 40  # models inside of models
MOST_LINES: Final = 200_000  # that are read, those of a model once for each of its uses
NUMBERS: Final = 12  # of the place and rotation of a part
COLOUR: Final = 1  # that of a line comes before the numbers
OTHER_PARTS: Final = "other parts"  # in `ignore`: all parts that the catalogue lacks
SEVERAL: Final = 2  # parts that the catalogue lacks, from which on one message names all
_GEOMETRY: Final = "geometry"  # lines, triangles and quadrilaterals

KINDS: Final[Mapping[str, str]] = {number: kind for kind, part in LEGO.items() for number in part.ldraw}
Row: TypeAlias = tuple[Fraction, Fraction, Fraction]
_MODEL: Final = re.compile(r"\s*0\s+FILE\s+(\S.*?)\s*", re.IGNORECASE)
_END: Final = re.compile(r"\s*0\s+NOFILE\b.*", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class _Frame:
    """Place and axes of a model or a part, in the frame of the whole, in LDraw units."""

    at: Row
    rows: tuple[Row, Row, Row]

    def of(self, inner: "_Frame") -> "_Frame":
        """Return the frame of something that is in this one."""
        columns = list(zip(*inner.rows, strict=True))
        rows = [tuple(_dot(row, column) for column in columns) for row in self.rows]
        at = [start + _dot(row, inner.at) for start, row in zip(self.at, self.rows, strict=True)]
        return _Frame((at[0], at[1], at[2]), (rows[0], rows[1], rows[2]))  # type: ignore[arg-type]  # of three each


def _dot(one: Sequence[Fraction], other: Sequence[Fraction]) -> Fraction:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


_ZERO, _ONE = Fraction(0), Fraction(1)
_WHOLE: Final = _Frame((_ZERO, _ZERO, _ZERO), ((_ONE, _ZERO, _ZERO), (_ZERO, _ONE, _ZERO), (_ZERO, _ZERO, _ONE)))


@dataclass(frozen=True, slots=True)
class _Model:
    """The lines of a model, by their indices in a file."""

    page: Page
    lines: tuple[int, ...]


@dataclass(slots=True)
class _Parts:
    """The parts of a file and of the files that it names."""

    reading: LoadReading
    models: dict[str, _Model]
    bricks: list[tuple[str, _Frame, Span]]  # kind and pose of each brick of the catalogue
    unknown: dict[str, Span]  # the first place of each part that the catalogue lacks
    read: int = 0
    _uses: dict[str, int] = field(default_factory=dict)  # lines of each model, with those of all models in it

    def of(self, name: str, frame: _Frame, outer: tuple[str, ...]) -> None:
        """Find all parts of a model."""
        model = self.models[name]
        for number in model.lines:
            self.read += 1
            text = model.page.lines[number]
            words = text.split(maxsplit=COLOUR + NUMBERS + 1)
            if not words:
                continue
            span = model.page.span(number, text.index(words[0]))
            if self.read > MOST_LINES or len(self.bricks) > MAX_BRICKS:
                self._end_too_large(span)
            if words[0] == "1":
                self._reference(words, frame, (*outer, name), span)
            elif words[0] in {"2", "3", "4", "5"}:
                self.reading.skip(_GEOMETRY, span, harmless=False, advice="only parts are read")
            elif words[0] != "0":
                self.reading.wrong(span, "a line begins with a digit from 0 to 5", "export the model again")

    def _reference(self, words: Sequence[str], frame: _Frame, outer: tuple[str, ...], span: Span) -> None:
        if len(words) < COLOUR + NUMBERS + 2:
            self.reading.wrong(
                span, "a part needs a colour, twelve numbers and a file", "export the model again, or complete the line"
            )
            return
        numbers = [number_of(word) for word in words[1 + COLOUR : -1]]
        if (wrong := next((i for i, number in enumerate(numbers) if number is None), None)) is not None:
            word = words[1 + COLOUR + wrong]
            self.reading.wrong(span, f"'{word[:40]}' is not a number", "write digits, with a decimal point")
            return
        values = [number[0] for number in numbers if number is not None]
        x, y, z, a, b, c, d, e, f, g, h, i = values
        if max(map(abs, values)) * UNIT > FURTHEST:
            self.reading.wrong(span, "a number of the part exceeds 10 km", "correct it")
            return
        own = frame.of(_Frame((x, y, z), ((a, b, c), (d, e, f), (g, h, i))))
        name = words[-1].strip().replace("\\", "/").lower()
        part = PurePosixPath(name)
        if part.suffix == ".dat" and part.stem in KINDS:
            self.bricks.append((KINDS[part.stem], own, span))
        elif name in outer:
            self.reading.wrong(span, f"the model '{name}' contains itself", "remove this line")
        elif len(outer) > DEEPEST:
            self.reading.wrong(span, f"models are nested more than {DEEPEST} deep", "simplify the model")
            self.reading.end()
        elif name in self.models or (part.suffix in {".ldr", ".mpd"} and self._open(name, words[-1].strip(), span)):
            if self.read + self._lines_of(name, len(outer)) > MOST_LINES:
                self._end_too_large(span)
            self.of(name, own, outer)
        elif name not in self.unknown and part.suffix not in {".ldr", ".mpd"}:
            self.unknown[name] = span

    def _end_too_large(self, span: Span) -> None:
        self.reading.wrong(span, f"the model has more than {MAX_BRICKS} parts", "import its parts one by one")
        self.reading.end()

    def _lines_of(self, name: str, depth: int) -> int:
        """Return how many lines are read for one use of a model, at least: files of their own count once opened."""
        if name not in self._uses:
            self._uses[name] = 0  # in itself
            model, total = self.models[name], 0
            for number in model.lines:
                words = model.page.lines[number].split()
                inner = words[-1].replace("\\", "/").lower() if words[:1] == ["1"] else ""
                nested = inner in self.models and depth < DEEPEST
                total += 1 + (self._lines_of(inner, depth + 1) if nested else 0)
            self._uses[name] = total
        return self._uses[name]

    def report_unknown(self) -> None:
        """Report all parts that the catalogue lacks and that are not ignored, together."""
        if all_others := OTHER_PARTS in self.reading.ignored and bool(self.unknown):
            self.reading.used.add(OTHER_PARTS)
        missing = [name for name in self.unknown if name not in self.reading.ignored]
        advice = "use bricks and plates of the catalogue (docs/language.md, Bricks with studs)"
        if all_others or len(missing) < SEVERAL:
            for name, span in self.unknown.items():
                self.reading.skip(name, span, harmless=all_others, advice=advice)
            return
        message = f"the catalogue lacks {len(missing)} parts: {names_text(missing)}"
        hint = f"{advice}; to ignore them, write `ignore: ['{OTHER_PARTS}']`"
        self.reading.undetermined(self.unknown[missing[0]], message, hint)

    def _open(self, name: str, written: str, span: Span) -> bool:
        """Read a model from a file of its own; report and return False if that fails."""
        data = self.reading.bytes_beside(written.replace("\\", "/"), span)
        text = decoded(data, written) if data else ""
        if isinstance(text, Diagnostic):
            self.reading.wrong(text.span, text.message, text.hint)
            return False
        page = page_of(text.removeprefix(BOM), written)
        self.models[name] = next(iter(_models(page).values()), _Model(page, ()))
        return bool(data)


def _models(page: Page) -> dict[str, _Model]:
    """Return the models of a file by name in lower case; the first one is the whole."""
    models: dict[str, list[int]] = {"": []}
    lines = models[""]
    for number, text in enumerate(page.lines):
        if (head := _MODEL.fullmatch(text)) is not None:
            lines = models.setdefault(head[1].replace("\\", "/").lower(), [])
        elif _END.fullmatch(text):
            lines = models[""] if len(models) == 1 else []
        else:
            lines.append(number)
    if len(models) > 1 and all(page.lines[number].split()[:1] in ([], ["0"]) for number in models[""]):
        del models[""]  # only comments come before the first model with a name
    return {name: _Model(page, tuple(lines)) for name, lines in models.items()}


def read_ldraw(reading: LoadReading) -> ImportedLoad:
    """Read the bricks and plates of a model, whose lowest ones stand on a base plate. Raises UnreadableLoadError."""
    models = _models(reading.page)
    parts = _Parts(reading, models, [], {})
    parts.of(next(iter(models)), _WHOLE, ())
    parts.report_unknown()
    reading.end()
    boxes = []
    for number, (kind, frame, span) in enumerate(parts.bricks, start=1):
        turned = _turned(frame.rows)
        if max(map(abs, frame.at)) * UNIT > FURTHEST:
            reading.wrong(span, "the part is further than 10 km", "correct its place, or that of its model")
        elif turned is None:
            message = "the part is tilted, scaled, or turned by other than multiples of 90 deg about the vertical"
            reading.undetermined(span, message, "turn it upright and onto the grid of studs")
        else:
            boxes.append(_box(f"brick-{number}", kind, frame.at, turned, span))
    lowest = min((box.bottom for box in boxes), default=_ZERO)
    standing = [replace(box, centre=(box.centre[0], box.centre[1], box.centre[2] - lowest)) for box in boxes]
    return replace(reading.load(standing), on_base_plate=True)


def _turned(rows: tuple[Row, Row, Row]) -> bool | None:
    """Return whether the length of an upright part is across x; None for other rotations."""
    for turned in (False, True):
        along, across = (rows[2], rows[0]) if turned else (rows[0], rows[2])
        squares = [abs(along[0]), _ONE + abs(along[1]), _ONE + abs(along[2])]
        squares += [_ONE + abs(across[0]), _ONE + abs(across[1]), abs(across[2])]
        squares += [_ONE + abs(rows[1][0]), rows[1][1], _ONE + abs(rows[1][2])]
        if all(abs(square - _ONE) <= SQUARE for square in squares):
            return turned
    return None


def _box(name: str, kind: str, at: Row, turned: bool, span: Span) -> ImportedBox:
    """Return the box of a part with its origin at a place in LDraw units."""
    length, width, height = LEGO[kind].exact_size
    turned = turned and length != width
    x, y, z = (UNIT * _near_whole(part) for part in at)
    along, across = (width, length) if turned else (length, width)
    return lego_box(name, kind, (x - along / 2, z - across / 2, -y - height), turned, span)


def _near_whole(part: Fraction) -> Fraction:
    """Return a coordinate without the error of numbers written with few digits."""
    return Fraction(round(part)) if abs(part - round(part)) <= SQUARE else part


# Bricks of the catalogue as an LDraw file.


COLOURS: Final = (4, 1, 14, 2, 25, 15)  # red, blue, yellow, green, orange, white; by level
DIGITS: Final = 5  # decimals of a number in LDraw units


class NoPartError(ValueError):
    """Bricks have no LDraw part."""


@dataclass(frozen=True, slots=True)
class LdrawBrick:
    """A brick to be written."""

    name: BodyId
    shape: ConvexShape
    pose: Pose
    level: int
    smooth: bool = False  # whether it has no studs on top

    @property
    def kind(self) -> str | None:
        """Return the kind of the catalogue with this size; None if there is none."""
        box = box_of(self.shape)
        if box is None:
            return None
        parts = ((kind, part) for kind, part in LEGO.items() if part.smooth is self.smooth)
        same = (kind for kind, part in parts if all(map(isclose, part.size, box[0].size)))
        return next(same, None)


def ldraw_text(title: str, bricks: Sequence[LdrawBrick]) -> str:
    """Return a model, with a step of building for each level. Raises NoPartError."""
    others = [brick.name for brick in bricks if brick.kind is None]
    if others:
        message = f"{names_text(others)}: no LEGO brick or plate of the catalogue has this size; "
        raise NoPartError(f"{message}only such bricks have LDraw parts, see docs/language.md, Bricks with studs")
    lines = [f"0 {title}", f"0 Name: {title}.ldr"]
    ordered = sorted(bricks, key=lambda brick: brick.level)
    for before, brick in zip((None, *ordered), ordered, strict=False):
        if before is not None and before.level != brick.level:
            lines.append("0 STEP")
        lines.append(_line(brick))
    return "\n".join([*lines, "0 STEP"]) + "\n"


def _line(brick: LdrawBrick) -> str:
    part = LEGO[str(brick.kind)]
    top_W = add(brick.pose.position_W, rotate(brick.pose.orientation, (0.0, 0.0, 0.5 * part.size[2])))
    x, y, z = (length / float(UNIT) for length in top_W)
    along_W, across_W, up_W = body_axes(brick.pose.orientation)
    # Both frames are right-handed: x, y, z of LDraw are x, -z, y of the scene.
    columns = [(axis[0], -axis[2], axis[1]) for axis in (along_W, scale(-1.0, up_W), across_W)]
    rotation = [row for rows in zip(*columns, strict=True) for row in rows]
    numbers = " ".join(_digits(number) for number in (x, -z, y, *rotation))
    return f"1 {COLOURS[(brick.level - 1) % len(COLOURS)]} {numbers} {part.ldraw[0]}.dat"


def _digits(number: float) -> str:
    return f"{round(number, DIGITS) + 0.0:.{DIGITS}f}".rstrip("0").rstrip(".")
