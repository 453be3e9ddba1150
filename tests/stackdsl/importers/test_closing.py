"""Open joints between imported stones: least moves by closed forms, what is told, and what is refused."""

from collections.abc import Sequence
from fractions import Fraction
from math import cos, pi, sin

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stackdsl.diagnostics import Span
from stackdsl.importers.closing import OpenJointError, closed_lines, with_closed_joints
from stackdsl.importers.load import Exact3, ImportedBox, ImportedLoad

SPAN = Span("stones.obj", 1, 1, 1)
MM = Fraction(1, 1000)


def exact(point: Sequence[float]) -> Exact3:
    x, y, z = (Fraction(float(part)) for part in point)
    return (x, y, z)


def box(name: str, size: Sequence[float], centre: Sequence[float]) -> ImportedBox:
    return ImportedBox(name, exact(size), exact(centre), Fraction(1), SPAN)


def load(*boxes: ImportedBox) -> ImportedLoad:
    return ImportedLoad(boxes, Fraction(0))


def stone(name: str, points: np.ndarray) -> ImportedBox:
    low, high = points.min(axis=0), points.max(axis=0)
    centre = 0.5 * (low + high)
    corners = tuple(exact(point - centre) for point in points)
    return ImportedBox(name, exact(high - low), exact(centre), Fraction(1), SPAN, corners=corners)


def arch(stones: int, noise: float, seed: int) -> tuple[ImportedLoad, float]:
    """A semicircular arch on the ground, each stone off its place; and the sum of the squared moves of its stones."""
    rng, boxes, total = np.random.default_rng(seed), [], 0.0
    for number in range(stones):
        angles = (pi * number / stones, pi * (number + 1) / stones)
        points = np.array([(r * cos(a), y, r * sin(a)) for r in (0.9, 1.1) for a in angles for y in (-0.15, 0.15)])
        middle = points.mean(axis=0)
        radius = np.linalg.norm(points - middle, axis=1).max()
        turn, way = rng.normal(size=3) * noise, rng.normal(size=3) * noise
        total += float(way @ way + radius**2 * (turn @ turn))
        boxes.append(stone(f"s{number}", Rotation.from_rotvec(turn).apply(points - middle) + middle + way))
    return load(*boxes), total


def height(found: ImportedBox) -> float:
    return float(found.centre[2])


def test_two_stones_in_the_air_meet_half_way() -> None:
    made = with_closed_joints(load(box("a", (1, 1, 1), (0, 0, 5)), box("b", (1, 1, 1), (0, 0, 6.004))), 5 * MM)
    assert [height(each) for each in made.load.boxes] == pytest.approx([5.002, 6.002], abs=1e-9)
    assert made.moved == pytest.approx((0.002, 0.002), abs=1e-9)


def test_a_column_closes_down_to_the_ground() -> None:
    column = [box(f"s{n}", (1, 1, 1), (0, 0, 0.5 + n + 0.002 * (n + 1))) for n in range(3)]
    made = with_closed_joints(load(*column), 7 * MM)
    assert [height(each) for each in made.load.boxes] == pytest.approx([0.5, 1.5, 2.5], abs=1e-9)
    assert list(closed_lines(made)) == [
        "3 of 3 stones were moved to close joints",
        "  s2: 6 mm",
        "  s1: 4 mm",
        "  s0: 2 mm",
    ]


def test_a_stone_on_a_slope_turns_until_its_face_lies_on_it() -> None:
    angle = 0.01
    points = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])
    turned = np.array((0.0, 0.0, 0.5 * sin(angle))) + Rotation.from_rotvec((0.0, angle, 0.0)).apply(points)
    made = with_closed_joints(load(stone("s", turned)), 20 * MM)
    assert made.turned[0] == pytest.approx(angle, abs=1e-6)
    lowest = sorted(float(corner[2] + made.load.boxes[0].centre[2]) for corner in made.load.boxes[0].corners or ())
    assert lowest[:4] == pytest.approx([0.0] * 4, abs=1e-8)


@pytest.mark.parametrize(("stones", "noise", "seed"), [(7, 0.002, 1), (10, 0.008, 2), (15, 0.001, 3)])
def test_an_arch_closes_by_less_than_what_opened_it(stones: int, noise: float, seed: int) -> None:
    opened, total = arch(stones, noise, seed)
    made = with_closed_joints(opened, 50 * MM if stones < 12 else 20 * MM)
    moves = [
        np.array([float(a - b) for a, b in zip(now.centre, was.centre, strict=True)])
        for now, was in zip(made.load.boxes, opened.boxes, strict=True)
    ]
    # Moving each stone back is one way to close all joints; the least one moves the stones less.
    assert 0.0 < sum(float(move @ move) for move in moves) < total
    again = with_closed_joints(made.load, 20 * MM)
    assert max(again.moved) < 1e-6  # closed joints stay


def test_the_least_moves_do_not_depend_on_the_direction_in_plan_or_the_order() -> None:
    opened, _ = arch(8, 0.003, 4)
    expected = dict(zip((each.name for each in opened.boxes), with_closed_joints(opened, 30 * MM).moved, strict=True))
    turn = Rotation.from_rotvec((0.0, 0.0, 0.7))
    turned = load(
        *(
            stone(
                each.name or "",
                turn.apply(
                    np.array(
                        [
                            [float(p + c) for p, c in zip(corner, each.centre, strict=True)]
                            for corner in each.corners or ()
                        ]
                    )
                ),
            )
            for each in reversed(opened.boxes)
        )
    )
    made = with_closed_joints(turned, 30 * MM)
    found = dict(zip((each.name for each in turned.boxes), made.moved, strict=True))
    assert found == pytest.approx(expected, abs=1e-6)


def test_closing_that_needs_more_than_the_gap_is_refused() -> None:
    column = [box(f"s{n}", (1, 1, 1), (0, 0, 0.5 + n + 0.004 * (n + 1))) for n in range(3)]
    with pytest.raises(OpenJointError, match="closing the joints moves 's2' by 12 mm"):
        with_closed_joints(load(*column), 5 * MM)


def test_joints_that_cannot_all_be_closed_are_refused() -> None:
    posts = [box("left", (1, 1, 2), (-2, 0, 1)), box("right", (1, 1, 2.002), (2, 0, 1.001))]
    with pytest.raises(OpenJointError, match="not all joints can be closed"):
        with_closed_joints(load(*posts, box("lintel", (5, 1, 1), (0, 0, 2.503))), 5 * MM)


def test_stones_that_touch_nothing_stay() -> None:
    apart = load(box("a", (1, 1, 1), (0, 0, 5)), box("b", (1, 1, 1), (9, 0, 5)))
    assert with_closed_joints(apart, 5 * MM).load.boxes == apart.boxes
