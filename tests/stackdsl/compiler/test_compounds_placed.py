"""Bricks of several parts as authors write them: their mass and place, and what is wrong with them."""

from pathlib import Path

import pytest

from stability.geometry.compound import Compound
from stability.geometry.placed_shape import bounds_W
from tests.stackdsl.compiler.test_solids_placed import mistakes, placed

HOOK = """{density: 1000 kg/m3, parts: [
  {size: [100 mm, 50 mm, 20 mm], at: [0 mm, 0 mm, 10 mm]},
  {prism: {outline: [[0 mm, 0 mm], [20 mm, 0 mm], [0 mm, 40 mm]], depth: 50 mm}, at: [50 mm, 0 mm, 0 mm],
   rotate: [0 deg, 90 deg, 0 deg]}]}"""


def in_one_line(written: str) -> str:
    return " ".join(written.split())


def test_parts_make_one_brick_with_the_mass_of_all(tmp_path: Path) -> None:
    brick = f"      - {{name: hook, at: [0, 0, 40 mm], brick: {in_one_line(HOOK)}, drop: true}}\n"
    hook = placed(tmp_path, brick)["hook"]
    assert isinstance(hook.brick.shape, Compound)
    assert hook.brick.mass == pytest.approx(1000.0 * 0.05 * (0.1 * 0.02 + 0.5 * 0.02 * 0.04))
    low, high = bounds_W(hook.brick.shape, hook.pose)
    # A turn by 90 deg about y leads x downwards and z to x: the wedge hangs 20 mm down and reaches 40 mm out.
    assert (*low, *high) == pytest.approx((-0.05, -0.025, 0.02, 0.09, 0.025, 0.06))


@pytest.mark.parametrize(
    ("brick", "volume"),
    [
        ("section: {shape: L, size: [100 mm, 10 mm, 80 mm], thickness: 20 mm}", 0.1 * 0.02 + 0.02 * 0.06),
        ("section: {shape: T, size: [100 mm, 10 mm, 80 mm], thickness: 20 mm}", 0.1 * 0.02 + 0.02 * 0.06),
        ("section: {shape: U, size: [100 mm, 10 mm, 80 mm], thickness: 20 mm}", 0.1 * 0.02 + 2.0 * 0.02 * 0.06),
        ("section: {shape: I, size: [100 mm, 10 mm, 80 mm], thickness: 20 mm}", 2.0 * 0.1 * 0.02 + 0.02 * 0.04),
        ("section: {shape: channel, size: [100 mm, 10 mm, 80 mm], thickness: 20 mm}", 2.0 * 0.1 * 0.02 + 0.02 * 0.04),
        ("hollow_block: {size: [100 mm, 40 mm, 10 mm], wall: 10 mm, cells: 3}", 0.1 * 0.04 - 0.02 * 0.06),
        ("table: {size: [100 mm, 40 mm, 50 mm], top: 10 mm, leg: 5 mm}", 0.1 * 0.04 + 4.0 * 0.005**2 * 4.0),
    ],
)
def test_words_describe_common_parts_with_their_origin_in_the_middle(tmp_path: Path, brick: str, volume: float) -> None:
    found = placed(tmp_path, f"      - {{name: b, on: ground, brick: {{{brick}, density: 1000 kg/m3}}}}\n")["b"]
    assert found.brick.shape.volume == pytest.approx(0.01 * volume)
    low, high = bounds_W(found.brick.shape, found.pose)
    assert (low[0] + high[0], low[1] + high[1], low[2]) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert high[0] - low[0] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("brick", "code", "cause"),
    [
        ("parts: []", "SD104", "0 items; the minimum is 1"),
        ("parts: [{at: [0, 0, 0]}]", "SD108", "exactly one of the keys size, prism, points is required, not none"),
        ("parts: [{size: [1 cm, 1 cm, 1 cm]}, {size: [1 cm, 1 cm, 1 cm]}]", "SD104", "parts 1 and 2 overlap by 10 mm"),
        (
            "parts: [{size: [1 cm, 1 cm, 1 cm]}, {size: [1 cm, 1 cm, 1 cm], at: [2 cm, 0, 0]}]",
            "SD104",
            "part 2 does not touch the other parts",
        ),
        ("section: {shape: L, size: [1 cm, 1 cm, 1 cm], thickness: 1 cm}", "SD104", "leaves nothing of the width"),
        ("section: {shape: Z, size: [1 cm, 1 cm, 1 cm], thickness: 1 mm}", "SD104", "'Z'"),
        ("hollow_block: {size: [4 cm, 2 cm, 2 cm], wall: 1 cm, cells: 3}", "SD104", "4 walls of 10 mm leave no cell"),
        ("hollow_block: {size: [4 cm, 2 cm, 2 cm], wall: 1 mm, cells: 51}", "SD104", "51"),
        ("table: {size: [4 cm, 2 cm, 2 cm], top: 2 cm, leg: 1 mm}", "SD104", "a top of 20 mm leaves no legs"),
        ("table: {size: [4 cm, 2 cm, 2 cm], top: 1 mm, leg: 1 cm}", "SD104", "two legs of 10 mm leave no room"),
    ],
)
def test_what_is_no_body_of_parts_is_told_with_its_cause(tmp_path: Path, brick: str, code: str, cause: str) -> None:
    found = mistakes(tmp_path, f"      - {{name: c, at: [0, 0, 0], brick: {{{brick}, mass: 1 kg}}}}\n")
    assert [(each.code, cause in each.message) for each in found] == [(code, True)], found


def test_systems_that_do_not_move_bricks_of_several_parts_are_refused(tmp_path: Path) -> None:
    brick = "{section: {shape: U, size: [1 cm, 1 cm, 1 cm], thickness: 1 mm}, mass: 1 g}"
    bricks = f"      - {{on: ground, brick: {brick}}}\nsystems: [exact, tuned]\n"
    assert [each.code for each in mistakes(tmp_path, bricks)] == ["SD211"]
