"""Frozen bricks that moving bricks load beyond their proof.

A brick carries any vertical load inside its load core (statics/load_core.py). Statics judges a load outside the core.
It also judges a load that leaves the core between its point of application and the foot of the brick, due to horizontal
forces. A brick slides when horizontal forces exceed the friction F below and above it: an excess impulse J moves a mass
M by J^2 / (2 M F). Every solver has short force peaks, so both conditions must last.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot
from typing import Self

from stability.contact_law import as_friction
from stability.engines.protocol import Engine
from stability.geometry.placed_shape import bounds_W
from stability.geometry.polygons import Point2
from stability.geometry.vectors import add, add_scaled, cross, scale, subtract
from stability.model import BodyId, ContactPoint, Vec3
from stability.problem import Contact, Placed, Wrench
from stability.stabilizers.protocol import BrickObserver
from stability.statics.assembly import Assembly, withstands

MOVED = 0.0064  # share of the smallest side, 0.05 mm for a plank: least slide of a brick that yields
OUTSIDE = 0.04  # share of the smallest side: least distance of a tipping load from the core
COUNTS = 0.05  # share of a brick's weight: least load that may tip it
NO_FORCE: Vec3 = (0.0, 0.0, 0.0)


@dataclass
class Overloads(BrickObserver):
    """Sums of the loads of moving bricks on frozen ones."""

    engine: Engine
    # Reactions of moving bricks to the dead loads on them, by frozen brick.
    reactions: Callable[[], Mapping[BodyId, Sequence[ContactPoint]]]
    tips_after: Callable[[BodyId], float]  # [s] duration of a load outside the core after which a brick tips
    _sums: dict[BodyId, "_Sums"] = field(default_factory=dict, init=False)  # of bricks that are or were loaded
    _holding: dict[BodyId, float] = field(default_factory=dict, init=False)  # sum of normal forces by brick [N]
    _changed: bool = field(default=False, init=False)  # whether proofs may have changed

    def overloaded(self, assembly: Assembly, moving: Iterable[BodyId], step: float) -> list[BodyId]:
        """Return the frozen bricks of an assembly that yield after another step of the engine [s]."""
        if self._changed:
            self._reset_changed(assembly)
        pressing, reactions = self._pressing(assembly, sorted(moving)), self.reactions()
        self._unload(assembly, self._sums.keys() - pressing.keys(), step)
        return [
            brick
            for brick in sorted(pressing)
            if self._gives_way(assembly, brick, pressing[brick], reactions.get(brick, ()), step)
        ]

    def _pressing(self, assembly: Assembly, moving: Sequence[BodyId]) -> dict[BodyId, list[ContactPoint]]:
        """Return the contact points of frozen bricks with moving ones; forces between frozen bricks are outdated."""
        loaded: dict[BodyId, list[ContactPoint]] = {}
        moving_bricks = set(moving)
        for brick in sorted(self._touched(assembly, moving)):
            points = [p for p in self.engine.contacts(brick) if (p.b if p.a == brick else p.a) in moving_bricks]
            if points:
                loaded[brick] = points
        return loaded

    def _touched(self, assembly: Assembly, moving: Sequence[BodyId]) -> Collection[BodyId]:
        """Return the frozen bricks whose contacts to read, by the cheaper search.

        The contacts are always read from the frozen brick, as those of the other body may differ in order and rounding.
        """
        frozen = assembly.bricks.keys()
        if len(frozen) <= len(moving):
            return frozen
        points = (point for brick in moving for point in self.engine.contacts(brick))
        return {body for point in points for body in (point.a, point.b) if body in frozen}

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Mark proofs as changed."""
        self._may_have_changed()

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Mark proofs as changed, even if no brick was woken."""
        self._may_have_changed()

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Mark proofs as changed."""
        self._may_have_changed()

    def absorb(self, other: Self) -> None:
        """Take over the sums of another instance."""
        self._sums |= other._sums
        self._may_have_changed()

    def _may_have_changed(self) -> None:
        self._changed = True
        self._holding.clear()

    def _reset_changed(self, assembly: Assembly) -> None:
        """Reset the sums of bricks whose own contacts have changed."""
        for brick, sums in list(self._sums.items()):
            if brick not in assembly.bricks or sums.touched != assembly.contacts(brick):
                del self._sums[brick]
        self._changed = False

    def _unload(self, assembly: Assembly, bricks: Iterable[BodyId], step: float) -> None:
        """Let friction reduce the excess impulse of bricks without loads."""
        for brick in sorted(bricks):
            sums = self._sums[brick]
            sums.outside = None
            if sums.excess == 0.0 or self._slides(assembly, brick, sums, (), step) or sums.excess == 0.0:
                del self._sums[brick]

    def _gives_way(
        self,
        assembly: Assembly,
        brick: BodyId,
        points: Collection[ContactPoint],
        reactions: Collection[ContactPoint],
        step: float,
    ) -> bool:
        forces, held_up = ([(point, _force_on(brick, point)) for point in some] for some in (points, reactions))
        sums = self._sums.setdefault(brick, _Sums(assembly.contacts(brick)))
        slides = self._slides(assembly, brick, sums, forces, step)
        return slides or self._tips(assembly, brick, sums, forces + held_up, step)

    def _slides(
        self,
        assembly: Assembly,
        brick: BodyId,
        sums: "_Sums",
        forces: Collection[tuple[ContactPoint, Vec3]],
        step: float,
    ) -> bool:
        placed = assembly.bricks[brick].brick
        x, y, z = NO_FORCE
        for _, force in forces:
            x, y, z = add((x, y, z), force)
        sideways, before, pressed = hypot(x, y), sums.excess, max(0.0, -z)
        least, _ = _frictions(assembly, brick)
        if before == 0.0 and sideways <= least * (placed.mass * assembly.gravity + pressed):
            return False  # its own weight suffices
        if brick not in self._holding:
            self._holding[brick] = _held_by(assembly, brick)
        friction = least * (self._holding[brick] + pressed)
        sums.excess = excess = max(0.0, before + (sideways - friction) * step)
        return excess * excess > 2.0 * placed.mass * friction * MOVED * placed.shape.least_thickness

    def _tips(
        self,
        assembly: Assembly,
        brick: BodyId,
        sums: "_Sums",
        forces: Collection[tuple[ContactPoint, Vec3]],
        step: float,
    ) -> bool:
        """Check that a load outside the core has lasted, and that statics finds no forces that balance it."""
        placed = assembly.bricks[brick]
        load = _wrench(placed.pose.position_W, forces)
        down, counts = -load.force_W[2], COUNTS * placed.brick.mass * assembly.gravity
        if (
            _within_core(assembly, placed, forces, down)
            if down >= counts
            else _hardly_tips(assembly, placed, forces, counts)
        ):
            sums.outside = None
            return False
        sums.outside = lasting = sums.outside or _Load()
        lasting.add(load, step)
        if lasting.span <= self.tips_after(brick):
            return False
        sums.outside = None
        return not withstands(assembly, {brick: lasting.mean()})


