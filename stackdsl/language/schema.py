"""Pydantic models of a scenario, with a description of every key."""

from collections.abc import Mapping
from copy import copy
from functools import cache
from importlib.util import find_spec
from math import pi
from typing import Annotated, Any, ClassVar, Final, Literal, NamedTuple, Self, TypeAlias

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    PrivateAttr,
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
from stackdsl.language.joints import Joints, StudGrid
from stackdsl.language.layouts.registry import LAYOUTS, Layout, LayoutParams
from stackdsl.language.loads import Loads, in_order_of_time
from stackdsl.language.model_base import AnchorText, AuthorModel, Shorthand, Timed, default, with_kinds
from stackdsl.language.quantities import InputError
from stackdsl.language.records import Record, RecordFile, joined_courses
from stackdsl.language.supports import Supports
from stackdsl.language.ties import Ties
from stackdsl.language.value_types import MAX_BRICKS

# Friction of particular pairs, besides the one coefficient that most scenarios have.


MAX_PAIRS: Final = 1000

RubbingName = Annotated[str, t.TYPE_NAME]


class PairOfBodies(AuthorModel):
    """Friction between two bodies or kinds of bricks."""

    pair: tuple[RubbingName, RubbingName] = Field(
        description="two names of kinds of brick, bricks, the ground or walls; a kind may be named twice"
    )
    friction: t.Friction = Field(description="Coulomb friction coefficient of this pair")


class Frictions(AuthorModel):
    """Friction between bodies with different coefficients."""

    rule: Literal["lower", "higher", "mean", "geometric"] = Field(
        "lower", description="combination rule for the friction coefficients of two bodies"
    )
    between: Annotated[tuple[PairOfBodies, ...], Field(max_length=MAX_PAIRS)] = Field(
        (), description="friction coefficients of particular pairs, which override the rule"
    )


# Scenarios that are skipped or expected to fail, each with the reason.


Package = Literal["mujoco"]  # optional packages, for formats


def _in_one_line(text: str) -> str:
    return " ".join(text.split())


class Mark(Shorthand):
    """A reason, and the systems that it applies to."""

    reason: Annotated[t.Text, AfterValidator(_in_one_line)] = Field(description="reason, shown in reports")
    system: Annotated[t.Systems, BeforeValidator(t.listed), WithJsonSchema(t.ONE_OR_MORE_SYSTEMS)] | None = Field(
        None, description="system or systems to which this applies; default: all"
    )

    scalar_key: ClassVar[str] = "reason"

    def is_of(self, system: str) -> bool:
        """Return whether the mark applies to a system."""
        return self.system is None or system in self.system


class Skip(Mark):
    """A scenario that is not run."""

    without: Package | None = Field(
        None, description="Python package; the scenario is skipped only if it is not installed"
    )

    def is_of(self, system: str) -> bool:
        """Return whether the mark applies to a system in this environment."""
        return Mark.is_of(self, system) and (self.without is None or not is_installed(self.without))


def is_installed(package: str) -> bool:
    """Return whether a Python package can be imported."""
    return find_spec(package) is not None


class Xfail(Mark):
    """A scenario that is run and expected to fail."""

    strict: t.Flag = Field(True, description="whether the check fails if all expectations are met")


# Shaking of the ground: a sine, a pulse, a table, or a record from a file.


Row: TypeAlias = tuple[t.Duration, t.SignedAcceleration]


Table = Annotated[tuple[Row, ...], Field(min_length=2, max_length=100_000), AfterValidator(in_order_of_time)]


