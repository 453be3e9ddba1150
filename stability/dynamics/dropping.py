"""Straight drops without an engine: bricks without support fall, and rest where they land if that is proven.

Bricks that touch only each other fall together, in any arrangement: no contact transfers a force on the way. Landings
are perfectly plastic, like all impacts here: all bricks stop if impulses within the friction cones balance the momentum
of every brick (Moreau). These are the equations of statics with momenta in place of weights, so a proof that the bricks
stand where they land proves that they stop there. A brick that stood before has no momentum, and its weight does not
resist an impact, so the proof uses a negligible weight for it.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import hypot, inf, sqrt

from stability.contact_law import GivenFriction
from stability.dynamics.brick_index import DOWN, LEVEL, BrickIndex
from stability.geometry.placed_shape import apart_from_plane, reach_W
from stability.graph import components
from stability.model import AT_REST, BodyId, BodyState, Brick, Plane, Pose
from stability.problem import Placed, Stability, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.structure import Structure

STRAIGHT = 1e-9  # [m/s] tolerance of speeds
WEIGHTLESS = 1e-6  # mass factor of a standing brick in the proof of a landing
BESIDE = 0.1  # offset of an impact from the centre that a brick must withstand, as a share of the centre's height
# The engine takes over this many steps before an unproven landing, in time for the prediction of hits.
STEPS_BEFORE = 4.0


@dataclass(eq=False)
class DroppingPart:
    """Bricks that fall together."""

    bricks: Sequence[Placed]  # at time 0 of the drop
    speed: float  # downwards, at time 0 [m/s]
    room: float = inf  # height of the fall [m]

    def find_room(self, below: BrickIndex, planes: Collection[Plane] = ()) -> None:
        """Reduce the height of the fall to that above these bricks and planes."""
        for placed in self.bricks:
            self.room = min([self.room, *(depth for _, depth in below.below(placed))])
            for plane in planes:
                if (rise := plane.normal_W[2]) > LEVEL:
                    gap = apart_from_plane(placed.brick.shape, placed.pose, plane).gap
                    self.room = min(self.room, max(0.0, gap) / rise)

    def fallen(self, time: float, gravity: float) -> float:
        """Return the distance fallen at a time [m]."""
        return (self.speed + 0.5 * gravity * time) * time

    def lands_at(self, gravity: float) -> float:
        """Return the time of landing [s]."""
        if self.room in (0.0, inf):
            return self.room
        return 2.0 * self.room / (self.speed + sqrt(self.speed * self.speed + 2.0 * gravity * self.room))

    def lowered(self, depth: float) -> list[Placed]:
        """Return the bricks lowered by a distance [m]."""
        return [replace(placed, pose=_lowered(placed.pose, depth)) for placed in self.bricks]


@dataclass
class Dropping:
    """All moving bricks of a world, while all of them drop."""

    parts: list[DroppingPart]  # falling parts
    dropped: BrickIndex  # all moving bricks at time 0
    part_of: Mapping[BodyId, DroppingPart]
    standing: BrickIndex  # standing and landed bricks
    planes: Sequence[Plane]
    friction: GivenFriction  # of brick on brick
    gravity: float  # [m/s2]
    clear: float = inf  # time before which no part catches up with another one [s]
    time: float = 0.0  # [s]
    count: Callable[[int], None] = lambda _: None  # receives the number of bricks in each proof of a landing
    _proven: DroppingPart | None = None  # the part with a proven landing, unless another lands before
    _at_rest: dict[BodyId, BodyState] = field(default_factory=dict)
    _landed: list[BodyId] = field(default_factory=list)  # since the last call of `take_landed`

    def advance(self, duration: float) -> bool:
        """Advance by a short time [s]; return False, without advancing, if a collision or landing is not proven."""
        now = self.time + duration
        look_ahead = now + STEPS_BEFORE * duration
        if not self.parts or self.clear <= look_ahead:
            return False
        while self.parts and (landing := self._next().lands_at(self.gravity)) <= look_ahead:
            if not self._stops(self._next()):
                return False
            if landing > now:
                break
            self._land(self._next())
        self.time = now
        return True

    def states(self) -> Mapping[BodyId, BodyState]:
        """Return the current states of the bricks."""
        states = dict(self._at_rest)
        for part in self.parts:
            velocity_W = (0.0, 0.0, -part.speed - self.gravity * self.time)
            for placed in part.lowered(part.fallen(self.time, self.gravity)):
                states[placed.brick.id] = BodyState(placed.pose, velocity_W, AT_REST)
        return states

    def take_landed(self) -> Sequence[BodyId]:
        """Return the bricks that have come to rest since the last call."""
        landed, self._landed = self._landed, []
        return landed

    def _next(self) -> DroppingPart:
        return min(self.parts, key=lambda part: part.lands_at(self.gravity))

    def _stops(self, part: DroppingPart) -> bool:
        """Check for a proof that a part stops where it lands, and that all bricks below withstand the impact."""
        if self._proven is not part:
            down = part.lowered(part.room)
            below = [replace(other, brick=_weightless(other)) for other in self.standing.connected(down)]
            self.count(len(down) + len(below))
            assembly = Assembly(self.planes, self.friction, self.gravity, overlap=inf)
            verdict = assembly.add_all([*down, *below], names_smallest=False)
            holds = verdict.stability is Stability.STABLE and all(
                _withstands_impact(assembly, placed) for placed in down
            )
            self._proven = part if holds else None
        return self._proven is part

    def _land(self, part: DroppingPart) -> None:
        self.parts.remove(part)
        self._proven = None
        landed, now = part.lowered(part.room), part.lands_at(self.gravity)
        self.clear = _time_of_collision(self.parts)
        falling = {placed.brick.id for other in self.parts for placed in other.bricks}
        for placed in landed:
            for name, depth in self.dropped.above(placed, falling) if falling else ():
                other = self.part_of[name]
                if depth >= other.fallen(now, self.gravity):  # otherwise the part has already passed the brick
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
    """Return the drop of all moving bricks; None unless all fall straight down without rotation."""
    if not all(_drops_straight(placed, state) for placed, state in moving.values()):
        return None
    crowd = BrickIndex(others)
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
        if max(speeds) - min(speeds) > STRAIGHT or any(_is_supported(structure, name, names) for name in names):
            return None
        parts.append(DroppingPart(bricks, min(speeds)))
        parts[-1].find_room(crowd, planes)
        part_of |= dict.fromkeys(names, parts[-1])
    dropped = BrickIndex(placed for placed, _ in moving.values())
    return Dropping(parts, dropped, part_of, crowd, planes, friction, gravity, _time_of_collision(parts))


def _drops_straight(placed: Placed, state: BodyState) -> bool:
    x, y, z = state.velocity_W
    return max(hypot(x, y), z, placed.brick.shape.bounding_radius * hypot(*state.angular_velocity_W)) <= STRAIGHT


def _is_supported(structure: Structure, name: BodyId, part: Collection[BodyId]) -> bool:
    """Check that a brick touches a body outside its part that is no wall beside it."""
    return any(
        abs(normal[2]) > LEVEL
        for other, contacts in structure.touching[name].items()
        if other not in part
        for contact in contacts
        for normal in contact.normals_W
    )


def _time_of_collision(parts: Sequence[DroppingPart]) -> float:
    """Return the time of the first collision of two parts in the air [s]."""
    if len({part.speed for part in parts}) == 1:
        return inf
    speed = {placed.brick.id: part.speed for part in parts for placed in part.bricks}
    everything = BrickIndex(placed for part in parts for placed in part.bricks)
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


def _withstands_impact(assembly: Assembly, placed: Placed) -> bool:
    """Check that a brick withstands an impact through its centre and near it, as no landing is exactly flat."""
    x, y, _ = placed.pose.position_W
    height = reach_W(placed.brick.shape, placed.pose, DOWN)
    return assembly.core_depth(placed.brick.id, (x, y)) >= BESIDE * height


def _lowered(pose: Pose, depth: float) -> Pose:
    x, y, z = pose.position_W
    return replace(pose, position_W=(x, y, z - depth))


def _weightless(placed: Placed) -> Brick:
    return replace(placed.brick, mass=WEIGHTLESS * placed.brick.mass)
