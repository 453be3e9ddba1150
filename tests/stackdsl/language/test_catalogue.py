"""Bricks of the catalogue: sides from long to short, and the mass of a real plank."""

import pytest

from stability.model import Vec3
from stackdsl.language.bricks import CATALOGUE
from tests.stackdsl.language.layouts.layout_shapes import LENGTH, THICKNESS, WIDTH


@pytest.mark.parametrize("size", [brick.size for brick in CATALOGUE.values()], ids=CATALOGUE)
def test_catalogue_bricks_are_given_as_length_width_thickness(size: Vec3) -> None:
    assert sorted(size, reverse=True) == list(size)


def test_the_ideal_plank_has_sides_of_1_3_15_and_the_real_one_11_9_grams() -> None:
    length, width, thickness = CATALOGUE["kapla-ideal"].size
    assert (length / thickness, width / thickness) == pytest.approx((15, 3))
    assert CATALOGUE["kapla"].density * LENGTH * WIDTH * THICKNESS == pytest.approx(0.0119, abs=0.0001)
