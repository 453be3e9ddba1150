"""Describes a fall: the bricks that tip, slide or drop, the bodies that they tip over, and the direction."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import atan2, dist, hypot

from stability.contact_law import ContactLaw
from stability.geometry.vectors import subtract
from stability.model import BodyId, Vec3
from stability.name_order import in_order, names_text
from stability.problem import ZERO, Contact, Motion, Placed, Problem, Stability, Stage, Verdict

# Description of a fall: bricks that tip over others, slide on others, or drop without support.


STUCK = 1e-2  # of the speed of a group: a point that is slower relative to another body is a pivot of the group
TURNING = 1e-3  # of the speed of a group: its spin may add this much without the motion counting as a rotation
ROUNDED = 1e-5  # of the fastest brick: slower bricks are numerical noise of the solver, and count as standing


@dataclass(frozen=True, slots=True)
class _Slip:
    """Relative motion of the upper body of a contact at a point, for one normal there."""

    separating: float  # along the normal [m/s]
    sliding: float  # across the normal [m/s]
    law: ContactLaw

    def size(self) -> float:
        """Return the relative speed [m/s]."""
        return hypot(self.separating, self.sliding)

    def sticks(self, speed: float) -> bool:
        """Return whether the point is static, compared with the speed of its group [m/s]."""
        return self.size() <= STUCK * speed

    def slides(self, speed: float) -> bool:
        """Return whether the point slides along the other body: it separates at most as fast as friction allows."""
        return -self.law.shortfall(self.separating, self.sliding) <= STUCK * speed and self.sliding > self.separating


def described(problem: Problem, motion: Motion) -> str:
    """Return moving bricks and motion, such as "L5.1, L5.2 tip over L4.1" or "plank slides on ground"."""
    motion = Motion({name: motion.velocity[name] for name in really_moving(problem, motion)})
    groups = _groups(problem, motion)
    return "; ".join(_of_group(problem, motion, group) for group in groups)


def really_moving(problem: Problem, motion: Motion) -> tuple[BodyId, ...]:
    """Return the moving bricks, without those whose motion is numerical noise of the solver."""
    speeds = {name: _speed(problem, motion, name) for name in motion.velocity}
    least = ROUNDED * max(speeds.values(), default=0.0)
    return tuple(name for name in motion.velocity if speeds[name] >= least)


def _groups(problem: Problem, motion: Motion) -> list[list[BodyId]]:
    """Return the groups of touching bricks that move as one body, by the lowest brick of each."""
    group_of = {name: [name] for name in sorted(motion.velocity)}
    for contact in problem.contacts:
        lower, upper = group_of.get(contact.lower), group_of.get(contact.upper)
        if lower is None or upper is None or lower is upper:
            continue
        if _as_one(problem, motion, contact):
            lower += upper
            for name in upper:
                group_of[name] = lower
    distinct = {id(group): sorted(group) for group in group_of.values()}
    return sorted(distinct.values(), key=lambda group: (_lowest(problem, group), group))


def _as_one(problem: Problem, motion: Motion, contact: Contact) -> bool:
    """Return whether two bricks move as one body: with equal velocity at the contact and equal spin."""
    pair = (contact.lower, contact.upper)
    still = STUCK * max(_speed(problem, motion, name) for name in pair)
    turn = hypot(*subtract(*(motion.velocity[name][1] for name in pair))) * max(_half(problem, name) for name in pair)
    return turn <= still and all(slip.size() <= still for slip in _slips(problem, motion, contact))


def _lowest(problem: Problem, group: Sequence[BodyId]) -> float:
    return min(problem.bricks[name].pose.position_W[2] for name in group)


def _of_group(problem: Problem, motion: Motion, group: Sequence[BodyId]) -> str:
    about, along = _still_against(problem, motion, group)
    if about and _turns(problem, motion, group):
        also = f" and {_verb('slide', group)} on {_named(problem, along)}" if along else ""
        return f"{_named(problem, group)} {_verb('tip', group)} over {_named(problem, about)}{also}"
    if along or about:
        return f"{_named(problem, group)} {_verb('slide', group)} on {_named(problem, along | about)}"
    has_something_under_it = any(other == contact.lower for contact, other in _border(problem, group))
    why = "nothing holds" if has_something_under_it else "nothing is under"
    return f"{_named(problem, group)} {_verb('fall', group)}: {why} {'them' if len(group) > 1 else 'it'}"


def sliding_supports(problem: Problem, motion: Motion) -> tuple[BodyId, ...]:
    """Return the bodies on which all bricks of a problem slide without tipping; empty for any other motion."""
    moving = really_moving(problem, motion)
    if {*moving} != problem.bricks.keys():
        return ()
    motion = Motion({name: motion.velocity[name] for name in moving})
    supports: set[BodyId] = set()
    for group in _groups(problem, motion):
        about, along = _still_against(problem, motion, group)
        if about or not along or _turns(problem, motion, group):
            return ()
        supports |= along
    return () if supports & problem.bricks.keys() else tuple(in_order(supports))


def _verb(stem: str, group: Sequence[BodyId]) -> str:
    return stem if len(group) > 1 else f"{stem}s"


def _still_against(problem: Problem, motion: Motion, group: Sequence[BodyId]) -> tuple[set[BodyId], set[BodyId]]:
    """Return the bodies on which a group pivots, and those along which it slides without a pivot."""
    speed = _group_speed(problem, motion, group)
    about, along = set[BodyId](), set[BodyId]()
    for contact, other in _border(problem, group):
        for slip in _slips(problem, motion, contact):
            if slip.sticks(speed):
                about.add(other)
            elif slip.slides(speed):
                along.add(other)
    along -= about
    # A group tips over static bodies; bodies that move along with it count only if no body is static.
    standing = (about | along) - motion.velocity.keys()
    return (about & standing, along & standing) if standing else (about, along)


def _turns(problem: Problem, motion: Motion, group: Sequence[BodyId]) -> bool:
    least = TURNING * _group_speed(problem, motion, group)
    return any(hypot(*motion.velocity[name][1]) * _half(problem, name) > least for name in group)


def _group_speed(problem: Problem, motion: Motion, group: Sequence[BodyId]) -> float:
    return max(_speed(problem, motion, name) for name in group)


def _border(problem: Problem, group: Sequence[BodyId]) -> Iterator[tuple[Contact, BodyId]]:
    """Yield the contacts of a group with other bodies, each with the other body."""
    members = set(group)
    for contact in problem.contacts:
        if (contact.lower in members) != (contact.upper in members):
            yield contact, contact.lower if contact.upper in members else contact.upper


def _slips(problem: Problem, motion: Motion, contact: Contact) -> Iterator[_Slip]:
    for point in contact.points_W:
        above, below = (_velocity_at(problem, motion, name, point) for name in (contact.upper, contact.lower))
        slip = subtract(above, below)
        for normal in contact.normals_W:
            separating = sum(a * b for a, b in zip(slip, normal, strict=True))
            sideways = subtract(slip, (separating * normal[0], separating * normal[1], separating * normal[2]))
            yield _Slip(separating, hypot(*sideways), contact.law)


def _velocity_at(problem: Problem, motion: Motion, name: BodyId, point: Vec3) -> Vec3:
    if name not in motion.velocity:
        return ZERO
    (vx, vy, vz), (wx, wy, wz) = motion.velocity[name]
    x, y, z = subtract(point, problem.bricks[name].pose.position_W)
    return (vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x)


def _speed(problem: Problem, motion: Motion, name: BodyId) -> float:
    velocity, spin = motion.velocity[name]
    return hypot(*velocity) + hypot(*spin) * _half(problem, name)


def _half(problem: Problem, name: BodyId) -> float:
    return problem.bricks[name].brick.shape.bounding_radius


def _named(problem: Problem, bodies: Sequence[BodyId] | set[BodyId]) -> str:
    return names_text(in_order(bodies), among=problem.bricks)


# The direction of a fall, and the overhang of the centre of mass over the tipping edge.


ALIKE = 1e-6  # share by which spins of one body may differ
SIDEWAYS = 0.05  # of the mean speed: a motion with a smaller horizontal part counts as straight down


@dataclass(frozen=True, slots=True)
class FallSide:
    """Direction of a fall; fields are None for bricks that drop straight down."""

    bearing: float | None = None  # from +x towards +y [rad]
    # of the common centre of mass beyond the edge, in plan [m]; only for bricks that tip as one body
    overhang: float | None = None


def fall_side(verdict: Verdict, bricks: Mapping[BodyId, Placed]) -> FallSide:
    """Return the direction of a proven fall of placed bricks."""
    motion = verdict.motion
    if verdict.stability is not Stability.UNSTABLE or motion is None or not motion.velocity:
        return FallSide()
    as_one = verdict.stage is Stage.TIPPING and _turns_as_one(motion)
    return _over_an_edge(motion, bricks) if as_one else _sideways(motion, bricks)


def _turns_as_one(motion: Motion) -> bool:
    """Return whether all bricks have one spin, as in a tip over one edge without any other motion."""
    spins = [spin for _, spin in motion.velocity.values()]
    return all(dist(spin, spins[0]) <= ALIKE * hypot(*spins[0]) for spin in spins)


def _over_an_edge(motion: Motion, bricks: Mapping[BodyId, Placed]) -> FallSide:
    """Return the direction of a rotation as one body about a level edge: sink rate = spin times lever arm."""
    _, (wx, wy, _) = next(iter(motion.velocity.values()))
    spin = hypot(wx, wy)
    if spin == 0.0:
        return FallSide()
    masses = {name: bricks[name].brick.mass for name in motion.velocity}
    sinking = -sum(mass * motion.velocity[name][0][2] for name, mass in masses.items()) / sum(masses.values())
    return FallSide(atan2(-wx, wy), sinking / spin)


def _sideways(motion: Motion, bricks: Mapping[BodyId, Placed]) -> FallSide:
    """Return the direction of any other motion: the mean horizontal motion of the mass, if large enough."""
    x = y = speed = 0.0
    for name, (velocity, _) in motion.velocity.items():
        mass = bricks[name].brick.mass
        x, y, speed = x + mass * velocity[0], y + mass * velocity[1], speed + mass * hypot(*velocity)
    return FallSide(atan2(y, x)) if hypot(x, y) > SIDEWAYS * speed else FallSide()
