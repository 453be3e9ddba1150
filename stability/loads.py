"""Loads that last: forces and moments on bricks besides their weight."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from stability.geometry.vectors import add, add_scaled, admit_numbers, cross, listed, rotate, scale, short_repr
from stability.model import BodyId, Pose, Vec3
from stability.problem import ZERO, Placed, Wrench


@dataclass(frozen=True, slots=True)
class Load:
    """Force at a point of a brick, and a moment."""

    brick: BodyId
    force: Vec3  # [N]
    point_B: Vec3 = ZERO  # where it acts, from the centre of mass, in axes of the brick [m]
    moment: Vec3 = ZERO  # [N m]
    # True if force and moment are in axes of the brick and turn with it, as a pressure; otherwise they are in W.
    turns: bool = False

    def times(self, factor: float) -> "Load":
        """Return the load times a factor."""
        return replace(self, force=scale(factor, self.force), moment=scale(factor, self.moment))

    def at(self, pose: Pose) -> Wrench:
        """Return force and torque about the centre of mass of its brick at a pose."""
        force_W, moment_W = self.force, self.moment
        if self.turns:
            force_W, moment_W = rotate(pose.orientation, force_W), rotate(pose.orientation, moment_W)
        arm_W = rotate(pose.orientation, self.point_B)
        return Wrench(force_W, add(cross(arm_W, force_W), moment_W))


@dataclass(frozen=True, slots=True)
class Loads:
    """Loads on bricks, which act as soon as their brick is placed."""

    loads: Sequence[Load] = ()
    _of: Mapping[BodyId, Sequence[Load]] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        of: dict[BodyId, list[Load]] = {}
        for load in self.loads:
            of.setdefault(load.brick, []).append(load)
        object.__setattr__(self, "_of", of)

    def on(self, brick: BodyId) -> Sequence[Load]:
        """Return the loads on a brick."""
        return self._of.get(brick, ())

    @property
    def bricks(self) -> Iterable[BodyId]:
        """The loaded bricks."""
        return self._of.keys()

    def towards(self, other: "Loads", part: float) -> "Loads":
        """Return the loads at a part of the way to others, which have the same places in the same order."""
        pairs = zip(self.loads, other.loads, strict=True)
        return Loads(tuple(_between(one, last, part) for one, last in pairs))

    def wrench(self, placed: Placed) -> Wrench | None:
        """Return the sum of all loads on a brick; None if there are none."""
        force_W, torque_W = ZERO, ZERO
        for load in (loads := self.on(placed.brick.id)):
            each = load.at(placed.pose)
            force_W, torque_W = add(force_W, each.force_W), add(torque_W, each.torque_W)
        return Wrench(force_W, torque_W) if loads else None


UNLOADED = Loads()


def _between(one: Load, other: Load, part: float) -> Load:
    force = add_scaled(scale(1.0 - part, one.force), part, other.force)
    return replace(one, force=force, moment=add_scaled(scale(1.0 - part, one.moment), part, other.moment))


@dataclass(frozen=True, slots=True)
class LoadCourse:
    """Loads that change in proportion to the time between two times, and stay as they are before and after."""

    first: Loads
    last: Loads
    begins: float = 0.0  # [s]
    ends: float = 0.0

    def at(self, time: float) -> Loads:
        """Return the loads at a time [s]."""
        if time >= self.ends or self.first == self.last:
            return self.last
        return self.first.towards(self.last, max(0.0, (time - self.begins) / (self.ends - self.begins)))


def admit_loads(loads: object) -> None:
    """Raise TypeError for anything but loads, ValueError for numbers that are not finite."""
    if not isinstance(loads, Loads):
        raise TypeError(f"expected Loads((Load(brick, force), ...)), not {short_repr(loads)}")
    for load in listed(loads.loads, "loads, such as [Load('a', (0.0, 0.0, -5.0))]"):
        if not isinstance(load, Load):
            raise TypeError(f"expected Load(brick, force), not {short_repr(load)}")
        if not isinstance(load.brick, str):
            raise TypeError(f"the name of a loaded brick is {short_repr(load.brick)}; write a string")
        parts = {"force": load.force, "point": load.point_B, "moment": load.moment}
        for what, numbers in parts.items():
            admit_numbers(f"the {what} of the load on '{load.brick}' is", numbers, 3, "write x, y and z")
