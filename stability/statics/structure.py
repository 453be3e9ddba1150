"""The contact graph and load core of an assembly, updated as bricks come and go."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, count
from math import inf

from stability.contact_law import Friction, GivenFriction, as_friction
from stability.contacts.bodies import AnySolid, BoxSolid, solid
from stability.contacts.detection import contacts_between, contacts_with_plane
from stability.contacts.filled_gaps import ROOM, is_filled
from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import apart, apart_from_plane
from stability.geometry.vectors import add
from stability.graph import reached
from stability.joints import DRY, Joints
from stability.loads import UNLOADED, Loads
from stability.model import BodyId, Plane, Vec3
from stability.problem import Contact, Placed, Problem, Tolerances, UnknownTension, Wrench
from stability.statics.journal import Journal, JournaledDict, JournaledNeighbours
from stability.statics.load_core import LoadCore, carries_upright, core_of
from stability.statics.propagation import VerticalLoad
from stability.ties import Tie
from stability.work_limit import BRICK, CORE, add_work

# The bricks of an assembly, their contacts and load cores, updated as bricks are added and removed.


MANY = 4  # bricks that are worth the set-up of arrays


@dataclass(frozen=True, slots=True)
class StructureState:
    """Snapshot of all mutable data of a structure."""

    bricks: Mapping[BodyId, Placed]
    touching: Mapping[BodyId, dict[BodyId, tuple[Contact, ...]]]
    supports: Mapping[BodyId, list[Contact]]
    carried: Mapping[BodyId, list[BodyId]]
    cores: Mapping[BodyId, LoadCore]
    weights: Mapping[BodyId, VerticalLoad]
    turn: Mapping[BodyId, int]
    solids: Mapping[BodyId, AnySolid]
    across_gaps: Mapping[tuple[BodyId, BodyId], tuple[Contact, ...]]
    joined: Mapping[tuple[BodyId, BodyId], tuple[Contact, ...]]
    applied: Mapping[BodyId, Wrench]
    ties: Mapping[str, Tie | None]


@dataclass
class Structure:
    """Bricks and fixed bodies. Cores depend on the order of placement: only earlier bricks carry later ones.

    Data of a brick are never changed in place, so that a copy of the tables costs little.
    """

    planes: tuple[Plane, ...]
    tables: tuple[Placed, ...]  # fixed boxes
    friction: GivenFriction  # between bricks
    gravity: float  # [m/s2]
    tolerances: Tolerances
    joints: Joints = DRY
    loads: Loads = UNLOADED
    journal: Journal = field(default_factory=Journal)  # undoes an interrupted change
    bricks: JournaledDict[BodyId, Placed] = field(init=False)
    # by brick, then by other body: one contact, or several of a compound
    touching: JournaledDict[BodyId, dict[BodyId, tuple[Contact, ...]]] = field(init=False)
    supports: JournaledDict[BodyId, list[Contact]] = field(init=False)  # contacts that can push a brick vertically up
    carried: JournaledDict[BodyId, list[BodyId]] = field(init=False)  # bricks that a brick can push vertically up
    cores: JournaledDict[BodyId, LoadCore] = field(init=False)
    # The weight of each brick, with its applied loads if the sum is a vertical force downwards.
    weights: JournaledDict[BodyId, VerticalLoad] = field(init=False)
    applied: JournaledDict[BodyId, Wrench] = field(init=False)  # the loads on each loaded brick, and pulls of ties
    # The ties that hold, which pull bricks that are placed from then on; None for those that have come off.
    ties: JournaledDict[str, Tie | None] = field(init=False)
    # by lower and upper body
    across_gaps: JournaledDict[tuple[BodyId, BodyId], tuple[Contact, ...]] = field(init=False)
    # by lower and upper body: the contacts that joints add to that in `touching`
    joined: JournaledDict[tuple[BodyId, BodyId], tuple[Contact, ...]] = field(init=False)
    _turn: JournaledDict[BodyId, int] = field(init=False)  # the order in which the cores were computed
    _law: Friction = field(init=False)
    _solids: JournaledDict[BodyId, AnySolid] = field(init=False)
    _thinnest: float = inf  # of all bodies ever present [m]
    _thickest: float = 0.0
    _curved: bool = False  # whether there ever was a contact on a curved surface
    _neighbours: JournaledNeighbours = field(init=False)
    _turns: Iterator[int] = field(default_factory=count)

    def __post_init__(self) -> None:
        """Register the fixed boxes as neighbours."""
        self.bricks = JournaledDict(self.journal, ordered=True)
        self.touching, self.supports, self.carried = (
            JournaledDict(self.journal),
            JournaledDict(self.journal),
            JournaledDict(self.journal),
        )
        self.cores, self.weights, self._turn = (
            JournaledDict(self.journal),
            JournaledDict(self.journal),
            JournaledDict(self.journal),
        )
        self.across_gaps, self._solids = JournaledDict(self.journal), JournaledDict(self.journal)
        self.joined, self.applied = JournaledDict(self.journal), JournaledDict(self.journal)
        self.ties = JournaledDict(self.journal)
        self._neighbours = JournaledNeighbours(journal=self.journal)
        self._law = as_friction(self.friction)
        for placed in self.tables:
            self._show(solid(placed))

    def _show(self, own: AnySolid) -> None:
        self._solids[own.id] = own
        self._thinnest, self._thickest = min(self._thinnest, own.shortest), max(self._thickest, own.shortest)
        self._neighbours.add(own.id, own.low_W, own.high_W)

    def put(self, placed: Placed) -> None:
        """Place a brick, with its contacts and its core; contacts across a gap that it fills are removed."""
        name = placed.brick.id
        own = solid(placed)
        contacts = self._found(own)
        filled = self._filled_by(own, contacts)
        self.bricks[name] = placed
        applied = self._applied_to(placed)
        if applied is not None:
            self.applied[name] = applied
        self.weights[name] = self._upright(placed) or self._own_weight(placed)
        self.touching[name], self.supports[name], self.carried[name] = {}, [], []
        self._show(own)
        for contact in self._unfilled(contacts, contacts):
            self._join(contact)
        self.find_core(name)
        self._part(filled)

    def put_together(self, coming: Sequence[Placed]) -> bool:
        """Place the first bricks of a joined structure, each after its supports, as `put` does one by one, but faster.

        Return False, without a change, if there are other bricks or shapes than boxes, or thin bricks that fill gaps.
        """
        boxes, fixed = self._boxes_with(coming), len(self._solids)
        if boxes is None:
            return False
        sides, own = [each.shortest for each in boxes], boxes[fixed:]
        if min(sides) <= ROOM * self.tolerances.gap * max(sides):
            return False
        for placed, box in zip(coming, own, strict=True):
            name = placed.brick.id
            self.bricks[name] = placed
            if (applied := self._applied_to(placed)) is not None:
                self.applied[name] = applied
            self.weights[name] = self._upright(placed) or self._own_weight(placed)
            self._show(box)
        self._touch([*self._on_planes(own), *self._among(boxes, fixed)])
        for placed in coming:
            self.find_core(placed.brick.id)
        return True

    def are_clear(self, coming: Sequence[Placed], overlap: float) -> bool:
        """Return whether the first bricks overlap nothing by more than `overlap` [m] or the reach of contact.

        False if this fast test does not decide it.
        """
        boxes = self._boxes_with(coming)
        if boxes is None:
            return False
        from stability.contacts.level_boxes import are_clear  # noqa: PLC0415 -- it brings numpy

        return are_clear(boxes, len(self._solids), self.planes, overlap)

    def _boxes_with(self, coming: Sequence[Placed]) -> list[BoxSolid] | None:
        """Return the fixed boxes and the first bricks of a joined structure; None for all else."""
        if self.bricks or not self.joints.rules or len(coming) < MANY:
            return None
        solids = [*self._solids.values(), *map(solid, coming)]
        boxes = [own for own in solids if isinstance(own, BoxSolid)]
        return boxes if len(boxes) == len(solids) else None

    def _on_planes(self, coming: Sequence[BoxSolid]) -> Iterator[tuple[BodyId, Contact]]:
        """Yield the contacts of new bodies with planes, each with the body."""
        for own in coming:
            for plane in self.planes:
                for contact in contacts_with_plane(own, plane, self.tolerances, self._law.on(own.id, plane)):
                    yield own.id, contact

    def _among(self, boxes: Sequence[BoxSolid], fixed: int) -> Iterator[tuple[BodyId, Contact]]:
        """Yield the contacts of boxes, each with the later one, those of each box by name; the first ones are fixed."""
        from stability.contacts.level_boxes import BoxArrays, contacts_of_pairs  # noqa: PLC0415 -- it brings numpy

        arrays = BoxArrays.of(boxes)
        rank = {name: number for number, name in enumerate(sorted(arrays.names))}
        near = zip(*(each.tolist() for each in arrays.near(self.tolerances.gap)), strict=True)
        pairs = sorted(
            ((one, other) for one, other in near if other >= fixed),
            key=lambda pair: (pair[1], rank[arrays.names[pair[0]]]),
        )
        for number, contact in contacts_of_pairs(boxes, arrays, pairs, self._law.of, self.tolerances):
            yield arrays.names[pairs[number][1]], contact

    def _touch(self, found: Sequence[tuple[BodyId, Contact]]) -> None:
        """Register the contacts of new bodies, in the order in which the bodies come."""
        turn = {name: number for number, name in enumerate(self.bricks)}
        contacts = [contact for _, contact in sorted(found, key=lambda each: turn[each[0]])]
        bodies = {placed.brick.id: placed for placed in self.tables} | self.bricks
        touching: dict[BodyId, dict[BodyId, tuple[Contact, ...]]] = {name: {} for name in self.bricks}
        supports: dict[BodyId, list[Contact]] = {name: [] for name in self.bricks}
        carried: dict[BodyId, list[BodyId]] = {name: [] for name in self.bricks}
        joined: dict[tuple[BodyId, BodyId], tuple[Contact, ...]] = {}
        for contact, added in self.joints.joined(contacts, bodies):
            lower, upper = contact.lower, contact.upper
            if added:
                joined[lower, upper] = added
            if contact.gaps:
                self.across_gaps[lower, upper] = (contact,)
            for body, other in ((lower, upper), (upper, lower)):
                if body in touching:
                    touching[body][other] = (contact,)
            if upper in supports and carries_upright(contact):
                supports[upper].append(contact)
                if lower in carried:
                    carried[lower].append(upper)
        self.touching.replace(touching)
        self.supports.replace(supports)
        self.carried.replace(carried)
        self.joined.replace(joined)

    def _found(self, own: AnySolid) -> list[Contact]:
        """Return the contacts of a body within the reach of contact."""
        law, near = self._law, self.tolerances
        contacts = [c for plane in self.planes for c in contacts_with_plane(own, plane, near, law.on(own.id, plane))]
        for other in self._neighbours.around(own.low_W, own.high_W, reach_between(own.shortest, share=near.gap)):
            if other != own.id:
                contacts += contacts_between(own, self._solids[other], law.of(own.id, other), near)
        return contacts

    def _unfilled(self, contacts: Iterable[Contact], coming: Sequence[Contact]) -> list[Contact]:
        """Return the old and new contacts whose gaps no body fills."""
        if not self._may_fill(self._thinnest):
            return list(contacts)

        def contacts_of(body: BodyId) -> Iterable[Contact]:
            return [*chain(*self.touching.get(body, {}).values()), *(c for c in coming if body in (c.lower, c.upper))]

        return [c for c in contacts if not is_filled(c, self._solids, contacts_of, self.tolerances.gap)]

    def _may_fill(self, thickness: float) -> bool:
        """Return whether a body of this thickness [m] may fill a gap that counts as contact of other bodies."""
        return thickness <= ROOM * self.tolerances.gap * self._thickest

    def parted_by(self, placed: Placed) -> list[BodyId]:
        """Return the bricks with a contact across a gap that a new brick will fill, and all bricks above them."""
        if not self._may_fill(placed.brick.shape.least_thickness):
            return []
        own = solid(placed)
        filled = self._filled_by(own, self._found(own))
        return self.upwards(self.with_all_above({c.upper for c in filled} & self.bricks.keys()))

    def _filled_by(self, own: AnySolid, coming: Sequence[Contact]) -> list[Contact]:
        """Return the contacts across gaps that a new body fills, given its contacts."""
        if not self._may_fill(own.shortest):
            return []
        self._thinnest = min(self._thinnest, own.shortest)
        self._solids[own.id] = own
        touched = {body for c in coming for body in (c.lower, c.upper) if body in self.bricks}
        known = {id(c): c for body in sorted(touched) for c in chain(*self.touching[body].values())}
        still = self._unfilled(known.values(), coming)
        del self._solids[own.id]
        return [c for c in known.values() if c not in still]

    def _join(self, contact: Contact) -> None:
        lower, upper = contact.lower, contact.upper
        self._curved = self._curved or bool(contact.rolling)
        if self.joints.rules:
            bodies = {placed.brick.id: placed for placed in self.tables if placed.brick.id in (lower, upper)}
            bodies |= {name: self.bricks[name] for name in (lower, upper) if name in self.bricks}
            added = self.joints.contacts(contact, bodies)
            if added:
                self.joined[lower, upper] = (*self.joined.get((lower, upper), ()), *added)
            else:
                contact = self.joints.dry_contact(contact, bodies)
        if contact.gaps:
            self.across_gaps[lower, upper] = (*self.across_gaps.get((lower, upper), ()), contact)
        for body, other in ((lower, upper), (upper, lower)):
            if body in self.bricks:
                known = self.touching[body]
                self.touching[body] = {**known, other: (*known.get(other, ()), contact)}
        if upper in self.bricks and carries_upright(contact):
            self.supports[upper] = [*self.supports[upper], contact]
            if lower in self.bricks:
                self.carried[lower] = [*self.carried[lower], upper]

    def _part(self, contacts: Sequence[Contact]) -> None:
        """Remove all contacts of the bodies of contacts whose gaps are filled, and join those that touch elsewhere."""
        filled = {id(contact) for contact in contacts}
        pairs = dict.fromkeys((contact.lower, contact.upper) for contact in contacts)
        for lower, upper in pairs:
            known = self.touching[upper if upper in self.bricks else lower]
            left = [c for c in known.get(lower if upper in self.bricks else upper, ()) if id(c) not in filled]
            for one, other in ((lower, upper), (upper, lower)):
                self.across_gaps.pop((one, other), None)
                self.joined.pop((one, other), None)
                if one in self.bricks:
                    self.touching[one] = {each: c for each, c in self.touching[one].items() if each != other}
                    self.supports[one] = [c for c in self.supports[one] if c.lower != other]
                    self.carried[one] = [each for each in self.carried[one] if each != other]
            for contact in left:
                self._join(contact)
        for brick in self.upwards(self.with_all_above({c.upper for c in contacts} & self.bricks.keys())):
            self.find_core(brick)

    def is_joined(self) -> bool:
        """Return whether most bricks are joined: then all connected ones are best judged together."""
        return 2 * len(self.joined) > len(self.bricks)

    def may_roll(self, brick: BodyId) -> bool:
        """Return whether a contact of a brick, or of one connected with it, is on a curved surface."""
        return self._curved and any(
            contact.rolling for name in self.component(brick) for contact in chain(*self.touching[name].values())
        )

    def refine(self, refined: Iterable[tuple[Contact, Contact]]) -> None:
        """Replace contacts by the same ones with more corners on round borders."""
        for old, new in refined:
            for body, other in ((old.lower, old.upper), (old.upper, old.lower)):
                if body in self.bricks:
                    known = self.touching[body]
                    now = tuple(new if contact is old else contact for contact in known[other])
                    self.touching[body] = {**known, other: now}
            if old.upper in self.bricks:
                self.supports[old.upper] = [new if c is old else c for c in self.supports[old.upper]]

    def current(self, contact: Contact) -> Contact:
        """Return a contact with a round border as it is refined now."""
        if contact.patch is None:
            return contact
        body, other = (contact.upper, contact.lower)
        if body not in self.bricks:
            body, other = other, body
        known = self.touching.get(body, {}).get(other, ())
        return next((each for each in known if each.patch and each.patch.is_same_as(contact.patch)), contact)

    def find_core(self, brick: BodyId) -> None:
        """Compute the core of a brick again from the known cores below."""
        add_work(CORE)
        self._turn[brick] = next(self._turns)
        # A load on a contact that may roll is carried only if something else keeps it from rolling.
        below = [
            c for c in self.supports[brick] if not c.rolling and (c.lower not in self.bricks or c.lower in self.cores)
        ]
        self.cores[brick] = core_of(below, self.cores)

    def neighbours(self, brick: BodyId) -> list[Placed]:
        """Return the other boxes, fixed ones included, that a brick may touch or overlap."""
        fixed = {placed.brick.id: placed for placed in self.tables}
        return [
            self.bricks.get(name) or fixed[name]
            for name in self._neighbours.neighbours(
                brick, reach_between(self._solids[brick].shortest, share=self.tolerances.gap)
            )
        ]

    def within(self, low_W: Vec3, high_W: Vec3) -> list[Placed]:
        """Return all boxes, fixed ones included, whose bounding boxes meet this one."""
        fixed = {placed.brick.id: placed for placed in self.tables}
        return [self.bricks.get(name) or fixed[name] for name in self._neighbours.around(low_W, high_W, 0.0)]

    def around(self, brick: BodyId, within: float) -> list[BodyId]:
        """Return the other bricks with bounding boxes within a distance [m], by name."""
        return [name for name in self._neighbours.neighbours(brick, within) if name in self.bricks]

    def take(self, brick: BodyId) -> None:
        """Remove a brick. The cores of the bricks that it carried still include it and must be computed again."""
        touched = self.touching.pop(brick)
        for contact in chain(*touched.values()):
            self.across_gaps.pop((contact.lower, contact.upper), None)
            self.joined.pop((contact.lower, contact.upper), None)
        beside = [other for other in touched if other in self.bricks]
        for other in beside:
            self.touching[other] = {body: c for body, c in self.touching[other].items() if body != brick}
            self.supports[other] = [c for c in self.supports[other] if c.lower != brick]
            self.carried[other] = [upper for upper in self.carried[other] if upper != brick]
        for record in (self.bricks, self.supports, self.carried, self.cores, self.weights, self._turn):
            del record[brick]
        self.applied.pop(brick, None)
        self._neighbours.remove(brick)
        del self._solids[brick]
        if self._may_fill(self._thinnest):  # other bodies may touch again across a gap that the brick filled
            for other in beside:
                near = self._found(self._solids[other])
                again = [c for c in near if not {c.lower, c.upper} & self.touching[other].keys()]
                for contact in self._unfilled(again, again):
                    self._join(contact)

    def state(self) -> StructureState:
        """Return a snapshot."""
        return StructureState(
            dict(self.bricks),
            dict(self.touching),
            dict(self.supports),
            dict(self.carried),
            dict(self.cores),
            dict(self.weights),
            dict(self._turn),
            dict(self._solids),
            dict(self.across_gaps),
            dict(self.joined),
            dict(self.applied),
            dict(self.ties),
        )

    def restore(self, state: StructureState) -> None:
        """Restore a snapshot."""
        now, before = dict(self._solids), state.solids
        for name in [name for name, own in now.items() if before.get(name) is not own]:
            self._neighbours.remove(name)
        for own in [own for name, own in before.items() if now.get(name) is not own]:
            self._show(own)
        self._solids.replace(before)
        self.bricks.replace(state.bricks)
        self.touching.replace(state.touching)
        self.supports.replace(state.supports)
        self.carried.replace(state.carried)
        self.cores.replace(state.cores)
        self.weights.replace(state.weights)
        self.across_gaps.replace(state.across_gaps)
        self.joined.replace(state.joined)
        self.applied.replace(state.applied)
        self.ties.replace(state.ties)
        self._turn.replace(state.turn)
        self._turns = count(max([next(self._turns), *(turn + 1 for turn in state.turn.values())]))

    def by_turn(self, bricks: Iterable[BodyId]) -> list[BodyId]:
        """Return bricks in the order in which their cores were computed: each after those that its core depends on."""
        return sorted(bricks, key=self._turn.__getitem__)

    def upwards(self, bricks: Iterable[BodyId]) -> list[BodyId]:
        """Return bricks by the height of their centres, ties by name."""
        return sorted(bricks, key=lambda name: (self.bricks[name].pose.position_W[2], name))

    def with_all_above(self, roots: Iterable[BodyId]) -> set[BodyId]:
        """Return these bricks and all bricks that they can carry, directly or through others."""
        return reached(roots, lambda brick: self.carried[brick])

    def component(self, brick: BodyId) -> set[BodyId]:
        """Return all bricks connected with a brick by contacts among bricks."""
        return reached([brick], lambda name: [other for other in self.touching[name] if other in self.bricks])

    def spread(self, group: Collection[BodyId], at_least: int) -> set[BodyId]:
        """Return a group extended by its neighbours, step by step, to a minimum size or to all connected bricks."""
        larger, front = set(group), set(group)
        while front and len(larger) < at_least:
            touched = {other for name in front for other in self.touching[name] if other in self.bricks}
            front = touched - larger
            larger |= front
        return larger

    def below(self, bricks: Iterable[BodyId]) -> set[BodyId]:
        """Return the bricks that can carry one of these directly."""
        return {c.lower for brick in bricks for c in self.supports[brick] if c.lower in self.bricks}

    def contacts_of(self, group: Collection[BodyId]) -> list[Contact]:
        """Return all contacts of a group, each once, in the order of the group; those that joints add come last."""
        contacts: dict[int, Contact] = {}  # by identity, which both bodies share
        for brick in group:
            for contact in chain(*self.touching[brick].values()):
                contacts[id(contact)] = contact
        if not self.joined:
            return list(contacts.values())
        pairs = dict.fromkeys((contact.lower, contact.upper) for contact in contacts.values())
        return [*contacts.values(), *(added for pair in pairs for added in self.joined.get(pair, ()))]

    def problem(self, group: Sequence[BodyId], contacts: Sequence[Contact]) -> Problem:
        """Return the equilibrium problem of a group under its weight and the loads on it.

        Its ties have the tension with which they were put on.
        """
        add_work(BRICK * len(group))
        loads = {brick: self._load(brick) for brick in group}
        applied = {brick: self.applied[brick] for brick in group if brick in self.applied} if self.applied else {}
        bricks = {brick: self.bricks[brick] for brick in group}
        if not (applied and self.ties):
            return Problem(bricks, contacts, loads, applied)
        own = {name: wrench for name in applied if (wrench := self.loads.wrench(bricks[name])) is not None}
        pulled = {name: wrench for name in applied if (wrench := self._pulled(bricks[name])) is not None}
        return Problem(bricks, contacts, loads, own, pulled)

    def tied_problem(self, group: Sequence[BodyId], contacts: Sequence[Contact]) -> Problem:
        """Return the problem of a group with the tension of its ties unknown, up to their strength."""
        problem = self.problem(group, contacts)
        ties = [tie for tie in self.ties.values() if tie is not None and tie.is_ranged]
        unknown = []
        for tie in sorted(ties, key=lambda each: each.name):
            placed = {name: problem.bricks[name] for name in tie.around if name in problem.bricks}
            pulls = {name: pull for name, each in sorted(placed.items()) if (pull := tie.pull_on(each)) is not None}
            if pulls:
                unknown.append(UnknownTension(tie.name, pulls, tie.tension, tie.strength))
        return replace(problem, ties=tuple(unknown)) if unknown else problem

    def _applied_to(self, placed: Placed) -> Wrench | None:
        """Return the loads on a brick and the pulls of ties; None if there are none."""
        loads, pulls = self.loads.wrench(placed), self._pulled(placed)
        return loads if pulls is None else pulls if loads is None else loads.plus(pulls)

    def _pulled(self, placed: Placed) -> Wrench | None:
        """Return the pulls of ties on a brick, at the tension with which they were put on; None if there are none."""
        if not self.ties:
            return None
        name = placed.brick.id
        ties = sorted((tie for tie in self.ties.values() if tie is not None), key=lambda tie: tie.name)
        return Loads(tuple(load for tie in ties for load in tie.loads() if load.brick == name)).wrench(placed)

    def _load(self, brick: BodyId) -> Wrench:
        """Return the weight of a brick with the loads on it."""
        applied = self.applied.get(brick) if self.applied else None
        if applied is None:
            return Wrench((0.0, 0.0, -self.weights[brick].weight))
        placed = self.bricks[brick]
        return Wrench(add(applied.force_W, (0.0, 0.0, -placed.brick.mass * self.gravity)), applied.torque_W)

    def _own_weight(self, placed: Placed) -> VerticalLoad:
        x, y, _ = placed.pose.position_W
        return VerticalLoad(placed.brick.mass * self.gravity, (x, y))

    def _upright(self, placed: Placed) -> VerticalLoad | None:
        """Return all loads on a brick as one vertical force downwards; None if they are none."""
        own = self._own_weight(placed)
        if (applied := self.applied.get(placed.brick.id)) is None:
            return own
        (across, along, up), (tx, ty, tz) = applied.force_W, applied.torque_W
        total = own.weight - up
        if across != 0.0 or along != 0.0 or tz != 0.0 or not total > 0.0:
            return None
        x, y = own.at
        return VerticalLoad(total, (x + ty / total, y - tx / total))

    def is_upright(self, brick: BodyId) -> bool:
        """Return whether the loads on a brick are a vertical force downwards, which is that in `weights`."""
        return brick not in self.applied or self._upright(self.bricks[brick]) is not None

    def is_pushed(self, brick: BodyId) -> bool:
        """Return whether loads push a brick, or one that is connected with it, other than vertically downwards."""
        pushed = {name for name in self.applied if not self.is_upright(name)}
        return bool(pushed) and not pushed.isdisjoint(self.component(brick))

    def rests_on(self, group: Collection[BodyId]) -> Mapping[BodyId, list[BodyId]]:
        """Return for each brick of a group the bricks of the group that carry it."""
        return {brick: [c.lower for c in self.supports[brick] if c.lower in group] for brick in group}


# Names the bodies that overlap too much to count as touching, for the reason of a verdict.


MILLIMETRES = 1000.0


def overlap_in_words(structure: Structure, brick: BodyId) -> str:
    """Return the deepest overlap of a brick in words; empty if no overlap is too deep to count as touching."""
    placed = structure.bricks[brick]
    shape, pose, share = placed.brick.shape, placed.pose, structure.tolerances.gap
    thickness = shape.least_thickness
    overlaps = [
        (-apart_from_plane(shape, pose, plane).gap, plane.id, reach_between(thickness, share=share))
        for plane in structure.planes
    ]
    for other in structure.neighbours(brick):
        reach = reach_between(thickness, other.brick.shape.least_thickness, share)
        overlaps.append((-apart(shape, pose, other.brick.shape, other.pose).gap, other.brick.id, reach))
    depth, deepest = max(((depth, other) for depth, other, reach in overlaps if depth > reach), default=(0.0, ""))
    if not deepest:
        return ""
    return f"{brick} is {MILLIMETRES * depth:.3g} mm inside {deepest}, too deep to count as contact"
