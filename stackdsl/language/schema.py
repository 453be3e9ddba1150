"""Pydantic models of a scenario, with a description of every key."""

from collections.abc import Sequence
from copy import copy
from functools import cache
from importlib.util import find_spec
from itertools import pairwise
from math import pi
from typing import Annotated, Any, ClassVar, Final, Literal, NamedTuple, Self, TypeAlias

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    WithJsonSchema,
    create_model,
    model_validator,
)
from pydantic_core import CoreSchema

from stability.dynamics.ground_motion import Course, SineCourse, TabulatedCourse
from stackdsl.language import value_types as t
from stackdsl.language.bricks import BrickKind, BrickTypes, PlacedBrick
from stackdsl.language.claims.claim import Claim, Expectation, Truth
from stackdsl.language.claims.claim_kind import CLAIMS, KindOfClaim
from stackdsl.language.hands import ByHand, HandErrors
from stackdsl.language.impacts import IMPACTS, Impact, KindOfImpact
from stackdsl.language.imports import Import
from stackdsl.language.layouts.registry import LAYOUTS, Layout, LayoutParams
from stackdsl.language.model_base import AnchorText, AuthorModel, Shorthand, Timed, default, with_kinds
from stackdsl.language.quantities import MistakeError
from stackdsl.language.value_types import MAX_BRICKS

# Friction of particular pairs, besides the one coefficient that most scenarios have.


MAX_PAIRS: Final = 1000

RubbingName = Annotated[str, t.TYPE_NAME]


class PairOfBodies(AuthorModel):
    """Friction between two bodies or kinds of bricks."""

    pair: tuple[RubbingName, RubbingName] = Field(
        description="names of two kinds of brick, bricks, the ground or walls; one kind twice for two bricks of it"
    )
    friction: t.Friction = Field(description="Coulomb coefficient between the two")


class Frictions(AuthorModel):
    """Friction between bodies with different coefficients."""

    rule: Literal["lower", "higher", "mean", "geometric"] = Field(
        "lower", description="how the coefficients of two bodies combine"
    )
    between: Annotated[tuple[PairOfBodies, ...], Field(max_length=MAX_PAIRS)] = Field(
        (), description="coefficients of particular pairs, in place of the rule"
    )


# Scenarios that are skipped or expected to fail, each with the reason.


Package = Literal["mujoco"]  # optional packages, for formats


def _in_one_line(text: str) -> str:
    return " ".join(text.split())


class Mark(Shorthand):
    """A reason, and the systems that it applies to."""

    reason: Annotated[t.Text, AfterValidator(_in_one_line)] = Field(description="the reason")
    system: Annotated[t.Systems, BeforeValidator(t.listed), WithJsonSchema(t.ONE_OR_MORE_SYSTEMS)] | None = Field(
        None, description="the system or systems that this applies to; default: all"
    )

    scalar_key: ClassVar[str] = "reason"

    def is_of(self, system: str) -> bool:
        """Return whether the mark applies to a system."""
        return self.system is None or system in self.system


class Skip(Mark):
    """A scenario that is not run."""

    without: Package | None = Field(None, description="skipped only if this Python package is not installed")

    def is_of(self, system: str) -> bool:
        """Return whether the mark applies to a system in this environment."""
        return Mark.is_of(self, system) and (self.without is None or not is_installed(self.without))


def is_installed(package: str) -> bool:
    """Return whether a Python package can be imported."""
    return find_spec(package) is not None


class Xfail(Mark):
    """A scenario that is run and expected to fail."""

    strict: t.Flag = Field(True, description="whether the check fails if all expectations are met")


# Shaking of the ground: a sine, or a table.


Row: TypeAlias = tuple[t.Duration, t.SignedAcceleration]


def _in_order(rows: Sequence[Row]) -> Sequence[Row]:
    for number, (before, after) in enumerate(pairwise(rows), start=2):
        if after[0] < before[0]:
            message = f"row {number} of the table is at {after[0]:g} s, and the row before it at {before[0]:g} s"
            raise MistakeError(
                "SD104", message, "write the rows in order of time; two rows of the same time are a jump"
            )
    if rows[-1][0] == rows[0][0]:
        raise MistakeError("SD104", "the table has no duration", "write a later row")
    return rows


Table = Annotated[tuple[Row, ...], Field(min_length=2, max_length=100_000), AfterValidator(_in_order)]


