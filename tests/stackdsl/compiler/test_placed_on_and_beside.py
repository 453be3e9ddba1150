"""Bricks that are placed `on` or `beside` others: where they come to lie, and when nobody can know where that is."""

from math import sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stability.geometry.box import Box
from stability.model import Plane, Pose, Vec3
from stackdsl.compiler.bricks import IncrementalNaming, WrittenBrick, footings_of, levels_of, names_of
from stackdsl.language.bricks import BrickKind
from tests.scenes import mistakes_of, timeline_of

BASE = "- bricks:\n    - {name: beam, on: ground, offset: [1 m, 0, 0]}\n"


def centres(build: str, rest: str = "") -> dict[str, Vec3]:
    """Where each brick is placed, in mm."""
    placed = timeline_of(build, rest).placements
    return {each.brick.id: tuple(round(1000 * part, 6) for part in each.pose.position_W) for each in placed}  # type: ignore[misc]  # three


@pytest.mark.parametrize(
    ("brick", "centre"),
    [
        ("on: beam", (1000, 0, 11.7)),
        ("on: beam, offset: [10 mm, -5 mm, 0]", (1010, -5, 11.7)),
        ("on: beam, rotate: [90 deg, 0, 0]", (1000, 0, 7.8 + 11.7)),  # on its narrow side
        ("on: beam, rotate: [0, 90 deg, 0]", (1000, 0, 7.8 + 58.8)),  # on end
        ("on: ground", (0, 0, 3.9)),
        ("beside: beam", (1117.6, 0, 3.9)),
        ("beside: beam, towards: 180 deg", (882.4, 0, 3.9)),
        ("beside: beam, towards: 90 deg, offset: [0, 1 mm, 0]", (1000, 24.4, 3.9)),
        ("beside: beam, towards: 90 deg, rotate: [0, 0, 90 deg]", (1000, 11.7 + 58.8, 3.9)),
        ("beside: beam, rotate: [90 deg, 0, 0]", (1117.6, 0, 11.7)),  # as low as the beam
    ],
)
def test_a_brick_lies_on_or_beside_another_without_any_height_worked_out(brick: str, centre: Vec3) -> None:
    assert centres(f"{BASE}    - {{name: x, {brick}}}")["x"] == pytest.approx(centre)


def test_a_brick_beside_another_at_an_angle_does_not_overlap_it() -> None:
    far = centres(f"{BASE}    - {{name: x, beside: beam, towards: 45 deg}}")["x"]
    assert (far[0] - 1000, far[1]) == pytest.approx(((117.6 + 23.4) / 2, (117.6 + 23.4) / 2))
    assert sqrt(2) * far[1] == pytest.approx((117.6 + 23.4) / sqrt(2))


def test_a_brick_on_several_lies_in_their_middle_on_the_highest() -> None:
    posts = """
    - bricks:
        - {name: left, on: ground, rotate: [0, 0, 90 deg]}
        - {name: right, beside: left, offset: [40 mm, 0, 0], rotate: [0, 0, 90 deg]}
        - {name: lintel, on: [left, right]}
        - {name: far, on: right, rotate: [0, 0, 90 deg], offset: [100 mm, 0, -7.8 mm]}
        - {name: high, on: [lintel, far], drop: true}
    """
    found = centres(posts)
    assert found["lintel"] == pytest.approx((31.7, 0, 7.8 + 3.9))
    assert found["high"] == pytest.approx(((31.7 + 163.4) / 2, 0, 15.6 + 3.9))


def test_the_bricks_of_layouts_are_named_by_place_and_those_of_a_step_with_its_name() -> None:
    build = "- {name: left, column: {levels: 3}}\n- bricks: [{name: a, on: left.L3.1}, {on: a}, {on: L5.1}]\n"
    found = centres(build)
    assert [found[name][2] for name in ("a", "L5.1", "L6.1")] == pytest.approx([27.3, 35.1, 42.9])
    build = "- {name: top, bricks: [{name: a, on: ground}, {name: b, on: top.a}]}"
    assert centres(build)["top.b"] == (0, 0, 11.7)


def test_an_inserted_brick_may_be_placed_beside_others() -> None:
    impacts = "impacts: [{insert: {name: wedge, beside: L1.1, towards: 90 deg}}, {insert: {on: wedge}}]"
    assert centres("- column: {levels: 2}", impacts)["wedge"] == pytest.approx((0, 23.4, 3.9))


def test_a_tower_of_bricks_each_on_the_one_before() -> None:
    build = "- bricks:\n    - {name: b0, on: ground}\n    - {repeat: {i: 1 .. 999}, name: 'b${i}', on: 'b${i - 1}'}"
    assert centres(build)["b999"] == pytest.approx((0, 0, 999.5 * 7.8))


