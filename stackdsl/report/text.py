"""The report of a check or a run as text."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import degrees, isfinite

from stability.name_order import in_order
from stability.statics.fall_description import FallSide
from stackdsl.report.blocks import Block, Row, Table, blocks_text, line, table, titled
from stackdsl.report.diagnostics import GUTTER, diagnostic_text
from stackdsl.report.warnings import (
    modified_text,
    passed_text,
    passed_through,
    samples_told,
    wrong_edges,
    wrong_edges_text,
    wrong_friction_text,
    wrong_frictions,
)
from stackdsl.results import (
    GOLDEN_FAILURES,
    REFERENCE_SYSTEM,
    Change,
    ClaimOutcome,
    EarlyEndSummary,
    FailureCause,
    GoldenStatus,
    Report,
    RunStatus,
    Seen,
    VariantResult,
)
from stackdsl.shown_text import visible
from stackdsl.trace import UNRELIABLE, BrickState, Collapse, Event, EventKind, Trace
from stackdsl.wording import broke_text, energy_fault, how_many, level_text, mm, names_text, shortened, touching_text

# One expectation as one line: the expected and the measured value, and the margin to the threshold.
#
# Also the line for a run without expectations.


TO_CLAIM = "add an expectation under `expect`, such as `- stands: all` or `- collapses: any`"


def outcome_text(outcome: ClaimOutcome) -> str:
    """Return the text of an outcome, without place and verdict."""
    margin = f" (margin {significant(outcome.margin)} {outcome.unit}".rstrip() + ")" if isfinite(outcome.margin) else ""
    return f"{outcome.name}: expected {outcome.expected}, measured {outcome.measured}{margin}"


def unchecked_text(result: VariantResult) -> str:
    """Return the text for a run without expectations, which says whether it fell."""
    if result.ensemble is not None:
        return f"no expectations; {result.ensemble.summary}"
    if result.collapse is None:
        return "no expectations"
    fell = result.collapse
    where = level_text(fell.level, fell.step)
    return f"it fell at {where} ({fell.brick} at {fell.time:.3f} s), without expectations"


def significant(value: float) -> str:
    """Format a number with three significant digits, without an exponent if possible."""
    return f"{float(f'{value:.3g}') + 0.0:g}"  # a zero has no sign


# One observation of two runs as one line.


NO_VALUE = "none"


def change_text(change: Change) -> str:
    """Return an observation, that of the other run, and the difference of numbers."""
    difference = change.difference
    by = f" ({'+' if difference > 0.0 else ''}{significant(difference)} {change.unit})" if difference else ""
    return f"{change.name}: {_seen(change.before, change.unit)} -> {_seen(change.after, change.unit)}{by}"


def _seen(value: Seen, unit: str) -> str:
    match value:
        case float():
            return f"{significant(value)} {unit}"
        case tuple():
            names, more = shortened(value)
            return ", ".join((*names, *([f"{more} more"] if more else []))) or NO_VALUE
        case _:
            return value or NO_VALUE


# One event of a run as one line.


def event_text(event: Event, all_names: bool = False) -> str:
    """Return time, kind, bricks and reason of an event; with `all_names` every brick is named."""
    bricks = event.bricks if event.kind is EventKind.PLACED else in_order(event.bricks)
    named = ", ".join(bricks) if all_names else names_text(bricks, least=1)
    reason = f": {event.reason}" if event.reason else ""
    return f"{event.time:9.3f} s  {event.kind.value:<9}  {named}{reason}"


# Direction of a fall in words.


AXES = {0: "+x", 90: "+y", 180: "-x", 270: "-y"}  # by bearing [deg]
ROUNDED = 0.05  # [deg] a bearing within this of an axis counts as along it


def side_text(side: FallSide) -> str:
    """Return text such as `towards +x, its weight 1.2 mm beyond the edge`; empty if unknown."""
    told = [f"towards {bearing_text(side.bearing)}"] if side.bearing is not None else []
    told += [f"its weight {mm(side.overhang, 3)} beyond the edge"] if side.overhang is not None else []
    return ", ".join(told)


def bearing_text(bearing: float) -> str:
    """Return a bearing [rad] as the name of an axis, or in degrees from +x towards +y."""
    angle = degrees(bearing) % 360.0
    nearest = 90 * round(angle / 90.0)
    return AXES[nearest % 360] if abs(angle - nearest) <= ROUNDED else f"{angle:.1f} deg"


# Cause of a failed run, in a few lines.


def why_lines(why: FailureCause) -> Iterator[str]:
    """Yield one line for each known fact about the cause."""
    told = {
        "cause": cause_text(why),
        "after": why.before,
        "first": why.first,
        "see": why.see,
    }
    yield from (f"  {name:<5}  {text}" for name, text in told.items() if text)


def cause_text(why: FailureCause) -> str:
    """Return cause and direction on one line; empty if unknown."""
    return ", ".join(filter(None, [why.cause, side_text(FallSide(why.bearing, why.overhang))]))


# Text for a run that ended early.


def ending_text(early: EarlyEndSummary) -> str:
    """Return the time of the end and the actions that were left out."""
    left_out = early.actions
    undone = f"; {left_out} later action{'s' * (left_out > 1)} left out" if left_out else ""
    return f"ended at {early.time:.3f} s of {early.planned:.3f} s, as every claim is decided{undone}"


# The report as text: mistakes, a table with one row per variant, failures, and one line of totals.


NOTHING = "-"
USUAL_ENGINE = "pybullet"  # needs no column
TWO_KINDS = "split the scenario in two, or add `strict: false`"
MOST_DIFFERENCES = 100  # shown differences of one golden file; a fallen tower has ten thousand
LEFT = ("scenario", "variant", "verdict", "engine", "truth", "golden")  # columns of words; numbers stand to the right
DISPENSABLE = (
    "engine",
    "level",
    "still moving",
    "truth",
    "golden",
    "moved",
    f"vs {REFERENCE_SYSTEM}",
)  # columns omitted if no row has a value


def report_text(
    report: Report, width: int = 120, colour: bool = False, *, verbosity: int = 0, durations: int = 0
) -> str:
    """Return the whole report. Tables keep to `width` [characters] if words are short enough; other lines do not wrap.

    Failures come first, then notes. `verbosity` -1 leaves out notes and the table; 1 adds passed expectations and notes
    on runs without claims. `durations` is the number of slowest cases to list.
    """
    parts = [*_failures(report, verbosity), *(_notes(report, verbosity) if verbosity >= 0 else ())]
    blocks = [*filter(None, [*parts, _slowest(report, durations)]), [line(closing_line(report))]]
    return blocks_text(blocks, width, colour)


def closing_line(report: Report) -> str:
    """Return the sums in one line."""
    goldens = {"obsolete golden file": len(report.obsolete), "removed golden file": len(report.removed)}
    extras = {"mistake": len(report.diagnostics), **goldens}
    known = sum(result.remembered and not result.unchecked for result in report.results)
    conclusions = dict(report.conclusions)
    if known and (passed := conclusions.pop("passed")):
        conclusions = {f"passed ({known} remembered)": passed} | conclusions
    sums = [f"{count} {conclusion}" for conclusion, count in conclusions.items() if count]
    sums += [how_many(count, what) for what, count in extras.items() if count]
    sums += [f"{report.left} not run after a failure"] if report.left else []
    sums += ["interrupted"] if report.interrupted else []
    ran = f"{how_many(report.scenarios, 'scenario')}, {how_many(len(report.results), 'variant')}"
    return f"{ran}: {', '.join(sums) or 'no cases run'} in {report.wall_time:.1f} s"


def _failures(report: Report, verbosity: int) -> Iterator[Block]:
    """Yield the blocks below the table: failures, warnings, and work to do."""
    yield _diagnostics(report)
    yield [_summary(report)] if report.results and verbosity >= 0 else []
    yield _blocked(report)
    stopped = [result for result in report.results if _stopped(result)]
    yield titled("Did not finish", [f"{r.file}: {r.name}: {r.status}: {r.message}" for r in stopped])
    yield titled("Failed expectations", list(_failed(report)))
    yield from _unchecked(report)
    odd = dict.fromkeys(str(each) for result in report.results for each in result.warnings)
    yield titled("Warnings", list(odd))
    yield titled("Expected failures (xfail)", list(_xfailed(report)))
    yield titled("Unexpected passes (xfail)", list(_xpassed(report)))
    yield titled("Changes at half the time step and twice the iterations", list(_moved(report)))
    yield from (_differences(result) for result in report.results)
    yield titled("Golden files", list(_golden_files(report)))
    yield titled("Passed expectations", list(_met(report)) if verbosity > 0 else [])


def _notes(report: Report, verbosity: int) -> Iterator[Block]:
    """Yield warnings that fail nothing; those on the accuracy of a run only if it has expectations."""
    noted = [result for result in report.results if verbosity > 0 or result.outcomes or result.truths]
    early = [(result.name, result.early_end) for result in report.results if result.early_end is not None]
    shown = {result.name for result in report.results if verbosity > 0 or not result.passed or result.golden_failed}
    gained = [result for result in report.results if result.energy_gained]
    yield titled("Skipped", list(_skipped(report)))
    standing = [r.name for r in report.results if r.unchecked and not r.fell and not r.must_claim]
    yield titled(f"Unchecked: {TO_CLAIM}", [names_text(standing)] if standing else [])
    yield titled("Samples", list(samples_told(report.results)))
    yield titled("Modified scenes", list(_modified(report)))
    yield titled("Ended early", [f"{name}: {ending_text(end)}" for name, end in early if name in shown])
    yield titled("Numerical collapses", [f"{r.name}: {r.numerical}" for r in report.results if r.numerical])
    yield titled("Stable only if gaps count as contact", [gaps_text(r) for r in noted if r.touching_within])
    yield titled("Energy added by the engine", [f"{r.name}: {energy_fault(r.energy_gained)}" for r in gained])
    yield titled("Wrong edge normals", list(wrong_edges(noted)))
    yield titled("Wrong friction in the engine", list(wrong_frictions(noted)))
    yield titled("Thrown bricks that passed through others", list(passed_through(report.results)))
    yield titled("Different from the reference (truth)", list(_missed(report, lambda result: result.truths)))
    yield titled(
        "Golden files of another engine, compared only in results that do not depend on the engine",
        list(_noted(report, GoldenStatus.OTHER_ENGINE)),
    )
    yield titled("Golden files made with other versions", list(_stamps(report)))


def gaps_text(result: VariantResult) -> str:
    """Return the gaps that a verdict of statics depends on."""
    return f"{result.name}: stable{touching_text(result.touching_within)}"


def _slowest(report: Report, count: int) -> Block:
    """Return the slowest cases, with their times when played."""
    timed = [(result.cost.wall_time, result) for result in report.results if result.cost is not None]
    slowest = sorted(timed, key=lambda pair: -pair[0])[:count]
    return titled("Slowest", [f"{time:.2f} s  {result.name}{_when(result)}" for time, result in slowest])


def _when(result: VariantResult) -> str:
    return " (remembered)" if result.remembered else ""


def _met(report: Report) -> Iterator[str]:
    for result in report.results:
        for outcome in result.outcomes:
            if outcome.passed:
                yield f"{outcome.span}: {result.name}: {outcome_text(outcome)}"


def _diagnostics(report: Report) -> Block:
    texts = [diagnostic_text(found) for found in report.diagnostics]
    return [line("\n\n".join(texts))] if texts else []


def _summary(report: Report) -> Table:
    rows = [_row(report, result) for result in report.results]
    idle = {name for name in DISPENSABLE if all(row[name] == NOTHING for row in rows)}
    return table([{name: cell for name, cell in row.items() if name not in idle} for row in rows], LEFT)


def _row(report: Report, result: VariantResult) -> Row:
    cost = result.cost
    return {
        "scenario": result.scenario,
        "variant": result.variant,
        "verdict": result.verdict if result.status is RunStatus.DONE else result.status.value,
        "engine": result.engine if result.engine not in ("", USUAL_ENGINE) else NOTHING,
        "level": str(result.collapse.level) if result.collapse else NOTHING,
        "drift mm": significant(1000.0 * result.drift) if result.is_one_run else NOTHING,
        "still moving": str(len(result.moving)) if result.moving else NOTHING,
        "met": f"{result.met}/{len(result.outcomes)}" if result.outcomes else NOTHING,
        "truth": {None: NOTHING, True: "agrees", False: "differs"}[result.truth_agrees],
        "golden": result.golden.status.value if result.golden else NOTHING,
        "moved": NOTHING if result.refinement is None else f"{len(result.moved)}/{len(result.refinement)}",
        "wall s": f"{cost.wall_time:.2f}" if cost else NOTHING,
        "sim. s": f"{cost.simulated_time:.1f}" if result.is_one_run and cost else NOTHING,
        "steps": str(cost.steps) if result.is_one_run and cost else NOTHING,
        f"vs {REFERENCE_SYSTEM}": _factor(report.speed_up(result)),
    }


def _factor(value: float | None) -> str:
    return f"{significant(value)}x" if value is not None else NOTHING


def _modified(report: Report) -> Iterator[str]:
    """Yield one line for each modification, with the names of its cases."""
    names: defaultdict[str, list[str]] = defaultdict(list)
    for result in report.results:
        if result.modified:
            names[result.modified].append(result.name)
    yield from (f"{modified_text(modified)}: {', '.join(played)}" for modified, played in names.items())


def _moved(report: Report) -> Iterator[str]:
    for result in report.results:
        yield from (f"{result.name}: {change_text(change)}" for change in result.moved)
    if report.results and all(result.refinement is not None and not result.moved for result in report.results):
        yield "no changes"


def _blocked(report: Report) -> Block:
    """Return the mistakes that blocked runs; runs with the same text share it."""
    told: defaultdict[str, list[str]] = defaultdict(list)
    for result in report.results:
        if result.mistake is not None:
            told[diagnostic_text(result.mistake)].append(result.name)
    texts = [line(f"{text}\n{'':{GUTTER}} = in {', '.join(names)}") for text, names in told.items()]
    return [line("Blocked", "bold"), *texts] if texts else []


def _skipped(report: Report) -> Iterator[str]:
    """Yield one line for each reason, with the names of the cases that were not played."""
    names: defaultdict[str, list[str]] = defaultdict(list)
    for result in report.results:
        if result.status is RunStatus.SKIPPED:
            names[result.message].append(result.name)
    yield from (f"{message}: {', '.join(skipped)}" for message, skipped in names.items())


def _stopped(result: VariantResult) -> bool:
    return result.status in (RunStatus.CRASHED, RunStatus.TIMED_OUT)


def _failed(report: Report) -> Iterator[str]:
    """Yield expected and measured values of each failed run, with the cause below."""
    for result in report.results:
        if result.xfail is None and not result.unchecked:
            yield from _missed(replace(report, results=(result,)), lambda each: each.outcomes)
            if result.why is not None:
                yield from why_lines(result.why)


def _unchecked(report: Report) -> Iterator[Block]:
    """Yield runs without expectations that fell, with their causes; with `--strict` all runs without expectations."""
    for title, must_claim in (("Unchecked cases, failed by --strict", True), ("Unchecked cases that fell", False)):
        told = [r for r in report.results if r.unchecked and r.must_claim is must_claim and (r.fell or must_claim)]
        yield titled(f"{title}: {TO_CLAIM}", [text for result in told for text in _unchecked_lines(result)])


def _unchecked_lines(result: VariantResult) -> Iterator[str]:
    yield f"{result.file}: {result.name}: {unchecked_text(result)}"
    if result.why is not None:
        yield from why_lines(result.why)


def _xfailed(report: Report) -> Iterator[str]:
    for result in report.results:
        if result.xfail is not None and result.status is RunStatus.DONE and not result.passed:
            missed = [outcome_text(outcome) for outcome in result.outcomes if not outcome.passed]
            yield f"{result.name}: {result.xfail}: {'; '.join(missed)}"


def _xpassed(report: Report) -> Iterator[str]:
    for result in report.results:
        if result.xfail is not None and result.passed:
            mixed = any(each.scenario == result.scenario and each.xfail and not each.passed for each in report.results)
            sure = f"other variants fail: {TWO_KINDS}" if mixed else "remove `xfail`"
            advice = sure if result.strict else "`xfail` is not strict, so this does not fail the check"
            yield f"{result.file}: {result.name}: {result.xfail}: {advice}"


def _missed(report: Report, outcomes_of: Callable[[VariantResult], Sequence[ClaimOutcome]]) -> Iterator[str]:
    for result in report.results:
        for outcome in outcomes_of(result):
            if not outcome.passed:
                yield f"{outcome.span}: {result.name}: {outcome_text(outcome)}"


def _differences(result: VariantResult) -> Block:
    if result.golden is None or not result.golden.differences:
        return []
    rows = [
        {
            "brick": difference.subject,
            "quantity": difference.quantity,
            "expected": difference.expected,
            "got": difference.got,
            "tolerance": difference.tolerance,
        }
        for difference in result.golden.differences[:MOST_DIFFERENCES]
    ]
    moved = "Rewritten" if result.golden.status is GoldenStatus.WRITTEN else "Different from"
    left_out = len(result.golden.differences) - len(rows)
    rest = [line(f"and {how_many(left_out, 'more difference')}; --format json lists all")] if left_out else []
    return [line(f"{moved} {result.golden.file}", "bold"), table(rows, left=tuple(rows[0])), *rest]


def _golden_files(report: Report) -> Iterator[str]:
    """Yield pending work on golden files, with the command for it."""
    goldens = [result.golden for result in report.results if result.golden is not None]
    for status in (GoldenStatus.MISSING, GoldenStatus.NEW):
        yield from _together([golden.file for golden in goldens if golden.status is status and not golden.note], status)
    for golden in goldens:
        alone = golden.status not in (GoldenStatus.MISSING, GoldenStatus.NEW) or golden.note
        if golden.status in (*GOLDEN_FAILURES, GoldenStatus.WRITTEN) and alone:
            yield f"{golden.file}: {golden.status}" + (f": {golden.note}" if golden.note else "")
    yield from (f"{visible(file)}: removed" for file in report.removed)
    yield from (f"{visible(file)}: obsolete, no variant uses this file" for file in report.obsolete)
    if failing := sum(result.golden_failed and not result.may_be_locked for result in report.results):
        what = "1 of these results fails" if failing == 1 else f"{failing} of these results fail"
        yield f"{what} expectations; only --update --accept-failing would accept {'it' if failing == 1 else 'them'}"
    if report.accept:
        yield f"accept{', and remove obsolete files,' if report.obsolete else ''} with: {report.accept}"


def _together(files: Sequence[str], status: GoldenStatus) -> Iterator[str]:
    """Yield files without further remarks on one line."""
    if len(files) == 1:
        yield f"{files[0]}: {status}"
    elif files:
        yield f"{len(files)} {status}: {names_text(files)}"


def _stamps(report: Report) -> Iterator[str]:
    """Yield one line for each set of versions."""
    yield from _noted(report, GoldenStatus.SAME)


def _noted(report: Report, status: GoldenStatus) -> Iterator[str]:
    alike = [r.golden for r in report.results if r.golden is not None and r.golden.status is status]
    notes = Counter(golden.note for golden in alike if golden.note)
    yield from (f"{how_many(count, 'file')} {note}" for note, count in sorted(notes.items()))


# Result of one run as text: outcome and cost, then each claim with its measured value.


def run_text(trace: Trace, result: VariantResult, all_names: bool = False) -> str:
    """Return lines of text without a final newline; with `all_names` every brick is named."""
    return "\n".join(_lines(trace, result, all_names))


def _lines(trace: Trace, result: VariantResult, all_names: bool) -> Iterator[str]:
    fell = "" if trace.collapse is None else _collapse(trace.collapse)
    cost = f"{trace.cost.simulated_time:g} s simulated in {trace.cost.wall_time:.3f} s, {trace.cost.steps} steps"
    came = f"{UNRELIABLE}: " * trace.unreliable + (fell or trace.verdict)
    yield f"{came}; {cost}" + (f"; a numerical collapse: {trace.numerical}" * bool(trace.numerical))
    yield from (f"warning: {odd}" for odd in result.warnings)
    if result.modified:
        yield modified_text(result.modified)
    fallen = [name for name, track in trace.tracks.items() if track.state is BrickState.FALLEN]
    if all_names and fallen:
        yield f"fallen: {', '.join(in_order(fallen))}"
    if trace.moving:
        moving = in_order(trace.moving)
        yield f"still moving at the end: {', '.join(moving) if all_names else names_text(moving)}"
    if result.early_end is not None:
        yield ending_text(result.early_end)
    if result.touching_within:
        yield f"statics: stable{touching_text(result.touching_within)}"
    if trace.energy_gained:
        yield energy_fault(trace.energy_gained)
    if trace.wrong_edges is not None:
        yield wrong_edges_text(trace.wrong_edges, trace.collapse)
    if trace.wrong_friction is not None:
        yield wrong_friction_text(trace.wrong_friction)
    if trace.passed_through is not None:
        yield passed_text(trace.passed_through)
    yield from claim_lines(result)


def _collapse(collapse: Collapse) -> str:
    at = f"collapses at {level_text(collapse.level, collapse.step)} after {collapse.time:.3f} s"
    return at + broke_text(collapse.broke, collapse.gave_way)


def claim_lines(result: VariantResult) -> Iterator[str]:
    """Yield each claim with its measured value, and the causes of failures."""
    if result.xfail is not None:
        yield f"{'unexpected pass' if result.passed else 'expected failure'} (xfail): {result.xfail}"
    for outcome in result.outcomes:
        yield f"{'passed' if outcome.passed else 'failed'}: {outcome.span}: {outcome_text(outcome)}"
    if result.why is not None:
        yield from why_lines(result.why)
    for truth in result.truths:
        yield f"truth {'agrees' if truth.passed else 'differs'}: {truth.span}: {outcome_text(truth)}"
