"""The intensity of a fragility curve, and the capacity of each sample."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
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
from stackdsl.language.quantities import InputError, in_si, quantity_text
from stackdsl.language.variants import Variant, variables_of
from stackdsl.language.yaml.source import Plain
from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.sample_outcomes import SampleOutcome, sample_outcomes_of
from stackdsl.sampling.samples import BuildPlan, Draws, Setting
from stackdsl.timeline import Jitter, Timeline

# The intensity axis of a fragility curve: friction, a constant acceleration, tilt, placement errors, or a variable.


class IntensityKind(StrEnum):
    """The kind of an intensity."""

    FRICTION = "friction"  # between bricks, unless a pair has its own
    ACCELERATION = "acceleration"  # constant and horizontal, after the build [g]
    TILT = "tilt"  # of the whole scene, after the build [rad]
    JITTER = "jitter"  # all placement errors, with one factor
    VARIABLE = "variable"


STEADY: Final = (IntensityKind.ACCELERATION, IntensityKind.TILT)  # kinds for which each sample has a capacity
UNITS: Final[Mapping[str, str]] = {"m": "mm", "rad": "deg", "kg": "g"}  # units of shown values
UPRIGHT: Final = 0.5 * pi


class NoIntensityError(Exception):
    """A scenario has no such intensity; the message has the remedy."""


@dataclass(frozen=True, slots=True)
class Intensity:
    """The intensity of a curve, in one scenario."""

    kind: IntensityKind
    name: str  # as requested
    unit: str  # of its values, in SI; empty for numbers
    written: float | None = None  # the value in the scenario; None if it has none

    @property
    def is_steady(self) -> bool:
        """True if the intensity is a constant acceleration or a tilt. Each sample has a capacity then."""
        return self.kind in STEADY

    @property
    def shown_unit(self) -> str:
        """The unit in which its values are shown."""
        return "g" if self.kind is IntensityKind.ACCELERATION else UNITS.get(self.unit, self.unit)

    def shown(self, value: float) -> float:
        """Return a value in the unit for display."""
        return value / float(in_si(self.shown_unit)) if self.unit else value

    def in_si(self, shown: float) -> float:
        """Return the value that is shown as a number."""
        return shown * float(in_si(self.shown_unit)) if self.unit else shown

    def told(self, value: float) -> str:
        """Return a value with its unit."""
        return f"{self.shown(value):.4g} {self.shown_unit}".rstrip()

    def setting(self, value: float) -> Setting:
        """Return the changes of the scenario for a value."""
        if self.kind is IntensityKind.JITTER:
            assert self.written is not None
            return Setting(errors=value / self.written)
        if self.is_steady:
            return Setting()
        number: Plain = quantity_text(Fraction(repr(value)), self.unit) if self.unit else value
        return Setting(fixed={self.name: number})

    def of_acceleration(self, value: float) -> float:
        """Return the intensity of an acceleration [g]."""
        return atan(value) if self.kind is IntensityKind.TILT else value

    def acceleration(self, value: float) -> float:
        """Return the acceleration [g] of an intensity."""
        if self.kind is not IntensityKind.TILT:
            return value
        return tan(value) if value < UPRIGHT else float("inf")


def intensity_of(name: str, variant: Variant, timeline: Timeline) -> Intensity:
    """Return the intensity of a name; a variable of the scenario has priority. Raises NoIntensityError."""
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
    raise NoIntensityError(f"unknown variable '{name}'; {did_you_mean(name, known)}")


def _of_variable(name: str, variant: Variant) -> Intensity:
    rows = (variant.values.get("let"), variant.choice, variant.written.values.get("uncertain"))
    written = next(row[name] for row in rows if isinstance(row, Mapping) and name in row)
    try:
        amount = constant(written)
    except InputError:
        try:
            amount = constant(distribution(written).middle)
        except InputError:
            raise NoIntensityError(f"the variable '{name}' is {written!r}, not a number or quantity") from None
    return Intensity(IntensityKind.VARIABLE, name, unit_text(amount), float(amount.magnitude))


def _of_jitter(timeline: Timeline) -> Intensity:
    """Return the jitter, measured by the largest error of position, or else of yaw."""
    for key, unit in (("position", "m"), ("yaw", "rad")):
        spreads = [getattr(each, key) for each in timeline.jitter.values()]
        if widths := [spread.width for spread in spreads if spread is not None]:
            return Intensity(IntensityKind.JITTER, IntensityKind.JITTER.value, unit, max(widths))
    raise NoIntensityError("no step of the build has a `jitter`; add jitter: {position: 1 mm, yaw: 1 deg} to one")


def jitter_text(jitters: Iterable[Jitter]) -> str:
    """Return the placement errors of a scenario, such as `position normal 3 mm, yaw normal 1 deg`."""
    texts = []
    for jitter in jitters:
        spreads = (("position", jitter.position, "m"), ("yaw", jitter.yaw, "rad"))
        texts.append(
            ", ".join(
                f"{key} {spread.kind} {spread.width / float(in_si(UNITS[unit])):.6g} {UNITS[unit]}"
                for key, spread, unit in spreads
                if spread is not None
            )
        )
    return " or ".join(dict.fromkeys(filter(None, texts)))


# Capacity: the constant horizontal acceleration that a sample survives once it is built, computed by statics.


ACCURACY = 1e-4  # relative accuracy of a capacity in the worst direction
UNKNOWN = (0.0, inf)
SOLVED = "margin of the sample"  # the kind of proof of samples that stand


@dataclass(frozen=True, slots=True)
class Capacity:
    """The acceleration that one sample survives."""

    outcome: int  # outcome of the build, see `SampleOutcome`
    survived: float = 0.0  # acceleration that is proven to be survived [g]
    fails: float = inf  # acceleration that is proven to bring bricks down [g]; inf if none is


def capacities_of(design: BuildPlan, draws: Draws, bearing: float | None) -> tuple[list[Capacity], Counter[str]]:
    """Return the capacities of a batch of samples, and the number of samples by kind of proof.

    A capacity is that along the bearing of the pull [rad], or in the worst direction if `bearing` is None.
    """
    outcomes, ways = sample_outcomes_of(design, draws), Counter[str]()
    hands = PlacementSampler(design, draws).build()
    capacities = []
    for sample, (outcome, way) in enumerate(zip(outcomes.values.tolist(), outcomes.ways, strict=True)):
        if outcome == SampleOutcome.STANDS:
            capacities.append(Capacity(outcome, *_margin(design, hands.placed(sample), bearing)))
            ways[SOLVED] += 1
        else:
            capacities.append(Capacity(outcome, 0.0, 0.0 if outcome > 0 else inf))
            ways.update([str(way)] if way is not None else [])
    return capacities, ways


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
