"""The equations of a start are those of rigid bodies: checked against vectors, and against Newton in one case."""

import numpy as np
import pytest

from stability.model import EARTH
from stability.statics.initial_motion import start_equations
from tests.stability.analysis.leaning_scenes import LENGTH, THICKNESS, WIDTH, ladder, pile_on_a_slope


def test_a_point_of_a_brick_accelerates_with_its_centre_and_as_it_spins() -> None:
    problem = ladder(60.0, 0.5, 0.3).problem()
    equations = start_equations(problem)
    given = np.array([0.3, -0.2, 0.5, 0.7, 1.1, -0.4])
    velocity, spin = equations.motion(given).velocity["plank"]
    force, mass, _ = equations.units
    points = [point for contact in problem.contacts for point in contact.points_W]
    for slip, point in zip(equations.slips, points, strict=True):
        arm = np.array(point) - problem.bricks["plank"].pose.position_W
        there = np.array(velocity) + np.cross(spin, arm)
        assert slip @ given * force / mass == pytest.approx(there)


def test_between_two_bricks_the_lower_counts_against_the_upper() -> None:
    equations = start_equations(pile_on_a_slope(2, 10.0, 0.5).problem())
    together = np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.0] * 2)
    between = equations.slips[equations.contact == equations.contact.max()]
    ground = equations.slips[equations.contact == equations.contact.min()]
    counts = sorted(float(np.abs(slips @ together).max()) for slips in (between, ground))
    assert counts == pytest.approx([0.0, 0.3])


def test_masses_loads_and_moments_are_those_of_the_bricks() -> None:
    equations = start_equations(ladder(60.0, 0.5, 0.3).problem())
    force, mass, length = equations.units
    inertia = mass * length**2 * equations.mass[3:, 3:]
    moments = sorted(m / 12.0 for m in (LENGTH**2 + WIDTH**2, LENGTH**2 + THICKNESS**2, WIDTH**2 + THICKNESS**2))
    assert np.linalg.eigvalsh(inertia) == pytest.approx(moments)
    assert force * equations.loads[:3] == pytest.approx([0.0, 0.0, -EARTH])