class Shake(Timed):
    """The ground moves horizontally to and fro along one line."""

    at: t.Duration | None = Field(None, description="when it begins; default: when all is built")
    after: AnchorText | None = Field(None, description="the event that it begins after")
    bearing: t.Angle = default("0 deg", "direction of the first acceleration: 0 deg = +x, 90 deg = +y")
    acceleration: t.ShakeAcceleration | None = Field(None, description="peak acceleration of a sine")
    amplitude: t.PositiveLength | None = Field(
        None, description="amplitude of a sine; give either this or the acceleration"
    )
    frequency: t.ShakeFrequency | None = Field(None, description="frequency of the sine")
    for_: t.PositiveDuration | None = Field(None, alias="for", description="duration of the sine")
    table: Table | None = Field(
        None, description="rows of [time, acceleration] along the bearing, linear between; one time twice is a jump"
    )

    one_of: ClassVar[tuple[str, ...]] = ("acceleration", "amplitude", "table")
    of_a_sine: ClassVar[tuple[str, ...]] = ("frequency", "for_")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        written = [key for key in self.of_a_sine if getattr(self, key) is not None]
        if self.table is not None:
            if written:
                message = f"`{self._spelling(written[0])}` goes with a sine, and this shake has a table"
                raise MistakeError("SD108", message, "remove one of them")
        elif len(written) < len(self.of_a_sine):
            missing = next(key for key in self.of_a_sine if key not in written)
            example = {"frequency": "frequency: 2 Hz", "for_": "for: 2 s"}[missing]
            raise MistakeError("SD102", f"`{self._spelling(missing)}` is missing", f"add such as {example}")
        elif self._most > t.MOST_SHAKEN:
            message = (
                f"the ground would accelerate by up to {self._most:.4g} m/s2, and {t.MOST_SHAKEN:g} m/s2 is the most"
            )
            raise MistakeError("SD104", message, "write a lower amplitude or frequency")
        return self

    @property
    def _most(self) -> float:
        """Return the peak acceleration of a sine [m/s2]."""
        return self.acceleration or (self.amplitude or 0.0) * (2.0 * pi * (self.frequency or 0.0)) ** 2

    @property
    def course(self) -> Course:
        """Return the acceleration along the bearing over time."""
        if self.table is None:
            return SineCourse(self._most, self.frequency or 0.0, self.for_ or 0.0)
        start = self.table[0][0]
        return TabulatedCourse(tuple((time - start, acceleration) for time, acceleration in self.table))

    @property
    def delay(self) -> float:
        """Return the time from its beginning until the ground first moves [s]."""
        return self.table[0][0] if self.table is not None else 0.0


# Models of a scenario.
#
# The classes here do not depend on the registered layouts, claims and impacts; `models` adds a key for each of these.


# --- the world --------------------------------------------------------------------------------------------------------


class Ground(AuthorModel):
    """The level ground."""

    friction: t.Friction | None = Field(None, description="friction of a brick on the ground; default: the scenario's")


class Wall(AuthorModel):
    """A vertical wall that faces the origin."""

    bearing: t.Angle = Field(description="direction of the wall from the origin: 0 deg = +x, 90 deg = +y")
    distance: t.NonNegativeLength = Field(description="distance of the wall from the origin")
    friction: t.Friction | None = Field(None, description="friction of a brick on the wall; default: the scenario's")


class Tilt(Shorthand):
    """Tilt of the whole scene."""

    angle: t.Slope = Field(description="angle between the ground and the horizontal")
    towards: t.Angle = default("0 deg", "downhill direction: 0 deg = +x, 90 deg = +y")

    scalar_key: ClassVar[str] = "angle"


class World(AuthorModel):
    """Ground, walls, gravity and friction."""

    gravity: t.Acceleration = default("9.81 m/s2", "acceleration of free fall")
    ground: Ground = Field(default_factory=Ground, description="the level ground")
    walls: Annotated[tuple[Wall, ...], Field(max_length=16)] = Field((), description="vertical walls")
    tilt: Tilt = default("0 deg", "tilt of the whole scene")
    shake: Shake | None = Field(None, description="shaking of the ground")
    friction: Frictions = Field(default_factory=Frictions, description="friction of particular pairs of bodies")
    touching: t.Touching | None = Field(
        None, description="which gaps statics count as contact; default: up to 2 % of the smallest side"
    )


