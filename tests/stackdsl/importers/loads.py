"""Small files of each format, and other readers of them, which know nothing of ours."""

import csv
import json
import re
import struct
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, TypeAlias
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from stackdsl.language.imports import Format

Corner: TypeAlias = tuple[float, ...]
Box: TypeAlias = tuple[tuple[float, ...], tuple[float, ...], float]  # size, centre [m], mass [kg]

TABLE: Final = """name,length [mm],width [mm],height [cm],mass [g],x [m],y [m],z [m]
bottom,400,300,20,5200,0,0,0
"by side",400,300,20.0,5.2e3,0.4,0,0
top,600,300,10.5,800,0.1,0,0.2
""".replace('"by side"', "by-side")

PALLET: Final = json.dumps(
    {
        "orderID": "1",
        "pallets": [
            {
                "palletNr": "001",
                "palletType": "EURO_PALLET",
                "palletDimension": {"x": 800.0, "y": 1200.0},
                "boxes": [
                    {
                        "product_code": code,
                        "anchor": dict(zip("xyz", anchor, strict=True)),
                        "dimension": dict(zip("xyz", size, strict=True)),
                        "approach": "3",
                    }
                    for code, anchor, size in (
                        ("7", (0.0, 0.0, 0.0), (394.0, 596.0, 140.0)),
                        ("7", (394.0, 0.0, 0.0), (394.0, 596.0, 140.0)),
                        ("8", (200.0, 0.0, 140.0), (388.0, 299.0, 110.0)),
                    )
                ],
            }
        ],
        "articles": {
            "7": {"description": "soap", "weight": 2600.0, "shippingGroup": "G1"},
            "8": {"description": "salt", "weight": 8400.0, "shippingGroup": "G2"},
        },
    },
    indent=1,
)

PLAN: Final = json.dumps(
    {
        "00100408": [
            {
                "item": {
                    "article": f"article-{number}",
                    "id": f"id{number}",
                    "product_group": "food",
                    "length/mm": 300,
                    "width/mm": 200,
                    "height/mm": 100,
                    "weight/kg": 3.14,
                    "sequence": number,
                },
                "flb_coordinates": corner,
                "orientation": turned,
            }
            for number, (corner, turned) in enumerate((([0, 0, 0], 0), ([300, 0, 0], 1), ([0, 0, 100], 1)), start=1)
        ]
    },
    indent=1,
)

OWN: Final = Path(__file__).parents[3] / "scenarios" / "loads"
ASSEMBLY, SLABS, LINKS = (OWN / name for name in ("wedge.assembly.json", "slabs.obj", "crates.urdf"))
SCENE = OWN / "crates.xml"


def _lego(first: int, **others: object) -> str:
    """A wall of three bricks, of which one is across."""
    bricks = {
        str(number): {"x": x, "y": 4, "z": z + first, "brick_id": kind, "ori": ori, **others}
        for number, (x, z, kind, ori) in enumerate(((3, 0, 2, 1), (7, 0, 12, 0), (5, 1, 9, 0)), start=1)
    }
    return json.dumps(bricks, indent=1)


LDRAW: Final = """0 FILE wall.ldr
0 a wall of two arms
1 4 0 -24 0 1 0 0 0 1 0 0 0 1 arm.ldr
1 1 60 -24 20 0 0 1 0 1 0 -1 0 0 arm.ldr
0 STEP
1 15 40 -32 0 1 0 0 0 1 0 0 0 1 3020.dat
0 FILE arm.ldr
1 16 0 0 0 1 0 0 0 1 0 0 0 1 3003.DAT
1 16 10.5 -24 10 0 0 -1 0 1 0 1 0 0 3004.dat
"""

# A box and a wedge, in metres: corners, and faces counter-clockwise seen from outside.
_BOX: Final = (
    tuple((x, y, z) for z in (0.0, 0.1) for y in (0.0, 0.2) for x in (0.0, 0.3)),
    ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)),
)
_WEDGE: Final = (
    ((0.4, 0.0, 0.0), (0.4, 0.2, 0.0), (0.4, 0.2, 0.1), (0.4, 0.0, 0.1), (0.7, 0.0, 0.0), (0.7, 0.2, 0.0)),
    ((0, 3, 2, 1), (0, 1, 5, 4), (3, 4, 5, 2), (0, 4, 3), (1, 2, 5)),
)
SOLIDS: Final = {"box": _BOX, "wedge": _WEDGE}


