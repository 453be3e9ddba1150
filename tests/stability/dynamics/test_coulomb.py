"""A point mass on a face opens, sticks or slides, in closed form, and does not lift off as it slides."""

import numpy as np
import pytest

from stability.contact_law import Coulomb
from stability.dynamics.coulomb import FrictionProblem, residual, solve_friction

FRICTION = 0.5


def point(*free: float, gap: float = 0.0, friction: float = FRICTION) -> FrictionProblem:
    """One unit mass at one point of contact, with the velocity that it would have: off the face, and along it twice."""
    return FrictionProblem(
        np.identity(3), np.identity(3), np.array(free), np.array([gap]), Coulomb(np.array([friction]))
    )


@pytest.mark.parametrize(
    ("free", "velocity", "impulse"),
    [
        ((0.5, 2.0, 0.0), (0.5, 2.0, 0.0), (0.0, 0.0, 0.0)),  # it flies off
        ((-1.0, 0.3, -0.4), (0.0, 0.0, 0.0), (1.0, -0.3, 0.4)),  # friction of 0.5 just holds 0.5
        ((-1.0, 2.0, 0.0), (0.0, 1.5, 0.0), (1.0, -0.5, 0.0)),  # it slides, slowed by 0.5
        ((-1.0, 1.2, -1.6), (0.0, 0.9, -1.2), (1.0, -0.3, 0.4)),
    ],
)
def test_a_point_opens_stays_or_slides(
    free: tuple[float, ...], velocity: tuple[float, ...], impulse: tuple[float, ...]
) -> None:
    found = solve_friction(point(*free))
    assert found is not None
    assert found.velocities == pytest.approx(velocity, abs=1e-8)
    assert found.impulses[0] == pytest.approx(impulse, abs=1e-8)


def test_least_constraint_alone_would_lift_it_off_and_is_seen_to_be_wrong() -> None:
    #   It leaves by the friction times the slip: p = 1.6 (1, -0.5), and so u = (0.6, 1.2).
    associated = np.array([0.6, 1.2, 0.0])
    assert associated[0] == pytest.approx(FRICTION * associated[1])
    assert residual(point(-1.0, 2.0, 0.0), associated, np.array([[1.6, -0.8, 0.0]])) > 0.1


def test_a_gap_may_close_within_the_step() -> None:
    found = solve_friction(point(-1.0, 0.0, 0.0, gap=0.4))
    assert found is not None
    assert found.velocities == pytest.approx((-0.4, 0.0, 0.0), abs=1e-8)


def test_without_friction_nothing_rubs() -> None:
    found = solve_friction(point(-1.0, 2.0, 0.0, friction=0.0))
    assert found is not None
    assert found.velocities == pytest.approx((0.0, 2.0, 0.0), abs=1e-8)


def test_a_good_initial_guess_does_not_change_the_solution() -> None:
    meeting = point(-1.0, 2.0, 1.0)
    alone, guessed = solve_friction(meeting), solve_friction(meeting, np.array([[0.9, -0.3, -0.3]]))
    assert alone is not None
    assert guessed is not None
    assert guessed.velocities == pytest.approx(alone.velocities, abs=1e-8)
