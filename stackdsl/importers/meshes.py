"""Reads solids from OBJ, STL and PLY files and from COMPAS assemblies.

None of the formats states the unit of length, and none gives masses, so the author does.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import chain, product
from typing import Final

from stability.geometry.compound import Compound
from stability.geometry.convex_solid import NotASolidError
from stability.geometry.placed_shape import corners_W
from stability.geometry.vectors import add, subtract
from stackdsl.diagnostics import Span
from stackdsl.importers.load import Exact3, ImportedBox, ImportedLoad, LoadReading, UnreadableLoadError
from stackdsl.importers.text_positions import IN_METRES, JsonText, Node, Numeral, UnitReader, json_text
from stackdsl.language.bricks import corner_number
from stackdsl.language.imports import Import
from stackdsl.language.mesh_files import MeshFileError, Surface, surfaces_of
from stackdsl.language.value_types import NAME

# Convex solids from the corners and faces of meshes, and the options that both formats need.


LONGEST_NAME: Final = 64  # [characters]
LEAST_CORNERS: Final = 3  # of a face
EVEN: Final = 1e-5  # share of a size: a centre of mass within it of the uniform solid's counts as equal


@dataclass(frozen=True, slots=True)
class ImportedMesh:
    """A solid of a file: corners [m], and faces as indices of corners, counter-clockwise seen from outside."""

    name: str
    corners: Sequence[Exact3]
    faces: Sequence[Sequence[int]]
    span: Span


def metre_of(reading: LoadReading, options: Import) -> Fraction:
    """Return the file's unit of length [m]; report it if the author has not set it."""
    unit = options.units.length if options.units is not None else None
    if unit is None:
        message = "the file does not state its unit of length"
        reading.undetermined(reading.page.span(0, 0), message, "set it, for example `units: {length: m}`")
    return IN_METRES[unit or "m"]


def density_of(reading: LoadReading, options: Import) -> Fraction:
    """Return the density of the blocks [kg/m3]; report it if the author has not set it."""
    if options.density is None:
        message = "the file does not give the masses of its blocks"
        reading.undetermined(reading.page.span(0, 0), message, "set their density, for example `density: 2400 kg/m3`")
    return Fraction(repr(options.density or 1.0))


def solid_brick(  # noqa: PLR0913 -- the data of formats
    reading: LoadReading,
    mesh: ImportedMesh,
    density: Fraction = Fraction(1),
    mass: Fraction | None = None,
    centre_of_mass: Exact3 | None = None,
    *,
    only_convex: bool = False,
) -> ImportedBox | None:
    """Return the brick of a mesh, in convex parts if it is not convex; report and return None unless it is a solid.

    With `only_convex` a solid that is not convex is a mistake, where the engine of a format replaces it by its hull.

    `mass` [kg] replaces the density [kg/m3]. The centre of mass defaults to that of a uniform solid.
    """
    from stability.geometry.convex_parts import body_of_mesh  # noqa: PLC0415 -- boxes do not need scipy
    from stability.geometry.solid_making import solid_of_mesh  # noqa: PLC0415 -- boxes do not need scipy

    make = solid_of_mesh if only_convex else body_of_mesh

    try:
        solid = make([_floats(corner) for corner in mesh.corners], mesh.faces)
    except NotASolidError as error:
        hint = f"{error.hint}; or, to ignore it, write `ignore: ['{mesh.name}']`"
        reading.wrong(mesh.span, f"'{mesh.name}': {error.message}", hint)
        return None
    used = dict.fromkeys(mesh.corners[corner] for face in mesh.faces for corner in face)
    lows, highs = zip(*((min(along), max(along)) for along in zip(*used, strict=True)), strict=True)
    centre = _exact3([(low + high) / 2 for low, high in zip(lows, highs, strict=True)])
    size = _exact3([high - low for low, high in zip(lows, highs, strict=True)])
    corners = None
    if set(used) != set(product(*zip(lows, highs, strict=True))):  # else it is an upright box, which may settle
        corners = tuple(_relative(corner, centre) for corner in used)
    parts = None
    if isinstance(solid.shape, Compound):
        parts = tuple(
            tuple(
                _relative(_exact3([*map(Fraction, add(solid.centre_of_mass, corner))]), centre)
                for corner in corners_W(part.shape, part.place)
            )
            for part in solid.shape.parts
        )
    if mass is None:
        mass = density * Fraction(solid.shape.volume)
    offset = None
    if centre_of_mass is not None:
        distances = map(abs, subtract(solid.centre_of_mass, _floats(centre_of_mass)))
        offset = _relative(centre_of_mass, centre) if max(distances) > EVEN * max(size) else None
    return ImportedBox(mesh.name, size, centre, mass, mesh.span, corners=corners, parts=parts, centre_of_mass=offset)


