"""MJCF and URDF: free bodies of one box or one convex mesh; all else that such a file has is named."""

import sys
from collections.abc import Mapping
from math import pi
from pathlib import Path

import pytest

from stability.contact_law import Friction, as_friction
from stability.model import Plane
from stackdsl.checking.cases import gather
from stackdsl.diagnostics import Diagnostic
from stackdsl.exits import ExitCode
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedLoad, UnreadableLoadError
from stackdsl.language.imports import Import
from tests.command_line import Stackdsl, stackdsl_in_folder, write
from tests.stackdsl.importers.loads import TEXTS, beside, skip_without_parser

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

URDF, MJCF = TEXTS["urdf"], TEXTS["mjcf"]
NOTHING: Mapping[str, object] = {}


def read(text: str, said: Mapping[str, object] = NOTHING) -> ImportedLoad:
    skip_without_parser("mjcf" if "<mujoco" in text else "urdf")
    return read_plainly(text, said)


def read_plainly(text: str, said: Mapping[str, object] = NOTHING) -> ImportedLoad:
    return read_load(text.encode("utf-8"), "a", Import.model_validate({"file": "a", **said}), beside)


def mistakes(text: str, said: Mapping[str, object] = NOTHING) -> list[Diagnostic]:
    with pytest.raises(UnreadableLoadError) as caught:
        read(text, said)
    return list(caught.value.diagnostics)


def put(text: str, before: str, added: str) -> str:
    assert before in text
    return text.replace(before, f"{added}\n{before}", 1)


@pytest.mark.parametrize(("text", "names"), [(URDF, ["base", "carton", "wedge"]), (MJCF, ["base", "crate", "ramp"])])
def test_free_bodies_are_bricks_of_their_names(text: str, names: list[str]) -> None:
    assert [box.name for box in read(text).boxes] == names


def test_a_mass_that_is_not_in_the_middle_stays_where_it_is() -> None:
    carton = read(URDF).boxes[1]
    assert carton.centre_of_mass is not None
    assert [float(part) for part in carton.centre_of_mass] == pytest.approx([0.05, 0.0, 0.0])
    assert [float(part) for part in carton.turn] == pytest.approx([0.0, 0.0, 180.0])
    assert read(URDF).boxes[2].centre_of_mass is None  # a third of each side, as of an even wedge


def test_a_density_of_mujoco_comes_to_a_mass() -> None:
    _, crate, ramp = read(MJCF).boxes
    assert float(crate.mass) == pytest.approx(1000.0 * 0.3 * 0.4 * 0.2)
    assert float(ramp.mass) == pytest.approx(500.0 * 0.5 * 0.3 * 0.3 * 0.2, rel=1e-6)


def test_a_scene_that_lets_mujoco_fuse_what_is_fixed_is_read_body_by_body() -> None:
    fusing = put(MJCF, "  <worldbody>", '  <compiler fusestatic="true"/>')
    assert [box.name for box in read(fusing).boxes] == ["base", "crate", "ramp"]
    shelf = '<body name="shelf" pos="2 0 1"><geom type="box" size=".1 .1 .1"/></body>'
    (found,) = mistakes(put(fusing, "  </worldbody>", shelf))
    assert "'shelf' is fixed, but bricks move freely" in found.message
    assert [box.name for box in read(put(fusing, "  </worldbody>", shelf), {"ignore": ["shelf"]}).boxes][-1] == "ramp"


BODY = '<body name="odd" pos="2 0 1">{}</body>'
BOX = '<geom type="box" size=".1 .1 .1"/>'
IN_MJCF = {
    BODY.format(f'<joint type="hinge"/>{BOX}'): "'odd' has a hinge or a slide",
    BODY.format(BOX): "'odd' is fixed, but bricks move freely",
    BODY.format(f"<freejoint/>{BOX}{BOX}"): "'odd' has 2 shapes, but a brick must have one",
    BODY.format(
        '<freejoint/><geom type="ellipsoid" size=".1 .2 .3"/>'
    ): "'odd' is a ellipsoid, but a brick must be a box, a round",
}


@pytest.mark.parametrize("added", IN_MJCF)
def test_a_body_of_a_scene_that_is_no_brick_is_named_and_may_be_passed_over(added: str) -> None:
    text = put(MJCF, "  </worldbody>", added)
    (found,) = mistakes(text)
    assert found.code == "SD115"
    assert found.message.startswith(IN_MJCF[added])
    assert found.span.line == 1 + text[: text.index('<body name="odd"')].count("\n")
    assert read(text, {"ignore": ["odd"]}).boxes == read(MJCF).boxes


