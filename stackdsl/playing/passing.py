"""Tunnelling: does a thrown brick pass through another one, because its engine steps too coarsely for its speed?

The centre of a rigid convex body can be in no other one. Between two looks that of a thrown brick is followed along
a straight line, as seen from the other brick; that errs by much less than the half thickness that any true way keeps.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import dist

from stability.geometry.rotations import inverse, rotate
from stability.geometry.vectors import dot, subtract
from stability.model import BodyId, BodyState, ConvexShape, Pose, Vec3
from stackdsl.playing.watch import Watch
from stackdsl.trace import Passed


@dataclass
class PassingWatch:
    """Looks for the first thrown brick that passes through another."""

    watch: Watch  # where all was when it was looked at last
    passed: Passed | None = None  # None while none has

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in what moves as it is now [s], before the watch does."""
        if self.passed is not None or not self.watch.dropped:
            return
        now = {name: state.pose for name, state in states.items()}
        self.passed = min(self._passed(time, now), default=(0.0, None), key=lambda each: each[0])[1]

    def _passed(self, time: float, now: Mapping[BodyId, Pose]) -> Iterator[tuple[float, Passed]]:
        """Each pair, with the share of the way after which the one enters the other."""
        for thrown in self.watch.dropped:
            name = thrown.placement.brick.id
            if not thrown.placement.hits or name not in now:
                continue
            before, after = thrown.last.position_W, now[name].position_W
            travel = dist(before, after)
            if travel <= 0.5 * thrown.placement.brick.shape.least_thickness:
                continue  # so slow that the engine sees the contact
            for other in self.watch.present:
                shape, was = self.watch.made_of[other].shape, self.watch.bricks[other].last
                pose = now.get(other, was)
                if other == name or dist(pose.position_W, after) > travel + shape.bounding_radius:
                    continue
                share = entry(shape, _seen_from(was, before), _seen_from(pose, after))
                if share is not None:
                    yield share, Passed(name, other, time, travel)


def entry(shape: ConvexShape, start: Vec3, end: Vec3) -> float | None:
    """The share of the straight way between two points, in body axes [m], after which it is inside a shape, if ever."""
    first, last = 0.0, 1.0
    for face in shape.faces:
        outside = dot(face.normal, subtract(start, shape.corners[face.corners[0]]))
        rises = dot(face.normal, subtract(end, start))
        if rises == 0.0:
            if outside >= 0.0:
                return None
        elif rises < 0.0:
            first = max(first, -outside / rises)
        else:
            last = min(last, -outside / rises)
    return first if first < last else None


def _seen_from(pose: Pose, point_W: Vec3) -> Vec3:
    return rotate(inverse(pose.orientation), subtract(point_W, pose.position_W))