def merged(corners: Sequence[Exact3], faces: Sequence[Sequence[int]]) -> tuple[list[Exact3], list[tuple[int, ...]]]:
    """Merge corners at the same position, which files may list once per face, and a surface that is listed twice."""
    places: dict[Exact3, int] = {}
    loops = [tuple(places.setdefault(corners[corner], len(places)) for corner in face) for face in faces]
    solid = [loop for loop in (tuple(dict.fromkeys(loop)) for loop in loops) if len(loop) >= LEAST_CORNERS]
    times = Counter(map(_from_lowest, solid))
    if times and min(times.values()) > 1:
        solid = [*{_from_lowest(loop): loop for loop in reversed(solid)}.values()][::-1]
    return list(places), solid


def _from_lowest(loop: tuple[int, ...]) -> tuple[int, ...]:
    """Return a face from its lowest corner on, in the same direction."""
    start = loop.index(min(loop))
    return loop[start:] + loop[:start]


def brick_name(written: str, default: str) -> str:
    """Return the valid brick name nearest to the written one; `default` if nothing of it is valid."""
    plain = re.sub(r"[^A-Za-z0-9_.-]+", "-", written.strip()).strip("-")[:LONGEST_NAME]
    if not plain:
        return default
    return plain if re.fullmatch(NAME, plain) else f"{default.partition('-')[0]}-{plain}"[:LONGEST_NAME]


def _relative(point: Exact3, origin: Exact3) -> Exact3:
    return _exact3([part - start for part, start in zip(point, origin, strict=True)])


def _floats(corner: Exact3) -> tuple[float, float, float]:
    x, y, z = map(float, corner)
    return (x, y, z)


def _exact3(parts: Sequence[Fraction]) -> Exact3:
    x, y, z = parts
    return (x, y, z)


# OBJ files as 3D programs export them. Each object (`o`) is a brick, or each group (`g`) in a file without objects.
#
# The format states no unit of length, no upward axis and no masses, so the author does. Normals, textures and materials
# do not affect statics and are skipped.


_LOOKS: Final = {"vt", "vn", "usemtl", "mtllib", "s", "usemap", "maplib", "lod", "shadow_obj", "trace_obj"}
LEAST_PARTS: Final = 3  # coordinates of a corner, or corners of a face


@dataclass(slots=True)
class _Part:
    """The faces of one object or group."""

    name: str
    span: Span
    faces: list[tuple[int, ...]] = field(default_factory=list)  # indices of corners of the file


def read_obj(reading: LoadReading, options: Import) -> ImportedLoad:
    """Read the bricks of an OBJ file, in file order. Raises UnreadableLoadError."""
    metre, density = metre_of(reading, options), density_of(reading, options)
    lines = _ObjLines(reading, UnitReader(reading, metre), _y_is_up(reading, options, "an OBJ"))
    lines.read()
    reading.end()
    bricks = [solid_brick(reading, mesh, density) for mesh in lines.meshes()]
    return reading.load([brick for brick in bricks if brick is not None])


def _y_is_up(reading: LoadReading, options: Import, kind: str) -> bool:
    """Return whether y is the vertical axis; report it if the author has not set the axis."""
    if options.up is None:
        hint = "set `up: +z`, or `up: +y`, the default of Blender and others"
        reading.undetermined(reading.page.span(0, 0), f"{kind} file does not state which axis points up", hint)
    return options.up == "+y"


