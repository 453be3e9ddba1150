"""Correction of PyBullet's contact normals: rebuilds stale manifolds, and rounds the edges of leaning bricks."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from math import cos, hypot, inf, radians, sqrt
from typing import Protocol

from stability.engines.edge_normals import FACE_ON, BoxPair, agreement, leans, nearest_of, velocity_at
from stability.engines.pybullet.binding import pybullet
from stability.engines.pybullet.bodies import ALL, ROUNDED, SHARP, BrickBodies
from stability.engines.pybullet.groups import WeldedGroups
from stability.geometry.box import Box, as_box
from stability.geometry.box_distance import Block, block
from stability.geometry.vectors import dot, multiply, norm, scale, subtract, turn_between
from stability.model import BodyId, BodyState, Brick, ContactPoint, Pose, Quaternion, Vec3
from stability.work_limit import POINT, add_work

# Contact detection is repeated after a brick has turned, so that its contact normals are correct.
#
# PyBullet keeps the first normal of a contact point until the point drifts, and the points of two bricks that turn
# together do not drift. Setting the collision group of a body again deletes all its contacts, within microseconds. The
# next step finds only one contact point of a hull; detection at slightly rotated poses finds the others.


STALE = radians(4.0)  # rotation of a brick since its contact detection that requires a new one
WRONG = cos(radians(5.0))  # a smaller cosine between a normal and the true one also requires a new detection
# [s] Interval between checks of an awake brick; it is shorter if the brick may have moved by its edge radius.
AGAIN = 0.004
STILL = 10.0  # [1/s] times the edge radius: the normals of a slower brick hardly change
CLOSE = 0.02  # times the edge radius: a gap that is smaller after the next step may carry a force
# Share of gravity. A contact point that has slid is detected again at every step while slip times relative rotation
# is larger: its force acts where it was detected and not at the edge, so bricks tip too fast (docs/design/hits.md).
LEFT_OUT = 0.2
# In a larger engine only the loaded contacts of leaning bricks are checked: a check of all takes as long as the steps,
# and the final place of one of hundreds of bricks is random anyway (docs/design/engines.md).
MOST_BODIES = 200
ALIKE = 2.0  # largest mass ratio of touching bricks at which one contact point may carry them for a step
# Half the angle of the rotations of a hull, about each corner of a tetrahedron: the end of a plank moves by two
# micrometres, and PyBullet merges contact points within one.
TURN = 1e-5
TO_AND_FRO: tuple[Quaternion, ...] = tuple(
    (TURN * x, TURN * y, TURN * z, 1.0) for x, y, z in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
)


@dataclass(slots=True)
class _CheckedBrick:
    """State of a brick at a check, with its cached block."""

    state: BodyState
    brick: Brick
    _block: Block | None = field(default=None, init=False)

    @property
    def block(self) -> Block:
        """Return the brick's box at its pose."""
        if self._block is None:
            self._block = block(as_box(self.brick.shape, "PyBullet").size, self.state.pose)
        return self._block


