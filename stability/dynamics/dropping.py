"""Dropping: what nothing is under falls straight down, and rests where it lands if that is proven: without an engine.

Bricks that touch each other, and nothing else, fall as one, however they are heaped: no contact bears anything on the
way. A landing is taken as perfectly plastic, as all hits here are: everything stops at once if impulses within the
friction cones balance the momentum of every brick (Moreau). These are the equations of statics with momenta in place of
weights, so a proof that the heap stands where it lands is one that it stops there. What stood before has no momentum,
and its weight is no help against a blow: it is asked with next to none.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import hypot, inf, sqrt

from stability.contact_law import GivenFriction
from stability.dynamics.contact_points import DOWN, LEVEL, Crowd
from stability.geometry.placed_shape import apart_from_plane, reach_W
from stability.graph import components
from stability.model import AT_REST, BodyId, BodyState, Brick, Plane, Pose
from stability.problem import Placed, Stability, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.structure import Structure

STRAIGHT = 1e-9  # [m/s]: what differs by less moves alike, or not at all
WEIGHTLESS = 1e-6  # share of its mass with which a brick that stood is asked whether it bears a blow
BESIDE = 0.1  # share of its centre's height above its foot by which a blow may come beside the centre of a brick
# An engine takes over so many steps before a landing that is not proven: by then it is seen what is about to be hit.
STEPS_BEFORE = 4.0


@dataclass(eq=False)
class DroppingPart:
    """Bricks that fall as one."""

    bricks: Sequence[Placed]  # where they were at time 0 of the drop
    speed: float  # downwards, at time 0 [m/s]
    room: float = inf  # how far they fall until they meet what stands [m]

    def find_room(self, below: Crowd, planes: Collection[Plane] = ()) -> None:
        """See what more is below."""
        for placed in self.bricks:
            self.room = min([self.room, *(depth for _, depth in below.below(placed))])
            for plane in planes:
                if (rise := plane.normal_W[2]) > LEVEL:
                    gap = apart_from_plane(placed.brick.shape, placed.pose, plane).gap
                    self.room = min(self.room, max(0.0, gap) / rise)

    def fallen(self, time: float, gravity: float) -> float:
        """How far it has come by a time [m]."""
        return (self.speed + 0.5 * gravity * time) * time

    def lands_at(self, gravity: float) -> float:
        """When it meets what stands [s]."""
        if self.room in (0.0, inf):
            return self.room
        return 2.0 * self.room / (self.speed + sqrt(self.speed * self.speed + 2.0 * gravity * self.room))

    def lowered(self, depth: float) -> list[Placed]:
        """Its bricks, so far below where they were [m]."""
        return [replace(placed, pose=_lowered(placed.pose, depth)) for placed in self.bricks]


@dataclass
class Dropping:
    """All that moves in a world, while all of it drops."""

    parts: list[DroppingPart]  # that fall
    dropped: Crowd  # all that moves, where it was at time 0
    part_of: Mapping[BodyId, DroppingPart]
    standing: Crowd  # what stands, and what has landed
    planes: Sequence[Plane]
    friction: GivenFriction  # of brick on brick
    gravity: float  # [m/s2]
    clear: float = inf  # until then no part catches up with another one [s]
    time: float = 0.0  # [s]
    count: Callable[[int], None] = lambda _: None  # called with the number of bricks in each proof of a landing
    _proven: DroppingPart | None = None  # that stops where it lands, if nothing lands before
    _at_rest: dict[BodyId, BodyState] = field(default_factory=dict)
    _landed: list[BodyId] = field(default_factory=list)  # and nobody has asked

    def goes_on(self, duration: float) -> bool:
        """Fall for a short time [s]; False, and not at all, if it is not known how."""
        now = self.time + duration
        seen = now + STEPS_BEFORE * duration
        if not self.parts or self.clear <= seen:
            return False
        while self.parts and (at := self._next().lands_at(self.gravity)) <= seen:
            if not self._stops(self._next()):
                return False
            if at > now:
                break
            self._land(self._next())
        self.time = now
        return True

    def states(self) -> Mapping[BodyId, BodyState]:
        """Where its bricks are, and how they move."""
        states = dict(self._at_rest)
        for part in self.parts:
            velocity_W = (0.0, 0.0, -part.speed - self.gravity * self.time)
            for placed in part.lowered(part.fallen(self.time, self.gravity)):
                states[placed.brick.id] = BodyState(placed.pose, velocity_W, AT_REST)
        return states

    def take_landed(self) -> Sequence[BodyId]:
        """The bricks that have come to rest since this was asked last."""
        landed, self._landed = self._landed, []
        return landed

    def _next(self) -> DroppingPart:
        return min(self.parts, key=lambda part: part.lands_at(self.gravity))

    def _stops(self, part: DroppingPart) -> bool:
        """Whether all of a part is proven to stop at once where it lands, and all that it lands on to bear it."""
        if self._proven is not part:
            down = part.lowered(part.room)
            below = [replace(other, brick=_weightless(other)) for other in self.standing.connected(down)]
            self.count(len(down) + len(below))
            assembly = Assembly(self.planes, self.friction, self.gravity, overlap=inf)
            verdict = assembly.add_all([*down, *below], names_smallest=False)
            holds = verdict.stability is Stability.STABLE and all(_is_amid(assembly, placed) for placed in down)
            self._proven = part if holds else None
        return self._proven is part

    def _land(self, part: DroppingPart) -> None:
        self.parts.remove(part)
        self._proven = None
        landed, now = part.lowered(part.room), part.lands_at(self.gravity)
        self.clear = _until_one_catches_up(self.parts)
        falling = {placed.brick.id for other in self.parts for placed in other.bricks}
        for placed in landed:
            for name, depth in self.dropped.above(placed, falling) if falling else ():
                other = self.part_of[name]
                if depth >= other.fallen(now, self.gravity):  # or it has come past by now
                    other.room = min(other.room, depth)
            self.standing.add(placed)
            self._landed.append(placed.brick.id)
            self._at_rest[placed.brick.id] = BodyState(placed.pose, AT_REST, AT_REST)


def dropping_of(
    moving: Mapping[BodyId, tuple[Placed, BodyState]],
    others: Sequence[Placed],
    planes: Sequence[Plane],
    friction: GivenFriction,
    gravity: float,
) -> Dropping | None:
    """How all that moves drops; None if not all of it does, straight down and without a turn."""
    if not all(_drops_straight(placed, state) for placed, state in moving.values()):
        return None
    crowd = Crowd(others)
    structure = Structure(tuple(planes), (), friction, gravity, Tolerances())
    for placed, _ in moving.values():
        structure.put(placed)
    for name in sorted({name for placed, _ in moving.values() for name in crowd.around(placed)}):
        structure.put(crowd.bricks[name])
    parts: list[DroppingPart] = []
    part_of: dict[BodyId, DroppingPart] = {}
    for names in components(moving, lambda name: structure.touching[name]):
        bricks = [moving[name][0] for name in sorted(names)]
        speeds = [-moving[name][1].velocity_W[2] for name in names]
        if max(speeds) - min(speeds) > STRAIGHT or any(_is_borne(structure, name, names) for name in names):
            return None
        parts.append(DroppingPart(bricks, min(speeds)))
        parts[-1].find_room(crowd, planes)
        part_of |= dict.fromkeys(names, parts[-1])
    dropped = Crowd(placed for placed, _ in moving.values())
    return Dropping(parts, dropped, part_of, crowd, planes, friction, gravity, _until_one_catches_up(parts))


def _drops_straight(placed: Placed, state: BodyState) -> bool:
    x, y, z = state.velocity_W
    return max(hypot(x, y), z, placed.brick.shape.bounding_radius * hypot(*state.angular_velocity_W)) <= STRAIGHT


def _is_borne(structure: Structure, name: BodyId, part: Collection[BodyId]) -> bool:
    """Whether a brick touches something beyond its part that is more than a wall beside it."""
    return any(
        abs(normal[2]) > LEVEL
        for other, contact in structure.touching[name].items()
        if other not in part
        for normal in contact.normals_W
    )


def _until_one_catches_up(parts: Sequence[DroppingPart]) -> float:
    """When the first part meets a slower one in the air, where nothing bears it [s]."""
    if len({part.speed for part in parts}) == 1:
        return inf
    speed = {placed.brick.id: part.speed for part in parts for placed in part.bricks}
    everything = Crowd(placed for part in parts for placed in part.bricks)
    return min(
        (
            depth / (part.speed - speed[other])
            for part in parts
            for placed in part.bricks
            for other, depth in everything.below(placed)
            if speed[other] < part.speed
        ),
        default=inf,
    )


def _is_amid(assembly: Assembly, placed: Placed) -> bool:
    """Whether a blow is borne through the centre of a brick, and a little beside it: nothing lands quite flat."""
    x, y, _ = placed.pose.position_W
    height = reach_W(placed.brick.shape, placed.pose, DOWN)
    return assembly.core_depth(placed.brick.id, (x, y)) >= BESIDE * height


def _lowered(pose: Pose, depth: float) -> Pose:
    x, y, z = pose.position_W
    return replace(pose, position_W=(x, y, z - depth))


def _weightless(placed: Placed) -> Brick:
    return replace(placed.brick, mass=WEIGHTLESS * placed.brick.mass)
