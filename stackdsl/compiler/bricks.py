"""Computes the pose, the name and the level of every brick of a scenario."""

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
from stackdsl.compiler.fit import CrowdedError, Fit, PlacementIndex, TimedShape, fits
from stackdsl.language.bricks import BrickKind, Form, SetBrick, laid
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, MortaredParams, place
from stackdsl.language.rotations import about_axes, about_z, half_turn
from stackdsl.language.schema import BuildStep, Scenario
from stackdsl.language.yaml.source import KeyPath

# The bricks in the order of the file, with layouts expanded, in the scene frame.


DIGITS: Final = 12  # decimals of a metre; far more than the rounding error of sums of decimals


class MissingNeighbourError(Exception):
    """A brick is placed on or beside a brick that does not come before it."""

    def __init__(self, name: BodyId, too_costly: bool = False) -> None:
        super().__init__(name)
        self.name, self.too_costly = name, too_costly


class PlacementResolver(Protocol):
    """Computes the positions of bricks that are placed on or beside others."""

    def place_of(
        self, brick: SetBrick, shape: ConvexShape, turned: Quaternion, before: "Sequence[WrittenBrick]"
    ) -> tuple[Vec3, tuple[int, ...]]:
        """Return the centre of mass and the indices of the neighbours in `before`. Raises MissingNeighbourError."""
        ...


@dataclass(frozen=True, slots=True)
class WrittenBrick:
    """A brick as written in the file, in the scene frame."""

    path: KeyPath  # to the brick, or to its layout
    step: int  # index; impacts follow the build steps
    shape: ConvexShape
    mass: float
    pose: Pose
    kind: BrickKind
    level: int | None  # None to compute it from the supports
    name: str | None
    friction: float | None = None  # Coulomb coefficient of this brick; None for that of its kind
    drop: bool = False
    together: bool = False  # whether it is set down at the same time as the previous brick
    within: str | None = None  # name of its step
    passed: int = 0  # number of bricks of its level that the layout leaves out just before it
    placed_by: tuple[int, ...] = ()  # indices of the bricks on or beside which it is placed
    lost: MissingNeighbourError | None = None  # if one of these is missing; then the pose is meaningless

    @property
    def of_layout(self) -> bool:
        """Whether a layout generated it, so the author did not write its level."""
        return "bricks" not in self.path and not self.inserted

    @property
    def inserted(self) -> bool:
        """Whether an impact slides it in, rather than a build step placing it."""
        return self.path[0] == "impacts"


def bricks_of(scenario: Scenario, resolver: PlacementResolver) -> list[WrittenBrick]:
    """Return all bricks in file order; impacts count as steps after the build steps."""
    bricks: list[WrittenBrick] = []
    for number, step in enumerate(scenario.build):
        bricks += _bricks_of_layout(number, step, scenario)
        for index, brick in enumerate(step.bricks or ()):
            path: KeyPath = ("build", number, "bricks", index)
            set_down = _set_brick(path, number, brick, step.brick or scenario.brick, bricks, resolver)
            bricks.append(replace(set_down, name=_prefixed(step, brick.name), drop=brick.drop, within=step.name))
    for number, impact in enumerate(scenario.impacts):
        if impact.content.slid_in is not None:
            turn, path = len(scenario.build) + number, ("impacts", number, impact.kind)
            bricks.append(_set_brick(path, turn, impact.content.slid_in, scenario.brick, bricks, resolver))
    return bricks


def _bricks_of_layout(number: int, step: BuildStep, scenario: Scenario) -> Iterator[WrittenBrick]:
    kind = step.brick or scenario.brick
    if step.layout is not None:
        name, params = step.layout
        for spec in place(name, params, kind.form.size):
            form, own = laid(kind.form, spec), _prefixed(step, spec.name)
            path: KeyPath = ("build", number, name)
            point = form.middle if spec.outline is None else form.origin
            mass, pose = _mass_with_mortar(kind, form, spec, params), _pose_with_point(pose_of(spec), point)
            brick = WrittenBrick(path, number, form.shape, mass, pose, kind, spec.level, own, together=spec.together)
            yield replace(brick, within=step.name, passed=spec.passed)


