"""A PyBullet world in which a brick that comes to lean on another edge on edge gets rounded edges.

PyBullet finds the normal of sharp edges that cross, but takes a face for edges that run along each other. It cannot
give a body another shape, so the brick gets another body: in the same place, with the same motion and mass. What the
last step pressed with is forgotten with the old one, which is why only those bricks change that must.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, hypot, radians

from stability.engines.edge_normals import FACE_ON, leans, nearest_points, velocity_at
from stability.engines.pybullet.plain_world import PlainWorld
from stability.engines.pybullet.planes import ROUNDED as ROUND
from stability.engines.pybullet.planes import SHARP
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.geometry.separation import Block
from stability.geometry.vectors import dot, norm, scale, subtract
from stability.model import AT_REST, BodyId, BodyState, Brick, Pose, Vec3
from stability.shapes.apart import solid_block

LOOK = 0.02  # [s] between looks at how bricks lie to each other
ALONG = cos(radians(1.0))  # edges run along each other within this; beyond, the normal of sharp ones is right
NEAR = 0.25  # share of its smallest side: a brick that is so close to another may touch it before the next look
# [s] So long ahead a brick that moves gets rounded edges, so that the forces that its foot loses with the old body are
# back by then. Of 144 pairs of planks that are tipped against each other, 34 slip with 10 ms, 8 with 40 ms.
AHEAD = 0.04
ROUNDED = 0.05  # share of its smallest side by which a box is rounded to see how it lies to others
SLOW, SLOWLY = 5e-3, 0.1  # [m/s], [rad/s]: what lies square and is not faster gets sharp edges again


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """A brick as it is at a look."""

    state: BodyState
    block: Block

    @property
    def fastest(self) -> float:
        """No point of it is faster [m/s]."""
        reach = norm(self.block.reach)
        return norm(self.state.velocity_W) + reach * norm(self.state.angular_velocity_W)


@dataclass
class ReshapingWorld(PlainWorld):
    """A world whose bricks have sharp or rounded edges, by how they touch."""

    _rounded: set[BodyId] = field(default_factory=set, init=False)
    _next_look: float = field(default=0.0, init=False)  # [s] on the clock

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        super().add_brick(brick, pose, velocity_W)
        if not self._square(pose):
            self._rounded.add(brick.id)

    def remove_brick(self, brick: BodyId) -> None:
        super().remove_brick(brick)
        self._rounded.discard(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        super().put_at(brick, pose)
        self._next_look = 0.0

    def step(self) -> None:
        if self.settings.edge_rounding and self._clock >= self._next_look:
            self._next_look = self._clock + LOOK
            states = self.states([name for name in self._masses if name in self._bodies and not self.holds(name)])
            for name, state in states.items():
                self._reach_beyond(self._bricks[name], state.pose.position_W)
            self._reshape(states)
        super().step()

    def _reshape(self, states: Mapping[BodyId, BodyState]) -> None:
        """Give every brick that is awake the edges that it needs."""
        leaning = {
            name: self._seen(name, state)
            for name, state in states.items()
            if name not in self._rounded and leans(state.pose)
        }
        edge_on = self._edge_on(leaning)
        rounded = ((name, state) for name, state in states.items() if name in self._rounded)
        lying = [name for name, state in rounded if _slow(state) and self._square(state.pose)]
        for name in (*(name for name in leaning if name in edge_on), *lying):
            self._swap(name)

    def _seen(self, name: BodyId, state: BodyState) -> _Seen:
        return _Seen(state, solid_block(self._bricks[name].shape, state.pose))

    def _edge_on(self, leaning: dict[BodyId, _Seen]) -> set[BodyId]:
        """Those whose edges are about to meet edges of another brick that run along them."""
        found: set[BodyId] = set()
        for name, one in leaning.items():
            thin = self._bricks[name].shape.least_thickness
            for other in self.near(name, NEAR * thin + AHEAD * one.fastest):
                if other not in self._bricks or (other in leaning and other < name):
                    continue  # every pair once
                two = leaning.get(other) or self._seen(other, self.states([other])[other])
                if _edges_meet(one, two, NEAR * thin, ROUNDED * thin):
                    found |= {name, other}
        return found

    def _kind(self, name: BodyId) -> int:
        """The collision group of a brick."""
        return ROUND if self.settings.half_spaces and name in self._rounded else SHARP

    def _swap(self, name: BodyId) -> None:
        """Give a brick a body with the other kind of edges: same place, motion, mass and name."""
        brick, body = self._bricks[name], self._bodies[name]
        position, orientation = pybullet.getBasePositionAndOrientation(body, self.client)
        velocity, angular_velocity = pybullet.getBaseVelocity(body, self.client)
        pybullet.removeBody(body, self.client)
        del self.names[body]
        self._rounded ^= {name}
        body = self._brick_body(brick, position, orientation, rounded=name in self._rounded)
        pybullet.resetBaseVelocity(body, velocity, angular_velocity, physicsClientId=self.client)
        if name in self._anchored:
            self._anchor([name], not self._told_stepping.lively)


def _slow(state: BodyState) -> bool:
    return hypot(*state.velocity_W) < SLOW and hypot(*state.angular_velocity_W) < SLOWLY


def _edges_meet(a: _Seen, b: _Seen, near: float, radius: float) -> bool:
    """Whether bricks will soon touch with edges that run along each other, and with no face."""
    alike = sum(abs(dot(x, y)) > ALONG for x in a.block.axes_W for y in b.block.axes_W)
    if alike == 0 or (alike == 3 and _faces_meet(a.block, b.block, 2.0 * radius)):  # noqa: PLR2004 -- all three axes
        return False
    on_a, on_b = nearest_points(a.block, b.block, a.block.p_WC, radius)
    between = subtract(on_a, on_b)
    distance = norm(between)
    if distance == 0.0:
        return False
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
