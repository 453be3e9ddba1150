"""Checks by plain arithmetic whether bricks at rest could start to move as is said, trusting nothing but the problem.

The forces must balance loads and inertia on every brick, within their cones. At every point where forces act neither
may open, and where the bodies slip friction must be as large as it can be, against the slip. No point may close.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import hypot, inf

from stability.geometry.vectors import add, cross, dot, scale, subtract
from stability.mechanics.inertia import inertia_times
from stability.model import BodyId, Vec3
from stability.statics.facts import ZERO, Contact, Motion, Problem, Tolerances, Wrench
from stability.statics.outcomes.other_start import Start
from stability.statics.proof import check_forces
from stability.statics.rounding import rounded

LAWFUL = 1e-8  # of the largest acceleration, and of that times the largest force: what laws may be violated by rounding


@dataclass(frozen=True, slots=True)
class StartCheck:
    """Whether bricks could start so, and by how much that violates the laws of contact."""

    holds: bool
    violation: float  # relative to the largest acceleration of a point, and force


def check_start(problem: Problem, start: Start, tolerances: Tolerances) -> StartCheck:
    """Whether a start obeys the laws of motion and of contact, and is none of rest."""
    moving = replace(problem, loads=dict(_with_inertia(problem, start.acceleration)))
    balanced = check_forces(moving, start.forces, rounded(problem, tolerances)).holds
    if not balanced or any(len(contact.normals_W) > 1 for contact in problem.contacts):
        return StartCheck(holds=False, violation=inf)
    points = list(_points(problem, start))
    fastest = max((hypot(*slip) for _, _, _, slip in points), default=0.0)
    strongest = max((hypot(*force) for _, _, force, _ in points), default=0.0)
    if not fastest > 0.0:
        return StartCheck(holds=False, violation=inf)
    violation = max(_violation(each, fastest, strongest) for each in points)
    return StartCheck(violation <= LAWFUL, violation)


def _with_inertia(problem: Problem, acceleration: Motion) -> Iterator[tuple[BodyId, Wrench]]:
    """Loads less what the accelerations of the bricks take of them."""
    for name, placed in problem.bricks.items():
        load = problem.loads.get(name, Wrench(ZERO))
        linear, angular = acceleration.velocity.get(name, (ZERO, ZERO))
        force = subtract(load.force_W, scale(placed.brick.mass, linear))
        turned = inertia_times(placed.brick, placed.pose.orientation, angular)
        yield name, Wrench(force, subtract(load.torque_W, turned))


def _points(problem: Problem, start: Start) -> Iterator[tuple[Vec3, float, Vec3, Vec3]]:
    """Of each point the normal, friction, the force on the upper body, and the slip of that against the lower."""
    for contact, forces in zip(problem.contacts, start.forces.of_contacts, strict=True):
        for point, (force,) in zip(contact.points_W, forces, strict=True):
            yield contact.normals_W[0], contact.friction, force, _slip(problem, start.acceleration, contact, point)


def _slip(problem: Problem, acceleration: Motion, contact: Contact, point: Vec3) -> Vec3:
    above, below = (_at(problem, acceleration, name, point) for name in (contact.upper, contact.lower))
    return subtract(above, below)


def _at(problem: Problem, acceleration: Motion, name: BodyId, point: Vec3) -> Vec3:
    if name not in acceleration.velocity:
        return ZERO
    linear, angular = acceleration.velocity[name]
    return add(linear, cross(angular, subtract(point, problem.bricks[name].pose.position_W)))


def _violation(point: tuple[Vec3, float, Vec3, Vec3], fastest: float, strongest: float) -> float:
    """By how much a point closes, or a force works where it must not, or friction is less than it can be."""
    normal, friction, force, slip = point
    opening, pressed = dot(normal, slip), dot(normal, force)
    across = subtract(slip, scale(opening, normal))
    not_braked = friction * pressed * hypot(*across) + dot(force, across)
    work = max(abs(opening * pressed), abs(not_braked)) / (fastest * strongest) if strongest > 0.0 else 0.0
    return max(-opening / fastest, work)
