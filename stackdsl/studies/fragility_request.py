"""A request for a fragility curve, and its plan: intensity, range, samples."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from re import fullmatch
from typing import Final

from stackdsl.checking.cases import Case
from stackdsl.judging.proofs import RIGID, TIED
from stackdsl.language.expressions import constant, unit_text
from stackdsl.language.quantities import ACCELERATION, SIGNED, InputError, in_si, parse_quantity
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.systems import Method
from stackdsl.studies.fragility import FragilityPlan
from stackdsl.studies.fragility_curve import spaced
from stackdsl.studies.fragility_intensity import Intensity, IntensityKind, NoIntensityError, intensity_of

POINTS: Final = 11
MOST_POINTS: Final = 1000
USUAL: Final = 1000  # most samples at each point, unless they are requested
AROUND: Final = 4.0  # ratio of the ends of the default range to the value in the scenario
LEAST_CONFIDENCE, MOST_CONFIDENCE = 0.5, 0.999999


class FragilityRequestError(ValueError):
    """A scenario has no fragility curve as requested; the message has the remedy."""


class NotProvenError(FragilityRequestError):
    """The system of a case does not compute the intensities that samples survive."""


@dataclass(frozen=True, slots=True)
class FragilityRequest:
    """The options of a fragility curve."""

    over: str
    first: str | None = None
    last: str | None = None
    points: int = POINTS
    samples: int | None = None
    seed: int | None = None
    confidence: float | None = None
    bearing: float | None = None  # [rad]
    option: Callable[[str], str] = "--{}".format  # spells the name of an option in messages


def plan_of(case: Case, asked: FragilityRequest) -> FragilityPlan:
    """Return the plan of a curve of a sampled case. Raises FragilityRequestError."""
    try:
        intensity = intensity_of(asked.over, case.variant, case.timeline)
    except NoIntensityError as error:
        raise FragilityRequestError(f"{asked.option('over')} {asked.over}: {error}") from error
    if intensity.is_steady and system_named(case.system).method is not Method.PROVEN:
        raise NotProvenError(f"only statics computes survived intensities, '{case.system}' does not")
    if asked.bearing is not None and not intensity.is_steady:
        raise FragilityRequestError(f"{asked.option('bearing')} applies only to acceleration and tilt; remove it")
    if case.timeline.world.strengths:
        raise FragilityRequestError(RIGID)
    if case.timeline.world.ties:
        raise FragilityRequestError(TIED)
    written = case.scenario
    return FragilityPlan(
        case,
        intensity,
        _values(intensity, asked),
        asked.points,
        asked.samples or min(USUAL, written.samples or USUAL),
        written.seed if asked.seed is None else asked.seed,
        asked.confidence or written.confidence,
        asked.bearing,
    )


def _values(intensity: Intensity, asked: FragilityRequest) -> tuple[float, ...]:
    """Return the values of the points in SI; none if they follow from the survived capacities."""
    low, high = asked.option("from"), asked.option("to")
    ends = [_end(key, text, intensity) for key, text in ((low, asked.first), (high, asked.last))]
    if ends == [None, None] and intensity.is_steady:
        return ()
    written = intensity.written
    if intensity.is_steady and ends[0] is None:
        ends[0] = 0.0
    if None in ends and (written is None or written <= 0.0):
        where = f"{asked.option('over')} {asked.over}"
        raise FragilityRequestError(f"{where}: give {low} and {high}, since the file has no value above zero")
    assert written is not None or None not in ends
    first, last = (
        end if end is not None else (written or 0.0) * times
        for end, times in zip(ends, (1 / AROUND, AROUND), strict=True)
    )
    if first >= last:
        raise FragilityRequestError(f"{low} {asked.first or first} is not less than {high} {asked.last or last}")
    if intensity.kind is IntensityKind.JITTER and first <= 0.0:
        raise FragilityRequestError(f"{low}: jitter must be above zero; without errors, all samples are the same")
    return tuple(float(f"{value:.15g}") for value in spaced(first, last, asked.points))


def _end(key: str, text: str | None, intensity: Intensity) -> float | None:
    if text is None:
        return None
    try:
        if intensity.kind is IntensityKind.ACCELERATION:
            return _acceleration(text)
        amount = constant(text)
    except InputError as mistake:
        raise FragilityRequestError(f"{key}: {mistake.message}; {mistake.hint}") from mistake
    value = float(amount.magnitude)
    if unit_text(amount) != intensity.unit and value != 0.0:
        if not unit_text(amount):
            remedy = f"write, for example, '{text} {intensity.shown_unit}'"
            raise FragilityRequestError(f"{key}: {text} has no unit; {remedy}")
        wanted = f"a quantity in {intensity.unit}" if intensity.unit else "a number"
        raise FragilityRequestError(f"{key}: {text} has the wrong unit: {intensity.name} is {wanted}")
    if value < 0.0 and intensity.kind is not IntensityKind.VARIABLE:
        raise FragilityRequestError(f"{key}: {intensity.name} must not be negative")
    return value


def _acceleration(text: str) -> float:
    """Return an acceleration in g; a number without a unit is one in g. Raises InputError."""
    written = f"{text} g" if fullmatch(SIGNED, text := text.strip()) else text
    return parse_quantity(written, replace(ACCELERATION, positive=False)) / float(in_si("g0"))
