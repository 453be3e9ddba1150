"""Disturbances of frozen bricks: hits, which friction may absorb, and added loads."""

from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil, dist, hypot, sqrt
from typing import Self

from stability.dynamics.rigid_body import pushed
from stability.engines.edge_normals import velocity_at
from stability.engines.protocol import Engine
from stability.geometry.box import Box
from stability.geometry.box_distance import TOUCHING
from stability.geometry.placed_shape import corners_W, nearest_in_bounds_W, reach_W
from stability.geometry.vectors import add_scaled, body_axes, dot, norm, scale, subtract
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Pose, Vec3, convex
from stability.name_order import in_order, names_text
from stability.problem import Placed
from stability.stabilizers.approach import Hit, HitPredictor, PredictionLimits, about_to_hit, carries_too_much
from stability.stabilizers.exact.candidates import solids
from stability.stabilizers.exact.overload import MOVED, Overloads, slides_before_it_tips
from stability.stabilizers.protocol import BrickObserver, Observers
from stability.stabilizers.rest import LimitsOf
from stability.statics.assembly import Assembly

# Normal forces of the proof that clamp a frozen brick between its neighbours, for friction.
#
# The courses just above a brick give a lower bound of these forces. More courses are solved only if it is too small, so
# the cost of a hit does not grow with the height of a wall.


FEWEST = 4  # courses above a brick in the first bound
SIDEWAYS = 0.5  # largest vertical component of the normal of bricks side by side
MORE = 1.5  # times the courses that would suffice if each weighed as much as one brick


