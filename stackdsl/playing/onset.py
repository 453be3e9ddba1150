"""How does what statics proves to fall begin to fall? Its bricks before, and when the first has turned by 5 deg."""

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import radians

from stability.geometry.rotations import turn_between
from stability.geometry.vectors import add, cross, norm, subtract
from stability.model import BodyId, BodyState, Plane, Pose
from stability.statics.facts import Contact, Motion, Placed, Tolerances, Verdict
from stackdsl.trace import Onset

BEGUN = radians(5.0)  # a turn that shows how something falls, before what it meets changes that
STUCK = 1e-2  # share of the largest speed: a point that moves less against what stands still is turned about


@dataclass
class OnsetWatch:
    """Follows the bricks that the last proof of a fall names."""

    motion: Motion | None = None
    onset: Onset | None = None
    _start: dict[BodyId, Pose] = field(default_factory=dict)
    _about: tuple[BodyId, ...] = ()

    @property
    def waiting(self) -> bool:
        """Whether something is about to fall, and has not turned far enough."""
        return self.onset is None and self.motion is not None

    def proven(
        self,
        verdict: Verdict,
        bricks: Mapping[BodyId, Placed],
        planes: Sequence[Plane],
        awake: Container[BodyId],
    ) -> None:
        """Something was set down, or taken out, and judged; `bricks` are all that are there, some of them `awake`."""
        if self.onset is not None or verdict.motion is self.motion:
            return
        if verdict.motion is None and any(name in awake for name in self._start):
            return  # what stands elsewhere holds up nothing of what has begun to fall
        self.motion = verdict.motion
        self._start = {}
        if self.motion is not None:
            self._start = {name: bricks[name].pose for name in self.motion.velocity}
            self._about = turned_about(self.motion, bricks, planes)

    def see(self, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves."""
        if self.motion is None or self.onset is not None:
            return
        poses = {name: (pose, states[name].pose) for name, pose in self._start.items() if name in states}
        if max((turn_between(*pair) for pair in poses.values()), default=0.0) >= BEGUN:
            self.onset = Onset(self.motion, poses, self._about)


def turned_about(motion: Motion, bricks: Mapping[BodyId, Placed], planes: Sequence[Plane]) -> tuple[BodyId, ...]:
    """What stands still where something that moves touches it and does not slip, by name."""
    fastest = max((_speed(motion, bricks[name]) for name in motion.velocity), default=0.0)
    found = set()
    for mover, other, contact in _contacts(motion, bricks, planes):
        velocity, spin = motion.velocity[mover]
        centre = bricks[mover].pose.position_W
        slips = (norm(add(velocity, cross(spin, subtract(point, centre)))) for point in contact.points_W)
        if min(slips) <= STUCK * fastest:
            found.add(other)
    return tuple(sorted(found))


def _speed(motion: Motion, placed: Placed) -> float:
    """At most, of any point of a brick."""
    velocity, spin = motion.velocity[placed.brick.id]
    return norm(velocity) + norm(spin) * placed.brick.shape.bounding_radius


def _contacts(
    motion: Motion, bricks: Mapping[BodyId, Placed], planes: Sequence[Plane]
) -> Iterable[tuple[BodyId, BodyId, Contact]]:
    """Each contact of a brick that moves with a body that does not: the brick, the body, and where they touch."""
    from stability.statics.contacts.touch import (  # noqa: PLC0415 -- where nothing is proven, nobody needs it
        contact_between,
        contact_with_plane,
        solid,
    )

    still = [solid(placed) for name, placed in bricks.items() if name not in motion.velocity]
    tolerances, any_friction = Tolerances(), 0.0
    for name in motion.velocity:
        mover = solid(bricks[name])
        touching = [(plane.id, contact_with_plane(mover, plane, tolerances)) for plane in planes]
        touching += [(other.id, contact_between(mover, other, any_friction, tolerances)) for other in still]
        yield from ((name, other, contact) for other, contact in touching if contact is not None)
