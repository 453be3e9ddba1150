"""World of the rigid-body engine, in which bricks can be welded into rigid groups."""

from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import Self

import numpy as np

from stability.contact_law import Friction, GivenFriction, as_friction
from stability.dynamics.rigid_body import AppliedForce, pushed
from stability.dynamics.rigid_group import common_motion, grouped
from stability.engines.bodies import EngineWorld, OwnBodies
from stability.engines.pressing import AppliedLoads
from stability.engines.protocol import NOTHING_PRESCRIBED, Link, MeanLoads, PrescribedMotion, StepClock
from stability.engines.rigid.bodies import BodyRows, single, solids_of
from stability.engines.rigid.mechanics import (
    ACROSS,
    ALONG,
    AT,
    AXES,
    COHESION,
    DRAGGED,
    FIRST,
    FRICTION,
    GAP,
    INVERSE_MASS,
    MOTION,
    NORMAL,
    ON_BODY,
    ON_FIRST,
    ON_OTHER,
    ON_SECOND,
    POSITION,
    PRESSES,
    PULLED,
    REACH,
    RESPONSE,
    RUBS,
    RUBS_ACROSS,
    SECOND,
    SHEAR,
    SPIN,
    TENSION,
    TURN,
    Array,
    Ints,
    Pairs,
    Points,
    Solids,
    advance,
    bounding_boxes,
    carry_over,
    contacts,
    load,
    near_boxes,
    no_links,
    no_pairs,
    no_points,
    placed_corners,
)
from stability.engines.rigid.preparation import tell_if_compiling
from stability.engines.rigid.settings import RigidSettings, Solving
from stability.geometry.box import Box
from stability.geometry.rows import cross_rows
from stability.geometry.vectors import add, add_scaled, cross, dot, norm, rotate, scale, unit
from stability.model import AT_REST, GROUND, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Vec3

# Share of the speed of the fastest body to which a fall is solved: what is off at its start grows, later it does not.
RELATIVE = 3e-4
MOST_HARD = 30  # bodies: the sweeps that hard contacts need grow with the square of the number of courses
FIRST_ROOM = 64
SLACK = 0.2  # edge radii between a body at rest and a body that bears its load
DEPTH = 0.3  # edge radii: largest overlap of bodies at rest at soft points
SAME_PLACE = 5.0  # in units of the least gap of a point: distance within which points keep impulses

tell_if_compiling()  # by the first import, as the first step of a process compiles


@dataclass
class ContactPoints:
    """Contact points of a world, which carry their impulses from step to step."""

    points: Points = field(default_factory=lambda: no_points(FIRST_ROOM), init=False)
    count: int = field(default=0, init=False)
    loaded: int = field(default=0, init=False)  # with the points that bear forces from outside
    _spare: Points = field(default_factory=lambda: no_points(FIRST_ROOM), init=False)
    _pairs: Pairs = field(default_factory=no_pairs, init=False)

    def find(  # noqa: PLR0913, PLR0917 -- of one call of machine code
        self, bodies: BodyRows, solids: Solids, order: Ints, duration: float, near: float, sharp: bool
    ) -> None:
        """Find the points of the next step of a duration [s], up to a gap [m]."""
        count, pairs = contacts(bodies.arrays, solids, self._spare, order, self._pairs, duration, near, sharp)
        if count > len(self._spare.ids):
            self._spare = no_points(2 * count)
            count, pairs = contacts(bodies.arrays, solids, self._spare, order, self._pairs, duration, near, sharp)
        self._pairs = pairs
        carry_over(self._spare, count, self.points, self.count, SAME_PLACE * near)
        self.points, self._spare, self.count = self._spare, self.points, count

    def load(self, bodies: BodyRows, loads: Array, slack: float) -> None:
        """Add points for the next step that bear forces from outside, as `mechanics.load` takes them."""
        if self.count + len(loads) > len(self.points.ids):
            more, count = no_points(self.count + len(loads)), self.count
            more.ids[:count], more.row[:count] = self.points.ids[:count], self.points.row[:count]
            self.points = more
        self.loaded = load(bodies.arrays, self.points, self.count, loads, slack)

    def forget(self, row: int | None = None) -> None:
        """Set the impulses on a body to 0, as its mass changes, or all impulses."""
        index = self.points.ids[: self.count]
        of_body = slice(None) if row is None else (index[:, ON_BODY] == row) | (index[:, ON_OTHER] == row)
        self.points.row[: self.count][of_body, PRESSES : RUBS_ACROSS + 1] = 0.0

    def renumber(self, before: Sequence[BodyId], now: Sequence[BodyId]) -> None:
        """Renumber the solids of the points after a change, and drop the points of removed solids."""
        self._pairs = no_pairs()
        if not self.count:
            return
        numbers = {key: number for number, key in enumerate(_counted(now))}
        renumbered = np.array([numbers.get(key, -1) for key in _counted(before)])
        pairs = self.points.ids[: self.count, : SECOND + 1]
        on_plane = pairs[:, 0] < 0
        first, second = np.where(on_plane, pairs[:, 0], renumbered[pairs[:, 0]]), renumbered[pairs[:, 1]]
        lost = (second < 0) | (~on_plane & ((first < 0) | (first > second)))
        # In the order of `contacts`.
        rows = np.lexsort((np.where(on_plane, -first, second), np.where(on_plane, second, first), ~on_plane))
        rows = rows[~lost[rows]]
        self.count = count = len(rows)
        self.points.ids[:count], self.points.row[:count] = self.points.ids[rows], self.points.row[rows]
        self.points.ids[:count, FIRST], self.points.ids[:count, SECOND] = first[rows], second[rows]


