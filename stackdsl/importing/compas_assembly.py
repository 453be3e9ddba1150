"""Assemblies of COMPAS 2, as `compas_assembly` and `compas_cra` write them: a graph whose nodes are blocks.

The blocks are at `data.graph.data.node`, each a mesh at `block.data` with the corners `vertex` and the faces `face`. A
node may be a support, which nothing moves. Interfaces that a file may have are not taken: contacts are found anew.
"""

from collections.abc import Iterator, Mapping
from typing import Final

from stackdsl.importing.json_text import JsonText, Node, Numeral, json_text
from stackdsl.importing.load import Exact3, ImportedLoad, LoadReading
from stackdsl.importing.measures import Measures
from stackdsl.importing.meshes import Mesh, brick_name, density_of, metre_of, solid_brick
from stackdsl.language.imports import Import

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
    blocks = _Blocks(json, Measures(reading, metre), asked)
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

    def __init__(self, json: JsonText, measures: Measures, asked: Import) -> None:
        self._json, self._measures, self._asked = json, measures, asked

    def meshes(self, nodes: Mapping[str, Node]) -> Iterator[Mesh]:
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

    def _mesh(self, name: str, node: Node, held: Node) -> Mesh | None:
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
        return Mesh(name, known, [loop for loop in loops if loop is not None], json.span(node))

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