SECTIONS = {
    '<actuator><motor joint="j"/></actuator>': "actuator",
    '<equality><weld body1="base" body2="crate"/></equality>': "equality",
    '<contact><exclude body1="base" body2="crate"/></contact>': "contact",
    '<include file="/etc/passwd"/>': "include",
    '<extension><plugin plugin="mujoco.elasticity.cable"/></extension>': "extension",
    '<option gravity="0 0 -1.62"/>': "gravity",
}


@pytest.mark.parametrize("added", SECTIONS)
def test_elements_other_than_bodies_are_named_and_may_be_ignored(added: str) -> None:
    text = put(MJCF, "  <worldbody>", added)
    (found,) = mistakes(text)
    assert (found.code, found.message) == ("SD115", f"'{SECTIONS[added]}' is not supported")
    assert len(read(text, {"ignore": [SECTIONS[added]]}).boxes) == 3


def test_friction_of_a_scene_may_be_passed_over() -> None:
    text = MJCF.replace('mass="24"', 'mass="24" friction="0.2"')
    load = read(text, {"ignore": ["friction"]})
    assert load.surfaces is None
    assert {box.friction for box in load.boxes} == {None}


def test_ways_of_touching_are_named_until_they_are_passed_over() -> None:
    text = MJCF.replace('mass="24"', 'mass="24" condim="1"')
    assert [found.message for found in mistakes(text)] == ["'condim' is not supported"]
    assert read(text, {"ignore": ["condim"]}).boxes


def test_a_shape_of_the_world_itself_is_the_ground_or_named() -> None:
    (found,) = mistakes(put(MJCF, "    <body", f"    {BOX}"))
    assert found.message == "the shape belongs to the world and is fixed, but only the ground at z = 0 can be fixed"
    assert len(mistakes(MJCF.replace('type="plane"', 'type="plane" pos="0 0 0.1"'))) == 1
    assert len(mistakes(MJCF.replace('type="plane"', 'type="plane" euler="0 5 0"'))) == 1


def test_visuals_and_sensors_are_named_as_ignored() -> None:
    assert read(MJCF).skipped == ("option", "light")
    assert read(URDF).skipped == ("inertia",)


def test_a_scene_that_mujoco_does_not_load_is_told_in_its_line() -> None:
    (found,) = mistakes(MJCF.replace('mass="24"', 'mass="heavy"'))
    assert found.message.startswith("MuJoCo reports:")
    assert found.span.line == 1 + MJCF[: MJCF.index('mass="24"')].count("\n")


def test_a_mesh_that_is_not_convex_is_told_with_what_it_lacks() -> None:
    corners = "0 0 0  2 0 0  2 0 1  1 0 1  1 0 2  0 0 2 " + "0 1 0  2 1 0  2 1 1  1 1 1  1 1 2  0 1 2"
    front = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    back = [(a + 6, c + 6, b + 6) for a, b, c in front]
    around = [((n + 1) % 6, n, n + 6) for n in range(6)] + [((n + 1) % 6, n + 6, (n + 1) % 6 + 6) for n in range(6)]
    faces = " ".join(str(corner) for face in (*front, *back, *around) for corner in face)
    bent = f'<mesh name="wedge" vertex="{corners}" face="{faces}"/>'
    lines = [bent if "<mesh name" in line else line for line in MJCF.splitlines()]
    (found,) = mistakes("\n".join(lines))
    assert (found.code, "'ramp': the solid is not convex" in found.message) == ("SD114", True)


def test_round_bodies_of_a_scene_stay_round() -> None:
    shapes = {"ball": '"sphere" size=".1"', "can": '"cylinder" size=".1 .2"', "pill": '"capsule" size=".1 .2"'}
    bodies = "".join(
        f'<body name="{name}" pos="{x} 0 .5" euler="90 0 0"><freejoint/><geom type={geom}/></body>'
        for x, (name, geom) in enumerate(shapes.items(), start=2)
    )
    *_, ball, can, pill = read(put(MJCF, "  </worldbody>", bodies)).boxes
    assert [box.curved for box in (ball, can, pill)] == ["sphere", "cylinder", "capsule"]
    heights = [tuple(map(float, box.size)) for box in (ball, can, pill)]
    assert heights == [(0.2, 0.2, 0.2), (0.2, 0.2, 0.4), (0.2, 0.2, 0.6)]
    assert float(can.mass) == pytest.approx(1000.0 * pi * 0.1**2 * 0.4)
    assert not can.is_upright
    assert tuple(map(float, can.turn)) == pytest.approx((90.0, 0.0, 0.0))


