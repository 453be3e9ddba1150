"""Corrects PyBullet's contact normals: rebuilds stale manifolds, and rounds the edges of leaning bricks."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from math import cos, hypot, inf, radians, sqrt
from typing import Protocol

from stability.engines.edge_normals import FACE_ON, BoxPair, agreement, leans, nearest_of, velocity_at
from stability.engines.pybullet.binding import pybullet
from stability.engines.pybullet.bodies import ALL, ROUNDED, SHARP, BrickBodies
from stability.engines.pybullet.groups import JoinedGroups
from stability.geometry.box import Box, as_box
from stability.geometry.box_distance import Block, block
from stability.geometry.vectors import dot, multiply, norm, scale, subtract, turn_between
from stability.model import BodyId, BodyState, Brick, ContactPoint, Pose, Quaternion, Vec3
from stability.work_limit import POINT, add_work

# Contacts of a brick are found anew after it has turned, so that their normals are right.
#
# PyBullet keeps a contact point with the normal that it had at first for as long as the point does not drift, and two
# bricks that turn together do not drift. A body that is put into its collision group again is forgotten by all that
# touches it, in microseconds. Of a hull only one point a step is found: the others are found by looking at it turned to
# and fro by less than anything is told apart by.


STALE = radians(4.0)  # a brick that has turned so far since its contacts were found has them found anew
WRONG = cos(radians(5.0))  # of the angle from a normal to the true one: below it, contacts are found anew as well
# What is awake is looked at after so long [s], or when it may have moved by the rounding of its edges.
AGAIN = 0.004
STILL = 10.0  # [1/s] in such roundings: of what is slower normals hardly change
CLOSE = 0.02  # of such a rounding: what comes so near in the next step may press
# Share of gravity: the turning times the slip above which a point that has slid is found anew at every step. It
# presses where it was found, and not where the edge is: what slides over one tips too fast (docs/design/hits.md).
LEFT_OUT = 0.2
# In an engine: of more only those that lean are looked at, where they press, since where one of hundreds comes to lie
# is chance, and to look at all takes as long as their steps (docs/design/engines.md).
MOST_BODIES = 200
ALIKE = 2.0  # times the mass of the lightest that touches: what is heavier is not left to one point alone
# Half of how far a hull is turned to and fro, about each corner of a tetrahedron: its end goes by two micrometres of a
# plank, as contacts are told apart by one.
TURN = 1e-5
TO_AND_FRO: tuple[Quaternion, ...] = tuple(
    (TURN * x, TURN * y, TURN * z, 1.0) for x, y, z in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
)


@dataclass(slots=True)
class _Seen:
    """A brick at a look, with what is worked out of it once."""

    state: BodyState
    brick: Brick
    _block: Block | None = field(default=None, init=False)

    @property
    def block(self) -> Block:
        """The box that it is."""
        if self._block is None:
            self._block = block(as_box(self.brick.shape, "PyBullet").size, self.state.pose)
        return self._block


@dataclass
class FreshContacts:
    """Knows how each brick lay when its contacts were found, and when it may have turned too far since."""

    bricks: BrickBodies
    groups: JoinedGroups
    _found: dict[BodyId, Pose] = field(default_factory=dict, init=False)
    _due: dict[BodyId, float] = field(default_factory=dict, init=False)  # when to look at a brick before the next look

    def see(self, states: Mapping[BodyId, BodyState], until: float) -> None:
        """Take in all bricks that are awake by themselves; they will be seen again at a time on the clock [s]."""
        self._found = {name: self._found.get(name, state.pose) for name, state in states.items()}
        self._due = {}
        self.bricks.let_go.clear()
        self._renew(states, until, {})  # some may have got other bodies since they were asked

    def look(self, until: float) -> None:
        """Look before a step at those that turn fast, or were just let go; all will be seen again at a time [s]."""
        now = self.bricks.stepper.time
        due = [name for name, when in self._due.items() if when <= now]
        for name in due:
            del self._due[name]
        due += [name for name in self.bricks.let_go if name in self.bricks.own.bricks and name not in due]
        self.bricks.let_go.clear()
        awake = [name for name in due if self._moves_by_itself(name)]
        if awake:
            states = self.bricks.states(awake)
            self._found |= {name: state.pose for name, state in states.items() if name not in self._found}
            own = self.bricks.own.bricks
            self._renew(states, until, {name: _Seen(state, own[name]) for name, state in states.items()})

    def _renew(self, states: Mapping[BodyId, BodyState], until: float, seen: dict[BodyId, _Seen]) -> None:
        """Find contacts anew of all of these that have wrong ones; boxes that touch others on edges become hulls."""
        anew: list[BodyId] = []
        mistaken: dict[BodyId, None] = {}
        crowd = self._crowd()
        for name, state in states.items():
            lasts, slid_off = inf, False
            if self.bricks.maker.settings.fresh_edges and self._is_box(name) and (not crowd or leans(state.pose)):
                wrong, lasts = self._seen_edges(name, state, seen)
                leaning = [each for each, pose in wrong if leans(pose)]
                mistaken |= dict.fromkeys(leaning)
                slid_off = bool(wrong) and not leaning
            turned = turn_between(self._found[name], state.pose)
            stale = turned > STALE and self._may_lose_its_forces(name)
            if name in mistaken or stale or slid_off:
                anew.append(name)
                self._found[name] = state.pose
                turned = turn_between(state.pose, state.pose)
            turning, left = norm(state.angular_velocity_W), STALE - turned if turned <= STALE else inf
            when = self.bricks.stepper.time + (min(lasts, left / turning) if turning > 0.0 else lasts)
            if when < until:
                self._due[name] = when
        rounding = [name for name in mistaken if name not in self.bricks.rounded and self._moves_by_itself(name)]
        for name in rounding:
            self.bricks.swap(name)
        find_all_points(self.bricks, rounding)
        find_contacts_anew(self.bricks, [name for name in anew if name not in rounding])

    def _crowd(self) -> bool:
        return len(self.bricks.bodies.numbers) > MOST_BODIES

    def _may_lose_its_forces(self, name: BodyId) -> bool:
        """Whether it does no harm that it is held by fewer points at first: by all of them at once, or no heavy one."""
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

    def _seen_edges(
        self, name: BodyId, state: BodyState, seen: dict[BodyId, _Seen]
    ) -> tuple[list[tuple[BodyId, Pose]], float]:
        """The bricks of contacts with wrong normals, and how long the others may stay right [s].

        Of what is seen again before the next step anyway, it is not found for how much less long.
        """
        own, maker, time = self.bricks.own.bricks, self.bricks.maker, self.bricks.stepper.time
        crowd, mine, radius = self._crowd(), self._as_seen(name, state, seen), maker.edge_radius(own[name])
        speed, next_step = norm(state.velocity_W), time + maker.settings.time_step
        again = inf if crowd and not leans(state.pose) else AGAIN  # what lies still may be hit
        if speed < STILL * radius:
            return [], again
        wrong, lasts = list[tuple[BodyId, Pose]](), min(again, radius / speed)
        pairs = dict[tuple[BodyId, BodyId], BoxPair]()
        # What would be wrong in the middle of a step is looked at before that, but in a crowd.
        ahead, gravity = (0.0, 0.0) if crowd else (maker.settings.time_step, maker.gravity)
        for point, other, its in self._on_boxes(name, seen):
            slip_W = subtract(velocity_at(state, point.position_W), velocity_at(its.state, point.position_W))
            slip = norm(slip_W)
            if point.slid > CLOSE * radius and not crowd:
                turning = norm(subtract(state.angular_velocity_W, its.state.angular_velocity_W))
                if turning * slip > LEFT_OUT * gravity:
                    wrong += [(name, state.pose), (other, its.state.pose)]
                    continue
            if point.normal_force <= 0.0:
                parting = dot(slip_W, point.normal_BA_W) * (1.0 if point.a == name else -1.0)
                # The gap that is told is that of before the engine's last step.
                near = point.gap + parting * self.bricks.stepper.part - CLOSE * radius
                presses_in = _takes(near, -parting, gravity)
                if presses_in > ahead:
                    lasts = min(lasts, presses_in - ahead)
                    continue  # it presses on nothing, and will not in the next step
            if (point.a, point.b) not in pairs:
                blocks = (mine.block, its.block) if point.a == name else (its.block, mine.block)
                pairs[point.a, point.b] = BoxPair(*blocks)
            found = agreement(point, pairs[point.a, point.b], min(radius, maker.edge_radius(own[other])))
            if found.cosine < WRONG:
                wrong += [(name, state.pose), (other, its.state.pose)]
            if time + lasts > next_step:
                lasts = min(lasts, _takes(found.holds_for, slip, gravity) - ahead)
        return wrong, lasts

    def _as_seen(self, name: BodyId, state: BodyState, seen: Mapping[BodyId, _Seen]) -> _Seen:
        known = seen.get(name)
        return known if known is not None and known.state is state else _Seen(state, self.bricks.own.bricks[name])

    def _on_boxes(self, name: BodyId, seen: dict[BodyId, _Seen]) -> Iterator[tuple[ContactPoint, BodyId, _Seen]]:
        """The points at which a brick touches others that are boxes, since hulls are rounded all over, with these.

        In a crowd those at which it presses.
        """
        own, crowd = self.bricks.own.bricks, self._crowd()
        for point in self.groups.touching(name, self.bricks.stepper.time):
            other = point.b if point.a == name else point.a
            if point.a not in own or point.b not in own or not self._is_box(other):
                continue
            if point.normal_force <= 0.0 and crowd:
                continue
            if other not in seen:
                seen[other] = _Seen(self.groups.states([other])[other], own[other])
            add_work(POINT)
            yield point, other, seen[other]


def _takes(way: float, speed: float, acceleration: float) -> float:
    """How long a way takes [s] from a speed, with an acceleration along it; infinitely, if there is neither."""
    if way <= 0.0:
        return 0.0
    at_end = sqrt(speed * speed + 2.0 * acceleration * way)
    return 2.0 * way / (speed + at_end) if speed + at_end > 0.0 else inf


def find_contacts_anew(bricks: BrickBodies, names: Collection[BodyId]) -> None:
    """Forget all that touches some bricks, and find it as they lie; what it pressed with is forgotten as well."""
    touching = [name for name in names if bricks.bodies.raw_contacts(name)]
    for name in touching:
        group = ROUNDED if bricks.maker.settings.half_spaces and name in bricks.rounded else SHARP
        bricks.maker.meet([bricks.bodies.numbers[name]], group, ALL)
    find_all_points(bricks, [name for name in touching if name in bricks.rounded])


def find_all_points(bricks: BrickBodies, hulls: Collection[BodyId]) -> None:
    """Find more than one point at which each of some hulls touches others."""
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


# A brick that comes to lean on another edge on edge gets rounded edges.
#
# PyBullet finds the normal of sharp edges that cross, but takes a face for edges that run along each other. It cannot
# give a body another shape, so the brick gets another body: in the same place, with the same motion and mass. What the
# last step pressed with is forgotten with the old one, which is why only those bricks change that must.


LOOK = 0.02  # [s] between looks at how bricks lie to each other
ALONG = cos(radians(1.0))  # edges run along each other within this; beyond, the normal of sharp ones is right
NEAR = 0.25  # share of its smallest side: a brick that is so close to another may touch it before the next look
# [s] So long ahead a brick that moves gets rounded edges, so that the forces that its foot loses with the old body are
# back by then. Of 144 pairs of planks that are tipped against each other, 34 slip with 10 ms, 8 with 40 ms.
AHEAD = 0.04
ROUNDED_SHARE = 0.05  # share of its smallest side by which a box is rounded to see how it lies to others
SLOW, SLOWLY = 5e-3, 0.1  # [m/s], [rad/s]: what lies square and is not faster gets sharp edges again


@dataclass(frozen=True, slots=True, eq=False)
class _SeenPair:
    """A brick as it is at a look."""

    state: BodyState
    block: Block

    @property
    def fastest(self) -> float:
        """No point of it is faster [m/s]."""
        reach = norm(self.block.reach)
        return norm(self.state.velocity_W) + reach * norm(self.state.angular_velocity_W)


class Reshaper(Protocol):
    """Decides which bricks get other edges."""

    def reshape(self, states: Mapping[BodyId, BodyState]) -> None:
        """Look how all bricks that are awake lie to each other, and swap the bodies of some."""


@dataclass
class EdgeReshaper:
    """Gives bricks that lean on each other edge on edge rounded edges, and what lies square sharp ones again."""

    bricks: BrickBodies
    groups: JoinedGroups

    def reshape(self, states: Mapping[BodyId, BodyState]) -> None:
        """Give every brick that is awake the edges that it needs."""
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
        """What a brick is, if it is one that has edges of two kinds: a hull always has rounded ones."""
        shape = self.bricks.own.bricks[name].shape
        return shape if isinstance(shape, Box) else None

    def _seen(self, state: BodyState, box: Box) -> _SeenPair:
        return _SeenPair(state, block(box.size, state.pose))

    def _edge_on(self, leaning: Mapping[BodyId, _SeenPair]) -> set[BodyId]:
        """Those whose edges are about to meet edges of another brick that run along them."""
        found: set[BodyId] = set()
        for name, one in leaning.items():
            thin = self.bricks.own.bricks[name].shape.least_thickness
            for other in self.groups.neighbours(name, NEAR * thin + AHEAD * one.fastest):
                if other not in self.bricks.own.bricks or (other in leaning and other < name):
                    continue  # every pair once
                box = self._box(other)
                if box is None:
                    continue
                two = leaning.get(other) or self._seen(self.groups.states([other])[other], box)
                if _edges_meet(one, two, NEAR * thin, ROUNDED_SHARE * thin):
                    found |= {name, other}
        return found


@dataclass
class EdgeWatch:
    """Looks every now and then how the bricks that are awake lie, and at once after one was put elsewhere."""

    bricks: BrickBodies
    reshaper: Reshaper
    fresh: FreshContacts
    _next_look: float = field(default=0.0, init=False)  # [s] on the clock

    def look(self) -> None:
        """Look before a step, if it is time to."""
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
            bricks.planes.reach_beyond(bricks.own.bricks[name], state.pose.position_W)
        self.reshaper.reshape(states)
        self.fresh.see(states, self._next_look)


def _slow(state: BodyState) -> bool:
    return hypot(*state.velocity_W) < SLOW and hypot(*state.angular_velocity_W) < SLOWLY


def _edges_meet(a: _SeenPair, b: _SeenPair, near: float, radius: float) -> bool:
    """Whether bricks will soon touch with edges that run along each other, and with no face."""
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
    """Whether boxes that are turned alike lie side by side, by more than a rounding."""
    between = subtract(a.p_WC, b.p_WC)
    gaps = sorted(abs(dot(between, axis)) - _extent(a, axis) - _extent(b, axis) for axis in a.axes_W)
    return gaps[1] < -radius


def _extent(box: Block, direction_W: Vec3) -> float:
    return sum(abs(dot(half_edge, direction_W)) for half_edge in box.half_edges_W)


def _edge_across(box: Block, normal_W: Vec3) -> Vec3:
    """The direction of the edges of a box that are most across a normal."""
    return min(box.axes_W, key=lambda axis: abs(dot(axis, normal_W)))
