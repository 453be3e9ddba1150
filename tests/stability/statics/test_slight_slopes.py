"""Slopes of less than rounding can show in a cosine: what stands on them has a proof that holds, or no proof at all."""

from itertools import product
from math import cos, sin

import pytest

from stability.geometry.box import Box
from stability.model import Brick, Plane, Pose
from stability.problem import Stability
from stability.statics.assembly import Assembly

TILTS = [10.0 ** (0.5 * power) for power in range(-28, -12)]  # [rad] from 1e-14 to 3e-7
FRICTIONS = (0.0, 1e-12, 1e-10, 1e-9, 1e-8)


def column_on(tilt: float, friction: float) -> Assembly:
    """Two planks on a slope, square to it."""
    normal_W = (sin(tilt), 0.0, cos(tilt))
    ground = Plane("ground", (0.0, 0.0, 0.0), normal_W, friction)
    assembly = Assembly([ground], friction)
    for name, height in (("lower", 0.004), ("upper", 0.012)):
        place = (height * normal_W[0], 0.0, height * normal_W[2])
        assembly.add(
            Brick(name, Box((0.12, 0.024, 0.008)), 0.0115), Pose(place, (0.0, sin(0.5 * tilt), 0.0, cos(0.5 * tilt)))
        )
    return assembly


@pytest.mark.parametrize(("tilt", "friction"), list(product(TILTS, FRICTIONS)))
def test_every_stable_verdict_on_a_slight_slope_carries_a_proof_that_holds(tilt: float, friction: float) -> None:
    assembly = column_on(tilt, friction)
    verdict = assembly.verdict()
    if verdict.stability is Stability.STABLE:
        assert assembly.forces() is not None  # it raises ArithmeticError where the proof does not hold
    # Coulomb: it stands up to a slope of the coefficient of friction.
    if tilt > friction + 3e-10:  # nearer, what gravity gains is within what the proof allows
        assert verdict.stability is Stability.UNSTABLE
    if tilt < friction:
        assert verdict.stability is Stability.STABLE
