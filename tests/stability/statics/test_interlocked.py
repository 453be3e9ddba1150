"""Boxes that hold one another up by the dozen are asked about together, not one by one with most of the others."""

from collections.abc import Collection
from dataclasses import replace
from random import Random

import pytest

from stability.geometry.box import Box
from stability.model import GROUND, BodyId, Brick, Plane, Pose
from stability.problem import Placed, Stability, Stage, Tolerances
from stability.statics import cascade, conic_program, equilibrium
from stability.statics.assembly import Assembly
from stability.statics.conic_program import SolverPoint
from stability.statics.equilibrium import separating_motion
from stability.statics.proof import check_forces
from stability.statics.structure import Structure
from stability.statics.upright_forces import upright_group

SIDE = 0.04  # [m]: every box but the lowest lies on the corners of four that touch one another
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)


def heap(count: int, pitch: float = SIDE) -> list[Placed]:
    """Layers of count x count boxes, every other one aside, so that its last rows hang out by a little over half."""
    return [
        Placed(
            Brick(f"{layer}.{row}.{column}", Box((SIDE, SIDE, SIDE)), 0.05),
            Pose(((row + aside) * pitch, (column + aside) * pitch, (layer + 0.5) * SIDE)),
        )
        for layer in range(count)
        for aside in [0.505 * (layer % 2)]
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


def test_a_group_that_would_grow_to_over_half_of_all_grows_to_all(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    ask = cascade._cones

    def counted(structure: Structure, group: Collection[BodyId], last: bool) -> object:
        asked.append(len(group))
        return ask(structure, sorted(group), last)

    monkeypatch.setattr(cascade, "_cones", counted)
    kept = Random(107)
    heap_with_holes = [box for box in heap(kept.choice([3, 4])) if kept.random() < 0.8]
    assert Assembly((FLOOR,), 0.5, 9.81).add_all(heap_with_holes).stability is Stability.UNSTABLE
    assert asked == [7, len(heap_with_holes)]  # with 13 between, which shows nothing


def test_an_overhanging_box_tips_where_gaps_prevent_lateral_support() -> None:
    verdict = Assembly((FLOOR,), 0.5, 9.81).add_all(heap(2, 1.01 * SIDE))
    assert verdict.stability is Stability.UNSTABLE
    assert {*verdict.moving} <= {"1.0.1", "1.1.0", "1.1.1"}


def test_a_box_beyond_its_limit_falls_on_a_heap_of_many() -> None:
    count = 4
    boxes = heap(count)
    over = Pose(((count - 0.5) * SIDE + 0.51 * SIDE, 0.0, (count + 0.5) * SIDE))
    verdict = Assembly((FLOOR,), 0.5, 9.81).add_all([*boxes, Placed(Brick("out", boxes[0].brick.shape, 0.05), over)])
    assert verdict.stability is Stability.UNSTABLE
    assert verdict.moving == ("out",)


def test_layers_of_boxes_side_by_side_are_opened_without_a_solver_also_where_some_rest_on_none_of_the_group() -> None:
    #   Two side by side, of which only one rests on a box of the problem: they must rise alike, or they rub.
    def never_asked(*question: object) -> SolverPoint:
        raise AssertionError("asked a solver")

    assembly = Assembly((FLOOR,), 0.5, 9.81)
    assembly.add_all(heap(2))
    problem = assembly.problem(["0.0.0", "0.0.1", "1.0.0", "1.0.1", "1.1.0", "1.1.1"])
    part = replace(problem, contacts=[c for c in problem.contacts if {c.lower, c.upper} <= {*problem.bricks, GROUND}])
    without = [c for c in part.contacts if c.upper not in ("1.1.0", "1.1.1") or c.lower.startswith("1")]
    assert separating_motion(replace(part, contacts=without), never_asked) is not None


def test_a_box_that_hangs_free_costs_no_program_of_upright_forces() -> None:
    boxes = heap(2)
    assembly = Assembly((FLOOR,), 0.5, 9.81)
    assembly.add_all(boxes)
    assert upright_group(assembly._structure, [box.brick.id for box in boxes[:4]]) is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(equilibrium, "balance", None)  # calling it is an error
        assert upright_group(assembly._structure, [box.brick.id for box in boxes]) is None


def test_of_large_programs_steps_are_not_refined_and_the_proof_holds_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(conic_program, "LARGE", 0)
    assembly = Assembly((FLOOR,), 0.5, 9.81)
    assert assembly.add_all(heap(3)).stability is Stability.STABLE
    assert assembly.forces() is not None  # checked by arithmetic
