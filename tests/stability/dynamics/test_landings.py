"""Landings: only falling bricks are compared with a landed one."""

import pytest

from stability.dynamics import brick_index
from stability.dynamics.dropping import dropping_of
from stability.geometry.box import Box
from stability.geometry.placed_shape import InPlace
from stability.model import AT_REST, GROUND, BodyState, Brick, Plane, Pose
from stability.problem import Placed

FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
SIDE, STEP = 0.04, 1e-3  # [m], [s]


def cube(name: str, x: float, height: float) -> tuple[Placed, BodyState]:
    pose = Pose((x, 0.0, height + 0.5 * SIDE))
    return Placed(Brick(name, Box((SIDE, SIDE, SIDE)), 0.1), pose), BodyState(pose, AT_REST, AT_REST)


@pytest.mark.parametrize(("above", "asked"), [(0, 0), (1, 5)])
def test_bricks_of_a_landing_column_are_not_compared_with_each_other(
    monkeypatch: pytest.MonkeyPatch, above: int, asked: int
) -> None:
    #   A column of five drops by a centimetre: in sqrt(2 * 0.01 / 9.81) = 45.2 ms. One more may come after it.
    moving = {f"c{n}": cube(f"c{n}", 0.0, 0.01 + n * SIDE) for n in range(5)}
    moving |= {f"after{n}": cube(f"after{n}", 0.0, 1.0 + n) for n in range(above)}
    dropping = dropping_of(moving, [], [FLOOR], 0.5, 9.81)
    assert dropping is not None
    calls: list[InPlace] = []
    drop = brick_index._drop

    def counted(upper: InPlace, lower: InPlace) -> float | None:
        calls.append(upper)
        return drop(upper, lower)

    monkeypatch.setattr(brick_index, "_drop", counted)
    steps = 0
    while not dropping.take_landed():
        assert dropping.advance(STEP)
        steps += 1
    assert steps == 46
    assert len(calls) == asked