class Shake(Timed):
    """The ground moves to and fro, horizontally along one line unless a record has other components."""

    at: t.Duration | None = Field(
        None, description="time at which the shaking begins; default: when the structure is complete"
    )
    after: AnchorText | None = Field(None, description="event after which the shaking begins")
    bearing: t.Angle = default("0 deg", "direction of the first acceleration: 0 deg = +x, 90 deg = +y")
    acceleration: t.ShakeAcceleration | None = Field(None, description="peak acceleration of a sine or a pulse")
    amplitude: t.PositiveLength | None = Field(
        None, description="amplitude of a sine, as an alternative to `acceleration`"
    )
    frequency: t.ShakeFrequency | None = Field(None, description="frequency of the sine")
    for_: t.PositiveDuration | None = Field(None, alias="for", description="duration of the sine or the pulse")
    pulse: Literal["half-sine", "rectangle", "triangle"] | None = Field(
        None, description="shape of a single pulse, in place of a sine with its `frequency`"
    )
    table: Table | None = Field(
        None,
        description="rows [time, acceleration] along the bearing, linear in between; equal times define a step",
    )

    file: Annotated[Record, RecordFile("record.at2")] | None = Field(
        None,
        description="record of accelerations, AT2 or CSV: one along the bearing, or columns along, across and up",
    )
    across: Annotated[Record, RecordFile("record-90.at2")] | None = Field(
        None, description="record of the horizontal component at the bearing + 90 deg, beside `file`"
    )
    up: Annotated[Record, RecordFile("record-up.at2")] | None = Field(
        None, description="record of the vertical component, positive upwards, beside `file`"
    )
    scale: t.ScaleFactor = default(1, "factor of all accelerations of a record")
    _record: tuple[float, Mapping[str, tuple[tuple[float, float], ...]]] = PrivateAttr((0.0, {}))

    one_of: ClassVar[tuple[str, ...]] = ("acceleration", "amplitude", "table", "file")
    of_a_sine: ClassVar[tuple[str, ...]] = ("frequency", "for_")
    of_a_record: ClassVar[tuple[str, ...]] = ("across", "up", "scale")

    @model_validator(mode="after")
    def _read(self) -> Self:
        """Read the components of a record."""
        if self.file is None:
            written = [key for key in self.of_a_record if key in self.model_fields_set]
            if written:
                raise InputError("SD108", f"`{written[0]}` applies to a record, but this shake has no `file`", "add it")
            return self
        others = {name: record for name, record in (("across", self.across), ("up", self.up)) if record is not None}
        self._record = joined_courses(self.file, others, self.scale)
        most = max(abs(acceleration) for rows in self._record[1].values() for _, acceleration in rows)
        if most > t.MOST_SHAKEN:
            message = f"the peak acceleration of the record is {most:.4g} m/s2; the maximum is {t.MOST_SHAKEN:g} m/s2"
            raise InputError("SD104", message, "check the unit of the file, or reduce `scale`")
        return self

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.pulse is not None:
            return self._complete_pulse(self.pulse)
        written = [key for key in self.of_a_sine if getattr(self, key) is not None]
        if self.table is not None or self.file is not None:
            if written:
                has = "a table" if self.file is None else "a file"
                message = f"`{self._spelling(written[0])}` applies to a sine, but this shake has {has}"
                raise InputError("SD108", message, "remove one of them")
        elif len(written) < len(self.of_a_sine):
            examples = {"frequency": "frequency: 2 Hz", "for_": "for: 2 s"}
            missing = [key for key in self.of_a_sine if key not in written]
            names = " and ".join(f"`{self._spelling(key)}`" for key in missing)
            example = ", ".join(examples[key] for key in missing)
            hint = f"add, for example, `{example}`"
            if self.acceleration is not None:
                hint += "; a steady acceleration is `table: [[0 s, 0.5 g], [1 s, 0.5 g]]`, without `acceleration`"
            raise InputError("SD102", f"{names} {'are' if len(missing) > 1 else 'is'} missing", hint)
        elif self._most > t.MOST_SHAKEN:
            message = (
                f"the peak acceleration of the ground is {self._most:.4g} m/s2; the maximum is {t.MOST_SHAKEN:g} m/s2"
            )
            raise InputError("SD104", message, "reduce the acceleration, the amplitude or the frequency")
        return self

    def _complete_pulse(self, pulse: str) -> Self:
        if self.acceleration is None or self.frequency is not None:
            message = f"the pulse `{pulse}` has an `acceleration`, and no other course or frequency"
            raise InputError("SD108", message, f"write, for example, `pulse: {pulse}, acceleration: 0.5 g, for: 0.3 s`")
        if self.for_ is None:
            raise InputError("SD102", "`for`, the duration of the pulse, is missing", "add, for example, `for: 0.3 s`")
        if pulse == "half-sine" and 0.5 / self.for_ > t.FASTEST_SHAKEN:
            raise InputError("SD104", f"a half-sine of {self.for_:g} s is too short", "write at least 5 ms")
        return self

    @property
    def _most(self) -> float:
        """Return the peak acceleration of a sine [m/s2]."""
        return self.acceleration or (self.amplitude or 0.0) * (2.0 * pi * (self.frequency or 0.0)) ** 2

    @property
    def course(self) -> Course:
        """Return the acceleration along the bearing over time."""
        if self.file is not None:
            rows = self._record[1].get("along")
            # A record may have other components only; then the ground is at rest along the bearing.
            return TabulatedCourse(rows or ((0.0, 0.0), (1.0, 0.0)))
        if self.table is not None:
            start = self.table[0][0]
            return TabulatedCourse(tuple((time - start, acceleration) for time, acceleration in self.table))
        most, duration = self._most, self.for_ or 0.0
        match self.pulse:
            case "half-sine":
                return SineCourse(most, 0.5 / duration, duration)
            case "rectangle":
                return TabulatedCourse(((0.0, most), (duration, most)))
            case "triangle":
                return TabulatedCourse(((0.0, 0.0), (0.5 * duration, most), (duration, 0.0)))
        return SineCourse(most, self.frequency or 0.0, duration)

    @property
    def beside(self) -> Mapping[str, Course]:
        """Return the other components of a record, by their names `across` and `up`."""
        return {name: TabulatedCourse(rows) for name, rows in self._record[1].items() if name != "along"}

    @property
    def delay(self) -> float:
        """Return the time from its beginning until the ground first moves [s]."""
        return self._record[0] if self.table is None else self.table[0][0]