def triangles(faces: Iterable[tuple[int, ...]]) -> list[tuple[int, int, int]]:
    """The faces, cut into fans of triangles."""
    return [(face[0], b, c) for face in faces for b, c in pairwise(face[1:])]


def _stl_text() -> str:
    lines = []
    for name, (corners, faces) in SOLIDS.items():
        lines.append(f"solid {name}")
        for triangle in triangles(faces):
            vertices = [f"  vertex {' '.join(map(str, corners[n]))}" for n in triangle]
            lines += [" facet normal 0 0 0", "  outer loop", *vertices, "  endloop", " endfacet"]
        lines.append(f"endsolid {name}")
    return "\n".join(lines) + "\n"


def ply_head(order: str, corners: int, faces: int, number: str = "float") -> str:
    """The header of a PLY file of corners and faces."""
    lines = [f"ply\nformat {order} 1.0\ncomment two solids\nelement vertex {corners}"]
    lines += [f"property {number} {axis}" for axis in "xyz"]
    lines += [f"element face {faces}", "property list uchar int vertex_indices", "end_header"]
    return "\n".join(lines) + "\n"


def numbered_solids() -> tuple[list[Corner], list[tuple[int, ...]]]:
    """The corners of both solids, and the faces by their numbers."""
    corners: list[Corner] = [corner for solid, _ in SOLIDS.values() for corner in solid]
    return corners, [*_BOX[1], *(tuple(n + len(_BOX[0]) for n in face) for face in _WEDGE[1])]


def binary_stl(*solids: tuple[Sequence[Corner], Sequence[tuple[int, ...]]], header: bytes = b"made by a test") -> bytes:
    flat = [[corners[n] for n in triangle] for corners, faces in solids for triangle in triangles(faces)]
    records = (struct.pack("<12fH", 0, 0, 0, *(part for corner in each for part in corner), 0) for each in flat)
    return header.ljust(80) + struct.pack("<I", len(flat)) + b"".join(records)


def binary_ply(
    corners: Sequence[Corner], faces: Sequence[tuple[int, ...]], order: str = "little", wide: bool = False
) -> bytes:
    sign, number = "<" if order == "little" else ">", "d" if wide else "f"
    head = ply_head(f"binary_{order}_endian", len(corners), len(faces), "double" if wide else "float")
    places = b"".join(struct.pack(f"{sign}3{number}", *corner) for corner in corners)
    return head.encode() + places + b"".join(struct.pack(f"{sign}B{len(face)}i", len(face), *face) for face in faces)


def _ply_text() -> str:
    corners, faces = numbered_solids()
    lines = [*(" ".join(map(str, corner)) for corner in corners)]
    lines += [" ".join(map(str, (len(face), *face))) for face in faces]
    return ply_head("ascii", len(corners), len(faces)) + "\n".join(lines) + "\n"


TEXTS: Final[dict[Format, str]] = {
    "table": TABLE,
    "pallet-sim": PALLET,
    "bed-bpp": PLAN,
    "compas": ASSEMBLY.read_text(encoding="utf-8"),
    "obj": SLABS.read_text(encoding="utf-8"),
    "stl": _stl_text(),
    "ply": _ply_text(),
    "urdf": LINKS.read_text(encoding="utf-8"),
    "mjcf": SCENE.read_text(encoding="utf-8"),
    "stablelego": _lego(0),
    "apex-mr": _lego(1, press_x=3, manipulate_type=0),
    "brickgpt": "2x4 (0,0,0)\n1x2 (0,1,1)\n\n6x2 (0,0,2)\n",
    "ldraw": LDRAW,
}
# Binary files of the same solids, by name; the format is the first word of it.
BINARIES: Final = {
    "stl, binary": binary_stl(*SOLIDS.values()),
    "ply, binary": binary_ply(*numbered_solids()),
}
_OF_MESHES: Final[dict[str, object]] = {"units": {"length": "m"}, "density": "2400 kg/m3"}
# What the author has to say of a file of each format.
SAID: Final[dict[Format, dict[str, object]]] = {
    "table": {"point": "corner"},
    "pallet-sim": {},
    "bed-bpp": {},
    "compas": {**_OF_MESHES, "supports": "bricks"},
    "obj": {**_OF_MESHES, "up": "+y"},
    "stl": {**_OF_MESHES, "up": "+z"},
    "ply": {**_OF_MESHES, "up": "+z"},
    "urdf": {},
    "mjcf": {},
    "stablelego": {},
    "apex-mr": {},
    "brickgpt": {},
    "ldraw": {},
}


