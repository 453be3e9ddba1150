"""Bounding boxes of all bricks of a world: neighbours, and distances to a half-space."""

from math import cos, pi, sin

import numpy as np
import pytest

from stability.geometry.bounding_boxes import BoundingBoxes
from stability.model import GROUND, Plane

FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)


def row_of_cubes(turn: float = 0.0) -> BoundingBoxes:
    """Cubes of 1 m, 1.5 m from centre to centre, the second one turned about the vertical."""
    axes = np.array([np.eye(3)] * 3)
    axes[1] = [[cos(turn), -sin(turn), 0.0], [sin(turn), cos(turn), 0.0], [0.0, 0.0, 1.0]]
    centres = np.array([[1.5 * number, 0.0, 0.75] for number in range(3)])
    return BoundingBoxes.around(["c", "a", "b"], centres, axes, np.full((3, 3), 0.5))


@pytest.mark.parametrize(("within", "near"), [(0.49, []), (0.51, ["a"]), (1.99, ["a"]), (2.01, ["a", "b"])])
def test_cubes_in_a_row_are_neighbours_within_the_gap_between_them(within: float, near: list[str]) -> None:
    assert row_of_cubes().neighbours("c", within) == near


def test_a_cube_on_its_edge_reaches_half_a_diagonal_out() -> None:
    gap = 1.5 - 0.5 - np.sqrt(0.5)
    assert row_of_cubes(pi / 4.0).neighbours("a", gap - 0.001) == []
    assert row_of_cubes(pi / 4.0).neighbours("a", gap + 0.001) == ["b", "c"]


@pytest.mark.parametrize(("within", "near"), [(0.24, False), (0.26, True)])
def test_a_half_space_is_near_when_the_lowest_corner_is(within: float, near: bool) -> None:
    assert row_of_cubes().reaches_plane("a", FLOOR, within) is near
