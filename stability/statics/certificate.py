"""Assembles the forces of a whole assembly from its groups, and the share of load that each support takes."""

from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from math import hypot, nan

from stability.geometry.polygons import Point2, barycentric, doubled_area
from stability.geometry.vectors import add
from stability.graph import from_the_top
from stability.model import BodyId, Vec3
from stability.problem import ZERO, ConeForces, Contact, Forces, Stage
from stability.statics.ledger import Ledger
from stability.statics.load_core import LoadCore, plan, upright_normal
from stability.statics.propagation import VerticalLoad, least_norm, shared
from stability.statics.structure import Structure

# The forces of a whole assembly, assembled from its groups, so that plain arithmetic can check them all at once.
#
# Groups pass their vertical loads to load cores. From the top down, all loads of a brick inside its core are one load
# inside it, because a core is convex; it is split over the corners of the core, and each part is passed down at its
# corner.


class Tally:
    """Sums of cone forces by contact. Added forces are stored, and summed on demand."""

    def __init__(self) -> None:
        # by lower body, then by upper body, points and, for dry contacts, normals
        self._noted: dict[BodyId, dict[object, tuple[Contact, list[ConeForces | VerticalLoad]]]] = {}

    def _of(self, contact: Contact) -> list[ConeForces | VerticalLoad]:
        onto, key = self._noted.setdefault(contact.lower, {}), _key(contact)
        if key not in onto:
            onto[key] = contact, []
        return onto[key][1]

    def add(self, contact: Contact, forces: ConeForces) -> None:
        """Add forces at the points of a contact."""
        self._of(contact).append(forces)

    def press(self, contact: Contact, load: VerticalLoad) -> None:
        """Add a vertical force inside a contact, as forces at its corners."""
        self._of(contact).append(load)

    def of(self, contact: Contact) -> ConeForces:
        """Return the sums of a contact; zero if nothing was added.

        Raises ValueError for a contact without vertical forces.
        """
        _, noted = self._noted.get(contact.lower, {}).get(_key(contact), (contact, []))
        return _summed(contact, noted)

    def onto(self, lower: BodyId) -> list[tuple[Contact, ConeForces]]:
        """Return the contacts whose lower body is this one, with the sums of forces at their points."""
        return [(contact, _summed(contact, noted)) for contact, noted in self._noted.get(lower, {}).values()]


def _key(contact: Contact) -> object:
    if contact.law.is_cone:  # a compound has several contacts with one body
        return contact.upper, contact.points_W, contact.normals_W
    return contact.upper, contact.points_W


def _summed(contact: Contact, noted: Sequence[ConeForces | VerticalLoad]) -> ConeForces:
    sums = [[ZERO] * len(contact.normals_W) for _ in contact.points_W]
    for each in noted:
        if isinstance(each, VerticalLoad):
            _press(contact, each, sums)
            continue
        for at_point, of_point in zip(sums, each, strict=True):
            at_point[:] = [add(one, other) for one, other in zip(at_point, of_point, strict=True)]
    return tuple(tuple(of_point) for of_point in sums)


def _press(contact: Contact, load: VerticalLoad, sums: Sequence[list[Vec3]]) -> None:
    normal = upright_normal(contact)
    if normal is None:
        raise ValueError(f"the contact of {contact.upper} on {contact.lower} carries no vertical force")
    for at_point, share in zip(sums, _at_corners(contact, load.at), strict=True):
        at_point[normal] = add(at_point[normal], (0.0, 0.0, share * load.weight))


def _at_corners(contact: Contact, at: Point2) -> list[float]:
    """Return the shares of the points of a contact in a unit force at a point in plan."""
    points = [(x, y) for x, y, _ in contact.points_W]
    if len(points) == 1:
        return [1.0]
    if len(points) == 2:  # noqa: PLR2004 -- a line
        length = hypot(points[1][0] - points[0][0], points[1][1] - points[0][1])
        part = hypot(at[0] - points[0][0], at[1] - points[0][1]) / length if length > 0.0 else 0.0
        return [1.0 - part, part]
    if doubled_area(points)[0] < 0.0:
        return barycentric(at, tuple(points[::-1]))[::-1]
    return barycentric(at, tuple(points))


def total_forces(structure: Structure, ledger: Ledger, contacts: list[Contact]) -> Forces:
    """Return the sums of the forces of an assembly's groups, one entry per contact."""
    tally = force_sums(structure, ledger, structure.bricks.keys())
    return Forces(tuple(tally.of(contact) for contact in contacts))


def force_sums(structure: Structure, ledger: Ledger, bricks: Set[BodyId]) -> Tally:
    """Return the sums of the forces of all groups, with forces of load cores only for `bricks`."""
    tally = Tally()
    loads = {name: structure.weights[name] for name in ledger.by_core() & bricks}
    for group in ledger.groups():
        for contact, forces in group.forces:
            now = structure.current(contact)
            tally.add(now, forces if now is contact else _at_new_corners(contact, forces, now))
        for force in group.vertical:
            tally.press(structure.current(force.contact), force.load)
            lower = force.contact.lower
            if lower in structure.bricks and lower not in group.members:
                _load(loads, lower, force.load)
    for brick in reversed(structure.by_turn(bricks)):
        if brick in loads:
            for contact, load in routed(loads[brick], structure.cores[brick]):
                tally.press(structure.current(contact), load)
                if contact.lower in structure.bricks:
                    _load(loads, contact.lower, load)
    return tally


