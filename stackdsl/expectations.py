"""Trace -> outcomes: each expectation held against what happened, with the margin to its threshold.

One function a kind of claim, all with one signature. A margin is positive inside, negative outside, in the unit of what
was measured; where a claim has several parts, the part closest to failing speaks for it.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from math import degrees, inf, isnan

from stability.geometry import box_top
from stability.model import BodyId
from stackdsl.language.claims import Claim, Collapses, Displaced, Drift, Height, Margin, RestsOn, Stands
from stackdsl.language.schema import Scenario
from stackdsl.language.tolerances import Tolerance
from stackdsl.language.variants import Variant, repeated
from stackdsl.outcome import Outcome
from stackdsl.reading.source import Path, Plain, Source
from stackdsl.trace import COLLAPSE_SHARE_OF_SMALLEST_SIDE, COLLAPSE_TILT, BrickState, BrickTrack, Trace

MILLIMETRES = 1000.0
SHOWN_PER_SI = {"mm": MILLIMETRES, "deg": degrees(1.0)}  # by the unit of a margin


@dataclass(frozen=True, slots=True)
class Finding:
    """What was measured for one claim, or for one part of it."""

    measured: str
    margin: float
    unit: str
    passed: bool


def judge(trace: Trace, scenario: Scenario, variant: Variant, source: Source, system: str) -> tuple[Outcome, ...]:
    """The outcome of every expectation that speaks of this system, in the order of the file."""
    asked = [
        (("expect", number), claim)
        for number, claim in enumerate(scenario.expect)
        if claim.system is None or system in claim.system
    ]
    return _outcomes(asked, trace, variant, source)


def compare_with_truth(trace: Trace, scenario: Scenario, variant: Variant, source: Source) -> tuple[Outcome, ...]:
    """The same for the answers known from outside; what only statics can tell is passed over where none was asked."""
    asked = [
        (("truth", number), claim)
        for number, claim in enumerate(scenario.truth)
        if trace.statics is not None or not claim.needs_statics
    ]
    return _outcomes(asked, trace, variant, source)


def _outcomes(
    asked: Sequence[tuple[Path, Claim]], trace: Trace, variant: Variant, source: Source
) -> tuple[Outcome, ...]:
    return tuple(_outcome(path, claim, trace, variant, source) for path, claim in asked)


def _outcome(path: Path, claim: Claim, trace: Trace, variant: Variant, source: Source) -> Outcome:
    kind = claim.kind
    found = JUDGES[kind](getattr(claim, kind), trace)
    place = (*path, kind)
    expected = as_written(repeated(_at(source.values, place), _at(variant.values, place)))
    return Outcome(kind, expected, found.measured, found.margin, found.unit, found.passed, source.key_span_of(place))


def _at(values: Plain, path: Path) -> Plain:
    for step in path:
        values = values[step]  # type: ignore[index]  # the path of a claim that was validated
    return values


def as_written(value: Plain) -> str:
    """A value of the file on one line, without the brackets."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {as_written(part)}" for key, part in value.items())
    if isinstance(value, list):
        return " ".join(as_written(part) for part in value)
    return str(value)


# --- the claims -------------------------------------------------------------------------------------------------------


def _stands(claim: Stands, trace: Trace) -> Finding:
    named = frozenset(trace.tracks if claim.bricks is None else claim.bricks)
    meant = [
        track
        for name, track in _remaining(trace)
        if (claim.levels is None or track.level <= claim.levels) and name in named
    ]
    missing = [track for track in meant if track.state is BrickState.UNPLACED]
    levels = max((track.level for track in trace.tracks.values()), default=0)
    if claim.levels is not None and levels < claim.levels:
        return Finding(f"only {levels} levels are built", levels - claim.levels, "levels", passed=False)
    if missing:
        why = f"it fell at level {trace.collapse.level}; " if trace.collapse is not None else ""
        return Finding(f"{why}{len(missing)} of {len(meant)} never placed", -len(missing), "bricks", passed=False)
    unsettled = [track.brick.id for track in meant if track.state is BrickState.UNSETTLED]
    if unsettled:
        return Finding(f"{unsettled[0]} has not come to rest", -len(unsettled), "bricks", passed=False)
    if not meant:
        return Finding("all of it was pulled out", -1, "bricks", passed=False)
    if claim.for_ is not None:  # what falls later is no matter of this claim
        meant = [track for track in meant if track.left_at is None or track.left_at <= trace.last_action + claim.for_]
    fallen = sum(track.state is BrickState.FALLEN for track in meant)
    measured = f"{fallen} of {len(meant)} bricks fell" if fallen else f"{len(meant)} bricks stand"
    margin, unit = min((_margin_to_collapse(track) for track in meant), default=(inf, ""))
    return Finding(measured, margin, unit, passed=not fallen)


def _margin_to_collapse(track: BrickTrack) -> tuple[float, str]:
    """How much further a brick may shift, or turn if that is closer, before it counts as collapsed."""
    limit = COLLAPSE_SHARE_OF_SMALLEST_SIDE * min(track.brick.size)
    if track.tilt / COLLAPSE_TILT > track.shift / limit:
        return degrees(COLLAPSE_TILT - track.tilt), "deg"
    return MILLIMETRES * (limit - track.shift), "mm"