class _ObjLines:
    """Reads an OBJ file line by line."""

    def __init__(self, reading: LoadReading, units: UnitReader, y_is_up: bool) -> None:
        self._reading, self._units, self._y_is_up = reading, units, y_is_up
        self._named_by = "o" if any(line.split()[:1] == ["o"] for line in reading.page.lines) else "g"
        self._corners: list[Exact3] = []
        self._parts: dict[str, _Part] = {}
        self._part: _Part | None = None

    def read(self) -> None:
        """Read the whole file, and report its mistakes."""
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
            self._reading.skip(kind, span, harmless=kind in _LOOKS or kind == "g")

    def _begin(self, span: Span, written: str) -> None:
        name = brick_name(written, f"brick-{len(self._parts) + 1}")
        part = self._parts.setdefault(name, _Part(name, span))
        if part.span != span and part is not self._part and part.faces:
            kind = "objects" if self._named_by == "o" else "groups"
            self._reading.wrong(span, f"two {kind} have the name '{name}'", "give each a different name")
        self._part = part

    def _corner(self, span: Span, parts: Sequence[str]) -> Exact3 | None:
        if len(parts) < LEAST_PARTS:
            hint = "write, for example, `v 0.1 0 0.05`"
            self._reading.wrong(span, f"the corner has {len(parts)} numbers instead of three", hint)
            return None
        # Colours may follow the coordinates.
        x, y, z = [self._units.coordinate(part, span, "the corner") for part in parts[:LEAST_PARTS]]
        if x is None or y is None or z is None:
            return None
        return (x, -z, y) if self._y_is_up else (x, y, z)

    def _face(self, span: Span, parts: Sequence[str]) -> None:
        if self._part is None:
            self._begin(span, "")
        assert self._part is not None
        loop = [self._corner_index(part) for part in parts]
        valid = [index for index in loop if index is not None]
        if len(valid) < len(loop):
            hint = "write a face as `f 1 2 3`, with the numbers of preceding corners"
            self._reading.wrong(
                span, f"the face refers to a corner that is not among the {len(self._corners)} preceding corners", hint
            )
        elif len(loop) < LEAST_PARTS or len(set(valid)) < len(valid):
            self._reading.wrong(
                span, "the face has fewer than three corners, or contains a corner twice", "correct the face"
            )
        else:
            self._part.faces.append(tuple(valid))

    def _corner_index(self, part: str) -> int | None:
        """Return the index of a corner written as `3` or `3/1/2` (with texture and normal); -1 is the latest corner."""
        number = corner_number(part)
        if number is None:
            return None
        index = number - 1 if number > 0 else len(self._corners) + number
        return index if number != 0 and 0 <= index < len(self._corners) else None

    def meshes(self) -> list[ImportedMesh]:
        """Return the meshes of all parts, without the ignored ones and those without faces."""
        meshes = []
        for part in self._parts.values():
            if part.name in self._reading.ignored:
                self._reading.skip(part.name, part.span, harmless=False)
            elif part.faces:
                meshes.append(ImportedMesh(part.name, *merged(self._corners, part.faces), part.span))
            else:
                self._reading.skip(f"{part.name}, which has no faces", part.span, harmless=True)
        return meshes


# STL and PLY files. Each closed surface is a brick; those of an STL file have the name of their `solid`.


def read_stl(reading: LoadReading, options: Import) -> ImportedLoad:
    """Read the bricks of an STL file, in file order. Raises UnreadableLoadError."""
    return _read_surfaces(reading, options, "stl", "an STL")


def read_ply(reading: LoadReading, options: Import) -> ImportedLoad:
    """Read the bricks of a PLY file, in file order. Raises UnreadableLoadError."""
    return _read_surfaces(reading, options, "ply", "a PLY")


def _read_surfaces(reading: LoadReading, options: Import, kind: str, noun: str) -> ImportedLoad:
    metre, density = metre_of(reading, options), density_of(reading, options)
    y_is_up = _y_is_up(reading, options, noun)
    try:
        surfaces = surfaces_of(reading.data, kind)
    except MeshFileError as error:
        line = min(max(error.line, 1), len(reading.page.lines)) - 1
        reading.wrong(reading.page.span(line, 0), error.message, error.hint)
        raise UnreadableLoadError(reading.mistakes) from error
    reading.end()
    units = UnitReader(reading, metre)
    meshes: list[ImportedMesh] = []
    names: set[str] = set()
    for surface in surfaces:
        span = reading.page.span(max(surface.line, 1) - 1, 0)
        corners = _surface_corners(units, surface, span, y_is_up)
        pieces = list(surface.pieces())
        for number, piece in enumerate(pieces, start=1):
            written = f"{surface.name}-{number}" if surface.name and len(pieces) > 1 else surface.name
            name = brick_name(written, f"brick-{len(names) + 1}")
            if name in names:
                name = f"brick-{len(names) + 1}"
            names.add(name)
            if name in reading.ignored:
                reading.skip(name, span, harmless=False)
            else:
                meshes.append(ImportedMesh(name, *merged(corners, piece.faces), span))
    bricks = [solid_brick(reading, mesh, density) for mesh in meshes]
    return reading.load([brick for brick in bricks if brick is not None])


