"""The equations of motion of leaning planks, which slips are compared with, against closed forms."""

from math import radians, sin

import pytest

from benchmarks.slipping import Leaning, gives_way, needed_friction, slides, slip, time_to_slide
from tests.planks import LENGTH, THICKNESS

KAPLA = (LENGTH, THICKNESS)


@pytest.mark.parametrize("angle", [45.0, 60.0, 75.0])
def test_a_thin_ladder_without_friction_leaves_the_wall_at_two_thirds_of_its_height(angle: float) -> None:
    down = slip(Leaning(LENGTH, 0.0, radians(angle), floor_friction=0.0))
    assert sin(down.angle(down.ends)) == pytest.approx(2.0 / 3.0 * sin(radians(angle)), rel=1e-9)


@pytest.mark.parametrize("share", [0.5, 0.9, 0.99])
@pytest.mark.parametrize("wall", [0.0, 0.05])
def test_energy_of_a_slipping_ladder_is_conserved_up_to_friction(share: float, wall: float) -> None:
    angle = radians(70.0)
    down = slip(Leaning(*KAPLA, angle, share * needed_friction(*KAPLA, angle) - wall / 4.0, wall))
    energies = [down.energy(down.ends * tenth / 10.0) for tenth in range(11)]
    assert energies == pytest.approx([energies[0]] * 11, rel=1e-10)


@pytest.mark.parametrize(("share", "moves"), [(0.9999, True), (1.0001, False)])
@pytest.mark.parametrize("angle", [50.0, 65.0, 80.0])
def test_a_ladder_slips_with_less_friction_than_statics_ask_for(share: float, moves: bool, angle: float) -> None:
    needed = needed_friction(*KAPLA, radians(angle))
    assert gives_way(Leaning(*KAPLA, radians(angle), share * needed)) is moves


def test_a_plank_slides_down_a_slope_by_gravity_minus_friction() -> None:
    way, speed = slides(radians(45.0), friction=0.5, time=0.4, gravity=10.0)
    assert speed == pytest.approx(0.4 * 10.0 * 0.5**0.5 * 0.5)
    assert way == pytest.approx(0.2 * speed)
    assert time_to_slide(way, radians(45.0), friction=0.5, gravity=10.0) == pytest.approx(0.4)