# Models of a scenario.
#
# The classes here do not depend on the registered layouts, claims and impacts; `models` adds a key for each of these.


# --- the world --------------------------------------------------------------------------------------------------------


PlateStuds = Annotated[int, Field(strict=True, ge=1, le=1000)]


class Ground(AuthorModel):
    """The level ground."""

    friction: t.Friction | None = Field(
        None, description="friction coefficient of the ground; default: that of the scenario"
    )
    studs: StudGrid | None = Field(
        None, description="studs of the ground, a base plate, which hold bricks with the same studs; default: none"
    )
    plate: tuple[PlateStuds, PlateStuds] | None = Field(
        None, description="size of the base plate along x and y in studs, from the origin; default: without end"
    )

    @model_validator(mode="after")
    def _plate_has_studs(self) -> Self:
        if self.plate is not None and self.studs is None:
            raise InputError("SD102", "`plate` is the size of a base plate, which needs `studs`", "add `studs: lego`")
        return self


class Wall(AuthorModel):
    """A vertical wall that faces the origin."""

    bearing: t.Angle = Field(description="direction of the wall from the origin: 0 deg = +x, 90 deg = +y")
    distance: t.NonNegativeLength = Field(description="distance of the wall from the origin")
    friction: t.Friction | None = Field(
        None, description="friction coefficient of the wall; default: that of the scenario"
    )


class Tilt(Shorthand):
    """Tilt of the whole scene."""

    angle: t.Slope = Field(description="angle between the ground and the horizontal")
    towards: t.Angle = default("0 deg", "downhill direction: 0 deg = +x, 90 deg = +y")

    scalar_key: ClassVar[str] = "angle"


class World(AuthorModel):
    """Ground, walls, gravity and friction."""

    gravity: t.Acceleration = default("9.81 m/s2", "acceleration of free fall")
    ground: Ground = Field(default_factory=Ground, description="the ground plane")
    walls: Annotated[tuple[Wall, ...], Field(max_length=16)] = Field((), description="vertical walls")
    tilt: Tilt = default("0 deg", "tilt of the whole scene")
    shake: Shake | None = Field(None, description="shaking of the ground")
    friction: Frictions = Field(
        default_factory=Frictions, description="friction between bodies with different coefficients"
    )
    touching: t.Touching | None = Field(
        None, description="largest gap that statics count as contact; default: 2 % of the smallest side"
    )


# --- the steps of building --------------------------------------------------------------------------------------------

UNTIL_COLLAPSE: Final = 100  # levels, or bricks; unstable stacks of planks fall long before


