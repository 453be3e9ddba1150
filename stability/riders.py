"""Bricks that ride along: joined into one rigid body as long as it hardly moves, and looked at through one of them."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from math import dist

from stability.engine import Joining
from stability.geometry import turn_between
from stability.model import BodyId, BodyState, Pose

MOVED = 0.25  # share of the smallest side, 2 mm for a plank: further than that, a group is taken apart
TURNED = 0.0175  # [rad], 1 deg


@dataclass(frozen=True, slots=True)
class _Group:
    members: tuple[BodyId, ...]
    start: Pose  # of the first member
    furthest: float  # that it may move [m]


@dataclass
class Riders:
    """The joined bricks of one engine, in groups, each followed by its first brick."""

    joiner: Joining | None  # None if nothing ever rides
    _groups: dict[BodyId, _Group] = field(default_factory=dict, init=False)  # by the first of its members
    _first: dict[BodyId, BodyId] = field(default_factory=dict, init=False)  # of the group of each rider

    def __contains__(self, brick: object) -> bool:
        return brick in self._first

    @property
    def bricks(self) -> frozenset[BodyId]:
        """All that ride."""
        return frozenset(self._first)

    def join(self, bricks: Collection[BodyId], poses: Mapping[BodyId, Pose], smallest_side: float) -> None:
        """Let frozen bricks ride as one."""
        if self.joiner is None:
            raise TypeError("this engine joins no bricks")
        members = tuple(sorted(bricks, key=lambda brick: (poses[brick].position_W[2], brick)))
        self.joiner.join(members)
        self._groups[members[0]] = _Group(members, poses[members[0]], MOVED * smallest_side)
        self._first |= dict.fromkeys(members, members[0])

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Take apart the group of a brick; these are its bricks."""
        group = self._groups.pop(self._first[brick])
        if self.joiner is not None:
            self.joiner.part(brick)
        for member in group.members:
            del self._first[member]
        return group.members

    def followed(self, awake: Iterable[BodyId]) -> list[BodyId]:
        """The bricks to look at: those that move one by one, and the first of each group."""
        return sorted(brick for brick in awake if self._first.get(brick, brick) == brick)

    def members(self, first: BodyId) -> tuple[BodyId, ...]:
        """The bricks that one that is followed stands for."""
        return self._groups[first].members if first in self._groups else (first,)

    def strayed(self, states: Mapping[BodyId, BodyState]) -> list[BodyId]:
        """The first bricks of the groups that have moved too far to be taken for rigid."""
        return [
            first
            for first, group in self._groups.items()
            if dist(states[first].pose.position_W, group.start.position_W) > group.furthest
            or turn_between(group.start, states[first].pose) > TURNED
        ]