LINK = '<link name="odd"><inertial><mass value="1"/></inertial><collision><geometry>{}</geometry></collision></link>'
JOINT = '<joint name="j" type="{}"><parent link="{}"/><child link="odd"/></joint>'
CUBE = '<box size="1 1 1"/>'
IN_URDF = {
    LINK.format(CUBE) + JOINT.format("fixed", "world"): "'odd' has a fixed joint, but bricks move freely",
    LINK.format(CUBE) + JOINT.format("revolute", "base"): "'odd' has a revolute joint, but bricks move freely",
    LINK.format(CUBE)
    + JOINT.format("floating", "base"): "the floating joint of 'odd' has the parent 'base' instead of the world",
    LINK.format(CUBE): "'odd' is a root link with a shape, so it is fixed, but bricks move freely",
}


def test_round_links_stay_round() -> None:
    ball, can = ('<sphere radius="1"/>', "sphere", 2.0), ('<cylinder radius="1" length="3"/>', "cylinder", 3.0)
    for geometry, kind, height in (ball, can):
        added = LINK.format(geometry) + JOINT.format("floating", "world")
        odd = read(put(URDF, "</robot>", added)).boxes[-1]
        assert (odd.curved, tuple(map(float, odd.size))) == (kind, (2.0, 2.0, height))


@pytest.mark.parametrize("added", IN_URDF)
def test_a_link_that_is_no_brick_is_named_and_may_be_passed_over(added: str) -> None:
    added = added.replace('revolute">', 'revolute"><limit lower="0" upper="1" effort="1" velocity="1"/>')
    text = put(URDF, "</robot>", added)
    (found,) = mistakes(text)
    assert found.code == "SD115"
    assert found.message.startswith(IN_URDF[added.replace('<limit lower="0" upper="1" effort="1" velocity="1"/>', "")])
    assert read(text, {"ignore": ["odd"]}).boxes == read(URDF).boxes


@pytest.mark.parametrize(
    ("written", "instead", "message"),
    [
        ('size="0.4 0.3 0.2"', 'size="0.4 0.3"', "urdf_parser_py reports:"),
        ('<mass value="24"/>', "", "urdf_parser_py reports:"),
        ('<mass value="24"/>', '<mass value="0"/>', "'base' has no mass"),
        ('<mass value="24"/>', '<mass value="nan"/>', "`value` of <mass> contains 'nan', which is not a finite number"),
        ('xyz="0 0 0.1"', 'xyz="0 0 nan"', "`xyz` of <origin> contains 'nan', which is not a finite"),
        ('xyz="0.05 0 0"', 'xyz="1e308 0 0"', "'carton', its centre of mass or one of its corners is more than 10 km"),
        ('rpy="0 0 3.141592653589793"', 'rpy="0 0 inf"', "`rpy` of <origin> contains 'inf', which is not a finite"),
        ('scale="0.001 0.001 0.001"', 'scale="0.001 0.001 nan"', "`scale` of <mesh> contains 'nan', which is not"),
        ('scale="0.001 0.001 0.001"', 'scale="0.001 0.001 1e308"', "'wedge', its centre of mass or one of its corners"),
        ('filename="block.obj"', 'filename="nowhere.obj"', "cannot read 'nowhere.obj'"),
        (
            'filename="block.obj"',
            'filename="package://x/block.stl"',
            "the mesh 'package://x/block.stl' is not an OBJ, STL or PLY file",
        ),
        ('<child link="base"/>', '<child link="wedge"/>', "joint 'wedge-in-world' connects 'world' to 'wedge'"),
        ('<link name="base">', '<link name="wedge">', "two links have the name 'wedge'"),
        ("</robot>", "", "invalid XML: no element found"),
        ("<robot", "<!DOCTYPE robot><robot", "the file has a document type declaration"),
    ],
)
def test_a_urdf_that_is_wrong_is_told(written: str, instead: str, message: str) -> None:
    assert written in URDF
    found = mistakes(URDF.replace(written, instead))[0]
    assert found.code == "SD114"
    assert found.message.startswith(message)
    assert found.hint


def test_other_elements_of_a_link_are_named() -> None:
    (found,) = mistakes(put(URDF, "</robot>", '<transmission name="t"/>'))
    assert found.message == "'transmission' is not supported"
    seen = URDF.replace("<collision>", '<visual><geometry><sphere radius="1"/></geometry></visual><collision>', 1)
    assert "visual" in read(seen).skipped


