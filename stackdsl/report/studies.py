"""Results of studies as text, CSV and JSON: limits, sensitivities, survival, fragility, sweeps, orders."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import groupby
from math import degrees, hypot, inf
from typing import TYPE_CHECKING, Any, Final

from stability.analysis.acceleration_margin import tilt
from stability.analysis.building_order import BuildingOrder
from stability.analysis.removal_order import EarliestFall, LongestOrder, Pull
from stability.analysis.repair import BrickShift, Propping, SeveralShifts
from stability.analysis.weakest import Weakest
from stability.name_order import in_order, names_text
from stability.problem import Stability
from stackdsl.judging.proofs import BearingSurvival, Survival
from stackdsl.judging.remedies import HeavierBrick, MoreFriction, StrongerJoints, Suggestion
from stackdsl.report.statics import (
    counterweight_text,
    friction_text,
    later_text,
    load_factor_text,
    stronger_text,
    weakest_json,
)
from stackdsl.report.study_table import StudyTable, rows_within
from stackdsl.report.warnings import levels_told
from stackdsl.shown_text import visible
from stackdsl.studies.find_limit import End, FoundLimit, Want
from stackdsl.studies.sensitivities import Effect, MarginKind, Sensitivities, SlopeSource
from stackdsl.timeline import Timeline, leaves_to_engine
from stackdsl.wording import (
    FEW,
    PARTS,
    aided_text,
    all_bricks_text,
    apart_text,
    degrees_text,
    gives_way_text,
    how_many,
    in_short,
    limit_text,
    rounded_down,
    rounded_up,
    slides_together,
    survived_text,
)

if TYPE_CHECKING:  # these import scipy
    from stackdsl.judging.statistics import Interval
    from stackdsl.studies.fragility_curve import CurvePoint, Fragility, Lognormal
    from stackdsl.studies.sweep import SweptCase

LABEL: Final = 11  # [characters] column of labels
MOST_ROWS: Final = 8  # ways to give way
OF: Final = " of "  # between the kind of a number and its brick
PULLED: Final = 16  # [characters] column of the headings of pulls
STEPS: Final = 8  # [characters] column of the numbers of steps
WIDEST_NAMES: Final = 28  # [characters] of numbers beside their values

# A fragility curve as text, CSV and JSON.


PERCENT = 100.0
FRAGILITY_COLUMNS = ("value", "unit", "fell", "unknown", "samples", "share", "low", "high", "decided")
SETTINGS = ("bearing_deg", "seed", "confidence", "jitter")  # columns that are the same in all rows of a curve
WORST = "worst"  # in place of a bearing
MANY_SAMPLES = 100  # fewer show only large differences from a curve
STEADY = {
    "acceleration": "acceleration: constant, horizontal, at the onset of tipping or sliding; not the peak of a record",
    "tilt": "tilt: of the whole scene, held constant, at the onset of tipping or sliding",
}


def fragility_lines(name: str, fragility: "Fragility") -> Iterator[str]:
    """Yield the intensity at which half fall, then points, curve and remarks on them."""
    unit, sure = fragility.intensity.shown_unit, f"{PERCENT * fragility.confidence:.6g} %"
    yield f"{name}: {half_text(fragility)}"
    yield ""
    heading = f"{fragility.intensity.name}{f' [{unit}]' if unit else ''}"
    ways = {way for point in fragility.points for way in point.ways}
    rows = [(_number(fragility, point.value), _share(point), _counts(point)) for point in fragility.points]
    width = max(map(len, (heading, *(value for value, _, _ in rows))))
    yield f"  {heading:>{width}}    falls  {sure} interval"
    yield from (f"  {value:>{width}}  {share}  {counts}" for value, share, counts in rows)
    yield ""
    yield from (f"  {line}" for line in _curve_lines(fragility, sure))
    yield f"  {settings_text(fragility)}"
    if fragility.intensity.is_steady:
        yield f"  {STEADY[fragility.intensity.kind]}"
    judged = sum(point.count for point in fragility.points)
    if fragility.intensity.is_steady and fragility.points:
        judged = fragility.points[0].count
    if judged:
        each = 1000.0 * fragility.cpu_time / judged
        how = f" by {', '.join(sorted(ways))}" if ways else ""
        yield f"  {judged} verdicts{how} in {fragility.cpu_time:.3g} s of CPU time, {each:.3g} ms each"


def settings_text(fragility: "Fragility") -> str:
    """Return the number of samples, the seed, the placement errors and the direction."""
    jitter = f"jitter {fragility.jitter}" if fragility.jitter else "no jitter"
    jitter += ", scaled to each point" * (fragility.intensity.kind == "jitter")
    direction = f"; {direction_text(fragility)}" if fragility.intensity.is_steady else ""
    return f"{how_many(fragility.samples, 'sample')}, seed {fragility.seed}; {jitter}{direction}"


def direction_text(fragility: "Fragility") -> str:
    """Return the direction of an acceleration or a tilt."""
    if fragility.bearing is None:
        return "worst direction of each sample"
    return f"direction {_rounded(degrees(fragility.bearing)):g} deg from +x towards +y"


def half_text(fragility: "Fragility") -> str:
    """Return the intensity at which half of the samples fall, with its interval, or why there is none.

    The lognormal curve gives it if it describes all samples; otherwise it follows from the points alone.
    """
    over, curve, sure = fragility.intensity.name, fragility.curve, f"{PERCENT * fragility.confidence:.6g} %"
    half, bracket = fragility.half, fragility.bracket
    if curve is not None and not fragility.fell_built:
        within = _between(fragility, curve.median_within)
        return (
            f"half of the samples fall at {over} {_quantity(fragility, curve.median)} ({within}; {sure}, lognormal fit)"
        )
    if fragility.intensity.is_steady and half is not None and fragility.half_within is not None:
        within = _between(fragility, fragility.half_within)
        return f"half of the samples fall at {over} {_quantity(fragility, half)} ({within}; {sure}, order statistics)"
    if bracket is not None:
        low, high = (_quantity(fragility, point.value) for point in bracket)
        at_low, at_high = (f"{PERCENT * p.within.low:.1f} to {PERCENT * p.within.high:.1f} %" for p in bracket)
        within = f"{at_low} fall at {low}, {at_high} at {high}"
        return f"half of the samples fall between {over} {low} and {high} ({within}; {sure}, Clopper-Pearson)"
    shares = [point.share for point in fragility.points if point.count > point.unknown]
    if not shares:
        return "no point is decided"
    least, most = (f"{PERCENT * share:.3g} %" for share in (min(shares), max(shares)))
    share = least if least == most else f"{least} to {most}"
    return f"{share} fall in this range of {over}, nowhere half of them"


def _curve_lines(fragility: "Fragility", sure: str) -> Iterator[str]:
    curve, test = fragility.curve, fragility.test
    if fragility.fell_built:
        others = "; the lognormal curve describes the others" if curve is not None else ""
        fallen = "counts as fallen" if fragility.fell_built == 1 else "count as fallen"
        yield f"{how_many(fragility.fell_built, 'sample')} fell during the build and {fallen} at each point{others}"
    if curve is None:
        yield f"no lognormal curve: {fragility.no_curve}"
    else:
        how = "" if curve.rises else ", decreasing: fewer samples fall at larger values"
        median = ""
        if fragility.fell_built:
            median = f"half of the others fall at {_quantity(fragility, curve.median)} "
            median += f"({_between(fragility, curve.median_within)}), "
        yield (
            f"lognormal curve: {median}dispersion {curve.dispersion:.3g} ({_plain_interval(curve.dispersion_within)})"
            f"{how}; {sure} intervals"
        )
    if curve is not None and test is not None:
        few = "; few samples show only large differences" if fragility.samples < MANY_SAMPLES else ""
        yield f"test of the curve: not refused, {test.text(_quantity(fragility, test.at))}{few}"
    if fragility.left_out:
        yield f"{fragility.left_out} undecided verdicts are left out of the curve"


def _quantity(fragility: "Fragility", value: float) -> str:
    return f"{_number(fragility, value)} {fragility.intensity.shown_unit}".rstrip()


def _number(fragility: "Fragility", value: float) -> str:
    return f"{fragility.intensity.shown(value):.{FIGURES}g}"


def _share(point: "CurvePoint") -> str:
    within = point.within
    return f"{PERCENT * point.share:5.1f} %  {PERCENT * within.low:5.1f} % to {PERCENT * within.high:5.1f} %"


def _counts(point: "CurvePoint") -> str:
    return f"{point.fell:>6} of {point.count}" + (f", {point.unknown} undecided" if point.unknown else "")


def _decided(point: "CurvePoint") -> str:
    return ", ".join(f"{count} {way}" for way, count in sorted(point.ways.items(), key=lambda each: -each[1]))


def _between(fragility: "Fragility", within: "Interval") -> str:
    return f"{_number(fragility, within.low)} to {_number(fragility, within.high)}"


def _plain_interval(within: "Interval") -> str:
    return f"{within.low:.3g} to {within.high:.3g}"


def fragility_table(curves: "Sequence[tuple[str, Fragility]]") -> StudyTable:
    """Return a row for each point; JSON has the curve as well, `null` where there is none."""
    rows = [
        {
            "case": name,
            "over": fragility.intensity.name,
            **_fragility_row(fragility, point),
            **{key: as_values(fragility)[key] for key in SETTINGS},
        }
        for name, fragility in curves
        for point in fragility.points
    ]
    details = [{"case": name, **as_values(fragility)} for name, fragility in curves]
    return StudyTable(("case", "over", *FRAGILITY_COLUMNS, *SETTINGS), rows, details)


def capacities_table(curves: "Sequence[tuple[str, Fragility]]") -> StudyTable:
    """Return a row for the capacity of each sample, as bounds between which it falls; None where there is no bound."""
    rows = [
        {
            "case": name,
            "sample": number,
            "outcome": "fell built" if each.outcome > 0 else "stands" if each.outcome == 0 else "undecided",
            "survives": _shown(fragility, each.survived),
            "falls": _shown(fragility, each.fails) if each.fails < inf else None,
            "unit": fragility.intensity.shown_unit,
        }
        for name, fragility in curves
        for number, each in fragility.capacities.items()
    ]
    return StudyTable(("case", "sample", "outcome", "survives", "falls", "unit"), rows, rows)


def _shown(fragility: "Fragility", acceleration: float) -> float:
    intensity = fragility.intensity
    return float(f"{intensity.shown(intensity.of_acceleration(acceleration)):.10g}")


def as_values(fragility: "Fragility") -> dict[str, Any]:
    """Return a fragility curve as plain values."""
    half_within, test = fragility.half_within, fragility.test
    bearing = WORST if fragility.bearing is None else _rounded(degrees(fragility.bearing))
    return {
        "over": fragility.intensity.name,
        "unit": fragility.intensity.shown_unit,
        "samples": fragility.samples,
        "seed": fragility.seed,
        "confidence": fragility.confidence,
        "jitter": fragility.jitter,
        "bearing_deg": bearing if fragility.intensity.is_steady else None,
        "points": [
            {**_fragility_row(fragility, point), "decided": dict(sorted(point.ways.items()))}
            for point in fragility.points
        ],
        "lognormal": _lognormal(fragility, fragility.curve),
        "is_lognormal": fragility.curve is not None,
        "no_lognormal": fragility.no_curve,
        "refused_lognormal": _lognormal(fragility, fragility.refused),
        "test": test
        and {
            "method": test.method,
            "level": test.level,
            "p": _rounded(test.p),
            "largest_difference": _rounded(test.largest),
            "at": _rounded(fragility.intensity.shown(test.at)),
        },
        "half": _rounded(fragility.intensity.shown(fragility.half)) if fragility.half is not None else None,
        "half_within": half_within and [_rounded(fragility.intensity.shown(end)) for end in _ends(half_within)],
        "fell_built": fragility.fell_built,
        "left_out": fragility.left_out,
    }


def _lognormal(fragility: "Fragility", curve: "Lognormal | None") -> dict[str, Any] | None:
    if curve is None:
        return None
    shown = fragility.intensity.shown
    return {
        "median": _rounded(shown(curve.median)),
        "median_within": [_rounded(shown(end)) for end in _ends(curve.median_within)],
        "dispersion": _rounded(curve.dispersion),
        "dispersion_within": [_rounded(end) for end in _ends(curve.dispersion_within)],
        "rises": curve.rises,
    }


def _ends(within: "Interval") -> tuple[float, float]:
    return within.low, within.high


def _fragility_row(fragility: "Fragility", point: "CurvePoint") -> dict[str, Any]:
    share = point.share if point.count > point.unknown else None
    low, high = map(_rounded, _ends(point.within))
    return {
        "value": _rounded(fragility.intensity.shown(point.value)),
        "unit": fragility.intensity.shown_unit,
        "fell": point.fell,
        "unknown": point.unknown,
        "samples": point.count,
        "share": share and _rounded(share),
        "low": low,
        "high": high,
        "decided": _decided(point),
    }


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")


# Limits of scenarios as text, CSV and JSON.


FIGURES: Final = 4  # significant digits of a limit as text; other formats have all
AGREEING: Final = 12  # at most, of the digits in which both sides of a limit agree
NUMBERS: Final = ("stands", "beyond", "written", "low", "high")
LIMIT_COLUMNS: Final = (
    *("case", "want", "name", "end", "stands", "beyond", "unit", "stands_si", "beyond_si", "written", "low", "high"),
    *("by_program", "verdicts", "is_open", "judged", "bricks", "place", "why"),
)


def limit_lines(finding: FoundLimit) -> Iterator[str]:
    """Yield the limit of a case and its certainty."""
    written = ""
    if finding.written is not None:
        at = f"; {finding.place} has" if finding.place else "; the scenario has"
        written = f"{at} {_number_text(finding, finding.written)}"
    yield f"{finding.case}: {_limit(finding)}{written}"
    if finding.end in (End.LIMIT, End.NOWHERE) and finding.why:
        for number, part in enumerate(finding.why.split(PARTS)):
            yield f"  {'' if number else 'falls':<{LABEL}}{part}"
        if finding.moment:
            yield f"  {'':<{LABEL}}with the placement at {finding.moment:g} s"
    if finding.end is End.OPEN:
        yield f"  {'undecided':<{LABEL}}{finding.why}"
    yield from (f"  {line}" for line in _remarks(finding))


def _limit(finding: FoundLimit) -> str:
    asked, stands = f"{finding.want} {finding.name}", _safe_text(finding, finding.stands)
    match finding.end:
        case End.LIMIT:
            return f"{asked} {stands} stands, {_safe_text(finding, finding.beyond, beyond=True)} falls"
        case End.EDGE:
            beyond = _safe_text(finding, finding.beyond, beyond=True)
            return f"{asked} {stands} stands, {beyond} is invalid: {finding.why}"
        case End.NONE if finding.stands == inf:
            return f"{asked}: no limit; the structure is held on all sides"
        case End.NONE:
            way = "down" if finding.want is Want.LEAST else "up"
            why = f"; beyond, {finding.why}; set the end of the search with --to" if finding.why else ""
            return f"{asked}: no limit found; it stands {way} to {stands}{why}"
        case End.NOWHERE if finding.written is None:
            return f"{asked}: no limit; the structure is not proven to stand"
        case End.NOWHERE:
            return f"{asked}: no limit found; it falls with every value tried"
        case End.OPEN:
            return f"{asked}: no limit found; no value tried is proven to stand"
        case End.NO_EFFECT:
            return f"{asked}: no effect on the structure"
        case _:
            return f"{asked}: no brick is set down at rest, so statics has nothing to judge"


def _remarks(finding: FoundLimit) -> Iterator[str]:
    """Yield remarks on the validity of a limit."""
    if finding.others:
        yield finding.others
    if finding.by_program and finding.written is None:
        yield "for the finished structure, proven by contact forces on one side and by a motion on the other"
    elif finding.written is not None and finding.end is not End.NOTHING:
        how = "computed by optimization and verified on both sides; " if finding.by_program else ""
        least, most = _number_text(finding, finding.low, unit=False), _number_text(finding, finding.high)
        yield f"{how}{how_many(finding.verdicts, 'verdict')} from {least} to {most}{_agreement(finding)}"
    if finding.is_open:
        yield "values in between are undecided: they are too close to the limit"
    if finding.contradicting:
        yield f"this is not the only limit: {', and '.join(_contradicting(finding))}"
    if finding.judged < finding.bricks and finding.stands is not None:
        yield f"for {finding.judged} of {finding.bricks} bricks; the later ones depend on an engine and are left out"


def _agreement(finding: FoundLimit) -> str:
    """Return the digits in which both sides of a limit agree, if there are more than the shown ones."""
    if finding.end is not End.LIMIT or finding.stands is None or finding.beyond is None:
        return ""
    for digits in range(AGREEING, FIGURES - 1, -1):
        stands, beyond = (f"{value:#.{digits}g}" for value in (finding.stands, finding.beyond))
        if stands == beyond:
            return f"; the limit is {stands.rstrip('.')} {finding.unit}".rstrip() + f" to {digits} digits"
    return ""


def _contradicting(finding: FoundLimit) -> Iterator[str]:
    """Yield numbers whose verdict contradicts their side of the limit."""
    for answer, group in groupby(finding.contradicting, key=lambda each: each[1]):
        values = [_number_text(finding, value) for value, _ in group]
        ends = (
            f" with each of {len(values)} values from {values[0]} to {values[-1]}"
            if len(values) > 1
            else f" at {values[0]}"
        )
        yield f"it {answer} also{ends}"


def _number_text(finding: FoundLimit, value: float, *, unit: bool = True) -> str:
    return f"{float(f'{value:.{FIGURES}g}'):.12g} {finding.unit if unit else ''}".rstrip()


def _safe_text(finding: FoundLimit, value: float | None, *, beyond: bool = False) -> str:
    """Return a side of a limit, rounded away from the limit, so that the shown value is on the same side."""
    if value is None:
        return "none"
    if value == round(value):
        return f"{value:.0f} {finding.unit}".rstrip()
    up = (finding.want is Want.LEAST) != beyond
    rounded = float((rounded_up if up else rounded_down)(value, FIGURES))
    return f"{f'{rounded:#.{FIGURES}g}'.rstrip('.')} {finding.unit}".rstrip()


def limit_table(findings: Sequence[FoundLimit]) -> StudyTable:
    """Return a row for each case and number; JSON has contradicting values as well, and `null` for a missing number."""
    rows = [*map(_limit_row, findings)]
    return StudyTable(LIMIT_COLUMNS, rows, rows, "found")


def _limit_row(finding: FoundLimit) -> dict[str, Any]:
    row = {key: value for key, value in asdict(finding).items() if key not in ("scale", "moment", "others")}
    row["contradicting"] = [{"value": value, "answer": answer} for value, answer in finding.contradicting]
    numbers = {key: _finite_in_si(row[key]) for key in NUMBERS}
    in_si = {f"{key}_si": _finite_in_si(row[key], finding.scale) for key in ("stands", "beyond")}
    return row | numbers | in_si


def _finite_in_si(value: float | None, scale: float = 1.0) -> float | None:
    return None if value is None or value == inf else scale * value


# Sensitivities of margins as text, CSV and JSON.


UNITS: Final = {MarginKind.ACCELERATION: "g", MarginKind.FRICTION: "", MarginKind.LOAD_FACTOR: ""}
HOW: Final = {
    SlopeSource.CHECKED: "confirmed by finite differences",
    SlopeSource.DUALS: "not checked",
    SlopeSource.DIFFERENCES: "from finite differences",
    SlopeSource.NONE: "no margin on either side",
}
SENSITIVITY_COLUMNS: Final = (
    "case",
    "margin",
    "what",
    "unit",
    "size",
    "less",
    "more",
    "by_a_hundredth",
    "kink",
    "source",
)


def _margin_of(found: Sensitivities) -> str:
    """Return the analysed margin in words."""
    match found.of:
        case MarginKind.FRICTION:
            return f"needs friction {rounded_up(found.margin)}"
        case MarginKind.LOAD_FACTOR:
            return f"bears {load_factor_text(found.margin)}"
        case MarginKind.ACCELERATION:
            return f"survives {survived_text(found.margin)} {UNITS[found.of]}"


def sensitivity_lines(found: Sensitivities, most: int) -> Iterator[str]:
    """Yield the margin and a line for numbers with the same effect, the largest effect first."""
    unit = UNITS[found.of]
    survives = _margin_of(found)
    counting = [each for each in found.effects if each.counts]
    shown = counting[:most]
    yield f"{found.case} {survives}. It depends most on:" if shown else f"{found.case} {survives}"
    yield ""
    rows = [(_numbers_text(alike), *_slopes(alike[0], unit), HOW[alike[0].source]) for alike in _alike_effects(shown)]
    if rows:
        rows.insert(0, ("number", "per unit more", "if 1 % more", ""))
        widths = [max(len(row[column]) for row in rows if len(row[0]) <= WIDEST_NAMES) for column in range(3)]
        for what, slope, change, how in rows:
            cells = f"{slope:<{widths[1]}}  {change:<{widths[2]}}  {how}".rstrip()
            if len(what) > WIDEST_NAMES:  # on a line of its own
                yield f"  {what}"
            yield f"  {what if len(what) <= WIDEST_NAMES else '':<{widths[0]}}  {cells}"
        yield ""
    rest, nothing = len(counting) - len(shown), [each for each in found.effects if not each.counts]
    if rest:
        yield f"  {how_many(rest, 'more number')} with less effect; --top {len(counting)} lists all"
    if nothing:
        by_forces = sum(each.source is SlopeSource.DUALS for each in nothing)
        unchecked = f" ({'not' if by_forces == len(nothing) else f'{by_forces} not'} checked)" if by_forces else ""
        yield f"  {len(nothing)} of {len(found.effects)} numbers have no effect{unchecked}"
    if found.in_doubt:
        yield "  forces or motions at the limit are not unique: unchecked values may be wrong; --check N checks more"
    if found.left or found.unchecked:
        yield f"  interrupted: {how_many(found.left, 'number')} left out, {how_many(found.unchecked, 'check')} not made"
    if found.judged < found.bricks:
        yield f"  for {found.judged} of {found.bricks} bricks; the later ones depend on an engine and are left out"


def _alike_effects(effects: Sequence[Effect]) -> list[list[Effect]]:
    """Return groups of effects of the same kind of number that look the same in three digits."""
    groups: dict[Any, list[Effect]] = {}
    for each in effects:
        slopes = tuple(None if slope is None else f"{slope:.3g}" for slope in (each.less, each.more))
        key = (each.what.partition(OF)[0], each.unit, slopes, f"{each.matters:.3g}", each.source)
        groups.setdefault(key, []).append(each)
    return list(groups.values())


def _numbers_text(effects: Sequence[Effect]) -> str:
    """Return the names of numbers of a kind: `y of L7.2, L9.1 to L9.3`."""
    if len(effects) == 1:
        return effects[0].what
    kind, of, _ = effects[0].what.partition(OF)
    return kind + of + names_text(in_order(each.what.partition(OF)[2] or each.what for each in effects))


def _slopes(effect: Effect, unit: str) -> tuple[str, str]:
    """Return the change of the margin for one unit more of the number, and for 1 % more."""
    per = f" {unit}/{effect.unit}" if unit and effect.unit else (f" {unit}" if unit else f" 1/{effect.unit}")
    per = per if unit or effect.unit else ""
    change = f"{effect.matters:.3g} {unit}".rstrip()
    if not effect.has_kink:
        assert effect.more is not None
        return f"{effect.more:+.3g}{per}", f"{'-' if effect.more * effect.size < 0.0 else '+'}{change}"
    if effect.less is None and effect.more is None:
        return "", ""  # `HOW` says it
    less, more = ("no margin" if each is None else f"{each:+.3g}{per}" for each in (effect.less, effect.more))
    return f"{more}, and {less} below", f"up to {change}"


def sensitivity_table(found: Sequence[Sensitivities]) -> StudyTable:
    """Return a row for each number; `null` where there is no margin on a side."""
    cases = [*map(_sensitivity_case, found)]
    return StudyTable(SENSITIVITY_COLUMNS, rows_within(cases, "effects"), cases)


def _sensitivity_case(found: Sensitivities) -> dict[str, Any]:
    told = {"case": found.case, "of": found.of, "margin": found.margin, "in_doubt": found.in_doubt}
    return {**told, "effects": [*map(_sensitivity_row, found.effects)]}


def _sensitivity_row(effect: Effect) -> dict[str, Any]:
    return {
        **{"what": effect.what, "unit": effect.unit, "size": effect.size, "less": effect.less, "more": effect.more},
        **{"by_a_hundredth": effect.matters, "kink": effect.has_kink, "source": effect.source},
    }


# Survived acceleration by bearing, as text, CSV and JSON.


SURVIVAL_COLUMNS = ("bearing_deg", "survives_g", "fails_g", "tilt_deg", "gives_way")


def survival_lines(name: str, survival: Survival) -> Iterator[str]:
    """Yield the least survived acceleration, then a line for bearings with the same failure, the weakest first."""
    if survival.load_factor is not None:
        yield f"{name} bears {load_factor_text(survival.load_factor, survival.loaded)}"
        if survival.yields:
            yield f"  beyond: {survival.yields}"
    if not survival.along:
        yield "  Accelerations by bearing are not computed for brittle joints."
        return
    worst = survival.worst
    if worst.survived == inf:
        yield f"{name} survives every acceleration in every direction, since it is held on all sides"
        return
    first = survival.weakest
    least = worst.survived if first is None else first.acceleration
    where = "along these bearings" if first is None else "in every direction"
    tilted = "" if worst.tilt is None else f", a tilt of {survived_text(degrees(tilt(least)))} deg"
    yield f"{name} survives {survived_text(least)} g {where}{tilted}"
    if survival.apart is not None:
        apart = survival.apart
        aided = f"{aided_text(apart)}: {in_short(apart.gives_way)}"
        yield f"  {apart_text(apart) if apart.acceleration is None else aided}"
    yield ""
    rows = list(_survival_rows(survival))
    rows.insert(0, ("towards", "survives", "what gives way first"))
    towards, survives = (max(len(row[column]) for row in rows) for column in (0, 1))
    yield from (f"  {row[0]:<{towards}}  {row[1]:<{survives}}  {row[2]}".rstrip() for row in rows[: MOST_ROWS + 1])
    if len(rows) > MOST_ROWS + 1:
        yield f"  {how_many(len(rows) - MOST_ROWS - 1, 'more way')} to give way; --format csv lists each bearing"
    yield ""
    if survival.tips is not None:
        tips = survival.tips
        where = f"{limit_text(tips.acceleration)} g towards {degrees_text(tips.bearing)}"
        where += ", without friction between neighbours"
        yield f"  If no brick slides on the one below, tipping begins above {where}: {_tipping(tips, survival)}."
        yield "  If bricks slide, parts may tip at less: set the friction of mats in the file, and ask again."
    yield "  Bearings count from +x towards +y."


EACH = " each"  # after bricks or groups that tip alike, but not as one body


def _tipping(tips: Weakest, survival: Survival) -> str:
    """Describe the mechanism that opens if nothing slides; if the whole structure tips, by the number of bricks."""
    first, (bricks, tip, rest) = survival.weakest, tips.gives_way.partition(" tip ")
    whole = first is not None and slides_together(first) and tips.bricks == first.bricks and PARTS not in rest
    whole = whole and not bricks.endswith(EACH)
    return f"{all_bricks_text(tips)}{tip}{rest}" if whole and tip and PARTS not in bricks else in_short(tips.gives_way)


def _survival_rows(survival: Survival) -> Iterator[tuple[str, str, str]]:
    """Yield bearings, survived accelerations and failure: the weakest bearing first, then the others by failure."""
    if survival.weakest is not None:
        first = survival.weakest
        yield degrees_text(first.bearing), f"{survived_text(first.acceleration)} g", in_short(gives_way_text(first))
    ways: dict[str, list[list[BearingSurvival]]] = {}
    for run in _alike(survival.along):
        ways.setdefault(in_short(run[0].gives_way), []).append(run)
    if survival.weakest is not None and list(ways) == [in_short(survival.weakest.gives_way)]:
        return  # the same in every direction
    for way, runs in sorted(ways.items(), key=lambda each: min(row.survived for run in each[1] for row in run)):
        spans = ", ".join(_span(run) for run in runs)
        survived = [row.survived for run in runs for row in run]
        if min(survived) == inf:
            yield f"{spans} deg", "any", "nothing"
            continue
        worst = survival.weakest
        if worst is not None and way == in_short(worst.gives_way):
            yield f"{spans} deg", f"{_range(survived)} g", f"as towards {degrees_text(worst.bearing)}"
        else:
            yield f"{spans} deg", f"{_range(survived)} g", way


def _alike(along: Sequence[BearingSurvival]) -> list[list[BearingSurvival]]:
    """Return groups of neighbouring bearings with the same failure; the group around +x comes first."""
    runs = [list(rows) for _, rows in groupby(along, key=lambda each: each.gives_way)]
    if len(runs) > 1 and runs[0][0].gives_way == runs[-1][0].gives_way:
        runs = [[*runs[-1], *runs[0]], *runs[1:-1]]
    return runs


def _span(rows: Sequence[BearingSurvival]) -> str:
    first, last = (f"{degrees(row.bearing):.4g}" for row in (rows[0], rows[-1]))
    return first if len(rows) == 1 else f"{first} to {last}"


def _range(values: Sequence[float]) -> str:
    least, most = survived_text(min(values)), "any" if max(values) == inf else survived_text(max(values))
    return least if least == most else f"{least} to {most}"


def survival_table(survivals: Sequence[tuple[str, Survival]]) -> StudyTable:
    """Return a row for each bearing; empty or `null` where nothing gives way."""
    cases = [
        {
            "case": name,
            "survives_g": _finite_margin(
                (survival.weakest and survival.weakest.acceleration) or survival.worst.survived
            )
            if survival.along
            else None,
            "without_neighbours_g": None if survival.apart is None else _rounded(survival.apart.acceleration or 0.0),
            "weakest": None if survival.weakest is None else weakest_json(survival.weakest),
            "load_factor": None if survival.load_factor is None else _finite_margin(survival.load_factor),
            "gives_way": survival.yields,
            "bearings": [*map(_survival_row, survival.along)],
        }
        for name, survival in survivals
    ]
    return StudyTable(("case", *SURVIVAL_COLUMNS), rows_within(cases, "bearings"), cases)


def _survival_row(each: BearingSurvival) -> dict[str, float | str | None]:
    leans = None if each.tilt is None else _finite_margin(degrees(each.tilt))
    numbers = map(_finite_margin, (degrees(each.bearing), each.survived, each.fails))
    return dict(zip(SURVIVAL_COLUMNS, (*numbers, leans, each.gives_way), strict=True))


def _finite_margin(value: float) -> float | None:
    return None if value == inf else _rounded(value)


# Summary of a sweep as text, CSV and JSON; the rows are in its file.


SAMPLED: Final = ("stands", "collapses", "undecided", "unfit", "failed")  # the verdicts of samples
SWEEP_COLUMNS: Final = ("case", "rows", *SAMPLED, "stands_least", "stands_most")
VERBS: Final = {
    "stands": "stand",
    "collapses": "fall",
    "unfit": "without free space for a brick",
}


def sweep_lines(cases: "Sequence[SweptCase]") -> Iterator[str]:
    """Yield a line for each case, with evidence and failures below. Rows may come with a project."""
    yield from map(visible, _lines(cases))


def _lines(cases: "Sequence[SweptCase]") -> Iterator[str]:
    for each in cases:
        if not each.rows:
            continue
        if not each.entry.case.is_sampled:
            yield f"{each.entry.name}: {_once(each)}"
            continue
        yield f"{each.entry.name}: {each.rows} of {each.entry.count} samples, seed {each.entry.seed}: {_verdicts(each)}"
        if (stands := each.stands) is not None:
            sure = f"{100.0 * each.entry.case.scenario.confidence:g} % confidence"
            yield f"  share that stands: {100.0 * stands.low:.3g} % to {100.0 * stands.high:.3g} %, {sure}"
        if each.ways:
            yield f"  decided: {', '.join(f'{count} {way}' for way, count in each.ways.items())}"
        failed = list(each.failed.items())
        yield from (f"  failed: {why}" + (f" ({count} of them)" if count > 1 else "") for why, count in failed[:FEW])
        if len(failed) > FEW:
            yield f"  failed: {len(failed) - FEW} more reasons in the rows with the verdict failed"


def sweep_table(cases: "Sequence[SweptCase]") -> StudyTable:
    """Return a row for each case; JSON has levels and ways as well. A case without samples has no share."""
    details = [*map(_sweep_case, cases)]
    rows = [
        {
            **case,
            **{verdict: case["verdicts"].get(verdict, 0) for verdict in SAMPLED},
            **dict(zip(("stands_least", "stands_most"), case["stands"] or ("", ""), strict=True)),
        }
        for case in details
    ]
    return StudyTable(SWEEP_COLUMNS, rows, details)


def _sweep_case(each: "SweptCase") -> dict[str, Any]:
    share = each.stands
    return {
        "case": each.entry.name,
        "seed": each.entry.seed,
        "rows": each.rows,
        "planned": each.entry.count,
        "verdicts": each.verdicts,
        "fell": {str(level): count for level, count in each.fell.items()},
        "ways": each.ways,
        "failed": each.failed,
        "stands": [share.low, share.high] if share is not None else None,
    }


def _verdicts(each: "SweptCase") -> str:
    parts = []
    for verdict, count in each.verdicts.items():
        levels = levels_told(each.fell) if verdict == "collapses" else ""
        parts.append(f"{count} {VERBS.get(verdict, verdict)}{levels}")
    return ", ".join(parts)


def _once(each: "SweptCase") -> str:
    """Return the result of a case that is played once."""
    kind = next(iter(each.kinds))
    return f"{kind.verdict}{f' at level {kind.level}' if kind.level is not None else ''} ({kind.how})"


# Suggested changes as text and rows.


NO_SHIFT = 1e-9  # share of a shift: a smaller part along an axis is rounding


def suggestion_row(suggestion: Suggestion) -> dict[str, Any]:
    """Return the same keys for every kind; a value is None if the kind has none."""
    keys = ("kind", "bricks", "amount", "unit", "fails_with")
    return {**dict(zip(keys, _amounts(suggestion), strict=True)), "text": suggestion_text(suggestion)}


def _amounts(suggestion: Suggestion) -> tuple[str, str, float | None, str, float | None]:
    match suggestion:
        case BrickShift(brick):
            return ("shift", brick, 1e3 * suggestion.length, "mm", 1e3 * suggestion.too_little)
        case SeveralShifts(shifts, too_little):
            longest = max(hypot(*shift) for _, shift in shifts)
            names = " ".join(name for name, _ in shifts)
            return ("shifts", names, 1e3 * longest, "mm", 1e3 * longest * too_little)
        case HeavierBrick(brick, mass):
            return ("counterweight", brick, 1e3 * mass, "g", None)
        case MoreFriction(_, coefficient):
            return ("friction", "", coefficient, "", None)
        case StrongerJoints(factor):
            return ("joints", "", factor, "", None)
        case Propping(bricks):
            return ("props", " ".join(bricks), None, "", None)


def suggestion_text(suggestion: Suggestion) -> str:
    """Return the suggestion in words."""
    match suggestion:
        case BrickShift(brick, shift):
            return f"move {brick} by {_shift(shift)}, with all bricks on it"
        case SeveralShifts(shifts):
            moves = ", ".join(f"{brick} by {_shift(shift)}" for brick, shift in shifts)
            return f"move {moves}, each with all bricks on it"
        case HeavierBrick():
            return counterweight_text(suggestion)
        case MoreFriction():
            return friction_text(suggestion)
        case StrongerJoints():
            return stronger_text(suggestion)
        case Propping(bricks, later):
            props = f"permanent prop{'s' * (len(bricks) > 1)} under {', '.join(bricks)}"
            return props + later_text(later)


def _shift(shift: tuple[float, float]) -> str:
    """Return a shift along the axes, rounded up, so that it suffices."""
    parts = zip(shift, (("+x", "-x"), ("+y", "-y")), strict=True)
    least = NO_SHIFT * hypot(*shift)
    told = [
        f"{rounded_up(1e3 * abs(part), FIGURES)} mm towards {to[part < 0.0]}" for part, to in parts if abs(part) > least
    ]
    return " and ".join(told)


# Pulls and building orders as text; the rows of their tables are the same for CSV and JSON.


ANSWERS = {Stability.STABLE: "stands", Stability.UNSTABLE: "falls", Stability.UNDECIDED: "not proven"}


def pull_row(pull: Pull) -> dict[str, Any]:
    """Return the row of a brick that was pulled out of the whole structure."""
    verdict = pull.verdict
    why = verdict.reason or (f"{verdict.stage}" if verdict.stage is not None else "")
    return {"brick": pull.brick, "carries": pull.carries, "rest": ANSWERS[verdict.stability], "proof": why}


def after_text(timeline: Timeline) -> str:
    """Return after which impacts the pulls are judged: all that pull bricks out, and none that push or shake."""
    told = []
    if timeline.pulled_out:
        are = "are" if len(timeline.pulled_out) > 1 else "is"
        told.append(f"{names_text(timeline.pulled_out)} {are} already out")
    if any(leaves_to_engine(action) for action in timeline.actions):
        told.append("impacts that need an engine are left out")
    return f" ({'; '.join(told)})" if told else ""


def pull_lines(name: str, after: str, pulls: Sequence[Pull]) -> Iterator[str]:
    """Yield the number of removable bricks, and bricks with the same result together; `after` names the actions."""
    answers = {answer: [pull for pull in pulls if pull.verdict.stability is answer] for answer in ANSWERS}
    stands = answers[Stability.STABLE]
    yield f"{name}: {len(stands)} of {how_many(len(pulls), 'brick')} can be pulled out, one at a time{after}"
    yield ""
    present = [pull.brick for pull in pulls]
    for heading, of in (
        ("stands without", [pull.brick for pull in stands if pull.carries]),
        ("carry nothing", [pull.brick for pull in stands if not pull.carries]),
    ):
        if of:
            yield f"  {heading:<{PULLED}}{names_text(in_order(of), among=present)}"
    for heading, answer in (("falls without", Stability.UNSTABLE), ("undecided", Stability.UNDECIDED)):
        for number, pull in enumerate(answers[answer]):
            yield f"  {'' if number else heading:<{PULLED}}{pull.brick}: {pull_row(pull)['proof']}"


def longest_lines(longest: LongestOrder) -> Iterator[str]:
    """Yield the longest order of removals."""
    bound = "proven that none is longer"
    if not longest.proven:
        bound = f"proven that none is longer than {longest.at_most}"
        bound += f" ({longest.reason})" if longest.reason else ""
    yield f"  {'longest order':<{PULLED}}{how_many(len(longest.order), 'pull')} after which the rest stands; {bound}"
    if longest.order:
        yield f"  {'':<{PULLED}}{', '.join(longest.order)}"


def soonest_line(soonest: EarliestFall) -> str:
    """Return the order of removals with the earliest fall."""
    heading = f"  {'shortest fall':<{PULLED}}"
    if not soonest.order:
        most = soonest.at_least - 1
        return heading + (f"{how_many(most, 'pull')} never make it fall" if most > 0 else "no worst case was found")
    count = len(soonest.order)
    bound = "proven that fewer do not suffice" if soonest.at_least == count else "fewer may suffice"
    return f"{heading}{how_many(count, 'pull')} ({', '.join(soonest.order)}); {bound}"


def order_rows(order: BuildingOrder) -> list[dict[str, Any]]:
    """Return a row for each step."""
    return [
        {"step": n, "brick": step.brick, "prop": step.propped, "struck": " ".join(step.struck)}
        for n, step in enumerate(order.steps, 1)
    ]


def order_lines(name: str, order: BuildingOrder, interrupted: bool = False) -> Iterator[str]:
    """Yield a building order and its props; after an interrupt, the best by then."""
    stopped = "interrupted; the best result so far: " if interrupted else ""
    yield f"{name}: {stopped}{_order_answer(order, interrupted)}"
    if order.steps:
        yield ""
        yield from _steps(order)


def _order_answer(order: BuildingOrder, interrupted: bool) -> str:
    if not order.steps:
        if order.impossible:
            return "no order exists (proven)"
        if order.props_at_least:
            return f"no order was found; every order needs at least {how_many(order.props_at_least, 'prop')} (proven)"
        return "no order was found, and it is not proven that none exists"
    if order.without is not None and order.without.order is not None:
        return f"all {len(order.steps)} bricks can be set down one at a time, without props"
    count, least = len(order.props), order.props_at_least
    fewer = f"at least {least} are needed, proven; a larger --most may find fewer than {count}"
    told = ["the fewest, proven" if least == count else fewer] if least else []
    proven = order.without is not None and order.without.impossible
    told.append("no order without props exists, proven" if proven else "no order without props was found")
    what = "props so far" if interrupted else "props"
    return f"{count} {what}, at most {order.props_at_once} at a time; {'; '.join(told)}"


def _steps(order: BuildingOrder) -> Iterator[str]:
    """Yield the steps; bricks that are set down one after the other without a prop share a line."""
    rows: list[tuple[int, list[str], str]] = []  # first step, bricks, and what is done besides
    for row in order_rows(order):
        besides = ["with a prop under it"] if row["prop"] else []
        besides += [f"then remove the prop under {row['struck'].replace(' ', ', ')}"] if row["struck"] else []
        if rows and not besides and not rows[-1][2]:
            rows[-1][1].append(row["brick"])
        else:
            rows.append((row["step"], [row["brick"]], "; ".join(besides)))
    for step, bricks, done in rows:
        last = step + len(bricks) - 1
        number = f"{step} to {last}" if last > step else f"{step}"
        gap = "; " if done.startswith("then") else "  "
        yield f"  {number:>{STEPS}}  {', '.join(bricks)}{gap}{done}".rstrip()