@dataclass
class HoldingForces(BrickObserver):
    """Cache of lower bounds of the normal forces on frozen bricks, valid until a proof may change."""

    _bounds: dict[BodyId, "_HoldingBound"] = field(default_factory=dict, init=False)

    def at_least(self, assembly: Assembly, brick: BodyId, required: float) -> bool:
        """Check that the sum of normal forces from above and below is at least this force [N]."""
        bound = self._bounds.setdefault(brick, _HoldingBound())
        while bound.force < required and not bound.is_all:
            bound.extend(assembly, brick, required)
        return bound.force >= required

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Clear the cache, as proofs may change."""
        self._bounds.clear()

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Clear the cache, as proofs may change even if no brick was woken."""
        self._bounds.clear()

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Clear the cache, as loads may be removed."""
        self._bounds.clear()


@dataclass
class _HoldingBound:
    """Lower bound of the normal forces on one brick."""

    force: float = 0.0  # [N]
    courses: int = 0  # courses above the brick in the bound
    is_all: bool = False  # whether the bound includes all bricks above

    def extend(self, assembly: Assembly, brick: BodyId, required: float) -> None:
        weight = assembly.bricks[brick].brick.mass * assembly.gravity
        self.courses = max(2 * self.courses, FEWEST, ceil(MORE * required / (2.0 * weight)))
        above, front = {brick}, {brick}
        for _ in range(self.courses):
            if not front:
                break  # a block above slivers would need millions of courses
            front = {upper for lower in front for upper in _carried(assembly, lower)} - above
            above |= front
        self.is_all = not front
        total_weight = sum(assembly.bricks[name].brick.mass for name in above) * assembly.gravity
        if self.is_all and 2.0 * total_weight < required:
            self.force = max(self.force, weight)  # even the weight of all courses is too small
            return
        pressing = assembly.forces_above([brick], above).onto(brick)
        from_above = sum(norm(force_W) for _, at_points in pressing for in_cones in at_points for force_W in in_cones)
        self.force = 2.0 * from_above + weight


def _carried(assembly: Assembly, brick: BodyId) -> Iterator[BodyId]:
    """Yield the bricks that lie on a brick."""
    for contact in assembly.contacts(brick):
        if contact.lower == brick and any(normal[2] > SIDEWAYS for normal in contact.normals_W):
            yield contact.upper


# Hits that friction absorbs before the struck brick has moved; they wake no brick.
#
# Model: the hit is plastic. Both bricks continue with a common velocity at the point of impact, and friction on the
# struck brick stops both. The brick's travel is their kinetic energy along the normal, divided by the friction and the
# mean motion of the rubbing faces. Below a limit the brick may stay frozen: it stops the other one all the same.


AT_ONCE = TOUCHING  # share of the smallest side: corners within this distance of the foremost arrive together
FLUSH = 0.125  # share of the smallest side: a brick this close to a face, and reaching as far, covers it
LEVEL = 1.0 - 1e-6  # least vertical component of the normal of a level contact, which only friction holds
LEVEL_HIT = 0.02  # largest vertical component of the normal of a hit from the side
ROUNDING = 1e-9  # of a unit normal
# Least ratio of mean speed to root mean square speed along a line that moves in its own plane.
MEAN_BY_ROOT = 0.816


@dataclass(frozen=True, slots=True)
class IncomingBrick:
    """Brick that is about to hit another one."""

    brick: Brick
    state: BodyState


def friction_stops(
    assembly: Assembly, hit: Hit, flying: IncomingBrick, beside: Sequence[Placed], holding: HoldingForces
) -> bool:
    """Check that friction stops a brick of an assembly within the limit after a hit; `beside`: bricks near it.

    Only for boxes; returns False for other solids, so that the engine simulates the hit.
    """
    struck = assembly.bricks[hit.brick]
    if not all(
        isinstance(brick.shape, Box) for brick in (flying.brick, struck.brick, *(near.brick for near in beside))
    ):
        return False
    contacts = assembly.contacts(hit.brick)
    lies_flat = all(abs(normal[2]) >= LEVEL for contact in contacts for normal in contact.normals_W)
    friction = min([contact.law.friction for contact in contacts], default=0.0)
    if not lies_flat or friction <= 0.0 or not slides_before_it_tips(struck, friction):
        return False
    normal_W, at_W, speed = _impact(hit, flying, struck, beside)
    if speed <= 0.0:
        return True
    own = _mass_at(flying.brick, flying.state.pose, at_W, normal_W)
    other = _mass_at(struck.brick, struck.pose, _point_hit(struck, at_W, normal_W), normal_W)
    shared = speed * own / (own + other)
    energy = 0.5 * (own + other) * shared * shared
    mean_way = MEAN_BY_ROOT * sqrt(min(1.0, other / struck.brick.mass))  # per unit of travel of the point of impact
    required = energy / (mean_way * min(1.0, friction) * MOVED * struck.brick.shape.least_thickness)
    return holding.at_least(assembly, hit.brick, required)


def _impact(hit: Hit, flying: IncomingBrick, struck: Placed, beside: Sequence[Placed]) -> tuple[Vec3, Vec3, float]:
    """Return the normal of a hit [unit, W], the hitting point [m, W], and its speed [m/s].

    A brick that lies flush beside a face covers the face's edge, so a hit on that edge acts on the open faces.
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
    """Return the foremost point of a brick along a direction: a corner, or the point in line with the centre."""
    reached = sorted(((dot(c, along_W), c) for c in corners_W(flying.brick.shape, flying.state.pose)), reverse=True)
    within = AT_ONCE * flying.brick.shape.least_thickness
    ahead = [corner for reach, corner in reached if reach >= reached[0][0] - within]
    centre_W = flying.state.pose.position_W
    if len(ahead) == 1:
        return ahead[0]
    if len(ahead) == 2:  # noqa: PLR2004 -- an edge
        return _on_edge(ahead[0], ahead[1], centre_W, along_W)
    return add_scaled(centre_W, reached[0][0] - dot(centre_W, along_W), along_W)


def _on_edge(first_W: Vec3, second_W: Vec3, centre_W: Vec3, along_W: Vec3) -> Vec3:
    """Return the point of an edge that is nearest to a line through the centre."""
    edge, lever = subtract(second_W, first_W), subtract(centre_W, first_W)
    across = add_scaled(edge, -dot(edge, along_W), along_W)
    length = dot(across, across)
    part = dot(lever, across) / length if length > 0.0 else 0.5
    return add_scaled(first_W, max(0.0, min(1.0, part)), edge)


