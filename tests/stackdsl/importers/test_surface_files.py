"""STL and PLY files, as text and binary: solids with closed-form volumes, and files that lie."""

import struct
from math import sqrt
from pathlib import Path

import pytest

from stackdsl.diagnostics import Diagnostic
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedBox, UnreadableLoadError
from stackdsl.language.bricks import BrickKind, KnownBricks
from stackdsl.language.imports import Import
from stackdsl.language.mesh_files import MOST_FACES
from tests.command_line import Stackdsl, stackdsl_in_folder
from tests.stackdsl.importers.loads import SAID, SOLIDS, TEXTS, binary_ply, binary_stl, numbered_solids

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

TETRAHEDRON = (
    ((0.1, 0.1, 0.1), (-0.1, -0.1, 0.1), (-0.1, 0.1, -0.1), (0.1, -0.1, -0.1)),
    ((0, 3, 2), (0, 1, 3), (0, 2, 1), (1, 2, 3)),
)
# An L along y: two bars of 0.1 m x 0.1 m, one of them twice as long, in one corner.
_OUTLINE = ((0.0, 0.0), (0.2, 0.0), (0.2, 0.1), (0.1, 0.1), (0.1, 0.3), (0.0, 0.3))
L_BRICK = (
    (*((x, 0.0, z) for x, z in _OUTLINE), *((x, 0.5, z) for x, z in _OUTLINE)),
    (
        *((0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)),
        *((8, 7, 6), (9, 8, 6), (10, 9, 6), (11, 10, 6)),
        *((n, n + 6, (n + 1) % 6 + 6, (n + 1) % 6) for n in range(6)),
    ),
)


def read(data: bytes, format_: str | None = None, unit: str = "m") -> tuple[ImportedBox, ...]:
    said = {**SAID["stl"], "units": {"length": unit}, **({"format": format_} if format_ else {})}
    return read_load(data, "a", Import.model_validate({"file": "a", **said})).boxes


def mistakes(data: bytes, format_: str | None = None) -> list[Diagnostic]:
    with pytest.raises(UnreadableLoadError) as caught:
        read(data, format_)
    return list(caught.value.diagnostics)


def test_a_tetrahedron_weighs_its_edge_cubed_over_six_times_the_root_of_two() -> None:
    edge = 0.2 * sqrt(2.0)
    for data in (binary_stl(TETRAHEDRON), binary_ply(*TETRAHEDRON), binary_ply(*TETRAHEDRON, "big", wide=True)):
        (brick,) = read(data)
        assert float(brick.mass) == pytest.approx(2400.0 * edge**3 / (6.0 * sqrt(2.0)), rel=1e-9)


@pytest.mark.parametrize(("unit", "metre"), [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254)])
def test_lengths_are_in_the_unit_that_the_author_gives(unit: str, metre: float) -> None:
    (brick,) = read(binary_stl(SOLIDS["box"]), unit=unit)
    assert [float(side) for side in brick.size] == pytest.approx([0.3 * metre, 0.2 * metre, 0.1 * metre])


def test_single_precision_is_read_in_the_digits_that_were_meant() -> None:
    (brick,) = read(binary_stl(SOLIDS["box"]))
    assert [str(side) for side in brick.size] == ["3/10", "1/5", "1/10"]
    assert brick.is_upright


def test_a_body_that_is_not_convex_has_the_volume_of_its_parts() -> None:
    for data in (binary_stl(L_BRICK), binary_ply(*L_BRICK)):
        (brick,) = read(data)
        assert float(brick.mass) == pytest.approx(2400.0 * 0.5 * (0.1 * 0.1 * 4.0), rel=1e-6)
        assert brick.parts is not None
        assert len(brick.parts) == 2


def test_text_and_binary_files_of_the_same_solids_give_the_same_bricks() -> None:
    forms = [(brick.size, brick.centre, brick.mass) for brick in read(TEXTS["stl"].encode())]
    for data in (TEXTS["ply"].encode(), binary_stl(*SOLIDS.values()), binary_ply(*numbered_solids())):
        assert [(brick.size, brick.centre, brick.mass) for brick in read(data)] == forms
    assert [brick.name for brick in read(TEXTS["stl"].encode())] == ["box", "wedge"]
    assert [brick.name for brick in read(binary_stl(*SOLIDS.values()))] == ["brick-1", "brick-2"]


def test_bricks_that_touch_are_apart_as_each_is_closed_by_itself() -> None:
    corners, faces = SOLIDS["box"]
    stacked = [tuple((x, y, z + 0.1 * n) for x, y, z in corners) for n in range(3)]
    bricks = read(binary_stl(*((each, faces) for each in stacked)))
    assert [float(brick.centre[2]) for brick in bricks] == pytest.approx([0.05, 0.15, 0.25])
    assert [float(brick.mass) for brick in bricks] == pytest.approx([14.4] * 3)


def test_other_properties_and_elements_of_a_ply_file_are_passed_over() -> None:
    corners, faces = TETRAHEDRON
    head = (
        "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement vertex 4\r\nproperty uchar red\r\nproperty double x\r\n"
        "property float y\r\nproperty float z\r\nelement edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\n"
        "element face 4\r\nproperty float area\r\nproperty list uint8 uint32 vertex_index\r\nend_header\r\n"
    )
    lines = [f"255 {x} {y} {z}" for x, y, z in corners] + ["0 1"] + [f"0.5 3 {a} {b} {c}" for a, b, c in faces]
    (brick,) = read((head + "\r\n".join(lines) + "\r\n").encode())
    assert float(brick.mass) == pytest.approx(2400.0 * 0.4**3 / 24.0 * 1.0, rel=1e-9)