def test_without_its_parser_a_format_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for module, text in (("mujoco", MJCF), ("urdf_parser_py", URDF)):
        monkeypatch.setitem(sys.modules, module, None)
        monkeypatch.setitem(sys.modules, f"{module}.urdf", None)
        for own in ("mujoco_binding", "compiled_scene"):
            monkeypatch.delitem(sys.modules, f"stability.engines.mujoco.{own}", raising=False)
        with pytest.raises(UnreadableLoadError) as caught:
            read_plainly(text)
        (found,) = caught.value.diagnostics
        assert (found.code, "is not installed" in found.message) == ("SD115", True)


def test_a_mesh_outside_of_the_project_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    skip_without_parser("urdf")
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside" / "stackdsl.toml").touch()
    (tmp_path / "block.obj").write_bytes(beside("block.obj"))
    monkeypatch.chdir(tmp_path / "inside")
    Path("a.urdf").write_text(URDF.replace("block.obj", "../block.obj"), encoding="utf-8")
    Path("a.yaml").write_text("scenario: a\nbuild:\n  - import: {file: a.urdf}\n", encoding="utf-8")
    (found,) = gather([Path("a.yaml")]).diagnostics
    assert (found.code, found.span.file) == ("SD114", "a.urdf")
    assert "is outside the project" in found.message
    Path("a.urdf").write_text(URDF, encoding="utf-8")
    Path("block.obj").write_bytes(beside("block.obj"))
    assert gather([Path("a.yaml")]).diagnostics == ()


def test_a_mesh_of_a_scene_may_be_in_a_file() -> None:
    text = MJCF.replace('<mesh name="wedge" vertex', '<mesh name="other" vertex')
    text = put(text, "  </asset>", '    <mesh name="wedge" file="block.obj" scale="0.001 0.001 0.001"/>')
    theirs, ours = read(MJCF).boxes[2], read(text).boxes[2]
    assert [float(side) for side in ours.size] == pytest.approx([float(side) for side in theirs.size], abs=1e-6)
    assert [float(part) for part in ours.centre] == pytest.approx([float(part) for part in theirs.centre], abs=1e-6)


def test_the_command_tells_what_of_a_scene_is_not_taken(stackdsl: Stackdsl, tmp_path: Path) -> None:
    skip_without_parser("mjcf")
    write(tmp_path, put(MJCF, "  <worldbody>", "  <actuator/>"), "scene.xml")
    printed = stackdsl("import", "scene.xml")
    assert (printed.code, printed.out) == (ExitCode.INVALID, "")
    assert "SD115 'actuator' is not supported" in printed.err


ROUGH = MJCF.replace('mass="24"', 'mass="24" friction="0.2"')
KEPT = "{ground: {friction: 0.7}, friction: {rule: higher}}"


def played(scene: str, world: str, folder: Path, format_: str = "mjcf") -> list[Diagnostic] | Friction:
    skip_without_parser(format_)
    (folder / "scene.xml").write_text(scene, encoding="utf-8")
    steps = f"build: [{{every: 1 s, import: {{file: scene.xml, format: {format_}}}}}]\n"
    text = f"scenario: rough\nworld: {world}\n{steps}systems: [exact]\nexpect: [stands: all]\n"
    (folder / "rough.yaml").write_text(text, encoding="utf-8")
    found = gather([folder / "rough.yaml"])
    return list(found.diagnostics) or as_friction(found.cases[0].timeline.world.friction)


def test_bodies_of_a_scene_rub_as_mujoco_has_it(tmp_path: Path) -> None:
    law = played(ROUGH, KEPT, tmp_path)
    assert isinstance(law, Friction)
    # MuJoCo gives a shape that says nothing 1.0, and two that touch the larger of both.
    assert law.of("base", "base") == pytest.approx(0.2)
    assert law.of("base", "crate") == pytest.approx(1.0)
    assert law.on("base", Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.7)) == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("world", "message", "hint"),
    [
        (
            "{ground: {friction: 0.7}}",
            "this file combines friction coefficients by the rule `higher`, but the scenario by the rule `lower`",
            "{friction: {rule: higher}}",
        ),
        ("{friction: {rule: higher}}", "sets a friction coefficient of 1 for the ground", "{ground: {friction: 1}}"),
    ],
)
def test_a_scenario_that_takes_frictions_otherwise_is_told(tmp_path: Path, world: str, message: str, hint: str) -> None:
    told = played(ROUGH, world, tmp_path)
    assert isinstance(told, list)
    assert [each.code for each in told] == ["SD115"]
    assert message in told[0].message
    assert hint in told[0].hint


