"""Bricks in YAML: shapes, sizes, masses and places."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite
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
from stability.geometry.convex_solid import NotASolidError
from stability.geometry.vectors import SHORTEST, scale, subtract
from stability.model import GROUND, ConvexShape, Vec3
from stability.statics.assembly import LIGHTEST
from stackdsl.diagnostics import did_you_mean
from stackdsl.language import value_types as t
from stackdsl.language.layouts.registry import BrickSpec
from stackdsl.language.model_base import AuthorModel, ExactlyOneKey, Shorthand, default
from stackdsl.language.quantities import SIDE, EchoError, MistakeError, shown
from stackdsl.language.value_types import Levels
from stackdsl.supervising.executors import supervised
from stackdsl.supervising.worker import Task, TaskStatus, memory_limited

if TYPE_CHECKING:
    from stability.geometry.solid_making import Made


# Bricks that scenarios know by name.


@dataclass(frozen=True, slots=True)
class CatalogueBrick:
    """A brick that can be bought, or an idealised one."""

    size: Vec3  # length, width, thickness; lying flat [m]
    density: float  # [kg/m3]


PINE: Final = 557.0  # [kg/m3], of a KAPLA plank of nominal size and 11.9 g

CATALOGUE: Final[Mapping[str, CatalogueBrick]] = {
    "kapla": CatalogueBrick((0.1176, 0.0234, 0.0078), PINE),
    # Sides of exactly 1:3:15, the plank of the published method. Of the same wood, so the same density and not the same
    # mass: what a structure does does not depend on a density that all of its bricks share.
    "kapla-ideal": CatalogueBrick((0.120, 0.024, 0.008), PINE),
}


# The text of a Wavefront OBJ file as corners and faces: of all that such a file may hold, its `v` and `f` lines.


MOST_LINES: Final = 100_000
LEAST_PARTS: Final = 3  # of a corner, and of a face
_CORNER: Final = re.compile(r"[-+]?[0-9]{1,18}(?=/|$)")


@dataclass(slots=True)
class ObjMesh:
    """What an OBJ file describes."""

    points: list[tuple[float, float, float]] = field(default_factory=list)
    loops: list[tuple[int, ...]] = field(default_factory=list)  # corners of each face, from 0


def obj_mesh(text: str, file: str) -> ObjMesh:
    """The mesh of a file. Raises MistakeError, with the line, for what is no corner and no face."""
    mesh = ObjMesh()
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        raise MistakeError("SD104", f"{file} has {len(lines)} lines, and {MOST_LINES} is the most", "simplify the mesh")
    for number, line in enumerate(lines, start=1):
        kind, *parts = line.partition("#")[0].split() or [""]
        try:
            if kind == "v":
                mesh.points.append(_point(parts))
            elif kind == "f":
                mesh.loops.append(_loop(parts, len(mesh.points)))
        except ValueError as error:
            hint = "a corner is `v 0.1 0 0.05`, and a face `f 1 2 3`, by the numbers of corners above it"
            raise MistakeError("SD104", f"{file}:{number}: {error}", hint) from None
    if not mesh.loops:
        raise MistakeError("SD104", f"{file} has no faces", "export it as a mesh, with `v` and `f` lines")
    return mesh


def _point(parts: Sequence[str]) -> tuple[float, float, float]:
    if len(parts) < LEAST_PARTS:
        raise ValueError(f"a corner of {len(parts)} numbers")
    x, y, z = (_number(part) for part in parts[:LEAST_PARTS])  # a weight or a colour may follow
    return (x, y, z)


def _number(part: str) -> float:
    try:
        number = float(part)
    except ValueError:
        raise ValueError(f"{shown(part)} is no number") from None
    if not part.isascii() or "_" in part:  # as Python would read
        raise ValueError(f"{shown(part)} is no number")
    if not isfinite(number):
        raise ValueError(f"{shown(part)} is no number that means a place")
    return number


def _loop(parts: Sequence[str], known: int) -> tuple[int, ...]:
    if len(parts) < LEAST_PARTS:
        raise ValueError(f"a face of {len(parts)} corners")
    loop = tuple(_corner(part, known) for part in parts)
    if len(set(loop)) < len(loop):
        raise ValueError("a face that has one corner twice")
    return loop


def _corner(part: str, known: int) -> int:
    """Of `3/1/2`, where texture and normal follow; -1 is the last corner so far."""
    number = corner_number(part)
    if number is None:
        raise ValueError(f"{shown(part)} names no corner")
    index = number - 1 if number > 0 else known + number
    if number == 0 or not 0 <= index < known:
        raise ValueError(f"there is no corner {number}: {known} stand above")
    return index


def corner_number(part: str) -> int | None:
    """The number of a corner in a part of a face, such as 3 of `3/1/2`; None if there is none."""
    match = _CORNER.match(part)
    return int(match[0]) if match else None


# What a brick is made to: its shape, the box around it, and which of its points an author means by its place.


KEPT: Final = 4096  # forms that are worked out once
MOST_AT_ONCE: Final = 200  # corners of which a solid is made in milliseconds, whatever they are
TIME_LIMIT: Final = 20.0  # [s] of wall time for one of more corners; of a thousand that are no solid, Qhull takes two
MEMORY_LIMIT: Final = 1 << 30  # [bytes] for it
METRES: Final = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}

Outline: TypeAlias = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Form:
    """The form of a brick. Ways lead from its centre of mass, in its own axes [m]."""

    shape: ConvexShape
    size: Vec3  # of the box around it, along its own axes [m]
    middle: Vec3 = MIDDLE  # to the middle of that box, which layouts, `on` and `beside` go by
    origin: Vec3 = MIDDLE  # to what `at` says the place of: of a box its middle, of a solid where it is written from


def box_form(size: Vec3, centre_of_mass: Vec3 | None = None) -> Form:
    """A box, its centre of mass seen from its middle [m]. Raises MistakeError."""
    if centre_of_mass is None or centre_of_mass == MIDDLE:
        return Form(Box(size), size)
    if any(abs(part) >= 0.5 * side for part, side in zip(centre_of_mass, size, strict=True)):
        message = "the centre of mass lies outside of the box"
        raise MistakeError("SD104", message, "write it as seen from the middle of the box, inside of it")
    back = subtract(MIDDLE, centre_of_mass)
    return Form(OffCentreBox(size, centre_of_mass), size, back, back)


@lru_cache(maxsize=KEPT)
def prism_form(outline: Outline, depth: float, centre_of_mass: Vec3 | None = None) -> Form:
    """A prism. Raises MistakeError."""
    from stability.geometry.solid_making import prism  # noqa: PLC0415 -- boxes do without scipy

    try:
        made = prism(outline, depth, centre_of_mass)
    except NotASolidError as error:
        raise MistakeError("SD104", error.message, error.hint) from error
    return _form(made.shape, made.centre_of_mass)


@lru_cache(maxsize=KEPT)
def hull_form(points: tuple[Vec3, ...], centre_of_mass: Vec3 | None = None) -> Form:
    """The hull of points. Raises MistakeError."""
    from stability.geometry.solid_making import solid_of_corners  # noqa: PLC0415 -- boxes do without scipy

    try:
        made = _solid(solid_of_corners, points, centre_of_mass)
    except NotASolidError as error:
        raise MistakeError("SD104", error.message, error.hint) from error
    return _form(made.shape, made.centre_of_mass)


@lru_cache(maxsize=KEPT)
def mesh_form(text: str, file: str, unit: str, centre_of_mass: Vec3 | None = None) -> Form:
    """The solid of the text of an OBJ file. Raises MistakeError."""
    from stability.geometry.solid_making import solid_of_mesh  # noqa: PLC0415 -- boxes do without scipy

    mesh = obj_mesh(text, file)
    try:
        points = tuple(scale(METRES[unit], point) for point in mesh.points)
        made = _solid(solid_of_mesh, points, tuple(mesh.loops), centre_of_mass)
    except NotASolidError as error:
        raise MistakeError("SD104", f"{file}: {error.message}", error.hint) from error
    return _form(made.shape, made.centre_of_mass)


def _solid(make: "Callable[..., Made]", points: tuple[Vec3, ...], *others: object) -> "Made":
    """The solid that a function makes of points. Raises NotASolidError.

    Of many it is made in a supervised process: for points on a circle Qhull takes their square, and no signal ends it.
    """
    if len(points) <= MOST_AT_ONCE:
        return make(points, *others)
    made = _made_apart(make, points, *others)
    if isinstance(made, tuple):
        raise NotASolidError(*made)
    return made


@lru_cache(maxsize=KEPT)
def _made_apart(make: "Callable[..., Made]", *arguments: object) -> "Made | tuple[str, str, int | None]":
    done = supervised(Task(_made_or_why, (make, *arguments), TIME_LIMIT))
    if done.status is TaskStatus.DONE:
        return done.value  # type: ignore[return-value]  # it is what the function returns
    broken = "take too long" if done.status is TaskStatus.TIMED_OUT else "break Qhull"
    return f"its corners {broken}: {done.message}", "write a simpler solid, close to it", None


def _made_or_why(make: "Callable[..., Made]", *arguments: object) -> "Made | tuple[str, str, int | None]":
    """What the worker does: make a solid, or say why there is none."""
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
    """What a layout lays of bricks of a form: whole ones, pieces, or stones of its own. Raises MistakeError."""
    if spec.outline is None:
        return cut_to(form, spec.size or form.size)
    return prism_form(spec.outline, spec.depth)


def cut_to(form: Form, size: Vec3) -> Form:
    """The same material in another size, as at the ends of a wall: of boxes only."""
    if size == form.size:
        return form
    match form.shape:
        case Box():
            return Form(Box(size), size)
        case OffCentreBox(whole, centre):
            x, y, z = (part * side / full for part, side, full in zip(centre, size, whole, strict=True))
            return box_form(size, (x, y, z))
    raise MistakeError(
        "SD104", "the layout lays pieces of bricks, and a solid cannot be cut", "take boxes, given by their `size`"
    )


# What an author may say of a brick: what it is, and where it is put.


MAX_TYPES: Final = 1000


class KnownBricks(Mapping[str, "BrickKind | None"]):
    """The bricks that a scenario names, None where their own lines are mistaken; and the files that bricks are of."""

    def __init__(self, kinds: Mapping[str, "BrickKind | None"], files: Mapping[str, str]) -> None:
        self.kinds, self.files = kinds, files

    def __getitem__(self, name: str) -> "BrickKind | None":
        return self.kinds[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.kinds)

    def __len__(self) -> int:
        return len(self.kinds)


class Prism(AuthorModel):
    """A solid that is alike all along one way."""

    outline: Annotated[tuple[tuple[t.Length, t.Length], ...], Field(min_length=3, max_length=200)] = Field(
        description="[x, y] of its corners in order around it, as seen from the front: y is up"
    )
    depth: t.Side = Field(description="how far it goes from front to back; the outline is in the middle of that")

    @model_validator(mode="after")
    def _is_a_solid(self) -> Self:
        prism_form(self.outline, self.depth)
        return self


class BrickKind(Shorthand, ExactlyOneKey):
    """A brick from the catalogue, or one of its own: a box, or any convex solid."""

    size: tuple[t.Side, t.Side, t.Side] | None = Field(None, description="length, width, thickness of a box")
    prism: Prism | None = Field(None, description="a solid of one outline all along: a wedge, a stone of an arch")
    points: Annotated[tuple[tuple[t.Length, t.Length, t.Length], ...], Field(min_length=4, max_length=1000)] | None = (
        Field(None, description="[x, y, z] of each corner of a convex solid, in any order")
    )
    file: t.Text | None = Field(
        None, description="a convex solid from an OBJ file, as seen from the folder of this one"
    )
    unit: Literal["mm", "cm", "m"] | None = Field(None, description="of the lengths in the file, which do not say")
    centre_of_mass: tuple[t.Length, t.Length, t.Length] | None = Field(
        None,
        description="[x, y, z] from the middle of a box, or as the corners of a solid; default: of an even filling",
    )
    density: t.Density | None = Field(None, description="density; or else give the mass")
    mass: t.Mass | None = Field(None, description="mass of a whole brick; or else give the density")
    friction: t.Friction | None = Field(None, description="Coulomb coefficient of its own; default: the scenario's")
    _form: Form = PrivateAttr()
    _called: str = PrivateAttr("")

    one_of: ClassVar[tuple[str, ...]] = ("density", "mass")
    also_one_of: ClassVar[tuple[str, ...]] = ("size", "prism", "points", "file")

    @property
    def form(self) -> Form:
        """What a whole brick is made to."""
        return self._form

    @property
    def called(self) -> str:
        """The name of this kind of brick; empty if it has none."""
        return self._called

    @classmethod
    def spelt_out(cls, scalar: object, known: Mapping[str, object]) -> object:
        name = scalar if isinstance(scalar, str) else ""
        if name in known:
            if known[name] is None:
                raise EchoError
            return known[name]
        if name in CATALOGUE:
            made = cls.model_construct(size=CATALOGUE[name].size, density=CATALOGUE[name].density)
            made._form, made._called = box_form(CATALOGUE[name].size), name
            return made
        message = f"there is no brick {shown(scalar)} in the catalogue, nor under `brick_types`"
        raise MistakeError("SD104", message, did_you_mean(str(scalar), (*known, *CATALOGUE)))

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

    @field_validator("unit")
    @classmethod
    def _read_the_file(cls, unit: str | None, info: ValidationInfo) -> str | None:
        """The unit comes after the file."""
        file = info.data.get("file")
        if unit is not None and "file" in info.data and file is None:
            raise MistakeError("SD108", "`unit` is of a `file`, and there is none", "write units at the lengths")
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
    def _outweighs_nothing(cls, written: float, info: ValidationInfo) -> float:
        """What statics cannot tell from nothing is no brick."""
        form = _form_of(info.data, None, info)
        if form is None:  # it is told by itself
            return written
        mass = written * form.shape.volume if info.field_name == "density" else written
        if mass < LIGHTEST:
            message = f"a brick of {mass:.3g} kg is lighter than any that can be weighed"
            hint = f"write a {info.field_name} that makes it at least {LIGHTEST:g} kg"
            raise MistakeError("SD104", message, hint)
        return written

    @model_validator(mode="after")
    def _take_form(self, info: ValidationInfo) -> Self:
        if self.file is not None and self.unit is None:
            raise MistakeError("SD102", "the file does not say in which unit its lengths are", "add `unit: mm`")
        form = _form_of(dict(self), self.centre_of_mass, info)
        assert form is not None  # one of its keys is there
        if not SHORTEST <= form.shape.least_thickness <= form.shape.length <= SIDE.most:
            across = f"{form.shape.least_thickness:.3g} to {form.shape.length:.3g} m"
            message = f"the solid measures {across}, and a brick {SHORTEST:g} to {float(SIDE.most):g} m"
            raise MistakeError("SD104", message, "look at its units")
        self._form = form
        return self

    def mass_of(self, form: Form) -> float:
        """Mass of a piece of this form, of the same material [kg]."""
        if self.mass is None:
            return (self.density or 0.0) * form.shape.volume
        return self.mass * form.shape.volume / self.form.shape.volume


def _text_of(file: str, info: ValidationInfo) -> str:
    """What a file held when the scenario was read."""
    files = info.context.files if isinstance(info.context, KnownBricks) else {}
    if file not in files:
        raise MistakeError("SD113", f"the file {shown(file)} was not read", "write its path, without ${...}")
    return str(files[file])


def _form_of(written: Mapping[str, Any], centre: Vec3 | None, info: ValidationInfo) -> Form | None:
    """The form that some keys describe; None where one of them is mistaken."""
    if written.get("size") is not None:
        return box_form(written["size"], centre)
    if written.get("prism") is not None:
        return prism_form(written["prism"].outline, written["prism"].depth, centre)
    if written.get("points") is not None:
        return hull_form(written["points"], centre)
    if written.get("file") is not None and written.get("unit") is not None:
        return mesh_form(_text_of(written["file"], info), written["file"], written["unit"], centre)
    return None


def _of_its_own(name: str) -> str:
    if name in CATALOGUE:
        raise MistakeError("SD104", f"'{name}' is a brick of the catalogue", "take another name")
    return name


BrickTypes = Annotated[
    dict[Annotated[str, t.TYPE_NAME, AfterValidator(_of_its_own)], BrickKind], Field(max_length=MAX_TYPES)
]


def known_bricks(written: object, files: Mapping[str, str]) -> KnownBricks:
    """The bricks that a scenario names, made of these files; None where its own lines are mistaken."""
    given = written if isinstance(written, dict) else {}
    return KnownBricks({name: _kind(name, kind, files) for name, kind in given.items()}, files)


def _kind(name: str, written: object, files: Mapping[str, str]) -> BrickKind | None:
    try:
        made = BrickKind.model_validate(written, context=KnownBricks({}, files))
    except ValidationError:
        return None
    made._called = name  # also where it is but another name for a brick of the catalogue
    return made


class SetBrick(ExactlyOneKey):
    """One brick set down in any pose."""

    name: t.BrickName | None = Field(None, description="its name; default: by place, such as L3.2")
    at: tuple[t.Length, t.Length, t.Length] | None = Field(
        None, description="[x, y, z] of its middle, or of the origin of a solid"
    )
    on: Annotated[t.Supports, BeforeValidator(t.listed), WithJsonSchema(t.SUPPORTS)] | None = Field(
        None, description="the brick, or bricks, on whose top it lies, in the middle of their centres; or the ground"
    )
    beside: t.BodyName | None = Field(None, description="the brick that it stands beside, touching it, as low as that")
    towards: t.Angle = default("0 deg", "where it stands, seen from what it is beside: 0 deg = +x, 90 deg = +y")
    offset: tuple[t.Length, t.Length, t.Length] = default(
        ["0 mm", "0 mm", "0 mm"], "shifts it from there by [x, y, z], in the axes of the scene"
    )
    rotate: tuple[t.Angle, t.Angle, t.Angle] = default(
        ["0 deg", "0 deg", "0 deg"], "turn about x, then y, then z, the axes of the scene"
    )
    brick: BrickKind | None = Field(None, description="default: the brick of the step, or else of the scenario")
    level: Levels | None = Field(None, description="its level; default: judged by its height")
    friction: t.Friction | None = Field(None, description="Coulomb coefficient of its own; default: of what it is")

    one_of: ClassVar[tuple[str, ...]] = ("at", "on", "beside")

    @model_validator(mode="after")
    def _shift_from_something(self) -> Self:
        written = self.model_fields_set
        if self.at is not None and "offset" in written:
            raise MistakeError(
                "SD108", "`offset` is from another brick, and this one has its place `at`", "add them up"
            )
        if self.beside is None and "towards" in written:
            raise MistakeError("SD108", "`towards` is of what stands `beside` another brick", "say beside which")
        if GROUND in (self.on or ()) and len(self.on or ()) > 1:
            raise MistakeError("SD104", "a brick lies on others or on the ground, not on both", "leave the ground out")
        return self


class PlacedBrick(SetBrick):
    """One brick in any pose, set down or let go."""

    drop: Annotated[bool, Field(strict=True)] = Field(False, description="let go in the air, rather than set down")
    repeat: t.REPEAT = Field(None, description="variables that each repetition has its own values of")
