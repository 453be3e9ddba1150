"""The scene of an impact: the bricks at their written poses, in the scene frame."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import fsum, hypot

from stability.geometry.placed_shape import InPlace, apart_from_plane, in_place
from stability.model import BodyId, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.compiler.bricks import START, ActionOrder
from stackdsl.compiler.fit import OVERLAP
from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.language.impacts import Aim
from stackdsl.language.quantities import InputError
from stackdsl.wording import mm


@dataclass(frozen=True, slots=True)
class StandingBrick:
    """A brick of the structure, and the time for which it is present."""

    name: BodyId
    level: int
    shape: InPlace
    centre: Vec3  # centre of mass [m]
    mass: float  # [kg]
    since: ActionOrder
    until: ActionOrder | None  # its removal
    let_go: bool  # released in the air, so its later position is unknown before the run

    def is_there(self, moment: ActionOrder) -> bool:
        """Whether it is placed before the moment, and not pulled out yet."""
        return self.since < moment and (self.until is None or moment < self.until)


@dataclass(frozen=True, slots=True)
class FlyingBrick:
    """A brick that an impact throws or drops."""

    since: ActionOrder
    brick: Brick


@dataclass(frozen=True, slots=True)
class ImpactScene:
    """The bricks and planes of a scenario at the time of an impact."""

    moment: ActionOrder
    bricks: Sequence[StandingBrick]  # all of the structure, whenever present, in the scene frame
    flying: Mapping[BodyId, FlyingBrick]  # all thrown and dropped ones
    planes: Sequence[Plane]  # in the scene frame
    gravity: float  # [m/s2], along -z of W
    tilt: Quaternion  # from the scene frame to W
    missile: Brick | None = None  # thrown or dropped by this impact

    @property
    def resting(self) -> list[StandingBrick]:
        """The present bricks with known positions."""
        return [brick for brick in self.bricks if brick.is_there(self.moment) and not brick.let_go]


def on_the_way(moving: InPlace, direction: Vec3, scene: ImpactScene) -> Iterator[StandingBrick]:
    """Yield the bricks that a body may meet on its path along a unit direction; excludes most bricks of a tower."""
    (px, py, pz), (dx, dy, dz), own = moving.middle_W, direction, hypot(*moving.reach)
    for brick in scene.resting:
        (mx, my, mz), reach = brick.shape.middle_W, brick.shape.reach
        x, y, z = mx - px, my - py, mz - pz
        if hypot(y * dz - z * dy, z * dx - x * dz, x * dy - y * dx) <= own + hypot(*reach):
            yield brick


class MissError(InputError):
    """An impact cannot happen as written; carries the key at fault."""

    def __init__(self, key: str, code: str, message: str, hint: str) -> None:
        super().__init__(code, message, hint)
        self.key = key


def scene_of(built: ResolvedScenario, gravity: float, tilt: Quaternion) -> ImpactScene:
    """Return the scene of all impacts at the start; `gravity` and `tilt` as in `ImpactScene`."""
    flying = {brick.id: FlyingBrick(built.impacts[number], brick) for number, brick in built.missiles.items()}
    return ImpactScene(START, tuple(_standing(built)), flying, built.planes, gravity, tilt)


def _standing(built: ResolvedScenario) -> Iterator[StandingBrick]:
    for brick in built.bricks:
        written = brick.written
        shape = in_place(written.shape, written.pose)
        yield StandingBrick(
            brick.name,
            brick.level,
            shape,
            written.pose.position_W,
            written.mass,
            brick.placed,
            brick.removed,
            written.drop,
        )


def aimed_at(aim: Aim, scene: ImpactScene, key: str) -> list[StandingBrick]:
    """Return the target bricks: one by name, or the present ones of a level. Raises MissError."""
    targets = [brick for brick in scene.resting if brick.name == aim.brick or brick.level == aim.level]
    if targets:
        return targets
    if aim.level is None:
        raise missing(aim.brick or "", scene, key)
    highest = max((brick.level for brick in scene.resting), default=0)
    hint = f"write a level up to {highest}, or begin later" if highest else "begin later"
    raise MissError(key, "SD205", f"no brick of level {aim.level} stands at {scene.moment.time:g} s", hint)


def missing(name: BodyId, scene: ImpactScene, key: str) -> MissError:
    """Return the error for a brick whose position is unknown."""
    time, brick = scene.moment.time, next((brick for brick in scene.bricks if brick.name == name), None)
    if brick is None or (brick.let_go and brick.is_there(scene.moment)):
        message = f"brick '{name}' flies or falls, so its position at {time:g} s is unknown before the run"
        return MissError(key, "SD204", message, "refer to a brick that is set down")
    if brick.since < scene.moment:
        return MissError(
            key,
            "SD204",
            f"brick '{name}' is no longer present at {time:g} s, since it is pulled out earlier",
            "refer to another brick, or begin earlier",
        )
    hint = f"begin later, such as `after: brick {name} + 1 s`"
    return MissError(
        key,
        "SD204",
        f"brick '{name}' is not placed before {brick.since.time:g} s, but this impact begins at {time:g} s",
        hint,
    )


def middle_of(bricks: Sequence[StandingBrick]) -> Vec3:
    """Return the mean of the midpoints of bricks [m]."""
    x, y, z = (fsum(along) / len(bricks) for along in zip(*(brick.shape.middle_W for brick in bricks), strict=True))
    return (x, y, z)


def keep_out_of_planes(brick: Brick, pose: Pose, scene: ImpactScene, key: str) -> None:
    """Raise MissError if a brick starts inside the ground or a wall."""
    for plane in scene.planes:
        gap = apart_from_plane(brick.shape, pose, plane).gap
        if gap < -OVERLAP:
            message = f"brick '{brick.id}' starts {mm(-gap)} inside {plane.id}"
            raise MissError(key, "SD201", message, "change its start, its rotation or its target")
