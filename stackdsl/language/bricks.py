"""What an author may say of a brick: what it is, and where it is put."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Final, Literal, Self

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

from stability.geometry.given_numbers import SHORTEST
from stability.model import GROUND, Vec3
from stability.statics.admission import LIGHTEST
from stackdsl.diagnostics import did_you_mean
from stackdsl.language import author_types as t
from stackdsl.language.author_models import AuthorModel, Choice, Shorthand, default
from stackdsl.language.author_types import Levels
from stackdsl.language.brick_forms import Form, box_form, hull_form, mesh_form, prism_form
from stackdsl.language.catalogue import CATALOGUE
from stackdsl.language.mistakes import EchoError, MistakeError, shown
from stackdsl.language.quantities import SIDE

MAX_TYPES: Final = 1000


class Known(Mapping[str, "BrickKind | None"]):
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


class BrickKind(Shorthand, Choice):
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
    files = info.context.files if isinstance(info.context, Known) else {}
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


def known_bricks(written: object, files: Mapping[str, str]) -> Known:
    """The bricks that a scenario names, made of these files; None where its own lines are mistaken."""
    given = written if isinstance(written, dict) else {}
    return Known({name: _kind(name, kind, files) for name, kind in given.items()}, files)


def _kind(name: str, written: object, files: Mapping[str, str]) -> BrickKind | None:
    try:
        made = BrickKind.model_validate(written, context=Known({}, files))
    except ValidationError:
        return None
    made._called = name  # also where it is but another name for a brick of the catalogue
    return made


class SetBrick(Choice):
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
