"""Pushes of bricks that are there, at points that are on them."""

from stability.geometry.rotations import rotate
from stability.geometry.vectors import add, norm
from stability.model import BodyId, Vec3
from stability.shapes.apart import how_far_outside
from stackdsl.compiling.fitting import OVERLAP
from stackdsl.compiling.impacts.actions import actions_of
from stackdsl.compiling.impacts.scene import MissError, Scene, Standing, missing
from stackdsl.compiling.moment import Moment
from stackdsl.language.impacts.push import Push as WrittenPush
from stackdsl.language.quantities import SPEED
from stackdsl.timeline import Push
from stackdsl.wording import mm, rounded_down

TURNED = 1e-12  # how much longer the rounding of a turn may make an impulse


@actions_of.register
def pushed(push: WrittenPush, scene: Scene) -> tuple[Push, ...]:
    """The push, of a brick of the structure or of one that came flying before. Raises MissError."""
    brick = next((brick for brick in scene.bricks if brick.name == push.brick), None)
    if brick is None:
        _await(push.brick, scene.flying[push.brick].since, scene)
    elif not brick.is_there(scene.moment):
        raise missing(push.brick, scene, "brick")
    elif not brick.let_go:
        _touch(push.point, brick)
    impulse_W, offset_W = rotate(scene.tilt, push.impulse), rotate(scene.tilt, push.point)
    return (Push(scene.moment.time, push.brick, impulse_W, offset_W),)


def _await(name: BodyId, comes: Moment, scene: Scene) -> None:
    if comes > scene.moment:
        message = f"brick '{name}' comes at {comes.time:g} s, not before {scene.moment.time:g} s"
        raise MissError("brick", "SD204", message, "push it later")


def _touch(point: Vec3, brick: Standing) -> None:
    """Raise MissError if a point, from the centre of a brick, is not in it."""
    beyond = how_far_outside(brick.shape, add(brick.centre, point))
    if beyond > OVERLAP:
        message = f"the point is {mm(beyond)} outside brick '{brick.name}'"
        raise MissError("point", "SD207", message, "write it from the centre of the brick, in the axes of the scene")


def limit_push(push: Push, scene: Scene) -> None:
    """Raise MissError if a push gives a brick no speed, or more than a thrown one may have, whatever kind it is of."""
    brick = next((brick for brick in scene.bricks if brick.name == push.brick), None)
    mass = scene.flying[push.brick].brick.mass if brick is None else brick.mass
    speed, most = norm(push.impulse_W) / mass, float(SPEED.most)
    if 0.0 < speed <= most * (1.0 + TURNED):
        return
    message = f"the push gives brick '{push.brick}' {speed:.4g} m/s, and it must be more than 0, at most {most:g} m/s"
    hint = f"write more than 0, at most {rounded_down(1000.0 * mass * most)} mN*s"
    raise MissError("impulse", "SD104", message, hint)
