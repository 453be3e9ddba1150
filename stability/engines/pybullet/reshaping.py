"""A brick that comes to lean on another edge on edge gets rounded edges.

PyBullet finds the normal of sharp edges that cross, but takes a face for edges that run along each other. It cannot
give a body another shape, so the brick gets another body: in the same place, with the same motion and mass. What the
last step pressed with is forgotten with the old one, which is why only those bricks change that must.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, hypot, radians
from typing import Protocol

from stability.engines.edge_normals import FACE_ON, leans, nearest_of, velocity_at
from stability.engines.pybullet.brick_bodies import BrickBodies
from stability.engines.pybullet.fresh_contacts import FreshContacts, find_all_points
from stability.engines.pybullet.joined_groups import JoinedGroups
from stability.geometry.separation import Block, block
from stability.geometry.vectors import dot, norm, scale, subtract
from stability.model import BodyId, BodyState, Vec3
from stability.shapes.box import Box

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

    def _seen(self, state: BodyState, box: Box) -> _Seen:
        return _Seen(state, block(box.size, state.pose))

    def _edge_on(self, leaning: Mapping[BodyId, _Seen]) -> set[BodyId]:
        """Those whose edges are about to meet edges of another brick that run along them."""
        found: set[BodyId] = set()
        for name, one in leaning.items():
            thin = self.bricks.own.bricks[name].shape.least_thickness
            for other in self.groups.near(name, NEAR * thin + AHEAD * one.fastest):
                if other not in self.bricks.own.bricks or (other in leaning and other < name):
                    continue  # every pair once
                box = self._box(other)
                if box is None:
                    continue
                two = leaning.get(other) or self._seen(self.groups.states([other])[other], box)
                if _edges_meet(one, two, NEAR * thin, ROUNDED * thin):
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


def _edges_meet(a: _Seen, b: _Seen, near: float, radius: float) -> bool:
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
