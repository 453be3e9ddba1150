"""Removal of contacts across gaps that a thin body fills.

A sheet of a millimetre under a carton of 200 mm is thinner than the largest gap of a contact between the carton and the
ground. But the carton stands on the sheet, with the friction of the sheet, and not on the ground.
"""

from collections.abc import Callable, Iterable, Mapping

from stability.contacts.bodies import AnySolid
from stability.geometry.vectors import dot
from stability.model import BodyId, Vec3
from stability.problem import Contact

ROOM = 1.1  # times the reach of a contact: the largest thickness of a body in its gap, including overlaps
PARALLEL = 1.0 - 1e-6  # least cosine between the normals of contacts in a stack of thin bodies

ContactsOf = Callable[[BodyId], Iterable[Contact]]


def is_filled(contact: Contact, solids: Mapping[BodyId, AnySolid], contacts_of: ContactsOf, share: float) -> bool:
    """Check that a stack of thin bodies connects the two bodies of a contact along its normal.

    `solids` are all bodies except planes; `share` is the gap tolerance as a share of the least thickness.
    """
    if len(contact.normals_W) != 1:
        return False
    thickness = min(solids[body].shortest for body in (contact.lower, contact.upper) if body in solids)
    visited, front = {contact.upper}, [contact.upper]
    while front:
        body = front.pop()
        for below in _below(body, contacts_of(body), contact.normals_W[0]):
            if below == contact.lower and body != contact.upper:
                return True
            if below not in visited and below in solids and solids[below].shortest <= ROOM * share * thickness:
                visited.add(below)
                front.append(below)
    return False


def _below(body: BodyId, contacts: Iterable[Contact], up_W: Vec3) -> Iterable[BodyId]:
    """Yield the bodies below a body along a direction."""
    for contact in contacts:
        if len(contact.normals_W) == 1:
            sign = 1.0 if contact.upper == body else -1.0
            if sign * dot(contact.normals_W[0], up_W) > PARALLEL:
                yield contact.lower if contact.upper == body else contact.upper
