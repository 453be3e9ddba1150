"""What is too much to be read, built or told is refused in one place, before it costs anything.

No time is measured here: what would take minutes if it were not refused makes the suite late by itself.
"""

import pytest

from stability.geometry.box_distance import Separation
from stability.geometry.placed_shape import InPlace, bodies_apart
from stability.statics.assembly import LIGHTEST
from stackdsl.diagnostics import MOST_REPORTED
from tests.scenes import compiled, mistakes_of

MANY = 20_000


def test_of_thousands_of_unknown_keys_the_first_are_told_and_that_there_are_more() -> None:
    keys = "\n".join(f"k{number}: 1" for number in range(MANY))
    _, mistakes = compiled(f"scenario: keys\nbuild:\n  - column: {{levels: 2}}\n{keys}\n")
    assert [mistake.code for mistake in mistakes] == ["SD101"] * MOST_REPORTED + ["SD111"]
    assert f"more than {MOST_REPORTED} mistakes" in mistakes[-1].message
    assert mistakes[-1].hint


def test_as_many_mistakes_as_are_told_are_all() -> None:
    keys = "\n".join(f"k{number}: 1" for number in range(MOST_REPORTED))
    _, mistakes = compiled(f"scenario: keys\nbuild:\n  - column: {{levels: 2}}\n{keys}\n")
    assert [mistake.code for mistake in mistakes] == ["SD101"] * MOST_REPORTED


def test_of_many_unknown_bricks_the_first_are_told() -> None:
    claims = "\n".join(f"  - rests_on: {{brick: x{n}, support: ground, share: 1 ± 0.1}}" for n in range(900))
    mistakes = mistakes_of("- column: {levels: 2}", f"expect:\n{claims}\n")
    assert [mistake.code for mistake in mistakes] == ["SD204"] * MOST_REPORTED + ["SD111"]


def test_of_bricks_in_one_place_each_is_held_against_one_other_only(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = 0

    def counted(a: InPlace, b: InPlace) -> Separation:
        nonlocal asked
        asked += 1
        return bodies_apart(a, b)

    monkeypatch.setattr("stackdsl.compiler.fit.bodies_apart", counted)
    count = 60
    bricks = "\n".join(f"    - {{name: b{number}, at: [0 mm, 0 mm, 3.9 mm]}}" for number in range(count))
    mistakes = mistakes_of(f"- bricks:\n{bricks}")
    assert [mistake.message for mistake in mistakes] == [
        f"brick 'b{n}' is 7.8 mm inside brick 'b0', at the same place" for n in range(1, count)
    ]
    assert asked <= 2 * 2 * count  # whoever was there first is held against all; and all is looked at twice


@pytest.mark.parametrize(
    ("matrix", "levels", "words"),
    [
        ("f: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]", 10_000, "up to 120000 bricks"),
        (f"f: [{', '.join(str(0.001 * n) for n in range(1, 257))}]", 500, "up to 256000 bricks"),
    ],
)
def test_all_variants_together_have_no_more_bricks_than_can_be_built_in_time(
    matrix: str, levels: int, words: str
) -> None:
    cases, (mistake,) = compiled(
        f"scenario: many\nmatrix:\n  {matrix}\nfriction: ${{f}}\nbuild:\n  - four_stack: {{levels: {levels}}}\n"
    )
    assert (cases, mistake.code, mistake.span.line) == ([], "SD206", 2)
    assert words in mistake.message
    assert mistake.hint


def test_all_variants_together_have_no_more_expressions_than_can_be_worked_out_in_time() -> None:
    row = ", ".join(str(number) for number in range(250))
    lets = "\n".join(f"  v{number}: ${{a + {number}}}" for number in range(90))
    cases, (mistake,) = compiled(
        f"scenario: many\nmatrix:\n  a: [{row}]\nlet:\n{lets}\nbuild:\n  - column: {{levels: 2}}\n"
    )
    assert (cases, mistake.code, mistake.span.line) == ([], "SD206", 2)
    assert "22500 expressions" in mistake.message


@pytest.mark.parametrize("side", ["0.0000001 mm", "0.0000009 mm"])
def test_a_side_below_a_nanometre_is_told_in_its_place(side: str) -> None:
    brick = f"- bricks: [{{name: a, brick: {{size: [1 m, 1 m, {side}], density: 700 kg/m3}}, at: [0 m, 0 m, 0 m]}}]"
    mistake = mistakes_of(brick)[0]
    assert (mistake.code, mistake.span.line) == ("SD104", 3)
    assert mistake.span.column == 3 + brick.index(side)
    assert "1e-09" in mistake.hint


@pytest.mark.parametrize(
    ("makes", "kilograms"),
    [("mass: 1e-100 g", "1e-103"), ("density: 1e-58 kg/m3", "1e-67"), ("density: 1e-320 kg/m3", "0")],
)
def test_a_brick_too_light_to_be_weighed_is_told_where_its_weight_is_written(makes: str, kilograms: str) -> None:
    brick = f"- bricks: [{{name: a, brick: {{size: [1 mm, 1 mm, 1 mm], {makes}}}, at: [0 m, 0 m, 0.5 mm]}}]"
    (mistake,) = mistakes_of(brick)
    assert (mistake.code, mistake.span.line) == ("SD104", 3)
    assert mistake.span.column == 3 + brick.index(makes.partition(": ")[2])
    assert f"a brick of {kilograms} kg" in mistake.message
    assert f"minimum mass is {LIGHTEST:g} kg" in mistake.hint


@pytest.mark.parametrize(
    ("wall", "rest"),
    [
        ("{levels: 2, bricks: 2, gap: 117.5999999999 mm}", ""),
        ("{levels: 2, bricks: 2}", f"brick: {{size: [90 mm, 20 mm, 6 mm], mass: {1.5 * LIGHTEST} kg}}"),
    ],
    ids=["too short", "too light"],
)
def test_half_planks_too_small_for_statics_are_told_at_their_wall(wall: str, rest: str) -> None:
    mistake = mistakes_of(f"- wall: {wall}", rest)[0]
    assert (mistake.code, str(mistake.span)) == ("SD104", "scene.yaml:3:11")
    assert "cuts brick 'L2.1' to" in mistake.message
    assert mistake.hint
