"""Blocks of COMPAS assemblies and of OBJ files: convex solids in their places, and what such files leave open."""

import json
from collections.abc import Callable, Mapping
from math import cos, pi, sin
from typing import Any

import pytest

from stackdsl.diagnostics import Diagnostic
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedLoad, UnreadableLoadError
from stackdsl.language.bricks import obj_mesh
from stackdsl.language.imports import Format, Import
from stackdsl.language.quantities import InputError
from tests.stackdsl.importers.loads import SAID, TEXTS

Said = Mapping[str, object]


def read(text: str, said: Said, format_: Format | None = None) -> ImportedLoad:
    asked = Import.model_validate({"file": "a", **({"format": format_} if format_ else {}), **said})
    return read_load(text.encode("utf-8"), "a", asked)


def mistakes(text: str, said: Said) -> list[Diagnostic]:
    with pytest.raises(UnreadableLoadError) as caught:
        read(text, said)
    return list(caught.value.diagnostics)


@pytest.mark.parametrize("format_", ["compas", "obj"])
def test_the_format_of_a_mesh_is_recognized(format_: Format) -> None:
    assert read(TEXTS[format_], SAID[format_]) == read(TEXTS[format_], SAID[format_], format_)


def test_a_wedge_weighs_half_the_box_around_it() -> None:
    _, wedge = read(TEXTS["compas"], SAID["compas"]).boxes
    assert [float(side) for side in wedge.size] == pytest.approx([0.3, 0.2, 0.3])
    assert float(wedge.mass) == pytest.approx(0.5 * 0.3 * 0.2 * 0.3 * 2400.0)


def test_a_mesh_that_is_an_upright_box_is_a_box_and_may_settle() -> None:
    assert [box.is_upright for box in read(TEXTS["obj"], SAID["obj"]).boxes] == [True] * 3
    assert [box.is_upright for box in read(TEXTS["compas"], SAID["compas"]).boxes] == [True, False]


def test_a_mesh_with_y_up_is_turned_to_z_up() -> None:
    heights = [float(box.centre[2]) for box in read(TEXTS["obj"], SAID["obj"]).boxes]
    assert heights == pytest.approx([0.025, 0.075, 0.125])
    depths = [float(box.size[1]) for box in read(TEXTS["obj"], SAID["obj"] | {"up": "+z"}).boxes]
    assert depths == pytest.approx([0.05, 0.05, 0.05])


def test_a_load_may_be_shifted() -> None:
    said = SAID["obj"] | {"origin": ["1 m", "0 mm", "20 mm"]}
    assert [float(part) for part in read(TEXTS["obj"], said).boxes[0].centre] == pytest.approx([1.0, 0.0, 0.045])


@pytest.mark.parametrize(
    ("format_", "key", "message"),
    [
        ("compas", "units", "the file does not state its unit of length"),
        ("obj", "units", "the file does not state its unit of length"),
        ("compas", "density", "the file does not give the masses of its blocks"),
        ("obj", "density", "the file does not give the masses of its blocks"),
        ("obj", "up", "an OBJ file does not state which axis points up"),
        ("compas", "supports", "'block-0' is a support, which COMPAS fixes, but imported blocks can move"),
    ],
)
def test_missing_units_of_a_mesh_are_required(format_: Format, key: str, message: str) -> None:
    said = {name: value for name, value in SAID[format_].items() if name != key}
    (found,) = mistakes(TEXTS[format_], said)
    assert (found.code, found.message) == ("SD115", message)
    assert found.hint


@pytest.mark.parametrize(
    ("format_", "key"), [("obj", "supports"), ("compas", "up"), ("table", "density"), ("compas", "load")]
)
def test_a_key_that_the_format_has_no_use_for_is_a_mistake(format_: Format, key: str) -> None:
    value = {"supports": "bricks", "up": "+z", "density": "1 kg/m3", "load": "1"}[key]
    with pytest.raises((InputError, ValueError), match=f"`{key}` applies only to"):
        read(TEXTS[format_], {**SAID[format_], key: value}, format_)
    (found,) = mistakes(TEXTS[format_], {**SAID[format_], key: value})
    assert found.message.startswith(f"`{key}` applies only to")


def test_a_block_that_is_ignored_is_not_there() -> None:
    (box,) = read(TEXTS["compas"], SAID["compas"] | {"ignore": ["block-0"]}).boxes
    assert box.name == "block-1"
    first, _ = read(TEXTS["obj"], SAID["obj"] | {"ignore": ["middle"]}).boxes
    assert first.name == "base"
    (found,) = mistakes(TEXTS["obj"], SAID["obj"] | {"ignore": ["bottom"]})
    assert found.message == "`ignore` lists 'bottom', but the file does not contain it"


def assembly(change: Callable[[dict[str, Any]], object]) -> str:
    whole = json.loads(TEXTS["compas"])
    change(whole["data"]["graph"]["data"])
    return json.dumps(whole, indent=1)