@dataclass
class _Sums:
    """Sums of the loads on a frozen brick since its contacts changed."""

    touched: Sequence[Contact]
    excess: float = 0.0  # impulse beyond friction [N s]
    outside: "_Load | None" = None  # loads outside the core


@dataclass
class _Load:
    """Time integral of a load, for its mean."""

    span: float = 0.0  # [s]
    force_W: Vec3 = NO_FORCE  # summed over time [N s]
    torque_W: Vec3 = NO_FORCE  # [N m s]

    def add(self, load: Wrench, step: float) -> None:
        self.span += step
        self.force_W = add_scaled(self.force_W, step, load.force_W)
        self.torque_W = add_scaled(self.torque_W, step, load.torque_W)

    def mean(self) -> Wrench:
        return Wrench(scale(1.0 / self.span, self.force_W), scale(1.0 / self.span, self.torque_W))


def _wrench(centre_W: Vec3, forces: Collection[tuple[ContactPoint, Vec3]]) -> Wrench:
    force, torque = NO_FORCE, NO_FORCE
    for point, part in forces:
        force = add(force, part)
        torque = add(torque, cross(subtract(point.position_W, centre_W), part))
    return Wrench(force, torque)


def _within_core(
    assembly: Assembly, placed: Placed, forces: Collection[tuple[ContactPoint, Vec3]], down: float
) -> bool:
    """Check that the line of action of the load meets the foot of the brick inside its core."""
    x, y = _tipping(assembly, placed, forces)
    x += sum(-force[2] * point.position_W[0] for point, force in forces)
    y += sum(-force[2] * point.position_W[1] for point, force in forces)
    return assembly.core_depth(placed.brick.id, (x / down, y / down)) >= -OUTSIDE * placed.brick.shape.least_thickness