# --- the steps of building --------------------------------------------------------------------------------------------

UNTIL_COLLAPSE: Final = 100  # levels, or bricks; unstable stacks of planks fall long before


class BuildStep(Timed):
    """One step of building: one layout, or bricks one by one."""

    bricks: Annotated[tuple[PlacedBrick, ...], Field(min_length=1, max_length=MAX_BRICKS)] | None = Field(
        None, description="bricks in any pose, one by one"
    )
    imported: Import | None = Field(None, alias="import", description="the boxes in a file of another program")
    name: t.BrickName | None = Field(None, description="prefix of the names of the bricks of this step")
    brick: BrickKind | None = Field(None, description="the brick of this step; default: the scenario's brick")
    every: t.PositiveDuration | None = Field(None, description="time for each brick; default: all at one time")
    until: Literal["collapse"] | None = Field(None, description="the step goes on until the structure falls")
    place: ByHand | None = Field(
        None, description="by hand, one brick after another; default: each brick appears in its place"
    )

    jitter: HandErrors | None = Field(None, description="placement errors of its bricks, in `samples`; default: none")

    @property
    def layout(self) -> tuple[str, LayoutParams] | None:
        """Return name and parameters of the layout; None for bricks that are listed or imported."""
        return None if self.kind in {"bricks", "imported"} else (self.kind, getattr(self, self.kind))

    @model_validator(mode="before")
    @classmethod
    def _fill_in_count(cls, written: object) -> object:
        """Fill in the largest number of levels or bricks for `until: collapse`."""
        if not isinstance(written, dict) or "until" not in written:
            return written
        layouts = {name: written[name] for name in LAYOUTS if isinstance(written.get(name), dict)}
        return written | {name: {LAYOUTS[name].params.count: UNTIL_COLLAPSE} | layouts[name] for name in layouts}

    @model_validator(mode="after")
    def _check_until_collapse(self) -> Self:
        if self.until is None:
            return self
        if self.layout is None:
            message = "`until: collapse` needs a layout, and this step has none"
            raise MistakeError("SD108", message, "write a layout")
        if self.every is None and self.place is None:
            message = "`until: collapse` needs `every`, to add one brick after another"
            raise MistakeError("SD102", message, "add such as every: 1 s")
        return self

    @model_validator(mode="after")
    def _place_or_drop(self) -> Self:
        if self.place is not None and any(brick.drop for brick in self.bricks or ()):
            message = "`place` releases a brick in its place, and `drop` in the air"
            raise MistakeError("SD108", message, "remove one of them, or write two steps")
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> t.JsonSchema:
        schema = super().__get_pydantic_json_schema__(core, handler)
        counts = {name: {"required": [layout.params.count]} for name, layout in LAYOUTS.items()}
        handler.resolve_ref_schema(schema).update(
            {"if": {"not": {"required": ["until"]}}, "then": {"properties": counts}}
        )
        return schema


# --- the scenario -----------------------------------------------------------------------------------------------------

_NAMED: Final[t.JsonSchema] = {
    "type": "object",
    "properties": {"file": t.FILE, "scenario": {"type": "string", "description": "its name; default: the only one"}},
    "additionalProperties": False,
}
_BASE = WithJsonSchema({"anyOf": [t.FILE, _NAMED]})  # `includes` merges the base before validation
_CHOSEN = WithJsonSchema({"type": "array", "items": {"type": "object", "additionalProperties": t.VALUE}, "minItems": 1})