def _mass_with_mortar(kind: BrickKind, form: Form, spec: BrickSpec, params: LayoutParams) -> float:
    """Return the mass of a brick of a layout with its mortar [kg]."""
    mass = kind.mass_of(form)
    if not isinstance(params, MortaredParams) or params.mortar is None or params.mortar.density is None:
        return mass
    return mass + spec.mortar * (params.mortar.density - mass / form.shape.volume)


def pose_of(spec: BrickSpec) -> Pose:
    """Return the pose of a brick of a layout."""
    if spec.lean == 0.0:
        return Pose(spec.position, about_z(spec.yaw))
    sine, cosine = half_turn(spec.lean)
    return Pose(spec.position, multiply(about_z(spec.yaw), (0.0, sine, 0.0, cosine)))


def _set_brick(  # noqa: PLR0913, PLR0917 -- a brick and everything that it may depend on
    path: KeyPath,
    step: int,
    brick: SetBrick,
    default_kind: BrickKind,
    before: Sequence[WrittenBrick],
    resolver: PlacementResolver,
) -> WrittenBrick:
    kind = brick.brick or default_kind
    form = kind.form
    at, angles = (brick.at, brick.rotate) if brick.stud is None else brick.on_studs(kind)
    turned, lost = about_axes(angles), None
    pose = _pose_with_point(Pose(at or (0.0, 0.0, 0.0), turned), form.origin)
    placed_by: tuple[int, ...] = ()
    if at is None:
        try:
            centre, placed_by = resolver.place_of(brick, form.shape, turned, before)
            pose = Pose(centre, turned)
        except MissingNeighbourError as error:
            lost = error
    mass = kind.mass_of(form)
    own = brick.friction
    return WrittenBrick(
        path, step, form.shape, mass, pose, kind, brick.level, brick.name, own, placed_by=placed_by, lost=lost
    )


def _pose_with_point(pose: Pose, point: Vec3) -> Pose:
    """Return the pose of a brick that has a point, given from its centre of mass along its body axes, at a position."""
    if point == MIDDLE:
        return pose
    x, y, z = subtract(pose.position_W, rotate(pose.orientation, point))
    return Pose((round(x, DIGITS), round(y, DIGITS), round(z, DIGITS)), pose.orientation)


def _prefixed(step: BuildStep, name: str | None) -> str | None:
    return f"{step.name}.{name}" if step.name and name else name


# Levels and names. The automatic name is `L3.2` for the second brick of level 3.


class CrowdedBrickError(Exception):
    """A brick has too many neighbours to compute its supports."""

    def __init__(self, brick: WrittenBrick) -> None:
        super().__init__(brick.path)
        self.brick = brick


def footings_of(
    written: Sequence[WrittenBrick], planes: Sequence[Plane], removed_in: Mapping[int, int] = MappingProxyType({})
) -> list[Fit]:
    """Return the supports of every brick, for its level; empty ones if all bricks are of layouts, which set levels.

    `removed_in` maps indices of bricks to the steps that pull them out. Raises CrowdedBrickError.
    """
    if all(brick.of_layout for brick in written):
        return [Fit() for _ in written]
    # The supports of a brick are in earlier steps or in its own, independent of times.
    sited = [
        TimedShape(float(brick.step), brick.shape, brick.pose, until=float(removed_in.get(index, inf)))
        for index, brick in enumerate(written)
    ]
    try:
        return fits(sited, planes)
    except CrowdedError as error:
        raise CrowdedBrickError(written[error.index]) from error


def levels_of(written: Sequence[WrittenBrick], footings: Sequence[Fit]) -> list[int]:
    """Return the level of every brick: the written one, or one above its highest support."""
    levels: dict[int, int] = {}
    for index in sorted(range(len(written)), key=lambda index: written[index].pose.position_W[2]):
        levels[index] = written[index].level or level_above(index, footings[index], written, levels)
    return [levels[index] for index in range(len(written))]


