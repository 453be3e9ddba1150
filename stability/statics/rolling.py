"""Decides whether contacts keep balanced round bodies from rolling.

A ball on level ground is in balance, but nothing holds it. Round bodies are held if forces also balance the loads with
a small disturbance, in either sense: forces of different size along all ways in which a contact may roll. A motion that
no contact resists and along which the loads gain no power cannot gain power from both disturbances, so it moves no
contact.
"""

from collections.abc import Sequence
from dataclasses import replace

from stability.geometry.vectors import add, cross, norm, scale, subtract
from stability.model import BodyId, Vec3
from stability.problem import ZERO, Contact, Forces, Problem, Tolerances, Wrench
from stability.statics.equilibrium import balance
from stability.statics.self_stress import forces_without_self_stress

SMALL = 1e-7  # of the load of a body: the disturbance
GOLDEN = 0.6180339887498949  # spreads the sizes of disturbances evenly, so that no motion is perpendicular to all


def rolls_freely(problem: Problem, tolerances: Tolerances) -> bool:
    """Return whether nothing is proven to keep round bodies of a balanced problem from rolling."""
    pushes = _pushes(problem.contacts, problem)
    if not pushes:
        return False
    return any(_disturbed(problem, pushes, sign, tolerances) is None for sign in (1.0, -1.0))


def _pushes(contacts: Sequence[Contact], problem: Problem) -> list[tuple[BodyId, Vec3, Vec3]]:
    """Return the body, the force [N] and the point [m] of each part of the disturbance."""
    pushes: list[tuple[BodyId, Vec3, Vec3]] = []
    ways = [(contact, way) for contact in contacts for way in contact.rolling]
    for number, (contact, way) in enumerate(ways):
        size = 0.5 + 0.5 * ((number + 1) * GOLDEN % 1.0)
        bodies = [body for body in (contact.lower, contact.upper) if body in problem.bricks]
        least = min(norm(problem.loads[body].force_W) for body in bodies)
        force = scale(SMALL * size * least, way.direction_W)
        for body, sign, at in ((contact.upper, 1.0, way.upper_W), (contact.lower, -1.0, way.lower_W)):
            if body in problem.bricks:
                pushes.append((body, scale(sign, force), at))
    return pushes


def _disturbed(
    problem: Problem, pushes: Sequence[tuple[BodyId, Vec3, Vec3]], sign: float, tolerances: Tolerances
) -> Forces | None:
    """Return forces without self-stress that balance the disturbed problem, if there are any."""
    loads = dict(problem.loads)
    for body, force, at in pushes:
        arm = subtract(at, problem.bricks[body].pose.position_W)
        own = loads.get(body, Wrench(ZERO))
        push = scale(sign, force)
        loads[body] = Wrench(add(own.force_W, push), add(own.torque_W, cross(arm, push)))
    disturbed = replace(problem, loads=loads)
    answer = balance(disturbed, tolerances)
    if answer.forces is None or answer.frictionless:
        return answer.forces
    return forces_without_self_stress(disturbed, answer.forces, tolerances)
