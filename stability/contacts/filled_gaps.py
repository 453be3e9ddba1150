"""A gap counts as contact up to a share of the bodies beside it, but not where a body lies in it that fills it.

A sheet of a millimetre under a carton of 200 mm is thinner than the gap across which the carton still touches the
ground. It stands on the sheet all the same, and slides as that lets it: not on what is below.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

from stability.contacts.bodies import Solid
from stability.geometry.box_distance import TOUCHING
from stability.geometry.vectors import dot
from stability.model import BodyId, Vec3
from stability.problem import Contact

ROOM = 1.1  # times the reach of a contact: what is thicker has no room in its gap, whatever it is in its neighbours
PARALLEL = 1.0 - 1e-6  # cosine between the normals of what lies one on the other

ContactsOf = Callable[[BodyId], Iterable[Contact]]


def is_filled(contact: Contact, solids: Mapping[BodyId, Solid], contacts_of: ContactsOf, share: float) -> bool:
    """Whether thin bodies, one on the other, lead from one body of a contact to the other along its normal.

    `solids` are all bodies but planes, and `share` is that of the least thickness by which bodies touch.
    """
    if len(contact.normals_W) != 1:
        return False
    thickness = min(solids[body].shortest for body in (contact.lower, contact.upper) if body in solids)
    seen, front = {contact.upper}, [contact.upper]
    while front:
        body = front.pop()
        for below in _below(body, contacts_of(body), contact.normals_W[0]):
            if below == contact.lower and body != contact.upper:
                return True
            if below not in seen and below in solids and solids[below].shortest <= ROOM * share * thickness:
                seen.add(below)
                front.append(below)
    return False


def thin_ones(solids: Mapping[BodyId, Solid], share: float = TOUCHING) -> list[BodyId]:
    """The bodies that are thin enough to fill a gap which counts as contact of others; none, nearly everywhere."""
    thickest = max((body.shortest for body in solids.values()), default=0.0)
    return [name for name, body in solids.items() if body.shortest <= ROOM * share * thickest]


def without_filled(
    contacts: Sequence[Contact], beside: Iterable[Contact], solids: Mapping[BodyId, Solid], share: float = TOUCHING
) -> list[Contact]:
    """Those of some contacts whose gaps nothing fills; `beside` are all others of what may be in them."""
    known = [*contacts, *beside]

    def contacts_of(body: BodyId) -> Iterable[Contact]:
        return (contact for contact in known if body in (contact.lower, contact.upper))

    return [contact for contact in contacts if not is_filled(contact, solids, contacts_of, share)]


def _below(body: BodyId, contacts: Iterable[Contact], up_W: Vec3) -> Iterable[BodyId]:
    """What a body lies on, seen along a direction."""
    for contact in contacts:
        if len(contact.normals_W) == 1:
            sign = 1.0 if contact.upper == body else -1.0
            if sign * dot(contact.normals_W[0], up_W) > PARALLEL:
                yield contact.lower if contact.upper == body else contact.upper
