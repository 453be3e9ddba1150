"""Bricks that a hit wakes, rigid groups that ride on them, and dead loads of frozen bricks on them."""

from collections import defaultdict
from collections.abc import Collection, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import dist
from typing import Self

from stability.contacts.bodies import solid
from stability.contacts.detection import contacts_between
from stability.dynamics.rigid_body import AppliedForce
from stability.engines.protocol import AcceptsForces, Engine, WeldingEngine
from stability.geometry.placed_shape import apart
from stability.geometry.vectors import add, cross, dot, norm, scale, subtract, turn_between
from stability.graph import components, reached
from stability.loads import UNLOADED, Loads
from stability.model import BodyId, BodyState, ContactPoint, Pose, Vec3
from stability.problem import Contact, Placed, Tolerances, Wrench, by_place
from stability.stabilizers.exact.candidates import moved_share, release_until_stable
from stability.stabilizers.protocol import BrickObserver
from stability.statics.assembly import Assembly
from stability.statics.certificate import Tally

# Riding bricks are welded into one rigid body while it hardly moves, and one brick of each group is watched.


MOVED = 0.25  # share of the smallest side, 2 mm for a plank: a group that has moved further is unwelded
FEWEST = 3  # least bricks of a group: welding fewer does not pay
TURNED = 0.0175  # [rad], 1 deg: a group that has turned further is unwelded


@dataclass(frozen=True, slots=True)
class RidingGroup:
    """Bricks welded into one rigid body."""

    starts: Mapping[BodyId, Pose]  # initial poses, from the lowest brick up
    touching: Mapping[BodyId, Collection[BodyId]]  # initial contacts between the bricks
    furthest: float  # largest motion [m]

    @property
    def first(self) -> BodyId:
        """The brick that represents the group."""
        return next(iter(self.starts))


