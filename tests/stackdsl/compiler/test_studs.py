"""Bricks with studs: places in studs, a base plate, and mistakes with their place."""

import pytest

from stability.geometry.vectors import body_axes
from stability.joints import Studs
from stability.model import Vec3
from stability.problem import Placed
from stackdsl.diagnostics import Diagnostic
from stackdsl.timeline import FixedWorld, Timeline
from tests.scenes import compiled

LEGO = Studs(0.008, 1.7, 100.0, 2.8)
SCENE = """
scenario: scene
brick: lego_2x4
world: {ground: {studs: lego}}
build:
  - bricks: [%s]
"""


def timeline(bricks: str, scene: str = SCENE) -> Timeline:
    cases, mistakes = compiled(scene % bricks)
    assert mistakes == []
    return cases[0].timeline


def world(bricks: str, scene: str = SCENE) -> FixedWorld:
    return timeline(bricks, scene).world


def only_mistake(bricks: str, scene: str = SCENE) -> Diagnostic:
    mistake, *others = compiled(scene % bricks)[1]
    assert others == []
    assert mistake.hint
    return mistake


def test_a_place_in_studs_is_the_lowest_corner_of_the_brick() -> None:
    bricks = "{name: a, stud: [0, 0, 0]}, {name: b, stud: [2, -1, 1 brick], turned: true}, "
    bricks += "{name: c, stud: [3, 0, 6 plates], brick: lego_plate_1x2}"
    poses = {placed.brick.id: placed.pose for placed in timeline(bricks).placements}
    centres: dict[str, Vec3] = {
        "a": (0.016, 0.008, 0.0048),
        "b": (0.024, 0.008, 0.0144),
        "c": (0.032, 0.004, 0.0208),
    }
    assert {name: pose.position_W for name, pose in poses.items()} == pytest.approx(centres)
    along = {name: [round(part) for part in body_axes(pose.orientation)[0]] for name, pose in poses.items()}
    assert along == {"a": [1, 0, 0], "b": [0, 1, 0], "c": [1, 0, 0]}


def test_bricks_of_one_kind_of_studs_hold_each_other_and_a_base_plate() -> None:
    bricks = "{name: a, stud: [0, 0, 0]}, {name: b, stud: [2, 0, 1 brick]}, "
    bricks += "{name: c, on: b, brick: {size: [32 mm, 16 mm, 9.6 mm], mass: 2 g}}"
    joints = world(bricks).joints
    pairs = [("a", "b"), ("b", "a"), ("a", "ground"), ("b", "c"), ("c", "ground")]
    assert [joints.of(*pair) for pair in pairs] == [LEGO, LEGO, LEGO, None, None]
    bare = world(bricks, SCENE.replace("{ground: {studs: lego}}", "{}"))
    assert [bare.joints.of(*pair) for pair in (("a", "b"), ("a", "ground"))] == [LEGO, None]


def test_own_studs_are_written_on_the_kind_of_brick_and_joints_overrule_them() -> None:
    scene = SCENE.replace(
        "brick: lego_2x4", "brick_types: {big: {size: [63.8 mm, 31.8 mm, 19.2 mm], mass: 10 g, studs: &own %s}}\n"
        "brick: big\njoints: [{between: [a, b], dry: true}]"
    ).replace("studs: lego", "studs: *own")  # fmt: skip
    own = "{pitch: 16 mm, pull: 3 N, shear: 50 N}"
    bricks = "{name: a, stud: [0, 0, 0]}, {name: b, stud: [0, 1, 1 brick]}, {name: c, stud: [0, 0, 2 bricks]}"
    joints = world(bricks, scene.replace("%s", own, 1)).joints
    pairs = [("a", "b"), ("b", "c"), ("a", "ground")]
    assert [joints.of(*pair) for pair in pairs] == [None, Studs(0.016, 3.0, 50.0), Studs(0.016, 3.0, 50.0)]