@dataclass
class ContactRefresher:
    """Poses of the bricks at their contact detection, and the times of their next checks."""

    bricks: BrickBodies
    groups: WeldedGroups
    _detected_at: dict[BodyId, Pose] = field(default_factory=dict, init=False)
    _due: dict[BodyId, float] = field(default_factory=dict, init=False)  # [s] of checks of single bricks

    def see(self, states: Mapping[BodyId, BodyState], until: float) -> None:
        """Check all single bricks that are awake; `until` is the time of the next such check [s]."""
        self._detected_at = {name: self._detected_at.get(name, state.pose) for name, state in states.items()}
        self._due = {}
        self.bricks.let_go.clear()
        self._renew(states, until, {})  # without cached states: some bricks may have new bodies

    def look(self, until: float) -> None:
        """Check the bricks that are due or were just released; `until` is the time of the next check of all [s]."""
        now = self.bricks.stepper.time
        due = [name for name, when in self._due.items() if when <= now]
        for name in due:
            del self._due[name]
        due += [name for name in self.bricks.let_go if name in self.bricks.own.bricks and name not in due]
        self.bricks.let_go.clear()
        awake = [name for name in due if self._moves_by_itself(name)]
        if awake:
            states = self.bricks.states(awake)
            self._detected_at |= {name: state.pose for name, state in states.items() if name not in self._detected_at}
            own = self.bricks.own.bricks
            self._renew(states, until, {name: _CheckedBrick(state, own[name]) for name, state in states.items()})

    def _renew(self, states: Mapping[BodyId, BodyState], until: float, checked: dict[BodyId, _CheckedBrick]) -> None:
        """Repeat the contact detection of bricks with wrong normals; boxes that touch edge on edge become hulls."""
        outdated: list[BodyId] = []
        wrong_bricks: dict[BodyId, None] = {}
        crowd = self._crowd()
        for name, state in states.items():
            lasts, slid_off = inf, False
            if self.bricks.maker.settings.fresh_edges and self._is_box(name) and (not crowd or leans(state.pose)):
                wrong, lasts = self._wrong_edges(name, state, checked)
                leaning = [brick for brick, pose in wrong if leans(pose)]
                wrong_bricks |= dict.fromkeys(leaning)
                slid_off = bool(wrong) and not leaning
            turned = turn_between(self._detected_at[name], state.pose)
            stale = turned > STALE and self._may_lose_its_forces(name)
            if name in wrong_bricks or stale or slid_off:
                outdated.append(name)
                self._detected_at[name] = state.pose
                turned = turn_between(state.pose, state.pose)
            turning, remaining = norm(state.angular_velocity_W), STALE - turned if turned <= STALE else inf
            when = self.bricks.stepper.time + (min(lasts, remaining / turning) if turning > 0.0 else lasts)
            if when < until:
                self._due[name] = when
        rounding = [name for name in wrong_bricks if name not in self.bricks.rounded and self._moves_by_itself(name)]
        for name in rounding:
            self.bricks.swap(name)
        find_all_points(self.bricks, rounding)
        refresh_contacts(self.bricks, [name for name in outdated if name not in rounding])

    def _crowd(self) -> bool:
        return len(self.bricks.bodies.numbers) > MOST_BODIES

    def _may_lose_its_forces(self, name: BodyId) -> bool:
        """Check that a brick may rest on fewer contacts for a step: all are found again, or masses are similar."""
        if self.bricks.maker.settings.fresh_edges:
            return True
        own = self.bricks.own.masses
        points = self.groups.contacts(name, self.bricks.stepper.time)
        masses = [own[body] for point in points for body in (point.a, point.b) if body in own]
        return not masses or max(masses) <= ALIKE * min(masses)

    def _is_box(self, name: BodyId) -> bool:
        return isinstance(self.bricks.own.bricks[name].shape, Box)

    def _moves_by_itself(self, name: BodyId) -> bool:
        return name in self.bricks.bodies.numbers and not self.bricks.holds(name)

    def _wrong_edges(
        self, name: BodyId, state: BodyState, checked: dict[BodyId, _CheckedBrick]
    ) -> tuple[list[tuple[BodyId, Pose]], float]:
        """Return the bricks at contacts with wrong normals, and how long the other normals stay correct [s].

        A duration within the next step is an upper bound: the brick is checked before that step anyway.
        """
        own, maker, time = self.bricks.own.bricks, self.bricks.maker, self.bricks.stepper.time
        crowd, mine, radius = self._crowd(), self._checked(name, state, checked), maker.edge_radius(own[name])
        speed, next_step = norm(state.velocity_W), time + maker.settings.time_step
        again = inf if crowd and not leans(state.pose) else AGAIN  # a resting brick may be hit
        if speed < STILL * radius:
            return [], again
        wrong, lasts = list[tuple[BodyId, Pose]](), min(again, radius / speed)
        pairs = dict[tuple[BodyId, BodyId], BoxPair]()
        # Outside crowds, a normal that would become wrong during a step is checked before that step.
        ahead, gravity = (0.0, 0.0) if crowd else (maker.settings.time_step, maker.gravity)
        for point, other, partner in self._contacts_with_boxes(name, checked):
            slip_W = subtract(velocity_at(state, point.position_W), velocity_at(partner.state, point.position_W))
            slip = norm(slip_W)
            if point.slid > CLOSE * radius and not crowd:
                turning = norm(subtract(state.angular_velocity_W, partner.state.angular_velocity_W))
                if turning * slip > LEFT_OUT * gravity:
                    wrong += [(name, state.pose), (other, partner.state.pose)]
                    continue
            if point.normal_force <= 0.0:
                parting = dot(slip_W, point.normal_BA_W) * (1.0 if point.a == name else -1.0)
                # The engine reports the gap before its last step.
                near = point.gap + parting * self.bricks.stepper.part - CLOSE * radius
                presses_in = _travel_time(near, -parting, gravity)
                if presses_in > ahead:
                    lasts = min(lasts, presses_in - ahead)
                    continue  # the contact carries no force, and will not in the next step
            if (point.a, point.b) not in pairs:
                blocks = (mine.block, partner.block) if point.a == name else (partner.block, mine.block)
                pairs[point.a, point.b] = BoxPair(*blocks)
            fit = agreement(point, pairs[point.a, point.b], min(radius, maker.edge_radius(own[other])))
            if fit.cosine < WRONG:
                wrong += [(name, state.pose), (other, partner.state.pose)]
            if time + lasts > next_step:
                lasts = min(lasts, _travel_time(fit.holds_for, slip, gravity) - ahead)
        return wrong, lasts

    def _checked(self, name: BodyId, state: BodyState, checked: Mapping[BodyId, _CheckedBrick]) -> _CheckedBrick:
        cached = checked.get(name)
        return (
            cached
            if cached is not None and cached.state is state
            else _CheckedBrick(state, self.bricks.own.bricks[name])
        )

    def _contacts_with_boxes(
        self, name: BodyId, checked: dict[BodyId, _CheckedBrick]
    ) -> Iterator[tuple[ContactPoint, BodyId, _CheckedBrick]]:
        """Yield a brick's contact points with boxes, with these boxes; in a crowd only loaded points.

        Contacts with hulls need no check, as all their edges are rounded.
        """
        own, crowd = self.bricks.own.bricks, self._crowd()
        for point in self.groups.touching(name, self.bricks.stepper.time):
            other = point.b if point.a == name else point.a
            if point.a not in own or point.b not in own or not self._is_box(other):
                continue
            if point.normal_force <= 0.0 and crowd:
                continue
            if other not in checked:
                checked[other] = _CheckedBrick(self.groups.states([other])[other], own[other])
            add_work(POINT)
            yield point, other, checked[other]