class Scenario(AuthorModel):
    """A structure to build, and the expected outcome."""

    scenario: t.Slug = Field(description="name of the scenario and of its files")
    extends: Annotated[object, _BASE] = Field(
        None, description="a scenario in another file or in this one; its keys apply where this scenario has none"
    )
    description: t.Text | None = Field(None, description="what it shows, in a sentence")
    tags: Annotated[tuple[t.Slug, ...], Field(max_length=32)] = Field((), description="words to select scenarios by")
    brick_types: BrickTypes = Field({}, description="names for kinds of bricks, for use wherever a brick is expected")
    brick: BrickKind = default("kapla", "the brick of the structure")
    friction: t.Friction = Field(0.5, description="Coulomb coefficient of brick on brick")
    world: World = Field(default_factory=World, description="gravity, ground, walls, tilt, shaking")
    # Validated by `variants.expand`, which also fills them in.
    let: Annotated[object, t.variables_schema(t.VALUE)] = Field(
        None, description="variables for ${...}: numbers, quantities, words, and expressions of variables above"
    )
    uncertain: Annotated[object, t.variables_schema(t.SPREADS)] = Field(
        None, description="random variables, with a value for each of the `samples`: ranges or distributions"
    )
    matrix: Annotated[object, t.variables_schema(t.VALUES)] = Field(
        None, description="variables with several values: a variant of the scenario for each combination"
    )
    cases: Annotated[object, _CHOSEN] = Field(
        None, description="sets of values, a variant for each; the first value names the variant"
    )
    exclude: Annotated[object, _CHOSEN] = Field(None, description="combinations without a variant")
    build: Annotated[tuple[BuildStep, ...], Field(min_length=1, max_length=1000)] = Field(
        description="steps of building, in order"
    )
    impacts: Annotated[tuple[Impact, ...], Field(max_length=1000)] = Field(
        (), description="actions on the structure: hits, pushes, bricks pulled out"
    )
    samples: t.Samples | None = Field(
        None, description="largest number of random samples that are judged; claims give the share in which they hold"
    )
    seed: t.Seed = Field(1, description="seed of the random samples")
    confidence: t.Confidence = default("95 %", "confidence with which a share is judged to hold or to fail")
    watch: t.PositiveDuration | None = Field(
        None, description="longest simulated time after the last action, and of a collapse"
    )
    skip: Skip | None = Field(None, description="why it is not run")
    xfail: Xfail | None = Field(None, description="why it is expected to fail")
    systems: t.Systems = Field(("exact",), description="the systems that simulate the scenario")
    expect: Annotated[tuple[Expectation, ...], Field(max_length=1000)] = Field((), description="the expected outcome")
    truth: Annotated[tuple[Truth, ...], Field(max_length=1000)] = Field(
        (), description="the outcome known from another source, such as an experiment"
    )


# --- with all kinds ---------------------------------------------------------------------------------------------------


class Models(NamedTuple):
    """The models of a file, with a key for each registered layout, claim and impact."""

    BuildStep: type[BuildStep]
    Impact: type[Impact]
    Expectation: type[Expectation]
    Truth: type[Truth]
    Scenario: type[Scenario]


def models() -> Models:
    """Return the models for the kinds that are registered now."""
    return _models_of(tuple(LAYOUTS.items()), tuple(CLAIMS.items()), tuple(IMPACTS.items()))


class _ByName:
    """Lets pickle find a generated model, which is in no module: `MADE.Scenario`."""

    def __getattr__(self, name: str) -> type[AuthorModel]:
        made: type[AuthorModel] = getattr(models(), name)
        return made


MADE: Final = _ByName()


@cache
def _models_of(
    layouts: tuple[tuple[str, Layout], ...],
    claims: tuple[tuple[str, KindOfClaim], ...],
    impacts: tuple[tuple[str, KindOfImpact], ...],
) -> Models:
    step = with_kinds(BuildStep, {key: (kind.params, kind.summary) for key, kind in layouts}, "bricks", "imported")
    impact = with_kinds(Impact, {key: (kind.model, kind.summary) for key, kind in impacts})
    claim = with_kinds(Claim, {key: (kind.model, kind.summary) for key, kind in claims})
    # Pydantic puts the fields of the second base first.
    expectation = _made("Expectation", Expectation, claim)
    truth = _made("Truth", Truth, claim)
    lists = {"build": step, "impacts": impact, "expect": expectation, "truth": truth}
    fields = {key: (tuple[item, ...], copy(Scenario.model_fields[key])) for key, item in lists.items()}  # type: ignore[valid-type]  # made while running
    scenario = _made("Scenario", Scenario, **fields)
    made = Models(step, impact, expectation, truth, scenario)
    for name, model in made._asdict().items():
        model.__module__, model.__qualname__ = __name__, f"MADE.{name}"  # for pickle
    return made


def _made(name: str, *bases: type[AuthorModel], **fields: object) -> type[Any]:
    return create_model(name, __base__=bases, __doc__=bases[0].__doc__, __module__=__name__, **fields)  # type: ignore[call-overload, no-any-return]  # likewise
