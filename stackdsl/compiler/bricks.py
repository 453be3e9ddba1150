"""Places, names and levels of every brick of a scenario."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import cos, fsum, inf, sin
from types import MappingProxyType
from typing import Final, NamedTuple, Protocol

from stability.geometry.box import MIDDLE
from stability.geometry.placed_shape import in_place
from stability.geometry.vectors import dot, inverse, multiply, rotate, subtract
from stability.model import GROUND, BodyId, ConvexShape, Plane, Pose, Quaternion, Vec3
from stackdsl.compiler.fit import CrowdedError, Fit, PlacementIndex, Sited, fits
from stackdsl.language.bricks import BrickKind, SetBrick, laid
from stackdsl.language.layouts.registry import BrickSpec, place
from stackdsl.language.schema import BuildStep, Scenario
from stackdsl.language.yaml.source import KeyPath

# Every brick as the author wrote it, layouts taken apart, in the frame of the scene.


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

    path: KeyPath  # of the brick, or of its layout, in the file
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
            path: KeyPath = ("build", number, "bricks", index)
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
            path: KeyPath = ("build", number, name)
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
    path: KeyPath,
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


# Levels and names: by place, such as `L3.2`, unless the author gives his own.


class CrowdedBrickError(Exception):
    """A brick has so many others near it that it takes too long to say on what it stands."""

    def __init__(self, brick: WrittenBrick) -> None:
        super().__init__(brick.path)
        self.brick = brick


def footings_of(
    written: Sequence[WrittenBrick], planes: Sequence[Plane], removed_in: Mapping[int, int] = MappingProxyType({})
) -> list[Fit]:
    """What every brick stands on, for judging levels; nothing where layouts, which know theirs, are all there is.

    `removed_in` says of bricks, by number, in which step they are pulled out. Raises CrowdedBrickError.
    """
    if all(brick.of_layout for brick in written):
        return [Fit() for _ in written]
    # What a brick stands on does not depend on the clock, only on what the author put before it or in the same step.
    sited = [
        Sited(float(brick.step), brick.shape, brick.pose, until=float(removed_in.get(index, inf)))
        for index, brick in enumerate(written)
    ]
    try:
        return fits(sited, planes)
    except CrowdedError as error:
        raise CrowdedBrickError(written[error.index]) from error


def levels_of(written: Sequence[WrittenBrick], footings: Sequence[Fit]) -> list[int]:
    """The level of every brick: as written, or one above the highest that it stands on."""
    levels: dict[int, int] = {}
    for index in sorted(range(len(written)), key=lambda index: written[index].pose.position_W[2]):
        levels[index] = written[index].level or level_above(index, footings[index], written, levels)
    return [levels[index] for index in range(len(written))]


def level_above(
    index: int, footing: Fit, written: Sequence[WrittenBrick], levels: Mapping[int, int] | Sequence[int]
) -> int:
    """The level above the highest of those that a brick stands on, as far as their centres are lower than its own."""
    height = written[index].pose.position_W[2]
    below = (other for other in footing.on_boxes if (written[other].pose.position_W[2], other) < (height, index))
    return max((levels[other] for other in below), default=0) + 1


def names_of(
    written: Sequence[WrittenBrick], levels: Sequence[int], counts: Counter[tuple[str, int]] | None = None
) -> list[BodyId]:
    """The author's names, and `L3.2` for the second brick of level 3 in the author's order."""
    counted = Counter() if counts is None else counts
    return [name_by_place(brick, level, counted) for brick, level in zip(written, levels, strict=True)]


def name_by_place(brick: WrittenBrick, level: int, counts: Counter[tuple[str, int]]) -> BodyId:
    """The name of a brick that comes after those that are counted, by step and level; it is counted, too."""
    place = f"{brick.within}." if brick.within else ""
    counts[place, level] += 1 + brick.passed
    return brick.name or f"{place}L{level}.{counts[place, level]}"


# When something of a scenario happens, among all that happens at one time.


BUILD: Final = 0  # among what happens at one time, the build comes first, and then impact by impact


class ActionOrder(NamedTuple):
    """A time, and a place among what happens at that time."""

    time: float  # [s]
    turn: int = BUILD  # 1 for the first impact, and so on


START: Final = ActionOrder(0.0)


# Names by place of bricks that come one by one: each is asked for before the next one is known.


MAX_NAMED = 20_000  # bricks whose names are worked out anew, as others came to lie under them; a second


@dataclass(slots=True)
class IncrementalNaming:
    """Levels and names of the bricks so far, as `levels_of` and `names_of` would give them."""

    planes: Sequence[Plane]
    site: PlacementIndex = field(init=False)
    written: list[WrittenBrick] = field(default_factory=list)
    levels: list[int] = field(default_factory=list)
    counts: Counter[tuple[str, int]] = field(default_factory=Counter)
    named: dict[BodyId, int] = field(default_factory=dict)  # the first brick that is called so, by number
    cost: int = 0  # bricks whose names were worked out anew

    def __post_init__(self) -> None:
        self.site = PlacementIndex([], self.planes)

    def take_in(self, bricks: Sequence[WrittenBrick], asked: BodyId) -> None:
        """Take in those that are new, as a name is `asked` for. Raises NowhereError if that costs too much."""
        moved = False  # the level of an earlier brick
        for brick in bricks[len(self.written) :]:
            moved = self._add(brick) or moved
        if moved:
            self._name_all(asked)

    def _add(self, brick: WrittenBrick) -> bool:
        """Take in a brick; whether it lies under an earlier one, whose level it changes."""
        number = len(self.written)
        self.written.append(brick)
        self.site.blocks.append(in_place(brick.shape, brick.pose))
        self.levels.append(brick.level or 1)
        try:
            moved = brick.lost is None and self._stand(number, brick)
        except CrowdedError as error:
            raise CrowdedBrickError(brick) from error
        self.named.setdefault(name_by_place(brick, self.levels[number], self.counts), number)
        return moved

    def _stand(self, number: int, brick: WrittenBrick) -> bool:
        self.site.put(number)
        self.levels[number] = brick.level or self._level(number)
        return any(self._is_lifted(other, brick.step) for other in self.site.touching(number))

    def _level(self, number: int) -> int:
        return level_above(number, self.site.fit(number), self.written, self.levels)

    def _is_lifted(self, number: int, step: int) -> bool:
        """Whether a brick has come to stand higher; it rests on what is put in its own step, and on nothing later."""
        brick = self.written[number]
        return brick.step == step and brick.level is None and self._level(number) != self.levels[number]

    def _name_all(self, asked: BodyId) -> None:
        self.cost += len(self.written)
        if self.cost > MAX_NAMED:
            raise NowhereError(asked, too_dear=True)
        self.levels = levels_of(self.written, footings_of(self.written, self.planes))
        self.counts.clear()
        names = names_of(self.written, self.levels, self.counts)
        self.named = {called: number for number, called in reversed(list(enumerate(names)))}


# Where a brick lies that is placed by another one: `on` it, or `beside` it.


@dataclass(slots=True)
class EarlierBricks:
    """What bricks may be placed by: all that the author put before them."""

    planes: Sequence[Plane]
    standing: IncrementalNaming = field(init=False)
    named: dict[BodyId, int] = field(default_factory=dict)  # by the author
    seen: int = 0  # bricks whose own names are known

    def __post_init__(self) -> None:
        self.standing = IncrementalNaming(self.planes)

    def place_of(
        self, brick: SetBrick, shape: ConvexShape, turned: Quaternion, before: Sequence[WrittenBrick]
    ) -> tuple[Vec3, tuple[int, ...]]:
        """The centre of mass of a brick, and the bricks that it is placed by, by number. Raises NowhereError."""
        names = brick.on or ((brick.beside,) if brick.beside is not None else ())
        numbers = tuple(self._number(name, before) for name in names if name != GROUND)
        own = in_place(shape, Pose((0.0, 0.0, 0.0), turned))
        others = [in_place(before[number].shape, before[number].pose) for number in numbers]
        centres = [other.middle_W for other in others] or [(0.0, 0.0, 0.0)]
        x, y = (fsum(centre[axis] for centre in centres) / len(centres) for axis in (0, 1))
        top = max((other.high_W[2] for other in others), default=0.0)
        if brick.beside is not None:
            toward = (cos(brick.towards), sin(brick.towards), 0.0)
            apart = _reach(shape, turned, (-toward[0], -toward[1], 0.0)) + dot(own.middle_W, toward)
            other = before[numbers[0]]
            apart += _reach(other.shape, other.pose.orientation, toward)
            apart -= dot(subtract(others[0].middle_W, other.pose.position_W), toward)
            x, y, top = x + apart * toward[0], y + apart * toward[1], others[0].low_W[2]
        (dx, dy, dz), (mx, my, _) = brick.offset, own.middle_W
        place = (x - mx + dx, y - my + dy, top - own.low_W[2] + dz)
        return (round(place[0], DIGITS), round(place[1], DIGITS), round(place[2], DIGITS)), numbers

    def _number(self, name: BodyId, before: Sequence[WrittenBrick]) -> int:
        """The number of an earlier brick. Its name by place is worked out only if none is called so by its author."""
        for number in range(self.seen, len(before)):
            if (own := before[number].name) is not None:
                self.named.setdefault(own, number)
        self.seen = len(before)
        if name in self.named:
            return self.named[name]
        self.standing.take_in(before, name)
        if name not in self.standing.named:
            raise NowhereError(name)
        return self.standing.named[name]


def _reach(shape: ConvexShape, turned: Quaternion, direction: Vec3) -> float:
    """How far a shape reaches from its centre in a direction of the scene [m]."""
    return shape.reach(rotate(inverse(turned), direction))


def later_names(written: Sequence[WrittenBrick]) -> Mapping[BodyId, WrittenBrick]:
    """All bricks that their authors named."""
    return {brick.name: brick for brick in written if brick.name is not None}


# Every brick that is built or slid in: on what it stands, at which level, by which name, and while it is there.


class InHand(NamedTuple):
    """When a brick comes, is in its place, and is left to itself [s]: all at once, unless a hand brings it."""

    begins: float
    arrives: float
    let_go: float


AT_ONCE = InHand(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class BuiltBrick:
    """One brick of the structure."""

    written: WrittenBrick
    footing: Fit  # for judging levels; empty where layouts are all there is
    level: int
    name: BodyId
    removed_in: int | None  # the impact that pulls it out, by number
    placed: ActionOrder = START
    gone: ActionOrder | None = None  # when it is pulled out
    in_hand: InHand = AT_ONCE


def built_bricks(scenario: Scenario, planes: Sequence[Plane]) -> list[BuiltBrick]:
    """All bricks in the author's order, not yet with their times."""
    written = bricks_of(scenario, EarlierBricks(planes))
    removed: Mapping[int, int] = {}
    # Names say what is pulled out, which makes room for what is slid in, whose level then gives it its name.
    for _ in range(2 if scenario.impacts else 1):
        until = {index: len(scenario.build) + number for index, number in removed.items()}
        footings = footings_of(written, planes, until)
        levels = levels_of(written, footings)
        names = names_of(written, levels)
        removed = _removed_in(scenario, names)
    each = enumerate(zip(written, footings, levels, names, strict=True))
    return [BuiltBrick(*known, removed.get(index)) for index, known in each]


def _removed_in(scenario: Scenario, names: Sequence[BodyId]) -> Mapping[int, int]:
    """The impact that pulls out a brick, by the number of the brick."""
    numbers = {name: index for index, name in enumerate(names)} if scenario.impacts else {}
    return {
        numbers[named.name]: number
        for number, impact in enumerate(scenario.impacts)
        for named in impact.done.pulled_out
        if named.name in numbers
    }