PARSERS: Final = {"urdf": "urdf_parser_py", "mjcf": "mujoco"}


def skip_without_parser(format_: str) -> None:
    """Skip a test of a format whose parser comes with an extra, where that is not installed."""
    if format_ in PARSERS:
        pytest.importorskip(PARSERS[format_], reason=f"{PARSERS[format_]} is in an extra")


def beside(named: str) -> bytes:
    """What a file holds that one of these names."""
    return (OWN / named).read_bytes()


def read_otherwise(format_: str, text: str) -> list[Box]:
    """The boxes of a file that is right, by libraries that know nothing of ours. Raises if it is not."""
    meshes = {"obj": _objects, "stl": _of_facets, "ply": _of_ply}
    if format_ in meshes:
        return list(meshes[format_](text))
    if format_ == "urdf":
        return list(_links(ElementTree.fromstring(text)))
    if format_ == "mjcf":
        return list(_bodies(text))
    if format_ == "table":
        return [_row(row) for row in csv.DictReader(text.splitlines(), strict=True)]
    if format_ == "brickgpt":
        return [_of_cells(*map(int, re.findall(r"\d+", line))) for line in text.splitlines() if line.strip()]
    if format_ == "ldraw":
        return list(_of_models(text))
    whole = json.loads(text, object_pairs_hook=_each_once)
    if format_ in {"stablelego", "apex-mr"}:
        return list(
            _of_wall(whole.values(), 0 if format_ == "stablelego" else min(each["z"] for each in whole.values()))
        )
    if format_ == "compas":
        nodes = whole["data"]["graph"]["data"]["node"]
        return [_of_faces(_faces_of(node["block"]["data"])) for node in nodes.values()]
    if format_ == "bed-bpp":
        (actions,) = whole.values()
        return [_action(action) for action in actions]
    (pallet,) = whole["pallets"]
    return [_of_pallet(box, whole["articles"]) for box in pallet["boxes"]]


GRAMS: Final = {
    **{(1, 1): 0.43, (2, 1): 0.81, (3, 1): 1.2, (4, 1): 1.57, (6, 1): 2.28, (8, 1): 3.03},
    **{(2, 2): 1.15, (3, 2): 1.71, (4, 2): 2.16, (6, 2): 3.23, (8, 2): 4.3},
}


def _of_cells(along: int, across: int, x: int, y: int, z: int) -> Box:
    """A brick of so many studs from its lowest cell, in exact tenths of a millimetre."""
    longer, shorter = sorted((along, across), reverse=True)
    size = (Fraction(8 * longer, 1000), Fraction(8 * shorter, 1000), Fraction(96, 10_000))
    centre = (Fraction(8 * x + 4 * along, 1000), Fraction(8 * y + 4 * across, 1000), Fraction(96 * z + 48, 10_000))
    return tuple(map(float, size)), tuple(map(float, centre)), float(Fraction(repr(GRAMS[longer, shorter])) / 1000)