def _travel_time(distance: float, speed: float, acceleration: float) -> float:
    """Return the time [s] to cover a distance from a speed with an acceleration; infinite if both are 0."""
    if distance <= 0.0:
        return 0.0
    at_end = sqrt(speed * speed + 2.0 * acceleration * distance)
    return 2.0 * distance / (speed + at_end) if speed + at_end > 0.0 else inf


def refresh_contacts(bricks: BrickBodies, names: Collection[BodyId]) -> None:
    """Delete the contacts of some bricks, with their forces, so that they are detected at the current poses."""
    touching = [name for name in names if bricks.bodies.raw_contacts(name)]
    for name in touching:
        group = ROUNDED if bricks.maker.settings.half_spaces and name in bricks.rounded else SHARP
        bricks.maker.set_collision_group([bricks.bodies.numbers[name]], group, ALL)
    find_all_points(bricks, [name for name in touching if name in bricks.rounded])


def find_all_points(bricks: BrickBodies, hulls: Collection[BodyId]) -> None:
    """Detect all contact points of some hulls, by rotating them slightly."""
    client, numbers = bricks.bodies.client, {name: bricks.bodies.numbers[name] for name in hulls}
    if not (numbers and bricks.maker.settings.fresh_edges):
        return
    places = {name: pybullet.getBasePositionAndOrientation(number, client) for name, number in numbers.items()}
    motions = {name: bricks.bodies.raw_motion(name) for name in numbers}
    for turn in TO_AND_FRO:
        for name, (position, orientation) in places.items():
            turned = multiply(orientation, turn)
            pybullet.resetBasePositionAndOrientation(numbers[name], position, turned, physicsClientId=client)
        pybullet.performCollisionDetection(client)
    for name, (position, orientation) in places.items():
        pybullet.resetBasePositionAndOrientation(numbers[name], position, orientation, physicsClientId=client)
        bricks.bodies.set_raw_motion(name, *motions[name])