def _is_covered(struck: Placed, beside: Sequence[Placed], at_W: Vec3, outwards_W: Vec3) -> bool:
    """Check that another brick covers a face of a brick beside the hitting point."""
    near, nearest_W = reach_beside(struck), _nearest(struck, at_W)
    inside = dot(subtract(nearest_W, struck.pose.position_W), outwards_W)
    to_face = reach_W(struck.brick.shape, struck.pose, outwards_W) - inside
    beyond_W = add_scaled(nearest_W, to_face + near, outwards_W)
    return any(dist(_nearest(other, beyond_W), beyond_W) <= near for other in beside)


def reach_beside(struck: Placed) -> float:
    """Return the distance within which other bricks are beside a brick [m]."""
    return FLUSH * struck.brick.shape.least_thickness


def _point_hit(struck: Placed, at_W: Vec3, normal_W: Vec3) -> Vec3:
    """Return the point of impact on a flat brick; the height of a hit from the side has no effect, as it slides."""
    x, y, z = _nearest(struck, at_W)
    return (x, y, struck.pose.position_W[2] if abs(normal_W[2]) <= LEVEL_HIT else z)


def _nearest(placed: Placed, point_W: Vec3) -> Vec3:
    return nearest_in_bounds_W(placed.brick.shape, placed.pose, point_W)


def _mass_at(brick: Brick, pose: Pose, at_W: Vec3, along_W: Vec3) -> float:
    """Return the effective mass [kg] of a free brick at a point along a direction."""
    moving = pushed(BodyState(pose, AT_REST, AT_REST), brick, along_W, at_W)
    return 1.0 / dot(velocity_at(moving, at_W), along_W)


# Disturbances of frozen bricks by moving ones: hits, and loads beyond the proof.


NO_LINE: Vec3 = (0.0, 0.0, 0.0)  # the direction of a disturbance by a load
# Shares of the hold-off, which is a tenth of a second for planks.
HORIZON = 0.05
AHEAD = 0.1  # look-ahead of hits: the contact forces of woken bricks start at 0 and need time to build up
PERIOD = 0.02  # between checks of loads
PRESSES = 0.1  # least duration of an overload, as new contact forces are inaccurate
# Times the speed limit of rest. A plank that is hit at 20 mm/s and slides on wood moves by 0.05 mm.
HITS = 4.0
PUSHES = 1.0  # the same for pushes: a plank pushed to 5 mm/s slides by less than three micrometres


@dataclass(frozen=True, slots=True)
class Disturbance:
    """Frozen bricks to wake, each with the direction of its hit [unit, W]."""

    struck: Mapping[BodyId, Vec3]
    reason: str
    by: tuple[BodyId, ...] = ()  # the moving bricks that hit or press them; empty for other causes


@dataclass(frozen=True, slots=True)
class UnionContainer:
    """Union of two containers without copying, as they may hold thousands of bricks and are read at every step."""

    first: Container[BodyId]
    second: Container[BodyId]

    def __contains__(self, brick: object) -> bool:
        return brick in self.first or brick in self.second