def _at_new_corners(contact: Contact, forces: ConeForces, now: Contact) -> ConeForces:
    """Return the forces at the corners of a contact with more corners than before, which keeps the old ones."""
    known = dict(zip(contact.points_W, forces, strict=True))
    none = (ZERO,) * len(contact.normals_W)
    if not known.keys() <= set(now.points_W):
        raise ValueError(f"the contact of {now.upper} on {now.lower} lost a corner")
    return tuple(known.get(point, none) for point in now.points_W)


def _load(loads: dict[BodyId, VerticalLoad], brick: BodyId, load: VerticalLoad) -> None:
    loads[brick] = loads[brick].plus(load) if brick in loads else load


def routed(load: VerticalLoad, core: LoadCore) -> list[tuple[Contact, VerticalLoad]]:
    """Return a load inside a core as loads on the contacts that make up the core."""
    if len(core.pieces) == 1:
        return [(core.pieces[0][0], load)]
    corners = [(contact, point) for contact, points in core.pieces for point in points]
    shares = least_norm(load.at, [point for _, point in corners]) or _of_hull(load.at, core, corners)
    return [
        (contact, VerticalLoad(share * load.weight, point))
        for (contact, point), share in zip(corners, shares, strict=True)
        if share > 0.0
    ]


def _of_hull(at: Point2, core: LoadCore, corners: list[tuple[Contact, Point2]]) -> list[float]:
    """Return a load as loads on at most three corners of the hull: always possible, but a corner may be far away."""
    weights: Mapping[Point2, float] = dict(zip(core.polygon, barycentric(at, core.polygon), strict=True))
    used: set[Point2] = set()
    shares = []
    for _, point in corners:
        shares.append(0.0 if point in used else weights.get(point, 0.0))
        used.add(point)
    return shares


# The brick graph: the supports of each brick and their shares of its load.
#
# Contact forces are not unique, so shares are a convention if a brick has redundant supports: weights are passed down
# by forces of least norm, which depend only on geometry and weights, not on a solver. If weights cannot be passed down
# in this way, because friction, leaning or a counterweight holds a brick, a share is known only if there is no other
# support; otherwise it is NaN.


NOTHING = 1e-6  # share of a brick's weight: a contact with a smaller normal force counts as unloaded
SIDEWAYS = 1e-6  # vertical part of a normal up to which a contact without friction carries no weight

Shares = Mapping[BodyId, float]


def brick_graph(structure: Structure, ledger: Ledger, bricks: Collection[BodyId]) -> dict[BodyId, Shares]:
    """Return the supports of some bricks, with the share of each in their weight and in that of the bricks above."""
    group = set(bricks)
    leaning = {name: bodies for name in group if (bodies := _leans_on(structure, ledger, name)) is not None}
    loads: dict[BodyId, VerticalLoad | None] = {
        name: structure.weights[name] for name in group
    }  # None for an unknown share
    shares: dict[BodyId, Shares] = {}
    order = from_the_top(structure.rests_on(group))
    for name in (*order, *sorted(group.difference(order))):  # bricks that rest on one another in a ring come last
        load = loads[name] if name not in leaning and structure.is_upright(name) else None
        patches = [(contact, plan(contact)) for contact in structure.supports[name]]
        handed = shared(load, patches) if load is not None else None
        if handed is None or load is None:
            shares[name] = _of_unknown(structure, name, leaning.get(name, ()))
            loads |= dict.fromkeys(loads.keys() & shares[name].keys())
            continue
        loads_on: dict[BodyId, VerticalLoad] = {}
        for force in handed:
            _load(loads_on, force.contact.lower, force.load)
        shares[name] = {
            on: loads_on[on].weight / load.weight if on in loads_on else 0.0 for on in supports_of(structure, name)
        }
        for lower, load in loads_on.items():
            carried = loads.get(lower)
            if carried is not None:
                loads[lower] = carried.plus(load)
    return shares


def supports_of(structure: Structure, brick: BodyId) -> list[BodyId]:
    """Return the bodies below that can push a brick vertically up, by name."""
    return sorted({contact.lower for contact in structure.supports[brick]})


def _of_unknown(structure: Structure, name: BodyId, leans_on: Iterable[BodyId]) -> Shares:
    """Return the shares of a brick whose load is not passed down by vertical forces."""
    supports = sorted({*supports_of(structure, name), *leans_on})
    able = [on for on in supports if any(map(_takes_weight, structure.touching[name][on]))]
    if len(able) == 1:
        return {on: 1.0 if on == able[0] else 0.0 for on in supports}
    return {on: nan if on in able else 0.0 for on in supports}


def _takes_weight(contact: Contact) -> bool:
    return contact.law.friction > 0.0 or any(abs(normal[2]) > SIDEWAYS for normal in contact.normals_W)


def rests_on(structure: Structure, ledger: Ledger, brick: BodyId) -> list[BodyId]:
    """Return the bodies that a brick rests on or leans on, by name."""
    return sorted({*supports_of(structure, brick), *(_leans_on(structure, ledger, brick) or ())})


def _leans_on(structure: Structure, ledger: Ledger, brick: BodyId) -> set[BodyId] | None:
    """Return the bodies that hold a brick by friction or leaning; None if vertical forces hold it."""
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
    """Return whether two bodies lean on each other face to face, so that neither lies on the other."""
    return abs(sum(normal[2] for normal in contact.normals_W)) <= SIDEWAYS


def lies_on(contact: Contact) -> bool:
    """Return whether the upper body of a contact lies on the lower one, and does not only stand beside it."""
    return any(normal[2] > SIDEWAYS for normal in contact.normals_W)


def _size(forces: ConeForces) -> float:
    """Return the sum of the absolute components of forces [N]."""
    return sum(abs(x) + abs(y) + abs(z) for of_point in forces for x, y, z in of_point)
