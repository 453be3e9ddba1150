"""Checks by plain arithmetic whether forces balance a problem or a motion lowers it, trusting nothing but the problem.

Forces prove that a problem can stand: each contact can bear them, and their sum on every brick is zero. A motion proves
that it cannot: the loads gain more power by it than any contact forces can take. Then no forces balance the loads, as
their total power would be both zero and positive. The law of a contact defines the forces that it can bear and the
power that it can take.

Tolerances are larger than rounding errors. A residual is relative to the load of its own brick, so that a heavy brick
does not hide a light one. A violated contact is relative to the speed of its two bodies; the power that its force could
gain, were it to carry the load of all moving bricks, is subtracted before the power counts as positive.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import islice
from math import hypot, inf, isfinite, nan
from typing import Self

import numpy as np

from stability.contact_law import ContactLaw
from stability.geometry.round_patch import Disc, RoundPatch
from stability.geometry.rows import Array, Indices, cross_rows
from stability.geometry.vectors import add_scaled, dot, norm
from stability.model import BodyId, Vec3
from stability.problem import ZERO, Contact, Forces, Motion, Problem, Tolerances, UnknownTension, Wrench

# Relative to a force, or to the load capacity of the lighter of its two bricks: a smaller violation of a cone is
# rounding.
ROUNDING = 1e-12
UNIT = 1e-9  # accepted error of the length of normals
UNLOADED = Wrench(ZERO)


@dataclass(frozen=True, slots=True)
class ForceCheck:
    """Result of a check of forces: whether they balance a problem, and where the residual is largest."""

    holds: bool
    residual: float  # the largest on any brick, relative to the load capacity of the brick
    brick: BodyId  # the brick with the largest residual; "" if there is none
    cone: float  # the largest violation of any cone, relative to its force and to the load capacity of its bricks


@dataclass(frozen=True, slots=True)
class MotionCheck:
    """Result of a check of a motion: whether it proves that a problem falls, and by what margin."""

    holds: bool
    gain: float  # power of the loads minus the cost of violations, relative to the sum of force times speed
    violation: float  # the largest at any contact, relative to the speed of its bodies there


@dataclass(frozen=True, slots=True, eq=False)
class PointLaws:
    """Laws of some points. Points of one kind share one law whose numbers are arrays, for speed."""

    of_kinds: Sequence[tuple[Indices | slice, ContactLaw]]  # indices of points, and their law

    @classmethod
    def of(cls, laws: Sequence[ContactLaw], points: Indices) -> Self:
        """Return the laws of contacts, each for its number of points."""
        kinds = list(dict.fromkeys(map(type, laws)))
        if len(kinds) == 1:
            return cls([(slice(None), _stacked(laws, points))])
        kind = np.array([kinds.index(type(law)) for law in laws], dtype=np.int64)
        own = [(np.flatnonzero(np.repeat(kind, points) == i), np.flatnonzero(kind == i)) for i in range(len(kinds))]
        return cls([(where, _stacked([laws[i] for i in which.tolist()], points[which])) for where, which in own])

    def are_sound(self) -> bool:
        """Return whether the numbers of all laws are not negative and not NaN."""
        return all(law.is_sound() for _, law in self.of_kinds)

    def violation(self, normal: Array, tangential: Array) -> Array:
        """Return by how much each force violates the law of its contact [N]."""
        return self._each(normal, tangential, lambda law, *own: law.violation(*own))

    def shortfall(self, opening: Array, sliding: Array) -> Array:
        """Return by how much each slip opens its contact too slowly to bound the power of forces [m/s]."""
        return self._each(opening, sliding, lambda law, *own: law.shortfall(*own))

    def support(self, opening: Array, sliding: Array, press: float) -> Array:
        """Return the greatest power that forces can take from each slip [W], with normal forces up to `press` [N]."""
        return self._each(opening, sliding, lambda law, *own: law.support(*own, press))

    def _each(self, one: Array, other: Array, of: Callable[[ContactLaw, Array, Array], Array]) -> Array:
        values = np.zeros(len(one))
        for where, law in self.of_kinds:
            values[where] = of(law, one[where], other[where])
        return values


def _stacked(laws: Sequence[ContactLaw], points: Indices) -> ContactLaw:
    """Return one law for the points of contacts whose laws are of one kind."""
    names = [each.name for each in fields(laws[0])]
    numbers = [np.array([getattr(law, name) for law in laws], dtype=float) for name in names]
    return type(laws[0])(*(np.repeat(each, points) for each in numbers))


@dataclass(frozen=True, slots=True, eq=False)
class ProofCones:
    """Places of forces: by contact, point and normal. A fixed body has the index after the last brick.

    Loads are not included: problems that differ only in loads may share it.
    """

    names: Sequence[BodyId]
    bodies: tuple[Indices, Indices]  # lower and upper body of each cone
    arms: tuple[Array, Array]  # (n, 3) from their centres to the point [m]; meaningless for a fixed body
    normals: Array  # (n, 3)
    laws: PointLaws


@dataclass(frozen=True, slots=True, eq=False)
class ProofLoads:
    """Loads on the bricks of a problem, in the order of their names."""

    wrenches: Array  # (bricks, 6) [N, N m]
    half: Array  # (bricks,) bounding radii [m]
    names: Sequence[BodyId]


FORCES_FAIL = ForceCheck(holds=False, residual=inf, brick="", cone=inf)
MOTION_FAILS = MotionCheck(holds=False, gain=-inf, violation=inf)


def check_forces(
    problem: Problem, forces: Forces, tolerances: Tolerances, known: ProofCones | None = None
) -> ForceCheck:
    """Check whether forces lie in their cones and balance the loads on every brick; `known` are the cones."""
    cones = known or proof_cones(problem)
    pressed = _pressed(problem, forces)
    if cones is None or pressed is None or not _are_borne(problem, forces.more_tension):
        return FORCES_FAIL
    return check_pressed(cones, proof_loads(problem.drawn(forces.more_tension)), pressed, tolerances)


def check_pressed(cones: ProofCones, loads: ProofLoads, pressed: Array, tolerances: Tolerances) -> ForceCheck:
    """Check as `check_forces` whether the forces (n, 3) of cones [N] balance loads."""
    if not np.isfinite(pressed).all():
        return FORCES_FAIL
    names, half = loads.names, loads.half
    (lower, upper), (lower_arms, upper_arms) = cones.bodies, cones.arms
    wrench = np.vstack([loads.wrenches, np.zeros((1, 6))])
    _add(wrench, upper, np.hstack([pressed, cross_rows(upper_arms, pressed)]))
    _add(wrench, lower, -np.hstack([pressed, cross_rows(lower_arms, pressed)]))
    carried = np.append(_size(loads.wrenches[:, :3]) + _size(loads.wrenches[:, 3:]) / half, inf)
    carried += np.bincount(lower, np.maximum(pressed[:, 2], 0.0), minlength=len(carried))
    cone = _cone_violation(cones, pressed, np.minimum(carried[lower], carried[upper]))
    residual = np.maximum(_size(wrench[:-1, :3]), _size(wrench[:-1, 3:]) / half) if names else np.zeros(0)
    relative = _ratio(residual, carried[:-1])
    worst = int(np.argmax(relative)) if names else -1
    largest = float(relative[worst]) if names else 0.0
    holds = largest <= tolerances.residual and cone <= ROUNDING
    return ForceCheck(holds, largest, names[worst] if names else "", cone)


def proof_loads(problem: Problem) -> ProofLoads:
    """Return the loads of a problem; non-finite ones stay non-finite, and fail every check."""
    names = sorted(problem.bricks)
    half = np.array([problem.bricks[name].brick.shape.bounding_radius for name in names])
    return ProofLoads(_wrenches(names, problem.loads), half, names)


def check_motion(
    problem: Problem, motion: Motion, tolerances: Tolerances, known: ProofCones | None = None
) -> MotionCheck:
    """Check whether the loads gain power by `motion` without resistance; `known` are the problem's cones.

    The power that a contact takes is a convex function of the place, so it is greatest at a corner of a polygon around
    the contact.
    """
    names = sorted(problem.bricks)
    velocity = velocity_rows(names, motion)
    if problem.is_round and velocity is not None:
        problem = closely_surrounded(problem, motion)
    cones = known if known and not problem.is_round else proof_cones(problem, around=True)
    if cones is None or velocity is None or not _are_borne(problem, [0.0] * len(problem.ties)):
        return MOTION_FAILS
    problem = problem.drawn(tensions_against(problem, motion))
    opening, sliding = _slips(cones, velocity)
    excess = np.maximum(cones.laws.shortfall(opening, sliding), 0.0)
    violation = float(_ratio(excess, _speeds(cones, velocity)).max(initial=0.0))
    loads = _wrenches(names, problem.loads)
    press = _weight_on(problem, motion.velocity.keys()) if excess.any() else 0.0
    cost = float(cones.laws.support(opening, sliding, press).sum())
    power = float((loads * velocity[:-1]).sum()) - cost
    scale = float(_size(loads[:, :3]) @ _size(velocity[:-1, :3]) + _size(loads[:, 3:]) @ _size(velocity[:-1, 3:]))
    gain = power / scale if 0.0 < scale < inf else -inf
    holds = power > 0.0 and gain >= tolerances.gain and violation <= tolerances.violation
    return MotionCheck(holds, gain, violation)


def tensions_against(problem: Problem, motion: Motion) -> list[float]:
    """Return by tie the tension above the least one that takes most power from a motion [N].

    The power is linear in the tension, so a motion that gains with it gains with every admissible tension.
    """
    return [tie.more if power(tie.pulls, motion) < 0.0 else 0.0 for tie in problem.ties]


def _are_borne(problem: Problem, more: Sequence[float]) -> bool:
    """Return whether there is an admissible tension for each tie, above its least one [N]."""
    if len(more) != len(problem.ties):
        return False
    known = [name in problem.bricks for tie in problem.ties for name in tie.pulls]
    return all(known) and all(0.0 <= each <= tie.more < inf for each, tie in zip(more, problem.ties, strict=True))


def least_separating_speed(problem: Problem, motion: Motion) -> float:
    """Return the least opening speed of all contacts in a motion, relative to the speed at the contact.

    The shortening of a tie counts likewise. The result is negative if a contact closes. If it is positive, all forces
    have positive power along the motion: only zero forces balance each other. This does not hold for laws that are not
    cones, so the result for these is minus infinity.
    """
    names = sorted(problem.bricks)
    velocity = velocity_rows(names, motion)
    if problem.is_round and velocity is not None:
        problem = closely_surrounded(problem, motion)
    cones = proof_cones(problem, around=True)
    if cones is None or velocity is None or not all(law.is_cone for _, law in cones.laws.of_kinds):
        return -inf
    short = cones.laws.shortfall(*_slips(cones, velocity))
    of_ties = min((_shortening(tie, motion) for tie in problem.ties), default=inf)
    return min(of_ties, float(-_ratio(short, _speeds(cones, velocity)).max(initial=-inf)))


def _shortening(tie: UnknownTension, motion: Motion) -> float:
    """Return the speed at which a tie gets shorter, relative to the speeds of its bricks where it pulls them."""
    moving = {name: motion.velocity[name] for name in tie.pulls if name in motion.velocity}
    speed = sum(
        norm(tie.pulls[name].force_W) * norm(v) + norm(tie.pulls[name].torque_W) * norm(w)
        for name, (v, w) in moving.items()
    )
    return power(tie.pulls, motion) / speed if speed > 0.0 else 0.0


MOST_SPLITS = 16  # of a span of an arc
MOST_SPANS = 16_384  # of all arcs of a contact
FAILS = 1e-9  # share of the speed: a motion that a point of the contact itself resists by more is no proof
SHUT = 1e-13  # share of the speed: a smaller violation is rounding


def closely_surrounded(problem: Problem, motion: Motion) -> Problem:
    """Return the problem with polygons around its round contacts that are as close as a motion needs.

    Only where a corner outside the contact would resist the motion, a span of an arc is split.
    """
    contacts = [
        contact if contact.patch is None else replace(contact, points_W=_cover(contact, contact.patch, problem, motion))
        for contact in problem.contacts
    ]
    return replace(problem, contacts=[replace(contact, patch=None, gaps=()) for contact in contacts])


def _cover(contact: Contact, patch: RoundPatch, problem: Problem, motion: Motion) -> tuple[Vec3, ...]:
    """Return corners of a polygon around a patch with as few as possible that resist a motion."""
    corners = list(patch.placed(patch.flat))
    for disc, spans in zip(patch.discs, patch.spans, strict=True):
        waiting = np.array(spans).reshape(-1, 2)
        for split in range(MOST_SPLITS):
            middle, half = waiting.mean(axis=1), 0.5 * (waiting[:, 1] - waiting[:, 0])
            over = _on_circle(patch, disc, middle, disc.radius / np.cos(half))
            values, speed = contact_shortfall(contact, over, problem, motion)
            resists = values > SHUT * speed
            on_arc = _on_circle(patch, disc, middle[resists], np.full(int(resists.sum()), disc.radius))
            truly = contact_shortfall(contact, on_arc, problem, motion)[0].max(initial=0.0) > FAILS * speed
            if truly or split == MOST_SPLITS - 1 or 2 * resists.sum() > MOST_SPANS:
                resists[:] = False
            done = waiting[~resists]
            ends = _on_circle(patch, disc, done.ravel(), np.full(2 * len(done), disc.radius))
            corners += map(tuple, [*ends.tolist(), *over[~resists].tolist()])
            rest, at = waiting[resists], middle[resists]
            waiting = np.concatenate([np.column_stack([rest[:, 0], at]), np.column_stack([at, rest[:, 1]])])
            if not len(waiting):
                break
    return tuple(corners)


def _on_circle(patch: RoundPatch, disc: Disc, angles: Array, radii: Array) -> Array:
    """Return points at angles of a disc and at distances from its centre (n, 3) [m]."""
    x, y = disc.x + radii * np.cos(angles), disc.y + radii * np.sin(angles)
    points: Array = np.array(patch.origin_W) + np.outer(x, patch.axes_W[0]) + np.outer(y, patch.axes_W[1])
    return points


def contact_shortfall(contact: Contact, points: Array, problem: Problem, motion: Motion) -> tuple[Array, float]:
    """Return by how much the slip at points of a contact opens it too slowly (n,), and the largest speed [m/s]."""
    slip, speed = np.zeros_like(points), 0.0
    for body, sign in ((contact.upper, 1.0), (contact.lower, -1.0)):
        if body in motion.velocity:
            velocity, spin = (np.array(part) for part in motion.velocity[body])
            arms = points - np.array(problem.bricks[body].pose.position_W)
            slip += sign * (velocity + cross_rows(np.tile(spin, (len(points), 1)), arms))
            speed += float(np.linalg.norm(velocity) + np.linalg.norm(spin) * _size(arms).max(initial=0.0))
    normal = np.array(contact.normals_W[0])
    opening = slip @ normal
    return np.asarray(contact.law.shortfall(opening, _size(slip - np.outer(opening, normal)))), speed


def greatest_sum(problem: Problem, weights: Array, motion: Motion, known: ProofCones | None = None) -> float:
    """Return an upper bound, proven by a motion, of a sum of weighted normal forces that balance a problem [N].

    `weights` (n,) are those of the forces by contact, point and normal. Balanced forces take as much power from any
    motion as the loads give. So the sum is at most the power that lifts the loads, and what forces can gain where the
    contacts open more slowly than their weights. Returns inf for a motion that proves no bound.
    """
    cones, velocity = known or proof_cones(problem), velocity_rows(sorted(problem.bricks), motion)
    if cones is None or velocity is None or weights.shape != (len(cones.normals),) or not np.isfinite(weights).all():
        return inf
    return greatest_pressed(cones, proof_loads(problem), weights, velocity)


def greatest_pressed(cones: ProofCones, loads: ProofLoads, weights: Array, velocity: Array) -> float:
    """Return the bound of `greatest_sum` by velocities and spins (bricks + 1, 6), zero in the last row [m/s]."""
    opening, sliding = _slips(cones, velocity)
    gained = float(cones.laws.support(opening - weights, sliding, inf).sum())
    bound = gained - float((loads.wrenches * velocity[:-1]).sum())
    return bound if isfinite(bound) else inf


def shortfalls(cones: ProofCones, weights: Array, motion: Motion) -> Array:
    """Return by cone how much a motion opens it more slowly than a bound of `greatest_sum` requires [m/s]."""
    velocity = velocity_rows(cones.names, motion)
    return np.full(len(weights), inf) if velocity is None else shortfalls_of(cones, weights, velocity)


def shortfalls_of(cones: ProofCones, weights: Array, velocity: Array) -> Array:
    """Return the same by velocities and spins (bricks + 1, 6), zero in the last row."""
    opening, sliding = _slips(cones, velocity)
    return cones.laws.shortfall(opening - weights, sliding)


def motion_plus(motion: Motion, rate: float, other: Motion) -> Motion:
    """Return a motion plus another one at a rate."""
    still = (ZERO, ZERO)
    pairs = [(name, each, other.velocity.get(name, still)) for name, each in motion.velocity.items()]
    return Motion({name: (add_scaled(v, rate, u), add_scaled(w, rate, r)) for name, (v, w), (u, r) in pairs})


def power_of_joints(problem: Problem, motion: Motion) -> tuple[float, ...]:
    """Return by contact the greatest power that its bounded forces take from a motion [W]; NaN if it is invalid."""
    names = sorted(problem.bricks)
    cones, velocity = proof_cones(problem), velocity_rows(names, motion)
    if cones is None or velocity is None:
        return (nan,) * len(problem.contacts)
    of_points = iter(cones.laws.support(*_slips(cones, velocity), 0.0).tolist())
    sizes = [len(contact.points_W) * len(contact.normals_W) for contact in problem.contacts]
    return tuple(sum(islice(of_points, size)) for size in sizes)


def power(loads: Mapping[BodyId, Wrench], motion: Motion) -> float:
    """Return the power of loads along a motion [W]."""
    loaded = [(name, *motion.velocity[name]) for name in sorted(motion.velocity) if name in loads]
    return sum(dot(loads[name].force_W, v) + dot(loads[name].torque_W, w) for name, v, w in loaded)


def proof_cones(problem: Problem, around: bool = False) -> ProofCones | None:
    """Return the places of forces; None if a number of the problem is NaN, or a normal is not of unit length.

    The forces of patches with round borders are at the corners of their inner polygons, or of those `around` them.
    """
    names = sorted(problem.bricks)
    index = {name: i for i, name in enumerate(names)}
    points_W, normals_W, count = contact_rows(problem.contacts, around)
    laws = PointLaws.of([contact.law for contact in problem.contacts], count)
    finite = np.isfinite(points_W).all() and np.isfinite(normals_W).all()
    if not (finite and laws.are_sound() and (np.abs(_size(normals_W) - 1.0) <= UNIT).all()):
        return None
    fixed = len(names)
    pairs = np.array([(index.get(c.lower, fixed), index.get(c.upper, fixed)) for c in problem.contacts], dtype=np.int64)
    lower, upper = np.repeat(pairs.reshape(-1, 2), count, axis=0).T
    centres = np.array([problem.bricks[name].pose.position_W for name in names] + [ZERO])
    arms = (points_W - centres[lower], points_W - centres[upper])
    return ProofCones(names, (lower, upper), arms, normals_W, laws)


def contact_rows(contacts: Sequence[Contact], around: bool = False) -> tuple[Array, Array, Indices]:
    """Return the points and the normals (n, 3) by contact, point and normal, and the number of rows of each contact."""
    places = [contact.around_W if around else contact.points_W for contact in contacts]
    points = np.array([len(place) for place in places], dtype=np.int64)
    normals = np.array([len(contact.normals_W) for contact in contacts], dtype=np.int64)
    points_W = np.array([point for place in places for point in place], dtype=float).reshape(-1, 3)
    normals_W = np.array([normal for contact in contacts for normal in contact.normals_W], dtype=float).reshape(-1, 3)
    count = points * normals
    which = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    own = np.repeat(np.cumsum(normals) - normals, count) + which % np.repeat(normals, count)
    return np.repeat(points_W, np.repeat(normals, points), axis=0), normals_W[own], count


def _pressed(problem: Problem, forces: Forces) -> Array | None:
    """Return (n, 3) the force of each cone; None if there is not exactly one finite force for each."""
    if len(forces.of_contacts) != len(problem.contacts):
        return None
    flat: list[Vec3] = []
    for contact, by_point in zip(problem.contacts, forces.of_contacts, strict=True):
        if len(by_point) != len(contact.points_W):
            return None
        for by_normal in by_point:
            if len(by_normal) != len(contact.normals_W):
                return None
            flat += by_normal
    return _finite(flat, 3)


def velocity_rows(names: Sequence[BodyId], motion: Motion) -> Array | None:
    """Return (bricks + 1, 6) velocity and spin, zero in the last row; None if not finite or of an unknown body."""
    if not set(motion.velocity) <= set(names):
        return None
    still = (ZERO, ZERO)
    rows = [(*velocity, *spin) for velocity, spin in (motion.velocity.get(name, still) for name in names)]
    return _finite([*rows, (0.0,) * 6], 6)


def _finite(rows: Sequence[Sequence[float]], width: int) -> Array | None:
    if any(len(row) != width for row in rows):
        return None
    array = np.array(rows, dtype=float).reshape(-1, width)
    return array if np.isfinite(array).all() else None


def _cone_violation(cones: ProofCones, pressed: Array, carried: Array) -> float:
    """Return the largest violation of a law, relative to its force and to the load of the lighter brick."""
    normal = np.einsum("ij,ij->i", cones.normals, pressed)
    tangential = _size(pressed - normal[:, None] * cones.normals)
    outside = cones.laws.violation(normal, tangential)
    return float(_ratio(outside, _size(pressed) + np.where(carried < inf, carried, 0.0)).max(initial=0.0))


def _slips(cones: ProofCones, velocity: Array) -> tuple[Array, Array]:
    """Return the opening and sliding speed of each contact [m/s]."""
    (lower, upper), (lower_arms, upper_arms) = cones.bodies, cones.arms
    below, above = velocity[lower], velocity[upper]
    slip = above[:, :3] + cross_rows(above[:, 3:], upper_arms) - below[:, :3] - cross_rows(below[:, 3:], lower_arms)
    opening = np.einsum("ij,ij->i", cones.normals, slip)
    return opening, _size(slip - opening[:, None] * cones.normals)


def _speeds(cones: ProofCones, velocity: Array) -> Array:
    """Return the sum of the greatest speeds that both bodies of each contact can have there [m/s]."""
    speeds = np.zeros(len(cones.normals))
    for body, arms in zip(cones.bodies, cones.arms, strict=True):
        moved = velocity[body]
        speeds += _size(moved[:, :3]) + _size(moved[:, 3:]) * _size(arms)
    return speeds


def _weight_on(problem: Problem, moving: Collection[BodyId]) -> float:
    """Return the loads on moving bricks and on all that they carry [N], an upper bound of their normal forces."""
    above: dict[BodyId, list[BodyId]] = {}
    for contact in problem.contacts:
        above.setdefault(contact.lower, []).append(contact.upper)
    carried, waiting = set(moving), sorted(moving)
    while waiting:
        for upper in above.get(waiting.pop(), ()):
            if upper in problem.bricks and upper not in carried:
                carried.add(upper)
                waiting.append(upper)
    total = 0.0
    for name in sorted(carried):
        load = problem.loads.get(name, UNLOADED)
        arm = problem.bricks[name].brick.shape.bounding_radius
        total += hypot(*load.force_W) + hypot(*load.torque_W) / arm
    return total if isfinite(total) else inf


def _wrenches(names: Sequence[BodyId], loads: Mapping[BodyId, Wrench]) -> Array:
    """Return (bricks, 6) forces and torques; non-finite loads stay non-finite, and fail every check."""
    rows = [loads.get(name, UNLOADED) for name in names]
    return np.array([(*row.force_W, *row.torque_W) for row in rows], dtype=float).reshape(-1, 6)


def _add(wrench: Array, body: Indices, rows: Array) -> None:
    """Add rows to those of `body`."""
    places = (body[:, None] * 6 + np.arange(6)).ravel()
    wrench += np.bincount(places, rows.ravel(), minlength=wrench.size).reshape(wrench.shape)


def _size(rows: Array) -> Array:
    size: Array = np.sqrt(np.einsum("ij,ij->i", rows, rows))
    return size


def _ratio(part: Array, whole: Array) -> Array:
    """Return `part / whole`; 0 / 0 is 0, and NaN becomes infinity."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(part == 0.0, 0.0, part / whole)
    return np.where(np.isnan(ratio), inf, ratio)
