"""Reads structures of LEGO bricks of research programs: StableLego, APEX-MR and BrickGPT.

All count x and y in studs and z in bricks. A brick has its lowest cell at x, y; its two extents in studs are `height`
along x and `width` along y, and exchanged if `ori` is 1.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Final

from stackdsl.diagnostics import Span, page_of
from stackdsl.importers.load import ImportedBox, ImportedLoad, LoadReading
from stackdsl.importers.text_positions import JsonText, Node, Numeral, UnitReader, json_text
from stackdsl.language.lego import LEGO, PITCH, PLATE, PLATES, LegoPart
from stackdsl.language.yaml.source import BOM, decoded

FURTHEST: Final = 10_000  # studs or bricks
# The bricks of both libraries by number, as kinds of the catalogue. Their masses differ by up to 7 %.
_IDS: Final[Mapping[str, str]] = {
    "2": "lego_2x4",
    "3": "lego_2x6",
    "4": "lego_1x8",
    "5": "lego_1x4",
    "6": "lego_1x6",
    "9": "lego_1x2",
    "10": "lego_1x1",
    "12": "lego_2x2",
}
_WEIGHT_ID: Final = "1"  # of StableLego: a weight of 0.2 kg on 2 x 2 studs
_WEIGHT: Final = Fraction(1, 5)  # [kg]
_OF_ROBOTS: Final = {
    *("press_side", "press_offset", "press_x", "press_y", "press_z", "press_ori", "manipulate_type", "attack_dir"),
    *("support_x", "support_y", "support_z", "support_ori", "brick_seq"),
}
_LINE: Final = re.compile(r"(\d{1,6})x(\d{1,6}) \((\d{1,6}),(\d{1,6}),(\d{1,6})\)", re.ASCII)


def of_studs(studs: tuple[int, int]) -> str | None:
    """Return the brick of the catalogue with these numbers of studs, in any order; None if there is none."""
    length, width = max(studs), min(studs)
    name = f"lego_{width}x{length}"
    return name if name in LEGO else None


def lego_box(name: str, kind: str, at: Sequence[Fraction], turned: bool, span: Span) -> ImportedBox:
    """Return a brick of the catalogue whose lowest corner is at a place [m]."""
    part = LEGO[kind]
    return _box(name, part.exact_size, at, turned, part.mass, span, kind)


def _box(  # noqa: PLR0913, PLR0917 -- all about one brick
    name: str,
    size: tuple[Fraction, Fraction, Fraction],
    at: Sequence[Fraction],
    turned: bool,
    mass: Fraction,
    span: Span,
    kind: str | None,
) -> ImportedBox:
    extent = (size[1], size[0], size[2]) if turned else size
    x, y, z = (low + side / 2 for low, side in zip(at, extent, strict=True))
    turn = (Fraction(0), Fraction(0), Fraction(90 if turned else 0))
    return ImportedBox(name, size, (x, y, z), mass, span, turn, kind=kind, has_studs=True)


def _on_plate(boxes: Sequence[ImportedBox | None], reading: LoadReading) -> ImportedLoad:
    return replace(reading.load([box for box in boxes if box is not None]), on_base_plate=True)


# Lines of BrickGPT, such as `2x4 (3,0,1)`: the extents along x and y, and the place.


def read_brickgpt(reading: LoadReading) -> ImportedLoad:
    """Read the bricks of a file with one line for each. Raises UnreadableLoadError."""
    boxes: list[ImportedBox | None] = []
    for number, line in enumerate(reading.page.lines):
        text = line.strip()
        if text:
            boxes.append(_of_line(text, len(boxes) + 1, reading, reading.page.span(number, line.index(text[0]))))
    return _on_plate(boxes, reading)


def _of_line(text: str, number: int, reading: LoadReading, span: Span) -> ImportedBox | None:
    match = _LINE.fullmatch(text)
    if match is None:
        reading.wrong(span, "the line is not a brick", "write each brick as `2x4 (0,0,0)`: extents, then x, y, z")
        return None
    along, across, *place = map(int, match.groups())
    kind = of_studs((along, across))
    if kind is None:
        sizes = ", ".join(f"{part.studs[1]}x{part.studs[0]}" for part in LEGO.values() if part.plates == PLATES)
        reading.wrong(span, f"there is no brick of {along}x{across} studs in the catalogue", f"use one of {sizes}")
        return None
    if max(place) > FURTHEST:
        reading.wrong(span, f"the place is further than {FURTHEST} studs", "correct it")
        return None
    return lego_box(f"brick-{number}", kind, _metres(place), along < across, span)


def _metres(place: Sequence[int]) -> tuple[Fraction, Fraction, Fraction]:
    return place[0] * PITCH, place[1] * PITCH, place[2] * PLATES * PLATE


# JSON of StableLego, and of the tasks of APEX-MR: an object of bricks by number.


def read_stablelego(reading: LoadReading, library: str | None, lowest: int | None = 0) -> ImportedLoad:
    """Read the bricks of a structure. Raises UnreadableLoadError.

    `lowest` is the z of bricks on the base plate; None for that of the lowest brick.
    """
    json = json_text(reading)
    pieces = _library(reading, library) if library is not None else None
    bricks = json.mapping(json.root, "the structure")
    read = [(name, node, _placed(json, name, node)) for name, node in bricks.items()]
    if lowest is None:
        lowest = min((placed[2] for _, _, placed in read if placed is not None), default=0)
    boxes: list[ImportedBox | None] = []
    for name, node, placed in read:
        if placed is not None:
            x, y, z, along_x, piece = placed
            boxes.append(_piece(json, f"brick-{name}", node, (x, y, z - lowest), along_x, piece, pieces))
    return _on_plate(boxes, reading)


def _placed(json: JsonText, name: str, node: Node) -> tuple[int, int, int, bool, str] | None:
    """Return the place of a brick, whether `width`, the longer extent, is along x, and its number in the library."""
    label = f"brick '{name}'"
    members = json.mapping(node, label)
    json.skip_others(members, {"x", "y", "z", "ori", "brick_id"}, _OF_ROBOTS)
    values: list[int] = []
    for key, most in (("x", FURTHEST), ("y", FURTHEST), ("z", FURTHEST), ("ori", 1), ("brick_id", FURTHEST)):
        member = json.member(node, members, key, label)
        number = _whole(json, member, key, most) if member is not None else None
        if number is None:
            return None
        values.append(number)
    x, y, z, ori, piece = values
    if not re.fullmatch(r"[0-9A-Za-z_.-]{1,58}", name):
        json.reading.wrong(json.span(node), "the number of the brick is no word", "use digits, as in '12'")
        return None
    return x, y, z, ori == 1, str(piece)


def _whole(json: JsonText, node: Node, key: str, most: int) -> int | None:
    if isinstance(node.value, Numeral) and re.fullmatch(r"[0-9]{1,6}", node.value.text):
        number = int(node.value.text)
        if number <= most:
            return number
    json.reading.wrong(json.span(node), f"`{key}` must be a whole number from 0 to {most}", "correct it")
    return None


def _piece(  # noqa: PLR0913, PLR0917 -- all about one brick
    json: JsonText,
    name: str,
    node: Node,
    place: Sequence[int],
    along_x: bool,
    piece: str,
    pieces: Mapping[str, LegoPart | None] | None,
) -> ImportedBox | None:
    """Return a brick with its longer extent along x or along y."""
    at, span = _metres(place), json.span(node)
    if pieces is not None:
        if piece not in pieces:
            json.reading.wrong(span, f"the library has no brick {piece}", "add it to the library")
        if (part := pieces.get(piece)) is None:
            return None
        return _box(name, part.exact_size, at, not along_x, part.mass, span, None)
    if piece == _WEIGHT_ID:
        return _box(name, LEGO["lego_2x2"].exact_size, at, False, _WEIGHT, span, None)
    if piece not in _IDS:
        known = ", ".join((_WEIGHT_ID, *_IDS))
        message = f"the number {piece} is not one of the published bricks"
        json.reading.undetermined(span, message, f"use one of {known}, or name the file of your bricks under `library`")
        return None
    return lego_box(name, _IDS[piece], at, not along_x, span)


def _library(reading: LoadReading, library: str) -> Mapping[str, LegoPart | None]:
    """Return the sizes and masses of bricks by number; None for invalid ones, which are reported."""
    data = reading.bytes_beside(library, reading.page.span(0, 0))
    reading.end()
    text = decoded(data, library)
    if not isinstance(text, str):
        reading.wrong(text.span, text.message, text.hint)
        reading.end()
        return {}
    own = replace(reading, page=page_of(text.removeprefix(BOM), library))
    json = json_text(own)
    units = UnitReader(own, Fraction(1))
    parts: dict[str, LegoPart | None] = {}
    for piece, node in json.mapping(json.root, "the library").items():
        label = f"brick '{piece}'"
        members = json.mapping(node, label)
        json.skip_others(members, {"height", "width", "mass", "weight"}, {"inventory", "partID"})
        studs = [
            _whole(json, member, key, 100)
            for key in ("height", "width")
            if (member := json.member(node, members, key, label)) is not None
        ]
        key = "weight" if "weight" in members else "mass"
        mass = units.mass_of(json, json.member(node, members, key, label), f"`{key}` of {label}")
        parts[piece] = None
        if mass is not None and len(studs) == 2:  # noqa: PLR2004 -- both extents
            height, width = studs
            if height is None or width is None or not 0 < height <= width:
                if height is not None and width is not None:
                    own.wrong(json.span(node), f"{label}: `height` must be 1 to `width`", "exchange both extents")
                continue
            parts[piece] = LegoPart((width, height), PLATES, mass, ())
    reading.mistakes[:] = own.mistakes
    reading.end()
    return parts