def _of_wall(bricks: Iterable[dict[str, int]], lowest: int) -> Iterator[Box]:
    studs = {1: (2, 2), 2: (2, 4), 3: (2, 6), 4: (1, 8), 5: (1, 4), 6: (1, 6), 9: (1, 2), 10: (1, 1), 12: (2, 2)}
    for brick in bricks:
        one, other = studs[brick["brick_id"]]
        along, across = (other, one) if brick["ori"] else (one, other)
        size, centre, mass = _of_cells(along, across, brick["x"], brick["y"], brick["z"] - lowest)
        yield size, centre, 0.2 if brick["brick_id"] == 1 else mass


def _of_models(text: str) -> Iterator[Box]:
    """The parts of an LDraw model, by matrices, with the lowest one at height 0."""
    lines: list[list[str]] = []
    models = {"": lines}
    for words in map(str.split, text.splitlines()):
        if [word.upper() for word in words[:2]] == ["0", "FILE"] and len(words) > 2:
            lines = models.setdefault(" ".join(words[2:]).lower(), [])
        else:
            lines.append(words)
    parts = {"3003.dat": (2, 2, 96, 1.15), "3004.dat": (2, 1, 96, 0.81), "3020.dat": (4, 2, 32, 1.15)}

    def placed(name: str, frame: NDArray[np.float64]) -> Iterator[tuple[tuple[float, ...], NDArray[np.float64], float]]:
        for words in models[name]:
            if not words or words[0] == "0":
                continue
            assert words[0] == "1"
            x, y, z, *turn = (float(word) for word in words[2:14])
            own = frame @ np.block([[np.reshape(turn, (3, 3)), np.array([[x], [y], [z]])], [np.zeros(3), 1.0]])
            file = " ".join(words[14:]).lower()
            if file in parts:
                length, width, height, grams = parts[file]
                top = np.round(own[:3, 3], 2) * 0.4e-3
                middle = np.array([top[0], top[2], -top[1] - 0.5e-4 * height])
                yield (8e-3 * length, 8e-3 * width, 1e-4 * height), middle, 1e-3 * grams
            else:
                yield from placed(file, own)

    first = "" if any(words[0] != "0" for words in models[""] if words) else list(models)[1]
    found = list(placed(first, np.eye(4)))
    ground = min(middle[2] - 0.5 * size[2] for size, middle, _ in found)
    yield from ((size, (middle[0], middle[1], middle[2] - ground), mass) for size, middle, mass in found)


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    assert len(dict(pairs)) == len(pairs)
    return dict(pairs)


def _row(row: dict[str | None, Any]) -> Box:
    assert None not in row
    assert None not in row.values()
    per: dict[str, Fraction | int] = {"mm": 1000, "cm": 100, "m": 1, "g": 1000, "kg": 1, "t": Fraction(1, 1000)}
    by: dict[str, Any] = {}
    for header, cell in row.items():
        name, _, unit = str(header).rstrip("] ").partition("[")
        # The only column in a unit of mass is that of the masses, however its name is spelt.
        key = "mass" if unit.strip() in {"g", "kg", "t"} else name.strip()
        by[key] = cell if key == "name" else Fraction(cell) / per[unit.strip()]
    return _box([by[key] for key in "xyz"], [by[key] for key in ("length", "width", "height")], by["mass"])


def _of_pallet(box: dict[str, Any], articles: dict[str, Any]) -> Box:
    corner = [_exact(box["anchor"][axis]) / 1000 for axis in "xyz"]
    size = [_exact(box["dimension"][axis]) / 1000 for axis in "xyz"]
    return _box(corner, size, _exact(articles[box["product_code"]]["weight"]) / 1000)


def _action(action: dict[str, Any]) -> Box:
    item = action["item"]
    size = [_exact(item[f"{side}/mm"]) / 1000 for side in ("length", "width", "height")]
    assert action["orientation"] in {0, 1}
    laid = [size[1], size[0], size[2]] if action["orientation"] == 1 else size
    return _box([_exact(part) / 1000 for part in action["flb_coordinates"]], laid, _exact(item["weight/kg"]))


def _exact(number: float) -> Fraction:
    assert isinstance(number, int | float)
    assert not isinstance(number, bool)
    return Fraction(repr(number))


