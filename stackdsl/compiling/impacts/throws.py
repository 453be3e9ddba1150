"""How a thrown brick flies: it leaves with the upward speed that brings it to the height of its aim as it arrives.

So it hits what it is aimed at from however far away it comes. It does not turn on its way.
"""

from math import cos, inf, sin, sqrt

from stability.geometry.rotations import rotate
from stability.geometry.vectors import add_scaled, scale, subtract
from stability.model import Brick, Pose, Vec3
from stability.shapes.apart import in_place, meeting
from stackdsl.compiling.fitting import OVERLAP
from stackdsl.compiling.impacts.actions import actions_of
from stackdsl.compiling.impacts.scene import MissError, Scene, aimed_at, keep_out_of_planes, middle_of, on_the_way
from stackdsl.compiling.site import turned_pose
from stackdsl.compiling.written_bricks import about_z
from stackdsl.language.impacts.throw import Throw
from stackdsl.language.quantities import SPEED
from stackdsl.timeline import Arrival, Placement
from stackdsl.wording import MILLIMETRES, rounded_down, rounded_up

ROUNDING = 1e-12  # of the speed, so that what is told to be allowed is


@actions_of.register
def thrown(throw: Throw, scene: Scene) -> tuple[Placement, ...]:
    """The brick where it begins to fly. Raises MissError."""
    brick = scene.missile
    assert brick is not None  # the kind says that it has one
    towards = _direction_from(throw.from_.bearing)
    start = _start(brick, throw, towards, scene)
    ahead_W = rotate(scene.tilt, towards)
    _limit_height(throw, ahead_W, scene)
    # After a time t it is at start + v t + g t^2 / 2, which at the end shall be straight ahead by the distance.
    duration, gravity_W = throw.from_.distance / throw.speed, (0.0, 0.0, -scene.gravity)
    velocity_W = subtract(scale(throw.speed, ahead_W), scale(0.5 * duration, gravity_W))
    pose = turned_pose(start, scene.tilt)
    return (Placement(scene.moment.time, brick, 0, pose, Arrival.THROWN, velocity_W, duration),)


def _limit_height(throw: Throw, ahead_W: Vec3, scene: Scene) -> None:
    """Raise MissError for a throw that rises or falls, as it leaves or arrives, faster than one may be thrown."""
    assert scene.missile is not None
    speed, distance, gravity = throw.speed, throw.from_.distance, scene.gravity
    climb, most = abs(ahead_W[2]), float(SPEED.most)
    fastest = climb * speed + 0.5 * gravity * (distance / speed)
    if fastest <= most * (1.0 + ROUNDING):
        return
    # Slower than the lesser root of climb s^2 - most s + g d / 2 = 0, it is in the air for too long.
    under_root = most * most - 2.0 * climb * gravity * distance
    slowest = gravity * distance / (most + sqrt(under_root)) if under_root >= 0.0 else inf
    nearest = 2.0 * (most - climb * speed) * speed / gravity
    remedies = [f"throw it at {rounded_up(slowest)} m/s or faster"] if speed < slowest <= most else []
    remedies += [f"from {rounded_down(MILLIMETRES * nearest)} mm or nearer"] if nearest > 0.0 else []
    message = f"brick '{scene.missile.id}' would rise and fall at up to {fastest:.4g} m/s, and {most:g} m/s is the most"
    raise MissError("speed", "SD104", message, ", or ".join(remedies) or "throw it more slowly, or from nearer")


def _direction_from(bearing: float) -> Vec3:
    """Of the flight along the ground, rounded to where processors agree on it."""
    return (0.0 - round(cos(bearing), 15), 0.0 - round(sin(bearing), 15), 0.0)


def _start(brick: Brick, throw: Throw, towards: Vec3, scene: Scene) -> Pose:
    """At the height of the aim, with its nose at the distance from what it meets first on the straight way there."""
    aim = middle_of(aimed_at(throw.at, scene, "at"))
    orientation = about_z(throw.from_.bearing + throw.turn)
    flying = in_place(brick.shape, Pose(aim, orientation))
    ways = [meeting(flying, other.shape, towards, OVERLAP) for other in on_the_way(flying, towards, scene)]
    nearest = min((way[0] for way in ways if way is not None), default=None)
    if nearest is None:
        hint = "aim at a brick, take another bearing, or `turn: 90 deg` to let it come broadside"
        raise MissError("at", "SD207", f"nothing is in the way of brick '{brick.id}'", hint)
    start = Pose(add_scaled(aim, nearest - throw.from_.distance, towards), orientation)
    keep_out_of_planes(brick, start, scene, "from")
    return start
