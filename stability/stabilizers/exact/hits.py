"""Detects hits and added loads on frozen bricks, and finds which of them friction absorbs."""

from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil, dist, hypot, sqrt
from typing import Self

from stability.dynamics.rigid_body import pushed
from stability.engines.edge_normals import velocity_at
from stability.engines.protocol import Engine
from stability.geometry.box import Box
from stability.geometry.box_distance import TOUCHING
from stability.geometry.placed_shape import corners_W, reach_W
from stability.geometry.vectors import add, add_scaled, body_axes, dot, inverse, norm, rotate, scale, subtract
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Pose, Vec3, convex
from stability.problem import Placed
from stability.stabilizers.approach import Approaches, Attention, Hit
from stability.stabilizers.exact.candidates import solids
from stability.stabilizers.exact.overload import MOVED, Overloads, slides_before_it_tips
from stability.stabilizers.protocol import BrickObserver, Observers
from stability.stabilizers.rest import LimitsOf
from stability.statics.assembly import Assembly

# Normal forces that clamp a frozen brick between its neighbours above and below, for friction.
#
# They are those of the proof. What lies higher presses too, so the bricks just above a brick are a lower bound, and
# more of them are asked only where it is not enough: what a hit costs does not grow with the height of the wall.


FEWEST = 4  # courses above a brick that are asked first
SIDEWAYS = 0.5  # vertical part of a normal up to which bricks stand side by side
MORE = 1.5  # times the courses that would press enough if each pressed with the weight of one brick


@dataclass
class Holding(BrickObserver):
    """The normal forces on frozen bricks of one engine, kept until a proof may have changed."""

    _known: dict[BodyId, "_Known"] = field(default_factory=dict, init=False)

    def at_least(self, assembly: Assembly, brick: BodyId, enough: float) -> bool:
        """Whether normal forces from above and below come to at least so much in all [N]."""
        known = self._known.setdefault(brick, _Known())
        while known.force < enough and not known.is_all:
            known.ask_more(assembly, brick, enough)
        return known.force >= enough

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Proofs may be others than they were."""
        self._known.clear()

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Likewise, also if none was woken."""
        self._known.clear()

    def gone(self, bricks: Collection[BodyId]) -> None:
        """What pressed on a brick may be gone."""
        self._known.clear()


@dataclass
class _Known:
    """What is known of the normal forces on one brick."""

    force: float = 0.0  # [N]; a lower bound
    courses: int = 0  # above the brick that were asked
    is_all: bool = False  # whether nothing presses on it from higher up

    def ask_more(self, assembly: Assembly, brick: BodyId, enough: float) -> None:
        weight = assembly.bricks[brick].brick.mass * assembly.gravity
        self.courses = max(2 * self.courses, FEWEST, ceil(MORE * enough / (2.0 * weight)))
        above, front = {brick}, {brick}
        for _ in range(self.courses):
            if not front:
                break  # what a block would need of slivers is millions of courses
            front = {upper for lower in front for upper in _carried(assembly, lower)} - above
            above |= front
        self.is_all = not front
        most = sum(assembly.bricks[name].brick.mass for name in above) * assembly.gravity
        if self.is_all and 2.0 * most < enough:
            self.force = max(self.force, weight)  # all of it would not be enough
            return
        pressing = assembly.forces_above([brick], above).onto(brick)
        from_above = sum(norm(force_W) for _, at_points in pressing for in_cones in at_points for force_W in in_cones)
        self.force = 2.0 * from_above + weight


def _carried(assembly: Assembly, brick: BodyId) -> Iterator[BodyId]:
    """The bricks that lie on a brick."""
    for contact in assembly.contacts(brick):
        if contact.lower == brick and any(normal[2] > SIDEWAYS for normal in contact.normals_W):
            yield contact.upper


# Finds hits that friction absorbs before the struck brick has moved. They wake nothing.
#
# A hit is taken as plastic: the two bricks go on with the speed that they share at the point where they meet, and as
# long as the one pushes the other, both are stopped by what rubs on the one that lies in the structure. What is left of
# their energy along the normal, by friction times the mean way of the rubbing faces, is how far that brick goes. Below
# a limit it may as well be held fixed: the other one is stopped by it all the same.