def level_above(
    index: int, footing: Fit, written: Sequence[WrittenBrick], levels: Mapping[int, int] | Sequence[int]
) -> int:
    """Return one more than the highest level of the supports whose centres are lower than that of the brick."""
    height = written[index].pose.position_W[2]
    below = (other for other in footing.on_boxes if (written[other].pose.position_W[2], other) < (height, index))
    return max((levels[other] for other in below), default=0) + 1


def names_of(
    written: Sequence[WrittenBrick], levels: Sequence[int], counts: Counter[tuple[str, int]] | None = None
) -> list[BodyId]:
    """Return the written names, and automatic names for the other bricks."""
    counted = Counter() if counts is None else counts
    return [next_name(brick, level, counted) for brick, level in zip(written, levels, strict=True)]


def next_name(brick: WrittenBrick, level: int, counts: Counter[tuple[str, int]]) -> BodyId:
    """Return the name of the next brick, and add it to the counts by step name and level."""
    place = f"{brick.within}." if brick.within else ""
    counts[place, level] += 1 + brick.passed
    return brick.name or f"{place}L{level}.{counts[place, level]}"


# The order of actions.


BEFORE_BUILDING: Final = -1  # turn of joints that set or are made
BUILD: Final = 0  # turn of the build, before those of the impacts


class ActionOrder(NamedTuple):
    """A time, and a turn among the actions at that time."""

    time: float  # [s]
    turn: int = BUILD  # 1 for the first impact, and so on


START: Final = ActionOrder(0.0)


# Automatic names while bricks are added one by one: `on` and `beside` need the names of the bricks so far.


MAX_NAMED = 20_000  # names that are recomputed because of bricks added below; takes about a second


@dataclass(slots=True)
class IncrementalNaming:
    """The levels and names of the bricks so far, equal to those of `levels_of` and `names_of`."""

    planes: Sequence[Plane]
    site: PlacementIndex = field(init=False)
    written: list[WrittenBrick] = field(default_factory=list)
    levels: list[int] = field(default_factory=list)
    counts: Counter[tuple[str, int]] = field(default_factory=Counter)
    named: dict[BodyId, int] = field(default_factory=dict)  # index of the first brick of each name
    cost: int = 0  # number of recomputed names

    def __post_init__(self) -> None:
        self.site = PlacementIndex([], self.planes)

    def add_new(self, bricks: Sequence[WrittenBrick], wanted: BodyId) -> None:
        """Add the new bricks, to look up the name `wanted`. Raises MissingNeighbourError if that is too costly."""
        changed = False  # whether the level of an earlier brick has changed
        for brick in bricks[len(self.written) :]:
            changed = self._add(brick) or changed
        if changed:
            self._name_all(wanted)

    def _add(self, brick: WrittenBrick) -> bool:
        """Add a brick; return whether it changes the level of an earlier brick above it."""
        number = len(self.written)
        self.written.append(brick)
        self.site.blocks.append(in_place(brick.shape, brick.pose))
        self.levels.append(brick.level or 1)
        try:
            changed = brick.lost is None and self._stand(number, brick)
        except CrowdedError as error:
            raise CrowdedBrickError(brick) from error
        self.named.setdefault(next_name(brick, self.levels[number], self.counts), number)
        return changed

    def _stand(self, number: int, brick: WrittenBrick) -> bool:
        self.site.put(number)
        self.levels[number] = brick.level or self._level(number)
        return any(self._is_lifted(other, brick.step) for other in self.site.touching(number))

    def _level(self, number: int) -> int:
        return level_above(number, self.site.fit(number), self.written, self.levels)

    def _is_lifted(self, number: int, step: int) -> bool:
        """Whether the level of a brick has changed; only bricks of its own step can still become its supports."""
        brick = self.written[number]
        return brick.step == step and brick.level is None and self._level(number) != self.levels[number]

    def _name_all(self, wanted: BodyId) -> None:
        self.cost += len(self.written)
        if self.cost > MAX_NAMED:
            raise MissingNeighbourError(wanted, too_costly=True)
        self.levels = levels_of(self.written, footings_of(self.written, self.planes))
        self.counts.clear()
        names = names_of(self.written, self.levels, self.counts)
        self.named = {name: number for number, name in reversed(list(enumerate(names)))}


