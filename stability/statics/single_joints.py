"""Parts of a structure that hang on one joint: closed forms for studded bricks under vertical loads.

A part that touches the rest at one contact of two bricks alone loads this contact with all its weight. The studs of the
contact pull as strongly as they can, and its corners press (`stud_program`): the part stands if the sum of its load and
of the pulls acts between the corners. So outer bricks are removed one by one, each with its load added to the brick
that holds it, until each remaining brick has two neighbours at least: only these need a program.

A part that also touches something from the side is left to the program.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import hypot
from typing import TypeAlias

from stability.contact_law import MohrCoulomb
from stability.geometry.vectors import add, cross, scale, subtract
from stability.model import BodyId, Vec3
from stability.problem import ZERO, ConeForces, Contact, Forces, Motion, Problem, Wrench

LEVEL = 1e-12  # parts of a normal across the vertical that are rounding
SQUARE = 1e-9  # share of the diagonals: a patch with a larger difference is no rectangle
CORNERS = 4

Load: TypeAlias = tuple[float, float, float]  # weight [N], and its moments: the weight times x and y [N m]


@dataclass(slots=True)
class _Joint:
    """Level contact of two bodies with its studs."""

    lower: BodyId
    upper: BodyId
    corners_W: tuple[Vec3, ...] = ()
    dry: int = -1  # number of the contact that presses
    studs: list[tuple[int, float, tuple[Vec3, ...]]] = field(
        default_factory=list
    )  # number, pull of a point [N], points

    def pulled(self) -> Load:
        """Return the pull of all studs, and its moments."""
        pull = across = along = 0.0
        for _, each, points in self.studs:
            pull += each * len(points)
            across += each * sum([x for x, _, _ in points])
            along += each * sum([y for _, y, _ in points])
        return pull, across, along


@dataclass(frozen=True, slots=True)
class _Fall:
    """Part that its joint does not hold."""

    joint: _Joint
    edge: int  # of the joint, about which it turns
    part: list[BodyId]
    is_upper: bool  # the part is above the joint


@dataclass(frozen=True, slots=True)
class SingleJoints:
    """Structure without the parts that hang on single joints, and the forces of these joints."""

    problem: Problem  # the whole structure
    rest: Problem  # the remaining bricks with the loads of these parts, and the contacts among them
    contacts: Sequence[int]  # the numbers of these contacts in the whole structure
    forces: dict[int, ConeForces]  # of the single joints, by the number of the contact in the whole structure
    parts: dict[BodyId, list[BodyId]]  # by remaining brick: itself, and all that hangs on it

    def whole_forces(self, rest: Forces) -> Forces:
        """Return forces of the rest as forces of the whole structure."""
        known = self.forces | dict(zip(self.contacts, rest.of_contacts, strict=True))
        return Forces(tuple(known.get(number) or _nothing(each) for number, each in enumerate(self.problem.contacts)))

    def whole_motion(self, rest: Motion) -> Motion:
        """Return a motion of the rest with the parts that hang on it."""
        velocity = {}
        for root, (own, spin) in rest.velocity.items():
            middle = self.problem.bricks[root].pose.position_W
            for name in self.parts[root]:
                arm = subtract(self.problem.bricks[name].pose.position_W, middle)
                velocity[name] = (add(own, cross(spin, arm)), spin)
        return Motion(velocity)


def _nothing(contact: Contact) -> ConeForces:
    return ((ZERO,) * len(contact.normals_W),) * len(contact.points_W)


def single_joints(problem: Problem) -> SingleJoints | Motion:
    """Return a structure without the parts that hang on single joints, or the motion of the least part that falls.

    Neither is proven. If some loads are not vertical, the structure stays whole.
    """
    loads = _loads(problem)
    if loads is None:
        everything = {name: [name] for name in problem.bricks}
        return SingleJoints(problem, problem, range(len(problem.contacts)), {}, everything)
    of_pair, around = _contacts_of_pairs(problem)
    parts: dict[BodyId, list[BodyId]] = {name: [name] for name in problem.bricks}
    forces: dict[int, ConeForces] = {}
    fall: _Fall | None = None
    outer = [name for name in problem.bricks if len(around[name]) == 1]
    while outer:
        name = outer.pop()
        if len(around[name]) != 1:
            continue  # the last of its part, with no fixed body
        (holder,) = around[name]
        joint = _joint(problem, of_pair.get((holder, name)) or of_pair[name, holder])
        if joint is None:
            continue
        load, part, is_upper = loads[name], parts.pop(name), joint.upper == name
        borne = _borne(joint, load if is_upper else (-load[0], -load[1], -load[2]))
        if not isinstance(borne, int):
            forces |= borne
        elif fall is None or len(part) < len(fall.part):
            fall = _Fall(joint, borne, [*part], is_upper)
        around[name] = set()
        if holder in around:
            loads[holder] = _sum(loads[holder], load)
            parts[holder] += part
            around[holder].discard(name)
            if len(around[holder]) == 1:
                outer.append(holder)
    return _rest(problem, loads, parts, forces) if fall is None else _turning(problem, fall)


def _sum(one: Load, other: Load) -> Load:
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]


def _loads(problem: Problem) -> dict[BodyId, Load] | None:
    """Return the load of each brick; None if one is not vertical."""
    loads = {}
    for name, placed in problem.bricks.items():
        wrench = problem.loads.get(name, Wrench(ZERO))
        (fx, fy, fz), (tx, ty, tz) = wrench.force_W, wrench.torque_W
        if fx != 0.0 or fy != 0.0 or tz != 0.0:
            return None
        x, y, _ = placed.pose.position_W
        loads[name] = (-fz, -fz * x + ty, -fz * y - tx)
    return loads


def _contacts_of_pairs(
    problem: Problem,
) -> tuple[dict[tuple[BodyId, BodyId], list[int]], dict[BodyId, set[BodyId]]]:
    """Return the numbers of contacts by lower and upper body, and the bodies that each brick touches."""
    of_pair: dict[tuple[BodyId, BodyId], list[int]] = {}
    for number, contact in enumerate(problem.contacts):
        of_pair.setdefault((contact.lower, contact.upper), []).append(number)
    around: dict[BodyId, set[BodyId]] = {name: set() for name in problem.bricks}
    for lower, upper in of_pair:
        if lower in around:
            around[lower].add(upper)
        if upper in around:
            around[upper].add(lower)
    return of_pair, around


def _joint(problem: Problem, numbers: Sequence[int]) -> _Joint | None:
    """Return the joint of two bodies; None if they touch otherwise than at a level rectangle with or without studs."""
    contacts = [problem.contacts[number] for number in numbers]
    joint = _Joint(contacts[0].lower, contacts[0].upper)
    for number, contact in zip(numbers, contacts, strict=True):
        (across, along, up), *more = contact.normals_W
        if more or hypot(across, along) > LEVEL or up <= 0.0:
            return None
        if isinstance(contact.law, MohrCoulomb) and not contact.law.friction:
            joint.studs.append((number, _pull(contact.law), contact.points_W))
        elif contact.law.is_cone and joint.dry < 0 and _is_rectangle(contact.points_W):
            joint.dry, joint.corners_W = number, contact.points_W
        else:
            return None
    return joint if joint.dry >= 0 else None


@lru_cache(maxsize=64)
def _pull(law: MohrCoulomb) -> float:
    return -float(law.least_normal)


def _is_rectangle(points: Sequence[Vec3]) -> bool:
    if len(points) != CORNERS:
        return False
    a, b, c, d = points
    across, along = subtract(c, a), subtract(d, b)
    least = SQUARE * hypot(*across)
    same = hypot(*subtract(subtract(b, a), subtract(c, d)))  # opposite sides
    return same <= least and abs(hypot(*across) - hypot(*along)) <= least


def _borne(joint: _Joint, load: Load) -> dict[int, ConeForces] | int:
    """Return the forces of a joint that bears a load from above, or the number of the edge about which it opens."""
    press, across, along = _sum(load, joint.pulled())
    a, b, _, d = joint.corners_W
    (ux, uy, _), (vx, vy, _) = subtract(b, a), subtract(d, a)
    # coordinates along both sides, times the pressure
    x, y = across - press * a[0], along - press * a[1]
    u, v = (x * ux + y * uy) / (ux * ux + uy * uy), (x * vx + y * vy) / (vx * vx + vy * vy)
    outside = (-v, u - press, v - press, -u)  # of the edges from a, b, c and d on
    worst = max(range(CORNERS), key=lambda edge: outside[edge] * (hypot(vx, vy) if edge % 2 == 0 else hypot(ux, uy)))
    if outside[worst] > 0.0:
        return worst
    if press <= 0.0:
        shares = (0.0,) * CORNERS
    else:
        u, v = u / press, v / press
        shares = ((1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v)
    forces: dict[int, ConeForces] = {joint.dry: tuple(((0.0, 0.0, share * press),) for share in shares)}
    for number, pull, points in joint.studs:
        forces[number] = (((0.0, 0.0, -pull),),) * len(points)
    return forces


def _turning(problem: Problem, fall: _Fall) -> Motion:
    """Return the motion of a part about an edge of its joint that opens the joint."""
    corners_W, edge = fall.joint.corners_W, fall.edge
    on, end, inner = (corners_W[(edge + number) % CORNERS] for number in range(3))
    spin = subtract(end, on)
    if (cross(spin, subtract(inner, on))[2] > 0.0) != fall.is_upper:
        spin = scale(-1.0, spin)
    spin = scale(1.0 / hypot(*spin), spin)
    places = {name: problem.bricks[name].pose.position_W for name in fall.part}
    return Motion({name: (cross(spin, subtract(place, on)), spin) for name, place in places.items()})


def _rest(
    problem: Problem, loads: dict[BodyId, Load], parts: dict[BodyId, list[BodyId]], forces: dict[int, ConeForces]
) -> SingleJoints:
    gone = problem.bricks.keys() - parts.keys()
    numbers = [i for i, c in enumerate(problem.contacts) if c.lower not in gone and c.upper not in gone]
    wrenches = {}
    for name in parts:
        (x, y, _), (weight, across, along) = problem.bricks[name].pose.position_W, loads[name]
        wrenches[name] = Wrench((0.0, 0.0, -weight), (weight * y - along, across - weight * x, 0.0))
    rest = Problem({name: problem.bricks[name] for name in parts}, [problem.contacts[i] for i in numbers], wrenches)
    return SingleJoints(problem, rest, numbers, forces, parts)
