"""Programs folded along the mirrors of a structure, against the programs of all bricks."""

from math import inf

import numpy as np
import pytest

from stability.analysis import placement_margin
from stability.analysis.mirrored_program import MIRRORS, Parts
from stability.analysis.placement_margin import placement
from tests.stability.analysis.margin_scenes import four_stack, upright_boxes


def test_a_folded_tower_has_the_placement_margin_and_the_limits_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = upright_boxes(four_stack(9))
    margins = []
    for large in (1, inf):
        monkeypatch.setattr(placement_margin, "LARGE", large)
        margins.append(placement(problem))
    folded, whole = margins
    assert folded.value == pytest.approx(whole.value, rel=1e-6)
    assert folded.limits == whole.limits


def test_a_tower_with_one_shifted_plank_is_not_folded_across_it(monkeypatch: pytest.MonkeyPatch) -> None:
    boxes = four_stack(6)
    name, x, y, z, size = boxes[-1]
    problem = upright_boxes([*boxes[:-1], (name, x + 0.01, y, z, size)])
    margins = []
    for large in (1, inf):
        monkeypatch.setattr(placement_margin, "LARGE", large)
        margins.append(placement(problem).value)
    assert margins[0] == pytest.approx(margins[1], rel=1e-6)


def test_a_corner_has_an_image_only_where_height_agrees() -> None:
    flat = Parts(np.array([[1.0, 2.0], [-1.0, 2.0]]), np.array([[0.5], [0.5]]))
    raised = Parts(flat.vectors, np.array([[0.5], [0.6]]))
    assert [flat.images(each) is not None for each in MIRRORS] == [True, False, False]
    assert [raised.images(each) for each in MIRRORS] == [None] * 3