def _surface_corners(units: UnitReader, surface: Surface, span: Span, y_is_up: bool) -> list[Exact3]:
    """Return the corners of a surface [m]. Raises UnreadableLoadError."""
    lengths = {part: units.coordinate(part, span, "the corner") for part in dict.fromkeys(chain(*surface.corners))}
    units.reading.end()
    corners = [_exact3([lengths[part] or Fraction(0) for part in corner]) for corner in surface.corners]
    return [(x, -z, y) for x, y, z in corners] if y_is_up else corners


# Assemblies of COMPAS 2, as `compas_assembly` and `compas_cra` write them: a graph whose nodes are blocks.
#
# The blocks are at `data.graph.data.node`, each a mesh at `block.data` with the corners `vertex` and the faces `face`.
# A node may be a support, which is fixed. Interfaces in the file are skipped: contacts are computed from the shapes.
#
# A model of `compas_dem` has its blocks at `data.elements` instead, and names them in the nodes of `data.graph`. Its
# materials have densities. A problem of `compas_dem` has a model at `data.model`, with loads beside it.


# Members that are read or may be skipped; all others are reported.
_OF_OBJECT: Final = {"data", "dtype", "guid", "name", "inheritance"}
_OF_ASSEMBLY: Final = {"graph", "attributes"}
_DEFAULTS: Final = {"default_node_attributes", "default_edge_attributes", "default_face_attributes"}
_OF_GRAPH: Final = {"node", "attributes", "adjacency", "max_node", *_DEFAULTS}
_OF_PROBLEM: Final = {"name", "model"}
_OF_MODEL: Final = {"transformation", "tree", "graph", "elements", "materials", "element_material"}
_OF_ELEMENT: Final = {"transformation", "features", "name", "material", "geometry", "shape", "is_support"}
_OF_MESH: Final = {*{"vertex", "face", "attributes", "default_vertex_attributes", "max_vertex", "max_face"}, *_DEFAULTS}


def read_compas(reading: LoadReading, options: Import) -> ImportedLoad:
    """Read the blocks of an assembly or a model, in the order of its nodes. Raises UnreadableLoadError."""
    metre = metre_of(reading, options)
    json = json_text(reading)
    blocks = _Blocks(json, UnitReader(reading, metre), options)
    root = _data(json, json.root, "the assembly")
    members = json.mapping(root, "`data`") if root is not None else {}
    if root is not None and "model" in members:
        json.skip_others(members, _OF_PROBLEM, set())
        root = _data(json, members["model"], "the model")
        members = json.mapping(root, "`data` of the model") if root is not None else {}
    densities: dict[str, Fraction] = {}  # of blocks whose material the file gives
    meshes: list[ImportedMesh] = []
    if root is not None and "elements" in members:
        json.skip_others(members, _OF_MODEL, set())
        meshes = list(blocks.elements(root, members, densities))
    elif root is not None:
        json.skip_others(members, _OF_ASSEMBLY, set())
        meshes = list(blocks.meshes(_nodes(json, root, members)))
    density = Fraction(1)
    if options.density is not None or any(mesh.name not in densities for mesh in meshes):
        density, densities = density_of(reading, options), {}
    reading.end()
    bricks = [solid_brick(reading, mesh, densities.get(mesh.name, density)) for mesh in meshes]
    return reading.load([brick for brick in bricks if brick is not None])


