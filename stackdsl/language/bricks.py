"""Bricks in YAML: shapes, sizes, masses and places."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite, pi, prod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Literal, Self, TypeAlias

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from stability.geometry.box import MIDDLE, Box, OffCentreBox
from stability.geometry.compound import MOST_PARTS, Compound
from stability.geometry.convex_solid import NotASolidError
from stability.geometry.round_solid import RoundSolid, capsule, cylinder, frustum, pipe, sphere
from stability.geometry.vectors import SHORTEST, rotate, scale, subtract
from stability.model import GROUND, ConvexShape, Pose, Vec3
from stability.statics.assembly import LIGHTEST
from stackdsl.diagnostics import did_you_mean
from stackdsl.language import value_types as t
from stackdsl.language.compound_parts import (
    MOST_CELLS,
    SectionShape,
    hollow_block_boxes,
    section_boxes,
    table_boxes,
)
from stackdsl.language.joints import LEGO_STUDS, StudGrid
from stackdsl.language.layouts.registry import BrickSpec
from stackdsl.language.lego import LEGO, PLATES, meant_lego
from stackdsl.language.mesh_files import MeshFileError, mesh_kind, whole_mesh
from stackdsl.language.model_base import AuthorModel, ExactlyOneKey, Shorthand, default
from stackdsl.language.pallets import Pallet, pallet_boxes
from stackdsl.language.quantities import SIDE, ConsequentialError, InputError, shown, triple
from stackdsl.language.rotations import about_axes
from stackdsl.language.round_words import ROUND_WORDS, round_brick
from stackdsl.language.strengths import BrickStrength
from stackdsl.language.value_types import Levels
from stackdsl.supervising.executors import supervised
from stackdsl.supervising.worker import Task, TaskStatus, memory_limited
from stackdsl.wording import mm

if TYPE_CHECKING:
    from stability.geometry.compound_making import FramedCompound
    from stability.geometry.solid_making import FramedSolid

    Framed: TypeAlias = FramedSolid | FramedCompound

# Catalogue of bricks.


@dataclass(frozen=True, slots=True)
class CatalogueBrick:
    """A brick that can be bought, or an idealised one."""

    size: Vec3  # length, width, thickness; lying flat [m]
    density: float  # [kg/m3]
    studs: StudGrid | None = None
    smooth: bool = False  # whether it has no studs on top


PINE: Final = 557.0  # [kg/m3], of a KAPLA plank of nominal size and 11.9 g

CATALOGUE: Final[Mapping[str, CatalogueBrick]] = {
    "kapla": CatalogueBrick((0.1176, 0.0234, 0.0078), PINE),
    # Sides of exactly 1:3:15, the plank of the published method. Density of the same wood, rather than the same mass:
    # a density common to all bricks does not change the behaviour of a structure.
    "kapla-ideal": CatalogueBrick((0.120, 0.024, 0.008), PINE),
    **{
        name: CatalogueBrick(part.size, float(part.mass) / prod(part.size), LEGO_STUDS, part.smooth)
        for name, part in LEGO.items()
    },
}


# Reader of Wavefront OBJ files: corners and faces, from the `v` and `f` lines; all other lines are ignored.


MOST_LINES: Final = 100_000
LEAST_PARTS: Final = 3  # numbers of a corner, and corners of a face
_CORNER: Final = re.compile(r"[-+]?[0-9]{1,18}(?=/|$)")


@dataclass(slots=True)
class ObjMesh:
    """The mesh of a file."""

    points: list[tuple[float, float, float]] = field(default_factory=list)
    loops: list[tuple[int, ...]] = field(default_factory=list)  # corners of each face, from 0


def obj_mesh(text: str, file: str) -> ObjMesh:
    """Read the mesh of a file. Raises InputError, with the line, for malformed corners and faces."""
    mesh = ObjMesh()
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        raise InputError("SD104", f"{file} has {len(lines)} lines; the maximum is {MOST_LINES}", "simplify the mesh")
    for number, line in enumerate(lines, start=1):
        kind, *parts = line.partition("#")[0].split() or [""]
        try:
            if kind == "v":
                mesh.points.append(_point(parts))
            elif kind == "f":
                mesh.loops.append(_loop(parts, len(mesh.points)))
        except ValueError as error:
            hint = "write a corner as `v 0.1 0 0.05`, and a face as `f 1 2 3` with the numbers of preceding corners"
            raise InputError("SD104", f"{file}:{number}: {error}", hint) from None
    if not mesh.loops:
        raise InputError("SD104", f"{file} has no faces", "export the solid as a mesh with `v` and `f` lines")
    return mesh


def file_mesh(text: str, file: str) -> ObjMesh:
    """Read the mesh of an OBJ, STL or PLY file; the bytes of the last two as characters. Raises InputError."""
    if not (kind := mesh_kind(file)):
        return obj_mesh(text, file)
    try:
        return ObjMesh(*whole_mesh(text.encode("latin-1"), kind))
    except MeshFileError as error:
        place = f"{file}:{error.line}" if error.line else file
        raise InputError("SD104", f"{place}: {error.message}", error.hint) from None


def _point(parts: Sequence[str]) -> tuple[float, float, float]:
    if len(parts) < LEAST_PARTS:
        raise ValueError(f"a corner has {len(parts)} coordinates instead of three")
    x, y, z = (_number(part) for part in parts[:LEAST_PARTS])  # a weight or a colour may follow
    return (x, y, z)


def _number(part: str) -> float:
    try:
        number = float(part)
    except ValueError:
        raise ValueError(f"{shown(part)} is not a number") from None
    if not part.isascii() or "_" in part:  # forms that only Python reads
        raise ValueError(f"{shown(part)} is not a number")
    if not isfinite(number):
        raise ValueError(f"{shown(part)} is not a finite number")
    return number


def _loop(parts: Sequence[str], corners: int) -> tuple[int, ...]:
    if len(parts) < LEAST_PARTS:
        raise ValueError(f"a face has {len(parts)} corners; the minimum is three")
    loop = tuple(_corner(part, corners) for part in parts)
    if len(set(loop)) < len(loop):
        raise ValueError("a face contains the same corner twice")
    return loop


def _corner(part: str, corners: int) -> int:
    """Return the index of the corner in `3/1/2`, before texture and normal; -1 is the last corner above the line."""
    number = corner_number(part)
    if number is None:
        raise ValueError(f"{shown(part)} is not a corner number")
    index = number - 1 if number > 0 else corners + number
    if number == 0 or not 0 <= index < corners:
        raise ValueError(f"corner {number} does not exist; {corners} corners precede this face")
    return index


def corner_number(part: str) -> int | None:
    """Return the number of the corner in a part of a face, such as 3 in `3/1/2`; None if there is none."""
    match = _CORNER.match(part)
    return int(match[0]) if match else None


# Form of a brick: its shape, its bounding box, and its reference points.


KEPT: Final = 4096  # forms in each cache
MOST_AT_ONCE: Final = 200  # corners of a solid that Qhull handles in milliseconds in all cases
TIME_LIMIT: Final = 20.0  # [s] of wall time for more corners; Qhull takes 2 s for a degenerate solid of a thousand
MEMORY_LIMIT: Final = 1 << 30  # [bytes] for a solid of more corners
METRES: Final = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}

Outline: TypeAlias = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Form:
    """The form of a brick. Points are relative to its centre of mass, in the axes of the brick [m]."""

    shape: ConvexShape
    size: Vec3  # of its bounding box, along the axes of the brick [m]
    middle: Vec3 = MIDDLE  # of the bounding box, the reference point of layouts, `on` and `beside`
    origin: Vec3 = MIDDLE  # reference point of `at`: the middle of a box, the origin of the corners of a solid


def box_form(size: Vec3, centre_of_mass: Vec3 | None = None) -> Form:
    """Return the form of a box. The centre of mass is relative to its middle [m]. Raises InputError."""
    if centre_of_mass is None or centre_of_mass == MIDDLE:
        return Form(Box(size), size)
    if any(abs(part) >= 0.5 * side for part, side in zip(centre_of_mass, size, strict=True)):
        message = "the centre of mass lies outside the box"
        raise InputError("SD104", message, "write a point inside the box, relative to its centre")
    back = subtract(MIDDLE, centre_of_mass)
    return Form(OffCentreBox(size, centre_of_mass), size, back, back)


@lru_cache(maxsize=KEPT)
def prism_form(outline: Outline, depth: float, centre_of_mass: Vec3 | None = None) -> Form:
    """Return the form of a prism, in parts if its outline is not convex. Raises InputError."""
    from stability.geometry.convex_parts import bent_prism  # noqa: PLC0415 -- boxes do not need scipy

    try:
        made = bent_prism(outline, depth, centre_of_mass)
    except NotASolidError as error:
        raise InputError("SD104", error.message, error.hint) from error
    return _form(made.shape, made.centre_of_mass)


def round_form(make: "Callable[..., RoundSolid]", *lengths: float, centre_of_mass: Vec3 | None = None) -> Form:
    """Return the form of a round solid; the centre of mass is relative to the middle of its height [m].

    Raises InputError.
    """
    try:
        solid = make(*lengths, centre_of_mass)
    except NotASolidError as error:
        raise InputError("SD104", error.message, error.hint) from error
    across = 2.0 * solid.widest
    back = subtract(MIDDLE, solid.centre_of_mass)
    return Form(solid, (across, across, solid.height + 2.0 * solid.rounding), back, back)


@lru_cache(maxsize=KEPT)
def hull_form(points: tuple[Vec3, ...], centre_of_mass: Vec3 | None = None) -> Form:
    """Return the form of the convex hull of points. Raises InputError."""
    from stability.geometry.solid_making import solid_of_corners  # noqa: PLC0415 -- boxes do not need scipy

    try:
        made = _solid(solid_of_corners, points, centre_of_mass)
    except NotASolidError as error:
        raise InputError("SD104", error.message, error.hint) from error
    return _form(made.shape, made.centre_of_mass)


@lru_cache(maxsize=KEPT)
def compound_form(parts: tuple[tuple[ConvexShape, Pose], ...], centre_of_mass: Vec3 | None = None) -> Form:
    """Return the form of a rigid body of convex parts. Raises InputError."""
    from stability.geometry.compound_making import compound  # noqa: PLC0415 -- few scenarios need it

    try:
        made = compound(parts, centre_of_mass)
    except NotASolidError as error:
        raise InputError("SD104", error.message, error.hint) from error
    return _form(made.shape, made.centre_of_mass)


@lru_cache(maxsize=KEPT)
def mesh_form(text: str, file: str, unit: str, centre_of_mass: Vec3 | None = None) -> Form:
    """Return the form of the solid in the text of a mesh file, in parts if it is not convex. Raises InputError."""
    from stability.geometry.convex_parts import body_of_mesh  # noqa: PLC0415 -- boxes do not need scipy

    mesh = file_mesh(text, file)
    try:
        points = tuple(scale(METRES[unit], point) for point in mesh.points)
        made = _solid(body_of_mesh, points, tuple(mesh.loops), centre_of_mass)
    except NotASolidError as error:
        raise InputError("SD104", f"{file}: {error.message}", error.hint) from error
    return _form(made.shape, made.centre_of_mass)


def _solid(make: "Callable[..., Framed]", points: tuple[Vec3, ...], *others: object) -> "Framed":
    """Return the solid that `make` makes of points. Raises NotASolidError.

    For many points `make` runs in a supervised process: the time of Qhull is quadratic for points on a circle, and
    signals do not interrupt it.
    """
    if len(points) <= MOST_AT_ONCE:
        return make(points, *others)
    made = _made_apart(make, points, *others)
    if isinstance(made, tuple):
        raise NotASolidError(*made)
    return made


@lru_cache(maxsize=KEPT)
def _made_apart(make: "Callable[..., Framed]", *arguments: object) -> "Framed | tuple[str, str, int | None]":
    result = supervised(Task(_solid_or_error, (make, *arguments), TIME_LIMIT))
    if result.status is TaskStatus.DONE:
        return result.value  # type: ignore[return-value]  # the type of `_solid_or_error`
    problem = "takes too long" if result.status is TaskStatus.TIMED_OUT else "crashes Qhull"
    return f"computing the hull of the corners {problem}: {result.message}", "simplify the solid", None


def _solid_or_error(make: "Callable[..., Framed]", *arguments: object) -> "Framed | tuple[str, str, int | None]":
    """Make a solid, or return the message, hint and number of the error. Runs in the worker."""
    with memory_limited(MEMORY_LIMIT):
        try:
            return make(*arguments)
        except NotASolidError as error:
            return error.message, error.hint, error.number


def _form(shape: ConvexShape, centre_of_mass: Vec3) -> Form:
    lows, highs = zip(*((min(along), max(along)) for along in zip(*shape.corners, strict=True)), strict=True)
    (ax, ay, az), (bx, by, bz) = lows, highs
    middle = (0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz))
    return Form(shape, (bx - ax, by - ay, bz - az), middle, subtract(MIDDLE, centre_of_mass))


def laid(form: Form, spec: BrickSpec) -> Form:
    """Return the form of one brick of a layout: a whole brick, a piece, or a special stone. Raises InputError."""
    if spec.outline is None:
        return cut_to(form, spec.size or form.size)
    return prism_form(spec.outline, spec.depth)


def cut_to(form: Form, size: Vec3) -> Form:
    """Return a box cut to another size, such as at the ends of a wall. Raises InputError for other solids."""
    if size == form.size:
        return form
    match form.shape:
        case Box():
            return Form(Box(size), size)
        case OffCentreBox(whole, centre):
            x, y, z = (part * side / full for part, side, full in zip(centre, size, whole, strict=True))
            return box_form(size, (x, y, z))
    raise InputError(
        "SD104", "this layout cuts bricks, and only boxes can be cut", "use a brick that is defined by `size`"
    )


# Models of bricks: kinds, and bricks in place.


MAX_TYPES: Final = 1000
MOST_AT_HAND: Final = 1000  # corners of a solid in YAML
PLAY: Final = 0.05  # share of the pitch by which a brick with studs may be shorter or longer than its studs


def side_off_studs(size: Vec3, pitch: float) -> float | None:
    """Return the length or width of a box that is between two sizes in studs [m]; None if both fit."""
    return next((side for side in size[:2] if abs(side - max(round(side / pitch), 1) * pitch) > PLAY * pitch), None)


class KnownBricks(Mapping[str, "BrickKind | None"]):
    """The named bricks of a scenario, None if the definition has mistakes, and the contents of mesh files by path."""

    def __init__(self, kinds: Mapping[str, "BrickKind | None"], files: Mapping[str, str]) -> None:
        self.kinds, self.files = kinds, files

    def __getitem__(self, name: str) -> "BrickKind | None":
        return self.kinds[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.kinds)

    def __len__(self) -> int:
        return len(self.kinds)


Points: TypeAlias = Annotated[
    tuple[tuple[t.Length, t.Length, t.Length], ...], Field(min_length=4, max_length=MOST_AT_HAND)
]


class Prism(AuthorModel):
    """A solid with a constant cross-section along one axis."""

    outline: Annotated[tuple[tuple[t.Length, t.Length], ...], Field(min_length=3, max_length=200)] = Field(
        description="corners [x, y] in order around the outline, seen from the front; y points up"
    )
    depth: t.Side = Field(description="length from front to back; the outline is at half this length")

    @model_validator(mode="after")
    def _is_a_solid(self) -> Self:
        prism_form(self.outline, self.depth)
        return self


class PartOfBrick(ExactlyOneKey):
    """A convex part of a rigid brick."""

    size: tuple[t.Side, t.Side, t.Side] | None = Field(None, description="length, width and thickness of a box")
    prism: Prism | None = Field(None, description="a prism, such as a wedge")
    points: Points | None = Field(None, description="corners [x, y, z] of a convex solid, in any order")
    at: tuple[t.Length, t.Length, t.Length] = default(
        ["0 mm", "0 mm", "0 mm"], "position [x, y, z] of the centre of a box, or of the origin of a solid, in the brick"
    )
    rotate: tuple[t.Angle, t.Angle, t.Angle] = default(
        ["0 deg", "0 deg", "0 deg"], "rotation about the axes of the brick: first x, then y, then z"
    )

    one_of: ClassVar[tuple[str, ...]] = ("size", "prism", "points")

    def placed(self) -> tuple[ConvexShape, Pose]:
        """Return the shape of the part, and the place of its centre of mass in the frame of the brick."""
        form = _form_of({"size": self.size, "prism": self.prism, "points": self.points}, None, None)
        assert form is not None
        if isinstance(form.shape, Compound):
            advice = "divide it into convex parts"
            raise InputError("SD104", "the outline of a part is not convex", advice)
        turn = about_axes(self.rotate)
        return form.shape, Pose(subtract(self.at, rotate(turn, form.origin)), turn)


class Section(AuthorModel):
    """A brick with a constant section, along y."""

    shape: SectionShape = Field(description="L, T, U (open above), I, or channel (a U that is open towards +x)")
    size: tuple[t.Side, t.Side, t.Side] = Field(description="width, length and height of the whole: x, y and z")
    thickness: t.Side = Field(description="thickness of the web and the flanges")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        section_boxes(self.shape, self.size, self.thickness)
        return self


class HollowBlock(AuthorModel):
    """A block with cells in a row along x, open above and below."""

    size: tuple[t.Side, t.Side, t.Side] = Field(description="length, width and height of the whole")
    wall: t.Side = Field(description="thickness of all walls")
    cells: Annotated[int, Field(strict=True, ge=1, le=MOST_CELLS)] = Field(2, description="number of cells")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        hollow_block_boxes(self.size, self.wall, self.cells)
        return self


class TableBrick(AuthorModel):
    """A table with four square legs at its corners."""

    size: tuple[t.Side, t.Side, t.Side] = Field(description="length, width and height of the whole")
    top: t.Side = Field(description="thickness of the top")
    leg: t.Side = Field(description="side of each leg")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        table_boxes(self.size, self.top, self.leg)
        return self


class Cylinder(AuthorModel):
    """A cylinder that stands upright; `rotate` lays it down."""

    diameter: t.Side = Field(description="diameter")
    height: t.Side = Field(description="height")

    def form(self, centre_of_mass: Vec3 | None) -> Form:
        """Return its form. Raises InputError."""
        return round_form(cylinder, 0.5 * self.diameter, self.height, centre_of_mass=centre_of_mass)


class Cone(AuthorModel):
    """A cone or the frustum of a cone that stands upright, such as a bucket."""

    bottom: t.NonNegativeLength = Field(description="diameter of the lower end; 0 mm for a point")
    top: t.NonNegativeLength = default("0 mm", "diameter of the upper end; 0 mm for a point")
    height: t.Side = Field(description="height")

    def form(self, centre_of_mass: Vec3 | None) -> Form:
        """Return its form. Raises InputError."""
        return round_form(frustum, 0.5 * self.bottom, 0.5 * self.top, self.height, centre_of_mass=centre_of_mass)

    @model_validator(mode="after")
    def _is_a_solid(self) -> Self:
        self.form(None)
        return self


class Pipe(AuthorModel):
    """A pipe that stands upright; nothing fits inside it."""

    diameter: t.Side = Field(description="outer diameter")
    wall: t.Side = Field(description="thickness of its wall")
    height: t.Side = Field(description="height, or length if it lies")

    def form(self, centre_of_mass: Vec3 | None) -> Form:
        """Return its form. Raises InputError."""
        return round_form(pipe, 0.5 * self.diameter, self.wall, self.height, centre_of_mass=centre_of_mass)

    @model_validator(mode="after")
    def _is_a_solid(self) -> Self:
        self.form(None)
        return self


class Sphere(Shorthand):
    """A ball."""

    scalar_key: ClassVar[str] = "diameter"

    diameter: t.Side = Field(description="diameter")

    def form(self, centre_of_mass: Vec3 | None) -> Form:
        """Return its form. Raises InputError."""
        return round_form(sphere, 0.5 * self.diameter, centre_of_mass=centre_of_mass)


class Capsule(AuthorModel):
    """An upright cylinder between two half balls."""

    diameter: t.Side = Field(description="diameter")
    height: t.Side = Field(description="height of the whole, at least the diameter")

    def form(self, centre_of_mass: Vec3 | None) -> Form:
        """Return its form. Raises InputError."""
        straight = self.height - self.diameter
        return round_form(capsule, 0.5 * self.diameter, straight, centre_of_mass=centre_of_mass)

    @model_validator(mode="after")
    def _is_a_solid(self) -> Self:
        if self.height < self.diameter:
            raise InputError("SD104", "the capsule is lower than its diameter", "write the height with both half balls")
        return self


_Round: TypeAlias = Cylinder | Cone | Pipe | Sphere | Capsule
ROUND_KEYS: Final = ("cylinder", "cone", "pipe", "sphere", "capsule")


class BrickKind(Shorthand, ExactlyOneKey):
    """A brick from the catalogue, or a box, a convex solid or a body of several parts, with its size and mass."""

    size: tuple[t.Side, t.Side, t.Side] | None = Field(None, description="length, width and thickness of a box")
    prism: Prism | None = Field(None, description="a prism, such as a wedge or an arch stone")
    cylinder: Cylinder | None = Field(None, description="a cylinder, such as a can, a barrel or a log")
    cone: Cone | None = Field(None, description="a cone, or the frustum of a cone, such as a bucket")
    pipe: Pipe | None = Field(None, description="a pipe")
    sphere: Sphere | None = Field(None, description="a ball")
    capsule: Capsule | None = Field(None, description="a cylinder between two half balls")
    points: Points | None = Field(None, description="corners [x, y, z] of a convex solid, in any order")
    file: t.Text | None = Field(
        None, description="OBJ, STL or PLY file of a solid; the path is relative to the folder of this file"
    )
    parts: Annotated[tuple[PartOfBrick, ...], Field(min_length=1, max_length=MOST_PARTS)] | None = Field(
        None, description="convex parts of one rigid brick, which touch without overlap"
    )
    section: Section | None = Field(None, description="a brick of L, T, U, I or channel section")
    hollow_block: HollowBlock | None = Field(None, description="a block with cells that are open above and below")
    table: TableBrick | None = Field(None, description="a table with four legs")
    pallet: Pallet | None = Field(None, description="a pallet such as `EUR`, with a closed deck or with boards")
    unit: Literal["mm", "cm", "m"] | None = Field(None, description="unit of length in the mesh file")
    centre_of_mass: tuple[t.Length, t.Length, t.Length] | None = Field(
        None,
        description="centre of mass [x, y, z], from the centre of a box, from half the height of a round brick, or in "
        "the frame of corners; default: centroid",
    )
    density: t.Density | None = Field(None, description="density, as an alternative to `mass`")
    mass: t.Mass | None = Field(None, description="mass of an uncut brick, as an alternative to `density`")
    friction: t.Friction | None = Field(None, description="Coulomb friction coefficient; default: that of the scenario")
    strength: BrickStrength | None = Field(
        None, description="strength against crushing: a pressure, or the load of a stack; default: it never crushes"
    )
    studs: StudGrid | None = Field(
        None, description="studs of the brick, which hold it to bricks and ground with the same studs; default: none"
    )
    smooth: t.Flag = Field(
        False, description="whether the brick has no studs on top, as a tile, which `studs` hold below"
    )
    _form: Form = PrivateAttr()
    _kind_name: str = PrivateAttr("")

    one_of: ClassVar[tuple[str, ...]] = ("density", "mass")
    also_one_of: ClassVar[tuple[str, ...]] = (
        *("size", "prism", *ROUND_KEYS, "points", "file"),
        *("parts", "section", "hollow_block", "table", "pallet"),
    )
    examples: ClassVar[Mapping[str, str]] = {"density": "500 kg/m3", "size": "[120 mm, 24 mm, 8 mm]"}

    @property
    def form(self) -> Form:
        """Return the form of a whole brick."""
        return self._form

    @property
    def kind_name(self) -> str:
        """Return the name of this kind of brick; empty if it has none."""
        return self._kind_name

    @classmethod
    def spelt_out(cls, scalar: object, known: Mapping[str, object]) -> object:
        name = scalar if isinstance(scalar, str) else ""
        if name in known:
            if known[name] is None:
                raise ConsequentialError
            return known[name]
        if name in CATALOGUE:
            bought = CATALOGUE[name]
            made = cls.model_construct(
                size=bought.size, density=bought.density, studs=bought.studs, smooth=bought.smooth
            )
            made._form, made._kind_name = box_form(bought.size), name
            return made
        message = f"there is no brick {shown(scalar)} in the catalogue or under `brick_types`"
        size = triple(name)
        hint = f"write {{size: {size}, density: {cls.examples['density']}}}" if size else ""
        hint = f"write {round_brick(name)}" if name in ROUND_WORDS else hint
        names = meant_lego(name) or did_you_mean(str(scalar), (*known, *CATALOGUE))
        names = names or did_you_mean(
            str(scalar), (*known, *(kind for kind in CATALOGUE if kind not in LEGO), "lego_2x4")
        )
        define = "" if names.endswith("?") else "define it under `brick_types`"
        raise InputError("SD104", message, hint or "; or ".join(filter(None, [names, define])))

    @classmethod
    def scalar_schema(cls, _properties: dict[str, t.JsonSchema]) -> t.JsonSchema:
        return {
            "type": "string",
            "anyOf": [{"enum": list(CATALOGUE)}, {"pattern": f"^{t.NAME}$|{t.EXPRESSION_PATTERN}"}],
        }

    @field_validator("points")
    @classmethod
    def _make_a_solid(cls, points: tuple[Vec3, ...] | None) -> tuple[Vec3, ...] | None:
        if points is not None:
            hull_form(points)
        return points

    @field_validator("parts")
    @classmethod
    def _join_the_parts(cls, parts: tuple[PartOfBrick, ...] | None) -> tuple[PartOfBrick, ...] | None:
        if parts is not None:
            compound_form(tuple(part.placed() for part in parts))
        return parts

    @field_validator("unit")
    @classmethod
    def _read_the_file(cls, unit: str | None, info: ValidationInfo) -> str | None:
        """Read the file with its unit. Pydantic validates `unit` after `file`."""
        file = info.data.get("file")
        if unit is not None and "file" in info.data and file is None:
            raise InputError(
                "SD108",
                "`unit` applies only to bricks with a `file`",
                "remove `unit`, and write a unit after each length",
            )
        if file is not None and unit is not None:
            mesh_form(_text_of(file, info), file, unit)
        return unit

    @field_validator("centre_of_mass")
    @classmethod
    def _is_inside(cls, centre: Vec3 | None, info: ValidationInfo) -> Vec3 | None:
        if centre is not None:
            _form_of(info.data, centre, info)
        return centre

    @field_validator("density", "mass")
    @classmethod
    def _reject_weightless(cls, written: float, info: ValidationInfo) -> float:
        """Reject masses that statics cannot distinguish from zero."""
        form = _form_of(info.data, None, info)
        if form is None:  # the mistake in the form is reported already
            return written
        mass = written * form.shape.volume if info.field_name == "density" else written
        if mass < LIGHTEST:
            message = f"a brick of {mass:.3g} kg is too light"
            hint = f"increase the {info.field_name}; the minimum mass is {LIGHTEST:g} kg"
            raise InputError("SD104", message, hint)
        return written

    @model_validator(mode="after")
    def _take_form(self, info: ValidationInfo) -> Self:
        if self.file is not None and self.unit is None:
            raise InputError(
                "SD102", "`unit`, the unit of length in the mesh file, is missing", "add it, for example `unit: mm`"
            )
        form = _form_of(dict(self), self.centre_of_mass, info)
        assert form is not None  # one of the keys of `also_one_of` is written
        if not SHORTEST <= form.shape.least_thickness <= form.shape.length <= SIDE.most:
            across = f"{form.shape.least_thickness:.3g} to {form.shape.length:.3g} m"
            message = f"the solid measures {across}; a brick must measure {SHORTEST:g} to {float(SIDE.most):g} m"
            raise InputError("SD104", message, "check the units of its lengths")
        self._form = form
        return self

    @model_validator(mode="after")
    def _studs_fill_the_box(self) -> Self:
        """Reject studs on other solids than boxes, and boxes between two sizes in studs."""
        if self.studs is None:
            if self.smooth:
                raise InputError("SD102", "`smooth` applies only with `studs`, which are missing", "add `studs: lego`")
            return self
        if self.size is None:
            message = "`studs` needs a box, and this brick is another solid"
            raise InputError("SD108", message, "define the brick by `size`, or remove `studs`")
        if (side := side_off_studs(self.size, self.studs.pitch)) is not None:
            pitch = self.studs.pitch
            message = f"a side of {mm(side)} does not fit studs every {mm(pitch)}"
            whole = max(round(side / pitch), 1) * pitch
            hint = f"write a length and a width that are multiples of {mm(pitch)}, such as {mm(whole)}"
            raise InputError("SD104", message, hint)
        return self

    def mass_of(self, form: Form) -> float:
        """Return the mass of a piece of another form, of the same material [kg]."""
        if self.mass is None:
            return (self.density or 0.0) * form.shape.volume
        return self.mass * form.shape.volume / self.form.shape.volume


def _text_of(file: str, info: ValidationInfo) -> str:
    """Return the content that a file had when the scenario was read."""
    files = info.context.files if isinstance(info.context, KnownBricks) else {}
    if file not in files:
        raise InputError(
            "SD113", f"the path {shown(file)} of the mesh contains an expression", "write a fixed path, without ${...}"
        )
    return str(files[file])


def _form_of(written: Mapping[str, Any], centre: Vec3 | None, info: ValidationInfo | None) -> Form | None:
    """Return the form that the written keys describe; None if one of them has a mistake."""
    if written.get("size") is not None:
        return box_form(written["size"], centre)
    if written.get("prism") is not None:
        return prism_form(written["prism"].outline, written["prism"].depth, centre)
    curved: _Round | None = next((written[key] for key in ROUND_KEYS if written.get(key) is not None), None)
    if curved is not None:
        return curved.form(centre)
    if written.get("points") is not None:
        return hull_form(written["points"], centre)
    if written.get("parts") is not None:
        return compound_form(tuple(part.placed() for part in written["parts"]), centre)
    if (made := _form_of_words(written, centre)) is not None:
        return made
    if info is not None and written.get("file") is not None and written.get("unit") is not None:
        return mesh_form(_text_of(written["file"], info), written["file"], written["unit"], centre)
    return None


def _form_of_words(written: Mapping[str, Any], centre: Vec3 | None) -> Form | None:
    """Return the form of a word for a common body of several parts; None if none is written."""
    if (section := written.get("section")) is not None:
        return compound_form(section_boxes(section.shape, section.size, section.thickness), centre)
    if (block := written.get("hollow_block")) is not None:
        return compound_form(hollow_block_boxes(block.size, block.wall, block.cells), centre)
    if (table := written.get("table")) is not None:
        return compound_form(table_boxes(table.size, table.top, table.leg), centre)
    if (pallet := written.get("pallet")) is not None:
        boards = pallet.boards
        return compound_form(pallet_boxes(pallet.whole, boards), centre) if boards else box_form(pallet.whole, centre)
    return None


def _not_in_catalogue(name: str) -> str:
    if name in CATALOGUE:
        raise InputError("SD104", f"'{name}' is already the name of a brick in the catalogue", "use another name")
    return name


BrickTypes = Annotated[
    dict[Annotated[str, t.TYPE_NAME, AfterValidator(_not_in_catalogue)], BrickKind], Field(max_length=MAX_TYPES)
]


def known_bricks(written: object, files: Mapping[str, str]) -> KnownBricks:
    """Read the named bricks of a scenario, None if a definition has mistakes. `files` are mesh files by path."""
    kinds = written if isinstance(written, dict) else {}
    return KnownBricks({name: _kind(name, kind, files) for name, kind in kinds.items()}, files)


def _kind(name: str, written: object, files: Mapping[str, str]) -> BrickKind | None:
    try:
        made = BrickKind.model_validate(written, context=KnownBricks({}, files))
    except ValidationError:
        return None
    made._kind_name = name  # also for an alias of a brick of the catalogue
    return made


_STUD_HEIGHT: Final = re.compile(r"\s*(?P<count>-?[0-9]{1,6})\s*(?P<unit>bricks?|plates?)\s*")
MOST_STUDS: Final = 10_000  # of a coordinate
DIGITS: Final = 12  # decimals of a metre; far more than the rounding error of products


def read_stud_height(written: object) -> int:
    """Read a height in bricks or plates, such as `2 bricks`; return plates."""
    if written == 0 and not isinstance(written, bool):
        return 0
    match = _STUD_HEIGHT.fullmatch(written) if isinstance(written, str) else None
    if match is None:
        advice = "write the height of its underside, such as `2 bricks` or `4 plates`"
        raise InputError("SD104", f"{shown(written)} is not a height in bricks or plates", advice)
    plates = int(match["count"]) * (PLATES if match["unit"].startswith("brick") else 1)
    if not 0 <= plates <= PLATES * MOST_STUDS:
        raise InputError("SD104", f"a height of {match[0].strip()} is out of range", f"write 0 to {MOST_STUDS} bricks")
    return plates


StudCount = Annotated[int, Field(strict=True, ge=-MOST_STUDS, le=MOST_STUDS)]
StudHeight = Annotated[
    int,
    t.Reads(
        read_stud_height,
        {
            "anyOf": [
                {"const": 0},
                t.text_schema(r"[0-9]{1,6}\s*(?:bricks?|plates?)", "a height in bricks or plates", "2 bricks"),
            ]
        },
    ),
]


class SetBrick(ExactlyOneKey):
    """One brick set down in any pose."""

    name: t.BrickName | None = Field(
        None, description="name of the brick; default: its level and its place in the level, such as L3.2"
    )
    at: tuple[t.Length, t.Length, t.Length] | None = Field(
        None, description="position [x, y, z] of the centre of a box, or of the origin of a solid"
    )
    stud: tuple[StudCount, StudCount, StudHeight] | None = Field(
        None,
        description="position [x, y, z] of a brick with studs: its lowest x and y in studs, and the height of its "
        "underside in bricks or plates",
    )
    turned: t.Flag = Field(False, description="whether the length of a brick with `stud` is along y instead of x")
    on: Annotated[t.Supports, BeforeValidator(t.listed), WithJsonSchema(t.SUPPORTS)] | None = Field(
        None, description="supporting brick or bricks, or the ground; the brick is centred on the mean of their centres"
    )
    beside: t.BodyName | None = Field(
        None, description="neighbouring brick that this brick touches; their lower sides are at the same height"
    )
    towards: t.Angle = default("0 deg", "direction from the neighbouring brick to this one: 0 deg = +x, 90 deg = +y")
    offset: tuple[t.Length, t.Length, t.Length] = default(
        ["0 mm", "0 mm", "0 mm"], "additional displacement [x, y, z], along the axes of the scene"
    )
    rotate: tuple[t.Angle, t.Angle, t.Angle] = default(
        ["0 deg", "0 deg", "0 deg"], "rotation about the axes of the scene: first x, then y, then z"
    )
    brick: BrickKind | None = Field(
        None, description="kind of brick; default: that of the step, or otherwise that of the scenario"
    )
    level: Levels | None = Field(None, description="level of the brick; default: derived from its height")
    friction: t.Friction | None = Field(
        None, description="Coulomb friction coefficient; default: that of its kind of brick"
    )

    one_of: ClassVar[tuple[str, ...]] = ("at", "stud", "on", "beside")

    def on_studs(self, kind: BrickKind) -> tuple[Vec3, Vec3]:
        """Return the centre [m] and the angles about the axes [rad] of a brick with `stud`. Raises InputError."""
        if self.stud is None or kind.studs is None:
            named = f"'{kind.kind_name}'" if kind.kind_name else "this brick"
            hint = "use a brick of the catalogue, such as `brick: lego_2x4`, or add `studs` to its kind"
            raise InputError("SD108", f"`stud` places bricks with studs, and {named} has none", hint)
        pitch, (length, width, height) = kind.studs.pitch, kind.form.size
        x, y = (width, length) if self.turned else (length, width)
        # A plate is 0.4 of the pitch high, of LEGO bricks and of their doubles for small children.
        base = 0.4 * pitch * self.stud[2]
        middle = (
            pitch * (self.stud[0] + 0.5 * round(x / pitch)),
            pitch * (self.stud[1] + 0.5 * round(y / pitch)),
            base + 0.5 * height,
        )
        centre = round(middle[0], DIGITS), round(middle[1], DIGITS), round(middle[2], DIGITS)
        return centre, (0.0, 0.0, 0.5 * pi if self.turned else 0.0)

    @model_validator(mode="after")
    def _only_beside_stud(self) -> Self:
        written = self.model_fields_set
        if self.stud is None and "turned" in written:
            message = "`turned` applies only with `stud`, which is missing"
            raise InputError("SD108", message, "write `rotate: [0 deg, 0 deg, 90 deg]`")
        if self.stud is not None and "rotate" in written:
            message = "`rotate` and `stud` exclude each other"
            raise InputError("SD108", message, "write `turned: true` for a brick along y, or `at` in place of `stud`")
        if self.stud is not None and self.brick is not None:
            self.on_studs(self.brick)
        return self

    @model_validator(mode="after")
    def _shift_from_something(self) -> Self:
        written = self.model_fields_set
        for key in ("at", "stud"):
            if getattr(self, key) is not None and "offset" in written:
                raise InputError(
                    "SD108",
                    f"`offset` applies only with `on` or `beside`, but this brick has `{key}`",
                    f"add the offset to `{key}`",
                )
        if self.beside is None and "towards" in written:
            raise InputError(
                "SD108",
                "`towards` applies only with `beside`, which is missing",
                "add `beside` with the name of a brick",
            )
        if GROUND in (self.on or ()) and len(self.on or ()) > 1:
            raise InputError("SD104", "`on` lists both bricks and the ground", "remove `ground` from the list")
        return self


class PlacedBrick(SetBrick):
    """One brick in any pose, set down or dropped."""

    drop: Annotated[bool, Field(strict=True)] = Field(
        False, description="whether the brick is released in the air instead of set down"
    )
    repeat: t.REPEAT = Field(None, description="variables and their values; the item is repeated for each combination")
