"""Starts other than rest obey Newton and Coulomb."""

from dataclasses import replace
from math import cos, radians, sin, tan

import pytest

from stability.contact_law import Coulomb
from stability.model import EARTH
from stability.problem import Forces, Motion, Problem, Tolerances
from stability.statics.initial_motion import InitialMotion, check_start
from tests.stability.analysis.leaning_scenes import aslant_between_walls, pile_on_a_slope

SLIPPERY = pile_on_a_slope(1, 20.0, 0.5).problem()


def free(problem: Problem, fall: float = EARTH) -> InitialMotion:
    """Every brick falls, and nothing presses."""
    nothing = Forces(tuple(tuple(((0.0, 0.0, 0.0),) for _ in contact.points_W) for contact in problem.contacts))
    return InitialMotion(Motion(dict.fromkeys(problem.bricks, ((0.0, 0.0, -fall), (0.0, 0.0, 0.0)))), nothing)


def holds(problem: Problem, start: InitialMotion) -> bool:
    return check_start(problem, start, Tolerances()).holds


def test_free_fall_between_walls_is_a_start() -> None:
    problem = aslant_between_walls(20.0, 0.6, 0.1).problem()
    assert holds(problem, free(problem))


def test_nothing_falls_faster_than_free() -> None:
    problem = aslant_between_walls(20.0, 0.6, 0.1).problem()
    assert not holds(problem, free(problem, 1.01 * EARTH))


def test_nothing_falls_through_a_slope() -> None:
    assert not holds(SLIPPERY, free(SLIPPERY))


def test_rest_is_no_other_start() -> None:
    made = pile_on_a_slope(1, 20.0, 0.5)
    forces = made.forces()
    assert forces is not None
    assert not holds(SLIPPERY, InitialMotion(Motion({}), forces))


@pytest.mark.parametrize(("share", "lawful"), [(1.0, True), (0.9, False)])
def test_sliding_contacts_of_another_start_have_full_friction(share: float, lawful: bool) -> None:
    # On a slope of 20 degrees with half the friction that it needs: m a = m g (sin - mu cos), with N = m g cos.
    angle = radians(20.0)
    friction = 0.5 * tan(angle)
    problem = replace(SLIPPERY, contacts=[replace(each, law=Coulomb(friction)) for each in SLIPPERY.contacts])
    (contact,) = problem.contacts
    weight, braked = EARTH, share * friction
    down = EARTH * (sin(angle) - braked * cos(angle))
    # Shared among the corners so that the torque of friction about the centre is met.
    offset = braked * 0.025 / 0.3
    forces = []
    for x, _, z in contact.points_W:
        lower = x * cos(angle) - z * sin(angle) > 0.0
        pressed = weight * cos(angle) * (0.25 + (0.5 if lower else -0.5) * offset)
        forces.append(
            ((pressed * (sin(angle) - braked * cos(angle)), 0.0, pressed * (cos(angle) + braked * sin(angle))),)
        )
    motion = Motion({"b0": ((down * cos(angle), 0.0, -down * sin(angle)), (0.0, 0.0, 0.0))})
    assert holds(problem, InitialMotion(motion, Forces((tuple(forces),)))) is lawful