def _nodes(json: JsonText, owner: Node, members: dict[str, Node]) -> Mapping[str, Node]:
    """Return the nodes of the graph of an assembly or a model."""
    graph = json.member(owner, members, "graph", "`data` of the assembly")
    data: Node | None = graph
    if graph is not None and "data" in json.mapping(graph, "the graph"):
        data = _data(json, graph, "the graph")
    if data is None:
        return {}
    of_graph = json.mapping(data, "`data` of the graph")
    _skip_others(json, of_graph, _OF_GRAPH, {"edge": "interfaces"})
    node = json.member(data, of_graph, "node", "`data` of the graph")
    return json.mapping(node, "`node`") if node else {}


def _data(json: JsonText, node: Node, label: str) -> Node | None:
    """Return the `data` of a COMPAS object; report and return None if there is none."""
    members = json.mapping(node, label)
    json.skip_others(members, _OF_OBJECT, set())
    return json.member(node, members, "data", label)


def _skip_others(json: JsonText, owner: Mapping[str, Node], supported: set[str], harmless: Mapping[str, str]) -> None:
    """Skip the members that are not supported; skip harmless ones under the given names, and silently if empty."""
    for key, node in owner.items():
        values = node.value.values() if isinstance(node.value, dict) else [node]
        if key not in harmless and key not in supported:
            json.reading.skip(key, json.span(node), harmless=False)
        elif key in harmless and any(value.value for value in values):
            json.reading.skip(harmless[key], json.span(node), harmless=True)


