"""Is rest the only thing that can happen, or one that can? Balance with friction shows that rest is possible, no more.

Let every brick be at rest, and a be any acceleration that the laws of contact allow: no contact closes (a_n >= 0), a
normal force acts only where none opens (f_n a_n = 0), and friction does not push along a slip (f_t . a_t <= 0). Then

    a' M a = a' g + sum f_n a_n + sum f_t . a_t <= a' g.

If forces N >= 0 along the normals alone balance the loads g, then a' g = - sum N a_n <= 0, so that a' M a <= 0 and
a = 0: nothing moves, whatever the friction and whichever of the possible forces act. The same holds of a change of
velocity by impulses. So such forces are a certificate, which `proof` checks by arithmetic as forces without friction.

No force at a point where the bodies are apart is counted on either: there the laws of contact hold once the gap has
closed, if at all.

Where a contact has several normals at a point, edges or corners meet, and a body leaves it along one of them: there
a_n >= 0 does not hold for all, and no force of such a contact is counted on.
"""

from dataclasses import replace

from stability.blas_threads import one_thread
from stability.statics.facts import ZERO, ConeForces, Contact, Forces, Problem, Tolerances
from stability.statics.proof import check_forces
from stability.statics.rounding import rounded
from stability.statics.solvers.equilibrium import balance


@one_thread()
def guarantee(
    problem: Problem,
    known: Forces | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> Forces | None:
    """Forces along normals alone that balance a problem, one entry for each contact with a single normal; or None.

    `known` are forces that balance it with friction: most often these are along the normals already.
    """
    tolerances = rounded(problem, tolerances)
    kept = [number for number, contact in enumerate(problem.contacts) if len(contact.normals_W) == 1]
    smooth = replace(problem, contacts=[_smooth(problem.contacts[number]) for number in kept])
    touching = without_gaps(smooth)
    if known is not None and len(known.of_contacts) == len(problem.contacts):
        same = Forces(tuple(_without(known.of_contacts[number], problem.contacts[number]) for number in kept))
        if check_forces(smooth, same, tolerances).holds:
            return same
    found = balance(touching, tolerances).forces
    return found if found is None or touching is smooth else _at_all_points(found, touching, smooth)


def without_gaps(problem: Problem) -> Problem:
    """The problem without the points of contacts at which there is a gap; itself if there are none."""
    if not any(contact.gaps for contact in problem.contacts):
        return problem
    return replace(problem, contacts=[touching for c in problem.contacts if (touching := _touching(c)).points_W])


def _touching(contact: Contact) -> Contact:
    if not contact.gaps:
        return contact
    points = tuple(point for point, gap in zip(contact.points_W, contact.gaps, strict=True) if gap == 0.0)
    return replace(contact, points_W=points, gaps=())


def _without(forces: ConeForces, contact: Contact) -> ConeForces:
    """The forces of a contact, with none where there is a gap."""
    if not contact.gaps:
        return forces
    return tuple(
        of_point if gap == 0.0 else (ZERO,) * len(of_point) for of_point, gap in zip(forces, contact.gaps, strict=True)
    )


def _at_all_points(found: Forces, touching: Problem, smooth: Problem) -> Forces:
    """Forces at the points that touch, with none at the others."""
    of_pair = {(c.lower, c.upper): iter(forces) for c, forces in zip(touching.contacts, found.of_contacts, strict=True)}

    def of(contact: Contact) -> ConeForces:
        own = of_pair.get((contact.lower, contact.upper), iter(()))
        gaps = contact.gaps or (0.0,) * len(contact.points_W)
        return tuple(next(own) if gap == 0.0 else (ZERO,) for gap in gaps)

    return Forces(tuple(map(of, smooth.contacts)))


def _smooth(contact: Contact) -> Contact:
    return replace(contact, friction=0.0)
