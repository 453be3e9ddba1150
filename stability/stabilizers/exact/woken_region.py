"""Finds the bricks that a hit wakes, those that ride along as rigid groups, and the loads that press on them."""

from collections import defaultdict
from collections.abc import Collection, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import dist
from typing import Self

from stability.contacts.bodies import solid
from stability.contacts.detection import contact_between
from stability.dynamics.rigid_body import AppliedForce
from stability.engines.protocol import AcceptsForces, Engine, Joining
from stability.geometry.placed_shape import apart
from stability.geometry.vectors import add, dot, norm, scale, turn_between
from stability.graph import components, reached
from stability.model import BodyId, BodyState, ContactPoint, Pose, Vec3
from stability.problem import Contact, Placed, Tolerances, by_place
from stability.stabilizers.exact.candidates import release_until_stable
from stability.stabilizers.protocol import BrickObserver
from stability.statics.assembly import Assembly
from stability.statics.certificate import Tally

# Bricks that ride along: they are joined into one rigid body while it hardly moves, and one of them is watched.


MOVED = 0.25  # share of the smallest side, 2 mm for a plank: further than that, a group is taken apart
FEWEST = 3  # bricks: making a rigid body of fewer is not worth it
TURNED = 0.0175  # [rad], 1 deg: a group that has turned further is taken apart


@dataclass(frozen=True, slots=True)
class RidingGroup:
    """Bricks that ride as one."""

    starts: Mapping[BodyId, Pose]  # where they stood, from the lowest on
    touching: Mapping[BodyId, Collection[BodyId]]  # who touched whom there
    furthest: float  # that it may move [m]

    @property
    def first(self) -> BodyId:
        """The brick that is watched for the whole group."""
        return next(iter(self.starts))


@dataclass
class RigidGroups(BrickObserver):
    """The joined bricks of one engine, in groups, each watched through its first brick."""

    joiner: Joining | None  # None if nothing ever rides
    _groups: dict[BodyId, RidingGroup] = field(default_factory=dict, init=False)  # by the first of its members
    _first: dict[BodyId, BodyId] = field(default_factory=dict, init=False)  # of the group of each rider

    def __contains__(self, brick: object) -> bool:
        return brick in self._first

    @property
    def bricks(self) -> frozenset[BodyId]:
        """All bricks that ride."""
        return frozenset(self._first)

    def weld(self, starts: Mapping[BodyId, Pose], touching: Mapping[BodyId, Collection[BodyId]], side: float) -> None:
        """Let bricks ride as one, from where they stand; `side` is their smallest [m]."""
        lowest = sorted(starts, key=lambda brick: starts[brick].position_W[::-1])
        self._form(RidingGroup({brick: starts[brick] for brick in lowest}, touching, MOVED * side))

    def _form(self, group: RidingGroup) -> None:
        if self.joiner is None:
            raise TypeError("this engine joins no bricks")
        self.joiner.weld(tuple(group.starts))
        self._groups[group.first] = group
        self._first |= dict.fromkeys(group.starts, group.first)

    def release(self, brick: BodyId) -> None:
        """Let a brick, and those that touch it, move one by one; what else rode with it rides on, in parts."""
        group = self._groups[self._first[brick]]
        self.unweld(brick)
        left = {name for name in group.starts if name != brick and name not in group.touching[brick]}
        for part in components(left, lambda name: group.touching[name]):
            if len(part) >= FEWEST:
                self._form(replace(group, starts={name: pose for name, pose in group.starts.items() if name in part}))

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Take apart the group of a brick; these are its bricks."""
        if self.joiner is not None:
            self.joiner.unweld(brick)
        return self._strike(brick)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """An engine that removes a brick takes apart the group in which it rode."""
        for brick in bricks:
            if brick in self:
                self._strike(brick)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._groups |= other._groups
        self._first |= other._first

    def _strike(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Strike the group of a brick from the record; these are its bricks."""
        group = self._groups.pop(self._first[brick])
        for member in group.starts:
            del self._first[member]
        return tuple(group.starts)

    def watched(self, awake: Iterable[BodyId]) -> list[BodyId]:
        """The bricks to watch: those that move one by one, and the first of each group."""
        return [brick for brick in awake if self._first.get(brick, brick) == brick]

    def members(self, first: BodyId) -> tuple[BodyId, ...]:
        """The bricks of the group that a watched brick stands for, or the brick alone."""
        return tuple(self._groups[first].starts) if first in self._groups else (first,)

    def moved_too_far(self, states: Mapping[BodyId, BodyState]) -> list[BodyId]:
        """The first bricks of the groups that have moved too far to be taken for rigid."""
        return [
            first
            for first, group in self._groups.items()
            if dist(states[first].pose.position_W, group.starts[first].position_W) > group.furthest
            or turn_between(group.starts[first], states[first].pose) > TURNED
        ]


