"""Bricks of the catalogue: their sides, masses and studs."""

import pytest

from stability.model import Vec3
from stackdsl.language.bricks import CATALOGUE
from stackdsl.language.joints import LEGO_STUDS
from tests.stackdsl.language.layouts.layout_shapes import LENGTH, THICKNESS, WIDTH


@pytest.mark.parametrize("size", [brick.size for brick in CATALOGUE.values()], ids=CATALOGUE)
def test_catalogue_bricks_are_given_as_length_width_thickness(size: Vec3) -> None:
    assert size[0] >= size[1]


def test_lego_bricks_have_studs_8_mm_apart_and_are_three_plates_high() -> None:
    brick, plate = CATALOGUE["lego_2x4"], CATALOGUE["lego_plate_2x4"]
    assert brick.size == pytest.approx((0.032, 0.016, 0.0096))
    assert plate.size == pytest.approx((0.032, 0.016, 0.0032))
    assert brick.density * 0.032 * 0.016 * 0.0096 == pytest.approx(0.00216)
    assert brick.studs == plate.studs == LEGO_STUDS


def test_the_ideal_plank_has_sides_of_1_3_15_and_the_real_one_11_9_grams() -> None:
    length, width, thickness = CATALOGUE["kapla-ideal"].size
    assert (length / thickness, width / thickness) == pytest.approx((15, 3))
    assert CATALOGUE["kapla"].density * LENGTH * WIDTH * THICKNESS == pytest.approx(0.0119, abs=0.0001)
