"""Pushes of bricks that are there, at points that are on them."""

from collections.abc import Mapping

from stability.geometry import turned
from stability.model import BodyId, Vec3
from stability.vectors import dot, norm
from stackdsl.compiling.fitting import OVERLAP
from stackdsl.compiling.scheduling import Moment
from stackdsl.compiling.standing import MissError, Scene, Standing, missing
from stackdsl.language.impacts import Push as WrittenPush
from stackdsl.timeline import Push


def pushed(push: WrittenPush, flying: Mapping[BodyId, Moment], scene: Scene) -> Push:
    """The push, of a brick of the structure or of one that came `flying` before. Raises MissError."""
    brick = next((brick for brick in scene.bricks if brick.name == push.brick), None)
    if brick is None:
        _await(push.brick, flying[push.brick], scene)
    elif not brick.is_there(scene.moment):
        raise missing(push.brick, scene, "brick")
    elif not brick.let_go:
        _touch(push.point, brick)
    return Push(scene.moment.time, push.brick, turned(scene.tilt, push.impulse), turned(scene.tilt, push.point))


def _await(name: BodyId, comes: Moment, scene: Scene) -> None:
    if comes > scene.moment:
        message = f"brick '{name}' comes at {comes.time:g} s, not before {scene.moment.time:g} s"
        raise MissError("brick", "SD204", message, "push it later")


def _touch(point: Vec3, brick: Standing) -> None:
    """Raise MissError if a point, from the centre of a brick, is not in it."""
    sides = zip(brick.shape.axes_W, brick.shape.half_edges_W, strict=True)
    beyond = max(abs(dot(point, axis)) - norm(half) for axis, half in sides)
    if beyond > OVERLAP:
        message = f"the point is {1000.0 * beyond:.4g} mm outside brick '{brick.name}'"
        raise MissError("point", "SD207", message, "write it from the centre of the brick, in the axes of the scene")