# Finds the bricks that a hit wakes, and those that ride along on them.
#
# The bricks that are struck move, with those that stand in line behind them, as good as side by side, and all that
# touch these. What these carry presses on them with its weight, so it cannot stay frozen; but as long as it does not
# change its shape it moves as one rigid body, true to its mass and inertia. All else stays frozen until it is reached
# itself.
#
# A rigid body bridges what gives way below a part of it, where bricks would sag. So in a wall nothing rides: a group
# must lie on what carries it with each of its lowest bricks alike, as a level of a tower does. What a wall carries may
# stand without the bricks that are struck, and then needs not be woken (see `waking`).


IN_LINE = 0.7  # cosine between a hit and the normal of a contact through which it goes on as it is
# Share of the smallest side, a millimetre for a plank: a brick that is hit closes such a gap within the very step.
BEHIND = 0.125
SIDEWAYS = 0.5  # vertical part of a normal up to which bricks stand side by side
LEVEL = 1.0 - 1e-6  # vertical part of a normal; on a contact that is less level no group may ride


@dataclass(frozen=True, slots=True)
class Region:
    """The bricks that a disturbance wakes, by name."""

    one_by_one: tuple[BodyId, ...]
    riding: tuple[tuple[BodyId, ...], ...]  # rigid groups
    lined: tuple[BodyId, ...]  # of those that move one by one: the struck, and those in line behind them
    in_wall: bool  # whether much of what moves one by one would ride if it lay on the rest as a level of a tower does


def region(assembly: Assembly, struck: Mapping[BodyId, Vec3], ride: bool) -> Region:
    """What moves when bricks of an assembly are struck, each along a direction [unit, W]; `ride` if any may do so."""
    lined: set[BodyId] = set()
    for brick, along_W in struck.items():
        lined |= reached([brick], lambda name, along_W=along_W: _behind(assembly, name, along_W))  # type: ignore[misc]
    core = lined | {other for brick in lined for other in touching(assembly, brick)}
    above = assembly.with_all_above(core) - core
    between = above & assembly.with_all_below(core)  # they carry part of the core, so they do not keep their place
    groups = components(above - between, lambda name: touching(assembly, name))
    large = [group for group in groups if len(group) >= FEWEST]
    riding = [group for group in large if ride and _may_ride(assembly, group)]
    return Region(
        _upwards(assembly, (core | above).difference(*riding)),
        tuple(_upwards(assembly, group) for group in riding),
        _upwards(assembly, lined),
        in_wall=len(riding) < len(large),
    )


def _upwards(assembly: Assembly, bricks: Collection[BodyId]) -> tuple[BodyId, ...]:
    """In an order of places: an engine that is told of bricks in the order of their names would round by these."""
    return tuple(sorted(bricks, key=lambda name: by_place(assembly.bricks[name])))


def _behind(assembly: Assembly, brick: BodyId, along_W: Vec3) -> list[BodyId]:
    """The bricks that stand beside a brick in line with a hit."""
    own = assembly.bricks[brick]
    within, found = BEHIND * own.brick.shape.least_thickness, []
    for name in assembly.around(brick, within):
        other = assembly.bricks[name]
        between = apart(own.brick.shape, own.pose, other.brick.shape, other.pose)
        sideways = abs(between.normal_BA_W[2]) < SIDEWAYS and abs(dot(between.normal_BA_W, along_W)) > IN_LINE
        if sideways and between.gap <= within:
            found.append(name)
    return found