# The positions of bricks that are placed `on` or `beside` others.


@dataclass(slots=True)
class EarlierBricks:
    """Resolves placements on or beside earlier bricks."""

    planes: Sequence[Plane]
    standing: IncrementalNaming = field(init=False)
    named: dict[BodyId, int] = field(default_factory=dict)  # indices by written name
    seen: int = 0  # number of bricks in `named`

    def __post_init__(self) -> None:
        self.standing = IncrementalNaming(self.planes)

    def place_of(
        self, brick: SetBrick, shape: ConvexShape, turned: Quaternion, before: Sequence[WrittenBrick]
    ) -> tuple[Vec3, tuple[int, ...]]:
        """Return the centre of mass and the indices of the neighbours in `before`. Raises MissingNeighbourError."""
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
        """Return the index of an earlier brick; compute automatic names only if no written name matches."""
        for number in range(self.seen, len(before)):
            if (own := before[number].name) is not None:
                self.named.setdefault(own, number)
        self.seen = len(before)
        if name in self.named:
            return self.named[name]
        self.standing.add_new(before, name)
        if name not in self.standing.named:
            raise MissingNeighbourError(name)
        return self.standing.named[name]


def _reach(shape: ConvexShape, turned: Quaternion, direction: Vec3) -> float:
    """Return the extent of a shape from its centre along a direction of the scene [m]."""
    return shape.reach(rotate(inverse(turned), direction))


def later_names(written: Sequence[WrittenBrick]) -> Mapping[BodyId, WrittenBrick]:
    """Return the bricks with written names, by name."""
    return {brick.name: brick for brick in written if brick.name is not None}


# The bricks of the structure, built or slid in.


class HandTimes(NamedTuple):
    """The times at which a hand starts with a brick, places it and releases it [s]; all equal without a hand."""

    begins: float
    arrives: float
    let_go: float


AT_ONCE = HandTimes(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class ResolvedBrick:
    """A brick of the structure, with its name, its level and its times."""

    written: WrittenBrick
    footing: Fit  # supports, for the level; empty if all bricks are of layouts
    level: int
    name: BodyId
    removed_in: int | None  # index of the impact that pulls it out
    placed: ActionOrder = START
    removed: ActionOrder | None = None  # its removal
    in_hand: HandTimes = AT_ONCE


def resolved_bricks(scenario: Scenario, planes: Sequence[Plane]) -> list[ResolvedBrick]:
    """Return all bricks in file order, without their times."""
    written = bricks_of(scenario, EarlierBricks(planes))
    removed: Mapping[int, int] = {}
    # Impacts pull bricks out by name, bricks are slid into the gaps, and their names depend on their supports there.
    for _ in range(2 if scenario.impacts else 1):
        until = {index: len(scenario.build) + number for index, number in removed.items()}
        footings = footings_of(written, planes, until)
        levels = levels_of(written, footings)
        names = names_of(written, levels)
        removed = _removed_in(scenario, names)
    columns = zip(written, footings, levels, names, strict=True)
    return [ResolvedBrick(*values, removed.get(index)) for index, values in enumerate(columns)]


def _removed_in(scenario: Scenario, names: Sequence[BodyId]) -> Mapping[int, int]:
    """Return the index of the impact that pulls out each brick, by the index of the brick."""
    numbers = {name: index for index, name in enumerate(names)} if scenario.impacts else {}
    return {
        numbers[named.name]: number
        for number, impact in enumerate(scenario.impacts)
        for named in impact.content.pulled_out
        if named.name in numbers
    }
