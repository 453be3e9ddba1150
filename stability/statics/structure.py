"""The bricks of an assembly, what touches what, and the load core of each, kept up to date as bricks come and go."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count

from stability.geometry.neighbours import Neighbours
from stability.geometry.touching import reach_between
from stability.graph import reached
from stability.model import BodyId, Plane
from stability.statics.contacts.touch import Solid, contact_between, contact_with_plane, solid
from stability.statics.facts import Contact, Placed, Problem, Tolerances, Wrench
from stability.statics.load_core import LoadCore, carries_upright, core_of
from stability.statics.propagation import VerticalLoad


@dataclass
class Structure:
    """Bricks and fixed bodies. Cores depend on the order in which bricks came: only earlier ones carry later ones."""

    planes: tuple[Plane, ...]
    tables: tuple[Placed, ...]  # boxes that never move
    friction: float  # Coulomb coefficient of brick on brick
    gravity: float  # [m/s2]
    tolerances: Tolerances
    bricks: dict[BodyId, Placed] = field(default_factory=dict)
    touching: dict[BodyId, dict[BodyId, Contact]] = field(default_factory=dict)  # by brick, then by other body
    supports: dict[BodyId, list[Contact]] = field(default_factory=dict)  # contacts that can press a brick straight up
    carried: dict[BodyId, list[BodyId]] = field(default_factory=dict)  # bricks that a brick can press straight up
    cores: dict[BodyId, LoadCore] = field(default_factory=dict)
    weights: dict[BodyId, VerticalLoad] = field(default_factory=dict)  # the weight of each brick
    _turn: dict[BodyId, int] = field(default_factory=dict)  # in which order their cores were found
    _solids: dict[BodyId, Solid] = field(default_factory=dict)
    _neighbours: Neighbours[BodyId] = field(default_factory=Neighbours)
    _turns: Iterator[int] = field(default_factory=count)

    def __post_init__(self) -> None:
        """Boxes that never move are neighbours like bricks."""
        for placed in self.tables:
            if placed.brick.id not in self._solids:
                self._show(solid(placed))

    def copied(self) -> "Structure":
        """Another with the same bricks, which changes by itself."""
        return replace(
            self,
            bricks=dict(self.bricks),
            touching={name: dict(contacts) for name, contacts in self.touching.items()},
            supports={name: list(contacts) for name, contacts in self.supports.items()},
            carried={name: list(bricks) for name, bricks in self.carried.items()},
            cores=dict(self.cores),
            weights=dict(self.weights),
            _turn=dict(self._turn),
            _solids=dict(self._solids),
            _neighbours=self._neighbours.copied(),
        )

    def _show(self, own: Solid) -> None:
        self._solids[own.id] = own
        self._neighbours.add(own.id, own.low_W, own.high_W)

    def put(self, placed: Placed) -> None:
        """Set a brick in its place, with its contacts and its core."""
        name, (x, y, _) = placed.brick.id, placed.pose.position_W
        own = solid(placed)
        found = [contact_with_plane(own, plane, self.tolerances) for plane in self.planes]
        for other in self._neighbours.around(own.low_W, own.high_W, self._reach(own)):
            found.append(contact_between(own, self._solids[other], self.friction, self.tolerances))
        self.bricks[name] = placed
        self.weights[name] = VerticalLoad(placed.brick.mass * self.gravity, (x, y))
        self.touching[name], self.supports[name], self.carried[name] = {}, [], []
        for contact in found:
            if contact is not None:
                self._join(contact)
        self._show(own)
        self.find_core(name)

    def _reach(self, body: Solid) -> float:
        """As far away as this, something may still touch it [m]."""
        return reach_between(body.shortest, share=self.tolerances.gap)

    def _join(self, contact: Contact) -> None:
        lower, upper = contact.lower, contact.upper
        for body, other in ((lower, upper), (upper, lower)):
            if body in self.bricks:
                self.touching[body][other] = contact
        if upper in self.bricks and carries_upright(contact):
            self.supports[upper].append(contact)
            if lower in self.bricks:
                self.carried[lower].append(upper)

    def find_core(self, brick: BodyId) -> None:
        """Find the core of a brick anew from the bricks whose core is known by now."""
        self._turn[brick] = next(self._turns)
        below = [c for c in self.supports[brick] if c.lower not in self.bricks or c.lower in self.cores]
        self.cores[brick] = core_of(below, self.cores)

    def near(self, brick: BodyId) -> list[Placed]:
        """The other boxes, fixed ones included, that a brick may touch or overlap."""
        fixed = {placed.brick.id: placed for placed in self.tables}
        return [
            self.bricks.get(name) or fixed[name]
            for name in self._neighbours.near(brick, self._reach(self._solids[brick]))
        ]

    def around(self, brick: BodyId, within: float) -> list[BodyId]:
        """The other bricks whose upright boxes come as close as this [m], by name."""
        return [name for name in self._neighbours.near(brick, within) if name in self.bricks]

    def take(self, brick: BodyId) -> None:
        """Take a brick away. The cores of what it carried still count on it: find them anew."""
        for other in self.touching.pop(brick):
            if other in self.bricks:
                del self.touching[other][brick]
                self.supports[other] = [c for c in self.supports[other] if c.lower != brick]
                self.carried[other] = [upper for upper in self.carried[other] if upper != brick]
        for record in (self.bricks, self.supports, self.carried, self.cores, self.weights, self._turn):
            del record[brick]
        self._neighbours.remove(brick)
        del self._solids[brick]

    def by_turn(self, bricks: Iterable[BodyId]) -> list[BodyId]:
        """Bricks in the order in which their cores were found: each after those that its core counts on."""
        return sorted(bricks, key=self._turn.__getitem__)

    def upwards(self, bricks: Iterable[BodyId]) -> list[BodyId]:
        """Bricks by the height of their centres, ties by name."""
        return sorted(bricks, key=lambda name: (self.bricks[name].pose.position_W[2], name))

    def with_all_above(self, roots: Iterable[BodyId]) -> set[BodyId]:
        """These bricks, and all that they can carry, directly or through others."""
        return reached(roots, lambda brick: self.carried[brick])

    def component(self, brick: BodyId) -> set[BodyId]:
        """All bricks that are connected with this one by contacts among bricks."""
        return reached([brick], lambda name: [other for other in self.touching[name] if other in self.bricks])

    def spread(self, group: Collection[BodyId], at_least: int) -> set[BodyId]:
        """A group and its neighbours, theirs and so on, until it is so large or nothing more touches it."""
        larger, front = set(group), set(group)
        while front and len(larger) < at_least:
            touched = {other for name in front for other in self.touching[name] if other in self.bricks}
            front = touched - larger
            larger |= front
        return larger

    def below(self, bricks: Iterable[BodyId]) -> set[BodyId]:
        """The bricks that can carry one of these directly."""
        return {c.lower for brick in bricks for c in self.supports[brick] if c.lower in self.bricks}

    def contacts_of(self, group: Collection[BodyId]) -> list[Contact]:
        """All contacts that a group takes part in, each once, in the order of the group."""
        found: dict[tuple[BodyId, BodyId], Contact] = {}
        for brick in group:
            for contact in self.touching[brick].values():
                found.setdefault((contact.lower, contact.upper), contact)
        return list(found.values())

    def problem(self, group: Sequence[BodyId], contacts: Sequence[Contact]) -> Problem:
        """The equilibrium of a group under its weight."""
        loads = {brick: Wrench((0.0, 0.0, -self.weights[brick].weight)) for brick in group}
        return Problem({brick: self.bricks[brick] for brick in group}, contacts, loads)

    def rests_on(self, group: Collection[BodyId]) -> Mapping[BodyId, list[BodyId]]:
        """Within a group, the bricks that carry each."""
        return {brick: [c.lower for c in self.supports[brick] if c.lower in group] for brick in group}