# A brick that leans on another edge on edge gets rounded edges.
#
# PyBullet finds the normal of sharp edges that cross, but uses a face normal for parallel edges. It cannot change the
# shape of a body, so the brick gets a new body with the same pose, motion and mass. The new body starts without contact
# forces, so only the bricks that need rounded edges change.


LOOK = 0.02  # [s] between checks of all bricks
ALONG = cos(radians(1.0))  # edges within this angle are parallel; beyond it, the normal of sharp edges is correct
NEAR = 0.25  # times the smallest side: a brick this close to another may touch it before the next check
# [s] Lead time of the change to rounded edges before a contact, so that the forces at the foot of the brick have built
# up again. Of 144 pairs of planks that tip against each other, 34 slip with 10 ms, 8 with 40 ms.
AHEAD = 0.04
ROUNDED_SHARE = 0.05  # times the smallest side: edge radius of a box in the check for edge contacts
SLOW, SLOWLY = 5e-3, 0.1  # [m/s], [rad/s] limits below which a brick that lies square gets sharp edges again


@dataclass(frozen=True, slots=True, eq=False)
class _LeaningBrick:
    """State and block of a brick at a check."""

    state: BodyState
    block: Block

    @property
    def fastest(self) -> float:
        """Upper bound of the speed of the brick's points [m/s]."""
        reach = norm(self.block.reach)
        return norm(self.state.velocity_W) + reach * norm(self.state.angular_velocity_W)


class Reshaper(Protocol):
    """Selects the bricks whose edges change."""

    def reshape(self, states: Mapping[BodyId, BodyState]) -> None:
        """Check all awake bricks, and exchange the bodies of some."""


@dataclass
class EdgeReshaper:
    """Rounds the edges of bricks that lean on each other edge on edge; bricks that lie square get sharp ones again."""

    bricks: BrickBodies
    groups: WeldedGroups

    def reshape(self, states: Mapping[BodyId, BodyState]) -> None:
        """Set sharp or rounded edges of every awake brick."""
        rounded = self.bricks.rounded
        leaning = {
            name: self._seen(state, box)
            for name, state in states.items()
            if name not in rounded and (box := self._box(name)) is not None and leans(state.pose)
        }
        edge_on = self._edge_on(leaning)
        lying = {name for name, state in states.items() if name in rounded and self._lies(name, state)}
        swapped = [name for name in states if (name in edge_on and name in leaning) or name in lying]
        for name in swapped:
            self.bricks.swap(name)
        find_all_points(self.bricks, [name for name in swapped if name in rounded])

    def _lies(self, name: BodyId, state: BodyState) -> bool:
        return _slow(state) and self.bricks.planes.lies_square(state.pose, self.bricks.own.bricks[name].shape)

    def _box(self, name: BodyId) -> Box | None:
        """Return the box of a brick; None for a hull, whose edges are always rounded."""
        shape = self.bricks.own.bricks[name].shape
        return shape if isinstance(shape, Box) else None

    def _seen(self, state: BodyState, box: Box) -> _LeaningBrick:
        return _LeaningBrick(state, block(box.size, state.pose))

    def _edge_on(self, leaning: Mapping[BodyId, _LeaningBrick]) -> set[BodyId]:
        """Return the bricks about to touch parallel edges of another brick, with these others."""
        touching: set[BodyId] = set()
        for name, brick in leaning.items():
            thin = self.bricks.own.bricks[name].shape.least_thickness
            for other in self.groups.neighbours(name, NEAR * thin + AHEAD * brick.fastest):
                if other not in self.bricks.own.bricks or (other in leaning and other < name):
                    continue  # every pair once
                box = self._box(other)
                if box is None:
                    continue
                partner = leaning.get(other) or self._seen(self.groups.states([other])[other], box)
                if _edges_meet(brick, partner, NEAR * thin, ROUNDED_SHARE * thin):
                    touching |= {name, other}
        return touching