@pytest.mark.parametrize("joints", ["", "joints: [{studs: {pitch: 8 mm, pull: 3 N, shear: 90 N}}]"])
def test_a_tile_grips_the_brick_below_and_has_no_studs_for_the_one_above(joints: str) -> None:
    bricks = "{name: a, stud: [0, 0, 0]}, {name: t, stud: [0, 0, 1 brick], brick: lego_tile_2x4}, "
    bricks += "{name: b, on: t, offset: [8 mm, 0 mm, 0 mm]}"
    scene = SCENE.replace("brick: lego_2x4", f"brick: lego_2x4\nexpect: [{{stands: all}}]\n{joints}")
    assembly = world(bricks, scene).assembly()
    assembly.add_all(Placed(placed.brick, placed.pose) for placed in timeline(bricks, scene).placements)
    joined = {(c.lower, c.upper) for c in assembly.all_contacts() if not c.law.is_cone}
    assert joined == {("ground", "a"), ("a", "t")}


def test_a_brick_may_hang_from_the_studs_that_it_grips() -> None:
    bricks = "{name: a, stud: [0, 0, 0]}, {name: b, stud: [2, 0, 1 brick]}, {name: c, stud: [5, 0, 0], brick: lego_1x1}"
    hanging = SCENE.replace("lego_2x4", "lego_2x4\nexpect: [{stands: all}]")
    assert compiled(hanging % bricks.replace("c, stud: [5, 0, 0]", "c, stud: [4, 0, 0]"))[1] == []
    arm = "{stud: [0, 0, 0], brick: lego_2x2}, {stud: [0, 0, 1 brick], brick: lego_2x2}, {stud: [0, 0, 2 bricks]}"
    low, step = "{name: low, stud: [2, 0, 1 brick], brick: lego_2x2}", "]\n  - bricks: ["
    assert compiled(hanging % f"{arm}{step}{low}")[1] == []
    (mistake,) = compiled(
        (hanging % f"{low}{step}{arm}").replace(f"  - bricks: [{arm}]", f"  - bricks: [{arm}]\n    at: 1 s")
    )[1]
    assert mistake.message.startswith("brick 'low' has no support")
    assert "with or after the brick whose joint holds it" in mistake.hint


@pytest.mark.parametrize(
    ("bricks", "code", "place", "message"),
    [
        ("{stud: [0, 0, 0]}, {stud: [2, 0, 0]}", "SD201", "6:33", "is 9.6 mm inside brick"),
        ("{stud: [0, 0, 0]}, {name: high, stud: [0, 0, 3 bricks]}", "SD202", "6:33", "brick 'high' has no support"),
        (
            "{name: a, stud: [0, 0, 0]}, {name: b, on: a, offset: [4 mm, 0 mm, 0 mm]}",
            "SD201",
            "6:42",
            "brick 'b' is off the studs of brick 'a'",
        ),
        ("{stud: [0, 0, 1]}", "SD104", "6:28", "1 is not a height in bricks or plates"),
        ("{stud: [0, 0, 1 m]}", "SD104", "6:28", "'1 m' is not a height in bricks or plates"),
        ("{stud: [0, 0, -1 plate]}", "SD104", "6:28", "a height of -1 plate is out of range"),
        ("{stud: [0.5, 0, 0]}", "SD103", "6:22", "expected a whole number"),
        ("{stud: [0, 0, 0], brick: kapla}", "SD108", "6:14", "'kapla' has none"),
        (
            "{stud: [0, 0, 0], rotate: [0 deg, 0 deg, 90 deg]}",
            "SD108",
            "6:14",
            "`rotate` and `stud` exclude each other",
        ),
        ("{on: ground, turned: true}", "SD108", "6:14", "`turned` applies only with `stud`"),
        ("{stud: [0, 0, 0], offset: [1 mm, 0 mm, 0 mm]}", "SD108", "6:14", "but this brick has `stud`"),
        ("{stud: [0, 0, 0], on: ground}", "SD108", "6:14", "exactly one of the keys at, stud, on, beside"),
    ],
)
def test_mistakes_with_studs_are_told_with_their_place(bricks: str, code: str, place: str, message: str) -> None:
    mistake = only_mistake(bricks)
    assert (mistake.code, f"{mistake.span.line}:{mistake.span.column}") == (code, place)
    assert message in mistake.message


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("{size: [12 mm, 16 mm, 9.6 mm], mass: 2 g, studs: lego}", "a side of 12 mm does not fit studs every 8 mm"),
        (
            "{prism: {outline: [[0 mm, 0 mm], [8 mm, 0 mm], [0 mm, 8 mm]], depth: 8 mm}, mass: 2 g, studs: lego}",
            "a box",
        ),
        ("{size: [32 mm, 16 mm, 9.6 mm], mass: 2 g, studs: duplo}", "expected 'lego' or a mapping, not 'duplo'"),
    ],
)
def test_studs_need_a_box_of_whole_studs(kind: str, message: str) -> None:
    assert message in only_mistake("{stud: [0, 0, 0]}", SCENE.replace("lego_2x4", kind)).message