def test_a_scene_with_frictions_is_written_with_what_keeps_them(stackdsl: Stackdsl, tmp_path: Path) -> None:
    skip_without_parser("mjcf")
    (tmp_path / "scene.xml").write_text(ROUGH, encoding="utf-8")
    done = stackdsl("import", "scene.xml")
    assert done.code == 0
    assert "world: {ground: {friction: 1.0}, friction: {rule: higher}}" in done.out
    assert "mass: 24 kg}, friction: 0.2}" in done.out
    (tmp_path / "made.yaml").write_text(done.out, encoding="utf-8")
    assert stackdsl("check", "made.yaml", "--no-golden").code == 0


def test_a_friction_that_no_brick_may_have_is_told_where_it_stands() -> None:
    (found,) = mistakes(MJCF.replace('mass="24"', 'mass="24" friction="12"'))
    assert found.message == "'base' has an invalid friction coefficient of 12"


ROUGH_LINK = """<robot name="crate">
  <link name="crate">
    <contact>
      <lateral_friction value="0.3"/>
    </contact>
    <inertial>
      <origin xyz="0 0 0.1"/>
      <mass value="24"/>
    </inertial>
    <collision>
      <origin xyz="0 0 0.1"/>
      <geometry>
        <box size="0.4 0.3 0.2"/>
      </geometry>
    </collision>
  </link>
</robot>
"""


def test_a_link_has_the_friction_that_it_says_and_the_scenario_says_what_two_have(tmp_path: Path) -> None:
    law = played(ROUGH_LINK, "{friction: {rule: mean}}", tmp_path, "urdf")
    assert isinstance(law, Friction)
    assert law.of("crate", "another") == pytest.approx(0.5 * (0.3 + 0.5))
    told = played(ROUGH_LINK, "{}", tmp_path, "urdf")
    assert isinstance(told, list)
    assert [each.code for each in told] == ["SD115"]
    assert told[0].message.startswith("the file sets the friction of each body, but no rule")


def test_a_rule_that_is_asked_for_is_written(stackdsl: Stackdsl, tmp_path: Path) -> None:
    skip_without_parser("urdf")
    (tmp_path / "things.urdf").write_text(ROUGH_LINK, encoding="utf-8")
    left_open = stackdsl("import", "things.urdf")
    assert left_open.code == 2
    assert "write --rule lower, or another rule, or --ignore contact" in left_open.err
    assert "world: {friction: {rule: mean}}" in stackdsl("import", "things.urdf", "--rule", "mean").out
    passed_over = stackdsl("import", "things.urdf", "--ignore", "contact").out
    assert "rule" not in passed_over
    assert "friction: 0.3" not in passed_over


@pytest.mark.parametrize("value", ["rough", ""])
def test_a_friction_of_a_link_that_is_no_number_is_told_in_its_line(value: str) -> None:
    (found,) = mistakes(ROUGH_LINK.replace('value="0.3"', f'value="{value}"'))
    assert found.message == "the friction is not a number"


ODD = {"nan": "which is not a finite number", "inf": "which is not a finite number", "٠.١": "finite", "1_0": "finite"}


@pytest.mark.parametrize("number", ODD)
def test_a_number_that_is_one_to_python_only_is_refused_before_its_parser_reads_it(number: str) -> None:
    for text, old in ((URDF, 'mass value="'), (MJCF, 'size="')):
        place = text.index(old) + len(old)
        odd = text[:place] + number + text[text.index('"', place) :]
        with pytest.raises(UnreadableLoadError) as caught:
            read_plainly(odd)
        assert f"'{number}'" in caught.value.diagnostics[0].message


@pytest.mark.parametrize("made", ['builtin="sphere" params="12"', 'builtin="supersphere" params="99999 9 1 1"'])
def test_a_mesh_that_mujoco_would_make_by_itself_is_refused(made: str) -> None:
    text = put(MJCF, "  </asset>", f'<mesh name="made" {made}/>') if "</asset>" in MJCF else ""
    text = text or put(MJCF, "  <worldbody>", f'<asset><mesh name="made" {made}/></asset>')
    with pytest.raises(UnreadableLoadError) as caught:
        read_plainly(text)
    assert "lets MuJoCo generate the mesh" in caught.value.diagnostics[0].message
