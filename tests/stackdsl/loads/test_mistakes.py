"""Mistakes in loads: each is told where it is written, with a remedy."""

import pytest

from tests.scenes import mistakes_of

BLOCK = "- bricks: [{name: block, at: [0 m, 0 m, 0.45 m]}]"
SIZE = "\nbrick: {size: [0.3 m, 0.4 m, 0.9 m], density: 200 kg/m3}"


@pytest.mark.parametrize(
    ("load", "code", "words"),
    [
        ("^{force: 20 N, brick: block}", "SD102", "no direction"),
        ("^{moment: 2 N*m, brick: block}", "SD102", "no axis"),
        ("^{pressure: 2 kPa, brick: block}", "SD102", "no `face`"),
        ("{force: 20 N, brick: block, towards: ^left}", "SD104", "not a direction"),
        ("{force: ^20 kg, brick: block, towards: down}", "SD106", "weight"),
        ("{pressure: ^1 N, brick: block, face: top}", "SD106", "a pressure"),
        ("{weight: ^20 m, brick: block}", "SD106", "a weight"),
        ("{weight: ^20, brick: block}", "SD105", "no unit"),
        ("{force: 20 N, brick: ^blok, towards: down}", "SD204", "no brick 'blok'"),
        ("{force: 20 N, level: ^4, towards: down}", "SD204", "no level 4"),
        ("{pressure: 1 Pa, brick: block, face: ^45 deg}", "SD207", "no face looks that way"),
        ("{weight: 2 kg, brick: block, point: ^[1 m, 0 m, 0 m]}", "SD207", "850 mm outside"),
        ("^{weight: 2 kg, level: 1, point: [0 m, 0 m, 0 m]}", "SD108", "a single brick"),
        ("^{weight: 2 kg, brick: block, towards: down}", "SD108", "does not apply"),
        ("{weight: 2 kg, brick: block, after: ^level 7}", "SD205", "this load waits for level 7"),
        ("{force: ^from 0 N to 5 kg over 3 s, brick: block, towards: up}", "SD106", "a value of `weight`"),
        ("{force: ^from 0 N to 5 N over 3 N, brick: block, towards: up}", "SD106", "a duration"),
        ("{weight: ^from 0 to 5 over 3 s, brick: block}", "SD105", "no unit"),
        ("^{weight: from 1 kg to 5 N over 3 s, brick: block}", "SD104", "from a mass to a force"),
        ("{weight: 1 kg, brick: block, table: ^[[2 s, 10 %], [1 s, 20 %]]}", "SD104", "row 2"),
        ("^{weight: from 1 kg to 5 kg over 3 s, brick: block, table: [[0 s, 1 %], [1 s, 2 %]]}", "SD108", "no `table`"),
    ],
)
def test_a_mistake_is_told_at_its_place(load: str, code: str, words: str) -> None:
    (mistake,) = mistakes_of(BLOCK, f"{SIZE}\nloads: [{load.replace('^', '')}]")
    assert mistake.code == code
    assert mistake.span.column == len("loads: [") + load.index("^") + 1
    assert words in mistake.message
    assert mistake.hint


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("systems: [exact, tuned]", "not on the system 'tuned'"),
        ("samples: 100\nuncertain: {x: 0 mm .. 1 mm}", "samples are not drawn"),
        ("impacts: [{hold: {brick: block, for: 1 s}}]", "hands are not played"),
        ("expect: [{margin: {tilt: '>= 1 deg'}}]", "the margin `tilt` is not computed"),
        ("joints: [{pull: 2 N}]\nexpect: [{stands: all}]", "only judged at rest"),
    ],
)
def test_what_is_not_computed_under_loads_is_refused(more: str, words: str) -> None:
    build = BLOCK.replace("0.45 m]", "'${0.45 m + x}']") if "uncertain" in more else BLOCK
    found = mistakes_of(build, f"{SIZE}\nloads: [{{weight: 2 kg, brick: block}}]\n{more}")
    assert [mistake.code for mistake in found] == ["SD211"]
    assert words in found[0].message