def test_the_kind_of_the_scenario_must_have_studs_for_places_in_studs() -> None:
    scene = SCENE.replace("brick: lego_2x4\nworld: {ground: {studs: lego}}\n", "")
    mistake = only_mistake("{stud: [0, 0, 0]}", scene)
    assert (mistake.span.line, mistake.span.column) == (4, 15)
    assert "'kapla' has none" in mistake.message


@pytest.mark.parametrize(
    ("brick", "message"),
    [
        ("{name: b, stud: [12, 4, 0]}", ""),
        ("{name: b, stud: [13, 0, 0]}", "brick 'b' is not all on the base plate of 16 x 8 studs"),
        ("{name: b, stud: [4, 5, 0], turned: true}", "brick 'b' is not all on the base plate of 16 x 8 studs"),
        ("{name: b, stud: [-1, 2, 0]}", "brick 'b' is not all on the base plate of 16 x 8 studs"),
        ("{name: b, at: [100 mm, 8 mm, 4.8 mm]}", "brick 'b' is off the studs of the ground"),
    ],
)
def test_a_brick_stands_on_the_studs_of_the_base_plate(brick: str, message: str) -> None:
    scene = SCENE.replace("studs: lego", "studs: lego, plate: [16, 8]")
    told = [mistake.message for mistake in compiled(scene % f"{{name: a, stud: [0, 0, 0]}}, {brick}")[1]]
    assert told == [message] * bool(message)
    alone = "{name: a, at: [100 mm, 12 mm, 4.8 mm]}"
    assert [each.message for each in compiled(scene % alone)[1]] == ["brick 'a' is off the studs of the ground"]
    assert compiled(SCENE % alone)[1] == []
    beside = [each.message for each in compiled(SCENE % f"{alone}, {{name: b, stud: [0, 0, 0]}}")[1]]
    assert beside == ["brick 'b' is off the studs of the ground, on which brick 'a' stands"]
    overhang = "{name: a, stud: [12, 0, 0]}, {name: b, stud: [14, 0, 1 brick]}"
    assert compiled(scene % overhang)[1] == []


def test_a_base_plate_has_studs() -> None:
    mistake = only_mistake("{on: ground, brick: kapla}", SCENE.replace("studs: lego", "plate: [16, 8]"))
    assert (mistake.code, mistake.span.line) == ("SD102", 4)


def test_studs_of_the_ground_need_a_brick_that_they_hold() -> None:
    mistake = only_mistake("{on: ground}", SCENE.replace("lego_2x4", "kapla"))
    assert (mistake.span.line, mistake.message) == (4, "no brick has the studs of the ground")


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("2x4", "did you mean 'lego_2x4'?"),
        ("lego-4x2", "did you mean 'lego_2x4'?"),
        ("lego plate 1x3", "did you mean 'lego_plate_1x3'?"),
        ("lego_2x5", "choose from: lego_1x1, lego_1x2, lego_1x3, lego_1x4, lego_1x6, lego_1x8, lego_2x2"),
        ("duplo", "define it under `brick_types`"),
    ],
)
def test_another_spelling_of_a_brick_is_understood(name: str, hint: str) -> None:
    assert hint in only_mistake("{on: ground}", SCENE.replace("lego_2x4", name)).hint