def test_a_file_may_begin_with_solid_and_be_binary_all_the_same() -> None:
    assert len(read(binary_stl(SOLIDS["box"], header=b"solid of a careless program"))) == 1


STL, PLY = binary_stl(TETRAHEDRON), binary_ply(*TETRAHEDRON)
NAN = struct.pack("<f", float("nan"))


@pytest.mark.parametrize(
    ("data", "format_", "message"),
    [
        (STL[:-1], "stl", "the file has 283 bytes, but announces 4 triangles, which take 284"),
        (STL[:80] + struct.pack("<I", 2**32 - 1) + STL[84:], "stl", "but announces 4294967295 triangles"),
        (STL[:60], "stl", "the file has 60 bytes, but a binary STL file has at least 84"),
        (STL[:96] + NAN + STL[100:], "stl", "the corner: 'nan' is not a number"),
        (STL[:84] + STL[134:184] + STL[134:], "stl", "traverse their common edge in the same direction"),
        (binary_stl((TETRAHEDRON[0], TETRAHEDRON[1][:3])), "stl", "3 faces enclose no volume"),
        (binary_stl((SOLIDS["box"][0], SOLIDS["box"][1][:5])), "stl", "the mesh has a hole"),
        (
            binary_stl((TETRAHEDRON[0], [face[::-1] for face in TETRAHEDRON[1]])),
            "stl",
            "the faces are oriented inwards",
        ),
        (binary_stl(), "stl", "the file has no triangles"),
        (PLY[:-1], "ply", "the file ends within element 4 of `face`, but announces 4"),
        (PLY + b"123", "ply", "the file has 3 bytes more than its header announces"),
        (PLY.replace(b"face 4", b"face 3"), "ply", "13 bytes more than its header announces"),
        (PLY.replace(b"vertex 4", b"vertex 400000000000"), "ply", "the file has 400000000000 elements `vertex`"),
        (PLY.replace(b"vertex 4", b"vertex 90000"), "ply", "the file ends within element 9 of `vertex`"),
        (PLY.replace(b"uchar int", b"float int"), "ply", "the line 'property list float int vertex_indices' is not"),
        (PLY.replace(b"float z", b"list uchar float z"), "ply", "the vertices have no `x`, `y` and `z`"),
        (PLY.replace(b"float y", b"float x"), "ply", "has no entry, an entry twice"),
        (PLY.replace(b"end_header", b"end_headed"), "ply", "does not begin with `ply` and a header"),
        (PLY.replace(b"vertex_indices", b"vertices"), "ply", "the faces have no list `vertex_indices`"),
        (PLY[:-4] + struct.pack("<i", -1), "ply", "a face refers to a corner that is not among the 4 corners"),
        (TEXTS["ply"].encode().replace(b"4 0 2 3 1", b"4 0 2 3 14"), "ply", "is not among the 14 corners"),
        (TEXTS["ply"].encode() + b"3 0 1 2\n", "ply", "the file has more lines than its header announces"),
        (TEXTS["ply"].encode()[:-12], "ply", "the file has 10 elements `face`, but announces 11"),
        (TEXTS["stl"].encode()[:-15], "stl", "the file ends within a solid"),
        (TEXTS["stl"].encode().replace(b"vertex 0.0", b"vertex 1e999", 1), "stl", "'1e999' is not a number"),
        (TEXTS["stl"].encode().replace(b"  endloop\n", b"", 1), "stl", "'endfacet' stands where endloop must follow"),
    ],
    ids=lambda value: "file" if isinstance(value, bytes) else None,
)
def test_a_file_that_lies_is_told_with_the_cause(data: bytes, format_: str, message: str) -> None:
    first = mistakes(data, format_)[0]
    assert first.code == "SD114"
    assert message in first.message
    assert first.hint


def test_a_mesh_of_too_many_faces_is_refused_before_it_is_read() -> None:
    head = b"x".ljust(80) + struct.pack("<I", MOST_FACES + 1)
    (found,) = mistakes(head + bytes(50 * (MOST_FACES + 1)), "stl")
    assert found.message == f"the file has {MOST_FACES + 1} triangles; the maximum is {MOST_FACES}"


@pytest.mark.parametrize("format_", ["stl", "ply"])
def test_a_kind_of_brick_may_be_in_a_binary_file(format_: str) -> None:
    data = STL if format_ == "stl" else PLY
    name = f"tetrahedron.{format_}"
    known = KnownBricks({}, {name: data.decode("latin-1")})
    kind = BrickKind.model_validate({"file": name, "unit": "m", "density": "600 kg/m3"}, context=known)
    assert kind.mass_of(kind.form) == pytest.approx(600.0 * 0.4**3 / 24.0, rel=1e-6)


def test_a_scenario_of_a_binary_file_is_checked_and_one_that_is_cut_is_told(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "box.stl").write_bytes(binary_stl(SOLIDS["box"]))
    (tmp_path / "cut.stl").write_bytes(binary_stl(SOLIDS["box"])[:-7])
    text = "scenario: meshes\nbrick: {file: %s.stl, unit: m, density: 600 kg/m3}\nbuild: [column: {levels: 2}]\n"
    (tmp_path / "box.yaml").write_text(text % "box" + "expect: [stands: all]\n", encoding="utf-8")
    (tmp_path / "cut.yaml").write_text(text % "cut", encoding="utf-8")
    assert stackdsl("check", "box.yaml").code == 0
    told = stackdsl("check", "cut.yaml")
    assert "cut.stl: the file has 677 bytes, but announces 12 triangles, which take 684" in told.out + told.err
