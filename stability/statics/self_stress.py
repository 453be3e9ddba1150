"""Verdicts without self-stress: Coulomb equilibrium is necessary for rest, but not sufficient.

Friction balances a plank between two walls if the walls press it hard enough, but nothing ensures that they do. Forces
that balance each other without a load are self-stress. If some motion strictly opens every contact, there is none.
Otherwise contacts are left out until there is such a motion: if the remaining contacts still balance the loads, the
structure stands without the contacts with uncertain pressure. It also stands if forces along normals alone, or the
load-induced forces, balance it.
"""

from collections.abc import Collection, Iterator
from dataclasses import replace

from stability.problem import ZERO, ConeForces, Contact, Forces, Motion, Problem, Tolerances
from stability.statics.conic_program import Solver, clarabel_solve
from stability.statics.elastic_rest import elastic_rest
from stability.statics.equilibrium import ContactSeparation, balance, separating_motion, widest_separation
from stability.statics.proof import check_forces
from stability.statics.wrench_matrix import passed_down

SHUT = 1e-3  # of the widest separation: a contact that opens less may take part in self-stress
IDLE = 1e-5  # of the load capacity: a contact with a smaller normal force is not needed
STEEP = 0.2  # vertical part of a normal up to which a contact is with a wall
MOST_TRIALS = 8  # of leaving out contacts one by one

__all__ = ["Motion", "forces_without_self_stress", "separating_motion"]


def forces_without_self_stress(
    problem: Problem,
    forces: Forces,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solver: Solver = clarabel_solve,
) -> Forces | None:
    """Return forces that balance a problem by contacts without self-stress; None if none are found.

    `forces` balance the problem, possibly with self-stress. Contacts that are left out get zero forces.
    """
    if separating_motion(problem, solver) is not None:
        return forces
    widest = widest_separation(problem, solver)
    if widest is None:
        return None
    for left_out in _choices(problem, forces, widest):
        remaining = _without(problem, left_out, tolerances, solver)
        if remaining is not None and separating_motion(_less(problem, left_out), solver) is not None:
            return remaining
    unforced = _along_normals(problem, tolerances, solver)
    if unforced is None and not problem.has_joints:
        unforced = elastic_rest(problem, tolerances)
    return unforced or _one_by_one(problem, _shut(problem, widest), tolerances, solver)


def _choices(problem: Problem, forces: Forces, widest: ContactSeparation) -> Iterator[frozenset[int]]:
    """Yield the contacts to leave out: all shut ones without pressure, then all shut and steep ones."""
    shut = _shut(problem, widest)
    carried = passed_down(problem)
    idle = [i for i in shut if _press(forces.of_contacts[i]) <= IDLE * _least_carried(problem.contacts[i], carried)]
    steep = [i for i in shut if steepness(problem.contacts[i]) <= STEEP]
    for choice in (idle, steep):
        if choice:
            yield frozenset(choice)


def _along_normals(problem: Problem, tolerances: Tolerances, solver: Solver) -> Forces | None:
    """Return forces along normals alone; they leave rest as the only motion for any self-stress (`guarantee`)."""
    smooth = replace(problem, contacts=[replace(contact, law=contact.law.smooth()) for contact in problem.contacts])
    several = {i for i, contact in enumerate(problem.contacts) if len(contact.normals_W) > 1}
    return _without(smooth, several, tolerances, solver)


def _one_by_one(problem: Problem, shut: list[int], tolerances: Tolerances, solver: Solver) -> Forces | None:
    """Leave out contacts, the steepest first, as long as the remaining ones balance the loads."""
    left_out: frozenset[int] = frozenset()
    for contact in shut[:MOST_TRIALS]:
        tried = left_out | {contact}
        remaining = _without(problem, tried, tolerances, solver)
        if remaining is None:
            continue
        left_out = tried
        if separating_motion(_less(problem, left_out), solver) is not None:
            return remaining
    return None


def _shut(problem: Problem, widest: ContactSeparation) -> list[int]:
    """Return the contacts that no motion opens, the steepest first."""
    shut = [i for i, separation in enumerate(widest.of_contacts) if separation < SHUT]
    return sorted(shut, key=lambda i: (steepness(problem.contacts[i]), i))


def steepness(contact: Contact) -> float:
    """Return the largest vertical part of a normal: 0 for a wall, 1 for level ground."""
    return max(normal[2] for normal in contact.normals_W)


def _less(problem: Problem, left_out: Collection[int]) -> Problem:
    return replace(problem, contacts=[c for i, c in enumerate(problem.contacts) if i not in left_out])


def _without(problem: Problem, left_out: Collection[int], tolerances: Tolerances, solver: Solver) -> Forces | None:
    """Return forces that balance a problem without some of its contacts."""
    balancing = balance(_less(problem, left_out), tolerances, solver).forces
    if balancing is None:
        return None
    rest = iter(balancing.of_contacts)
    whole = Forces(tuple(_nothing(c) if i in left_out else next(rest) for i, c in enumerate(problem.contacts)))
    return whole if check_forces(problem, whole, tolerances).holds else None


def _nothing(contact: Contact) -> ConeForces:
    return ((ZERO,) * len(contact.normals_W),) * len(contact.points_W)


def _press(forces: ConeForces) -> float:
    """Return the sum of the absolute components of a contact's forces [N]."""
    return sum(abs(x) + abs(y) + abs(z) for of_point in forces for x, y, z in of_point)


def _least_carried(contact: Contact, carried: dict[str, float]) -> float:
    return min(carried[name] for name in (contact.lower, contact.upper) if name in carried)
