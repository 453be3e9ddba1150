"""The pydantic models of one scenario, with the description of every key."""

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

from stability.dynamics.ground_motion import Course, Recorded, Sine
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

# What an author may say of how bricks rub on each other, beside the one coefficient that most scenarios have.


MAX_PAIRS: Final = 1000

RubbingName = Annotated[str, t.TYPE_NAME]


class PairOfBodies(AuthorModel):
    """Two bodies, or kinds of bricks, and how they rub on each other."""

    pair: tuple[RubbingName, RubbingName] = Field(
        description="two kinds of brick, or bricks, the ground, walls by name; one kind twice for two of its bricks"
    )
    friction: t.Friction = Field(description="Coulomb coefficient of the one on the other")


class Frictions(AuthorModel):
    """What two surfaces have on each other."""

    rule: Literal["lower", "higher", "mean", "geometric"] = Field(
        "lower", description="what two bodies have on each other, of the friction that each has"
    )
    between: Annotated[tuple[PairOfBodies, ...], Field(max_length=MAX_PAIRS)] = Field(
        (), description="what certain pairs have, whatever each has by itself"
    )


# Scenarios that are not played, or that are known to come out wrong, each with the reason.


Package = Literal["mujoco", "sapien"]  # that formats are read with, and engines are of


def _in_one_line(text: str) -> str:
    return " ".join(text.split())


class Mark(Shorthand):
    """Why, and on which systems."""

    reason: Annotated[t.Text, AfterValidator(_in_one_line)] = Field(description="why")
    system: Annotated[t.Systems, BeforeValidator(t.listed), WithJsonSchema(t.ONE_OR_MORE_SYSTEMS)] | None = Field(
        None, description="the system, or systems, that this is said of; default: all"
    )

    scalar_key: ClassVar[str] = "reason"

    def is_of(self, system: str) -> bool:
        """Whether it is said of a system."""
        return self.system is None or system in self.system


class Skip(Mark):
    """Not played."""

    without: Package | None = Field(None, description="played all the same wherever this Python package is installed")

    def is_of(self, system: str) -> bool:
        """Whether it is said of a system, here."""
        return Mark.is_of(self, system) and (self.without is None or not is_installed(self.without))


def is_installed(package: str) -> bool:
    """Whether a Python package can be imported here."""
    return find_spec(package) is not None


class Xfail(Mark):
    """Played, and known to fail its expectations: for now, and for a reason."""

    strict: t.Flag = Field(True, description="whether it fails the check that all expectations are met after all")


# How the ground is shaken: as a sine, or as a table says.


Row: TypeAlias = tuple[t.Duration, t.SignedAcceleration]


def _in_order(rows: Sequence[Row]) -> Sequence[Row]:
    for number, (before, after) in enumerate(pairwise(rows), start=2):
        if after[0] < before[0]:
            message = f"row {number} of the table is of {after[0]:g} s, and the one before it of {before[0]:g} s"
            raise MistakeError("SD104", message, "write the rows in order of time; twice the same time is a jump")
    if rows[-1][0] == rows[0][0]:
        raise MistakeError("SD104", "the table takes no time", "write a later row")
    return rows


Table = Annotated[tuple[Row, ...], Field(min_length=2, max_length=100_000), AfterValidator(_in_order)]


class Shake(Timed):
    """The ground moves to and fro, level, along one line."""

    at: t.Duration | None = Field(None, description="when it begins; default: when all is built")
    after: AnchorText | None = Field(None, description="the event that it begins after")
    bearing: t.Angle = default("0 deg", "which way it accelerates first: 0 deg = +x, 90 deg = +y")
    acceleration: t.ShakeAcceleration | None = Field(None, description="the most, of a sine")
    amplitude: t.PositiveLength | None = Field(None, description="to either side, of a sine; or else its acceleration")
    frequency: t.ShakeFrequency | None = Field(None, description="of the sine")
    for_: t.PositiveDuration | None = Field(None, alias="for", description="how long the sine goes on")
    table: Table | None = Field(
        None, description="rows of [time, acceleration] along the bearing, straight between; one time twice is a jump"
    )

    one_of: ClassVar[tuple[str, ...]] = ("acceleration", "amplitude", "table")
    of_a_sine: ClassVar[tuple[str, ...]] = ("frequency", "for_")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        written = [key for key in self.of_a_sine if getattr(self, key) is not None]
        if self.table is not None:
            if written:
                message = f"a table says all, and there is no sine to have a `{self._spelling(written[0])}`"
                raise MistakeError("SD108", message, "leave it out, or the table")
        elif len(written) < len(self.of_a_sine):
            missing = next(key for key in self.of_a_sine if key not in written)
            example = {"frequency": "frequency: 2 Hz", "for_": "for: 2 s"}[missing]
            raise MistakeError("SD102", f"`{self._spelling(missing)}` is missing", f"add such as {example}")
        elif self._most > t.MOST_SHAKEN:
            message = (
                f"the ground would accelerate by up to {self._most:.4g} m/s2, and {t.MOST_SHAKEN:g} m/s2 is the most"
            )
            raise MistakeError("SD104", message, "write a lesser amplitude or frequency")
        return self

    @property
    def _most(self) -> float:
        """Of a sine [m/s2]."""
        return self.acceleration or (self.amplitude or 0.0) * (2.0 * pi * (self.frequency or 0.0)) ** 2

    @property
    def course(self) -> Course:
        """The acceleration along the bearing."""
        if self.table is None:
            return Sine(self._most, self.frequency or 0.0, self.for_ or 0.0)
        start = self.table[0][0]
        return Recorded(tuple((time - start, acceleration) for time, acceleration in self.table))

    @property
    def delay(self) -> float:
        """From when it begins until the ground first moves [s]."""
        return self.table[0][0] if self.table is not None else 0.0


