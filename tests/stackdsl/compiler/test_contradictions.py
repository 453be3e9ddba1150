"""Two expectations of one thing that no run can meet are told at the second, before anything is played."""

import pytest

from tests.scenes import mistakes_of

COLUMN = "- column: {levels: 3}\n  every: 1 s"


def told(one: str, other: str) -> list[str]:
    rest = f"systems: [exact]\nexpect:\n  - {one}\n  - {other}"
    return [mistake.message for mistake in mistakes_of(COLUMN, rest)]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("height: 20 mm .. 21 mm", "height: '> 21 mm'"),
        ("height: {is: < 8 mm, of: L1.1}", "height: {is: '>= 8 mm', of: L1.1}"),
        ("drift: < 1 mm", "drift: 3 mm ± 1 mm"),
        ("collapses: {at: level 2}", "collapses: {at: level 3}"),
        ("collapses: {time: 1 s .. 2 s}", "collapses: {time: 3 s .. 4 s, brick: L3.1}"),
        ("leaves: {levels: 1}", "leaves: {levels: '>= 2'}"),
        ("displaced: {bricks: <= 1, by: '> 5 mm'}", "displaced: {bricks: '> 1', by: '> 5 mm'}"),
        ("margin: {friction: <= 0.2}", "margin: {tilt: '>= 3 deg', friction: '> 0.2'}"),
        ("stands: all", "falls: {bricks: [L3.1]}"),
        ("stands: all", "falls: {bricks: [L3.1], for: 1 s}"),
        ("falls: {count: 1, for: 1 s}", "falls: {count: 2, for: 1 s}"),
        ("stands: {levels: 2}", "falls: {bricks: [L3.1, L2.1]}"),
    ],
)
def test_values_that_do_not_meet_are_a_mistake_whichever_comes_first(one: str, other: str) -> None:
    for first, second in ((one, other), (other, one)):
        assert told(first, second) == [
            f"this claim and `{first.partition(':')[0]}` at 7:5 contradict each other on exact"
        ]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("height: 20 mm .. 21 mm", "height: '>= 21 mm'"),  # 21 mm
        ("height: {is: < 8 mm, of: L1.1}", "height: {is: '> 8 mm', of: L2.1}"),
        ("drift: '> 2 mm'", "drift: {is: < 1 mm, bricks: [L1.1]}"),
        ("displaced: {bricks: <= 1, by: '> 5 mm'}", "displaced: {bricks: '> 1', by: '> 1 mm'}"),
        ("stands: {levels: 2}", "falls: {bricks: [L3.1]}"),
        ("falls: {count: 1, for: 1 s}", "falls: {count: 2}"),
        ("collapses: {at: level 2 ± 1}", "collapses: {at: level 3, time: < 9 s}"),
    ],
)
def test_values_that_meet_or_are_of_different_things_are_let_be(one: str, other: str) -> None:
    assert told(one, other) == told(other, one) == []
