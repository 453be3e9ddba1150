"""The load factor of a structure: how often it bears its loads before the first mechanism, with a proof on both sides.

Limit analysis: forces within the strength of all contacts prove a factor from below, and a motion against which the
loads do more work than the contacts can take proves one from above. The theorem covers joints that keep their force
when they yield. A dry structure bears any multiple of its own weight or none, since friction grows with the weight.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import Final, TypeVar

import numpy as np

from stability.contact_law import ContactLaw, OtherLawError
from stability.geometry.vectors import add, add_scaled, dot, norm, scale
from stability.loads import LoadCourse
from stability.model import BodyId
from stability.problem import ZERO, Forces, Motion, Problem, Stability, Tolerances, Wrench, admit_problem, rounded
from stability.process_settings import one_thread
from stability.statics.assembly import Assembly
from stability.statics.conic_program import clarabel_solve, quick_solve
from stability.statics.elastic_joints import elastic_factor, without_brittle
from stability.statics.equilibrium import (
    ACCURACIES,
    ALIKE,
    STILL,
    balance,
    exact_points,
    proven_forces,
    proven_motion,
    separating_motion,
    without_bounded_forces,
)
from stability.statics.load_factor import central_forces, yielding
from stability.statics.proof import ProofCones, check_forces, check_motion, power_of_joints, proof_cones
from stability.statics.stud_program import HalvedJoints, StudPoint, stud_points
from stability.statics.wrench_matrix import wrench_matrix

Proof = TypeVar("Proof", Forces, Motion)

SHARES: Final = (
    1e-9,
    1e-8,
    1e-7,
    1e-6,
    1e-5,
)  # relative distances from the solver's factor, tried in turn until proven
GIVES_WAY: Final = 1e-3  # of the power of all joints: a joint that takes less hardly yields
HELD: Final = 1e6  # times the weight: loads that are borne up to there are borne at any size
MOST_SHARE: Final = 1e6  # of the strength: a mechanism that is not held by so much counts as not held at all
NONE: Final = 1e-9  # a motion that falls with this share of the loads is held by no joint


@dataclass(frozen=True, slots=True)
class YieldingJoint:
    """Joint that yields in the first mechanism."""

    lower: BodyId
    upper: BodyId
    share: float  # of the power that all joints take


@dataclass(frozen=True, slots=True)
class LoadFactor:
    """Factor on the growing loads up to which contact forces balance a structure."""

    factor: float  # proven by `forces`; inf if contacts bear any factor, 0 if they bear none
    too_large: float  # proven by `motion`; inf if there is none
    forces: Forces | None  # that balance the loads at `factor`; for inf, at a factor of 1
    motion: Motion | None  # the first mechanism
    joints: tuple[YieldingJoint, ...] = ()  # that yield in this mechanism, the one that takes most first


@one_thread()
def load_factor(
    problem: Problem,
    growing: Mapping[BodyId, Wrench] | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> LoadFactor | None:
    """Return the load factor of a problem; None if none is proven.

    All loads grow, or `growing` loads in addition to those of the problem. Both bounds differ by a share of 2e-5 at
    most, and usually of 2e-9. Self-stress is not excluded. With brittle joints, both are further apart: the factor is
    the larger one of an elastic calculation and of the structure without its brittle joints, and has no forces.
    """
    admit_problem(problem)
    if problem.is_brittle:
        return _of_brittle(problem, growing, tolerances)
    tolerances = rounded(problem, tolerances)
    if growing is None and problem.has_joints and not problem.ties:
        studded = _studded_factor(problem, tolerances)
        if studded is not None:
            return studded
    grown = GrownLoads(problem, growing)
    now = balance(problem, tolerances)
    if now.forces is None and problem.is_tied:  # ties may be too tight without the loads
        now = balance(grown.at(1.0), tolerances)
    if growing is not None and now.forces is None:
        return None if now.motion is None else LoadFactor(0.0, 0.0, None, now.motion)
    unlimited = balance(without_bounded_forces(grown.alone), tolerances)
    if unlimited.forces is not None:
        return LoadFactor(inf, inf, now.forces, None)
    if not problem.has_joints and growing is None:
        return None if now.motion is None else LoadFactor(0.0, 0.0, None, now.motion)
    bracket = bracket_of(grown, tolerances)
    if bracket.at_once is not None:
        return LoadFactor(0.0, NONE, None, bracket.at_once)
    below, above = bracket.below, bracket.above
    if below is None or above is None:
        held = above is None and not problem.has_joints and _bears_much_more(grown, tolerances)
        return LoadFactor(inf, inf, now.forces, None) if held else None
    return _bounded(grown, below, above)


def _bears_much_more(grown: "GrownLoads", tolerances: Tolerances) -> bool:
    """Return whether dry bricks are proven to bear growing loads of a million times their weight.

    Loads alone leave bricks without any force, for which rounding decides.
    """
    weight, load = (
        sum(norm(each.force_W) for each in loads.values()) for loads in (grown.problem.loads, grown.alone.loads)
    )
    return load > 0.0 and forces_at(grown, HELD * weight / load, None, tolerances) is not None


def _of_brittle(problem: Problem, growing: Mapping[BodyId, Wrench] | None, tolerances: Tolerances) -> LoadFactor | None:
    """Return the load factor of a structure with brittle joints. Raises OtherLawError for a load that grows alone."""
    if growing is not None:
        raise OtherLawError("the load factor of a load that grows alone is not computed for brittle joints")
    ductile = replace(problem, contacts=tuple(replace(contact, brittle=None) for contact in problem.contacts))
    whole, rest = load_factor(ductile, tolerances=tolerances), without_brittle(problem)
    if whole is None:
        return None
    # Without brittle joints, bricks that only wedge each other are not ensured to stand.
    without = load_factor(rest, tolerances=tolerances) if separating_motion(rest) is not None else None
    least = 0.0 if without is None else without.factor
    if least == inf or whole.factor == 0.0:
        return whole
    return replace(whole, factor=min(whole.factor, max(least, elastic_factor(problem))), forces=None)


def _studded_factor(problem: Problem, tolerances: Tolerances) -> LoadFactor | None:
    """Return the load factor by the small programs of studded bricks; None unless they prove both bounds."""
    grown, cones = GrownLoads(problem, None), proof_cones(problem)
    above: tuple[float, Motion] | None = None
    for point in stud_points(problem):
        if not NONE < point.share < inf:
            continue
        above = above or _fall_by_studs(grown, cones, point, tolerances)
        if above is None:
            continue  # its forces may be far from the load factor
        factor = 1.0 / point.share * (1.0 - SHARES[0])
        forces = point.forces(factor)
        if check_forces(grown.at(factor), forces, tolerances, cones).holds:
            return _bounded(grown, (factor, forces), above)
    return _by_halves(problem, tolerances)


def _fall_by_studs(
    grown: "GrownLoads", cones: ProofCones | None, point: StudPoint, tolerances: Tolerances
) -> tuple[float, Motion] | None:
    """Return the first mechanism of a point, proven with loads close to its load factor."""

    def motion_at(factor: float, motion: Motion) -> Motion | None:
        return motion if check_motion(grown.at(factor), motion, tolerances, cones).holds else None

    near = (
        _closest(1.0 / point.share, 1.0, partial(motion_at, motion=motion))
        for motion in _first_mechanisms(grown.problem, point)
    )
    return next((found for found in near if found is not None), None)


def _first_mechanisms(problem: Problem, point: StudPoint) -> Iterator[Motion]:
    """Yield motions, unproven, with the load factor of a point."""
    for each in exact_points(problem, point):
        if each is point or each.share >= (1.0 - ALIKE) * min(point.share, MOST_SHARE):
            yield each.motion()


def _by_halves(problem: Problem, tolerances: Tolerances) -> LoadFactor | None:
    halved = HalvedJoints.of(problem)
    if halved is None:
        return None
    system = wrench_matrix(halved.problem, whole=True, any_law=True)
    point = yielding(system, system.loads, None, ACCURACIES[0], quick_solve)
    if isinstance(point, str) or not (np.isfinite(point.columns).all() and point.share > NONE):
        return None
    grown, small, falling = GrownLoads(problem, None), GrownLoads(halved.problem, None), system.motion(point.columns)

    def forces_at(factor: float) -> Forces | None:
        at = small.at(factor)  # in the units of its rows, which are those of the loads, the forces do not change
        forces = proven_forces(at, wrench_matrix(at, whole=True, any_law=True), point.rows, tolerances)
        forces = None if forces is None else halved.spread(forces)
        return forces if forces and check_forces(grown.at(factor), forces, tolerances).holds else None

    above = _closest(1.0 / point.share, 1.0, partial(motion_at, grown, motion=falling, tolerances=tolerances))
    below = None if above is None else _closest(1.0 / point.share, -1.0, forces_at)
    return None if below is None or above is None else _bounded(grown, below, above)


def _bounded(grown: "GrownLoads", below: tuple[float, Forces], above: tuple[float, Motion]) -> LoadFactor:
    """Return the load factor with its proofs on both sides."""
    return LoadFactor(below[0], above[0], below[1], above[1], tuple(_yielding_joints(grown.at(above[0]), above[1])))


def borne_until(assembly: Assembly, course: LoadCourse, now: float) -> float:
    """Return the time until which bricks, which stand under the loads of now, stand under a course of loads [s].

    It is the time at which the loads are proven to be too large; inf if the bricks stand to its end and after.
    """
    if now >= course.ends or not assembly.bricks:
        return inf
    ends = assembly.with_loads(course.last)
    if ends.verdict().stability is Stability.STABLE:
        return inf
    problem, beyond = assembly.problem(), ends.problem().applied
    found = load_factor(problem, {name: load.minus(problem.applied.get(name)) for name, load in beyond.items()})
    return now if found is None else now + min(1.0, found.too_large) * (course.ends - now)


def used_of_joints(problem: Problem, forces: Forces) -> dict[tuple[BodyId, BodyId], float]:
    """Return the share of its strength that each joint uses, by lower and upper body.

    It is the least factor on the strength of the joint with which it bears its part of the forces.
    """
    used: dict[tuple[BodyId, BodyId], float] = {}
    for contact, by_point in zip(problem.contacts, forces.of_contacts, strict=True):
        if contact.law.is_cone:
            continue
        (normal_W,) = contact.normals_W
        pair = contact.lower, contact.upper
        for by_normal in by_point:
            for force_W in by_normal:
                normal = dot(force_W, normal_W)
                tangential = norm(add_scaled(force_W, -normal, normal_W))
                used[pair] = max(used.get(pair, 0.0), _used(contact.law, normal, tangential))
    return used


def _used(law: ContactLaw, normal: float, tangential: float) -> float:
    """Return the least factor on the bounds of a law, its friction aside, with which it bears a force."""
    parts = [(-normal, -float(law.least_normal))]
    parts += [(tangential - float(slope) * normal, float(height)) for height, slope in law.borders]
    return max((force / bound for force, bound in parts if force > 0.0 < bound), default=0.0)


@dataclass(frozen=True, slots=True)
class Bracket:
    """Proofs on both sides of a load factor; each is None if it was not found."""

    below: tuple[float, Forces] | None = None
    above: tuple[float, Motion] | None = None
    at_once: Motion | None = None  # proven to fall at any factor


def bracket_of(grown: "GrownLoads", tolerances: Tolerances) -> Bracket:
    """Return the proofs closest to the load factor that are found."""
    below: tuple[float, Forces] | None = None
    above: tuple[float, Motion] | None = None
    carried: Mapping[BodyId, float] | None = None
    for accuracy in ACCURACIES:
        system = wrench_matrix(grown.at(1.0), whole=True, any_law=True, carried=carried)
        constant = None if grown.constant is None else system.wrench_of(grown.constant)
        point = yielding(system, system.wrench_of(grown.alone.loads), constant, accuracy, clarabel_solve)
        if isinstance(point, str) or not (np.isfinite(point.rows).all() and np.isfinite(point.columns).all()):
            continue
        falling = system.motion(point.columns)
        at_once = motion_at(grown, NONE, falling, tolerances)
        if at_once is not None:
            return Bracket(at_once=at_once)
        factor = 1.0 / point.share if point.share > 0.0 else inf
        if factor < inf:
            below = below or _closest(factor, -1.0, partial(forces_at, grown, carried=carried, tolerances=tolerances))
            above = above or _closest(factor, 1.0, partial(motion_at, grown, motion=falling, tolerances=tolerances))
        if below is not None and above is not None:
            break
        carried = carried or system.greatest_forces(point.rows)
    return Bracket(below, above)


@dataclass(frozen=True, slots=True)
class GrownLoads:
    """Problem whose loads grow."""

    problem: Problem
    growing: Mapping[BodyId, Wrench] | None  # in addition to the loads of the problem; None if these grow themselves

    @property
    def constant(self) -> Mapping[BodyId, Wrench] | None:
        """Return the loads that do not grow; None if there are none."""
        return None if self.growing is None else self.problem.loads

    @property
    def alone(self) -> Problem:
        """Return the problem with the growing loads only."""
        return self.problem if self.growing is None else replace(self.problem, loads=self.growing)

    def at(self, factor: float) -> Problem:
        """Return the problem with the growing loads times a factor."""
        loads = {name: _times(factor, load) for name, load in self.alone.loads.items()}
        for name, load in (self.constant or {}).items():
            more = loads.get(name, Wrench(ZERO))
            loads[name] = Wrench(add(load.force_W, more.force_W), add(load.torque_W, more.torque_W))
        return replace(self.problem, loads=loads)


def _times(factor: float, load: Wrench) -> Wrench:
    return Wrench(scale(factor, load.force_W), scale(factor, load.torque_W))


def _closest(factor: float, side: float, proof: Callable[[float], Proof | None]) -> tuple[float, Proof] | None:
    """Return the closest factor above another one, or below it for a `side` of -1, that has a proof, with the proof."""
    for share in SHARES:
        at = factor * (1.0 + side * share)
        proven = proof(at)
        if proven is not None:
            return at, proven
    return None


def forces_at(
    grown: GrownLoads, factor: float, carried: Mapping[BodyId, float] | None, tolerances: Tolerances
) -> Forces | None:
    """Return proven forces for loads at a factor."""
    problem = grown.at(factor)
    system = wrench_matrix(problem, any_law=True, carried=carried)
    rows = central_forces(system, system.loads, ACCURACIES[0], clarabel_solve)
    return None if isinstance(rows, str) else proven_forces(problem, system, rows, tolerances)


def motion_at(grown: GrownLoads, factor: float, motion: Motion, tolerances: Tolerances) -> Motion | None:
    """Return a motion near the given one that is proven to fall with loads at a factor."""
    problem = grown.at(factor)
    system = wrench_matrix(problem, whole=True, any_law=True)
    return proven_motion(problem, system, system.columns_of(motion), tolerances, STILL)


def _yielding_joints(problem: Problem, motion: Motion) -> Iterator[YieldingJoint]:
    """Yield the joints that take power from a motion, the one that takes most first."""
    powers: dict[tuple[BodyId, BodyId], float] = {}
    for contact, power in zip(problem.contacts, power_of_joints(problem, motion), strict=True):
        pair = contact.lower, contact.upper
        powers[pair] = powers.get(pair, 0.0) + power
    total = sum(powers.values())
    for (lower, upper), power in sorted(powers.items(), key=lambda item: (-item[1], item[0])):
        if power > GIVES_WAY * total:
            yield YieldingJoint(lower, upper, power / total)