def test_parts_of_an_assembly_other_than_blocks_are_named() -> None:
    joined = assembly(lambda graph: graph.update(edge={"0": {"1": {"interfaces": [{}]}}}))
    assert read(joined, SAID["compas"]).skipped == ("interfaces",)
    glued = assembly(lambda graph: graph["node"]["1"].update(glued=True))
    (found,) = mistakes(glued, SAID["compas"])
    assert (found.code, found.message) == ("SD115", "'glued' is not supported")
    assert read(glued, SAID["compas"] | {"ignore": ["glued"]}).boxes


def model(listed: bool, change: Callable[[dict[str, Any]], object] = lambda _: None) -> str:
    """The blocks of the assembly as a model of compas_dem; `listed` as its first versions wrote it."""
    nodes = json.loads(TEXTS["compas"])["data"]["graph"]["data"]["node"]
    elements = {
        f"guid-{key}": {
            "dtype": "compas_dem.elements/Block",
            "data": {
                "transformation": None,
                "features": [],
                "name": "Block",
                "shape" if listed else "geometry": node["block"],
                "is_support": node.get("is_support", False),
                "material": "stone",
            },
            "guid": f"guid-{key}",
        }
        for key, node in nodes.items()
    }
    stone = {"dtype": "compas_dem.material/Stone", "data": {"density": 2000}, "guid": "stone"}
    data = {
        "transformation": None,
        "elements": [*elements.values()] if listed else elements,
        "materials": [stone] if listed else {"stone": stone},
        "graph": {"node": {key: {"element": f"guid-{key}"} for key in nodes}, "edge": {}},
    }
    change(data)
    return json.dumps({"dtype": "compas_dem.models/BlockModel", "data": data}, indent=1)


@pytest.mark.parametrize("listed", [True, False])
def test_a_model_of_compas_dem_has_the_blocks_of_the_assembly_with_the_density_of_their_material(listed: bool) -> None:
    said = {key: value for key, value in SAID["compas"].items() if key != "density"}
    blocks, same = read(model(listed), said).boxes, read(TEXTS["compas"], SAID["compas"]).boxes
    assert [(each.name, each.size, each.centre) for each in blocks] == [
        (each.name, each.size, each.centre) for each in same
    ]
    assert [float(each.mass) for each in blocks] == pytest.approx([float(each.mass) * 2000 / 2400 for each in same])
    assert [each.mass for each in read(model(listed), SAID["compas"]).boxes] == [each.mass for each in same]


def test_a_problem_of_compas_dem_has_its_model_and_names_the_loads_beside_it() -> None:
    inner = json.loads(model(listed=False))
    whole = {"dtype": "compas_dem.problem/Problem", "data": {"model": inner, "boundary_conditions": {}}}
    text = json.dumps(whole, indent=1)
    (found,) = mistakes(text, SAID["compas"])
    assert (found.code, found.message) == ("SD115", "'boundary_conditions' is not supported")
    assert len(read(text, SAID["compas"] | {"ignore": ["boundary_conditions"]}).boxes) == 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data["graph"]["node"]["1"].update(element="other"), "the node refers to an element that"),
        (
            lambda data: data.update(transformation=[[1, 0], [0, 1]]),
            "the `transformation` of the model is not supported",
        ),
        (lambda data: data["elements"]["guid-1"]["data"].update(features=[1]), "the `features` of the element is not"),
        (lambda data: data["materials"]["stone"]["data"].update(density=0), "the density of 0 is not a valid density"),
        (lambda data: data["materials"]["stone"]["data"].update(density="2"), "the density must be a number"),
        (lambda data: data.update(elements=3), "the list of which an element is part is 3 instead of a list"),
        (lambda data: data.pop("materials"), "the file does not give the masses of its blocks"),
    ],
)
def test_mistakes_of_a_model_are_named(change: Callable[[dict[str, Any]], object], message: str) -> None:
    said = {key: value for key, value in SAID["compas"].items() if key != "density"}
    assert any(message in found.message for found in mistakes(model(listed=False, change=change), said))


def test_a_surface_that_a_file_lists_twice_counts_once() -> None:
    text = TEXTS["obj"]
    faces = "\n".join(line for line in text.splitlines() if line.startswith("f "))
    first = text.splitlines().index(faces.splitlines()[0])
    lines = text.splitlines()
    end = next((n for n in range(first, len(lines)) if not lines[n].startswith("f ")), len(lines))
    turned = [" ".join(("f", *line.split()[2:], line.split()[1])) for line in lines[first:end]]
    twice = "\n".join((*lines[:end], *turned, *lines[end:]))
    assert [(box.size, box.mass) for box in read(twice, SAID["obj"]).boxes] == [
        (box.size, box.mass) for box in read(text, SAID["obj"]).boxes
    ]


def test_a_corner_without_a_coordinate_has_the_usual_one() -> None:
    def leave_out(graph: dict[str, Any]) -> None:
        del graph["node"]["0"]["block"]["data"]["vertex"]["0"]["x"]

    without, with_all = (read(assembly(change), SAID["compas"]) for change in (leave_out, lambda _: None))
    assert [box.corners for box in without.boxes] == [box.corners for box in with_all.boxes]


