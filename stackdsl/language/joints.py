"""Joints between bricks: mortar and glue, magnets and tape, studs."""

import re
from collections.abc import Mapping
from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from stackdsl.language import value_types as t
from stackdsl.language.lego import PITCH
from stackdsl.language.model_base import AuthorModel, ExactlyOneKey, Shorthand
from stackdsl.language.quantities import LONG_DURATION, InputError, parse_quantity, quantity_pattern

MAX_RULES: Final = 1000


_SETTING: Final = re.compile(r"(.*?)\s+after\s+placing")


def _read_setting(written: object) -> float:
    """Read the time until mortar has set, such as `2 d after placing` [s]."""
    match = _SETTING.fullmatch(written.strip()) if isinstance(written, str) else None
    try:
        return parse_quantity(match[1] if match else written, LONG_DURATION)
    except InputError as error:
        raise InputError(error.code, error.message, f"{error.hint}; for example `2 d after placing`") from error


SettingTime = Annotated[
    float,
    t.Reads(
        _read_setting,
        t.text_schema(
            rf"{quantity_pattern(LONG_DURATION)}(?:\s+after\s+placing)?",
            "a duration after placing",
            "2 d after placing",
        ),
    ),
]


DUCTILE: Final = Field(
    0.0,
    description="distance by which the bodies may move apart while the joint keeps its strength; default: it opens as "
    "soon as it yields",
)


class MortarOrGlue(AuthorModel):
    """Strength per area: mortar or glue."""

    tension: t.Strength = Field(description="greatest tension across the joint, per area")
    cohesion: t.Strength = Field(
        description="greatest shear without pressure, per area; pressure adds friction to it, and tension reduces it"
    )
    shear: t.Strength | None = Field(None, description="greatest shear at any pressure, per area; default: none")
    brittle: t.Flag = Field(
        False, description="whether the joint sheds its force when it yields, so that others must bear it"
    )
    ductile: t.NonNegativeLength = DUCTILE
    from_: SettingTime | None = Field(
        None, alias="from", description="time after placing from which the joint holds, such as `2 d after placing`"
    )

    @model_validator(mode="after")
    def _shear_is_more(self) -> Self:
        if self.shear is not None and self.shear < self.cohesion:
            message = "`shear` is less than `cohesion`, so the joint never has its cohesion"
            raise InputError("SD104", message, "write a `shear` of at least `cohesion`, or remove it")
        if self.brittle and self.ductile:
            message = "`brittle` and `ductile` exclude each other: a brittle joint sheds its force as soon as it yields"
            raise InputError("SD108", message, "remove one of them")
        return self


class Mortar(Shorthand):
    """Mortar between the bricks of a layout."""

    thickness: t.PositiveLength = Field(description="thickness of each joint, from brick to brick")
    bond: MortarOrGlue | None = Field(None, description="strength of the mortar; default: that of an item of `joints`")
    density: t.Density | None = Field(None, description="density of the mortar; default: that of the brick")

    scalar_key: ClassVar[str] = "thickness"


class MagnetOrTape(Shorthand):
    """Force at each corner of a contact: magnets, tape or Velcro."""

    force: t.Force = Field(description="force that pulls each corner of the contact")
    ductile: t.NonNegativeLength = DUCTILE

    scalar_key: ClassVar[str] = "force"


class StudGrid(Shorthand):
    """Studs on a square grid, centred on the top and the bottom of each box."""

    pitch: t.Side = Field(description="distance of two studs")
    pull: t.Force = Field(description="greatest pull of one stud")
    narrow_pull: t.Force | None = Field(
        None, description="greatest pull of one stud under a brick that is one stud wide; default: `pull`"
    )
    shear: t.Force = Field(description="greatest sideways force of one stud, in any direction")
    ductile: t.NonNegativeLength = DUCTILE

    scalar_word: ClassVar[str] = "lego"

    @classmethod
    def spelt_out(cls, scalar: object, known: Mapping[str, object]) -> object:
        return LEGO_STUDS if scalar == cls.scalar_word else super().spelt_out(scalar, known)


# The pull under a wide brick is fitted to structures that were built for StableLego, the other one is that of BrickSim:
# see docs/joints.md. No structure of light bricks shears a stud off, and no strength is published; this one is that of
# 3 mm2 of the plastic.
LEGO_STUDS: Final = StudGrid.model_construct(pitch=float(PITCH), pull=1.7, narrow_pull=2.8, shear=100.0, ductile=0.0)


class JoinedBodies(AuthorModel):
    """Bodies between which joints act."""

    of: t.JoinedNames | None = Field(
        None,
        description="names of kinds of brick, steps, bricks, the ground or walls, which are joined to each other; "
        "default: all bodies",
    )
    between: tuple[t.JoinedName, t.JoinedName] | None = Field(
        None, description="two such names: each body of one is joined to each body of the other"
    )

    @property
    def named(self) -> tuple[str, ...]:
        """Return the names; none for all bodies."""
        return self.of or self.between or ()

    @model_validator(mode="after")
    def _of_or_between(self) -> Self:
        if self.of is not None and self.between is not None:
            message = "`of` and `between` exclude each other"
            raise InputError("SD108", message, "remove one of them, or begin another item")
        return self


class JointKind(ExactlyOneKey, JoinedBodies):
    """Joints of one kind, between some bodies."""

    bond: MortarOrGlue | None = Field(None, description="mortar or glue, by its strength per area")
    pull: MagnetOrTape | None = Field(
        None, description="magnets, tape or Velcro: the force that pulls each corner of the contact"
    )
    studs: StudGrid | None = Field(None, description="studs of toy bricks, by their grid and the strength of each")

    one_of: ClassVar[tuple[str, ...]] = ("bond", "pull", "studs")
    examples: ClassVar = {"bond": "{tension: 0.2 MPa, cohesion: 0.3 MPa}", "pull": "2 N"}


class JointOfBricks(JointKind):
    """Joints of one kind, or none, between some bodies."""

    dry: Literal[True] | None = Field(None, description="`true`: no joint, whatever later items say")

    one_of: ClassVar[tuple[str, ...]] = ("bond", "pull", "studs", "dry")


Joints = Annotated[tuple[JointOfBricks, ...], Field(max_length=MAX_RULES)]
