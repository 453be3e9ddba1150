"""Bricks that ride along: they are joined into one rigid body while it hardly moves, and one of them is watched."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from math import dist
from typing import Self

from stability.engines.protocol import Joining
from stability.geometry.rotations import turn_between
from stability.graph import components
from stability.model import BodyId, BodyState, Pose
from stability.watching.life_cycle import BrickObserver

MOVED = 0.25  # share of the smallest side, 2 mm for a plank: further than that, a group is taken apart
FEWEST = 3  # bricks: making a rigid body of fewer is not worth it
TURNED = 0.0175  # [rad], 1 deg: a group that has turned further is taken apart


@dataclass(frozen=True, slots=True)
class Group:
    """Bricks that ride as one."""

    starts: Mapping[BodyId, Pose]  # where they stood, from the lowest on
    touching: Mapping[BodyId, Collection[BodyId]]  # who touched whom there
    furthest: float  # that it may move [m]

    @property
    def first(self) -> BodyId:
        """The brick that is watched for the whole group."""
        return next(iter(self.starts))


@dataclass
class RigidGroups(BrickObserver):
    """The joined bricks of one engine, in groups, each watched through its first brick."""

    joiner: Joining | None  # None if nothing ever rides
    _groups: dict[BodyId, Group] = field(default_factory=dict, init=False)  # by the first of its members
    _first: dict[BodyId, BodyId] = field(default_factory=dict, init=False)  # of the group of each rider

    def __contains__(self, brick: object) -> bool:
        return brick in self._first

    @property
    def bricks(self) -> frozenset[BodyId]:
        """All bricks that ride."""
        return frozenset(self._first)

    def join(self, starts: Mapping[BodyId, Pose], touching: Mapping[BodyId, Collection[BodyId]], side: float) -> None:
        """Let bricks ride as one, from where they stand; `side` is their smallest [m]."""
        lowest = sorted(starts, key=lambda brick: starts[brick].position_W[::-1])
        self._form(Group({brick: starts[brick] for brick in lowest}, touching, MOVED * side))

    def _form(self, group: Group) -> None:
        if self.joiner is None:
            raise TypeError("this engine joins no bricks")
        self.joiner.join(tuple(group.starts))
        self._groups[group.first] = group
        self._first |= dict.fromkeys(group.starts, group.first)

    def release(self, brick: BodyId) -> None:
        """Let a brick, and those that touch it, move one by one; what else rode with it rides on, in parts."""
        group = self._groups[self._first[brick]]
        self.part(brick)
        left = {name for name in group.starts if name != brick and name not in group.touching[brick]}
        for part in components(left, lambda name: group.touching[name]):
            if len(part) >= FEWEST:
                self._form(replace(group, starts={name: pose for name, pose in group.starts.items() if name in part}))

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Take apart the group of a brick; these are its bricks."""
        if self.joiner is not None:
            self.joiner.part(brick)
        return self._strike(brick)

    def gone(self, bricks: Collection[BodyId]) -> None:
        """An engine that removes a brick takes apart the group in which it rode."""
        for brick in bricks:
            if brick in self:
                self._strike(brick)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._groups |= other._groups
        self._first |= other._first

    def _strike(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Strike the group of a brick from the record; these are its bricks."""
        group = self._groups.pop(self._first[brick])
        for member in group.starts:
            del self._first[member]
        return tuple(group.starts)

    def watched(self, awake: Iterable[BodyId]) -> list[BodyId]:
        """The bricks to watch: those that move one by one, and the first of each group."""
        return [brick for brick in awake if self._first.get(brick, brick) == brick]

    def members(self, first: BodyId) -> tuple[BodyId, ...]:
        """The bricks of the group that a watched brick stands for, or the brick alone."""
        return tuple(self._groups[first].starts) if first in self._groups else (first,)

    def moved_too_far(self, states: Mapping[BodyId, BodyState]) -> list[BodyId]:
        """The first bricks of the groups that have moved too far to be taken for rigid."""
        return [
            first
            for first, group in self._groups.items()
            if dist(states[first].pose.position_W, group.starts[first].position_W) > group.furthest
            or turn_between(group.starts[first], states[first].pose) > TURNED
        ]
