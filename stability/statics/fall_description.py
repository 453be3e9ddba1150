"""Describes a fall: the bricks that tip, slide or drop, the bodies that they tip over, and the direction."""

from collections.abc import Collection, Iterator, Mapping, Sequence
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
STEEP = 0.5**0.5  # z of a unit normal at 45 deg: a body below a contact with a larger one is under the other
UPRIGHT = 1e-3  # z of the normal of a vertical face, at most
MOST_PARTS = 3  # of a fall that are all described
MOST_BLOCKS = 3  # groups of several bricks that move alike and are written out
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


def described(problem: Problem, motion: Motion, cause: Collection[BodyId] = ()) -> str:
    """Return moving bricks and motion, such as "L5.1, L5.2 tip over L4.1" or "plank slides on ground".

    Groups with bricks of `cause` come first, then the others from the lowest on.
    """
    return "; ".join(_parts(problem, motion, cause))


def described_from(problem: Problem, motion: Motion, proven: Verdict) -> str:
    """Describe the whole motion that begins with a proven fall: all its parts if they are few, else that fall first."""
    parts = _parts(problem, motion, proven.moving)
    if len(parts) <= MOST_PARTS:
        return "; ".join(parts)
    others = [name for name in really_moving(problem, motion) if name not in proven.moving]
    more = f"{len(others)} more brick{'s start' if len(others) > 1 else ' starts'} to move"
    return f"{proven.reason}; {more}: {_named(problem, others)}" if others else proven.reason


def _parts(problem: Problem, motion: Motion, cause: Collection[BodyId]) -> list[str]:
    motion = Motion({name: motion.velocity[name] for name in really_moving(problem, motion)})
    alike: dict[_Way, list[list[BodyId]]] = {}
    for group in sorted(_groups(problem, motion), key=lambda group: not {*cause} & {*group}):
        alike.setdefault(_way_of(problem, motion, group), []).append(group)
    return [_told(problem, way, groups) for way, groups in alike.items()]


@dataclass(frozen=True, slots=True)
class _Way:
    """The way in which a group begins to move."""

    verb: str
    rest: str  # after the verb; `{it}` stands for the group


def _told(problem: Problem, way: _Way, groups: Sequence[Sequence[BodyId]]) -> str:
    """Describe groups that move alike, but not as one body: "C1, C2 each tip over ground"."""
    several = len(groups) > 1 or len(groups[0]) > 1
    ending = f"{way.verb if several else f'{way.verb}s'}{way.rest.format(it='them' if several else 'it')}"
    if len(groups) == 1 or way.verb == "slide":
        return f"{_named(problem, [name for group in groups for name in group])} {ending}"
    if all(len(group) == 1 for group in groups):
        return f"{_named(problem, [group[0] for group in groups])} each {ending}"
    blocks = [f"[{_named(problem, group)}]" if len(group) > 1 else group[0] for group in groups]
    left_out = len(blocks) - MOST_BLOCKS
    shown = [*blocks[:MOST_BLOCKS], f"{left_out} more groups"] if left_out > 1 else blocks
    return f"{', '.join(shown[:-1])} and {shown[-1]} each {ending}"


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


def _way_of(problem: Problem, motion: Motion, group: Sequence[BodyId]) -> _Way:
    about, along = _still_against(problem, motion, group)
    sinks = sum(motion.velocity[name][0][2] for name in group) < 0.0
    if (about or along) and sinks and not _turns(problem, motion, group) and _is_only_beside(problem, group):
        return _Way("slide", f" down along {_named(problem, about | along)}: nothing is under {{it}}")
    if about and _turns(problem, motion, group):
        if not along and _only_rolls(problem, group, about):
            return _Way("roll", f" on {_named(problem, about)}")
        also = f" and {'slide' if len(group) > 1 else 'slides'} on {_named(problem, along)}" if along else ""
        return _Way("tip", f" over {_named(problem, about)}{also}")
    if along or about:
        return _Way("slide", f" on {_named(problem, along | about)}")
    under = dict(_slips_under(problem, motion, group))
    if not under:
        return _Way("fall", ": nothing is under {it}")
    # Of all motions that prove a fall, the solver may find one that also lifts a sliding brick a little.
    below = [other for other, slips in under.items() if any(slip.sliding > slip.separating for slip in slips)]
    if below:
        return _Way("slide", f" on {_named(problem, [name for name in below if name not in motion.velocity] or below)}")
    gives_way = [name for name in under if name in motion.velocity]
    if sinks and gives_way:
        return _Way("fall", f" with {_named(problem, gives_way)}")
    return _Way("lift", f" off {_named(problem, [*under])}")


def _only_rolls(problem: Problem, group: Sequence[BodyId], about: Collection[BodyId]) -> bool:
    """Return whether all contacts of a group with its pivots are on curved surfaces."""
    return all(contact.rolling for contact, other in _border(problem, group) if other in about)


def _is_only_beside(problem: Problem, group: Sequence[BodyId]) -> bool:
    """Return whether a group touches other bodies with vertical faces only, or from below."""
    return all(
        contact.lower in group or all(abs(normal[2]) <= UPRIGHT for normal in contact.normals_W)
        for contact, _ in _border(problem, group)
    )


def _slips_under(problem: Problem, motion: Motion, group: Sequence[BodyId]) -> Iterator[tuple[BodyId, list[_Slip]]]:
    """Yield the bodies under a group, with the motion of the group relative to each."""
    for contact, other in _border(problem, group):
        if other == contact.lower and all(normal[2] > STEEP for normal in contact.normals_W):
            yield other, list(_slips(problem, motion, contact))


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