@pytest.mark.parametrize(
    ("build", "words", "hint"),
    [
        ("- bricks: [{on: bean}, {name: beam, on: ground}]", "no earlier brick has the name 'bean'", "'beam'?"),
        ("- bricks: [{on: beam}, {name: beam, on: ground}]", "is placed later, at 3:26", "place that brick first"),
        ("- bricks: [{name: beam, on: beam}]", "is placed on or beside itself", "name another brick"),
        (
            "- bricks: [{name: beam, on: ground}, {on: baem}]",
            "no earlier brick has the name 'baem'",
            "did you mean 'beam'?",
        ),
        ("- bricks: [{name: a, on: ground, offset: [0, 0, 9 mm]}]", "brick 'a' has no support", "drop: true"),
        (
            "- bricks: [{name: a, drop: true, on: ground, offset: [0, 0, 9 mm]}, {on: a}]",
            "which is dropped, so its position is unknown",
            "at",
        ),
        (
            "- {bricks: [{name: a, on: ground}], at: 2 s}\n- {bricks: [{on: a}], at: 1 s}",
            "which is not placed before 2 s",
            "time",
        ),
    ],
)
def test_a_reference_brick_that_is_not_there_yet_is_a_mistake(build: str, words: str, hint: str) -> None:
    (mistake,) = mistakes_of(build)
    assert words in mistake.message
    assert hint in mistake.hint


@pytest.mark.parametrize(
    ("impact", "words"),
    [
        ("remove: {brick: a}", "which is pulled out at 1 s"),
        ("push: {brick: a, impulse: [1 mN*s, 0 N*s, 0 N*s]}", "which is hit at 1 s"),
        ("drop: {onto: a, height: 1 mm}", "which is hit at 1 s"),
    ],
)
def test_a_removed_or_hit_brick_is_no_reference(impact: str, words: str) -> None:
    build = "- bricks: [{name: a, on: ground}]\n- {bricks: [{name: b, on: a}], at: 5 s}"
    (mistake,) = mistakes_of(build, f"impacts: [{{at: 1 s, {impact}}}]")
    assert (mistake.code, mistake.span.line, mistake.span.column) == ("SD204", 4, 29)
    assert words in mistake.message
    later = mistakes_of(build, f"impacts: [{{at: 6 s, {impact}}}]")
    assert [mistake for mistake in later if mistake.code == "SD204"] == []


@pytest.mark.parametrize(
    ("brick", "code"),
    [
        ("on: beam, at: [0, 0, 0]", "SD108"),
        ("name: x", "SD108"),
        ("at: [0, 0, 3.9 mm], offset: [0, 0, 0]", "SD108"),
        ("on: beam, towards: 90 deg", "SD108"),
        ("on: [beam, ground]", "SD104"),
        ("on: wall1", "SD104"),
        ("on: []", "SD104"),
    ],
)
def test_a_brick_has_one_place(brick: str, code: str) -> None:
    (mistake,) = mistakes_of(f"{BASE}    - {{{brick}}}")
    assert (mistake.code, mistake.span.line) == (code, 5)


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(-1, 4), st.booleans()), min_size=1, max_size=12))
@settings(max_examples=60, deadline=None)
def test_names_by_place_are_those_of_all_bricks_at_once(heap: list[tuple[int, int, bool]]) -> None:
    planes = [Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)]
    written, step, one_by_one = list[WrittenBrick](), 0, IncrementalNaming(planes)
    kapla = BrickKind.model_validate("kapla")
    for x, z, begins_a_step in heap:
        step += begins_a_step
        path, pose = ("build", step, "bricks", 0), Pose((0.05 * x, 0.0, 0.0039 + 0.0078 * z), (0.0, 0.0, 0.0, 1.0))
        written.append(WrittenBrick(path, step, Box((0.1176, 0.0234, 0.0078)), 0.012, pose, kapla, None, None))
        one_by_one.add_new(written, "L1.1")
        levels = levels_of(written, footings_of(written, planes))
        named = {name: number for number, name in enumerate(names_of(written, levels))}
        assert (one_by_one.levels, one_by_one.named) == (levels, named)


def test_names_by_place_are_not_worked_out_anew_for_ever() -> None:
    bricks = "\n".join(["    - {on: L1.1, offset: [0, 0, -15.6 mm]}"] * 300)
    (mistake,) = mistakes_of(f"- bricks:\n    - {{at: [0, 0, 10 m]}}\n{bricks}")
    assert (mistake.code, "must recompute more than" in mistake.message) == ("SD206", True)
