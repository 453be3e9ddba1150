"""Every brick as the author wrote it, layouts taken apart, in the frame of the scene."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import cos, sin
from typing import Final, Protocol

from stability.geometry.rotations import multiply, rotate
from stability.geometry.vectors import subtract
from stability.model import BodyId, ConvexShape, Pose, Quaternion, Vec3
from stability.shapes.off_centre_box import MIDDLE
from stackdsl.language.brick_forms import laid
from stackdsl.language.bricks import BrickKind, SetBrick
from stackdsl.language.layouts.registry import BrickSpec, place
from stackdsl.language.schema import BuildStep, Scenario
from stackdsl.reading.source import Path

DIGITS: Final = 12  # of a metre: what sums of decimals lose is far below


class NowhereError(Exception):
    """A brick is to lie by another one that does not stand before it."""

    def __init__(self, name: BodyId, too_dear: bool = False) -> None:
        super().__init__(name)
        self.name, self.too_dear = name, too_dear


class Whereabouts(Protocol):
    """Knows where a brick lies that is placed by others."""

    def place_of(
        self, brick: SetBrick, shape: ConvexShape, turned: Quaternion, before: "Sequence[WrittenBrick]"
    ) -> tuple[Vec3, tuple[int, ...]]:
        """Its centre of mass, and by number the bricks before it that it is placed by. Raises NowhereError."""
        ...


@dataclass(frozen=True, slots=True)
class WrittenBrick:
    """One brick as the author wrote it, in the frame of the scene."""

    path: Path  # of the brick, or of its layout, in the file
    step: int
    shape: ConvexShape
    mass: float
    pose: Pose
    kind: BrickKind
    level: int | None  # None if it is to be judged by what it stands on
    name: str | None
    friction: float | None = None  # of its own, if its author wrote one for it rather than for its kind
    drop: bool = False
    together: bool = False  # whether it is set down at one moment with the brick before it
    within: str | None = None  # the name of its step
    passed: int = 0  # how many bricks of its level are left out just before it
    placed_by: tuple[int, ...] = ()  # the bricks on or beside which it was to lie, by number
    lost: NowhereError | None = None  # where one of these is not there; then its own place means nothing

    @property
    def of_layout(self) -> bool:
        """Whether a layout made it, so that its level is none that the author wrote."""
        return "bricks" not in self.path and not self.inserted

    @property
    def inserted(self) -> bool:
        """Whether it is slid in by an impact, rather than built."""
        return self.path[0] == "impacts"


def bricks_of(scenario: Scenario, whereabouts: Whereabouts) -> list[WrittenBrick]:
    """All bricks in the author's order, step after step; impacts are steps after those of the build."""
    made: list[WrittenBrick] = []
    for number, step in enumerate(scenario.build):
        made += _bricks_of_layout(number, step, scenario)
        for index, brick in enumerate(step.bricks or ()):
            path: Path = ("build", number, "bricks", index)
            set_down = _set_brick(path, number, brick, step.brick or scenario.brick, made, whereabouts)
            made.append(replace(set_down, name=_prefixed(step, brick.name), drop=brick.drop, within=step.name))
    for number, impact in enumerate(scenario.impacts):
        if impact.done.slid_in is not None:
            turn, path = len(scenario.build) + number, ("impacts", number, impact.kind)
            made.append(_set_brick(path, turn, impact.done.slid_in, scenario.brick, made, whereabouts))
    return made


def _bricks_of_layout(number: int, step: BuildStep, scenario: Scenario) -> Iterator[WrittenBrick]:
    kind = step.brick or scenario.brick
    if step.layout is not None:
        name, params = step.layout
        for spec in place(name, params, kind.form.size):
            form, own = laid(kind.form, spec), _prefixed(step, spec.name)
            path: Path = ("build", number, name)
            point = form.middle if spec.outline is None else form.origin
            mass, pose = kind.mass_of(form), _set_back(pose_of(spec), point)
            made = WrittenBrick(path, number, form.shape, mass, pose, kind, spec.level, own, together=spec.together)
            yield replace(made, within=step.name, passed=spec.passed)


def pose_of(spec: BrickSpec) -> Pose:
    """The pose of a brick of a layout."""
    if spec.lean == 0.0:
        return Pose(spec.position, about_z(spec.yaw))
    sine, cosine = half_turn(spec.lean)
    return Pose(spec.position, multiply(about_z(spec.yaw), (0.0, sine, 0.0, cosine)))


def _set_brick(  # noqa: PLR0913, PLR0917 -- a brick, and all that it may depend on
    path: Path,
    step: int,
    brick: SetBrick,
    kind: BrickKind,
    before: Sequence[WrittenBrick],
    whereabouts: Whereabouts,
) -> WrittenBrick:
    made_of = brick.brick or kind
    form, turned = made_of.form, about_axes(brick.rotate)
    pose, lost = _set_back(Pose(brick.at or (0.0, 0.0, 0.0), turned), form.origin), None
    placed_by: tuple[int, ...] = ()
    if brick.at is None:
        try:
            centre, placed_by = whereabouts.place_of(brick, form.shape, turned, before)
            pose = Pose(centre, turned)
        except NowhereError as error:
            lost = error
    mass = made_of.mass_of(form)
    own = brick.friction
    return WrittenBrick(
        path, step, form.shape, mass, pose, made_of, brick.level, brick.name, own, placed_by=placed_by, lost=lost
    )


def _set_back(pose: Pose, point: Vec3) -> Pose:
    """The pose of a brick of which a point, seen from its centre of mass in its own axes, is to be in a place."""
    if point == MIDDLE:
        return pose
    x, y, z = subtract(pose.position_W, rotate(pose.orientation, point))
    return Pose((round(x, DIGITS), round(y, DIGITS), round(z, DIGITS)), pose.orientation)


def _prefixed(step: BuildStep, name: str | None) -> str | None:
    return f"{step.name}.{name}" if step.name and name else name


def about_z(angle: float) -> Quaternion:
    """The turn by an angle about the vertical [rad]."""
    sine, cosine = half_turn(angle)
    return (0.0, 0.0, sine, cosine)


def half_turn(angle: float) -> tuple[float, float]:
    """Sine and cosine of half an angle, rounded to where processors agree on them."""
    return round(sin(angle / 2.0), 15), round(cos(angle / 2.0), 15)


def about_axes(angles: Vec3) -> Quaternion:
    """The turn about x, then y, then z, the axes of the scene [rad]."""
    (sin_x, cos_x), (sin_y, cos_y) = half_turn(angles[0]), half_turn(angles[1])
    return multiply(about_z(angles[2]), multiply((0.0, sin_y, 0.0, cos_y), (sin_x, 0.0, 0.0, cos_x)))
