"""Named structures: each is a model of its parameters and one pure function, in a registry.

A layout is laid out in its own frame: z up, bricks lying flat with their length along x unless turned, level 1 resting
on z = 0. `origin` and `heading` then carry it to its place in the scenario. Bricks are listed in order of building.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import cos, pi, sin, tan
from typing import Annotated, ClassVar, Final, TypeAlias, TypeVar, cast

from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from stability.model import Vec3
from stackdsl.language.author_models import AuthorModel, default
from stackdsl.language.author_types import Angle, JsonSchema, Length, NonNegativeLength, PositiveLength, ShareOfLimit
from stackdsl.language.mistakes import MistakeError

MAX_LEVELS: Final = 10_000  # beyond, a typo: the tallest plank towers have a few hundred levels
MAX_BRICKS: Final = 20_000  # in one step of `build`; some seconds of computing

Levels = Annotated[int, Field(strict=True, ge=1, le=MAX_LEVELS)]


@dataclass(frozen=True, slots=True)
class BrickSpec:
    """One brick of a layout."""

    level: int  # storey, counted from 1
    position: Vec3  # its centre [m]
    yaw: float = 0.0  # turn about z, after the lean [rad]
    lean: float = 0.0  # turn about y, which brings its +x end down [rad]
    together: bool = False  # whether it is set down at one moment with the brick before it
    size: Vec3 | None = None  # [m]; None for the brick that the layout is built of
    name: str | None = None  # None for a name by place


Specs: TypeAlias = tuple[BrickSpec, ...]


class LayoutParams(AuthorModel):
    """Where a layout stands."""

    origin: tuple[Length, Length, Length] = default(["0 mm", "0 mm", "0 mm"], "shifts the layout to [x, y, z]")
    heading: Angle = default("0 deg", "turns the layout about the vertical through its origin, x towards y")

    count: ClassVar[str] = "levels"  # the key that says how much is built, which a step until a collapse may leave out

    @property
    def bricks_at_most(self) -> int:
        """An upper limit of the number of bricks, known before they are made."""
        return MAX_LEVELS

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchema:
        """Whether the count may be left out is up to the step."""
        schema = handler(core)
        keys = handler.resolve_ref_schema(schema)
        keys["required"] = [key for key in keys.get("required", []) if key != cls.count]
        return schema

    @model_validator(mode="after")
    def _reject_too_many(self) -> "LayoutParams":
        if self.bricks_at_most > MAX_BRICKS:
            message = f"the layout has {self.bricks_at_most} bricks, and {MAX_BRICKS} is the most"
            raise MistakeError("SD206", message, "build it in several steps, or smaller")
        return self


Params = TypeVar("Params", bound=LayoutParams)
# From parameters and the size of a brick (length, width, thickness) to bricks in the layout's frame.
LayoutFunction: TypeAlias = Callable[[Params, Vec3], Specs]


@dataclass(frozen=True, slots=True)
class Layout:
    """A structure that scenarios know by name."""

    params: type[LayoutParams]
    function: LayoutFunction[LayoutParams]
    summary: str


_registry: dict[str, Layout] = {}
LAYOUTS: Final[Mapping[str, Layout]] = _registry


def layout(name: str, params: type[Params]) -> Callable[[LayoutFunction[Params]], LayoutFunction[Params]]:
    """Register the function below under a name."""

    def register(function: LayoutFunction[Params]) -> LayoutFunction[Params]:
        summary = (function.__doc__ or "").partition("\n")[0]
        _registry[name] = Layout(params, cast("LayoutFunction[LayoutParams]", function), summary)
        return function

    return register


def place(name: str, params: LayoutParams, size: Vec3) -> Specs:
    """The bricks of a layout in the frame of the scenario."""
    return tuple(_carried(spec, params) for spec in LAYOUTS[name].function(params, size))


def _carried(spec: BrickSpec, params: LayoutParams) -> BrickSpec:
    """A brick turned by the heading, then shifted to the origin."""
    (x, y, z), (ox, oy, oz) = spec.position, params.origin
    c, s = cos(params.heading), sin(params.heading)
    position = (ox + c * x - s * y, oy + s * x + c * y, oz + z)
    return replace(spec, position=position, yaw=spec.yaw + params.heading)


def _height(level: int, thickness: float) -> float:
    """Height of the centre of a brick that lies flat on a level [m]."""
    return (level - 0.5) * thickness


class FourStackParams(LayoutParams):
    """Two parallel planks a level, turned by 90 deg each level."""

    levels: Levels = Field(description="how many levels of two planks")
    step: Length = default("0 mm", "how far each level is shifted along x from the one below")
    spacing: PositiveLength | None = Field(
        None, description="between the centres of the two planks; default: length - width, so that ends are flush"
    )

    @property
    def bricks_at_most(self) -> int:
        return 2 * self.levels


@layout("four_stack", FourStackParams)
def four_stack(params: FourStackParams, size: Vec3) -> Specs:
    """Two parallel planks a level, turned by 90 deg each level.

    Odd levels run along x and even ones along y; of each, the plank on the negative side comes first.
    """
    spacing = size[0] - size[1] if params.spacing is None else params.spacing
    return crossed_pairs(params.levels, params.step, spacing, size)


def crossed_pairs(levels: int, step: float, spacing: float, size: Vec3) -> Specs:
    """The bricks of a four-stack."""
    half, specs = spacing / 2, []
    for level in range(1, levels + 1):
        middle, z = (level - 1) * step, _height(level, size[2])
        for side in (-half, half):
            along_x = BrickSpec(level, (middle, side, z))
            along_y = BrickSpec(level, (middle + side, 0.0, z), yaw=pi / 2)
            specs.append(along_x if level % 2 else along_y)
    return tuple(specs)


class ColumnParams(LayoutParams):
    """One plank a level."""

    levels: Levels = Field(description="how many planks")
    step: Length = default("0 mm", "how far each plank is shifted along its length from the one below")


@layout("column", ColumnParams)
def column(params: ColumnParams, size: Vec3) -> Specs:
    """One flat plank a level, each shifted by the same step along its length."""
    return tuple(
        BrickSpec(level, ((level - 1) * params.step, 0.0, _height(level, size[2])))
        for level in range(1, params.levels + 1)
    )


class WallParams(LayoutParams):
    """Planks end to end, in running bond."""

    levels: Levels = Field(description="how many levels")
    bricks: Annotated[int, Field(strict=True, ge=1, le=MAX_BRICKS)] = Field(description="planks of a full level")
    # Planks that touch end to end would carry loads between them that no builder means.
    gap: NonNegativeLength = default("0.2 mm", "between the ends of neighbours")

    @property
    def bricks_at_most(self) -> int:
        return self.levels * (self.bricks + 1)


@layout("wall", WallParams)
def wall(params: WallParams, size: Vec3) -> Specs:
    """Planks end to end along x in running bond, closed at both ends.

    Even levels are shifted by half a plank. Whole planks only would leave their ends hanging out past their centres, or
    else the level would be shorter than the one below and the wall a triangle; half planks close them instead. So all
    levels are equally long, and every plank lies on two others or wholly on one.
    """
    length, width, thickness = size
    if params.gap >= length:
        raise MistakeError(
            "SD104", f"the gap is longer than a plank of {1000 * length:g} mm", "write less, such as 0.2 mm"
        )
    pitch, half_plank = length + params.gap, ((length - params.gap) / 2, width, thickness)
    end = (
        params.bricks * pitch - params.gap - half_plank[0]
    ) / 2  # from the middle of the wall to that of a half plank
    specs = []
    for level in range(1, params.levels + 1):
        z, whole = _height(level, thickness), params.bricks - (level % 2 == 0)
        row = [BrickSpec(level, ((i - (whole - 1) / 2) * pitch, 0.0, z)) for i in range(whole)]
        ends = [BrickSpec(level, (x, 0.0, z), size=half_plank) for x in (-end, end)]
        specs += row if level % 2 else [ends[0], *row, ends[1]]
    return tuple(specs)


class HarmonicParams(LayoutParams):
    """The stack that leans out furthest, one plank a level."""

    bricks: Levels = Field(description="how many planks")
    share: ShareOfLimit = default(1.0, "of the overhang at which the stack is on the point of tipping")

    count: ClassVar[str] = "bricks"


@layout("harmonic", HarmonicParams)
def harmonic(params: HarmonicParams, size: Vec3) -> Specs:
    """The overhanging stack: from the top, each plank leans out by 1/2, 1/4, 1/6 ... of a length, towards +x.

    The n planks above any joint then have their common centre just over the edge of the plank below, times `share`.
    """
    x, specs = 0.0, []
    for level in range(1, params.bricks + 1):
        specs.append(BrickSpec(level, (x, 0.0, _height(level, size[2]))))
        above = params.bricks - level
        x += params.share * size[0] / (2 * above) if above else 0.0
    return tuple(specs)


class TowerParams(LayoutParams):
    """A round, hollow tower of rings of planks."""

    levels: Levels = Field(description="how many rings")
    bricks: Annotated[int, Field(strict=True, ge=3, le=MAX_BRICKS)] = Field(description="planks of a ring")
    overlap: ShareOfLimit = default("40 %", "of a plank's length that lies on each of the two planks below")

    @property
    def bricks_at_most(self) -> int:
        return self.levels * self.bricks


@layout("tower", TowerParams)
def tower(params: TowerParams, size: Vec3) -> Specs:
    """Rings of planks, each ring turned by half a pitch, so that every plank bridges two of the ring below.

    The planks are chords: the middle of each is at a distance R from the axis, its length along the tangent there. The
    first of level 1 lies towards +x, and even levels are turned by half a pitch, a = pi / n. Seen from above, two
    neighbours in successive rings are mirror images in the radius between them, so on it their middle lines cross,
    R tan(a / 2) from the middle of either. Forces through these points, each half of the load, balance every plank, up
    from below and down from above, however high the tower is.
    """
    half_pitch, radius = pi / params.bricks, _ring_radius(params, size)
    specs = []
    for level in range(1, params.levels + 1):
        for number in range(params.bricks):
            bearing = (2 * number + (level % 2 == 0)) * half_pitch
            position = (radius * cos(bearing), radius * sin(bearing), _height(level, size[2]))
            specs.append(BrickSpec(level, position, yaw=bearing + pi / 2))
    return tuple(specs)


def _ring_radius(params: TowerParams, size: Vec3) -> float:
    """Of the circle on which the middles of the planks lie, so that they overlap as wanted [m].

    The end face of a plank below cuts the middle line of a plank at (R sin a - L / 2) / cos a from its middle, which
    leaves `overlap` of its length L beyond. Neighbours of one ring, 2 a apart, are free of each other as long as the
    inner corners stay on their side of the radius between them: L / 2 <= (R - w / 2) tan a.
    """
    (length, width, _), half_pitch = size, pi / params.bricks
    most = (1 / cos(half_pitch) - width / length * tan(half_pitch)) / 2
    if not 0 < params.overlap < most:
        problem = "does not reach the planks below" if params.overlap <= 0 else "runs into its neighbours of the ring"
        message = f"with {params.bricks} planks a ring and an overlap of {100 * params.overlap:.4g} %, each {problem}"
        raise MistakeError("SD104", message, f"write an overlap of more than 0 % and less than {100 * most:.3g} %")
    return (length / 2 + (0.5 - params.overlap) * length * cos(half_pitch)) / sin(half_pitch)
