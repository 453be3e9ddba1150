"""What touches a brick is found anew when the brick has turned, so that contacts have the normals that they should.

PyBullet keeps a contact point with the normal that it had at first for as long as the point does not drift, and two
bricks that turn together do not drift. A body that is put into its collision group again is forgotten by all that
touches it, in microseconds. Of a hull only one point a step is found: the others are found by looking at it turned to
and fro by less than anything is told apart by.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from math import cos, inf, radians, sqrt

from stability.engines.edge_normals import BoxPair, agreement, leans, velocity_at
from stability.engines.pybullet.body_making import ALL, ROUNDED, SHARP
from stability.engines.pybullet.brick_bodies import BrickBodies
from stability.engines.pybullet.joined_groups import JoinedGroups
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.geometry.rotations import multiply, turn_between
from stability.geometry.separation import Block, block
from stability.geometry.vectors import dot, norm, subtract
from stability.model import BodyId, BodyState, Brick, ContactPoint, Pose, Quaternion
from stability.shapes.box import Box, as_box

STALE = radians(4.0)  # a brick that has turned so far since its contacts were found has them found anew
WRONG = cos(radians(5.0))  # of the angle from a normal to the true one: below it, contacts are found anew as well
# What is awake is looked at after so long [s], or when it may have moved by the rounding of its edges.
AGAIN = 0.004
STILL = 10.0  # [1/s] in such roundings: of what is slower normals hardly change
CLOSE = 0.02  # of such a rounding: what comes so near in the next step may press
# Share of gravity: the turning times the slip above which a point that has slid is found anew at every step. It
# presses where it was found, and not where the edge is: what slides over one tips too fast (docs/decisions/0079).
LEFT_OUT = 0.2
# In an engine: of more only those that lean are looked at, where they press, since where one of hundreds comes to lie
# is chance, and to look at all takes as long as their steps (docs/decisions/0075).
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
