"""Load cores: where a brick can be loaded without anything above it being asked."""

import pytest

from stability.contact_law import Coulomb
from stability.problem import UP, Contact
from stability.statics.load_core import LoadCore, carries_upright, core_of
from tests.stability.statics.test_propagation import patch


def cores_of(*contacts: Contact) -> dict[str, LoadCore]:
    """Cores of bricks that come in the order of their contacts."""
    cores: dict[str, LoadCore] = {}
    for upper in dict.fromkeys(contact.upper for contact in contacts):
        cores[upper] = core_of([c for c in contacts if c.upper == upper], cores)
    return cores


def test_on_the_ground_the_core_is_the_patch() -> None:
    core = cores_of(patch("ground", "a", (-3.0, 3.0)))["a"]
    assert core.carries((2.999, 0.999))
    assert not core.carries((3.001, 0.0))


def test_between_two_supports_the_core_reaches_across_the_gap() -> None:
    cores = cores_of(
        patch("ground", "l", (-5.0, -4.0)),
        patch("ground", "r", (4.0, 5.0)),
        patch("l", "p", (-5.0, -4.0)),
        patch("r", "p", (4.0, 5.0)),
    )
    assert cores["p"].carries((0.0, 0.0))
    assert not cores["p"].carries((5.1, 0.0))


def test_each_level_of_a_stepped_column_has_a_smaller_core() -> None:
    # Three planks of length 1 stepped by 0.2: the core of the top one is what all three patches share.
    cores = cores_of(patch("ground", "0", (-0.5, 0.5)), patch("0", "1", (-0.3, 0.5)), patch("1", "2", (-0.1, 0.7)))
    assert cores["2"].carries((0.4999, 0.0))
    assert not cores["2"].carries((0.5001, 0.0))
    assert cores["2"].carries((-0.0999, 0.0))
    assert not cores["2"].carries((-0.1001, 0.0))


def test_three_points_carry_what_lies_in_their_triangle() -> None:
    feet = [
        Contact("ground", "t", ((x, y, 0.0),), (UP,), Coulomb(0.5)) for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    ]
    core = core_of(feet, {})
    assert core.carries((0.3, 0.3))
    assert not core.carries((0.6, 0.6))


def test_a_line_over_a_core_counts_as_far_as_it_lies_over_it() -> None:
    post = core_of([patch("ground", "s", (-1.0, 1.0))], {})
    lines = [Contact("s", "p", ((-2.0, y, 0.0), (2.0, y, 0.0)), (UP,), Coulomb(0.5)) for y in (-0.5, 0.5)]
    core = core_of(lines, {"s": post})
    assert core.carries((0.999, 0.0))
    assert not core.carries((1.001, 0.0))


@pytest.mark.parametrize(("slope", "carries"), [(0.5 - 1e-9, True), (0.5 + 1e-9, False)])
def test_a_slope_carries_upright_forces_while_it_is_no_steeper_than_friction(slope: float, carries: bool) -> None:
    length = (1.0 + slope * slope) ** 0.5
    contact = Contact("ground", "a", ((0.0, 0.0, 0.0),), ((slope / length, 0.0, 1.0 / length),), Coulomb(0.5))
    assert carries_upright(contact) is carries