@dataclass
class Disturbances(BrickObserver):
    """Detection of disturbances of the frozen bricks of one engine."""

    engine: Engine
    limits_of: LimitsOf
    gravity: float  # [m/s2]
    reactions: Callable[[], Mapping[BodyId, Sequence[ContactPoint]]]
    joined: Container[BodyId] = ()  # bricks that move in bodies with others, whose mass is not known here
    _approaches: HitPredictor = field(init=False)
    _overloads: Overloads = field(init=False)
    _holding: HoldingForces = field(default_factory=HoldingForces, init=False)
    _observers: Observers = field(init=False)
    _looked: float = field(default=0.0, init=False)  # time of the last check of loads [s]

    def __post_init__(self) -> None:
        self._approaches = HitPredictor(self.engine, self._attention, self.gravity)
        self._overloads = Overloads(self.engine, self.reactions, lambda brick: PRESSES * self.limits_of(brick).hold_off)
        self._observers = Observers((self._approaches, self._overloads, self._holding))

    def least_speed(self, brick: BodyId) -> float:
        """Return the speed [m/s] below which hits of a brick have no effect."""
        return HITS * self.limits_of(brick).speed

    def least_push(self, brick: BodyId) -> float:
        """Return the speed [m/s] below which pushes of a brick have no effect."""
        return PUSHES * self.limits_of(brick).speed

    def _attention(self, brick: BodyId) -> PredictionLimits:
        hold_off = self.limits_of(brick).hold_off
        return PredictionLimits(HORIZON * hold_off, self.least_speed(brick), AHEAD * hold_off)

    def hits(self, assembly: Assembly, states: Mapping[BodyId, BodyState], still: Container[BodyId]) -> list[Hit]:
        """Return the imminent hits on bricks in `still`, without those that friction absorbs."""
        hits = self._approaches.hits(states, still)
        return [hit for hit in hits if not self._is_absorbed(assembly, hit, states[hit.by])]

    def _is_absorbed(self, assembly: Assembly, hit: Hit, state: BodyState) -> bool:
        shape = convex(self.engine.shape(hit.by))
        if shape is None or hit.brick not in assembly.bricks or hit.by in self.joined:
            return False
        masses = self.engine.masses()
        flying = IncomingBrick(Brick(hit.by, shape, masses[hit.by]), state)
        within = reach_beside(assembly.bricks[hit.brick])
        near = [name for name in self.engine.neighbours(hit.brick, within) if name not in (hit.brick, hit.by)]
        # Fixed bodies have no mass and are not included.
        beside = [placed for _, placed in solids(self.engine, self.engine.states([n for n in near if n in masses]))]
        return friction_stops(assembly, hit, flying, beside, self._holding)

    def overloaded(self, assembly: Assembly, moving: Collection[BodyId]) -> Disturbance | None:
        """Return the frozen bricks that yield to the loads of moving ones; None if there are none."""
        if not moving:
            return None
        step = self.engine.time() - self._looked
        period = PERIOD * min(self.limits_of(brick).hold_off for brick in moving)
        if step < period:
            return None
        self._looked = self.engine.time()
        overloaded = self._overloads.overloaded(assembly, moving, min(step, 2.0 * period))
        if not overloaded:
            return None
        touched = {body for brick in overloaded for point in self.engine.contacts(brick) for body in (point.a, point.b)}
        by = tuple(sorted(touched.intersection(moving)))
        return Disturbance(dict.fromkeys(overloaded, NO_LINE), carries_too_much(overloaded), by)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Pass frozen bricks on to the observers."""
        self._observers.frozen(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Pass woken bricks on to the observers."""
        self._observers.woken(bricks)

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Pass removed bricks on to the observers."""
        self._observers.removed(bricks)

    def absorb(self, other: Self) -> None:
        """Take over the records of another instance."""
        self._observers.absorb(other._observers)


def is_level(along_W: Vec3) -> bool:
    """Check that a hit is more horizontal than vertical, so that it may move the brick along the ground."""
    return hypot(along_W[0], along_W[1]) > abs(along_W[2])


def hit_by_bricks(hits: Collection[Hit]) -> Disturbance:
    """Return the disturbance of all bricks that are hit."""
    by = tuple(sorted({hit.by for hit in hits}))
    return Disturbance({hit.brick: hit.normal_W for hit in hits}, hit_description(hits), by)


def hit_description(hits: Iterable[Hit]) -> str:
    """Describe imminent hits: for each hitting brick the hit bricks, and the largest speed."""
    fastest = {(hit.by, hit.brick): hit.speed for hit in sorted(hits, key=lambda hit: hit.speed)}
    described = []
    for by in in_order({by for by, _ in fastest}):
        speeds = {brick: speed for (other, brick), speed in fastest.items() if other == by}
        described.append(f"{about_to_hit(by, names_text(in_order(speeds)))} at {max(speeds.values()):.3g} m/s")
    return "; ".join(described)