@dataclass
class EdgeMonitor:
    """Checks the awake bricks periodically, and immediately after a brick was moved."""

    bricks: BrickBodies
    reshaper: Reshaper
    fresh: ContactRefresher
    _next_look: float = field(default=0.0, init=False)  # [s] on the clock

    def look(self) -> None:
        """Check the bricks that are due before a step."""
        bricks, now = self.bricks, self.bricks.stepper.time
        if not bricks.maker.settings.edge_rounding:
            return
        if not (bricks.displaced or now >= self._next_look):
            self.fresh.look(self._next_look)
            return
        self._next_look, bricks.displaced = now + LOOK, False
        single = [name for name in bricks.own.masses if name in bricks.bodies.numbers]
        states = bricks.states([name for name in single if not bricks.holds(name)])
        for name, state in states.items():
            bricks.planes.extend_to(bricks.own.bricks[name], state.pose.position_W)
        self.reshaper.reshape(states)
        self.fresh.see(states, self._next_look)


def _slow(state: BodyState) -> bool:
    return hypot(*state.velocity_W) < SLOW and hypot(*state.angular_velocity_W) < SLOWLY


def _edges_meet(a: _LeaningBrick, b: _LeaningBrick, near: float, radius: float) -> bool:
    """Check that bricks will soon touch along parallel edges and not on a face."""
    alike = sum(abs(dot(x, y)) > ALONG for x in a.block.axes_W for y in b.block.axes_W)
    if alike == 0 or (alike == 3 and _faces_meet(a.block, b.block, 2.0 * radius)):  # noqa: PLR2004 -- all three axes
        return False
    nearest = nearest_of(a.block, b.block, radius)
    if nearest is None:
        return False
    on_a, on_b = nearest
    between = subtract(on_a, on_b)
    distance = norm(between)
    normal = scale(1.0 / distance, between)
    closing = dot(subtract(velocity_at(b.state, on_b), velocity_at(a.state, on_a)), normal)
    if distance > near + 2.0 * radius + AHEAD * max(closing, 0.0):
        return False
    if max(abs(dot(axis, normal)) for axis in (*a.block.axes_W, *b.block.axes_W)) > FACE_ON:
        return False
    return abs(dot(_edge_across(a.block, normal), _edge_across(b.block, normal))) > ALONG


def _faces_meet(a: Block, b: Block, radius: float) -> bool:
    """Check that faces of parallel boxes overlap by more than a radius."""
    between = subtract(a.p_WC, b.p_WC)
    gaps = sorted(abs(dot(between, axis)) - _extent(a, axis) - _extent(b, axis) for axis in a.axes_W)
    return gaps[1] < -radius


def _extent(box: Block, direction_W: Vec3) -> float:
    return sum(abs(dot(half_edge, direction_W)) for half_edge in box.half_edges_W)


def _edge_across(box: Block, normal_W: Vec3) -> Vec3:
    """Return the direction of the edges of a box that is most perpendicular to a normal."""
    return min(box.axes_W, key=lambda axis: abs(dot(axis, normal_W)))
