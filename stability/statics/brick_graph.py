"""Who rests on whom, and which part of its load goes there: the brick graph.

Contact forces are not unique, so shares are a convention where a brick has more supports than it needs: weights are
passed down with forces of least norm, which depend on geometry and weights alone and on no solver. Where weights
cannot be passed down so, because friction, leaning or a counterweight holds a brick, a share is known only if no other
body could take any; else it is not a number.
"""

from collections.abc import Collection, Iterable, Mapping
from math import nan

from stability.graph import from_the_top
from stability.model import BodyId
from stability.statics.facts import ConeForces, Contact, Stage
from stability.statics.ledger import Ledger
from stability.statics.load_core import plan
from stability.statics.propagation import VerticalLoad, shared
from stability.statics.structure import Structure

NOTHING = 1e-6  # share of a brick's weight: a contact that presses less is taken to press with nothing
SIDEWAYS = 1e-6  # vertical part of a normal up to which a contact without friction carries no weight

Shares = Mapping[BodyId, float]


def brick_graph(structure: Structure, ledger: Ledger, bricks: Collection[BodyId]) -> dict[BodyId, Shares]:
    """What some bricks rest on, and the share of each support in their weight and in that of the others among them."""
    group = set(bricks)
    leaning = {name: bodies for name in group if (bodies := _leans_on(structure, ledger, name)) is not None}
    loads: dict[BodyId, VerticalLoad | None] = {
        name: structure.weights[name] for name in group
    }  # None for an unknown one
    found: dict[BodyId, Shares] = {}
    order = from_the_top(structure.rests_on(group))
    for name in (*order, *sorted(group.difference(order))):  # bricks that rest on one another in a ring come last
        load = loads[name] if name not in leaning else None
        patches = [(contact, plan(contact)) for contact in structure.supports[name]]
        handed = shared(load, patches) if load is not None else None
        if handed is None or load is None:
            found[name] = _of_unknown(structure, name, leaning.get(name, ()))
            loads |= dict.fromkeys(loads.keys() & found[name].keys())
            continue
        given = {force.contact.lower: force.load for force in handed}
        found[name] = {
            on: given[on].weight / load.weight if on in given else 0.0 for on in supports_of(structure, name)
        }
        for lower, load in given.items():
            carried = loads.get(lower)
            if carried is not None:
                loads[lower] = carried.plus(load)
    return found


def supports_of(structure: Structure, brick: BodyId) -> list[BodyId]:
    """The bodies below that can press a brick straight up, by name."""
    return sorted({contact.lower for contact in structure.supports[brick]})


def _of_unknown(structure: Structure, name: BodyId, leans_on: Iterable[BodyId]) -> Shares:
    """Shares of a brick whose load upright forces do not pass down."""
    supports = sorted({*supports_of(structure, name), *leans_on})
    able = [on for on in supports if _takes_weight(structure.touching[name][on])]
    if len(able) == 1:
        return {on: 1.0 if on == able[0] else 0.0 for on in supports}
    return {on: nan if on in able else 0.0 for on in supports}


def _takes_weight(contact: Contact) -> bool:
    return contact.friction > 0.0 or any(abs(normal[2]) > SIDEWAYS for normal in contact.normals_W)


def rests_on(structure: Structure, ledger: Ledger, brick: BodyId) -> list[BodyId]:
    """The bodies that a brick rests on or leans on, by name."""
    return sorted({*supports_of(structure, brick), *(_leans_on(structure, ledger, brick) or ())})


def _leans_on(structure: Structure, ledger: Ledger, brick: BodyId) -> set[BodyId] | None:
    """The bodies that hold a brick by friction or leaning, but for those that it carries; None if upright forces do."""
    proven = ledger.group(brick)
    if proven is None or proven.stage is not Stage.CONES:
        return None
    least = NOTHING * structure.weights[brick].weight
    return {
        contact.lower if contact.upper == brick else contact.upper
        for contact, forces in proven.forces
        if (contact.upper == brick or (contact.lower == brick and _is_upright(contact))) and _size(forces) > least
    }


def _is_upright(contact: Contact) -> bool:
    """Whether two bodies lean on each other face to face: then neither lies on the other."""
    return abs(sum(normal[2] for normal in contact.normals_W)) <= SIDEWAYS


def _size(forces: ConeForces) -> float:
    """The sum of the absolute components of forces [N]."""
    return sum(abs(x) + abs(y) + abs(z) for of_point in forces for x, y, z in of_point)
