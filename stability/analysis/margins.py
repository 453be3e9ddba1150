"""Margins of a stable assembly: friction, acceleration, placement, counterweight. Each solves a program on request."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from math import degrees, inf, isfinite

import numpy as np

from stability.analysis.acceleration_cut import least_prestress
from stability.analysis.acceleration_margin import AccelerationMargin, acceleration, tilt
from stability.analysis.placement_margin import PlacementMargin, placement
from stability.analysis.weakest import Weakest, weakest, weakest_at
from stability.geometry.vectors import add, admit_in_range, listed
from stability.model import GROUND, BodyId, Vec3
from stability.notebook import Display, Displayed, display_of
from stability.problem import (
    ZERO,
    ConeForces,
    Contact,
    Forces,
    Motion,
    PlacementLimit,
    Problem,
    Tolerances,
    Wrench,
    admit_problem,
    rounded,
)
from stability.process_settings import one_thread
from stability.statics.assembly import STRONGEST, WEAKEST, admit_name
from stability.statics.conic_program import clarabel_solve, solve
from stability.statics.equilibrium import balance, proven_forces, proven_motion
from stability.statics.proof import check_forces
from stability.statics.wrench_matrix import wrench_matrix

# The least factor on all friction coefficients for which contact forces balance the loads.
#
# Less friction means smaller cones, so an assembly that stands with a factor stands with any larger one. Each step
# computes for one factor k the least prestress s (see `least_prestress`); it is positive if forces within the cones
# cannot balance the loads. By the envelope theorem ds/dk is the power of tangential forces on slips, over k. So each
# step gives a verdict with its proof, forces or a motion, and by Newton's method the next factor, a little beyond the
# root, so that proofs close in on the root from both sides.


MOST_STEPS = 60
# a coefficient that no material has; an assembly that needs more is taken to stand with no friction coefficient
MOST_FRICTION = 1e4
WIDER = 4.0  # factor on the distance of the next step from the root after a step without proof


@dataclass(frozen=True, slots=True)
class FrictionMargin:
    """Least friction for which contact forces can balance the loads."""

    factor: float  # on all coefficients, proven by `forces`; inf if no friction is enough
    too_little: (
        float  # a factor that `motion` proves too small; equal to `factor` within the tolerance; 0 if there is none
    )
    coefficient: float  # `factor` times the largest coefficient of the problem
    forces: Forces | None
    motion: Motion | None


@dataclass(frozen=True, slots=True)
class _Step:
    """Proof at one factor."""

    forces: Forces | None
    motion: Motion | None
    guess: float  # estimate of the least factor


@one_thread()
def least_friction(
    problem: Problem,
    tolerance: float = 1e-7,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> FrictionMargin:
    """Return the least factor on all friction coefficients that still allows equilibrium, to a relative `tolerance`.

    Only equilibrium is required; the forces may include self-stress. Raises OtherLawError for bricks with joints, whose
    strength does not follow from friction alone.
    """
    problem.require_dry("the margin of friction")
    smooth = balance(_with_friction(problem, 0.0), tolerances)
    if smooth.forces is not None:
        return FrictionMargin(0.0, 0.0, 0.0, smooth.forces, None)
    largest = max((contact.law.friction for contact in problem.contacts), default=0.0)
    too_little, enough = _Step(None, smooth.motion, 0.0), _Step(None, None, inf)
    low, high, factor, aside = 0.0, inf, 1.0, tolerance / 3.0
    for _ in range(MOST_STEPS if largest > 0.0 else 0):
        step = _asked(problem, factor, tolerances)
        if step.forces is not None:
            high, enough = factor, step
        elif step.motion is not None:
            low, too_little = factor, step
        else:
            aside *= WIDER
        closed = high < inf and high - low <= max(tolerance, 2.0 * aside) * high
        if closed or (high == inf and factor * largest >= MOST_FRICTION):
            break
        factor = min(_next(step, low, high, aside), MOST_FRICTION / largest)
    return FrictionMargin(high, low, largest * high if high < inf else inf, enough.forces, too_little.motion)


def _next(step: _Step, low: float, high: float, aside: float) -> float:
    """Return a factor slightly beyond the root of Newton's method, so that the other side is proven next.

    Without such a factor it is one between the bounds.
    """
    factor = step.guess * (1.0 + aside if step.forces is None else 1.0 - aside)
    if isfinite(factor) and low < factor < high:
        return factor
    return 0.5 * (low + high) if high < inf else WIDER * max(low, factor)


def _with_friction(problem: Problem, factor: float) -> Problem:
    laws = [contact.law.with_friction(factor * contact.law.friction) for contact in problem.contacts]
    contacts = [replace(contact, law=law) for contact, law in zip(problem.contacts, laws, strict=True)]
    return replace(problem, contacts=contacts)


def _asked(problem: Problem, factor: float, tolerances: Tolerances) -> _Step:
    """Return the proof at one factor, with the next estimate of the least factor."""
    scaled = _with_friction(problem, factor)
    system = wrench_matrix(scaled)
    prestress = least_prestress(system)
    guess = factor * (1.0 - prestress.least / prestress.sliding) if prestress.sliding < 0.0 else inf
    forces = proven_forces(scaled, system, prestress.rows, tolerances) if prestress.least <= 0.0 else None
    motion = None if forces else proven_motion(scaled, system, prestress.columns, tolerances)
    return _Step(forces, motion, guess)


# Margins of an assembly. Each needs a program of its own, so it is computed only on request.


__all__ = [
    "AccelerationMargin",
    "FrictionMargin",
    "Margins",
    "PlacementLimit",
    "PlacementMargin",
    "Weakest",
    "acceleration",
    "least_friction",
    "margins",
    "placement",
    "tilt",
    "weakest",
    "weakest_at",
]


@dataclass(frozen=True, slots=True)
class Margins(Displayed):
    """All margins of a standing assembly."""

    acceleration_g: float  # horizontal, in the worst direction, in units of g
    bearing: float  # of the worst direction, from x towards y [rad]
    tilt: float  # of the ground, in the worst direction [rad]
    friction: float  # the least coefficient between bricks that still allows equilibrium
    placement: float  # the placement error in plan of every brick that is certain to be survived [m]
    # the mechanism that opens first at that acceleration; None if the structure is held on all sides
    weakest: Weakest | None
    limits: tuple[PlacementLimit, ...] = ()  # the contacts that limit `placement` equally


@display_of.register
def _(found: Margins) -> Display:
    towards = f"{round(degrees(found.bearing)) % 360} deg"
    lines = [
        ("survives", f"a horizontal acceleration of {found.acceleration_g:.4g} g (worst direction: {towards})"),
        ("", f"a tilt of {degrees(found.tilt):.4g} deg"),
        ("", f"friction down to {found.friction:.4g}"),
        ("", f"a placement error of {round(1000.0 * found.placement, 6):.4g} mm of every brick"),
    ]
    if found.acceleration_g == inf:
        lines[:2] = [("survives", "any horizontal acceleration"), ("", "any tilt below 90 deg")]
    if found.placement == inf:
        lines[-1] = ("", "any placement error of every brick")
    if found.weakest is not None:
        lines.append(("weakest", f"{found.weakest.brick}; {found.weakest.gives_way}"))
    for limit in found.limits:
        ways = " or ".join(f"{degrees(bearing):.4g} deg" for bearing in limit.bearings)
        lines.append(("limited by", f"{limit.upper} on {limit.lower}, towards {ways}, for the placement error"))
    return Display("margins", lines)


def margins(
    problem: Problem,
    tolerance: float = 1e-6,
    gravity: float | None = None,
    planes: Collection[BodyId] = (GROUND,),
) -> Margins | None:
    """Return all margins; None if the problem is not proven to stand.

    See `acceleration`, `least_friction` and `placement`. Raises OtherLawError for bricks with joints, whose margin is
    `load_factor`.
    """
    admit_problem(problem)
    problem.require_dry("the computation of these margins")
    admit_in_range("the tolerance is", tolerance, 1e-15, 0.5, "write a fraction of the limit, from 1e-15 to 0.5")
    if gravity is not None:
        admit_in_range("the gravity is", gravity, WEAKEST, STRONGEST, "write a number greater than 0, in m/s2")
    planes = listed(planes, f"names of planes, such as ['{GROUND}']")
    for plane in planes:
        admit_name("a plane", plane)
    shaken = acceleration(problem, tolerance, gravity)
    if shaken is None:
        return None
    friction = least_friction(problem, tolerance).coefficient
    place = placement(problem, tolerance, planes)
    first = weakest_at(problem, shaken)
    return Margins(shaken.value, shaken.bearing, tilt(shaken.value), friction, place.value, first, limits=place.limits)


# The least additional weight on one brick with which a falling assembly stands.
#
# One conic program per brick maximises the power of the loads along a motion that no contact resists, with the upward
# speed of the brick limited to 1. This power is the weight: the duals of the program are forces that balance the loads
# and this weight on the brick, and with a smaller weight the motion still gains power. If the power is unbounded, no
# weight is enough.
#
# The solver's point is no proof. The returned weight has forces that arithmetic has checked, and a slightly smaller
# weight, within the requested accuracy, has a motion that falls.


ACCURACY = 1e-12  # requested accuracy of the solver
SHARES = (1e-8, 1e-6, 1e-4)  # relative increases of the least weight, tried in turn until forces are proven


@dataclass(frozen=True, slots=True)
class Counterweight:
    """Least weight at the centre of a brick with which contact forces balance the loads."""

    brick: BodyId
    weight: float  # [N] proven to be enough for balance
    too_little: float  # [N] proven to be too little; at most a share of 1e-4 below `weight`


@one_thread()
def counterweight(
    problem: Problem,
    brick: BodyId,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> Counterweight | None:
    """Return the least weight on a brick that balances an unbalanced problem; None if none is found.

    Only equilibrium is required; the forces may include self-stress. Raises LookupError for an unknown brick.
    """
    if brick not in problem.bricks:
        raise LookupError(f"there is no brick '{brick}'")
    from scipy.sparse import csc_matrix, vstack  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    system = wrench_matrix(problem, whole=True)
    unit = sum(-load.force_W[2] for load in problem.loads.values()) / max(1, len(problem.loads))  # [N] a typical weight
    pressing = system.wrench_of({brick: Wrench((0.0, 0.0, -unit))})
    program = system.rows.program(
        -system.loads,
        vstack([-system.matrix, csc_matrix(-pressing)], format="csc"),
        np.append(np.zeros(len(system.row_scale)), 1.0),
        positive=1,
    )
    point = solve(program, ACCURACY, clarabel_solve)
    if isinstance(point, str) or not np.isfinite(point.dual).all() or not point.dual[-1] > 0.0:
        return None
    least, rows = float(point.dual[-1]) * unit, point.dual[:-1]
    for share in SHARES:
        enough, too_little = (_with_weight(problem, brick, factor * least) for factor in (1.0 + share, 1.0 - share))
        heavier, lighter = wrench_matrix(enough), wrench_matrix(too_little, whole=True)
        # The units of rows and columns depend on the load capacities, so each system has its own.
        forces = proven_forces(enough, heavier, rows * system.row_scale / heavier.row_scale, tolerances)
        columns = lighter.columns_of(system.motion(point.x))
        if forces is not None and proven_motion(too_little, lighter, columns, tolerances) is not None:
            return Counterweight(brick, (1.0 + share) * least, (1.0 - share) * least)
    return None


@one_thread()
def least_counterweight(problem: Problem, bricks: Collection[BodyId]) -> Counterweight | None:
    """Return the least of the weights on these bricks that balance a problem, ties by name; None if no weight does."""
    weights = [weight for brick in sorted(bricks) if (weight := counterweight(problem, brick)) is not None]
    return min(weights, key=lambda each: (each.weight, each.brick), default=None)


def _with_weight(problem: Problem, brick: BodyId, weight: float) -> Problem:
    load = problem.loads.get(brick, Wrench(ZERO))
    heavier = replace(load, force_W=add(load.force_W, (0.0, 0.0, -weight)))
    return replace(problem, loads={**problem.loads, brick: heavier})


# Proves that rest is guaranteed. Balance with friction proves only that rest is possible.
#
# Let each brick be at rest, and let a be any acceleration that the laws of contact allow: no contact closes (a_n >= 0),
# a normal force acts only at a contact that does not open (f_n a_n = 0), and friction does not push along a slip (f_t .
# a_t <= 0). Then
#
# Let every brick be at rest, and a be any acceleration that the laws of contact allow: no contact closes (a_n >= 0), a
# normal force acts only where none opens (f_n a_n = 0), and friction does not push along a slip (f_t . a_t <= 0). Then
#
#     a' M a = a' g + sum f_n a_n + sum f_t . a_t <= a' g.
#
# If forces N >= 0 along the normals alone balance the loads g, then a' g = - sum N a_n <= 0, so that a' M a <= 0 and a
# = 0: nothing moves, whatever the friction is and whichever of the possible forces act. The same holds for a change of
# velocity by impulses. So such forces are a certificate, which `proof` checks by arithmetic as forces without friction.
#
# Forces at points with a gap are excluded as well: there the laws of contact hold only after the gap has closed.
#
# A contact point with several normals is an edge or corner on another, and a body leaves it along one of these normals:
# a_n >= 0 does not hold for all of them, so forces of such a contact are excluded.


@one_thread()
def guarantee(
    problem: Problem,
    known: Forces | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> Forces | None:
    """Return forces along normals alone that balance a problem, per contact with a single normal; None if none exist.

    `known` are forces that balance it with friction: often these act along the normals already.
    """
    tolerances = rounded(problem, tolerances)
    kept = [number for number, contact in enumerate(problem.contacts) if len(contact.normals_W) == 1]
    smooth = replace(problem, contacts=[_smooth(problem.contacts[number]) for number in kept])
    touching = without_gaps(smooth)
    if known is not None and len(known.of_contacts) == len(problem.contacts):
        same = Forces(tuple(_without(known.of_contacts[number], problem.contacts[number]) for number in kept))
        if check_forces(smooth, same, tolerances).holds:
            return same
    forces = balance(touching, tolerances).forces
    return forces if forces is None or touching is smooth else _at_all_points(forces, touching, smooth)


def without_gaps(problem: Problem) -> Problem:
    """Return the problem without the contact points that have a gap, or the problem itself if none has."""
    if not any(contact.gaps for contact in problem.contacts):
        return problem
    return replace(problem, contacts=[touching for c in problem.contacts if (touching := _touching(c)).points_W])


def _touching(contact: Contact) -> Contact:
    if not contact.gaps:
        return contact
    points = tuple(point for point, gap in zip(contact.points_W, contact.gaps, strict=True) if gap == 0.0)
    return replace(contact, points_W=points, gaps=())


def _without(forces: ConeForces, contact: Contact) -> ConeForces:
    """Return the forces of a contact, zero at points with a gap."""
    if not contact.gaps:
        return forces
    return tuple(
        of_point if gap == 0.0 else (ZERO,) * len(of_point) for of_point, gap in zip(forces, contact.gaps, strict=True)
    )


def _at_all_points(forces: Forces, touching: Problem, smooth: Problem) -> Forces:
    """Return forces at the points without a gap, and zero at the others."""
    of_pair: dict[tuple[BodyId, BodyId], Iterator[tuple[Vec3, ...]]] = {}
    for contact, at_points in zip(touching.contacts, forces.of_contacts, strict=True):
        pair = contact.lower, contact.upper
        of_pair[pair] = chain(of_pair.get(pair, ()), at_points)

    def of(contact: Contact) -> ConeForces:
        own = of_pair.get((contact.lower, contact.upper), iter(()))
        gaps = contact.gaps or (0.0,) * len(contact.points_W)
        return tuple(next(own) if gap == 0.0 else (ZERO,) for gap in gaps)

    return Forces(tuple(map(of, smooth.contacts)))


def _smooth(contact: Contact) -> Contact:
    return replace(contact, law=contact.law.with_friction(0.0))
