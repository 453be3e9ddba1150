"""Passing weights down with forces of least norm."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.contact_law import Coulomb
from stability.problem import UP, Contact
from stability.statics.load_core import core_of
from stability.statics.propagation import Failure, VerticalLoad, least_norm, propagate, shared

BETWEEN = st.floats(-0.999, 0.999)


def patch(lower: str, upper: str, x: tuple[float, float], y: tuple[float, float] = (-1.0, 1.0)) -> Contact:
    corners = ((x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1]))
    return Contact(lower, upper, tuple((px, py, 0.0) for px, py in corners), (UP,), Coulomb(0.5))


@given(BETWEEN, BETWEEN)
def test_forces_at_four_corners_follow_the_lever_rule(x: float, y: float) -> None:
    corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    forces = least_norm((x, y), corners)
    assert forces is not None
    assert sum(forces) == pytest.approx(1.0)
    right = forces[1] + forces[2]
    assert right == pytest.approx(0.5 * (1.0 + x), abs=1e-12)
    assert forces[2] + forces[3] == pytest.approx(0.5 * (1.0 + y), abs=1e-12)
    assert min(forces) >= 0.0


def test_a_load_beyond_the_corners_is_not_carried() -> None:
    corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    assert least_norm((1.0 - 1e-9, 0.0), corners) is not None
    assert least_norm((1.0 + 1e-9, 0.0), corners) is None


@pytest.mark.parametrize(("at", "right"), [(0.0, 0.5), (0.5, 0.75), (-1.0, 0.0)])
def test_two_points_share_a_load_by_the_lever_rule(at: float, right: float) -> None:
    forces = least_norm((at, 0.0), [(-1.0, 0.0), (1.0, 0.0)])
    assert forces == pytest.approx([1.0 - right, right])
    assert least_norm((at, 0.1), [(-1.0, 0.0), (1.0, 0.0)]) is None


def test_the_nearer_support_takes_more() -> None:
    supports = [
        (c, tuple((x, y) for x, y, _ in c.points_W)) for c in (patch("a", "p", (-5, -4)), patch("b", "p", (4, 5)))
    ]
    handed = shared(VerticalLoad(2.0, (1.0, 0.0)), supports)
    assert handed is not None
    weights = {force.contact.lower: force.load.weight for force in handed}
    assert weights["a"] + weights["b"] == pytest.approx(2.0)
    assert weights["b"] > weights["a"]
    assert sum(p.load.weight * p.load.at[0] for p in handed) == pytest.approx(2.0)


def column(step: float, planks: int, length: float = 1.0) -> list[Contact]:
    """Contacts of a column stepped along x; plank 0 lies on the ground."""
    contacts = [patch("ground", "0", (-length / 2, length / 2))]
    for upper in range(1, planks):
        middle = (upper - 1) * step
        contacts.append(patch(str(upper - 1), str(upper), (middle + step - length / 2, middle + length / 2)))
    return contacts


@pytest.mark.parametrize("planks", [2, 5, 10])
@pytest.mark.parametrize(("share", "stands"), [(1.0 - 1e-6, True), (1.0 + 1e-6, False)])
def test_a_stepped_column_stands_while_planks_times_step_is_at_most_the_length(
    planks: int, share: float, stands: bool
) -> None:
    contacts = column(share / planks, planks)
    weights = {str(i): VerticalLoad(1.0, (i * share / planks, 0.0)) for i in range(planks)}
    order = [str(i) for i in reversed(range(planks))]
    passed = propagate(order, weights, {c.upper: [c] for c in contacts}, {})
    assert isinstance(passed, Failure) is not stands
    if isinstance(passed, Failure):
        assert passed.brick == "1"  # all above the lowest joint


def test_a_load_that_leaves_the_group_must_land_in_the_core_below() -> None:
    #      |--p--|          the patch of p on s reaches from 0 to 2,
    #  |----s----|          and that of s on the ground from -1 to 1
    #     |-g-|
    ground, upper = patch("ground", "s", (-1.0, 1.0)), patch("s", "p", (0.0, 2.0))
    cores = {"s": core_of([ground], {})}
    supports = {"p": [upper], "s": [ground]}
    assert isinstance(propagate(["p"], {"p": VerticalLoad(1.0, (0.9, 0.0))}, supports, cores), list)
    failure = propagate(["p"], {"p": VerticalLoad(1.0, (1.1, 0.0))}, supports, cores)
    assert isinstance(failure, Failure)
    assert failure.hinders == ("s",)
    # With its own weight in the group, s holds the overhang down.
    weights = {"p": VerticalLoad(1.0, (1.1, 0.0)), "s": VerticalLoad(1.0, (0.5, 0.0))}
    assert isinstance(propagate(["p", "s"], weights, supports, cores), list)
