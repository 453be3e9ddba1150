"""Results of studies as text, CSV and JSON: limits, sensitivities, survival, fragility, sweeps, orders."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import groupby
from math import atan2, ceil, degrees, hypot, inf, log10
from typing import TYPE_CHECKING, Any, Final

from stability.analysis.acceleration_margin import tilt
from stability.analysis.building_order import BuildingOrder
from stability.analysis.removal_order import EarliestFall, LongestOrder, Pull
from stability.analysis.repair import BrickShift, Propping, SeveralShifts
from stability.problem import Stability
from stackdsl.judging.proofs import BearingSurvival, Survival
from stackdsl.judging.remedies import HeavierBrick, MoreFriction, Suggestion
from stackdsl.report.statics import counterweight_text, friction_text, later_text, weakest_json, weakest_text
from stackdsl.report.study_table import StudyTable, rows_within
from stackdsl.report.warnings import levels_told
from stackdsl.shown_text import visible
from stackdsl.studies.find_limit import End, FoundLimit, Want
from stackdsl.studies.sensitivities import Effect, MarginKind, Sensitivities, SlopeSource

if TYPE_CHECKING:  # these import scipy
    from stackdsl.judging.statistics import Interval
    from stackdsl.studies.fragility_curve import CurvePoint, Fragility
    from stackdsl.studies.sweep import SweptCase

# A fragility curve as text, CSV and JSON.


PERCENT = 100.0
FRAGILITY_COLUMNS = ("value", "unit", "fell", "unknown", "samples", "share", "low", "high", "decided")


def fragility_lines(name: str, fragility: "Fragility") -> Iterator[str]:
    """Yield points, curve and remarks on them."""
    yield name
    unit, sure = fragility.intensity.shown_unit, f"{PERCENT * fragility.confidence:.6g} %"
    heading = f"{fragility.intensity.name}{f' [{unit}]' if unit else ''}"
    yield f"  {heading:>20}  share that falls, with its {sure} confidence interval"
    for point in fragility.points:
        yield f"  {_number(fragility, point.value):>20}  {_share(point)}  {_counts(point)}"
    yield from (f"  {line}" for line in _curve_lines(fragility, unit, sure))
    judged = sum(point.count for point in fragility.points)
    if fragility.intensity.is_shaking and fragility.points:
        judged = fragility.points[0].count
    if judged:
        each = 1000.0 * fragility.cpu_time / judged
        yield f"  {judged} verdicts in {fragility.cpu_time:.2f} s of CPU time, {each:.3g} ms each"


def _curve_lines(fragility: "Fragility", unit: str, sure: str) -> Iterator[str]:
    curve = fragility.curve
    if fragility.fell_built:
        yield f"{fragility.fell_built} samples fell during the build; the curve describes the others"
    if curve is None:
        yield f"no lognormal curve: {fragility.no_curve}"
    else:
        median, dispersion = _between(fragility, curve.median_within), _plain_interval(curve.dispersion_within)
        how = "" if curve.rises else ", decreasing: fewer samples fall at larger values"
        yield (
            f"lognormal: median {_number(fragility, curve.median)} {unit}".rstrip()
            + f" ({median}), dispersion {curve.dispersion:.4g} ({dispersion}){how}; {sure} confidence intervals"
        )
    if fragility.half is not None:
        whose = "the samples" if fragility.intensity.is_shaking else "the points"
        yield f"half fall at {_number(fragility, fragility.half)} {unit}".rstrip() + f", from {whose} alone"
    if fragility.left_out:
        yield f"{fragility.left_out} undecided verdicts are left out of the curve"
    if missed := fragility.missed:
        where = ", ".join(_number(fragility, point.value) for point in missed)
        yield f"the curve is outside the interval of {len(missed)} of {len(fragility.points)} points: {where}"


def _number(fragility: "Fragility", value: float) -> str:
    return f"{fragility.intensity.shown(value):.4g}"


def _share(point: "CurvePoint") -> str:
    within = point.within
    return f"{PERCENT * point.share:6.2f} %  {PERCENT * within.low:6.2f} .. {PERCENT * within.high:6.2f} %"


def _counts(point: "CurvePoint") -> str:
    open_ones = f", {point.unknown} undecided" if point.unknown else ""
    return f"{point.fell:>6} of {point.count}{open_ones}  ({_decided(point)})"


def _decided(point: "CurvePoint") -> str:
    return ", ".join(f"{count} {way}" for way, count in sorted(point.ways.items(), key=lambda each: -each[1]))


def _between(fragility: "Fragility", within: "Interval") -> str:
    return f"{_number(fragility, within.low)} .. {_number(fragility, within.high)}"


def _plain_interval(within: "Interval") -> str:
    return f"{within.low:.4g} .. {within.high:.4g}"


def fragility_table(curves: "Sequence[tuple[str, Fragility]]") -> StudyTable:
    """Return a row for each point; JSON has the curve as well, `null` where there is none."""
    rows = [
        {"case": name, "over": fragility.intensity.name, **_fragility_row(fragility, point)}
        for name, fragility in curves
        for point in fragility.points
    ]
    details = [{"case": name, **as_values(fragility)} for name, fragility in curves]
    return StudyTable(("case", "over", *FRAGILITY_COLUMNS), rows, details)


def as_values(fragility: "Fragility") -> dict[str, Any]:
    """Return a fragility curve as plain values."""
    curve = fragility.curve
    fitted = None
    if curve is not None:
        fitted = {
            "median": _rounded(fragility.intensity.shown(curve.median)),
            "median_within": [_rounded(fragility.intensity.shown(end)) for end in _ends(curve.median_within)],
            "dispersion": _rounded(curve.dispersion),
            "dispersion_within": [_rounded(end) for end in _ends(curve.dispersion_within)],
            "rises": curve.rises,
        }
    return {
        "over": fragility.intensity.name,
        "unit": fragility.intensity.shown_unit,
        "seed": fragility.seed,
        "confidence": fragility.confidence,
        "points": [
            {**_fragility_row(fragility, point), "decided": dict(sorted(point.ways.items()))}
            for point in fragility.points
        ],
        "lognormal": fitted,
        "no_lognormal": fragility.no_curve,
        "half": _rounded(fragility.intensity.shown(fragility.half)) if fragility.half is not None else None,
        "fell_built": fragility.fell_built,
        "left_out": fragility.left_out,
        "missed": [_rounded(fragility.intensity.shown(point.value)) for point in fragility.missed],
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


DIGITS: Final = (6, 10)  # of a limit: at least and at most
NUMBERS: Final = ("stands", "beyond", "written", "low", "high")
LIMIT_COLUMNS: Final = (
    *("case", "want", "name", "end", "stands", "beyond", "unit", "stands_si", "beyond_si", "written", "low", "high"),
    *("by_program", "verdicts", "is_open", "judged", "bricks", "place", "why"),
)


def limit_lines(finding: FoundLimit) -> Iterator[str]:
    """Yield the limit of a case and its certainty."""
    yield finding.case
    yield f"  {_limit(finding)}"
    if finding.end in (End.LIMIT, End.NOWHERE) and finding.why:
        when = "" if not finding.moment else f", at the placement at {finding.moment:g} s"
        yield f"    fall: {finding.why}{when}"
    if finding.end is End.OPEN:
        yield f"    undecided: {finding.why}"
    yield from (f"    {line}" for line in _remarks(finding))


def _limit(finding: FoundLimit) -> str:
    asked, stands = f"{finding.want} {finding.name}", _text(finding, finding.stands)
    match finding.end:
        case End.LIMIT:
            return f"{asked}: {stands} stands, {_text(finding, finding.beyond)} falls"
        case End.EDGE:
            return f"{asked}: {stands} stands, {_text(finding, finding.beyond)} is invalid: {finding.why}"
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
    if finding.written is not None:
        where = f" at {finding.place}" if finding.place else ""
        yield f"instead of {_text(finding, finding.written)}{where}" + (f"; {finding.others}" * bool(finding.others))
    if finding.by_program and finding.written is None:
        yield "for the finished structure, proven by contact forces on one side and by a motion on the other"
    elif finding.written is not None and finding.end is not End.NOTHING:
        how = "computed by optimization and verified on both sides; " if finding.by_program else ""
        least, most = _text(finding, finding.low), _text(finding, finding.high)
        yield f"{how}{finding.verdicts} verdict{'s' * (finding.verdicts > 1)}, from {least} to {most}"
    if finding.is_open:
        yield "values in between are undecided: they are too close to the limit"
    if finding.contradicting:
        yield f"this is not the only limit: {', and '.join(_contradicting(finding))}"
    if finding.judged < finding.bricks and finding.stands is not None:
        yield f"for {finding.judged} of {finding.bricks} bricks; the later ones depend on an engine and are left out"


def _contradicting(finding: FoundLimit) -> Iterator[str]:
    """Yield numbers whose verdict contradicts their side of the limit."""
    for answer, group in groupby(finding.contradicting, key=lambda each: each[1]):
        values = [_text(finding, value) for value, _ in group]
        ends = (
            f" with each of {len(values)} values from {values[0]} to {values[-1]}"
            if len(values) > 1
            else f" at {values[0]}"
        )
        yield f"it {answer} also{ends}"


def _text(finding: FoundLimit, value: float | None) -> str:
    if value is None:
        return "none"
    return f"{value:.{_digits(finding)}g} {finding.unit}".rstrip()


def _digits(finding: FoundLimit) -> int:
    """Return the digits that tell both sides of a limit apart."""
    least, most = DIGITS
    if finding.stands is None or finding.beyond is None or finding.stands == finding.beyond:
        return least
    size = max(abs(finding.stands), abs(finding.beyond))
    return min(most, max(least, ceil(log10(size / abs(finding.stands - finding.beyond))) + 2))


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


UNITS: Final = {MarginKind.ACCELERATION: "g", MarginKind.FRICTION: ""}
HOW: Final = {
    SlopeSource.CHECKED: "confirmed by finite differences",
    SlopeSource.DUALS: "not checked by finite differences",
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


def sensitivity_lines(found: Sensitivities, most: int) -> Iterator[str]:
    """Yield the margin and a line for each number that it depends on, the largest effect first."""
    yield found.case
    unit = UNITS[found.of]
    what = "least friction" if found.of is MarginKind.FRICTION else "acceleration"
    yield f"  {what} {found.margin:.4g} {unit}".rstrip() + "; largest change if a number changes by 1 %:"
    shown = [each for each in found.effects if each.counts][:most]
    width = max((len(each.what) for each in shown), default=0)
    for each in shown:
        yield f"    {each.what:<{width}}  {each.matters:>10.3g} {unit:<1}  {_slopes(each, unit)}; {HOW[each.source]}"
    rest = sum(each.counts for each in found.effects) - len(shown)
    if rest:
        yield f"    and {rest} more"
    nothing = [each for each in found.effects if not each.counts]
    if nothing:
        by_forces = sum(each.source is SlopeSource.DUALS for each in nothing)
        checked = ", none of them checked by finite differences" if by_forces == len(nothing) else ""
        unchecked = checked or (f", {by_forces} of them not checked by finite differences" if by_forces else "")
        yield f"    {len(nothing)} of {len(found.effects)} numbers have no effect{unchecked}"
    if found.in_doubt:
        yield "    forces or motions at the limit are not unique: unchecked values may be wrong; --check N checks more"
    if found.judged < found.bricks:
        yield f"  for {found.judged} of {found.bricks} bricks; the later ones depend on an engine and are left out"


def _slopes(effect: Effect, unit: str) -> str:
    per = f" {unit}/{effect.unit}" if unit and effect.unit else (f" {unit}" if unit else f" 1/{effect.unit}")
    per = per if unit or effect.unit else ""
    if not effect.has_kink:
        assert effect.more is not None
        return f"{effect.more:+.4g}{per}"
    less, more = ("no margin" if each is None else f"{each:+.4g}{per}" for each in (effect.less, effect.more))
    return f"{less} below and {more} above"


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
    """Yield one line for neighbouring bearings with the same failure, and the value for all bearings."""
    yield name
    worst = survival.worst
    if worst.survived == inf:
        yield "  survives every acceleration in every direction, since it is held on all sides"
        return
    first = survival.weakest
    if first is None:
        yield (
            f"  survives {worst.survived:.4g} g along these bearings, or a tilt of {degrees(worst.tilt):.4g} deg;"
            f" least towards {degrees(worst.bearing):.4g} deg"
        )
    else:
        told = degrees(tilt(first.acceleration))
        yield f"  survives {first.acceleration:.4g} g in every direction, or a tilt of {told:.4g} deg"
        yield f"  {weakest_text(first)}"
    for rows in _alike(survival.along):
        yield f"  {_span(rows):>20}  {_range([row.survived for row in rows]):>16} g  {rows[0].gives_way}".rstrip()


def _alike(along: Sequence[BearingSurvival]) -> list[list[BearingSurvival]]:
    """Return groups of neighbouring bearings with the same failure; the group around +x comes first."""
    runs = [list(rows) for _, rows in groupby(along, key=lambda each: each.gives_way)]
    if len(runs) > 1 and runs[0][0].gives_way == runs[-1][0].gives_way:
        runs = [[*runs[-1], *runs[0]], *runs[1:-1]]
    return runs


def _span(rows: Sequence[BearingSurvival]) -> str:
    first, last = (f"{degrees(row.bearing):.4g}" for row in (rows[0], rows[-1]))
    return f"towards {first} deg" if len(rows) == 1 else f"{first} to {last} deg"


def _range(values: Sequence[float]) -> str:
    least, most = f"{min(values):.4g}", f"{max(values):.4g}"
    return least if least == most else f"{least} .. {most}"


def survival_table(survivals: Sequence[tuple[str, Survival]]) -> StudyTable:
    """Return a row for each bearing; empty or `null` where nothing gives way."""
    cases = [
        {
            "case": name,
            "survives_g": _finite_margin(
                (survival.weakest and survival.weakest.acceleration) or survival.worst.survived
            ),
            "weakest": None if survival.weakest is None else weakest_json(survival.weakest),
            "bearings": [*map(_survival_row, survival.along)],
        }
        for name, survival in survivals
    ]
    return StudyTable(("case", *SURVIVAL_COLUMNS), rows_within(cases, "bearings"), cases)


def _survival_row(each: BearingSurvival) -> dict[str, float | str | None]:
    numbers = (degrees(each.bearing), each.survived, each.fails, degrees(each.tilt))
    return dict(zip(SURVIVAL_COLUMNS, (*map(_finite_margin, numbers), each.gives_way), strict=True))


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
FEW: Final = 3  # shown reasons of failures


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
            yield f"  share that stands: {100.0 * stands.low:.4g} .. {100.0 * stands.high:.4g} %, {sure}"
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


ALONG = {0: "+x", 90: "+y", 180: "-x", -180: "-x", -90: "-y"}  # [deg]


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
        case Propping(bricks, later):
            props = f"permanent prop{'s' * (len(bricks) > 1)} under {', '.join(bricks)}"
            return props + later_text(later)


def _shift(shift: tuple[float, float]) -> str:
    """Return a shift rounded up to five digits, so that it suffices."""
    bearing = round(degrees(atan2(shift[1], shift[0])), 2)
    towards = ALONG.get(int(bearing)) if bearing == int(bearing) else None
    return f"{1e3 * hypot(*shift):.5g} mm towards {towards or f'{bearing:g} deg'}"


# Pulls and building orders as text; the rows of their tables are the same for CSV and JSON.


ANSWERS = {Stability.STABLE: "stands", Stability.UNSTABLE: "falls", Stability.UNDECIDED: "not proven"}


def pull_row(pull: Pull) -> dict[str, Any]:
    """Return the row of a brick that was pulled out of the whole structure."""
    verdict = pull.verdict
    why = verdict.reason or (f"{verdict.stage}" if verdict.stage is not None else "")
    return {"brick": pull.brick, "carries": pull.carries, "rest": ANSWERS[verdict.stability], "proof": why}


def pull_lines(pulls: Sequence[Pull]) -> Iterator[str]:
    """Yield the number of removable bricks, and each with its proof."""
    counts = {answer: sum(p.verdict.stability is answer for p in pulls) for answer in ANSWERS}
    told = ", ".join(f"{count} {ANSWERS[answer]}" for answer, count in counts.items() if count)
    yield f"  remaining structure after each single pull: {told}"
    width = max(len(pull.brick) for pull in pulls)
    for row in map(pull_row, pulls):
        over = "" if row["carries"] else ", carries nothing"
        yield f"    {row['brick']:<{width}}  {row['rest']}{': ' * bool(row['proof'])}{row['proof']}{over}"


def longest_lines(longest: LongestOrder) -> Iterator[str]:
    """Yield the longest order of removals."""
    if longest.proven:
        bound = "proven that no order is longer"
    else:
        bound = f"proven that no order is longer than {longest.at_most}"
        bound += f" ({longest.reason})" if longest.reason else ""
    yield f"  longest order of pulls after which the rest always stands: {len(longest.order)}; {bound}"
    if longest.order:
        yield f"    {', '.join(longest.order)}"


def soonest_line(soonest: EarliestFall) -> str:
    """Return the order of removals with the earliest fall."""
    if not soonest.order:
        return (
            f"  no {soonest.at_least - 1} pulls make it fall" if soonest.at_least > 1 else "  no worst case was found"
        )
    count = len(soonest.order)
    bound = "proven that fewer do not suffice" if soonest.at_least == count else "a shorter one may exist"
    return f"  shortest order of pulls that makes it fall: {count} ({', '.join(soonest.order)}); {bound}"


def order_rows(order: BuildingOrder) -> list[dict[str, Any]]:
    """Return a row for each step."""
    return [
        {"step": n, "brick": step.brick, "prop": step.propped, "struck": " ".join(step.struck)}
        for n, step in enumerate(order.steps, 1)
    ]


def order_lines(order: BuildingOrder, interrupted: bool = False) -> Iterator[str]:
    """Yield a building order and its props; after an interrupt, the best by then."""
    unpropped = order.without is not None and order.without.order is not None
    if interrupted:
        yield "  interrupted: the best result so far"
    if not order.steps:
        if order.impossible:
            yield "  proven that no order exists"
        elif order.props_at_least:
            yield f"  no order was found; proven that an order needs at least {order.props_at_least} props"
        else:
            yield "  no order was found, and it is not proven that none exists"
        return
    if unpropped:
        yield f"  all {len(order.steps)} bricks can be set down one at a time, without props"
    else:
        yield from _props(order, interrupted)
    yield from _steps(order)


def _props(order: BuildingOrder, interrupted: bool) -> Iterator[str]:
    proven = order.without is not None and order.without.impossible
    yield "  proven that no order without props exists" if proven else "  no order without props was found"
    count = len(order.props)
    least = "proven" if order.props_at_least == count else f"at least {order.props_at_least} are needed"
    what = "props so far" if interrupted else "fewest props"
    yield f"  {what}: {count} in total ({least}), at most {order.props_at_once} at a time"


def _steps(order: BuildingOrder) -> Iterator[str]:
    for row in order_rows(order):
        prop = "  with a prop under it" if row["prop"] else ""
        struck = f"; then remove the prop under {row['struck'].replace(' ', ', ')}" if row["struck"] else ""
        yield f"  {row['step']:4}  {row['brick']}{prop}{struck}"
