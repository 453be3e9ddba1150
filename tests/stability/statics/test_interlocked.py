"""Boxes that hold one another up by the dozen are asked about together, not one by one with most of the others."""

import pytest

from stability.model import GROUND, Brick, Plane, Pose
from stability.shapes.box import Box
from stability.statics import cascade
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Stability, Stage, Tolerances
from stability.statics.proof import check_forces

SIDE, PITCH = 0.04, 0.0404  # [m]: every box but the lowest lies on the corners of four, over gaps of 0.4 mm
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)


def heap(count: int) -> list[Placed]:
    """Layers of count x count boxes, every other one half a pitch aside, so that its last rows hang out by half."""
    return [
        Placed(
            Brick(f"{layer}.{row}.{column}", Box((SIDE, SIDE, SIDE)), 0.05),
            Pose(((row + aside) * PITCH, (column + aside) * PITCH, (layer + 0.5) * SIDE)),
        )
        for layer in range(count)
        for aside in [0.5 * (layer % 2)]
        for row in range(count)
        for column in range(count)
    ]


def test_a_heap_of_interlocked_boxes_stands_with_forces_that_hold_and_few_programs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []
    ask = cascade._cones

    def counted(*question: object) -> object:
        asked.append(question)
        return ask(*question)  # type: ignore[arg-type]

    monkeypatch.setattr(cascade, "_cones", counted)
    assembly = Assembly((FLOOR,), 0.5, 9.81)
    verdict = assembly.add_all(heap(5))
    assert (verdict.stability, verdict.stage) == (Stability.STABLE, Stage.CONES)
    forces = assembly.forces()
    assert forces is not None
    assert check_forces(assembly.problem(), forces, Tolerances()).holds
    assert len(asked) <= 3  # one by one: eight


def test_one_box_too_far_out_falls_however_many_are_asked_together() -> None:
    count = 4
    boxes = heap(count)
    over = Pose(((count - 0.5) * PITCH + 0.51 * SIDE, 0.0, (count + 0.5) * SIDE))
    verdict = Assembly((FLOOR,), 0.5, 9.81).add_all([*boxes, Placed(Brick("out", boxes[0].brick.shape, 0.05), over)])
    assert verdict.stability is Stability.UNSTABLE
    assert verdict.moving == ("out",)