def _hardly_tips(
    assembly: Assembly, placed: Placed, forces: Collection[tuple[ContactPoint, Vec3]], counts: float
) -> bool:
    """Check that the tipping moment of horizontal forces is at most that of a negligible force."""
    return hypot(*_tipping(assembly, placed, forces)) <= counts * placed.brick.shape.least_thickness


def _tipping(assembly: Assembly, placed: Placed, forces: Collection[tuple[ContactPoint, Vec3]]) -> Point2:
    """Return the moments of horizontal forces about a brick's foot, along x and y [N m].

    They are 0 for a brick that slides before it tips, such as a flat plank.
    """
    if slides_before_it_tips(placed, _frictions(assembly, placed.brick.id)[1]):
        return (0.0, 0.0)
    foot = bounds_W(placed.brick.shape, placed.pose)[0][2]
    heights = [(force, point.position_W[2] - foot) for point, force in forces]
    return (sum(force[0] * height for force, height in heights), sum(force[1] * height for force, height in heights))


def _frictions(assembly: Assembly, brick: BodyId) -> tuple[float, float]:
    """Return the least and the greatest coefficient of a brick's contacts; the usual one for a uniform law."""
    law = as_friction(assembly.friction)
    coefficients = [contact.law.friction for contact in assembly.contacts(brick)] if law.differs else []
    return min(coefficients, default=law.usual), max(coefficients, default=law.usual)


def slides_before_it_tips(placed: Placed, friction: float) -> bool:
    """Check that a brick is so low that horizontal forces make it slide before they tip it."""
    (low_x, low_y, foot), (high_x, high_y, top) = bounds_W(placed.brick.shape, placed.pose)
    return friction * (top - foot) <= 0.5 * min(high_x - low_x, high_y - low_y)


def _force_on(brick: BodyId, point: ContactPoint) -> Vec3:
    """Return the force of a contact on one of its two bodies [N]."""
    on_a = add_scaled(point.friction_W, point.normal_force, point.normal_BA_W)
    return on_a if point.a == brick else (-on_a[0], -on_a[1], -on_a[2])


def _held_by(assembly: Assembly, brick: BodyId) -> float:
    """Return the normal forces below and above a brick without moving bricks [N]: 2 N + w for weight w and load N."""
    above = assembly.with_all_above([brick])
    shares = assembly.all_shares(above)
    loads = {name: assembly.bricks[name].brick.mass * assembly.gravity for name in above}
    for name in sorted(above - {brick}, key=lambda name: (-assembly.bricks[name].pose.position_W[2], name)):
        for lower, share in shares[name].items():
            if lower in loads and share == share:  # noqa: PLR0124 -- NaN stands for an unknown share
                loads[lower] += share * loads[name]
    return 2.0 * loads[brick] - assembly.bricks[brick].brick.mass * assembly.gravity