@dataclass
class RigidGroups(BrickObserver):
    """The welded groups of one engine, each represented by its first brick."""

    joiner: WeldingEngine | None  # None if the engine cannot weld
    _groups: dict[BodyId, RidingGroup] = field(default_factory=dict, init=False)  # by first brick
    _first: dict[BodyId, BodyId] = field(default_factory=dict, init=False)  # first brick of the group, by brick

    def __contains__(self, brick: object) -> bool:
        return brick in self._first

    @property
    def bricks(self) -> frozenset[BodyId]:
        """All welded bricks."""
        return frozenset(self._first)

    def weld(self, starts: Mapping[BodyId, Pose], touching: Mapping[BodyId, Collection[BodyId]], side: float) -> None:
        """Weld bricks at their poses; `side` is their smallest side [m]."""
        lowest = sorted(starts, key=lambda brick: starts[brick].position_W[::-1])
        self._form(RidingGroup({brick: starts[brick] for brick in lowest}, touching, MOVED * side))

    def _form(self, group: RidingGroup) -> None:
        if self.joiner is None:
            raise TypeError("this engine cannot weld bricks")
        self.joiner.weld(tuple(group.starts))
        self._groups[group.first] = group
        self._first |= dict.fromkeys(group.starts, group.first)

    def release(self, brick: BodyId) -> None:
        """Release a brick and those that touch it from their group; weld the connected parts of the rest again."""
        group = self._groups[self._first[brick]]
        self.unweld(brick)
        remaining = {name for name in group.starts if name != brick and name not in group.touching[brick]}
        for part in components(remaining, lambda name: group.touching[name]):
            if len(part) >= FEWEST:
                self._form(replace(group, starts={name: pose for name, pose in group.starts.items() if name in part}))

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Unweld the group of a brick; return its bricks."""
        if self.joiner is not None:
            self.joiner.unweld(brick)
        return self._drop(brick)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Drop the groups of removed bricks, which the engine has unwelded."""
        for brick in bricks:
            if brick in self:
                self._drop(brick)

    def absorb(self, other: Self) -> None:
        """Take over the records of another instance."""
        self._groups |= other._groups
        self._first |= other._first

    def _drop(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Drop the group of a brick; return its bricks."""
        group = self._groups.pop(self._first[brick])
        for member in group.starts:
            del self._first[member]
        return tuple(group.starts)

    def watched(self, awake: Iterable[BodyId]) -> list[BodyId]:
        """Return the bricks to watch: single bricks, and the first of each group."""
        return [brick for brick in awake if self._first.get(brick, brick) == brick]

    def members(self, first: BodyId) -> tuple[BodyId, ...]:
        """Return the bricks that a watched brick represents: its group, or itself."""
        return tuple(self._groups[first].starts) if first in self._groups else (first,)

    def moved_too_far(self, states: Mapping[BodyId, BodyState]) -> list[BodyId]:
        """Return the first bricks of the groups that have moved too far to stay welded."""
        return [
            first
            for first, group in self._groups.items()
            if dist(states[first].pose.position_W, group.starts[first].position_W) > group.furthest
            or turn_between(group.starts[first], states[first].pose) > TURNED
        ]


# The bricks that a hit wakes, and the groups that ride on them.
#
# The struck bricks wake, with the bricks side by side in line behind them, and all bricks that touch these. The bricks
# above load them and cannot stay frozen; while their arrangement does not change they move as one rigid body with their
# mass and inertia. All other bricks stay frozen until they are disturbed themselves.
#
# A rigid body spans a yielding support where single bricks would sag. So all lowest bricks of a group must rest on the
# same supports, as in a level of a tower; no group forms in a wall. The bricks above in a wall may stand without the
# struck ones, and then stay frozen (see `wake`).


IN_LINE = 0.7  # least cosine between a hit and the normal of a contact that passes it on
# Share of the smallest side, a millimetre for a plank: largest gap that a struck brick closes within the step.
BEHIND = 0.125
SIDEWAYS = 0.5  # largest vertical component of the normal of bricks side by side
LEVEL = 1.0 - 1e-6  # least vertical component of the normal of a contact that a group may ride on


@dataclass(frozen=True, slots=True)
class Region:
    """Bricks that a disturbance wakes."""

    one_by_one: tuple[BodyId, ...]
    riding: tuple[tuple[BodyId, ...], ...]  # rigid groups
    # Among the single bricks: the struck ones and those in line behind them. If some lie on others, also all that touch
    # these, and their courses.
    moving: tuple[BodyId, ...]
    in_wall: bool  # whether a large group above cannot ride, as in a wall


def region(assembly: Assembly, struck: Mapping[BodyId, Vec3], ride: bool) -> Region:
    """Find the bricks that wake when bricks of an assembly are struck, each along a direction [unit, W].

    `ride`: whether groups may form.
    """
    lined: set[BodyId] = set()
    for brick, along_W in struck.items():
        lined |= reached([brick], lambda name, along_W=along_W: _behind(assembly, name, along_W))  # type: ignore[misc]
    core = lined | {other for brick in lined for other in touching(assembly, brick)}
    moving = lined
    if any(_is_piled(contact) for brick in lined for o, contact in touching(assembly, brick).items() if o in lined):
        moving = core = core | reached(lined, lambda name: list(_beside(assembly, name)))
    above = assembly.with_all_above(core) - core
    between = above & assembly.with_all_below(core)  # they carry part of the core, so they cannot ride
    groups = components(above - between, lambda name: touching(assembly, name))
    large = [group for group in groups if len(group) >= FEWEST]
    riding = [group for group in large if ride and _may_ride(assembly, group)]
    return Region(
        _upwards(assembly, (core | above).difference(*riding)),
        tuple(_upwards(assembly, group) for group in riding),
        _upwards(assembly, moving),
        in_wall=len(riding) < len(large),
    )


def _upwards(assembly: Assembly, bricks: Collection[BodyId]) -> tuple[BodyId, ...]:
    """Sort bricks by position, as an order by name would make an engine's rounding depend on names."""
    return tuple(sorted(bricks, key=lambda name: by_place(assembly.bricks[name])))


def _behind(assembly: Assembly, brick: BodyId, along_W: Vec3) -> list[BodyId]:
    """Return the bricks beside a brick in line with a hit."""
    return [name for name, normal_W in _beside(assembly, brick).items() if abs(dot(normal_W, along_W)) > IN_LINE]


def _beside(assembly: Assembly, brick: BodyId) -> dict[BodyId, Vec3]:
    """Return the bricks side by side with a brick, each with the normal between them [unit, W]."""
    own = assembly.bricks[brick]
    within, found = BEHIND * own.brick.shape.least_thickness, {}
    for name in assembly.around(brick, within):
        other = assembly.bricks[name]
        between = apart(own.brick.shape, own.pose, other.brick.shape, other.pose)
        if abs(between.normal_BA_W[2]) < SIDEWAYS and between.gap <= within:
            found[name] = between.normal_BA_W
    return found


def _is_piled(contact: Contact) -> bool:
    """Check that one of two bricks lies on the other."""
    return any(abs(normal[2]) > SIDEWAYS for normal in contact.normals_W)


def touching(assembly: Assembly, brick: BodyId) -> dict[BodyId, Contact]:
    """Return the contacts of a brick with other bricks, by brick."""
    contacts = {c.lower if c.upper == brick else c.upper: c for c in assembly.contacts(brick)}
    return {other: contact for other, contact in contacts.items() if other in assembly.bricks}


def _may_ride(assembly: Assembly, group: Collection[BodyId]) -> bool:
    """Check that all lowest bricks of a group lie flat on the same supports."""
    supports: dict[BodyId, set[BodyId]] = defaultdict(set)
    for brick in group:
        for contact in assembly.contacts(brick):
            other = contact.lower if contact.upper == brick else contact.upper
            if other not in group:
                supports[brick].add(other)
                if any(abs(n[2]) < LEVEL for n in contact.normals_W):
                    return False
    return len({frozenset(others) for others in supports.values()}) <= 1


# Release of the woken bricks from an assembly, with those that cannot stand without them.
#
# In a wall the bricks above a struck brick mostly stand without it, by proof. Then only the struck brick wakes, and the
# frozen bricks press on it with the forces of the proof (`DeadLoads`), so that the cost follows the reach of the hit.
# If bricks fall without it, a small region wakes as a whole, down to its supports: beside rigid frozen bricks the
# moving ones would carry too little.
#
# Struck bricks that lie on each other turn each other and the bricks beside them. Between frozen bricks, which neither
# lift nor give way, they would jam and lose the momentum of the hit. So their courses wake with them.


FEW = 40  # bricks of a small region, whose simulation runs in about real time
MOSTLY = 0.5  # largest released share of a large region; beyond it the whole region wakes


@dataclass(frozen=True, slots=True)
class ReleasedBricks:
    """Bricks that an assembly has released."""

    placed: Mapping[BodyId, Placed]  # at their rest poses
    riding: tuple[tuple[BodyId, ...], ...] = ()  # rigid groups
    touched: Mapping[BodyId, Collection[BodyId]] = field(default_factory=dict)  # contacts of the bricks in groups
    forces: Tally | None = None  # of the proof, on frozen bricks that they carried; None if they carried none


def wake(assembly: Assembly, reached: Region, presses: bool) -> ReleasedBricks:
    """Release a region from an assembly; `presses` if frozen bricks can press on woken ones."""
    before = dict(assembly.bricks)
    touched = {brick: sorted(touching(assembly, brick)) for group in reached.riding for brick in group}
    released: set[BodyId] = set()
    if presses and reached.in_wall:
        forces = assembly.forces_above(reached.moving)
        few = len(reached.one_by_one) <= FEW
        released = _released(assembly, reached.moving, names_smallest=few)
        if len(released) <= (len(reached.moving) if few else MOSTLY * len(reached.one_by_one)):
            return ReleasedBricks(_in_order(before, released), forces=forces)
    released |= _released(assembly, {*reached.one_by_one, *touched} - released, names_smallest=True)
    return ReleasedBricks(_in_order(before, released), reached.riding, touched)


def _released(assembly: Assembly, bricks: Collection[BodyId], names_smallest: bool) -> set[BodyId]:
    """Remove bricks from an assembly, and those that cannot stand without them; return all removed bricks."""
    verdict = assembly.remove(bricks, names_smallest=names_smallest)
    return {*bricks, *release_until_stable(assembly, verdict, names_smallest=names_smallest).released}


def _in_order(before: Mapping[BodyId, Placed], bricks: Collection[BodyId]) -> dict[BodyId, Placed]:
    return {brick: before[brick] for brick in sorted(bricks, key=lambda name: by_place(before[name]))}


# Dead loads of frozen bricks on woken ones: the forces of the last proof.
#
# The bricks above a struck brick in a wall can stand without it, as an arch, so they stay frozen. But their weight
# rests on it, and the friction under this weight holds it. In an engine a frozen brick has no weight, so its contact
# force is applied instead, with friction, while the two are in contact. The force is constant: a frozen brick neither
# follows a yielding support nor redistributes its weight before it loses the support.


NOTHING: Vec3 = (0.0, 0.0, 0.0)
# Share of the smallest side, 8 um for a plank: a brick that has moved less is loaded at the same points. A fortieth of
# the largest gap of a contact, so that the loss of a contact is hardly seen late.
STAYS = 0.001


@dataclass(frozen=True, slots=True)
class DeadLoad:
    """Contact force of a frozen brick on a woken one."""

    by: Placed
    size: float  # along the normal of their contact [N]
    friction: float  # Coulomb coefficient

    def on(self, carrying: Placed) -> list[AppliedForce]:
        """Return the forces on the carrying brick at its current pose; none without contact."""
        contacts = contacts_between(solid(carrying), solid(self.by), self.friction, Tolerances())
        share = self.size / max(sum(len(contact.points_W) for contact in contacts), 1)
        return [
            AppliedForce(scale(share, _normal(contact, seen_from=self.by.brick.id)), at_W, self.friction)
            for contact in contacts
            for at_W in contact.points_W
        ]


@dataclass
class DeadLoads(BrickObserver):
    """The dead loads of frozen bricks on the woken ones of one engine."""

    engine: Engine
    presser: AcceptsForces | None  # None: there are no dead loads
    _carrying: dict[BodyId, Placed] = field(default_factory=dict, init=False)  # woken bricks at their rest poses
    applied: Loads = field(default=UNLOADED, init=False)  # on bricks from outside the scene
    _loads: dict[BodyId, list[DeadLoad]] = field(default_factory=dict, init=False)  # by carrying brick
    # By carrying brick: its pose, and the forces of each load there.
    _forces: dict[BodyId, tuple[Placed, list[tuple[DeadLoad, list[AppliedForce]]]]] = field(
        default_factory=dict, init=False
    )
    _pushed: set[BodyId] = field(default_factory=set, init=False)  # moving bricks with applied loads

    @property
    def are_applied(self) -> bool:
        """True if applied loads act on bricks in motion."""
        return bool(self._pushed)

    def take_over(self, forces: Tally, woken: Iterable[Placed], frozen: Mapping[BodyId, Placed]) -> None:
        """Add the loads on woken bricks that carried frozen ones with these forces."""
        for placed in woken:
            loads = list(_loads_on(placed.brick.id, forces, frozen))
            if loads and self.presser is not None:
                self._loads[placed.brick.id], self._carrying[placed.brick.id] = loads, placed
                self._forces.pop(placed.brick.id, None)

    def add(self, carrying: Placed, load: DeadLoad) -> None:
        """Add the load of a brick that the engine holds on one that it moves."""
        if self.presser is not None:
            self._loads.setdefault(carrying.brick.id, []).append(load)
            self._carrying[carrying.brick.id] = carrying
            self._forces.pop(carrying.brick.id, None)

    def exert(self) -> None:
        """Apply the loads in the engine for the next step."""
        if self.presser is None or not (self._loads or self._pushed):
            return
        forces: defaultdict[BodyId, list[AppliedForce]] = defaultdict(list)
        for brick, by_load in self._forces_by_load():
            forces[brick] += [force for _, on_brick in by_load for force in on_brick]
        for brick, state in self.engine.states(sorted(self._pushed)).items():
            for load in self.applied.on(brick):
                forces[brick] += _as_forces(load.at(state.pose), state.pose)
        for brick, on_brick in forces.items():
            self.presser.apply_forces(brick, on_brick)

    def reactions(self) -> Mapping[BodyId, list[ContactPoint]]:
        """Return the reactions of the woken bricks on the frozen ones, as contact points by frozen brick."""
        points: dict[BodyId, list[ContactPoint]] = defaultdict(list)
        for brick, by_load in self._forces_by_load():
            for load, on_brick in by_load:
                by = load.by.brick.id
                for force in on_brick:
                    size = norm(force.force_W)
                    points[by].append(
                        ContactPoint(by, brick, force.at_W, scale(-1.0 / size, force.force_W), 0.0, size, NOTHING)
                    )
        return points

    def absorb(self, other: Self) -> None:
        """Take over the records of another instance."""
        self._loads |= other._loads
        self._forces |= other._forces
        self._carrying |= other._carrying
        self._pushed |= other._pushed

    def _forces_by_load(self) -> Iterator[tuple[BodyId, list[tuple[DeadLoad, list[AppliedForce]]]]]:
        """Yield the carrying bricks, and the forces of each load on them at their current poses."""
        for brick, state in self.engine.states(sorted(self._loads)).items():
            if brick not in self._forces or moved_share(self._forces[brick][0], state.pose) > STAYS:
                carrying = replace(self._carrying[brick], pose=state.pose)
                self._forces[brick] = carrying, [(load, load.on(carrying)) for load in self._loads[brick]]
            yield brick, self._forces[brick][1]

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Drop the loads on frozen bricks."""
        for brick in bricks:
            self._loads.pop(brick, None)
            self._forces.pop(brick, None)
            self._carrying.pop(brick, None)
            self._pushed.discard(brick)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Drop the loads from woken bricks, which press by their own weight, and apply those on them."""
        self.drop_from(bricks)
        self._pushed.update(brick for brick in bricks if self.applied.on(brick))

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Drop the loads on and from removed bricks."""
        self.frozen(bricks)
        self.drop_from(bricks)

    def drop_from(self, pressing: Container[BodyId]) -> None:
        """Drop the loads of these bricks."""
        for brick, loads in self._loads.items():
            self._loads[brick] = [load for load in loads if load.by.brick.id not in pressing]
            if len(self._loads[brick]) < len(loads):
                self._forces.pop(brick, None)


def _as_forces(load: Wrench, pose: Pose) -> list[AppliedForce]:
    """Return a load as forces at points: one at the centre of mass, and a couple."""
    forces = [AppliedForce(load.force_W, pose.position_W, 0.0)] if norm(load.force_W) > 0.0 else []
    size = norm(load.torque_W)
    if size > 0.0:
        axis_W = scale(1.0 / size, load.torque_W)
        arm_W = cross(axis_W, (1.0, 0.0, 0.0) if abs(axis_W[0]) < abs(axis_W[1]) else (0.0, 1.0, 0.0))
        arm_W = scale(1.0 / norm(arm_W), arm_W)
        # The forces of the couple are 2 m apart: each is half the torque.
        turning_W = scale(0.5 * size, cross(axis_W, arm_W))
        forces.append(AppliedForce(turning_W, add(pose.position_W, arm_W), 0.0))
        forces.append(AppliedForce(scale(-1.0, turning_W), subtract(pose.position_W, arm_W), 0.0))
    return forces


def _loads_on(brick: BodyId, forces: Tally, frozen: Mapping[BodyId, Placed]) -> Iterator[DeadLoad]:
    """Yield the dead loads on a brick from the forces of a proof."""
    for contact, at_points in forces.onto(brick):
        up_W, size = _normal(contact, seen_from=brick), 0.0
        for in_cones in at_points:
            for force_W in in_cones:
                size += dot(force_W, up_W)
        if contact.upper in frozen and size > 0.0:
            yield DeadLoad(frozen[contact.upper], size, contact.law.friction)


def _normal(contact: Contact, seen_from: BodyId) -> Vec3:
    """Return the mean normal of a contact [unit, W], away from one of its bodies."""
    total = NOTHING
    for normal in contact.normals_W:
        total = add(total, normal)
    return scale((1.0 if contact.lower == seen_from else -1.0) / norm(total), total)