def _collapses(claim: Collapses, trace: Trace) -> Finding:
    if trace.collapse is None:
        margin, unit = min(
            (_margin_to_collapse(track) for track in _placed(trace)),
            default=(inf, "mm"),
        )
        return Finding("nothing fell", -margin, unit, passed=False)
    level, time, brick = trace.collapse.level, trace.collapse.time, trace.collapse.brick
    parts = [Finding(f"level {level}, {brick} at {time:.3f} s", inf, "", passed=True)]
    if claim.at is not None:
        parts.append(_within(claim.at, level, "levels"))
    if claim.time is not None:
        parts.append(_within(claim.time, time, "s"))
    if claim.brick is not None:
        parts.append(Finding("", 0.0 if claim.brick == brick else -1.0, "bricks", passed=claim.brick == brick))
    worst = min(parts, key=lambda part: (part.passed, part.margin))
    return Finding(parts[0].measured, worst.margin, worst.unit, all(part.passed for part in parts))


def _displaced(claim: Displaced, trace: Trace) -> Finding:
    count = sum(claim.by.holds(track.shift) for track in _placed(trace))
    return _within(claim.bricks, count, "bricks", f"{count} bricks")


def _drift(claim: Drift, trace: Trace) -> Finding:
    named = frozenset(trace.tracks if claim.bricks is None else claim.bricks)
    meant = [track for track in _placed(trace) if track.brick.id in named]
    worst = max(meant, key=lambda track: track.shift, default=None)
    if worst is None:
        return Finding("never placed", 0.0, "mm", passed=False)
    return _within(claim.within, worst.shift, "mm", f"{_mm(worst.shift)} ({worst.brick.id})")


def _rests_on(claim: RestsOn, trace: Trace) -> Finding:
    edge = next((edge for edge in trace.edges if (edge.upper, edge.lower) == (claim.brick, claim.support)), None)
    share = 0.0 if edge is None else edge.share
    if edge is None:
        margin = share if claim.share is None else claim.share.margin(share)
        return Finding("it does not rest there", min(margin, 0.0), "of its load", passed=False)
    if isnan(share):
        known = "it rests there, and its share is not known: friction, leaning or a counterweight holds it"
        return Finding(known, inf if claim.share is None else -inf, "", passed=claim.share is None)
    if claim.share is None:
        return Finding(f"share {share:.3f}", share, "of its load", passed=True)
    return _within(claim.share, share, "of its load", f"share {share:.3f}")


def _height(claim: Height, trace: Trace) -> Finding:
    meant = [track for track in _placed(trace) if claim.of in (None, track.brick.id)]
    if not meant:
        return Finding("never placed", 0.0, "mm", passed=False)
    if claim.of is None:
        meant = [track for track in meant if track.state not in (BrickState.FALLEN, BrickState.UNSETTLED)]
    top = max((box_top(track.brick.size, track.final) for track in meant), default=0.0)
    return _within(claim.within, top, "mm", _mm(top))


def _verdict(claim: str, trace: Trace) -> Finding:
    if trace.statics is None:
        return Finding("nothing was set down at rest", inf, "", passed=False)
    reason = f": {trace.statics.reason}" if trace.statics.reason else ""
    return Finding(f"{trace.statics.stability}{reason}", inf, "", passed=trace.statics.stability == claim)


def _margin(claim: Margin, trace: Trace) -> Finding:
    parts = [_part(key, getattr(claim, key), getattr(trace.margins, key)) for key in claim.asked]
    worst = min(parts, key=lambda part: (part.passed, part.margin))
    return replace(
        worst, measured=", ".join(part.measured for part in parts), passed=all(part.passed for part in parts)
    )


def _part(key: str, wanted: Tolerance, value: float | None) -> Finding:
    """One kind of margin."""
    unit = {"acceleration": "g", "tilt": "deg", "friction": "", "placement": "mm"}[key]
    if value is None:
        return Finding(f"no {key} is proven", -inf, unit, passed=False)
    return _within(wanted, value, unit, f"{key} {SHOWN_PER_SI.get(unit, 1.0) * value:.4g} {unit}".rstrip())


JUDGES: dict[str, Callable[..., Finding]] = {
    "stands": _stands,
    "collapses": _collapses,
    "displaced": _displaced,
    "drift": _drift,
    "rests_on": _rests_on,
    "height": _height,
    "verdict": _verdict,
    "margin": _margin,
}


def _remaining(trace: Trace) -> Iterable[tuple[BodyId, BrickTrack]]:
    """All bricks but those that were pulled out, of which nothing is expected any more."""
    return [(name, track) for name, track in trace.tracks.items() if track.state is not BrickState.REMOVED]


def _placed(trace: Trace) -> Iterable[BrickTrack]:
    return [track for _, track in _remaining(trace) if track.state is not BrickState.UNPLACED]


def _within(wanted: Tolerance, value: float, unit: str, measured: str = "") -> Finding:
    return Finding(measured, SHOWN_PER_SI.get(unit, 1.0) * wanted.margin(value), unit, wanted.holds(value))


def _mm(length: float) -> str:
    return f"{MILLIMETRES * length:.4g} mm"
