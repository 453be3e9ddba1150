"""Reads convex solids from OBJ files and COMPAS assemblies."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import Final

from stability.geometry.convex_solid import NotASolidError
from stability.geometry.vectors import subtract
from stackdsl.diagnostics import Span
from stackdsl.importers.load import Exact3, ImportedBox, ImportedLoad, LoadReading
from stackdsl.importers.text_positions import IN_METRES, JsonText, Node, Numeral, UnitReader, json_text
from stackdsl.language.bricks import corner_number
from stackdsl.language.imports import Import
from stackdsl.language.value_types import NAME

# Convex solids from the corners and faces of meshes, and what files of meshes leave open.
#
# Such files say neither in which unit their lengths are nor how heavy their blocks are, so the author does.


LONGEST_NAME: Final = 64  # [characters]
LEAST_CORNERS: Final = 3  # of a face
EVEN: Final = 1e-5  # of a size: a centre of mass as near to that of an even filling is that


@dataclass(frozen=True, slots=True)
class ImportedMesh:
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
    mesh: ImportedMesh,
    density: Fraction = Fraction(1),
    mass: Fraction | None = None,
    heavy_at: Exact3 | None = None,
) -> ImportedBox | None:
    """A mesh as a brick, if it is a convex solid; told and None if it is not.

    `mass` [kg] in place of the density [kg/m3]; `heavy_at` is the centre of mass, by default that of an even filling.
    """
    from stability.geometry.solid_making import solid_of_mesh  # noqa: PLC0415 -- boxes do without scipy

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


# OBJ files as 3D programs export them: each object (`o`), or each group (`g`) where there are no objects, is a brick.
#
# Lengths have no unit, no axis is said to point up, and nothing says how heavy anything is: the author does. Of what
# says nothing of statics, normals, textures and materials are passed over.


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
    lines = _Lines(reading, UnitReader(reading, metre), asked.up == "+y")
    lines.read()
    reading.end()
    made = [solid_brick(reading, mesh, density) for mesh in lines.meshes()]
    return reading.load([brick for brick in made if brick is not None])


class _Lines:
    """Reads one line after the other."""

    def __init__(self, reading: LoadReading, measures: UnitReader, y_is_up: bool) -> None:
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

    def meshes(self) -> list[ImportedMesh]:
        """What was read, but for what is to be ignored and what has no faces."""
        found = []
        for part in self._parts.values():
            if part.name in self._reading.ignored:
                self._reading.leave(part.name, part.span, known=False)
            elif part.faces:
                found.append(ImportedMesh(part.name, *merged(self._corners, part.faces), part.span))
            else:
                self._reading.leave(f"{part.name}, which has no faces", part.span, known=True)
        return found


# Assemblies of COMPAS 2, as `compas_assembly` and `compas_cra` write them: a graph whose nodes are blocks.
#
# The blocks are at `data.graph.data.node`, each a mesh at `block.data` with the corners `vertex` and the faces `face`.
# A node may be a support, which nothing moves. Interfaces that a file may have are not taken: contacts are found anew.


_OF_OBJECT: Final = {"data", "dtype", "guid"}
# What the format has for its own use; what is not listed here is named.
_OF_ASSEMBLY: Final = {"graph", "attributes"}
_DEFAULTS: Final = {"default_node_attributes", "default_edge_attributes", "default_face_attributes"}
_OF_GRAPH: Final = {"node", "attributes", "adjacency", "max_node", *_DEFAULTS}
_OF_MESH: Final = {*{"vertex", "face", "attributes", "default_vertex_attributes", "max_vertex", "max_face"}, *_DEFAULTS}


def read_compas(reading: LoadReading, asked: Import) -> ImportedLoad:
    """The blocks of an assembly, in the order of its nodes. Raises UnreadableLoadError."""
    metre, density = metre_of(reading, asked), density_of(reading, asked)
    json = json_text(reading)
    assembly = _data(json, json.root, "the assembly")
    nodes: dict[str, Node] = {}
    if assembly is not None:
        members = json.mapping(assembly, "`data`")
        json.pass_over(members, _OF_ASSEMBLY, set())
        graph = json.member(assembly, members, "graph", "`data` of the assembly")
        held = _data(json, graph, "the graph") if graph else None
        if held is not None:
            of_graph = json.mapping(held, "`data` of the graph")
            _pass_over(json, of_graph, _OF_GRAPH, {"edge": "interfaces"})
            node = json.member(held, of_graph, "node", "`data` of the graph")
            nodes = json.mapping(node, "`node`") if node else {}
    blocks = _Blocks(json, UnitReader(reading, metre), asked)
    meshes = list(blocks.meshes(nodes))
    reading.end()
    made = [solid_brick(reading, mesh, density) for mesh in meshes]
    return reading.load([brick for brick in made if brick is not None])


def _data(json: JsonText, node: Node, what: str) -> Node | None:
    """What an object of COMPAS holds; told and None if it is none."""
    members = json.mapping(node, what)
    json.pass_over(members, _OF_OBJECT, set())
    return json.member(node, members, "data", what)


def _pass_over(json: JsonText, owner: Mapping[str, Node], taken: set[str], besides: Mapping[str, str]) -> None:
    """Say of all other members that they are not taken; of `besides`, which say nothing of statics, if they say it."""
    for key, node in owner.items():
        said = node.value.values() if isinstance(node.value, dict) else [node]
        if key not in besides and key not in taken:
            json.reading.leave(key, json.span(node), known=False)
        elif key in besides and any(each.value for each in said):
            json.reading.leave(besides[key], json.span(node), known=True)


class _Blocks:
    """Reads the blocks of a graph."""

    def __init__(self, json: JsonText, measures: UnitReader, asked: Import) -> None:
        self._json, self._measures, self._asked = json, measures, asked

    def meshes(self, nodes: Mapping[str, Node]) -> Iterator[ImportedMesh]:
        """The mesh of each node; those that are mistaken are told and left out."""
        names: dict[str, Node] = {}
        for key, node in nodes.items():
            name = brick_name(f"block-{key}", "block")
            if name in self._json.reading.ignored:
                self._json.reading.leave(name, self._json.span(node), known=False)
                continue
            if name in names:
                self._wrong(node, f"two nodes come to the name '{name}'", "call them apart")
            names[name] = node
            members = self._json.mapping(node, "the node")
            self._json.pass_over(members, {"block", "is_support"}, {"section", "mesh_size"})
            self._ask_for_supports(name, members.get("is_support"))
            block = self._json.member(node, members, "block", "the node")
            held = _data(self._json, block, "the block") if block else None
            mesh = self._mesh(name, node, held) if held is not None else None
            if mesh is not None:
                yield mesh

    def _ask_for_supports(self, name: str, said: Node | None) -> None:
        if said is None or said.value in (False, None):
            return
        if said.value is not True:
            self._wrong(said, "`is_support` is neither true nor false", "write true or false")
        elif self._asked.supports is None:
            message = f"'{name}' is a support, which nothing moves in COMPAS, and here every block may move"
            hint = "to take supports as bricks write `supports: bricks`: what stands on these stands on fixed ones, too"
            self._json.reading.open(self._json.span(said), message, hint)

    def _mesh(self, name: str, node: Node, held: Node) -> ImportedMesh | None:
        json = self._json
        members = json.mapping(held, "`data` of the block")
        _pass_over(json, members, _OF_MESH, {"facedata": "facedata", "edgedata": "edgedata"})
        vertices = json.member(held, members, "vertex", "`data` of the block")
        faces = json.member(held, members, "face", "`data` of the block")
        if vertices is None or faces is None:
            return None
        defaults = members.get("default_vertex_attributes")
        usual = json.mapping(defaults, "`default_vertex_attributes`") if defaults else {}
        corners = {key: self._corner(each, usual) for key, each in json.mapping(vertices, "`vertex`").items()}
        places = {key: place for place, key in enumerate(corners)}
        loops = [self._loop(face, places) for face in json.mapping(faces, "`face`").values()]
        known = [corner for corner in corners.values() if corner is not None]
        if len(known) < len(corners) or None in loops:
            return None
        return ImportedMesh(name, known, [loop for loop in loops if loop is not None], json.span(node))

    def _corner(self, node: Node, usual: Mapping[str, Node]) -> Exact3 | None:
        members = self._json.mapping(node, "the corner")
        self._json.pass_over(members, {"x", "y", "z"}, set())
        full = {**{axis: usual[axis] for axis in "xyz" if axis in usual}, **members}
        parts = [self._json.member(node, full, axis, "the corner") for axis in "xyz"]
        return self._measures.places(self._json, parts, "the corner")

    def _loop(self, face: Node, places: Mapping[str, int]) -> tuple[int, ...] | None:
        """A face as places among the corners of its block."""
        found: list[int] = []
        for node in self._json.items(face, "the face"):
            key = node.value.text if isinstance(node.value, Numeral) else node.value
            if not isinstance(key, str) or key not in places:
                self._wrong(node, "the face names a corner that the block does not have", "mend the face")
                return None
            found.append(places[key])
        if len(found) < 3 or len(set(found)) < len(found):  # noqa: PLR2004 -- a triangle
            self._wrong(face, "the face has fewer than three corners, or one twice", "mend the face")
            return None
        return tuple(found)

    def _wrong(self, node: Node, message: str, hint: str) -> None:
        self._json.reading.wrong(self._json.span(node), message, hint)
