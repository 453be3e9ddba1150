"""Registry of layouts. A layout is a model of its parameters and one pure function.

A layout has its own frame: z up, bricks lying flat with their length along x unless turned, level 1 resting on z = 0.
`origin` and `heading` transform it to its place in the scenario. Bricks are listed in order of building.
"""

from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from math import cos, prod, sin
from typing import Annotated, ClassVar, Final, Self, TypeAlias, TypeVar, cast

from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from stability.geometry.vectors import add, subtract
from stability.model import Vec3
from stackdsl.language.joints import Mortar
from stackdsl.language.model_base import AuthorModel, Kinds, default
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import MAX_BRICKS, Angle, JsonSchema, Length, NonNegativeLength, PlaceName
from stackdsl.wording import mm


@dataclass(frozen=True, slots=True)
class BrickSpec:
    """One brick of a layout."""

    level: int  # storey, counted from 1
    position: Vec3  # its centre [m]
    yaw: float = 0.0  # turn about z, after the lean [rad]
    lean: float = 0.0  # turn about y, which brings its +x end down [rad]
    together: bool = False  # whether it is set down at the same time as the brick before it
    size: Vec3 | None = None  # [m]; None for the brick of the layout
    name: str | None = None  # None for a name by place
    # For a special stone in place of the brick of the layout: its corners seen from the front, relative to its
    # position, x to the right and z up [m], and its depth from front to back, centred on its position [m].
    outline: "Outline | None" = None
    depth: float = 0.0
    mortar: float = 0.0  # volume of the mortar in it [m3]
    passed: int = 0  # omitted bricks just before it in its level, which count in its name


Outline: TypeAlias = tuple[tuple[float, float], ...]
Specs: TypeAlias = tuple[BrickSpec, ...]


class LayoutParams(AuthorModel):
    """Parameters that all layouts share."""

    origin: tuple[Length, Length, Length] = default(
        ["0 mm", "0 mm", "0 mm"], "position [x, y, z] of the origin of the layout"
    )
    heading: Angle = default(
        "0 deg", "rotation of the layout about the vertical axis through its origin, from x towards y"
    )
    omit: Annotated[tuple[PlaceName, ...], Field(max_length=MAX_BRICKS)] = Field(
        (), description="bricks to omit, such as `L2.3`; all others keep their names"
    )

    count: ClassVar[str] = "levels"  # key of the size of the layout, which is optional with `until: collapse`

    @property
    @abstractmethod
    def bricks_at_most(self) -> int:
        """Return an upper bound of the number of bricks, without making them."""

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchema:
        """Make `count` optional in the schema; `BuildStep` adds the condition."""
        schema = handler(core)
        keys = handler.resolve_ref_schema(schema)
        keys["required"] = [key for key in keys.get("required", []) if key != cls.count]
        return schema

    @model_validator(mode="after")
    def _reject_too_many(self) -> "LayoutParams":
        if self.bricks_at_most > MAX_BRICKS:
            message = f"the layout has {self.bricks_at_most} bricks; the maximum is {MAX_BRICKS}"
            raise InputError("SD206", message, "split the layout into several steps, or reduce its size")
        return self


class MortaredParams(LayoutParams):
    """Parameters of layouts whose bricks may be laid in mortar.

    Each brick includes half of the mortar around it, so that bricks touch in the middle of a joint, as is usual for
    masonry of rigid blocks ("expanded blocks").
    """

    mortar: Mortar | None = Field(
        None, description="mortar between the bricks: the thickness of its joints, or {thickness, bond, density}"
    )

    between_ends: ClassVar[bool] = False  # whether mortar also fills the joints between the ends of boxes

    @property
    def joint(self) -> float:
        """Return the thickness of the joints [m]; 0 without mortar."""
        return 0.0 if self.mortar is None else self.mortar.thickness

    @property
    def mortar_on_a_box(self) -> Vec3:
        """Return by how much mortar makes a box longer, wider and thicker [m]."""
        return (self.joint if self.between_ends else 0.0, 0.0, self.joint)


class RowParams(MortaredParams):
    """Parameters of layouts with rows of planks end to end."""

    # Planks that touch end to end would press on each other, which a real wall does not intend.
    gap: NonNegativeLength = default("0.2 mm", "gap between the ends of neighbours; none with mortar")

    between_ends = True

    @model_validator(mode="after")
    def _mortar_fills_gaps(self) -> Self:
        if self.mortar is not None and "gap" in self.model_fields_set:
            message = "`gap` applies to dry joints, but mortar fills the joints between the ends"
            raise InputError("SD108", message, "remove one of them")
        return self

    def gap_of(self, length: float) -> float:
        """Return the gap between the ends of neighbours of a length [m]. Raises InputError."""
        gap = self.gap if self.mortar is None else 0.0
        if gap >= length:
            hint = "write a shorter gap, such as 0.2 mm"
            raise InputError("SD104", f"the gap must be shorter than a plank of {mm(length, 6)}", hint)
        return gap


