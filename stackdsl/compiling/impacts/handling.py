"""Bricks that hands move or hold, and let go."""

from math import sqrt

from stability.geometry.rotations import rotate
from stability.model import BodyId
from stackdsl.compiling.impacts.actions import actions_of
from stackdsl.compiling.impacts.scene import MissError, Scene, missing
from stackdsl.language.impacts.hold import Hold as WrittenHold
from stackdsl.language.impacts.move import Move as WrittenMove
from stackdsl.timeline import Hold, LetGo, Move
from stackdsl.wording import MILLIMETRES, mm, rounded_down


@actions_of.register
def moved(move: WrittenMove, scene: Scene) -> tuple[Move | Hold | LetGo, ...]:
    """The way of the hand, and its end. Raises MissError."""
    _reach_for(move.brick, scene)
    limit_speed(move.speed, scene)
    course = move.course
    turned = tuple(rotate(scene.tilt, place) for place in course.places_W)
    begins, arrives = scene.moment.time, scene.moment.time + course.duration
    held = (Hold(arrives, (move.brick,)),) if move.held else ()
    course_W = type(course)(turned, course.speed)
    free_W = rotate(scene.tilt, (0.0, 0.0, 1.0)) if move.slid else None
    return (Move(begins, move.brick, course_W, free_W), *held, LetGo(begins + move.lasts, (move.brick,)))


@actions_of.register
def held(hold: WrittenHold, scene: Scene) -> tuple[Hold | LetGo, ...]:
    """From when to when it is held. Raises MissError."""
    _reach_for(hold.brick, scene)
    begins = scene.moment.time
    return (Hold(begins, (hold.brick,)), LetGo(begins + hold.for_, (hold.brick,)))


def _reach_for(name: BodyId, scene: Scene) -> None:
    """Raise MissError if a brick is not there by then."""
    brick = next((brick for brick in scene.bricks if brick.name == name), None)
    if brick is not None:
        if not brick.is_there(scene.moment):
            raise missing(name, scene, "brick")
    elif (comes := scene.flying[name].since) > scene.moment:
        message = f"brick '{name}' comes at {comes.time:g} s, not before {scene.moment.time:g} s"
        raise MissError("brick", "SD204", message, "begin later")


def limit_speed(speed: float, scene: Scene) -> None:
    """Raise MissError if a hand is faster than a brick gets that falls by the thickness of the thinnest of all.

    Up to there a brick that is pushed moves by a share of its thickness in a step of any system; what is faster hits.
    """
    sizes = [(brick.shape.thickness, brick.name) for brick in scene.bricks]
    sizes += [(flying.brick.shape.least_thickness, name) for name, flying in scene.flying.items()]
    thinnest, name = min(sizes)
    most = sqrt(2.0 * scene.gravity * thinnest)
    if speed > most:
        what = f"what is as thin as brick '{name}', {mm(thinnest)}"
        message = f"a hand that moves at {speed:g} m/s hits rather than pushes {what}"
        hint = f"write at most {rounded_down(MILLIMETRES * most)} mm/s; for more there are `push` and `throw`"
        raise MissError("speed", "SD104", message, hint)
