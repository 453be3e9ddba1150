"""Reads the surfaces in STL and PLY files, as text or binary. Both state no unit of length.

The files are untrusted: counts are compared with the size of the file before anything is read, and coordinates are
returned as written, in the fewest digits that distinguish a binary number.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import isfinite
from pathlib import PurePath
from struct import Struct
from typing import TYPE_CHECKING, Final, TypeAlias

if TYPE_CHECKING:
    import numpy as np

MESH_SUFFIXES: Final = (".stl", ".ply")
MOST_FACES: Final = 100_000  # of a file, and corners and other elements likewise
LONGEST_HEADER: Final = 1 << 16  # [bytes] of a PLY file
MOST_LINES: Final = 8 * MOST_FACES  # of a text file; a triangle of STL takes seven
LEAST_CORNERS: Final = 3  # of a face
MOST_CORNERS: Final = 255  # of a face
_LONGEST_TOLD: Final = 40  # [characters] of a word in a message

Written3: TypeAlias = tuple[str, str, str]  # coordinates as written


class MeshFileError(ValueError):
    """A file that is no mesh: the message, the remedy, and the line from 1; 0 for a binary file."""

    def __init__(self, message: str, hint: str, line: int = 0) -> None:
        super().__init__(message)
        self.message, self.hint, self.line = message, hint, line


@dataclass(slots=True)
class Surface:
    """A surface of a file: its name, its corners as written, and its faces as indices of corners."""

    name: str
    line: int  # where it begins; 0 in a binary file
    corners: list[Written3] = field(default_factory=list)
    faces: list[tuple[int, ...]] = field(default_factory=list)

    def pieces(self) -> Iterator["Surface"]:
        """Yield its closed pieces: the shortest runs of faces in which each edge has its opposite.

        The last piece may be open. The faces of a body stand together in files, so that bodies that touch are apart.
        """
        numbers: dict[Written3, int] = {}
        same = [numbers.setdefault(corner, len(numbers)) for corner in self.corners]
        begun, unpaired = 0, Counter[tuple[int, int]]()
        for index, face in enumerate(self.faces):
            for edge in pairwise((*(loop := [same[corner] for corner in face]), loop[0])):
                if edge[0] != edge[1]:
                    opposite = (edge[1], edge[0])
                    if opposite not in unpaired:
                        unpaired[edge] += 1
                    elif unpaired[opposite] == 1:
                        del unpaired[opposite]
                    else:
                        unpaired[opposite] -= 1
            if not unpaired:
                yield Surface(self.name, self.line, self.corners, self.faces[begun : index + 1])
                begun = index + 1
        if begun < len(self.faces):
            yield Surface(self.name, self.line, self.corners, self.faces[begun:])


def is_binary_mesh(data: bytes, kind: str) -> bool:
    """Return whether a file is binary, of a given kind (`stl`, `ply` or another), by its header and its length."""
    head = data[:LONGEST_HEADER]
    if kind == "stl":
        return not _is_text_stl(data)
    return re.match(rb"ply\r?\n(?:(?:comment|obj_info)[^\n]*\n)*format binary_", head) is not None or _is_binary_stl(
        data
    )


def surfaces_of(data: bytes, kind: str) -> list[Surface]:
    """Return the surfaces of a file of kind `stl` or `ply`. Raises MeshFileError."""
    return _stl(data) if kind == "stl" else _ply(data)


def mesh_kind(file: str) -> str:
    """Return `stl` or `ply` by the ending of a file name; empty for others."""
    suffix = PurePath(file).suffix.lower()
    return suffix[1:] if suffix in MESH_SUFFIXES else ""


def whole_mesh(data: bytes, kind: str) -> tuple[list[tuple[float, float, float]], list[tuple[int, ...]]]:
    """Return all corners and faces of a file, corners at one place merged. Raises MeshFileError."""
    numbers: dict[tuple[float, float, float], int] = {}
    loops: list[tuple[int, ...]] = []
    for surface in surfaces_of(data, kind):
        places = [_floats(corner, surface.line) for corner in surface.corners]
        for face in surface.faces:
            loop = tuple(dict.fromkeys(numbers.setdefault(places[corner], len(numbers)) for corner in face))
            if len(loop) >= LEAST_CORNERS:
                loops.append(loop)
    return list(numbers), loops


def _floats(corner: Written3, line: int) -> tuple[float, float, float]:
    x, y, z = (_number(part, line) for part in corner)
    return (x, y, z)


def _number(part: str, line: int) -> float:
    try:
        number = float(part)
    except ValueError:
        number = float("nan")
    if not isfinite(number) or not part.isascii() or "_" in part:
        raise MeshFileError(f"{_told(part)} is not a number", "write digits, with a decimal point", line)
    return number


def _told(word: str) -> str:
    return f"'{word if len(word) <= _LONGEST_TOLD else word[:_LONGEST_TOLD] + '...'}'"


def _shortest(numbers: "Iterable[np.float32]") -> list[str]:
    """Return numbers of single precision in the fewest digits that distinguish them, as numpy prints them."""
    return [str(number) for number in numbers]


def _admit_count(count: int, noun: str, line: int = 0) -> None:
    if count > MOST_FACES:
        raise MeshFileError(f"the file has {count} {noun}; the maximum is {MOST_FACES}", "simplify the mesh", line)


# STL: triangles. A text file has named solids of facets; a binary one has 80 bytes of header, the number of triangles,
# and 50 bytes a triangle: its normal, its three corners, and 2 bytes of attributes.


_HEADER: Final = 84  # [bytes]
_TRIANGLE: Final = 50  # [bytes]


def _announced(data: bytes) -> int:
    return int.from_bytes(data[80:_HEADER], "little") if len(data) >= _HEADER else -1


def _is_binary_stl(data: bytes) -> bool:
    return len(data) == _HEADER + _announced(data) * _TRIANGLE and b"\0" in data


def _is_text_stl(data: bytes) -> bool:
    return not _is_binary_stl(data) and data[:_LONGEST_TOLD].lstrip()[:5].lower() == b"solid"


def _stl(data: bytes) -> list[Surface]:
    if _is_text_stl(data):
        solids = [each for each in _facets(data.decode("utf-8", "replace")) if each.faces]
        if not solids:
            raise MeshFileError("the file has no triangles", "export the solid again", 1)
        return solids
    count = _announced(data)
    needed = _HEADER + count * _TRIANGLE
    if count < 0 or len(data) != needed:
        told = (
            f"announces {count} triangles, which take {needed}" if count >= 0 else "a binary STL file has at least 84"
        )
        message = f"the file has {len(data)} bytes, but {told}"
        raise MeshFileError(message, "export the file again; a text file begins with `solid`")
    _admit_count(count, "triangles")
    import numpy as np  # noqa: PLC0415 -- scenarios of boxes start without

    layout = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
    triangles = np.frombuffer(data, layout, count, _HEADER)["corners"].reshape(-1, 3) + np.float32(0.0)  # no -0.0
    places, index = np.unique(triangles.view("V12").ravel(), return_inverse=True)
    texts = _shortest(places.view("<f4"))
    surface = Surface("", 0)
    surface.corners = list(zip(texts[0::3], texts[1::3], texts[2::3], strict=True))
    surface.faces = [tuple(loop) for loop in index.reshape(-1, 3).tolist()]
    if not surface.faces:
        raise MeshFileError("the file has no triangles", "export the solid again")
    return [surface]


# The keywords that are permitted after a line of a text file, by its keyword.
_NEXT: Final = {
    "solid": ("facet", "endsolid"),
    "facet": ("outer",),
    "outer": ("vertex",),
    "vertex": ("vertex",),
    "endloop": ("endfacet",),
    "endfacet": ("facet", "endsolid"),
    "endsolid": ("solid",),
}


def _facets(text: str) -> list[Surface]:
    """Return the solids of a text file."""
    lines = re.split("\r\n|\r|\n", text)  # as the lines of other files are counted
    if len(lines) > MOST_LINES:
        raise MeshFileError(f"the file has {len(lines)} lines; the maximum is {MOST_LINES}", "simplify the mesh")
    surfaces: list[Surface] = []
    expected: tuple[str, ...] = ("solid",)
    for number, words in ((number, line.split()) for number, line in enumerate(lines, start=1) if line.strip()):
        word = words[0].lower()
        if word not in expected:
            hint = f"write {' or '.join(f'`{each}`' for each in expected)}, or export the file again"
            raise MeshFileError(f"{_told(words[0])} stands where {expected[0]} must follow", hint, number)
        expected = _NEXT[word]
        if word == "solid":
            surfaces.append(Surface(" ".join(words[1:]), number))
        elif word == "vertex":
            surfaces[-1].corners.append(_vertex(words[1:], number))
            expected = expected if len(surfaces[-1].corners) % 3 else ("endloop",)
        elif word == "endfacet":
            last = len(surfaces[-1].corners)
            surfaces[-1].faces.append((last - 3, last - 2, last - 1))
    if expected != ("solid",):
        raise MeshFileError("the file ends within a solid", "export the file again", len(lines))
    return surfaces


def _vertex(parts: Sequence[str], line: int) -> Written3:
    if len(parts) != 3:  # noqa: PLR2004 -- x, y, z
        message = f"the corner has {len(parts)} numbers instead of three"
        raise MeshFileError(message, "write, for example, `vertex 0.1 0 0.05`", line)
    for part in parts:
        _number(part, line)
    x, y, z = parts
    return (x, y, z)


# PLY: a header that lists elements with their numbers and properties, and the elements, as text or binary.


_TYPES: Final = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"float": "f4", "double": "f8"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float32": "f4", "float64": "f8"},
}
_STRUCT: Final = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
_ORDERS: Final = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
MOST_NAMES: Final = 100  # of elements, and of properties of an element
_AS_ANNOUNCED: Final = "correct the numbers of elements, or export the file again"
_FACES: Final = ("vertex_indices", "vertex_index")


@dataclass(frozen=True, slots=True)
class _Property:
    name: str
    type: str  # of the value, or of the items of a list
    count: str = ""  # type of the length of a list; empty for a number


@dataclass(slots=True)
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)

    def has_numbers(self, names: Sequence[str]) -> bool:
        return {*names} <= {each.name for each in self.properties if not each.count}


_Record: TypeAlias = dict[str, list[str]]  # values as written, by property
_Records: TypeAlias = Callable[[_Element], Iterator[tuple[int, _Record]]]  # each with its line
_END: Final = _Element("end of the file", 0)  # of which no records follow


def _ply(data: bytes) -> list[Surface]:
    end = re.search(rb"^end_header[ \t]*\r?\n", data[:LONGEST_HEADER], re.MULTILINE)
    if not data.startswith((b"ply\n", b"ply\r\n")) or end is None:
        message = "the file does not begin with `ply` and a header that ends with `end_header`"
        raise MeshFileError(message, "export the file again", 1)
    lines = [line.strip() for line in data[: end.end()].decode("latin-1").split("\n")[:-1]]
    order, elements = _header(lines)
    body = data[end.end() :]
    records = _text_records(body, len(lines)) if not order else _binary_records(body, order)
    surface = Surface("", 0 if order else 1)
    for element in elements:
        is_face = element.name == "face"
        if element.name == "vertex" and not element.has_numbers("xyz"):
            raise MeshFileError("the vertices have no `x`, `y` and `z`", "export the file again", 1)
        listed = next((each.name for each in element.properties if each.name in _FACES and each.count), "")
        if is_face and not listed:
            raise MeshFileError("the faces have no list `vertex_indices`", "export the file again", 1)
        for line, record in records(element):
            if element.name == "vertex":
                (x,), (y,), (z,) = (record[axis] for axis in "xyz")
                for part in (x, y, z):
                    _number(part, line)
                surface.corners.append((x, y, z))
            elif is_face:
                surface.faces.append(_face(record[listed], len(surface.corners), line))
    next(records(_END), None)
    if not surface.faces:
        raise MeshFileError("the file has no faces", "export the solid as a mesh with faces", 0 if order else 1)
    return [surface]


def _face(written: Sequence[str], corners: int, line: int) -> tuple[int, ...]:
    if not LEAST_CORNERS <= len(written) <= MOST_CORNERS:
        message = f"a face has {len(written)} corners; it must have {LEAST_CORNERS} to {MOST_CORNERS}"
        raise MeshFileError(message, "correct the face", line)
    loop = [int(part) if re.fullmatch(r"[0-9]{1,9}", part) else -1 for part in written]
    if not all(0 <= corner < corners for corner in loop):
        message = f"a face refers to a corner that is not among the {corners} corners above it"
        raise MeshFileError(message, f"write numbers from 0 to {corners - 1}", line)
    return tuple(loop)


def _header(lines: Sequence[str]) -> tuple[str, list[_Element]]:
    order: str | None = None
    elements: list[_Element] = []
    for number, line in enumerate(lines, start=1):
        match line.split():
            case ["ply"] | ["end_header"] | ["comment" | "obj_info", *_] | []:
                pass
            case ["format", written, "1.0"] if written in _ORDERS:
                order = _ORDERS[written]
            case ["element", name, count] if re.fullmatch(r"[0-9]{1,12}", count):
                _admit_count(int(count), f"elements `{name[:_LONGEST_TOLD]}`", number)
                elements.append(_Element(name, int(count)))
            case ["property", *words] if elements and (written_property := _property(words)) is not None:
                elements[-1].properties.append(written_property)
            case _:
                hint = "write `format`, `element NAME COUNT`, `property TYPE NAME` or a comment"
                raise MeshFileError(f"the line {_told(line)} is not of the header of a PLY file", hint, number)
    if order is None:
        raise MeshFileError("the header has no line `format`", "write `format ascii 1.0`, or export the file again", 1)
    for noun, names in (
        ("header", [element.name for element in elements]),
        *((f"element {_told(each.name)}", [one.name for one in each.properties]) for each in elements),
    ):
        if not 0 < len(set(names)) == len(names) <= MOST_NAMES:
            message = f"the {noun} has no entry, an entry twice, or more than {MOST_NAMES}"
            raise MeshFileError(message, "export the file again", 1)
    return order, elements


def _property(words: Sequence[str]) -> _Property | None:
    match words:
        case ["list", count, of, name] if {count, of} <= _TYPES.keys() and _TYPES[count][0] in "iu":
            return _Property(name, _TYPES[of], _TYPES[count])
        case [of, name] if of in _TYPES:
            return _Property(name, _TYPES[of])
    return None


def _text_records(body: bytes, above: int) -> _Records:
    """Return a function that yields the records of an element, one a line."""
    lines = iter(
        [
            (number, words)
            for number, line in enumerate(body.decode("utf-8", "replace").split("\n"), start=above + 1)
            if (words := line.split())
        ]
    )
    last = above + max(body.count(b"\n"), 1)

    def records(element: _Element) -> Iterator[tuple[int, _Record]]:
        if element is _END and (further := next(lines, None)) is not None:
            raise MeshFileError("the file has more lines than its header announces", _AS_ANNOUNCED, further[0])
        for index in range(element.count):
            number, words = next(lines, (last, None))
            if words is None:
                message = f"the file has {index} elements `{element.name}`, but announces {element.count}"
                raise MeshFileError(message, "export the file again", number)
            record, at = dict[str, list[str]](), 0
            for each in element.properties:
                length = 1
                if each.count:
                    length = int(words[at]) if at < len(words) and re.fullmatch(r"[0-9]{1,6}", words[at]) else -1
                    at += 1
                record[each.name] = words[at : at + max(length, 0)]
                at += max(length, 0)
                if length < 0 or at > len(words):
                    break
            if at != len(words) or len(record) < len(element.properties):
                message = f"the line does not have the properties of `{element.name}`"
                names = ", ".join(each.name[:_LONGEST_TOLD] for each in element.properties[:10])
                raise MeshFileError(message, f"write {names}", number)
            yield number, record

    return records


def _binary_records(body: bytes, order: str) -> _Records:
    """Return a function that yields the records of an element."""
    import numpy as np  # noqa: PLC0415 -- scenarios of boxes start without

    at = 0

    def unpacked(kind: str, count: int, element: _Element, index: int) -> list[str]:
        nonlocal at
        size = int(kind[1]) * count
        if at + size > len(body):
            message = f"the file ends within element {index + 1} of `{element.name}`, but announces {element.count}"
            raise MeshFileError(message, "export the file again")
        values = Struct(f"{order}{count}{_STRUCT[kind]}").unpack_from(body, at)
        at += size
        if kind == "f4":
            return _shortest([np.float32(value + 0.0) for value in values])
        return [repr(value + 0.0) if isinstance(value, float) else str(value) for value in values]

    def records(element: _Element) -> Iterator[tuple[int, _Record]]:
        if element is _END and body[at:].strip():
            raise MeshFileError(f"the file has {len(body) - at} bytes more than its header announces", _AS_ANNOUNCED)
        for index in range(element.count):
            record = dict[str, list[str]]()
            for each in element.properties:
                length = 1
                if each.count:
                    length = int(unpacked(each.count, 1, element, index)[0])
                    if not 0 <= length <= MOST_FACES:
                        raise MeshFileError(f"a list of `{element.name}` has {length} items", "export the file again")
                record[each.name] = unpacked(each.type, length, element, index)
            yield 0, record

    return records