class _Blocks:
    """Reads the blocks of a graph."""

    def __init__(self, json: JsonText, units: UnitReader, options: Import) -> None:
        self._json, self._units, self._options = json, units, options

    def meshes(self, nodes: Mapping[str, Node]) -> Iterator[ImportedMesh]:
        """Yield the mesh of each node; report invalid nodes and leave them out."""
        names: dict[str, Node] = {}
        for key, node in nodes.items():
            name = brick_name(f"block-{key}", "block")
            if name in self._json.reading.ignored:
                self._json.reading.skip(name, self._json.span(node), harmless=False)
                continue
            if name in names:
                self._wrong(node, f"two nodes have the name '{name}'", "give each a different key")
            names[name] = node
            members = self._json.mapping(node, "the node")
            self._json.skip_others(members, {"block", "is_support"}, {"section", "mesh_size"})
            self._check_support(name, members.get("is_support"))
            block = self._json.member(node, members, "block", "the node")
            data = _data(self._json, block, "the block") if block else None
            mesh = self._mesh(name, node, data) if data is not None else None
            if mesh is not None:
                yield mesh

    def elements(self, root: Node, members: dict[str, Node], densities: dict[str, Fraction]) -> Iterator[ImportedMesh]:
        """Yield the mesh of each element of a model, and note the densities of the materials that it gives."""
        json = self._json
        made_of = {key: self._density(node) for key, node in self._keyed(members.get("materials"), "a material")}
        elements = dict(self._keyed(members["elements"], "an element"))
        materials = members.get("element_material")
        outside = json.mapping(materials, "`element_material`") if materials is not None else {}
        for key, node in _nodes(json, root, members).items():
            of_node = json.mapping(node, "the node")
            json.skip_others(of_node, {"element"}, {"transformation"})
            element = json.member(node, of_node, "element", "the node")
            guid = element.value if element is not None else None
            if element is None or not isinstance(guid, str) or guid not in elements:
                self._wrong(element or node, "the node refers to an element that the model does not have", "correct it")
                continue
            name = brick_name(f"block-{key}", "block")
            if name in json.reading.ignored:
                json.reading.skip(name, json.span(node), harmless=False)
                continue
            data = _data(json, elements[guid], "the element")
            if data is None:
                continue
            of_element = json.mapping(data, "`data` of the element")
            json.skip_others(of_element, _OF_ELEMENT, set())
            self._admit_unmoved(of_element, "the element")
            self._check_support(name, of_element.get("is_support"))
            shape = of_element.get("geometry") or json.member(data, of_element, "shape", "`data` of the element")
            mesh_data = _data(json, shape, "the mesh") if shape is not None else None
            mesh = self._mesh(name, elements[guid], mesh_data) if mesh_data is not None else None
            material = of_element.get("material") or outside.get(guid)
            density = made_of.get(material.value) if material is not None and isinstance(material.value, str) else None
            if density is not None:
                densities[name] = density
            if mesh is not None:
                yield mesh
        self._admit_unmoved(members, "the model")

    def _admit_unmoved(self, members: Mapping[str, Node], label: str) -> None:
        """Report what changes the shape or the place of an element."""
        for key in ("transformation", "features"):
            if key in members and members[key].value not in (None, [], {}):
                self._wrong(members[key], f"the `{key}` of {label} is not supported", "apply it, and export the model")

    def _keyed(self, node: Node | None, label: str) -> Iterator[tuple[str, Node]]:
        """Yield the objects of a mapping by key, or of a list by their `guid`."""
        if node is None:
            return
        if isinstance(node.value, dict):
            yield from node.value.items()
            return
        for each in self._json.items(node, f"the list of which {label} is part"):
            guid = self._json.mapping(each, label).get("guid")
            if guid is not None and isinstance(guid.value, str):
                yield guid.value, each

    def _density(self, material: Node) -> Fraction | None:
        """Return the density of a material [kg/m3]; None if it gives none."""
        data = _data(self._json, material, "the material")
        density = self._json.mapping(data, "`data` of the material").get("density") if data is not None else None
        if density is None or density.value is None:
            return None
        return self._units.density_of(self._json, density, "the density")

    def _check_support(self, name: str, is_support: Node | None) -> None:
        """Report a support, unless the author has decided how supports are imported."""
        if is_support is None or is_support.value in (False, None):
            return
        if is_support.value is not True:
            self._wrong(is_support, "`is_support` must be true or false", "write true or false")
        elif self._options.supports is None:
            message = f"'{name}' is a support, which COMPAS fixes, but imported blocks can move"
            hint = (
                "to import supports as bricks, write `supports: bricks`: a structure that stands on them also stands "
            )
            hint += "on fixed supports"
            self._json.reading.undetermined(self._json.span(is_support), message, hint)

    def _mesh(self, name: str, node: Node, data: Node) -> ImportedMesh | None:
        json = self._json
        members = json.mapping(data, "`data` of the block")
        _skip_others(json, members, _OF_MESH, {"facedata": "facedata", "edgedata": "edgedata"})
        vertices = json.member(data, members, "vertex", "`data` of the block")
        faces = json.member(data, members, "face", "`data` of the block")
        if vertices is None or faces is None:
            return None
        defaults = members.get("default_vertex_attributes")
        usual = json.mapping(defaults, "`default_vertex_attributes`") if defaults else {}
        corners = {key: self._corner(vertex, usual) for key, vertex in json.mapping(vertices, "`vertex`").items()}
        indices = {key: index for index, key in enumerate(corners)}
        loops = [self._loop(face, indices) for face in json.mapping(faces, "`face`").values()]
        valid = [corner for corner in corners.values() if corner is not None]
        if len(valid) < len(corners) or None in loops:
            return None
        return ImportedMesh(name, valid, [loop for loop in loops if loop is not None], json.span(node))

    def _corner(self, node: Node, usual: Mapping[str, Node]) -> Exact3 | None:
        members = self._json.mapping(node, "the corner")
        self._json.skip_others(members, {"x", "y", "z"}, set())
        full = {**{axis: usual[axis] for axis in "xyz" if axis in usual}, **members}
        parts = [self._json.member(node, full, axis, "the corner") for axis in "xyz"]
        return self._units.coordinates(self._json, parts, "the corner")

    def _loop(self, face: Node, indices: Mapping[str, int]) -> tuple[int, ...] | None:
        """Return a face as indices of the corners of its block."""
        loop: list[int] = []
        for node in self._json.items(face, "the face"):
            key = node.value.text if isinstance(node.value, Numeral) else node.value
            if not isinstance(key, str) or key not in indices:
                self._wrong(node, "the face refers to a corner that the block does not have", "correct the face")
                return None
            loop.append(indices[key])
        if len(loop) < 3 or len(set(loop)) < len(loop):  # noqa: PLR2004 -- a triangle
            self._wrong(face, "the face has fewer than three corners, or contains a corner twice", "correct the face")
            return None
        return tuple(loop)

    def _wrong(self, node: Node, message: str, hint: str) -> None:
        self._json.reading.wrong(self._json.span(node), message, hint)
