"""Balances a group of bricks by vertical forces alone: a linear program over the forces of the contacts.

Vertical forces lie within the friction cones of contacts that are no steeper than their friction. They may end on load
cores of bricks outside the group, which carry them to the ground regardless of other loads.
"""

from collections.abc import Collection, Iterator, Sequence

from stability.contact_law import Coulomb
from stability.geometry.polygons import depth, extent, hull
from stability.graph import from_the_top
from stability.model import BodyId, Vec3
from stability.problem import UP, ConeForces, Contact, Stage
from stability.statics.ledger import ProofGroup
from stability.statics.load_core import carries_upright, piece, plan
from stability.statics.propagation import VerticalForce, VerticalLoad
from stability.statics.structure import Structure

CLEARLY = 1e-6  # share of an extent: a point this far outside is outside despite rounding


def upright_group(structure: Structure, group: Sequence[BodyId]) -> ProofGroup | None:
    """Return the proof that vertical forces alone balance these bricks; None if none is found."""
    from stability.statics.equilibrium import balance  # noqa: PLC0415 -- it brings numpy

    members = frozenset(group)
    if len(from_the_top(structure.rests_on(members))) < len(members):
        return None  # in a ring vertical forces may be self-stress; the next stage checks this
    if any(_hangs_free(structure, name) for name in group):
        return None
    contacts = [c for c in structure.contacts_of(group) if carries_upright(c)]
    landings = list(landings_of(structure, members, contacts))
    answer = balance(structure.problem(group, [landing for landing, _ in landings]), structure.tolerances)
    if answer.forces is None:
        return None
    vertical = vertical_forces(answer.forces.of_contacts, landings)
    return ProofGroup(tuple(group), Stage.VERTICAL, vertical=vertical)


def _hangs_free(structure: Structure, brick: BodyId) -> bool:
    """Return whether a brick without load overhangs all its supports, so that no vertical forces balance it."""
    if structure.carried[brick]:
        return False
    corners = hull(point for contact in structure.supports[brick] for point in plan(contact))
    return bool(corners) and depth(structure.weights[brick].at, corners) < -CLEARLY * extent(corners)


def landings_of(
    structure: Structure, members: Collection[BodyId], contacts: Sequence[Contact]
) -> Iterator[tuple[Contact, Contact]]:
    """Yield vertical contacts without friction: unchanged inside the group, over the core of a brick outside."""
    for contact in contacts:
        if contact.upper not in members:
            continue
        core = structure.cores[contact.lower] if contact.lower in structure.bricks else None
        points = piece(plan(contact), None if contact.lower in members else core)
        if points:
            z = contact.points_W[0][2]
            raised: tuple[Vec3, ...] = tuple((x, y, z) for x, y in points)
            yield Contact(contact.lower, contact.upper, raised, (UP,), Coulomb(0.0)), contact


def vertical_forces(forces: Sequence[ConeForces], landings: Sequence[tuple[Contact, Contact]]) -> list[VerticalForce]:
    """Return the forces at the points of landings, each as one force through the original contact."""
    return [
        VerticalForce(contact, VerticalLoad(force[2], (x, y)))
        for (landing, contact), of_contact in zip(landings, forces, strict=True)
        for (x, y, _), (force,) in zip(landing.points_W, of_contact, strict=True)
        if force[2] > 0.0
    ]