def touching(assembly: Assembly, brick: BodyId) -> dict[BodyId, Contact]:
    """The other bricks that touch a brick."""
    found = {c.lower if c.upper == brick else c.upper: c for c in assembly.contacts(brick)}
    return {other: contact for other, contact in found.items() if other in assembly.bricks}


def _may_ride(assembly: Assembly, group: Collection[BodyId]) -> bool:
    """Whether a group lies flat on what carries it, each of its lowest bricks on all of that."""
    supports: dict[BodyId, set[BodyId]] = defaultdict(set)
    for brick in group:
        for contact in assembly.contacts(brick):
            other = contact.lower if contact.upper == brick else contact.upper
            if other not in group:
                supports[brick].add(other)
                if any(abs(n[2]) < LEVEL for n in contact.normals_W):
                    return False
    return len({frozenset(others) for others in supports.values()}) <= 1


# Takes out of an assembly what a hit wakes, and what cannot stand without it.
#
# In a wall what lies above a brick mostly stands without it, and is proven to. Then the brick that is struck is woken
# alone, and what stays frozen presses on it with the forces of the proof (`dead_loads`): what a hit costs is what it
# reaches. Where something falls without it, bricks that are few are all woken, down to what they lie on: beside bricks
# as firm as frozen ones are, those that move carry too little.


FEW = 40  # bricks whose motion costs about a second for a second
MOSTLY = 0.5  # share of a region that stands without what is struck, or it is woken whole


@dataclass(frozen=True, slots=True)
class Woken:
    """Bricks that an assembly has released, and how they move on."""

    placed: Mapping[BodyId, Placed]  # as they stood
    riding: tuple[tuple[BodyId, ...], ...] = ()  # those that do not move one by one, as rigid groups
    touched: Mapping[BodyId, Collection[BodyId]] = field(default_factory=dict)  # whom those touched that ride
    forces: Tally | None = None  # with which they carried what stays frozen; None if they carried nothing of it


def wake(assembly: Assembly, reached: Region, presses: bool) -> Woken:
    """Release a region from an assembly; `presses` if frozen bricks can press on woken ones."""
    before = dict(assembly.bricks)
    released: set[BodyId] = set()
    if presses and reached.in_wall:
        forces = assembly.forces_above(reached.lined)
        few = len(reached.one_by_one) <= FEW
        released = _released(assembly, reached.lined, names_smallest=few)
        if len(released) <= (len(reached.lined) if few else MOSTLY * len(reached.one_by_one)):
            return Woken(_in_order(before, released), forces=forces)
    touched = {brick: sorted(touching(assembly, brick)) for group in reached.riding for brick in group}
    released |= _released(assembly, {*reached.one_by_one, *touched} - released, names_smallest=True)
    return Woken(_in_order(before, released), reached.riding, touched)


def _released(assembly: Assembly, bricks: Collection[BodyId], names_smallest: bool) -> set[BodyId]:
    """Take bricks out of an assembly, and what cannot stand without them; these are they."""
    verdict = assembly.remove(bricks, names_smallest=names_smallest)
    return {*bricks, *release_until_stable(assembly, verdict, names_smallest=names_smallest).released}


def _in_order(before: Mapping[BodyId, Placed], bricks: Collection[BodyId]) -> dict[BodyId, Placed]:
    return {brick: before[brick] for brick in sorted(bricks, key=lambda name: by_place(before[name]))}


# Loads of frozen bricks on woken ones: the forces of the last proof.
#
# What lies above a brick in the middle of a wall stands without it if it has to, as an arch, and so it stays frozen
# when the brick is hit. But it lies on that brick with all its weight, and friction under this weight is what holds the
# brick. To an engine a frozen brick has no weight, so its force is exerted in its stead, where the two are in touch,
# with its friction, for as long as they are. It keeps its size: what is frozen does not follow what gives way, and does
# not shift its weight elsewhere before it has lost its support.