AT_ONCE = TOUCHING  # share of the smallest side: corners no further back than this arrive with the foremost
FLUSH = 0.125  # share of the smallest side: what is so near to a face, and goes on as far as it, covers it
LEVEL = 1.0 - 1e-6  # vertical part of a normal; on a contact that is less level, friction is not all that holds
LEVEL_HIT = 0.02  # vertical part of the normal of a hit that comes from the side
ROUNDING = 1e-9  # of a unit normal
# Of a line that moves in its own plane, the mean speed over the root of the mean square is at least this.
MEAN_BY_ROOT = 0.816


@dataclass(frozen=True, slots=True)
class IncomingBrick:
    """A brick that is about to hit another one."""

    brick: Brick
    state: BodyState


def friction_stops(
    assembly: Assembly, hit: Hit, flying: IncomingBrick, beside: Sequence[Placed], holding: Holding
) -> bool:
    """Whether a hit on a brick of an assembly moves it by less than what counts; `beside`: other bricks near it.

    Of boxes only: what any other solid meets, and how, is left to an engine.
    """
    struck = assembly.bricks[hit.brick]
    if not all(isinstance(brick.shape, Box) for brick in (flying.brick, struck.brick, *(one.brick for one in beside))):
        return False
    contacts = assembly.contacts(hit.brick)
    lies_flat = all(abs(normal[2]) >= LEVEL for contact in contacts for normal in contact.normals_W)
    friction = min([contact.law.friction for contact in contacts], default=0.0)
    if not lies_flat or friction <= 0.0 or not slides_before_it_tips(struck, friction):
        return False
    normal_W, at_W, speed = _as_it_meets(hit, flying, struck, beside)
    if speed <= 0.0:
        return True
    own = _mass_at(flying.brick, flying.state.pose, at_W, normal_W)
    other = _mass_at(struck.brick, struck.pose, _point_hit(struck, at_W, normal_W), normal_W)
    shared = speed * own / (own + other)
    energy = 0.5 * (own + other) * shared * shared
    mean_way = MEAN_BY_ROOT * sqrt(min(1.0, other / struck.brick.mass))  # for a unit of way at the point that is hit
    enough = energy / (mean_way * min(1.0, friction) * MOVED * struck.brick.shape.least_thickness)
    return holding.at_least(assembly, hit.brick, enough)


def _as_it_meets(hit: Hit, flying: IncomingBrick, struck: Placed, beside: Sequence[Placed]) -> tuple[Vec3, Vec3, float]:
    """The normal of a hit [unit, W], the point that meets the struck brick [m, W], and the speed there [m/s].

    Where the next brick lies flush on a face, nothing comes onto the edge of that face: it meets the faces beside it.
    """
    at_W, open_W = _foremost(flying, hit.normal_W), (0.0, 0.0, 0.0)
    for axis_W in body_axes(struck.pose.orientation):
        inwards = dot(hit.normal_W, axis_W)
        outwards_W = scale(-1.0 if inwards > 0.0 else 1.0, axis_W)
        if abs(inwards) > ROUNDING and not _is_covered(struck, beside, at_W, outwards_W):
            open_W = add_scaled(open_W, inwards, axis_W)
    size = norm(open_W)
    if size >= 1.0 - ROUNDING or size <= ROUNDING:
        return hit.normal_W, at_W, hit.speed
    normal_W = scale(1.0 / size, open_W)
    at_W = _foremost(flying, normal_W)
    return normal_W, at_W, dot(velocity_at(flying.state, at_W), normal_W)


def _foremost(flying: IncomingBrick, along_W: Vec3) -> Vec3:
    """The point of a brick that goes ahead along a direction: a corner, or that of several which is most in its way."""
    reached = sorted(((dot(c, along_W), c) for c in corners_W(flying.brick.shape, flying.state.pose)), reverse=True)
    within = AT_ONCE * flying.brick.shape.least_thickness
    ahead = [corner for reach, corner in reached if reach >= reached[0][0] - within]
    centre_W = flying.state.pose.position_W
    if len(ahead) == 1:
        return ahead[0]
    if len(ahead) == 2:  # noqa: PLR2004 -- an edge
        return _on_edge(ahead[0], ahead[1], centre_W, along_W)
    return add_scaled(centre_W, reached[0][0] - dot(centre_W, along_W), along_W)