class BuildStep(Timed):
    """One step of building: a layout, single bricks, or imported boxes."""

    bricks: Annotated[tuple[PlacedBrick, ...], Field(min_length=1, max_length=MAX_BRICKS)] | None = Field(
        None, description="list of single bricks, each with its pose"
    )
    imported: Import | None = Field(None, alias="import", description="boxes from a file of another program")
    name: t.BrickName | None = Field(None, description="prefix of the names of the bricks of this step")
    brick: BrickKind | None = Field(None, description="kind of brick of this step; default: that of the scenario")
    every: t.LongInterval | None = Field(None, description="time between bricks; default: all at the same time")
    until: Literal["collapse"] | None = Field(
        None, description="`collapse` continues the step until the structure falls"
    )
    place: ByHand | None = Field(
        None, description="placement by hand, one brick after another; default: each brick appears in its place"
    )

    jitter: HandErrors | None = Field(
        None, description="placement errors of the bricks of this step in `samples`; default: none"
    )

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
            message = "`until: collapse` needs a layout, but this step has none"
            raise InputError("SD108", message, "replace the bricks by a layout")
        if self.every is None and self.place is None:
            message = "`until: collapse` needs `every`, to add one brick after another"
            raise InputError("SD102", message, "add, for example, `every: 1 s`")
        return self

    @model_validator(mode="after")
    def _place_or_drop(self) -> Self:
        if self.place is not None and any(brick.drop for brick in self.bricks or ()):
            message = (
                "`place` and `drop` exclude each other: `place` releases a brick on its support, `drop` in the air"
            )
            raise InputError("SD108", message, "remove one of them, or split the step")
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
    "properties": {
        "file": t.FILE,
        "scenario": {"type": "string", "description": "name of the scenario in that file; default: its only scenario"},
    },
    "additionalProperties": False,
}
_BASE = WithJsonSchema({"anyOf": [t.FILE, _NAMED]})  # `includes` merges the base before validation
_CHOSEN = WithJsonSchema({"type": "array", "items": {"type": "object", "additionalProperties": t.VALUE}, "minItems": 1})


class Scenario(AuthorModel):
    """A structure to build, and the expected outcome."""

    scenario: t.Slug = Field(description="name of the scenario and of its files")
    extends: Annotated[object, _BASE] = Field(
        None, description="base scenario, in this or another file, whose keys apply unless this scenario overrides them"
    )
    description: t.Text | None = Field(None, description="purpose of the scenario, in one sentence")
    tags: Annotated[tuple[t.Slug, ...], Field(max_length=32)] = Field(
        (), description="keywords for selecting scenarios"
    )
    brick_types: BrickTypes = Field(
        {}, description="named kinds of brick, for use wherever a kind of brick is expected"
    )
    brick: BrickKind = default("kapla", "kind of brick of the structure")
    friction: t.Friction = Field(0.5, description="Coulomb friction coefficient between bricks")
    joints: Joints = Field((), description="mortar, glue, magnets and studs; the first item about two bodies counts")
    world: World = Field(default_factory=World, description="gravity, ground, walls, tilt, shaking")
    # Validated by `variants.expand`, which also fills them in.
    let: Annotated[object, t.variables_schema(t.VALUE)] = Field(
        None, description="variables for ${...}: numbers, quantities, words, or expressions of the variables above"
    )
    uncertain: Annotated[object, t.variables_schema(t.SPREADS)] = Field(
        None, description="random variables, given as ranges or distributions; each of the `samples` draws new values"
    )
    matrix: Annotated[object, t.variables_schema(t.VALUES)] = Field(
        None, description="variables with lists of values; each combination is a variant of the scenario"
    )
    cases: Annotated[object, _CHOSEN] = Field(
        None, description="list of sets of values; each set is a variant, named by its first value"
    )
    exclude: Annotated[object, _CHOSEN] = Field(None, description="combinations of values that are left out")
    build: Annotated[tuple[BuildStep, ...], Field(min_length=1, max_length=1000)] = Field(
        description="steps of building, in order"
    )
    impacts: Annotated[tuple[Impact, ...], Field(max_length=1000)] = Field(
        (), description="actions on the structure, such as throws, pushes and removals"
    )
    loads: Loads = Field((), description="lasting forces, weights, pressures, wind and others on bricks")
    supports: Supports = Field((), description="movements of the ground below bricks, until the structure falls")
    ties: Ties = Field((), description="straps, bands and rods, which hold from the placement of their last brick on")
    samples: t.Samples | None = Field(
        None, description="maximum number of random samples; claims then state the share of samples in which they hold"
    )
    seed: t.Seed = Field(1, description="seed of the random samples")
    confidence: t.Confidence = default("95 %", "confidence level of the decision whether a share is met")
    watch: t.PositiveDuration | None = Field(
        None, description="maximum simulated time after the last action, and maximum duration of a collapse"
    )
    skip: Skip | None = Field(None, description="reason why the scenario is not run")
    xfail: Xfail | None = Field(None, description="reason why the scenario is expected to fail")
    systems: t.Systems = Field(("exact",), description="systems that simulate the scenario")
    expect: Annotated[tuple[Expectation, ...], Field(max_length=1000)] = Field(
        (), description="expected outcomes; the check fails if one is not met"
    )
    truth: Annotated[tuple[Truth, ...], Field(max_length=1000)] = Field(
        (), description="outcomes known from another source, such as an experiment; they are compared and reported only"
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
