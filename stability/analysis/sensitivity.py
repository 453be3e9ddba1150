"""Sensitivity of a margin to the data of an assembly, from the forces and the motion at its limit.

At the limit forces balance the loads, and a motion neither gains nor loses power. In a slightly changed problem the
same forces, each at its point and within its cone, leave a residual. The change of the margin is the power of the
residual along the motion, over the power that the motion loses per unit of the margin. By the envelope theorem, changes
of forces and motion do not contribute at first order. Only the data of two problems are compared; no program is solved.

A margin with several motions at its limit is the least of their bounds, so it follows the steepest decrease: it has a
kink, with different slopes on both sides. Non-unique forces or motions at one limit cause a kink as well, which is not
detected here: compute the margin of both problems to find it.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import atan2, pi

from stability.analysis.acceleration_cut import (
    AcceleratedProblem,
    Heading,
    groups_apart,
    heading,
    proven_distance,
    shaken,
)
from stability.analysis.acceleration_margin import acceleration
from stability.analysis.margins import least_friction
from stability.geometry.vectors import add, add_scaled, cross, dot, norm, scale, subtract
from stability.model import BodyId, Vec3
from stability.problem import ZERO, ConeForces, Contact, Forces, Motion, Problem, Tolerances
from stability.process_settings import one_thread
from stability.work_limit import add_work

NEAR = 1e-5  # relative distance beyond the margin at which a limit counts as reached with it
ALIGNED = 1e-6  # [rad] accepted angle between a direction and the normal of its limit
CONTACT = 40.0  # units of work to compare the forces of a contact with another problem
ASIDE = 0.01  # share of the size of a contact: points further apart are different points


@dataclass(frozen=True, slots=True)
class MarginLimit:
    """The limit of a margin: balancing forces, and a motion that neither gains nor loses power."""

    problem: Problem
    forces: Forces
    motion: Motion
    pull_g: tuple[float, float]  # the horizontal acceleration at the limit, in units of g
    gain: float  # the power [W] of the motion per unit of the margin


@dataclass(frozen=True, slots=True)
class Slopes:
    """Slopes of a margin per unit of a number, for a decrease and an increase of it."""

    less: float
    more: float


@one_thread()
def acceleration_limits(
    problem: Problem, gravity: float, tolerance: float = 1e-7
) -> tuple[float, tuple[MarginLimit, ...]]:
    """Return the margin of acceleration [g] and all limits reached at it; no limits if no fall is proven.

    Bodies that slide alike in all directions have more limits than these four.
    """
    margin = acceleration(problem, tolerance, gravity)
    if margin is None or margin.motion is None:
        return (0.0 if margin is None else margin.value), ()
    limits: dict[tuple[int, float], MarginLimit] = {}
    for number, part in enumerate(groups_apart(problem)):
        case = shaken(part, gravity, Tolerances())
        assert case is not None  # the margin of the whole problem is known
        for quarter in range(4):
            for one in _aligned(case, margin.bearing + 0.5 * pi * quarter):
                assert one.cut is not None
                if proven_distance(case, one.cut) <= margin.upper * (1.0 + NEAR):
                    limits.setdefault((number, round(one.angle, 5) % (2.0 * pi)), _limit(case, one))
    return margin.value, tuple(limits.values())


def _aligned(case: AcceleratedProblem, angle: float) -> Iterator[Heading]:
    """Yield the limits of a direction, each at the direction in which it is reached first."""
    one = heading(case, angle)
    if one.cut is None:
        return
    normal = atan2(one.cut.normal[1], one.cut.normal[0])
    if abs((normal - angle + pi) % (2.0 * pi) - pi) > ALIGNED:
        one = heading(case, normal)
    if one.cut is not None:
        yield one


def _limit(case: AcceleratedProblem, one: Heading) -> MarginLimit:
    assert one.cut is not None
    forces = case.at(*one.point).forces(one.rows)
    motion = one.cut.motion
    x, y = (part / one.reach for part in one.point) if one.reach > 0.0 else one.cut.normal
    pulled = case.pull(x, y)
    gain = sum(dot(pulled[name].force_W, velocity) for name, (velocity, _) in motion.velocity.items())
    return MarginLimit(case.problem, forces, motion, one.point, gain)


@one_thread()
def friction_limits(problem: Problem, tolerance: float = 1e-9) -> tuple[float, tuple[MarginLimit, ...]]:
    """Return the least factor on all friction for which forces balance, and its limit, if it has one."""
    margin = least_friction(problem, tolerance)
    if margin.forces is None or margin.motion is None or not margin.factor > 0.0:
        return margin.factor, ()
    limit = MarginLimit(problem, margin.forces, margin.motion, (0.0, 0.0), 1.0)
    gain = _power_of_friction(limit) / margin.factor
    return margin.factor, (replace(limit, gain=gain),) if gain < 0.0 else ()


def _power_of_friction(limit: MarginLimit) -> float:
    power = 0.0
    for contact, forces in zip(limit.problem.contacts, limit.forces.of_contacts, strict=True):
        for point, at_point in zip(contact.points_W, forces, strict=True):
            slip = _slip(limit.problem, limit.motion, contact, point)
            for normal, force in zip(contact.normals_W, at_point, strict=True):
                power += dot(add_scaled(force, -dot(force, normal), normal), slip)
    return power


# --- slopes -----------------------------------------------------------------------------------------------------------


@one_thread()
def slopes(limits: Sequence[MarginLimit], less: Problem | None, more: Problem | None, step: float) -> Slopes | None:
    """Return the slopes of a margin at its limits, from problems with a number decreased and increased by `step`.

    None if a problem is missing or has other contacts, so that no comparison is possible.
    """
    if not limits or less is None or more is None:
        return None
    falling, rising = [], []
    for limit in limits:
        below, above = (_change(limit, each) for each in (less, more))
        if below is None or above is None:
            return None
        falling.append(below / (step * limit.gain))
        rising.append(-above / (step * limit.gain))
    return Slopes(max(falling), min(rising))


def _change(limit: MarginLimit, other: Problem) -> float | None:
    """Return the power along the limit's motion that loads and contact forces gain in another problem.

    The forces move with their contacts. Only loads, contacts and bricks that differ are compared.
    """
    own = limit.problem
    if not other.bricks.keys() >= own.bricks.keys():
        return None
    add_work(CONTACT * len(own.contacts))
    moved = {name for name, placed in own.bricks.items() if other.bricks[name].pose != placed.pose}
    change = 0.0
    for name, (velocity, spin) in sorted(limit.motion.velocity.items()):
        if other.loads[name] != own.loads[name]:
            for problem, sign in ((other, 1.0), (own, -1.0)):
                load = problem.loads[name]
                x, y = (-load.force_W[2] * share for share in limit.pull_g)
                change += sign * (dot(add(load.force_W, (x, y, 0.0)), velocity) + dot(load.torque_W, spin))
    contacts = dict(zip(_numbered(other.contacts), other.contacts, strict=True))
    numbered = zip(_numbered(own.contacts), own.contacts, limit.forces.of_contacts, strict=True)
    for key, contact, forces in numbered:
        now = contacts.get(key)
        if now == contact and contact.lower not in moved and contact.upper not in moved:
            continue
        if all(force == ZERO for at_point in forces for force in at_point):
            continue
        here = _carried(limit, contact, forces, contact, own)
        there = None if now is None else _carried(limit, contact, forces, now, other)
        if here is None or there is None:
            return None
        change += there - here
    return change


def _numbered(contacts: Sequence[Contact]) -> Iterator[tuple[BodyId, BodyId, int]]:
    """Yield the bodies of each contact, with its number among the contacts of both."""
    counts: Counter[tuple[BodyId, BodyId]] = Counter()
    for contact in contacts:
        pair = contact.lower, contact.upper
        yield *pair, counts[pair]
        counts[pair] += 1


def _carried(limit: MarginLimit, contact: Contact, forces: ConeForces, now: Contact, other: Problem) -> float | None:
    """Return the power of forces that move with the points and cones of a contact; None if the points differ."""
    order = _same_points(contact, now)
    if order is None or len(contact.normals_W) != len(now.normals_W):
        return None
    rougher = now.law.friction / contact.law.friction if contact.law.friction > 0.0 else 1.0
    power = 0.0
    for number, at_point in zip(order, forces, strict=True):
        slip = _slip(other, limit.motion, now, now.points_W[number])
        for normal, turned, force in zip(contact.normals_W, now.normals_W, at_point, strict=True):
            pressed = dot(force, normal)
            rubbed = _turned(add_scaled(force, -pressed, normal), turned)
            power += dot(add_scaled(scale(rougher, rubbed), pressed, turned), slip)
    return power


def _turned(tangential: Vec3, normal: Vec3) -> Vec3:
    """Return a tangential force rotated into the plane across another normal, with its size unchanged."""
    across = add_scaled(tangential, -dot(tangential, normal), normal)
    size = norm(across)
    return scale(norm(tangential) / size, across) if size > 0.0 else ZERO


def _same_points(contact: Contact, now: Contact) -> list[int] | None:
    """Return the index of the nearly equal point of `now` for each point of a contact; None if one has none."""
    if len(contact.points_W) != len(now.points_W):
        return None
    size = max(norm(subtract(point, contact.points_W[0])) for point in contact.points_W)
    nearest = [_nearest(point, now.points_W) for point in contact.points_W]
    if len(set(nearest)) < len(nearest):
        return None
    apart = max(norm(subtract(now.points_W[n], point)) for n, point in zip(nearest, contact.points_W, strict=True))
    return nearest if apart <= ASIDE * size or len(nearest) == 1 else None


def _nearest(point: Vec3, points: Sequence[Vec3]) -> int:
    distances = [norm(subtract(other, point)) for other in points]
    return distances.index(min(distances))


def _slip(problem: Problem, motion: Motion, contact: Contact, point: Vec3) -> Vec3:
    """Return the velocity of the upper body relative to the lower one at a point [m/s]."""
    return subtract(*(_velocity(problem, motion, body, point) for body in (contact.upper, contact.lower)))


def _velocity(problem: Problem, motion: Motion, body: str, point: Vec3) -> Vec3:
    if body not in motion.velocity:
        return ZERO
    velocity, spin = motion.velocity[body]
    return add(velocity, cross(spin, subtract(point, problem.bricks[body].pose.position_W)))