def _on_edge(one_W: Vec3, other_W: Vec3, centre_W: Vec3, along_W: Vec3) -> Vec3:
    """The point of an edge that passes nearest to a line through the centre."""
    edge, lever = subtract(other_W, one_W), subtract(centre_W, one_W)
    across = add_scaled(edge, -dot(edge, along_W), along_W)
    length = dot(across, across)
    part = dot(lever, across) / length if length > 0.0 else 0.5
    return add_scaled(one_W, max(0.0, min(1.0, part)), edge)


def _is_covered(struck: Placed, beside: Sequence[Placed], at_W: Vec3, outwards_W: Vec3) -> bool:
    """Whether another brick goes on where a face of a brick ends, as far out as where something comes."""
    near, nearest_W = reach_beside(struck), _nearest(struck, at_W)
    inside = dot(subtract(nearest_W, struck.pose.position_W), outwards_W)
    to_face = reach_W(struck.brick.shape, struck.pose, outwards_W) - inside
    beyond_W = add_scaled(nearest_W, to_face + near, outwards_W)
    return any(dist(_nearest(other, beyond_W), beyond_W) <= near for other in beside)


def reach_beside(struck: Placed) -> float:
    """How near to a brick others are beside it [m]."""
    return FLUSH * struck.brick.shape.least_thickness


def _point_hit(struck: Placed, at_W: Vec3, normal_W: Vec3) -> Vec3:
    """Where a brick that lies flat is hit. From the side it slides before it tips, so the height does not matter."""
    x, y, z = _nearest(struck, at_W)
    return (x, y, struck.pose.position_W[2] if abs(normal_W[2]) <= LEVEL_HIT else z)