# What an author may write: the models of one scenario, and the description of every key.
#
# The classes here are what is known of a scenario whatever kinds of layouts, claims and impacts there are; `models`
# adds a key for each kind.


# --- given: the world -------------------------------------------------------------------------------------------------


class Ground(AuthorModel):
    """The level ground."""

    friction: t.Friction | None = Field(None, description="of a brick on the ground; default: the scenario's")


class Wall(AuthorModel):
    """A vertical wall that faces the origin."""

    bearing: t.Angle = Field(description="where the wall is, seen from the origin: 0 deg = +x, 90 deg = +y")
    distance: t.NonNegativeLength = Field(description="from the origin to the wall")
    friction: t.Friction | None = Field(None, description="of a brick on the wall; default: the scenario's")


class Tilt(Shorthand):
    """How far the whole scene is tilted."""

    angle: t.Slope = Field(description="between the ground and the horizontal")
    towards: t.Angle = default("0 deg", "bearing of downhill: 0 deg = +x, 90 deg = +y")

    scalar_key: ClassVar[str] = "angle"


class World(AuthorModel):
    """What bricks stand on, and what pulls at them."""

    gravity: t.Acceleration = default("9.81 m/s2", "acceleration of free fall")
    ground: Ground = Field(default_factory=Ground, description="the level ground")
    walls: Annotated[tuple[Wall, ...], Field(max_length=16)] = Field((), description="vertical walls")
    tilt: Tilt = default("0 deg", "how far the whole scene is tilted")
    shake: Shake | None = Field(None, description="how the ground moves to and fro")
    friction: Frictions = Field(default_factory=Frictions, description="where some bodies rub otherwise than most")
    touching: t.Touching | None = Field(
        None, description="which gaps statics count as contact; default: up to 2 % of the smallest side"
    )


# --- when: the steps of building --------------------------------------------------------------------------------------

UNTIL_COLLAPSE: Final = 100  # levels, or bricks; plank stacks that are made to fall do so long before


class BuildStep(Timed):
    """One step of building: one layout, or bricks one by one."""

    bricks: Annotated[tuple[PlacedBrick, ...], Field(min_length=1, max_length=MAX_BRICKS)] | None = Field(
        None, description="bricks in any pose, one by one"
    )
    imported: Import | None = Field(None, alias="import", description="the boxes of a file that another program wrote")
    name: t.BrickName | None = Field(None, description="goes before the names of the bricks of this step")
    brick: BrickKind | None = Field(None, description="what this step is built of; default: the scenario's brick")
    every: t.PositiveDuration | None = Field(None, description="time for each brick; default: all at one time")
    until: Literal["collapse"] | None = Field(None, description="goes on until the structure falls")
    place: ByHand | None = Field(
        None, description="by hand, one brick after another; default: set down as if from nowhere"
    )

    jitter: HandErrors | None = Field(
        None, description="how far off its bricks are set down, in `samples`; default: not at all"
    )

    @property
    def layout(self) -> tuple[str, LayoutParams] | None:
        """Name and parameters of the layout, unless the step lists its bricks."""
        return None if self.kind in {"bricks", "imported"} else (self.kind, getattr(self, self.kind))

    @model_validator(mode="before")
    @classmethod
    def _go_on(cls, written: object) -> object:
        """Fill in how much is built at most, where that is left to the collapse."""
        if not isinstance(written, dict) or "until" not in written:
            return written
        layouts = {name: written[name] for name in LAYOUTS if isinstance(written.get(name), dict)}
        return written | {name: {LAYOUTS[name].params.count: UNTIL_COLLAPSE} | layouts[name] for name in layouts}

    @model_validator(mode="after")
    def _fall_on_the_way(self) -> Self:
        if self.until is None:
            return self
        if self.layout is None:
            raise MistakeError("SD108", "`until: collapse` goes on with a layout, and this step has none", "write one")
        if self.every is None and self.place is None:
            message = "`until: collapse` needs `every`: all at once, nothing is left to add when it falls"
            raise MistakeError("SD102", message, "add such as every: 1 s")
        return self

    @model_validator(mode="after")
    def _let_go_in_one_way(self) -> Self:
        if self.place is not None and any(brick.drop for brick in self.bricks or ()):
            message = "a hand lets a brick go in its place, and `drop` in the air"
            raise MistakeError("SD108", message, "leave out one of them, or take two steps")
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> t.JsonSchema:
        schema = super().__get_pydantic_json_schema__(core, handler)
        counts = {name: {"required": [layout.params.count]} for name, layout in LAYOUTS.items()}
        handler.resolve_ref_schema(schema).update(
            {"if": {"not": {"required": ["until"]}}, "then": {"properties": counts}}
        )
        return schema