def _counted(names: Sequence[BodyId]) -> list[tuple[BodyId, int]]:
    """Return the bricks of solids, each with the number of the solid among those of the brick."""
    counts: dict[BodyId, int] = defaultdict(int)
    keys = []
    for name in names:
        keys.append((name, counts[name]))
        counts[name] += 1
    return keys


@dataclass(frozen=True, slots=True, eq=False)
class StepRecord:
    """State of a world before a step, and the contact impulses on its bricks during the step."""

    time: float  # [s]
    struck: bool
    bodies: Array
    points: Points
    links: Array
    impulses: Array  # (solids, 6) [N s], and about the centre of each brick [N m s], W


def _frame(normal: Vec3) -> tuple[Vec3, Vec3, Vec3]:
    """Return a unit vector with two tangents."""
    least = min(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), key=lambda axis: abs(dot(axis, normal)))
    along = unit(cross(normal, least))
    return normal, along, cross(normal, along)


def _add_impulses(impulses: Array, ids: Ints, row: Array, centres_W: Array) -> None:
    """Add the impulses of the last sub-step at some points on each brick; the centres are those before it."""
    if not len(ids):
        return
    impulses_W = np.zeros((len(ids), 3))
    for size, axis in ((PRESSES, NORMAL), (RUBS, ALONG), (RUBS_ACROSS, ACROSS)):
        impulses_W += row[:, size, None] * row[:, axis : axis + 3]
    solids, signed_W = np.concatenate((ids[:, SECOND], ids[:, FIRST])), np.concatenate((impulses_W, -impulses_W))
    of_brick = np.flatnonzero(solids >= 0)
    numbers, signed_W = solids[of_brick], signed_W[of_brick]
    arms_W = row[of_brick % len(ids), AT : AT + 3] - centres_W[numbers]
    np.add.at(impulses, numbers, np.hstack([signed_W, cross_rows(arms_W, signed_W)]))


