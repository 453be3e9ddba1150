"""The intensity of a fragility curve, and the capacity of each sample."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from math import atan, inf, pi, tan
from typing import Final

from stability.analysis.acceleration_margin import acceleration
from stability.analysis.bearings import along_bearing
from stability.contact_law import as_friction
from stability.problem import Placed, Stability
from stackdsl.diagnostics import did_you_mean
from stackdsl.language.distributions import distribution
from stackdsl.language.expressions import constant, unit_text
from stackdsl.language.quantities import MistakeError, in_si, quantity_text
from stackdsl.language.variants import Variant, variables_of
from stackdsl.language.yaml.source import Plain
from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.sample_outcomes import SampleOutcome, sample_outcomes_of
from stackdsl.sampling.samples import BuildPlan, Draws, Setting
from stackdsl.timeline import Timeline

# What a fragility curve is over: friction, shaking, tilt, errors of hands, or a variable of the scenario.


class IntensityKind(StrEnum):
    """What an intensity is of."""

    FRICTION = "friction"  # of brick on brick, wherever nothing else is written
    ACCELERATION = "acceleration"  # of the ground, once all is built [g]
    TILT = "tilt"  # of the whole, once all is built [rad]
    JITTER = "jitter"  # the errors of hands, all multiplied alike
    VARIABLE = "variable"


SHAKING: Final = (IntensityKind.ACCELERATION, IntensityKind.TILT)  # at which each sample has a capacity of its own
UNITS: Final[Mapping[str, str]] = {"m": "mm", "rad": "deg", "kg": "g"}  # in which values are shown
UPRIGHT: Final = 0.5 * pi


class NoIntensityError(Exception):
    """A scenario has nothing of that kind; the message says what to do."""


@dataclass(frozen=True, slots=True)
class Intensity:
    """One of these, in one scenario."""

    kind: IntensityKind
    name: str  # as it was asked for
    unit: str  # of its values, in SI; empty for numbers
    written: float | None = None  # the value of the design; None of what a design has none of

    @property
    def shown_unit(self) -> str:
        """The unit in which its values are shown."""
        return "g" if self.kind is IntensityKind.ACCELERATION else UNITS.get(self.unit, self.unit)

    def shown(self, value: float) -> float:
        """A value in that unit."""
        return value / float(in_si(self.shown_unit)) if self.unit else value

    def told(self, value: float) -> str:
        """A value with its unit."""
        return f"{self.shown(value):.4g} {self.shown_unit}".rstrip()

    def setting(self, value: float) -> Setting:
        """What is otherwise at a value."""
        if self.kind is IntensityKind.JITTER:
            assert self.written is not None
            return Setting(errors=value / self.written)
        if self.kind in SHAKING:
            return Setting()
        number: Plain = quantity_text(Fraction(repr(value)), self.unit) if self.unit else value
        return Setting(fixed={self.name: number})

    def of_acceleration(self, value: float) -> float:
        """The intensity of an acceleration [g]."""
        return atan(value) if self.kind is IntensityKind.TILT else value

    def acceleration(self, value: float) -> float:
        """The acceleration [g] that an intensity is."""
        if self.kind is not IntensityKind.TILT:
            return value
        return tan(value) if value < UPRIGHT else float("inf")


def intensity_of(name: str, variant: Variant, timeline: Timeline) -> Intensity:
    """What is meant by a name; a variable of the scenario goes before what is called alike. Raises NoIntensityError."""
    names = variables_of(variant)
    if name in names:
        return _of_variable(name, variant)
    match name:
        case IntensityKind.FRICTION:
            return Intensity(IntensityKind.FRICTION, name, "", as_friction(timeline.world.friction).usual)
        case IntensityKind.ACCELERATION:
            return Intensity(IntensityKind.ACCELERATION, name, "")
        case IntensityKind.TILT:
            return Intensity(IntensityKind.TILT, name, "rad")
        case IntensityKind.JITTER:
            return _of_jitter(timeline)
    known = [*(kind.value for kind in IntensityKind if kind is not IntensityKind.VARIABLE), *names]
    raise NoIntensityError(f"there is no variable '{name}'; {did_you_mean(name, known)}")


def _of_variable(name: str, variant: Variant) -> Intensity:
    rows = (variant.values.get("let"), variant.choice, variant.written.values.get("uncertain"))
    written = next(row[name] for row in rows if isinstance(row, Mapping) and name in row)
    try:
        amount = constant(written)
    except MistakeError:
        try:
            amount = constant(distribution(written).middle)
        except MistakeError:
            raise NoIntensityError(f"the variable '{name}' is {written!r}, and no quantity") from None
    return Intensity(IntensityKind.VARIABLE, name, unit_text(amount), float(amount.magnitude))


def _of_jitter(timeline: Timeline) -> Intensity:
    """The largest error of position, or else of yaw, stands for all."""
    for key, unit in (("position", "m"), ("yaw", "rad")):
        spreads = [getattr(each, key) for each in timeline.jitter.values()]
        if widths := [spread.width for spread in spreads if spread is not None]:
            return Intensity(IntensityKind.JITTER, IntensityKind.JITTER.value, unit, max(widths))
    raise NoIntensityError("no step of the build has a `jitter`; say jitter: {position: 1 mm, yaw: 1 deg} in one")


# How much horizontal acceleration each sample survives once it is built: its capacity, which statics knows at once.


ACCURACY = 1e-4  # share of a capacity in the worst direction that may be unproven
UNKNOWN = (0.0, inf)
SOLVED = "its own margin"  # the way of samples that stand


@dataclass(frozen=True, slots=True)
class Capacity:
    """What one sample survives, and what it is proven not to."""

    fate: int  # of its building, see `SampleOutcome`
    survived: float = 0.0  # proven [g]
    fails: float = inf  # proven to bring something down [g]; inf if nothing is proven to


def capacities_of(design: BuildPlan, draws: Draws, bearing: float | None) -> tuple[list[Capacity], Counter[str]]:
    """The capacities of some samples, and how many each way decided.

    Along one bearing [rad], which bricks are pulled along, or in the worst direction of all.
    """
    fates, ways = sample_outcomes_of(design, draws), Counter[str]()
    hands = PlacementSampler(design, draws).build()
    found = []
    for sample, (fate, way) in enumerate(zip(fates.fates.tolist(), fates.ways, strict=True)):
        if fate == SampleOutcome.STANDS:
            found.append(Capacity(fate, *_margin(design, hands.placed(sample), bearing)))
            ways[SOLVED] += 1
        else:
            found.append(Capacity(fate, 0.0, 0.0 if fate > 0 else inf))
            ways.update([str(way)] if way is not None else [])
    return found, ways


def _margin(design: BuildPlan, placed: Sequence[Placed], bearing: float | None) -> tuple[float, float]:
    assembly = design.assembly()
    if assembly.add_all(placed, names_smallest=False).stability is not Stability.STABLE:
        return UNKNOWN
    problem = assembly.problem()
    margin = (
        acceleration(problem, ACCURACY, design.gravity)
        if bearing is None
        else along_bearing(problem, bearing, design.gravity)
    )
    return (margin.value, margin.upper) if margin is not None else UNKNOWN