def test_a_block_that_is_not_convex_has_convex_parts() -> None:
    def dent(graph: dict[str, Any]) -> None:
        block = graph["node"]["1"]["block"]["data"]
        block["vertex"]["2"] = {"x": 0.35, "y": 0.05, "z": 0.25}
        loops = [[0, 1, 2], [5, 4, 3], [1, 0, 3, 4], [2, 1, 4], [2, 4, 5], [0, 2, 5, 3]]
        block["face"] = {str(number): loop for number, loop in enumerate(loops)}

    whole, block = read(assembly(dent), SAID["compas"]).boxes
    assert whole.parts is None
    assert block.parts is not None
    assert len(block.parts) > 1
    assert block.mass < read(assembly(lambda _: None), SAID["compas"]).boxes[1].mass


def drum(sides: int, turn: float, digits: int) -> str:
    """A prism of so many sides, leaning, in metres written with so many decimals."""
    ring = [(0.1 * cos(2 * pi * n / sides), 0.1 * sin(2 * pi * n / sides)) for n in range(sides)]
    lean = [(x * cos(turn) - z * sin(turn), y, x * sin(turn) + z * cos(turn)) for z in (0.0, 0.05) for x, y in ring]
    lines = ["v " + " ".join(f"{part:.{digits}f}" for part in corner) for corner in lean]
    around = [[n, (n + 1) % sides, sides + (n + 1) % sides, sides + n] for n in range(sides)]
    loops = [list(range(sides - 1, -1, -1)), list(range(sides, 2 * sides)), *around]
    return "\n".join([*lines, *("f " + " ".join(str(n + 1) for n in loop) for loop in loops)])


@pytest.mark.parametrize("sides", [3, 5, 6, 9, 12])
@pytest.mark.parametrize("digits", [6, 9])
def test_faces_that_are_flat_as_far_as_the_file_writes_are_flat(sides: int, digits: int) -> None:
    from stability.geometry.solid_making import solid_of_corners  # noqa: PLC0415 -- as it is imported where it is used

    (box,) = read(drum(sides, 0.7, digits), SAID["obj"]).boxes
    area = 0.5 * sides * 0.01 * sin(2 * pi / sides)
    assert float(box.mass) == pytest.approx(area * 0.05 * 2400.0, rel=1e-4)
    corners = [(float(x), float(y), float(z)) for x, y, z in box.corners or ()]
    assert len(solid_of_corners(corners).shape.faces) == sides + 2


@pytest.mark.parametrize(
    ("line", "code", "message"),
    [
        ("f 1 2 99", "SD114", "the face refers to a corner that is not among the 24 preceding corners"),
        ("f 1 2", "SD114", "the face has fewer than three corners, or contains a corner twice"),
        ("f 1 2 2", "SD114", "the face has fewer than three corners, or contains a corner twice"),
        ("v 1 2", "SD114", "the corner has 2 numbers instead of three"),
        ("v 1 2 3mm", "SD114", "the corner: '3mm' is not a number"),
        ("curv 0 1 1 2 3", "SD115", "'curv' is not supported"),
        ("l 1 2", "SD115", "'l' is not supported"),
    ],
)
def test_a_line_that_is_wrong_is_told_in_its_place(line: str, code: str, message: str) -> None:
    (found,) = mistakes(TEXTS["obj"] + line + "\n", SAID["obj"])
    assert (found.code, found.message) == (code, message)
    assert found.span.line == TEXTS["obj"].count("\n") + 1


def test_groups_are_bricks_where_there_are_no_objects() -> None:
    grouped = TEXTS["obj"].replace("o base", "g base").replace("o middle", "g the middle").replace("o top", "g 3rd")
    names = [box.name for box in read(grouped, SAID["obj"]).boxes]
    assert names == ["base", "the-middle", "brick-3rd"]


def test_ignored_statements_of_a_mesh_are_named() -> None:
    assert read(TEXTS["obj"] + "g all\ns off\n", SAID["obj"]).skipped == ("mtllib", "usemtl", "g", "s")


def test_two_objects_of_one_name_are_told() -> None:
    (found,) = mistakes(TEXTS["obj"].replace("o top", "o base"), SAID["obj"])
    assert found.message == "two objects have the name 'base'"


def test_a_line_may_go_on_in_the_next() -> None:
    broken = TEXTS["obj"].replace("f 1 2 3 4", "f 1 2 \\\n3 4")
    assert [box.size for box in read(broken, SAID["obj"]).boxes] == [
        box.size for box in read(TEXTS["obj"], SAID["obj"]).boxes
    ]


@pytest.mark.parametrize("corner", ["٣", "0_3", "3_"])
def test_only_plain_digits_number_a_corner(corner: str) -> None:
    text = TEXTS["obj"].replace("f 1 2 3", f"f 1 2 {corner}", 1)
    assert corner in text
    assert mistakes(text, SAID["obj"])[0].message.startswith("the face refers to a corner that is not among")
    with pytest.raises(InputError, match="is not a corner number"):
        obj_mesh(f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {corner}\n", "a")


@pytest.mark.parametrize("number", ["١", "1_0"])
def test_only_plain_digits_are_a_coordinate(number: str) -> None:
    with pytest.raises(InputError, match="is not a number"):
        obj_mesh(f"v 0 0 {number}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a")