@dataclass
class RigidWorld(EngineWorld):
    """World of bricks and planes; create it by `opened`."""

    settings: RigidSettings
    own: OwnBodies
    gravity: float  # [m/s2] along -z
    friction: Friction
    clock: StepClock
    presses: AppliedLoads = field(default_factory=AppliedLoads, init=False)
    _bodies: BodyRows = field(default_factory=BodyRows, init=False)
    _frozen: set[BodyId] = field(default_factory=set, init=False)
    _guided: set[BodyId] = field(default_factory=set, init=False)  # in the last step
    _solids: Solids | None = field(default=None, init=False)  # None after a change
    _names: tuple[BodyId, ...] = field(default=(), init=False)  # of the brick of each solid
    _numbers: dict[BodyId, list[int]] = field(default_factory=dict, init=False)  # of the solids of each brick
    _order: Ints = field(default_factory=lambda: np.arange(0), init=False)  # of the solids along an axis
    _contacts: ContactPoints = field(default_factory=ContactPoints, init=False)
    _struck: bool = field(default=False, init=False)  # whether a hit has taken place
    _part: float = field(default=1.0, init=False)  # duration of the last sub-step [s]
    _touching: dict[BodyId, list[int]] | None = field(default=None, init=False)  # numbers of points, by body
    _told: dict[int, ContactPoint] = field(default_factory=dict, init=False)  # points that were asked for, by number
    _boxes: Array | None = field(default=None, init=False)  # around the solids
    _states: dict[BodyId, BodyState] = field(default_factory=dict, init=False)  # of bricks, as they were asked for
    _records: bool = field(default=False, init=False)  # whether each step is recorded
    _record: StepRecord | None = field(default=None, init=False)  # of the last step
    _tied: tuple[Link, ...] = field(default=(), init=False)
    _links: Points = field(default_factory=no_links, init=False)  # their impulses carry over from step to step

    @classmethod
    def opened(
        cls, settings: RigidSettings, gravity: float, friction: GivenFriction, heaviest: float | None = None
    ) -> Self:
        """Open an empty world with gravity [m/s2] along -z; `heaviest` has no effect."""
        return cls(settings, OwnBodies(), gravity, as_friction(friction), StepClock(settings))

    def close(self) -> None:
        self._solids = None

    def step(self, prescribed: PrescribedMotion = NOTHING_PRESCRIBED) -> None:
        solids, settings, duration = self._built(), self.settings, self.settings.time_step
        self._guide(prescribed)
        x, y, z = prescribed.acceleration_W
        gravity_W = np.array((-x, -y, -self.gravity - z))
        # The features at which fast bodies touch may change within a step, and a hit may make any body as fast.
        splits = self.clock.pass_step()
        duration /= splits
        falling, struck = settings.falling, settings.struck
        near = 2.0 * settings.edge_radius + duration * self.clock.fastest
        # Hands and moving ground hit what they move.
        self._struck = self._struck or bool(self._guided) or prescribed.acceleration_W != AT_REST
        self._struck = self._struck or len(self._bodies.groups) - len(self._frozen) > MOST_HARD
        relative = RELATIVE * self.clock.fastest
        record = self._record = self._before_step() if self._records else None
        self._tie()
        passed = 0.0
        for _ in range(splits):
            parts = ceil((struck if self._struck else falling).parts / splits)
            self._contacts.find(self._bodies, solids, self._order, duration, near, not self._struck)
            self._contacts.load(self._bodies, self._loads(), SLACK * settings.edge_radius)
            # A recorded step is taken in pieces, as the points keep the impulses of the last sub-step only.
            pieces = 1 if record is None else parts
            for _ in range(pieces):
                centres_W = None if record is None else self._centres()
                self._struck = advance(
                    self._bodies.arrays,
                    self._contacts.points,
                    self._contacts.count,
                    self._contacts.loaded,
                    self._links,
                    (duration / pieces, parts // pieces, passed),
                    (falling.sweeps, max(falling.accuracy, relative)),
                    (struck.sweeps, struck.accuracy),
                    self._struck,
                    settings.hit,
                    settings.recovery,
                    DEPTH * settings.edge_radius,
                    gravity_W,
                )
                passed += duration / pieces
                if record is not None and centres_W is not None:
                    points, count = self._contacts.points, self._contacts.count
                    _add_impulses(record.impulses, points.ids[:count], points.row[:count], centres_W)
                    _add_impulses(record.impulses, self._links.ids, self._links.row, centres_W)
            self._part = duration / parts
            self._moved()

    # --- records of steps, for joined bricks --------------------------------------------------------------------------

    def record_steps(self) -> None:
        self._records = True

    def hit_duration(self) -> float:
        return self.settings.time_step

    def mean_loads(self) -> MeanLoads:
        if self._record is None:
            return {}
        means = self._record.impulses / self.settings.time_step
        loads = {name: means[numbers].sum(axis=0) for name, numbers in self._numbers.items()}
        return {name: tuple(load.tolist()) for name, load in loads.items() if load.any()}

    def undo_step(self) -> None:
        record, self._record = self._record, None
        if record is None:
            raise RuntimeError("the last step was not recorded")
        self.clock.time, self._struck = record.time, record.struck
        self._bodies.arrays[:] = record.bodies
        self._contacts.points, self._contacts.count = record.points, len(record.points.ids)
        self._links.row[:] = record.links
        self._moved()

    def link(self, links: Sequence[Link]) -> None:
        if tuple(links) == self._tied:
            return
        before = dict(zip(self._tied, self._links.row[:, PRESSES : RUBS_ACROSS + 1].copy(), strict=True))
        self._tied, self._links = tuple(links), no_links(len(links))
        for link, row in zip(self._tied, self._links.row, strict=True):
            law = link.law
            row[FRICTION], row[TENSION], row[COHESION], row[SHEAR] = law.friction, law.tension, law.cohesion, law.shear
            row[PRESSES : RUBS_ACROSS + 1] = before.get(link, 0.0)

    def _tie(self) -> None:
        """Place the links for a step."""
        world = len(self._bodies.groups)
        states = self.states({name for link in self._tied for name in (link.lower, link.upper)})
        for number, link in enumerate(self._tied):
            row, ids = self._links.row[number], self._links.ids[number]
            for at, column, end, solid, body in (
                (link.at_lower, ON_FIRST, ON_BODY, FIRST, link.lower),
                (link.at_upper, ON_SECOND, ON_OTHER, SECOND, link.upper),
            ):
                is_fixed = body in self.own.planes
                ids[end], ids[solid] = (world, -1) if is_fixed else (self._bodies.row[body], self._numbers[body][0])
                pose, own = states[body].pose, self._bodies.arrays[ids[end]]
                at_W = at if is_fixed else add(pose.position_W, rotate(pose.orientation, at))
                turn = np.eye(3) if is_fixed else own[AXES:INVERSE_MASS].reshape(3, 3)
                row[column : column + 3] = (np.array(at_W) - own[POSITION:TURN]) @ turn
            is_fixed, turn_W = link.lower in self.own.planes, states[link.lower].pose.orientation
            for axis, column in zip(_frame(link.normal), (NORMAL, ALONG, ACROSS), strict=True):
                row[column : column + 3] = axis if is_fixed else rotate(turn_W, axis)
        self._links.row[:, PULLED : DRAGGED + 1] = 0.0

    def _before_step(self) -> StepRecord:
        """Return a record of the step that begins, whose time has passed already."""
        points, count = self._contacts.points, self._contacts.count
        return StepRecord(
            self.clock.time - self.settings.time_step,
            self._struck,
            self._bodies.arrays.copy(),
            Points(points.ids[:count].copy(), points.row[:count].copy()),
            self._links.row.copy(),
            np.zeros((len(self._names), 6)),
        )

    def _centres(self) -> Array:
        """Return the centre of mass of the brick of each solid in W (n, 3) [m]."""
        rows = [self._bodies.row[name] for name in self._names]
        bodies = self._bodies.arrays[rows]
        places_G = [
            self._bodies.groups[row].places_G[name].position_W for row, name in zip(rows, self._names, strict=True)
        ]
        turned = np.einsum(
            "nij,nj->ni", bodies[:, AXES:INVERSE_MASS].reshape(-1, 3, 3), np.array(places_G).reshape(-1, 3)
        )
        centres: Array = bodies[:, POSITION:TURN] + turned
        return centres

    def _guide(self, prescribed: PrescribedMotion) -> None:
        """Prescribe the motion of guided bricks; those that are guided no longer move freely."""
        for name in self._guided - prescribed.guided.keys():
            if name in self._bodies.row and name not in self._frozen:
                self._bodies.release(self._bodies.row[name])
                self._contacts.forget(self._bodies.row[name])
        self._guided = {*prescribed.guided}
        for name, motion in prescribed.guided.items():
            self._bodies.guide(self._bodies.row[name], motion, self._bodies.state(name))

    def _loads(self) -> Array:
        """Return the forces from outside, as `load` takes them."""
        loads = [
            (self._bodies.row[brick], norm(force.force_W), *unit(force.force_W), *force.at_W, force.friction)
            for brick, forces in self.presses.forces(self)
            for force in forces
        ]
        return np.array(loads, np.float64).reshape(-1, 9)

    def _moved(self) -> None:
        self._touching = self._boxes = None
        self._told.clear()
        self._states.clear()

    def _changed(self) -> None:
        self._solids = None
        self._moved()

    def _built(self) -> Solids:
        """Return the solids of all bricks; build them after a change."""
        if self._solids is None:
            before, planes = self._names, self.own.planes.values()
            self._names, self._solids = solids_of(self._bodies, planes, self.friction, self.settings.edge_radius)
            self._numbers = defaultdict(list)
            for number, name in enumerate(self._names):
                self._numbers[name].append(number)
            self._contacts.renumber(before, self._names)
            self._order = np.arange(len(self._names))
        return self._solids

    # --- changes ------------------------------------------------------------------------------------------------------

    def add_plane(self, plane: Plane) -> None:
        self.own.add_plane(plane)
        self._changed()

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self.own.add_brick(brick)
        self._bodies.add(single(brick, pose), BodyState(pose, velocity_W))
        self._expect_hit(velocity_W)
        self._changed()

    def remove_brick(self, brick: BodyId) -> None:
        self.presses.leave(brick)
        self._part_from_others(brick)
        self._bodies.drop(self._bodies.row[brick])
        self._frozen.discard(brick)
        self.own.remove_brick(brick)
        self._changed()

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        self._part_from_others(brick)
        row = self._bodies.row[brick]
        self._frozen.discard(brick)
        self._bodies.release(row)
        self._bodies.put(row, state.pose)
        self._bodies.move(row, state)
        self._expect_hit(state.velocity_W)
        self._moved()

    def _expect_hit(self, velocity_W: Vec3) -> None:
        """Take contacts as struck before a body in motion hits another; their loads are then shared out anew."""
        if not self._struck and norm(velocity_W) > self.settings.hit:
            self._struck = True
            self._contacts.forget()

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        if len(self._members(brick)) > 1:
            self._push_group(self._bodies.row[brick], np.array(impulse_W), np.array(at_W))
            return
        self.set_state(brick, pushed(self._bodies.state(brick), self.own.bricks[brick], impulse_W, at_W))
        self._changed()  # the order of the contacts

    def _push_group(self, row: int, impulse_W: Array, at_W: Array) -> None:
        """Apply an impulse to a welded group as a whole."""
        body = self._bodies.arrays[row]
        a, b, c, d, e, f = body[RESPONSE:REACH]
        twist_W = np.cross(at_W - body[POSITION:TURN], impulse_W)
        body[MOTION:SPIN] += body[INVERSE_MASS] * impulse_W
        body[SPIN:AXES] += np.array([[a, b, c], [b, d, e], [c, e, f]]) @ twist_W
        x, y, z = body[MOTION:SPIN].tolist()
        self._expect_hit((x, y, z))
        self._changed()

    def apply_forces(self, brick: BodyId, forces: Sequence[AppliedForce]) -> None:
        self.presses.apply_forces(self.own.bricks[brick], self._bodies.state(brick), forces)

    def freeze(self, brick: BodyId) -> None:
        self.presses.leave(brick)
        self._part_from_others(brick)
        self._bodies.hold(self._bodies.row[brick])
        self._frozen.add(brick)
        self._states.clear()

    def holds(self, brick: BodyId) -> bool:
        return brick in self._frozen

    def wake(self, brick: BodyId) -> None:
        self._frozen.discard(brick)
        self._bodies.release(self._bodies.row[brick])

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._bodies.put(self._bodies.row[brick], pose)
        self._moved()

    def weld(self, bricks: Collection[BodyId]) -> None:
        for brick in bricks:
            self.presses.leave(brick)
            self._part_from_others(brick)
        states = self.states(bricks)
        group = grouped((self.own.bricks[brick], states[brick].pose) for brick in bricks)
        motion = common_motion(group, states)
        for brick in bricks:
            self._frozen.discard(brick)
            self._bodies.drop(self._bodies.row[brick])
        self._bodies.add(group, BodyState(group.pose, *motion))
        self._changed()

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        row = self._bodies.row[brick]
        members = self._bodies.groups[row].bricks
        states = self.states(members)
        self._bodies.drop(row)
        for name, member in members.items():
            self._bodies.add(single(member, states[name].pose), states[name])
        self._changed()
        return tuple(members)

    def _part_from_others(self, brick: BodyId) -> None:
        """Unweld the group of a brick, if it is in one."""
        if len(self._members(brick)) > 1:
            self.unweld(brick)

    def _members(self, brick: BodyId) -> Collection[BodyId]:
        return self._bodies.groups[self._bodies.row[brick]].bricks.keys()

    # --- queries ------------------------------------------------------------------------------------------------------

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return {body: self._states.get(body) or self._state(body) for body in bodies}

    def _state(self, body: BodyId) -> BodyState:
        if body in self.own.planes:
            return BodyState(Pose(self.own.planes[body].point_W))
        state = self._states[body] = self._bodies.state(body)
        return state

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        if self._touching is None:
            self._touching = self._by_body()
        return [self._told.get(number) or self._tell(number) for number in self._touching.get(brick, ())]

    def _by_body(self) -> dict[BodyId, list[int]]:
        """Return the points that touch, or almost touch, by brick and plane."""
        row, pairs = self._contacts.points.row, self._contacts.points.ids[: self._contacts.count, : SECOND + 1]
        row, touching = row[: len(pairs)], defaultdict[BodyId, list[int]](list)
        numbers = np.flatnonzero((row[:, PRESSES] > 0.0) | (row[:, GAP] < self.settings.edge_radius))
        for number, (first, second) in zip(numbers.tolist(), pairs[numbers].tolist(), strict=True):
            touching[self._body(first)].append(number)
            touching[self._names[second]].append(number)
        return touching

    def _body(self, number: int) -> BodyId:
        return self._names[number] if number >= 0 else tuple(self.own.planes)[-1 - number]

    def _tell(self, number: int) -> ContactPoint:
        values = self._contacts.points.row[number].tolist()
        first, second = self._contacts.points.ids[number, : SECOND + 1].tolist()
        normal, along, across = ((values[k], values[k + 1], values[k + 2]) for k in (0, 3, 6))
        gap = values[GAP]
        # The point is a corner over a half-space, or in the middle of the gap between two solids.
        at_W = add_scaled((values[AT], values[AT + 1], values[AT + 2]), -(gap if first < 0 else 0.5 * gap), normal)
        rubs_W = add(scale(values[RUBS] / self._part, along), scale(values[RUBS_ACROSS] / self._part, across))
        presses = values[PRESSES] / self._part
        point = ContactPoint(self._names[second], self._body(first), at_W, normal, gap, presses, rubs_W)
        self._told[number] = point
        return point

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        solids = self._built()
        if self._boxes is None:
            self._boxes = bounding_boxes(
                solids.table, placed_corners(self._bodies.arrays, solids.table, solids.corners)
            )
        members, planes = self._members(brick), tuple(self.own.planes)
        near = {
            other
            for number in self._numbers[brick]
            for other in near_boxes(self._boxes, solids.planes, number, within).tolist()
        }
        names = {planes[-1 - number] if number < 0 else self._names[number] for number in near}
        return sorted(name for name in names if name not in members)


def compile_engine() -> None:
    """Compile the engine for this machine, and keep its machine code for this process and all later ones."""
    settings = RigidSettings(
        time_step=0.001,
        most_travel=0.001,
        falling=Solving(1, 1, 1e-3),
        struck=Solving(1, 1, 1e-3),
        hit=0.02,
        recovery=0.05,
        edge_radius=1e-4,
    )
    world = RigidWorld.opened(settings, 9.81, 0.5)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    for name, height in (("lower", 0.5), ("upper", 1.5)):
        world.add_brick(Brick(name, Box((1.0, 1.0, 1.0)), 1.0), Pose((0.0, 0.0, height)))
    world.step()
    world.neighbours("upper", 1.0)
    world.close()