def _box(corner: list[Fraction], size: list[Fraction], mass: Fraction) -> Box:
    assert min(*size, mass) > 0
    centre = tuple(float(low + side / 2) for low, side in zip(corner, size, strict=True))
    return tuple(map(float, size)), centre, float(mass)


def _faces_of(block: dict[str, Any]) -> list[list[list[float]]]:
    """The corners of a block that its faces name; its edges must be passed once each way."""
    usual, vertices = block["default_vertex_attributes"], block["vertex"]
    ways = [pair for face in block["face"].values() for pair in pairwise([*face, face[0]])]
    assert {(other, one) for one, other in ways} == set(ways)
    places = {corner: [{**usual, **vertices[str(corner)]}[axis] for axis in "xyz"] for way in ways for corner in way}
    return [[places[corner] for corner in face] for face in block["face"].values()]


def _objects(text: str) -> Iterator[Box]:
    """The objects of an OBJ file with y up."""
    corners: list[list[float]] = []
    objects: dict[str, list[list[list[float]]]] = {}
    name = ""
    for kind, *parts in (line.split() for line in text.splitlines() if line.partition("#")[0].strip()):
        if kind == "o":
            name = " ".join(parts)
        elif kind == "v":
            x, y, z = (float(Fraction(part)) for part in parts[:3])
            corners.append([x, -z, y])
        elif kind == "f":
            objects.setdefault(name, []).append([corners[int(part.partition("/")[0]) - 1] for part in parts])
    for faces in objects.values():
        yield _of_faces(faces)


def _of_facets(text: str) -> Iterator[Box]:
    """The solids of an STL file, whose corners are all that matters."""
    for solid in re.findall(r"^solid\b.*?^endsolid\b", text, re.MULTILINE | re.DOTALL | re.IGNORECASE):
        corners = [
            [float(Fraction(part)) for part in line.split()[1:]]
            for line in solid.split("\n")
            if line.split()[:1] and line.split()[0].lower() == "vertex"
        ]
        yield from _between([corners[n : n + 3] for n in range(0, len(corners), 3)])


def _of_ply(text: str) -> Iterator[Box]:
    """The solids of a PLY file of text."""
    head, _, body = text.partition("end_header\n")
    (many,) = re.findall(r"^ *element vertex (\d+)", head, re.MULTILINE)
    axes = re.findall(r"^ *property \w+ ([xyz])\s*$", head, re.MULTILINE)
    lines = [line.split() for line in body.split("\n") if line.strip()]
    corners = [[float(Fraction(line[axes.index(axis)])) for axis in "xyz"] for line in lines[: int(many)]]
    yield from _between([[corners[int(part)] for part in line[1:]] for line in lines[int(many) :]])


def read_binary_otherwise(format_: str, data: bytes) -> list[Box]:
    """The solids of a binary file like those above. Raises if it is none."""
    if format_ == "stl":
        corners = (
            np.frombuffer(data, np.uint8, offset=84).reshape(-1, 50)[:, 12:48].copy().view("<f4").reshape(-1, 3, 3)
        )
        return list(_between(corners.astype(float).tolist()))
    head, _, body = data.partition(b"end_header\n")
    many, faces = (int(found) for found in re.findall(rb"^element [vf]\w+ (\d+)", head, re.MULTILINE))
    places = np.frombuffer(body, "<f4", 3 * many).reshape(-1, 3).astype(float).tolist()
    at, loops = 12 * many, []
    for _ in range(faces):
        loops.append([places[n] for n in struct.unpack_from(f"<{body[at]}i", body, at + 1)])
        at += 1 + 4 * body[at]
    assert at == len(body)
    return list(_between(loops))


def _between(faces: list[list[list[float]]]) -> Iterator[Box]:
    """The bodies between faces, those of one body connected by corners."""
    numbers: dict[tuple[float, ...], int] = {}
    loops = [[numbers.setdefault(tuple(corner), len(numbers)) for corner in face] for face in faces]
    ways = [way for loop in loops for way in pairwise([*loop, loop[0]])]
    assert {(other, one) for one, other in ways} == set(ways)
    links = coo_array((np.ones(len(ways)), tuple(zip(*ways, strict=True))), shape=(len(numbers),) * 2)
    _, labels = connected_components(links)
    for label in dict.fromkeys(int(labels[loop[0]]) for loop in loops):
        own = [face for face, loop in zip(faces, loops, strict=True) if labels[loop[0]] == label]
        yield _of_faces(own)


