"""Principal axes of inertia: they explain the tensor, stay near the axes that it is written in, and ask no library."""

from math import pi

import numpy as np
import pytest

from stability.geometry.solid_making import prism
from stability.geometry.vectors import about, principal_axes, rotate


def matrix(turn: tuple[float, float, float, float]) -> np.ndarray:
    return np.array([rotate(turn, (1.0, 0.0, 0.0)), rotate(turn, (0.0, 1.0, 0.0)), rotate(turn, (0.0, 0.0, 1.0))]).T


@pytest.mark.parametrize("number", range(50))
def test_moments_about_the_axes_make_up_the_tensor(number: int) -> None:
    draws = np.random.default_rng(number)
    half = draws.normal(size=(3, 3))
    tensor = half @ half.T * 10.0 ** draws.uniform(-12.0, 3.0)
    moments, turn = principal_axes(tensor.tolist())
    axes = matrix(turn)
    assert axes @ np.diag(moments) @ axes.T == pytest.approx(tensor, abs=1e-14 * np.abs(tensor).max())
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-14)
    assert sorted(moments) == pytest.approx(np.linalg.eigvalsh(tensor).tolist(), rel=1e-9)


@pytest.mark.parametrize("angle", [-0.2 * pi, -0.01, 0.3, 0.24 * pi])
@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
def test_axes_that_are_turned_by_less_than_an_eighth_are_found_where_they_are(
    angle: float, axis: tuple[float, float, float]
) -> None:
    turned = about(axis, angle)
    axes = matrix(turned)
    moments, turn = principal_axes((axes @ np.diag([1.0, 2.0, 4.0]) @ axes.T).tolist())
    assert moments == pytest.approx((1.0, 2.0, 4.0))
    assert turn == pytest.approx(turned, abs=1e-14)


def test_a_diagonal_tensor_is_returned_unchanged() -> None:
    assert principal_axes([[3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]) == (
        (3.0, 1.0, 2.0),
        (0.0, 0.0, 0.0, 1.0),
    )


def test_no_library_of_linear_algebra_chooses_the_axes_of_a_solid(monkeypatch: pytest.MonkeyPatch) -> None:
    # Its signs and last digits differ from processor to processor, and a prism stood on one and fell on another.
    monkeypatch.setattr(np.linalg, "eigh", None)
    assert prism([(0.0, 0.0), (0.12, 0.0), (0.0, 0.06)], 0.04).shape.unit_moments[0] > 0.0