# --- the whole --------------------------------------------------------------------------------------------------------

_NAMED: Final[t.JsonSchema] = {
    "type": "object",
    "properties": {"file": t.FILE, "scenario": {"type": "string", "description": "its name; default: the only one"}},
    "additionalProperties": False,
}
_BASE = WithJsonSchema({"anyOf": [t.FILE, _NAMED]})  # what it says is taken over by `composing`
_CHOSEN = WithJsonSchema({"type": "array", "items": {"type": "object", "additionalProperties": t.VALUE}, "minItems": 1})


class Scenario(AuthorModel):
    """What is built, and what must come of it."""

    scenario: t.Slug = Field(description="its name, and that of its files")
    extends: Annotated[object, _BASE] = Field(
        None, description="a scenario, in another file or in this one, whose keys hold for all that is not said here"
    )
    description: t.Text | None = Field(None, description="what it shows, in a sentence")
    tags: Annotated[tuple[t.Slug, ...], Field(max_length=32)] = Field((), description="words to select scenarios by")
    brick_types: BrickTypes = Field({}, description="names for bricks, to be written wherever a brick is asked for")
    brick: BrickKind = default("kapla", "what is built with")
    friction: t.Friction = Field(0.5, description="Coulomb coefficient of brick on brick")
    world: World = Field(default_factory=World, description="gravity, ground, walls, tilt, shaking")
    # Judged by `variants.expand`, which has filled them in before.
    let: Annotated[object, t.variables_schema(t.VALUE)] = Field(
        None, description="variables for ${...}, each of numbers, quantities, words, and variables above it"
    )
    uncertain: Annotated[object, t.variables_schema(t.SPREADS)] = Field(
        None, description="variables of which each of the `samples` has another value: ranges, or distributions"
    )
    matrix: Annotated[object, t.variables_schema(t.VALUES)] = Field(
        None, description="variables with several values: a variant of the scenario for each combination"
    )
    cases: Annotated[object, _CHOSEN] = Field(
        None, description="variables whose values belong together: a variant for each, called by the first of them"
    )
    exclude: Annotated[object, _CHOSEN] = Field(None, description="combinations that are left out")
    build: Annotated[tuple[BuildStep, ...], Field(min_length=1, max_length=1000)] = Field(
        description="what is built, step by step"
    )
    impacts: Annotated[tuple[Impact, ...], Field(max_length=1000)] = Field((), description="what is done to it")
    samples: t.Samples | None = Field(
        None,
        description="how many samples of what is uncertain are judged at most; claims say in which share they hold",
    )
    seed: t.Seed = Field(1, description="of the samples: another one draws others")
    confidence: t.Confidence = default("95 %", "how sure one is to be of a share that is found to hold or to fail")
    watch: t.PositiveDuration | None = Field(
        None, description="how long it is watched after the last action, and a collapse is followed, at most"
    )
    skip: Skip | None = Field(None, description="why it is not played")
    xfail: Xfail | None = Field(None, description="why it is known to fail its expectations")
    systems: t.Systems = Field(("exact",), description="what the scenario is played on")
    expect: Annotated[tuple[Expectation, ...], Field(max_length=1000)] = Field((), description="what must come of it")
    truth: Annotated[tuple[Truth, ...], Field(max_length=1000)] = Field((), description="what is known from outside")


# --- with all kinds ---------------------------------------------------------------------------------------------------


class Models(NamedTuple):
    """The models that are read from a file, with a key for each kind of layout, claim and impact."""

    BuildStep: type[BuildStep]
    Impact: type[Impact]
    Expectation: type[Expectation]
    Truth: type[Truth]
    Scenario: type[Scenario]


def models() -> Models:
    """The models for the kinds that are registered by now."""
    return _models_of(tuple(LAYOUTS.items()), tuple(CLAIMS.items()), tuple(IMPACTS.items()))


class _ByName:
    """Where pickle finds a model, which no module holds: `MADE.Scenario`."""

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
    # Of two bases, the fields of the second come first.
    expectation = _made("Expectation", Expectation, claim)
    truth = _made("Truth", Truth, claim)
    lists = {"build": step, "impacts": impact, "expect": expectation, "truth": truth}
    fields = {key: (tuple[item, ...], copy(Scenario.model_fields[key])) for key, item in lists.items()}  # type: ignore[valid-type]  # made while running
    scenario = _made("Scenario", Scenario, **fields)
    made = Models(step, impact, expectation, truth, scenario)
    for name, model in made._asdict().items():
        model.__module__, model.__qualname__ = __name__, f"MADE.{name}"  # where pickle asks for it
    return made


def _made(name: str, *bases: type[AuthorModel], **fields: object) -> type[Any]:
    return create_model(name, __base__=bases, __doc__=bases[0].__doc__, __module__=__name__, **fields)  # type: ignore[call-overload, no-any-return]  # likewise