NOTHING: Vec3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class DeadLoad:
    """What a frozen brick presses on a woken one with."""

    by: Placed
    size: float  # along the normal of their contact [N]
    friction: float  # Coulomb coefficient

    def on(self, carrying: Placed) -> list[AppliedForce]:
        """What acts on the brick that carries, where it is; nothing where the two are not in touch any more."""
        contact = contact_between(solid(carrying), solid(self.by), self.friction, Tolerances())
        if contact is None:
            return []
        down_W = _normal(contact, seen_from=self.by.brick.id)
        force_W = scale(self.size / len(contact.points_W), down_W)
        return [AppliedForce(force_W, at_W, self.friction) for at_W in contact.points_W]


@dataclass
class DeadLoads(BrickObserver):
    """The loads of frozen bricks on the woken ones of one engine."""

    engine: Engine
    presser: AcceptsForces | None  # None: what is frozen presses with nothing
    _carrying: dict[BodyId, Placed] = field(default_factory=dict, init=False)  # woken bricks, where they were frozen
    _loads: dict[BodyId, list[DeadLoad]] = field(default_factory=dict, init=False)  # by the brick that carries them

    def take_over(self, forces: Tally, woken: Iterable[Placed], frozen: Mapping[BodyId, Placed]) -> None:
        """Bricks are woken that carried frozen ones with these forces."""
        for placed in woken:
            loads = list(_loads_on(placed.brick.id, forces, frozen))
            if loads and self.presser is not None:
                self._loads[placed.brick.id], self._carrying[placed.brick.id] = loads, placed

    def exert(self) -> None:
        """Tell the engine what acts in the coming step."""
        if self.presser is None or not self._loads:
            return
        for brick, state in self._states().items():
            carrying = replace(self._carrying[brick], pose=state.pose)
            self.presser.apply_forces(brick, [each for load in self._loads[brick] for each in load.on(carrying)])

    def reactions(self) -> Mapping[BodyId, list[ContactPoint]]:
        """What the woken bricks press back with on the frozen ones that they still carry."""
        found: dict[BodyId, list[ContactPoint]] = defaultdict(list)
        for brick, state in self._states().items():
            carrying = replace(self._carrying[brick], pose=state.pose)
            for load in self._loads[brick]:
                by = load.by.brick.id
                for each in load.on(carrying):
                    size = norm(each.force_W)
                    found[by].append(
                        ContactPoint(by, brick, each.at_W, scale(-1.0 / size, each.force_W), 0.0, size, NOTHING)
                    )
        return found

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._loads |= other._loads
        self._carrying |= other._carrying

    def _states(self) -> Mapping[BodyId, BodyState]:
        return self.engine.states(sorted(self._loads))

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """What is frozen carries by its proof."""
        for brick in bricks:
            self._loads.pop(brick, None)
            self._carrying.pop(brick, None)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """What is woken presses by its own weight."""
        self._leave_out(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """What is gone neither presses nor carries."""
        self.frozen(bricks)
        self._leave_out(bricks)

    def _leave_out(self, pressing: Container[BodyId]) -> None:
        for brick, loads in self._loads.items():
            self._loads[brick] = [load for load in loads if load.by.brick.id not in pressing]


def _loads_on(brick: BodyId, forces: Tally, frozen: Mapping[BodyId, Placed]) -> Iterator[DeadLoad]:
    """What presses on a brick by the forces of a proof."""
    for contact, at_points in forces.onto(brick):
        up_W, size = _normal(contact, seen_from=brick), 0.0
        for in_cones in at_points:
            for force_W in in_cones:
                size += dot(force_W, up_W)
        if contact.upper in frozen and size > 0.0:
            yield DeadLoad(frozen[contact.upper], size, contact.law.friction)


def _normal(contact: Contact, seen_from: BodyId) -> Vec3:
    """The middle of the normals of a contact [unit, W], away from one of its bodies."""
    total = NOTHING
    for normal in contact.normals_W:
        total = add(total, normal)
    return scale((1.0 if contact.lower == seen_from else -1.0) / norm(total), total)