def _of_faces(faces: list[list[list[float]]]) -> Box:
    """The box around faces, and the weight between them, as a corner that has moved may leave a dent."""
    size, centre, _ = _of_corners([corner for face in faces for corner in face])
    fans = [(face[0], b, c) for face in faces for b, c in pairwise(face[1:])]
    return size, centre, 2400.0 * abs(float(np.linalg.det(np.array(fans)).sum())) / 6.0


def _of_corners(corners: list[list[float]]) -> Box:
    """The box around a hull, and the weight of that."""
    points = np.array(corners, dtype=float)
    low, high = points.min(axis=0), points.max(axis=0)
    return tuple(high - low), tuple(0.5 * (low + high)), 2400.0 * float(ConvexHull(points).volume)


def _links(robot: ElementTree.Element) -> Iterator[Box]:
    """The links of a URDF that a joint puts somewhere."""
    joints = {_only(joint, "child").attrib["link"]: joint for joint in robot.iter("joint")}
    for link in robot.iter("link"):
        if link.attrib["name"] not in joints:
            assert link.find("collision") is None
            continue
        joint, collision = joints[link.attrib["name"]], _only(link, "collision")
        assert joint.attrib["type"] == "floating"
        turn, place = _origin(joint)
        inner, shift = _origin(collision)
        mass = float(_only(_only(link, "inertial"), "mass").attrib["value"])
        (shape,) = _only(collision, "geometry")
        if shape.tag == "box":
            yield tuple(_numbers(shape.attrib["size"])), tuple((place + turn @ shift).tolist()), mass
        else:
            assert shape.tag == "mesh"
            scaled = _numbers(shape.attrib.get("scale", "1 1 1")) * np.array(_points(shape.attrib["filename"]))
            size, centre, _ = _of_corners((place + (shift + scaled @ inner.T) @ turn.T).tolist())
            yield size, centre, mass


def _only(element: ElementTree.Element, tag: str) -> ElementTree.Element:
    (found,) = element.findall(tag)
    return found


def _numbers(text: str) -> NDArray[np.float64]:
    return np.array([float(part) for part in text.split()])


def _origin(element: ElementTree.Element) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The turn, about x, then y, then z, and the place."""
    origin = element.find("origin")
    written = origin.attrib if origin is not None else {}
    a, b, c = _numbers(written.get("rpy", "0 0 0"))
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    about_z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return about_z @ about_y @ about_x, _numbers(written.get("xyz", "0 0 0"))


def _points(file: str) -> list[list[float]]:
    lines = (line.split() for line in beside(file).decode("utf-8").splitlines())
    return [[float(part) for part in words[1:4]] for words in lines if words[:1] == ["v"]]


def _plain(found: re.Match[str]) -> str:
    """Without attributes that are not taken, which may mean nothing."""
    return f"<{found[1]}{found[2]}>"


def _bodies(text: str) -> Iterator[Box]:
    """The bodies of a scene, as MuJoCo itself has them once all of it is loaded that says what is where."""
    import mujoco  # noqa: PLC0415 -- it comes with an extra

    model = mujoco.MjModel.from_xml_string(re.sub(r"<(option|light|mujoco)\b[^<>]*?(/?)>", _plain, text))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for body in range(1, model.nbody):
        (geom,) = range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body])
        place, turn = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
        mass = float(model.body_mass[body])
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX:
            yield tuple((2.0 * model.geom_size[geom]).tolist()), tuple(place.tolist()), mass
        else:
            first, count = (of[model.geom_dataid[geom]] for of in (model.mesh_vertadr, model.mesh_vertnum))
            size, centre, _ = _of_corners((place + model.mesh_vert[first : first + count] @ turn.T).tolist())
            yield size, centre, mass