def _nearest(placed: Placed, point_W: Vec3) -> Vec3:
    """The point of the box about a brick that is nearest to a point [m, W]."""
    turn, shape = placed.pose.orientation, placed.brick.shape
    x, y, z = rotate(inverse(turn), subtract(point_W, placed.pose.position_W))
    a, b, c = (shape.reach(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    within = (max(-a, min(a, x)), max(-b, min(b, y)), max(-c, min(c, z)))
    return add(placed.pose.position_W, rotate(turn, within))


def _mass_at(brick: Brick, pose: Pose, at_W: Vec3, along_W: Vec3) -> float:
    """The impulse [N s] that gives a point of a free brick at rest a unit of speed along a direction."""
    moving = pushed(BodyState(pose, AT_REST, AT_REST), brick, along_W, at_W)
    return 1.0 / dot(velocity_at(moving, at_W), along_W)


# Moving bricks disturb frozen ones by hits, or by pressing harder than the proof allows.


NO_LINE: Vec3 = (0.0, 0.0, 0.0)  # the direction of what is pressed, not hit
# Shares of the hold-off, which is a tenth of a second for planks.
HORIZON = 0.05
AHEAD = 0.1  # a hit is told so early: contacts of woken bricks start without force, and need a while to find it
PERIOD = 0.02
PRESSES = 0.1  # a load must last so long: forces that have just begun say little
# Times the speed at rest. A plank that is hit at 20 mm/s and slides on wood moves by 0.05 mm.
HITS = 4.0
PUSHES = 1.0  # likewise: at less than 5 mm/s a plank that is pushed slides by less than three micrometres


@dataclass(frozen=True, slots=True)
class Disturbed:
    """Frozen bricks that have to be woken, each with the direction of the hit [unit, W]."""

    struck: Mapping[BodyId, Vec3]
    reason: str
    by: tuple[BodyId, ...] = ()  # the moving bricks that hit or press them; empty if it is another who does


@dataclass(frozen=True, slots=True)
class UnionContainer:
    """The bricks that one or the other knows; nothing is copied, as there may be thousands, asked for at every step."""

    one: Container[BodyId]
    other: Container[BodyId]

    def __contains__(self, brick: object) -> bool:
        return brick in self.one or brick in self.other


@dataclass
class Disturbances(BrickObserver):
    """Looks out for what disturbs the frozen bricks of one engine."""

    engine: Engine
    limits_of: LimitsOf
    gravity: float  # [m/s2]
    reactions: Callable[[], Mapping[BodyId, Sequence[ContactPoint]]]
    _approaches: Approaches = field(init=False)
    _overloads: Overloads = field(init=False)
    _holding: Holding = field(default_factory=Holding, init=False)
    _observers: Observers = field(init=False)
    _looked: float = field(default=0.0, init=False)  # when loads were last looked at [s]

    def __post_init__(self) -> None:
        self._approaches = Approaches(self.engine, self._attention, self.gravity)
        self._overloads = Overloads(self.engine, self.reactions, lambda brick: PRESSES * self.limits_of(brick).hold_off)
        self._observers = Observers((self._approaches, self._overloads, self._holding))

    def least_speed(self, brick: BodyId) -> float:
        """The speed [m/s] below which a brick that hits does nothing."""
        return HITS * self.limits_of(brick).speed

    def least_push(self, brick: BodyId) -> float:
        """The speed [m/s] below which a push leaves a brick where it is."""
        return PUSHES * self.limits_of(brick).speed

    def _attention(self, brick: BodyId) -> Attention:
        hold_off = self.limits_of(brick).hold_off
        return Attention(HORIZON * hold_off, self.least_speed(brick), AHEAD * hold_off)

    def hits(self, assembly: Assembly, states: Mapping[BodyId, BodyState], still: Container[BodyId]) -> list[Hit]:
        """Who is about to hit which of the bricks `still`, but for hits that friction stops at once."""
        found = self._approaches.hits(states, still)
        return [hit for hit in found if not self._is_borne(assembly, hit, states[hit.by])]

    def _is_borne(self, assembly: Assembly, hit: Hit, state: BodyState) -> bool:
        shape = convex(self.engine.shape(hit.by))
        if shape is None or hit.brick not in assembly.bricks:
            return False
        masses = self.engine.masses()
        flying = IncomingBrick(Brick(hit.by, shape, masses[hit.by]), state)
        within = reach_beside(assembly.bricks[hit.brick])
        near = [name for name in self.engine.neighbours(hit.brick, within) if name not in (hit.brick, hit.by)]
        # What is fixed is no brick, and has no mass.
        beside = [placed for _, placed in solids(self.engine, self.engine.states([n for n in near if n in masses]))]
        return friction_stops(assembly, hit, flying, beside, self._holding)

    def overloaded(self, assembly: Assembly, moving: Collection[BodyId]) -> Disturbed | None:
        """The frozen bricks that are pressed away, if any are."""
        if not moving:
            return None
        step = self.engine.time() - self._looked
        period = PERIOD * min(self.limits_of(brick).hold_off for brick in moving)
        if step < period:
            return None
        self._looked = self.engine.time()
        found = self._overloads.found(assembly, moving, min(step, 2.0 * period))
        if not found:
            return None
        touched = {body for brick in found for point in self.engine.contacts(brick) for body in (point.a, point.b)}
        by = tuple(sorted(touched.intersection(moving)))
        return Disturbed(dict.fromkeys(found, NO_LINE), f"{', '.join(found)} pressed away", by)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Frozen bricks hit nothing, and there is more to be disturbed."""
        self._observers.frozen(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """There is less to be disturbed."""
        self._observers.woken(bricks)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """What is gone neither hits nor is disturbed."""
        self._observers.gone(bricks)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._observers.absorb(other._observers)


def is_level(along_W: Vec3) -> bool:
    """Whether a hit is more along the ground than up or down: it is meant to move what it strikes."""
    return hypot(along_W[0], along_W[1]) > abs(along_W[2])


def hit_by_bricks(hits: Collection[Hit]) -> Disturbed:
    """The bricks that are hit, by which, and how fast."""
    by = tuple(sorted({hit.by for hit in hits}))
    return Disturbed({hit.brick: hit.normal_W for hit in hits}, in_words(hits), by)


def in_words(hits: Iterable[Hit]) -> str:
    """Which brick hits which, and how fast."""
    told = sorted({(hit.brick, hit.by): hit.speed for hit in hits}.items())
    return ", ".join(f"{brick} hit by {by} at {speed:.3g} m/s" for (brick, by), speed in told)
