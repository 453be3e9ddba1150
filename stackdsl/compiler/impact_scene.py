"""What stands where when something hits it, as the author put it, in the frame of the scene."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import fsum, hypot

from stability.geometry.placed_shape import InPlace, apart_from_plane, in_place
from stability.model import BodyId, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.compiler.bricks import START, ActionOrder
from stackdsl.compiler.fit import OVERLAP
from stackdsl.compiler.schedule import Built
from stackdsl.language.impacts import Aim
from stackdsl.language.quantities import MistakeError
from stackdsl.wording import mm


@dataclass(frozen=True, slots=True)
class StandingBrick:
    """One brick of the structure, and while it is there."""

    name: BodyId
    level: int
    shape: InPlace
    centre: Vec3  # of its mass [m]
    mass: float  # [kg]
    since: ActionOrder
    until: ActionOrder | None  # when it is pulled out
    let_go: bool  # in the air, so where it is later is not known before

    def is_there(self, moment: ActionOrder) -> bool:
        """Whether it is placed by then, and not yet pulled out."""
        return self.since < moment and (self.until is None or moment < self.until)


@dataclass(frozen=True, slots=True)
class FlyingBrick:
    """A brick that an impact throws or drops."""

    since: ActionOrder
    brick: Brick


@dataclass(frozen=True, slots=True)
class ImpactScene:
    """What an impact happens in."""

    moment: ActionOrder
    bricks: Sequence[StandingBrick]  # all that are ever built, in the frame of the scene
    flying: Mapping[BodyId, FlyingBrick]  # all that ever come from outside
    planes: Sequence[Plane]  # in the frame of the scene
    gravity: float  # [m/s2], along -z of W
    tilt: Quaternion  # from the frame of the scene to W
    missile: Brick | None = None  # what comes with this impact, if it has one

    @property
    def resting(self) -> list[StandingBrick]:
        """The bricks whose place is known."""
        return [brick for brick in self.bricks if brick.is_there(self.moment) and not brick.let_go]


def on_the_way(moving: InPlace, direction: Vec3, scene: ImpactScene) -> Iterator[StandingBrick]:
    """The bricks that a body may meet which goes in a unit direction: of a tower, most lie beside the way."""
    (px, py, pz), (dx, dy, dz), own = moving.middle_W, direction, hypot(*moving.reach)
    for brick in scene.resting:
        (mx, my, mz), reach = brick.shape.middle_W, brick.shape.reach
        x, y, z = mx - px, my - py, mz - pz
        if hypot(y * dz - z * dy, z * dx - x * dz, x * dy - y * dx) <= own + hypot(*reach):
            yield brick


class MissError(MistakeError):
    """A hit that cannot be as it is written, by one of its keys."""

    def __init__(self, key: str, code: str, message: str, hint: str) -> None:
        super().__init__(code, message, hint)
        self.key = key


def scene_of(built: Built, gravity: float, tilt: Quaternion) -> ImpactScene:
    """What all impacts happen in, at the start; gravity in m/s2, and the tilt as in `ImpactScene`."""
    comes = {brick.id: FlyingBrick(built.impacts[number], brick) for number, brick in built.missiles.items()}
    return ImpactScene(START, tuple(_standing(built)), comes, built.planes, gravity, tilt)


def _standing(built: Built) -> Iterator[StandingBrick]:
    for brick in built.bricks:
        made = brick.written
        shape = in_place(made.shape, made.pose)
        yield StandingBrick(
            brick.name, brick.level, shape, made.pose.position_W, made.mass, brick.placed, brick.gone, made.drop
        )


def aimed_at(aim: Aim, scene: ImpactScene, key: str) -> list[StandingBrick]:
    """The bricks that are meant: one, or those of a level that stand by then. A name must be that of some brick."""
    meant = [brick for brick in scene.resting if brick.name == aim.brick or brick.level == aim.level]
    if meant:
        return meant
    if aim.level is None:
        raise missing(aim.brick or "", scene, key)
    highest = max((brick.level for brick in scene.resting), default=0)
    hint = f"take a level up to {highest}, or begin later" if highest else "begin later"
    raise MissError(key, "SD205", f"no brick of level {aim.level} stands at {scene.moment.time:g} s", hint)


def missing(name: BodyId, scene: ImpactScene, key: str) -> MissError:
    """Why nobody knows where a brick is."""
    time, brick = scene.moment.time, next((brick for brick in scene.bricks if brick.name == name), None)
    if brick is None or (brick.let_go and brick.is_there(scene.moment)):
        message = f"brick '{name}' comes flying or falling, so where it is at {time:g} s is not known before"
        return MissError(key, "SD204", message, "take one that was set down")
    if brick.since < scene.moment:
        return MissError(key, "SD204", f"brick '{name}' is pulled out by {time:g} s", "take another, or begin earlier")
    hint = f"begin later, such as `after: brick {name} + 1 s`"
    return MissError(key, "SD204", f"brick '{name}' is placed at {brick.since.time:g} s, not before {time:g} s", hint)


def middle_of(bricks: Sequence[StandingBrick]) -> Vec3:
    """The mean of their middles [m]."""
    x, y, z = (fsum(along) / len(bricks) for along in zip(*(brick.shape.middle_W for brick in bricks), strict=True))
    return (x, y, z)


def keep_out_of_planes(brick: Brick, pose: Pose, scene: ImpactScene, key: str) -> None:
    """Raise MissError if a brick starts inside the ground or a wall."""
    for plane in scene.planes:
        gap = apart_from_plane(brick.shape, pose, plane).gap
        if gap < -OVERLAP:
            message = f"brick '{brick.id}' starts {mm(-gap)} inside {plane.id}"
            raise MissError(key, "SD201", message, "let it start elsewhere, or turn it, or aim elsewhere")
