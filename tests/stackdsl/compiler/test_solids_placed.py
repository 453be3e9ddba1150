"""Solids and cartons as authors write them: where they come to be, what they weigh, and what is wrong with them."""

from pathlib import Path

import pytest

from stability.geometry.compound import Compound
from stability.geometry.placed_shape import bounds_W
from stability.geometry.vectors import subtract
from stability.model import Vec3
from stackdsl.checking.cases import gather
from stackdsl.diagnostics import Diagnostic
from stackdsl.timeline import Placement

HEAD = "scenario: solids\nbuild:\n  - bricks:\n"
ROOF = "{prism: {outline: [[0 mm, 0 mm], [90 mm, 0 mm], [0 mm, 60 mm]], depth: 40 mm}, density: 1000 kg/m3}"
CARTON = "{size: [400 mm, 300 mm, 200 mm], centre_of_mass: [100 mm, 0 mm, -50 mm], mass: 8 kg}"
CUBE = """\
v 0 0 0
v 5 0 0
v 5 5 0
v 0 5 0
v 0 0 5
v 5 0 5
v 5 5 5
v 0 5 5
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""


def mistakes(folder: Path, bricks: str) -> tuple[Diagnostic, ...]:
    (folder / "solids.yaml").write_text(HEAD + bricks, encoding="utf-8")
    return gather([folder / "solids.yaml"]).diagnostics


def placed(folder: Path, bricks: str) -> dict[str, Placement]:
    """All bricks by name."""
    (folder / "solids.yaml").write_text(HEAD + bricks, encoding="utf-8")
    found = gather([folder / "solids.yaml"])
    assert found.diagnostics == ()
    actions = found.cases[0].timeline.actions
    return {action.brick.id: action for action in actions if isinstance(action, Placement)}


def middle(placement: Placement) -> Vec3:
    low, high = bounds_W(placement.brick.shape, placement.pose)
    return (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))


def test_at_says_where_the_origin_of_a_solid_is(tmp_path: Path) -> None:
    roof = placed(tmp_path, f"      - {{name: roof, at: [200 mm, 0 mm, 0 mm], brick: {ROOF}}}\n")["roof"]
    assert roof.pose.position_W == pytest.approx((0.23, 0.0, 0.02))  # a third of 90 and of 60 mm from its right angle
    assert roof.brick.mass == pytest.approx(0.5 * 0.09 * 0.06 * 0.04 * 1000.0)
    low, high = bounds_W(roof.brick.shape, roof.pose)
    assert (*low, *high) == pytest.approx((0.2, -0.02, 0.0, 0.29, 0.02, 0.06))


def test_at_says_where_the_middle_of_a_carton_is_wherever_its_mass_is(tmp_path: Path) -> None:
    carton = placed(tmp_path, f"      - {{name: carton, at: [0 mm, 0 mm, 100 mm], brick: {CARTON}}}\n")["carton"]
    assert carton.pose.position_W == pytest.approx((0.1, 0.0, 0.05))
    assert middle(carton) == pytest.approx((0.0, 0.0, 0.1))


def test_a_turned_solid_turns_about_its_origin(tmp_path: Path) -> None:
    turned = f"      - {{name: roof, at: [0, 0, 90 mm], rotate: [0, 90 deg, 0], brick: {ROOF}}}\n"
    low, high = bounds_W((roof := placed(tmp_path, turned)["roof"]).brick.shape, roof.pose)
    assert (*low, *high) == pytest.approx((0.0, -0.02, 0.0, 0.06, 0.02, 0.09))


def test_on_and_beside_go_by_the_boxes_around_solids(tmp_path: Path) -> None:
    bricks = placed(
        tmp_path,
        f"      - {{name: carton, on: ground, brick: {CARTON}}}\n"
        f"      - {{name: other, on: carton, brick: {CARTON}, rotate: [0, 0, 180 deg]}}\n"
        f"      - {{name: next, beside: carton, brick: {CARTON}}}\n"
        f"      - {{name: roof, on: other, brick: {ROOF}}}\n",
    )
    assert middle(bricks["carton"]) == pytest.approx((0.0, 0.0, 0.1))
    assert middle(bricks["other"]) == pytest.approx((0.0, 0.0, 0.3))
    assert middle(bricks["next"]) == pytest.approx((0.4, 0.0, 0.1))
    assert middle(bricks["roof"]) == pytest.approx((0.0, 0.0, 0.43))


def test_a_column_of_cartons_keeps_their_sides_flush(tmp_path: Path) -> None:
    text = f"scenario: solids\nbrick: {CARTON}\nbuild:\n  - column: {{levels: 3}}\n"
    (tmp_path / "column.yaml").write_text(text, encoding="utf-8")
    found = gather([tmp_path / "column.yaml"])
    assert found.diagnostics == ()
    for level, action in enumerate(found.cases[0].timeline.actions):
        assert isinstance(action, Placement)
        assert middle(action) == pytest.approx((0.0, 0.0, 0.1 + 0.2 * level))


def test_a_wall_of_solids_is_refused_as_they_cannot_be_cut(tmp_path: Path) -> None:
    text = f"scenario: solids\nbrick: {ROOF}\nbuild:\n  - wall: {{levels: 2, bricks: 3}}\n"
    (tmp_path / "wall.yaml").write_text(text, encoding="utf-8")
    (found,) = gather([tmp_path / "wall.yaml"]).diagnostics
    assert (found.code, found.message) == ("SD104", "this layout cuts bricks, and only boxes can be cut")


def test_a_solid_inside_another_one_is_a_mistake(tmp_path: Path) -> None:
    (found,) = mistakes(
        tmp_path,
        f"      - {{name: a, at: [0, 0, 0], brick: {ROOF}}}\n      - {{name: b, at: [30 mm, 0, 0], brick: {ROOF}}}\n",
    )
    assert found.code == "SD201"


def test_solids_whose_slopes_touch_fit(tmp_path: Path) -> None:
    # The box around each goes through the other one; the solids themselves lie on each other.
    lying = f"      - {{name: b, at: [90 mm, 0, 60 mm], rotate: [0, 180 deg, 0], brick: {ROOF}}}\n"
    assert mistakes(tmp_path, f"      - {{name: a, at: [0, 0, 0], brick: {ROOF}}}\n" + lying) == ()


# --- files ------------------------------------------------------------------------------------------------------------


def test_a_solid_comes_from_a_file_beside_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "cube.obj").write_text(CUBE, encoding="utf-8")
    cube = placed(tmp_path, "      - {name: c, at: [0, 0, 0], brick: {file: cube.obj, unit: cm, mass: 100 g}}\n")["c"]
    assert cube.brick.shape.volume == pytest.approx(0.05**3)
    assert cube.pose.position_W == pytest.approx((0.025, 0.025, 0.025))


def test_a_solid_is_remembered_by_what_its_file_holds(tmp_path: Path) -> None:
    bricks = "      - {name: c, at: [0, 0, 0], brick: {file: cube.obj, unit: cm, mass: 100 g}}\n"
    (tmp_path / "cube.obj").write_text(CUBE, encoding="utf-8")
    before = placed(tmp_path, bricks)["c"].brick.shape
    (tmp_path / "cube.obj").write_text(
        CUBE.replace("v 5 5 5", "v 5 5 6").replace("v 0 5 5", "v 0 5 6"), encoding="utf-8"
    )
    assert subtract(placed(tmp_path, bricks)["c"].pose.position_W, (0.025, 0.025, 0.025)) != (0.0, 0.0, 0.0)
    assert placed(tmp_path, bricks)["c"].brick.shape != before


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        (CUBE.replace("f 4 1 5 8\n", ""), "cube.obj: the mesh has a hole"),
        (
            CUBE.replace("f 4 1 5 8", "f 8 5 1 4"),
            "cube.obj: faces 2 and 6 traverse their common edge in the same direction",
        ),
        (CUBE.replace("v 5 5 5", "v 5 five 5"), "cube.obj:7: 'five' is not a number"),
        (CUBE.replace("f 4 1 5 8", "f 4 1 5 9"), "cube.obj:14: corner 9 does not exist; 8 corners precede this face"),
        ("", "cube.obj has no faces"),
    ],
)
def test_a_file_that_holds_no_solid_is_told_with_its_line(tmp_path: Path, text: str, cause: str) -> None:
    (tmp_path / "cube.obj").write_text(text, encoding="utf-8")
    (found,) = mistakes(tmp_path, "      - {name: c, at: [0, 0, 0], brick: {file: cube.obj, unit: cm, mass: 1 g}}\n")
    assert found.code == "SD104"
    assert cause in found.message


def test_a_file_of_a_solid_that_is_not_convex_is_one_brick_of_convex_parts(tmp_path: Path) -> None:
    # A step of two cubes of 5 cm, and one on top of the first.
    outline = [(0, 0), (10, 0), (10, 5), (5, 5), (5, 10), (0, 10)]
    corners = [f"v {x} {y} {z}" for y in (0, 5) for x, z in outline]
    around = [f"f {n + 1} {n + 7} {(n + 1) % 6 + 7} {(n + 1) % 6 + 1}" for n in range(6)]
    text = "\n".join([*corners, "f 1 2 3 4 5 6", "f 12 11 10 9 8 7", *around])
    (tmp_path / "step.obj").write_text(text, encoding="utf-8")
    brick = "{name: c, at: [0, 0, 0], brick: {file: step.obj, unit: cm, density: 1000 kg/m3}}"
    step = placed(tmp_path, f"      - {brick}\n")["c"]
    assert isinstance(step.brick.shape, Compound)
    assert step.brick.mass == pytest.approx(3.0 * 0.05**3 * 1000.0)
    assert step.pose.position_W == pytest.approx((0.125 / 3.0, 0.025, 0.125 / 3.0))
    outline_too = "[[0 mm, 0 mm], [100 mm, 0 mm], [100 mm, 50 mm], [50 mm, 50 mm], [50 mm, 100 mm], [0 mm, 100 mm]]"
    brick = (
        f"{{name: c, at: [0, 0, 0], brick: {{prism: {{outline: {outline_too}, depth: 50 mm}}, density: 1000 kg/m3}}}}"
    )
    prism = placed(tmp_path, f"      - {brick}\n")["c"]
    assert prism.brick.mass == pytest.approx(step.brick.mass)
    assert sorted(prism.brick.shape.moments(1.0)) == pytest.approx(sorted(step.brick.shape.moments(1.0)))


@pytest.mark.parametrize(
    ("brick", "code", "cause"),
    [
        ("{file: nowhere.obj, unit: cm, mass: 1 g}", "SD113", "does not exist"),
        ("{file: ../cube.obj, unit: cm, mass: 1 g}", "SD113", "is outside the project"),
        ("{file: /etc/passwd, unit: cm, mass: 1 g}", "SD113", "is an absolute path"),
        ("{file: cube.obj, mass: 1 g}", "SD102", "`unit`, the unit of length in the mesh file, is missing"),
        ("{size: [1 cm, 1 cm, 1 cm], unit: cm, mass: 1 g}", "SD108", "`unit` applies only to"),
        (
            "{size: [1 cm, 1 cm, 1 cm], file: cube.obj, unit: cm, mass: 1 g}",
            "SD108",
            "exactly one of the keys size, prism",
        ),
        ("{density: 1 kg/m3}", "SD108", "exactly one of the keys size, prism, cylinder, cone, pipe, sphere, capsule"),
        ("{size: [1 cm, 1 cm, 1 cm]}", "SD108", "exactly one of the keys density, mass"),
        ("{size: [1 cm, 1 cm, 1 cm], centre_of_mass: [6 mm, 0, 0], mass: 1 g}", "SD104", "outside the box"),
        (
            "{prism: {outline: [[0, 0], [2 cm, 0], [0, 2 cm], [2 cm, 2 cm], [1 cm, 3 cm]], depth: 1 cm}, mass: 1 g}",
            "SD104",
            "crosses itself",
        ),
        ("{points: [[0, 0, 0], [1 cm, 0, 0], [0, 1 cm, 0], [1 cm, 1 cm, 0]], mass: 1 g}", "SD104", "in one plane"),
        ("{points: [[0, 0, 0], [1 cm, 0, 0], [0, 1 cm, 0]], mass: 1 g}", "SD104", "3 items; the minimum is 4"),
    ],
)
def test_what_is_no_brick_is_told_with_its_cause(tmp_path: Path, brick: str, code: str, cause: str) -> None:
    (tmp_path / "cube.obj").write_text(CUBE, encoding="utf-8")
    (tmp_path / "stackdsl.toml").touch()
    found = mistakes(tmp_path, f"      - {{name: c, at: [0, 0, 0], brick: {brick}}}\n")
    assert [(each.code, cause in each.message) for each in found] == [(code, True)], found