Params = TypeVar("Params", bound=LayoutParams)
# From parameters and the size of a brick (length, width, thickness) to bricks in the layout's frame.
LayoutFunction: TypeAlias = Callable[[Params, Vec3], Specs]


@dataclass(frozen=True, slots=True)
class Layout:
    """A registered layout."""

    params: type[LayoutParams]
    function: LayoutFunction[LayoutParams]
    summary: str


LAYOUTS: Final = Kinds[Layout](
    "layout",
    "four_stack",
    "column",
    "wall",
    "harmonic",
    "tower",
    "card_house",
    "leaning_structure",
    "arch",
    "flat_arch",
    "jenga",
    "pyramid",
    "corbel",
    "dominoes",
    "ring",
)


def layout(name: str, params: type[Params]) -> Callable[[LayoutFunction[Params]], LayoutFunction[Params]]:
    """Return a decorator that registers the function of a layout, with the first line of its docstring for editors."""

    def register(function: LayoutFunction[Params]) -> LayoutFunction[Params]:
        summary = (function.__doc__ or "").partition("\n")[0]
        LAYOUTS.register(name, Layout(params, cast("LayoutFunction[LayoutParams]", function), summary))
        return function

    return register


def place(name: str, params: LayoutParams, size: Vec3) -> Specs:
    """Return the bricks of a layout in the frame of the scenario. Raises InputError."""
    all_specs = _in_mortar(name, params, size) if isinstance(params, MortaredParams) and params.mortar else None
    all_specs = all_specs or LAYOUTS[name].function(params, size)
    specs = without(all_specs, params.omit) if params.omit else all_specs
    stays = params.heading == 0.0 and params.origin == (0.0, 0.0, 0.0)  # as in most scenarios
    return tuple(specs) if stays else tuple(_transformed(spec, params) for spec in specs)


def _in_mortar(name: str, params: MortaredParams, size: Vec3) -> Specs:
    """Return the bricks of a layout, each with half of the mortar around it. Raises InputError."""
    around = params.mortar_on_a_box
    if any(layer >= side for layer, side in zip(around, size, strict=True)):
        message = f"joints of {mm(params.joint)} are thicker than the bricks"
        raise InputError("SD104", message, "write thinner joints, or larger bricks")
    grown = add(size, around)

    def with_mortar(spec: BrickSpec) -> BrickSpec:
        own = spec.size or grown
        return replace(spec, size=own, mortar=prod(own) - prod(subtract(own, around)))

    specs = LAYOUTS[name].function(params, grown)
    return tuple(with_mortar(spec) if spec.outline is None else spec for spec in specs)


def without(specs: Specs, omitted: Collection[str]) -> Specs:
    """Return a layout without some bricks, given by their places in it. Raises InputError."""
    left, places = list[BrickSpec](), dict.fromkeys(omitted)
    counts, passed = Counter[int](), Counter[int]()
    alone = False  # whether the first brick of a group that is set down together is omitted
    for spec in specs:
        counts[spec.level] += 1
        if (place := f"L{spec.level}.{counts[spec.level]}") in places:
            del places[place]
            passed[spec.level] += 1
            alone = alone or not spec.together
            continue
        left.append(replace(spec, passed=passed.pop(spec.level, 0), together=spec.together and not alone))
        alone = False
    if places:
        first = next(iter(places))
        message = f"the layout has no {first} to omit"
        raise InputError("SD104", message, "write the level of the brick and its number in the level, such as L2.3")
    if not left:
        raise InputError("SD104", "`omit` lists all bricks of the layout", "omit fewer")
    return tuple(left)


def _transformed(spec: BrickSpec, params: LayoutParams) -> BrickSpec:
    """Return a brick rotated by the heading, then shifted to the origin."""
    (x, y, z), (ox, oy, oz) = spec.position, params.origin
    c, s = cos(params.heading), sin(params.heading)
    position = (ox + c * x - s * y, oy + s * x + c * y, oz + z)
    return replace(spec, position=position, yaw=spec.yaw + params.heading)


def height(level: int, thickness: float) -> float:
    """Return the height of the centre of a brick that lies flat on a level [m]."""
    return (level - 0.5) * thickness
