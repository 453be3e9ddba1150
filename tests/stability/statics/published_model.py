"""What the published model says of an assembly that stands still, without any engine.

Bricks join the stack one by one in the order in which they are set down: a brick joins if its centre of mass is above
its main contact, and what was set down on one that did not join has lost its support. Then the stack is tested as a
whole. The contacts are those that `StackStability` works out.
"""

from collections.abc import Iterable, Mapping, Sequence

from stability.model import GROUND, BodyId, HalfSpace, Pose, Shape, Vec3
from stability.problem import Placed
from stability.stabilizers.published.stabilizer import stacked_brick
from stability.stabilizers.published.support import (
    AS_READ,
    ContactLimits,
    Readings,
    StackedBrick,
    corners_on,
    failing,
    lies_above,
    loads_above,
)

FLOOR: tuple[Shape, Pose] = (HalfSpace((0.0, 0.0, 1.0)), Pose((0.0, 0.0, 0.0)))


def published_model_says_stable(bricks: Iterable[Placed], readings: Readings = AS_READ) -> bool:
    """Whether all of them join the stack, on level ground at height 0, and none fails in the finished stack."""
    stack: dict[BodyId, StackedBrick] = {}
    solids: dict[BodyId, tuple[Shape, Pose]] = {GROUND: FLOOR}
    for each in bricks:
        points = _points(each, solids)
        if not points:
            return False
        tested = stacked_brick(each.brick.id, each.brick.mass, each.pose.position_W, points)
        if not lies_above((tested.com_W[0], tested.com_W[1]), tested.main):
            return False
        stack[tested.id] = tested
        solids[tested.id] = (each.brick.shape, each.pose)
    return not failing(stack, loads_above(stack, readings))


def _points(each: Placed, solids: Mapping[BodyId, tuple[Shape, Pose]]) -> dict[BodyId, Sequence[Vec3]]:
    box, limits = each.brick.shape, ContactLimits()
    found = {name: corners_on(box, each.pose, shape, pose, limits) for name, (shape, pose) in solids.items()}
    return {name: points for name, points in found.items() if points}
