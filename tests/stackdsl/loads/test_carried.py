"""Claims about what bricks carry: met by the whole proven range, or missed with the brick that carries most."""

import pytest

from stackdsl.api.cases import loads
from stackdsl.api.run import play
from tests.scenes import mistakes_of

COLUMN = """
scenario: cartons
world: {gravity: 10 m/s2}
brick: {size: [400 mm, 300 mm, 250 mm], mass: 12 kg}
build:
  - column: {levels: 6}
"""
SUPPORTS = """
scenario: supports
world: {gravity: 10 m/s2}
brick: {size: [100 mm, 100 mm, 100 mm], mass: 1 kg}
build:
  - bricks:
      - {name: left, at: [-200 mm, 0 mm, 50 mm]}
      - {name: right, at: [200 mm, 0 mm, 50 mm]}
      - {name: plank, at: [50 mm, 0 mm, 110 mm], brick: {size: [800 mm, 100 mm, 20 mm], mass: 3 kg}}
"""


def judged(scene: str, *claims: str) -> list[tuple[bool, str]]:
    """Return for each claim if it is met, and what is measured."""
    (case,) = loads(f"{scene}expect:\n" + "".join(f"  - {claim}\n" for claim in claims))
    return [(outcome.passed, outcome.measured) for outcome in play(case).outcomes]


def test_the_lowest_of_six_cartons_carries_five() -> None:
    assert judged(COLUMN, "load: '<= 60 kg'", "load: '<= 600 N'", "load: '< 60 kg'", "load: '<= 59.9 kg'") == [
        (True, "60 kg on L1.1"),
        (True, "600 N on L1.1"),
        (False, "60 kg on L1.1"),
        (False, "60 kg on L1.1"),
    ]


def test_each_brick_of_a_list_and_the_ground_are_compared() -> None:
    assert judged(
        COLUMN, "load: {bricks: [L5.1, L6.1], is: '<= 12 kg'}", "load: {support: ground, is: 72 kg ± 0.01 kg}"
    ) == [(True, "12 kg on L5.1"), (True, "72 kg on ground")]


def test_the_pressure_is_the_load_over_the_area() -> None:
    assert judged(COLUMN, "pressure: '<= 5 kPa'", "pressure: {bricks: [L4.1], is: '<= 1.9 kPa'}") == [
        (True, "5 kPa on L1.1"),
        (False, "2 kPa on L4.1"),
    ]


def test_a_range_must_lie_in_the_tolerance_as_a_whole() -> None:
    """The supports push at any place from 150 mm to 250 mm beside the middle."""
    assert judged(
        SUPPORTS,
        "load: {support: left, brick: plank, is: 0.75 kg .. 1.5 kg}",
        "load: {support: left, brick: plank, is: '>= 1 kg'}",
        "load: {support: left, brick: plank, is: '<= 1 kg'}",
        "load: {support: left, brick: right, is: '<= 1 kg'}",
    ) == [
        (True, "0.75 kg to 1.5 kg on left by plank"),
        (False, "0.75 kg to 1.5 kg on left by plank"),
        (False, "0.75 kg to 1.5 kg on left by plank"),
        (False, "the brick does not lie on this support"),
    ]


def test_walls_that_may_wedge_a_box_leave_its_load_without_limit() -> None:
    wedged = """
scenario: wedged
world:
  walls: [{bearing: 0 deg, distance: 100 mm, friction: 0.5}, {bearing: 180 deg, distance: 100 mm, friction: 0.5}]
brick: {size: [200 mm, 200 mm, 200 mm], mass: 2 kg}
build:
  - bricks: [{name: box, on: ground}]
"""
    assert judged(wedged, "load: {support: ground, is: '>= 0 kg'}", "load: {support: ground, is: '<= 5 kg'}") == [
        (True, "0 kg or more, without limit, on ground"),
        (False, "0 kg or more, without limit, on ground"),
    ]


def test_a_structure_that_falls_has_no_proven_load() -> None:
    (outcome,) = judged(COLUMN.replace("levels: 6", "levels: 6, step: 150 mm"), "load: '<= 60 kg'")
    assert not outcome[0]
    assert outcome[1].startswith("no load is proven: ")


@pytest.mark.parametrize(
    ("claim", "code", "words"),
    [
        ("load: ^40 kg", "SD107", "single value"),
        ("load: ^<= 3 m", "SD106", "not a unit of a weight"),
        ("load: ^<= 3", "SD105", "no unit"),
        ("pressure: ^<= 3 kg", "SD106", "not a unit of a pressure"),
        ("load: ^{brick: L1.1, is: <= 3 kg}", "SD102", "needs the body under it"),
        ("load: ^{bricks: [L1.1], support: L2.1, is: <= 3 kg}", "SD102", "excludes"),
        ("load: {bricks: [^L9.1], is: <= 3 kg}", "SD204", "no brick 'L9.1'"),
        ("load: {support: ^grund, is: <= 3 kg}", "SD204", "grund"),
    ],
)
def test_a_mistake_is_told_at_its_place(claim: str, code: str, words: str) -> None:
    head = "\nexpect: [{"
    (mistake,) = mistakes_of("- column: {levels: 6}", f"{head}{claim.replace('^', '')}}}]")
    assert (mistake.code, mistake.span.column) == (code, len(head) - 1 + claim.index("^") + 1)
    assert words in mistake.message
    assert mistake.hint


def test_claims_that_exclude_each_other_are_told() -> None:
    found = mistakes_of("- column: {levels: 6}", "\nexpect: [{load: <= 3 kg}, {load: '>= 4 kg'}]")
    assert len(found) == 1
    assert not mistakes_of("- column: {levels: 6}", "\nexpect: [{load: <= 3 kg}, {load: '>= 4 N'}]")
