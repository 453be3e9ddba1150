"""The report of a check as text: green runs in one line a file, failures as blocks, and one line of sums."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from os.path import dirname
from textwrap import wrap

from stability.name_order import names_text, natural_key
from stackdsl.exits import ExitCode
from stackdsl.report.blocks import GAP, Block, Line, Row, Table, TextStyle, blocks_text, hanging, line, table, titled
from stackdsl.report.diagnostics import GUTTER, diagnostic_text
from stackdsl.report.golden_differences import difference_lines, unclear_lines
from stackdsl.report.outline import (
    MARKS,
    CaseRow,
    Group,
    Status,
    failure_lines,
    nearest,
    outline,
    result_text,
    see_line,
    status_of,
)
from stackdsl.report.text import (
    TO_CLAIM,
    change_text,
    closing_line,
    decided_text,
    ending_text,
    outcome_text,
    unchecked_text,
    why_lines,
)
from stackdsl.report.warnings import (
    modified_text,
    passed_through,
    samples_told,
    unclear_claims,
    wrong_edges,
    wrong_frictions,
)
from stackdsl.results import (
    GOLDEN_FAILURES,
    REFERENCE_SYSTEM,
    UNCHECKED,
    GoldenStatus,
    Report,
    RunStatus,
    VariantResult,
    exit_code,
)
from stackdsl.shown_text import visible
from stackdsl.wording import energy_fault, how_many, significant, touching_text

# The report as text: mistakes, a table with one row per variant, failures, and one line of totals.


NOTHING = "-"
USUAL_ENGINES = ("", "pybullet", "rigid")  # need no column
TWO_KINDS = "split the scenario in two, or add `strict: false`"
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


PLAIN = TextStyle()


def report_text(report: Report, width: int = 120, colour: bool = False, style: TextStyle = PLAIN) -> str:
    """Return the whole report. Lines keep to `width` [characters], and break between words only.

    A green report has a line for each file; one with failures has a block for each of these. Notes are counted, and
    listed with a verbosity of 1.
    """
    blocks = [*filter(None, _parts(report, width, style)), _closing(report, width)]
    return blocks_text(blocks, width, colour)


def _closing(report: Report, width: int) -> Block:
    """Return the sums, after a mark that says whether anything failed."""
    status = Status.PASSED if exit_code(report) == ExitCode.OK else Status.FAILED
    return [line(text, "bold") for text in hanging(f"{MARKS[status]} {closing_line(report)}", width)]


def _parts(report: Report, width: int, style: TextStyle) -> Iterator[Block]:
    verbose, quiet = style.verbosity > 0, style.verbosity < 0
    groups = outline(report)
    yield _diagnostics(report)
    yield [_summary(report)] if report.results and style.table else []
    if verbose:
        yield [line(text) for group in groups for row in group.rows for text in _case_lines(row, width)]
    elif not quiet and not style.table and exit_code(report) == ExitCode.OK and not report.diagnostics:
        yield [line(text) for text in _green_lines(groups, width)]
    yield _blocked(report)
    for group in groups:
        yield from _failure_blocks(group, width)
    for result in report.results:
        yield _differences(result, width, report.review)
    yield titled("Unexpected passes (xfail)", list(_xpassed(report)))
    yield titled("Changes at half the time step and twice the iterations", list(_moved(report)))
    yield titled("Runs a micrometre to either side", list(_sensitive(report)))
    yield titled("Golden files", list(_golden_files(report)))
    if verbose:
        yield titled("Passed expectations", list(_met(report)))
        yield from _notes(report)
    if not verbose:
        yield _fallen_unchecked(report)
    if not verbose and not quiet:
        yield titled("Skipped", list(_skipped(report)))
        yield titled(
            "Warnings", list(dict.fromkeys(str(each) for result in report.results for each in result.warnings))
        )
        yield [line(text) for text in _counts(report)]
    yield _slowest(report, style.durations)


# Green: one line a file, or a folder if there are many files.


MOST_FILES = 25  # lines of files; with more files, each line is a folder
NEAR = 0.5  # share of the limit within which a margin is told


def _green_lines(groups: Sequence[Group], width: int) -> Iterator[str]:
    """Yield a line for each file or folder: number of cases, the margin nearest to failing, and the time."""
    files = dict.fromkeys(group.file for group in groups)
    by_folder = len(files) > MOST_FILES

    def place(group: Group) -> str:
        return f"{dirname(group.file)}/" if by_folder else group.file

    parts: defaultdict[str, list[Group]] = defaultdict(list)
    for group in sorted(groups, key=lambda group: natural_key(place(group))):
        parts[place(group)].append(group)
    rows = [(name, _marked_counts(of), _remark(of), _time(of)) for name, of in parts.items()]
    names, counts, times = (max((len(row[at]) for row in rows), default=0) for at in (0, 1, 3))
    room = width - names - counts - times - 3 * len(GAP)
    for name, count, remark, time in rows:
        shown = remark if len(remark) <= room else ""
        yield GAP.join((name.ljust(names), count.ljust(counts), shown.ljust(max(0, room)), time.rjust(times))).rstrip()


def _marked_counts(groups: Sequence[Group]) -> str:
    counts = {status: sum(group.count(status) for group in groups) for status in Status}
    return ", ".join(f"{MARKS[status]} {count} {status}" for status, count in reversed(counts.items()) if count)


def _remark(groups: Sequence[Group]) -> str:
    """Return the claim nearest to failing, or what happened in the only case."""
    results = [result for group in groups for row in group.rows for result in row.results]
    near = [each for each in nearest(results) if each.share is not None and each.share < NEAR]
    if near:
        return f"nearest: {near[0].result.name}, {near[0].text}"
    return result_text(results[0]) if len({result_text(result) for result in results}) == 1 else ""


def _time(groups: Sequence[Group]) -> str:
    return f"{sum(group.wall_time for group in groups):.1f} s"


def _case_lines(row: CaseRow, width: int) -> Iterator[str]:
    for result in row.results:
        yield from hanging(f"{MARKS[row.status]} {result.name}: {result_text(result)}", width)


# Red: one block a failure. Cases of one scenario that fail alike share a block.


LABEL = 10  # [characters] columns of the labels in a block
MOST_ROWS = 6  # lines of cases in one block


def _failure_blocks(group: Group, width: int) -> Iterator[Block]:
    """Yield a block for a failed case, or one for several cases of a scenario that failed, crashed or timed out."""
    failed = [row for row in group.rows if row.status is Status.FAILED and row.first.status is not RunStatus.BLOCKED]
    for status in dict.fromkeys(row.first.status for row in failed):  # each has its own command that shows it
        rows = [row for row in failed if row.first.status is status]
        yield _one_failure(rows[0], width) if len(rows) == 1 else _several_failures(group, rows, width)


def _head(status: Status, name: str, place: str, width: int) -> Line:
    before = f"{MARKS[status]} {str(status).upper()}  {name}"
    gap = max(len(GAP), min(width, WIDEST) - len(before) - len(place))
    return line(f"{before}{' ' * gap}{place}", STYLES[status])


STYLES = {Status.FAILED: "bold red", Status.DIFFERS: "bold yellow"}


def _place(row: CaseRow) -> str:
    """Return file and line of the failed claim, or the file."""
    failed = next((outcome for outcome in row.first.outcomes if not outcome.passed), None)
    return f"{failed.span.file}:{failed.span.line}:{failed.span.column}" if failed is not None else row.first.file


def _one_failure(row: CaseRow, width: int) -> Block:
    systems = "".join(f", {result.system}" for result in row.results[1:])
    name = row.first.name.removesuffix("]") + systems + "]"
    word = f" ({row.first.conclusion})" if row.first.conclusion not in ("failed", UNCHECKED) else ""
    lines = failure_lines(row.first)
    told = [text for label, value in lines if value for text in hanging(f"  {label:<{LABEL}}{value}", width)]
    return [_head(Status.FAILED, name + word, _place(row), width), *map(line, [*told, _see(row.first)])]


def _several_failures(group: Group, failed: Sequence[CaseRow], width: int) -> Block:
    count = sum(len(row.results) for row in failed)
    total = sum(len(row.results) for row in group.rows)
    first = dict(failure_lines(failed[0].first))
    told: list[str] = []
    claims = [f"{outcome.name}: {outcome.expected}" for outcome in failed[0].first.outcomes if not outcome.passed]
    for number, claim in enumerate(claims or filter(None, [first.get("expected")])):
        told += hanging(f"  {'expected' if number == 0 else '':<{LABEL}}{claim}", width)
    for number, row in enumerate(failed[:MOST_ROWS]):
        systems = ", ".join(result.system for result in row.results)
        values = " ".join(f"{name}={text}" for name, text in row.first.parameters) or row.first.case
        text = f"{values}  {result_text(row.first)}  ({systems})".strip()
        told += hanging(f"  {'measured' if number == 0 else '':<{LABEL}}{text}", width)
    if len(failed) > MOST_ROWS:
        told.append(f"  {'':<{LABEL}}and {how_many(len(failed) - MOST_ROWS, 'more case')}; -v lists all")
    for label in ("why", "after"):
        texts = {dict(failure_lines(row.first)).get(label, "") for row in failed}
        if len(texts) == 1 and label in first:  # a cause of one case is not that of the others
            told += hanging(f"  {label:<{LABEL}}{first[label]}", width)
    told.append(_see(failed[0].first))
    name = f"{group.scenario}, {count} of {how_many(total, 'case')}"
    return [_head(Status.FAILED, name, _place(failed[0]), width), *map(line, told)]


def _see(result: VariantResult) -> str:
    """Return the line of the command that shows a failure, which stays on one line to be copied."""
    label, command = see_line(result, f"{result.scenario}.html")
    return f"  {label:<{LABEL}}{command}"


# Notes: counted, and listed with -v.


def _fallen_unchecked(report: Report) -> Block:
    """Return the few runs without expectations that fell."""
    fell = [result for result in report.results if result.unchecked and result.fell and not result.must_claim]
    if len(fell) > MOST_ROWS:
        return []
    texts = [text for result in fell for text in _unchecked_lines(result)]
    return titled(f"Unchecked cases that fell: {TO_CLAIM}", texts)


def _counts(report: Report) -> Iterator[str]:
    """Yield the numbers of notes on one line."""
    results = report.results
    counts = {
        "disagree with the reference": sum(result.truth_agrees is False for result in results),
        "unchecked": sum(result.unchecked and not result.must_claim for result in results),
        "expected to fail": sum(status_of(result) is Status.EXPECTED_FAILURE for result in results),
        "numerical collapses": sum(bool(result.numerical) for result in results),
        "with energy added by the engine": sum(bool(result.energy_gained) for result in results),
        "with wrong edge normals": sum(result.wrong_edges is not None for result in results),
        "with wrong friction in the engine": sum(result.wrong_friction is not None for result in results),
        "with claims that rest on bricks whose fate is unclear": sum(
            any(outcome.passed and outcome.unclear for outcome in result.outcomes) for result in results
        ),
        "stable only if gaps count as contact": sum(result.touching_within > 0.0 for result in results),
        "with a thrown brick that passed through another": sum(result.passed_through is not None for result in results),
        "with a golden file of another engine": sum(
            result.golden is not None and result.golden.status is GoldenStatus.OTHER_ENGINE for result in results
        ),
        "with changed constants": sum(bool(result.modified) for result in results),
    }
    told = [f"{count} {what}" for what, count in counts.items() if count]
    if told:
        yield from wrap(f"! {', '.join(told)}; -v lists them", WIDEST)


WIDEST = 100  # [characters] of heads of blocks and the line of notes, in a wider window


def _notes(report: Report) -> Iterator[Block]:
    """Yield warnings that fail nothing."""
    noted = report.results
    early = [(result.name, result.early_end) for result in report.results if result.early_end is not None]
    gained = [result for result in report.results if result.energy_gained]
    odd = dict.fromkeys(str(each) for result in report.results for each in result.warnings)
    yield titled("Warnings", list(odd))
    yield titled("Expected failures (xfail)", list(_xfailed(report)))
    yield from _unchecked(report)
    yield titled("Skipped", list(_skipped(report)))
    standing = [r.name for r in report.results if r.unchecked and not r.fell and not r.must_claim]
    yield titled(f"Unchecked: {TO_CLAIM}", [names_text(standing)] if standing else [])
    yield titled("Samples", list(samples_told(report.results)))
    yield titled("Modified scenes", list(_modified(report)))
    yield titled("Ended early", [f"{name}: {ending_text(end)}" for name, end in early])
    yield titled("Numerical collapses", [f"{r.name}: {r.numerical}" for r in report.results if r.numerical])
    yield titled("Claims that rest on bricks whose fate is unclear", list(unclear_claims(noted)))
    yield titled("Stable only if gaps count as contact", [gaps_text(r) for r in noted if r.touching_within])
    yield titled("Energy added by the engine", [f"{r.name}: {energy_fault(r.energy_gained)}" for r in gained])
    yield titled("Wrong edge normals", list(wrong_edges(noted)))
    yield titled("Wrong friction in the engine", list(wrong_frictions(noted)))
    yield titled("Thrown bricks that passed through others", list(passed_through(report.results)))
    yield titled("Different from the reference (truth)", list(_missed_truths(report)))
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
        "engine": result.engine if result.engine not in USUAL_ENGINES else NOTHING,
        "level": str(result.collapse.level) if result.collapse else NOTHING,
        "drift mm": significant(1000.0 * result.drift) if result.is_one_run else NOTHING,
        "still moving": str(len(result.moving)) if result.moving else NOTHING,
        "met": f"{result.met}/{len(result.outcomes)}" if result.outcomes else NOTHING,
        "truth": {None: NOTHING, True: "agrees", False: "differs"}[result.truth_agrees],
        "golden": result.golden.status.value if result.golden is not None else NOTHING,
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


def _sensitive(report: Report) -> Iterator[str]:
    asked = [result for result in report.results if result.sensitivity is not None]
    for result in asked:
        if found := result.decided_by_a_micrometre:
            yield f"{result.name}: a micrometre decides: {decided_text(found)}"
    if asked and not any(result.decided_by_a_micrometre for result in asked):
        yield "a micrometre decides nothing"


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
    yield from (f"{message}: {names_text(skipped)}" for message, skipped in names.items())


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


def _missed_truths(report: Report) -> Iterator[str]:
    for result in report.results:
        for truth in result.truths:
            if not truth.passed:
                yield f"{truth.span}: {result.name}: {outcome_text(truth)}"


def _differences(result: VariantResult, width: int, review: str) -> Block:
    """Return the differences from a golden file: each brick once for an observation, equal changes together."""
    golden = result.golden
    if golden is None or not golden.differences:
        return []
    told = difference_lines(golden, width)
    if golden.status is GoldenStatus.WRITTEN:
        return [line(f"Rewritten {golden.file}", "bold"), *map(line, told)]
    head = _head(Status.DIFFERS, result.name, golden.file, width)
    decide = [f"  {'decide':<{LABEL}}{review}"] if review else []
    return [head, *map(line, [*told, *decide])]


UNWRITABLE = "cannot be written"  # in the note on a golden file that no option would write


def _golden_files(report: Report) -> Iterator[str]:
    """Yield pending work on golden files, with the command for it."""
    goldens = [result.golden for result in report.results if result.golden is not None]
    for status in (GoldenStatus.MISSING, GoldenStatus.NEW):
        yield from _together([golden.file for golden in goldens if golden.status is status and not golden.note], status)
    for golden in goldens:
        alone = golden.status not in (GoldenStatus.MISSING, GoldenStatus.NEW) or golden.note
        if golden.status in (*GOLDEN_FAILURES, GoldenStatus.WRITTEN) and alone:
            yield f"{golden.file}: {golden.status}" + (f": {golden.note}" if golden.note else "")
    yield from unclear_lines(goldens)
    yield from (f"{visible(file)}: removed" for file in report.removed)
    yield from (f"{visible(file)}: obsolete, no variant uses this file" for file in report.obsolete)
    if failing := sum(result.golden_failed and not result.may_be_locked for result in report.results):
        what = "1 of these results fails" if failing == 1 else f"{failing} of these results fail"
        yield f"{what} expectations; only {report.accept_failing} would accept {'it' if failing == 1 else 'them'}"
    if report.accept and not any(UNWRITABLE in (golden.note or "") for golden in goldens):
        others, unused = " the others" * bool(failing), ", and remove obsolete files," * bool(report.obsolete)
        yield f"accept{others}{unused} with: {report.accept}"


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
