"""The report as CSV, JSON, JUnit, GitHub annotations and Markdown."""

import csv
import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from io import StringIO
from itertools import groupby
from math import isfinite
from xml.etree import ElementTree as ET

from stability.engines.protocol import WrongFriction
from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.language.quantities import number_or_word, quantity_of
from stackdsl.report.outline import remedy_text, stop_text
from stackdsl.report.text import TO_CLAIM, closing_line, outcome_text, unchecked_text
from stackdsl.results import (
    UNCHECKED,
    Change,
    ClaimOutcome,
    EarlyEndSummary,
    FailureCause,
    GoldenResult,
    Report,
    RunStatus,
    Seen,
    VariantResult,
    exit_code,
)
from stackdsl.shown_text import visible
from stackdsl.trace import Collapse, Cost, Ensemble, PassedThrough, WrongEdges
from stackdsl.wording import significant

# All failures and warnings as single findings, worst first, for outputs that limit their number.


MOST_SEEN = 3  # shown differences of one golden file; the text report has the others


class Rank(IntEnum):
    """Severity of a finding; those that make other results untrustworthy come first."""

    INVALID = 0
    STOPPED = 1
    FAILED = 2
    GOLDEN = 3
    WARNED = 4  # does not fail the check


@dataclass(frozen=True, slots=True)
class RankedFailure:
    """A finding of a report."""

    rank: Rank
    title: str
    text: str
    file: str
    line: int = 1
    column: int = 1


def ranked_failures(report: Report) -> list[RankedFailure]:
    """Return all findings, worst first, then in the order of the report; warnings come last."""
    found = [
        RankedFailure(
            Rank.INVALID, each.code, f"{each.message}{f'; {each.hint}' if each.hint else ''}", *_place(each.span)
        )
        for each in report.diagnostics
    ]
    found += [finding for result in report.results for finding in ranked_failures_of(result)]
    found += [finding for result in report.results for finding in warnings_of(result)]
    found += [
        RankedFailure(Rank.GOLDEN, "obsolete golden file", "no variant uses this file", visible(file))
        for file in report.obsolete
    ]
    return sorted(found, key=lambda finding: finding.rank)


def ranked_failures_of(result: VariantResult) -> Iterator[RankedFailure]:
    """Yield the failures of a result."""
    if result.mistake is not None:
        yield RankedFailure(Rank.INVALID, result.name, result.mistake.message, *_place(result.mistake.span))
    elif result.status not in (RunStatus.DONE, RunStatus.SKIPPED):
        yield RankedFailure(Rank.STOPPED, result.name, f"{result.status}: {stop_text(result)}", result.file)
    for outcome in result.outcomes:
        if not outcome.passed:
            cause = result.why.why if result.why is not None else ""
            text = "; ".join(filter(None, [outcome_text(outcome), cause]))
            yield RankedFailure(Rank.FAILED, result.name, text, *_place(outcome.span))
    if result.unchecked and result.must_claim:
        yield RankedFailure(Rank.FAILED, result.name, _unchecked(result), result.file)
    if result.golden is not None and result.golden_failed:
        golden = result.golden
        seen = [f"{one.subject}: {one.quantity}: was {one.expected}, is {one.got}" for one in golden.differences]
        more = [f"and {len(seen) - MOST_SEEN} more"] if len(seen) > MOST_SEEN else []
        left = (golden.fallen_text, golden.unclear.text * bool(seen))
        told = "; ".join(filter(None, [golden.note, *seen[:MOST_SEEN], *more, *left]))
        text = f"{golden.file}: {golden.status}{f': {told}' if told else ''}"
        yield RankedFailure(Rank.GOLDEN, result.name, text, result.file)


def warnings_of(result: VariantResult) -> Iterator[RankedFailure]:
    """Yield the warnings of a result, and an unexpected fall without expectations."""
    for odd in result.warnings:
        yield RankedFailure(
            Rank.WARNED, result.name, "; ".join(filter(None, [odd.message, odd.hint])), *_place(odd.span)
        )
    if result.unchecked and result.fell and not result.must_claim:
        yield RankedFailure(Rank.WARNED, result.name, _unchecked(result), result.file)


def _unchecked(result: VariantResult) -> str:
    cause = result.why.why if result.why is not None else ""
    return "; ".join(filter(None, [unchecked_text(result), cause, TO_CLAIM]))


def _place(span: Span) -> tuple[str, int, int]:
    return span.file, span.line, span.column


# The report as JUnit XML for continuous integration: one suite per file, one test per case.
#
# A case without expectations counts as skipped, since JUnit has no other status for neither passed nor failed.


NO_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # characters that XML 1.0 forbids


def report_junit(report: Report) -> str:
    """Return the report as JUnit; mistakes of files and unused golden files are errors of separate suites."""
    root = ET.Element("testsuites", name="stackdsl", time=f"{report.wall_time:.3f}")
    for file, group in groupby(report.results, key=lambda result: result.file):
        results = list(group)
        suite = ET.SubElement(root, "testsuite", name=_clean(file))
        if unchecked := sum(result.unchecked for result in results):
            told = ET.SubElement(suite, "properties")
            ET.SubElement(told, "property", name=UNCHECKED, value=str(unchecked))
        for result in results:
            _case(suite, result)
    _errors(root, "mistakes", [(f"{each.span}", f"{each.code} {each.message}") for each in report.diagnostics])
    _errors(root, "golden files", [(visible(file), "obsolete: no variant uses this file") for file in report.obsolete])
    for counted in [*root, root]:
        cases = list(counted.iter("testcase"))
        counted.set("tests", str(len(cases)))
        for kind, name in (("failure", "failures"), ("error", "errors"), ("skipped", "skipped")):
            counted.set(name, str(sum(case.find(kind) is not None for case in cases)))
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _case(suite: ET.Element, result: VariantResult) -> None:
    time = result.cost.wall_time if result.cost is not None and not result.remembered else 0.0
    named = {"name": _clean(result.name), "classname": _clean(result.scenario), "file": _clean(result.file)}
    case = ET.SubElement(suite, "testcase", {**named, "time": f"{time:.3f}"})
    told = {
        "system": result.system,
        "verdict": result.verdict,
        "conclusion": result.conclusion,
        **dict(result.parameters),
    }
    properties = ET.SubElement(case, "properties")
    for name, value in told.items():
        ET.SubElement(properties, "property", name=_clean(name), value=_clean(value))
    for odd in result.warnings:
        ET.SubElement(properties, "property", name="warning", value=_clean(str(odd)))
    if result.status is RunStatus.SKIPPED:
        ET.SubElement(case, "skipped", message=_clean(result.message))
    found = list(ranked_failures_of(result))
    if found:
        kind = "failure" if result.status is RunStatus.DONE else "error"
        text = "\n".join(f"{each.file}:{each.line}:{each.column}: {each.text}" for each in found)
        ET.SubElement(case, kind, message=_clean(found[0].text)).text = _clean(text)
    elif result.unchecked:
        ET.SubElement(case, "skipped", message=_clean(f"{UNCHECKED}: {unchecked_text(result)}"))


def _errors(root: ET.Element, title: str, found: list[tuple[str, str]]) -> None:
    if found:
        suite = ET.SubElement(root, "testsuite", name=title)
        for place, text in found:
            case = ET.SubElement(suite, "testcase", name=_clean(place), classname=title)
            ET.SubElement(case, "error", message=_clean(text))


def _clean(text: str) -> str:
    return NO_XML.sub("\ufffd", text)


# The report as workflow commands of GitHub, which shows them beside the lines of the files.
#
# GitHub shows only ten annotations of a step. So the worst come first, and the tenth gives the number of the others.


MOST_SHOWN = 10  # annotations of one kind that a step shows


def report_github(report: Report) -> str:
    """Return one annotation for each finding, and a line of sums for the log."""
    found = ranked_failures(report)
    shown = found if len(found) <= MOST_SHOWN else found[: MOST_SHOWN - 1]
    lines = [_command(finding) for finding in shown]
    if len(found) > len(shown):
        rest = found[len(shown) :]
        lines.append(f"::error title=stackdsl::{len(rest)} more findings are listed in the log")
        lines += [_remark(finding) for finding in rest]
    return "\n".join([*lines, closing_line(report)]) + "\n"


def _command(finding: RankedFailure) -> str:
    place = f"file={_value(finding.file)},line={finding.line},col={finding.column}"
    command = "warning" if finding.rank is Rank.WARNED else "error"
    return f"::{command} {place},title={_value(finding.title)}::{_data(finding.text)}"


def _remark(finding: RankedFailure) -> str:
    """Return a line of the log that is no workflow command."""
    told = f"{finding.file}:{finding.line}:{finding.column}: {finding.title}: {finding.text}"
    return f"- {' '.join(told.split())}"


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _value(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")


# The report as a page of Markdown: the summary of a step of continuous integration, or a comment.


MOST_ROWS = 200  # of each table; GitHub does not show pages of a megabyte
SPECIAL = str.maketrans({character: f"\\{character}" for character in "\\`*_{}[]<>#|~"})


def report_markdown(report: Report) -> str:
    """Return sums, failures with the worst first, and all cases in a folded part."""
    return "\n".join([f"**{_plain(closing_line(report))}**", "", *_failed(report), *_cases(report.results)])


def _failed(report: Report) -> Iterator[str]:
    found = ranked_failures(report)
    if found:
        yield from ("| place | case or code | finding |", "|---|---|---|")
        for each in found[:MOST_ROWS]:
            yield f"| {_plain(each.file)}:{each.line} | {_plain(each.title)} | {_plain(each.text)} |"
        yield from _more(len(found))
        yield ""


def _cases(results: Sequence[VariantResult]) -> Iterator[str]:
    if results:
        yield from (
            "<details><summary>All cases</summary>",
            "",
            "| case | verdict | drift mm | met | golden | wall s |",
        )
        yield "|---|---|---|---|---|---|"
        for result in results[:MOST_ROWS]:
            golden = result.golden.status.value if result.golden is not None else "-"
            wall = f"{result.cost.wall_time:.2f}" if result.cost else "-"
            drift = significant(1000.0 * result.drift) if result.is_one_run else "-"
            met = f"{result.met}/{len(result.outcomes)}"
            cells = (result.name, result.verdict or result.status.value, drift, met, golden, wall)
            yield f"| {' | '.join(map(_plain, cells))} |"
        yield from _more(len(results))
        yield from ("", "</details>", "")


def _more(count: int) -> Iterator[str]:
    if count > MOST_ROWS:
        yield f"\nand {count - MOST_ROWS} more"


def _plain(text: str) -> str:
    """Return text on one line, escaped for Markdown."""
    return " ".join(text.split()).translate(SPECIAL)


# The report as comma-separated values with one row per case, for example to plot a parameter study.
#
# Each variable has a column, with numbers in SI units and words as written. Column names end in the unit. A file name
# that a spreadsheet would read as a formula, or GitHub as a workflow command, gets a leading folder: `./=1+1.yaml`.


FIXED = ("file", "scenario", "variant", "system", "conclusion", "verdict", "collapse_level", "collapse_s", "drift_m")
FORMULA = ("=", "+", "-", "@")  # first characters of formulas in spreadsheets
COMMAND = "::"  # start of a workflow command in the log of GitHub, where rows may be printed
COSTS = ("expectations", "met", "least_margin", "least_margin_unit", "golden", "wall_s", "simulated_s", "steps")


def report_csv(report: Report) -> str:
    """Return a header and rows with line ends of RFC 4180."""
    variables = list(dict.fromkeys(name for result in report.results for name, _ in result.parameters))
    out = StringIO()
    writer = csv.writer(out)
    writer.writerow([*FIXED, *COSTS, *(f"variable_{name}" for name in variables)])
    for result in report.results:
        chosen = {name: number_or_word(written) for name, written in result.parameters}
        writer.writerow([*_fixed(result), *_costs(result), *(chosen.get(name, "") for name in variables)])
    return out.getvalue()


def _fixed(result: VariantResult) -> list[object]:
    odd = result.file.lstrip().startswith((*FORMULA, COMMAND))
    file = f"./{result.file}" if odd else result.file
    names = [file, result.scenario, result.variant, result.system, result.conclusion, result.verdict]
    level = result.collapse.level if result.collapse else ""
    time = result.collapse.time if result.collapse else ""
    return [*names, level, time, result.drift if result.is_one_run else ""]


def _costs(result: VariantResult) -> list[object]:
    least = min(result.outcomes, key=lambda outcome: (outcome.passed, outcome.margin), default=None)
    margin = [least.margin, least.unit] if least is not None else ["", ""]
    golden = result.golden.status.value if result.golden is not None else ""
    cost = result.cost
    costs = [cost.wall_time, cost.simulated_time, cost.steps] if cost is not None else ["", "", ""]
    return [len(result.outcomes), result.met, *margin, golden, *costs]


# The report as JSON for other programs.
#
# Keys are sorted and end in their SI unit. A number that is not finite or not measured is null. `format` increases if a
# key changes its meaning or is removed, but not if a key is added.


FORMAT = 1


def report_json(report: Report) -> str:
    """Return the report as one JSON object, with variants in its order."""
    whole = {
        "format": FORMAT,
        "exit_code": int(exit_code(report)),
        "interrupted": report.interrupted,
        "wall_time_s": _number(report.wall_time),
        "scenarios": report.scenarios,
        "conclusions": dict(report.conclusions),
        "diagnostics": [_diagnostic(diagnostic) for diagnostic in report.diagnostics],
        "results": [_result(report, result) for result in report.results],
        "obsolete": list(report.obsolete),
        "removed": list(report.removed),
        "accept": report.accept or None,
        "not_played": report.left,
    }
    text = json.dumps(whole, indent=2, sort_keys=True, allow_nan=False)
    return text.replace("\x7f", "\\u007f") + "\n"  # the only ASCII control character that JSON does not escape


def _number(value: float | None) -> float | None:
    return value if value is not None and isfinite(value) else None


def _span(span: Span) -> dict[str, object]:
    return {"file": span.file, "line": span.line, "column": span.column, "end_column": span.end_column}


def _diagnostic(diagnostic: Diagnostic) -> dict[str, object]:
    return {
        "code": diagnostic.code,
        "message": diagnostic.message,
        "hint": diagnostic.hint,
        "span": _span(diagnostic.span),
        "repetition": diagnostic.span.where or None,
    }


def _result(report: Report, result: VariantResult) -> dict[str, object]:
    return {
        "scenario": result.scenario,
        "variant": result.variant,
        "system": result.system,
        "file": result.file,
        "status": result.status.value,
        "conclusion": result.conclusion,
        "unchecked": result.unchecked,
        "xfail": None if result.xfail is None else {"reason": result.xfail, "strict": result.strict},
        "set_aside": result.set_aside,
        "message": result.message,
        "remedy": remedy_text(result) or None,
        "warnings": [{"message": w.message, "hint": w.hint, "span": _span(w.span)} for w in result.warnings],
        "mistake": _diagnostic(result.mistake) if result.mistake else None,
        "variables": {name: quantity_of(written) for name, written in result.parameters},
        "remembered": result.remembered,
        "verdict": result.verdict or None,
        "numerical": result.numerical or None,
        "wrong_edges": _wrong_edges(result.wrong_edges) if result.wrong_edges else None,
        "wrong_friction": _wrong_friction(result.wrong_friction) if result.wrong_friction else None,
        "touching_within_m": _number(result.touching_within) or None,
        "passed_through": _passed(result.passed_through) if result.passed_through else None,
        "energy_gained": _number(result.energy_gained) or None,
        "collapse": _collapse(result.collapse) if result.collapse else None,
        "samples": _samples(result.ensemble) if result.ensemble else None,
        "still_moving": list(result.moving),
        "early_end": _early_end(result.early_end) if result.early_end else None,
        "drift_m": _number(result.drift),
        "engine": result.engine or None,
        "modified": result.modified or None,
        "cost": _cost(result.cost) if result.cost else None,
        "speed_up": _number(report.speed_up(result)),
        "why": _why(result.why) if result.why else None,
        "expectations": [_outcome(outcome) for outcome in result.outcomes],
        "truths": [_outcome(outcome) for outcome in result.truths],
        "refinement": None if result.refinement is None else [_change(change) for change in result.refinement],
        "sensitivity": None if result.sensitivity is None else [_change(change) for change in result.sensitivity],
        "golden": _golden(result.golden) if result.golden is not None else None,
    }


def _change(change: Change) -> dict[str, object]:
    return {
        "observation": change.name,
        "unit": change.unit,
        "coarse": _seen(change.before),
        "fine": _seen(change.after),
        "difference": _number(change.difference),
        "moved": change.moved,
    }


def _seen(value: Seen) -> object:
    return list(value) if isinstance(value, tuple) else value


def _wrong_edges(wrong: WrongEdges) -> dict[str, object]:
    return {
        "contacts": wrong.contacts,
        "upper": wrong.upper,
        "lower": wrong.lower,
        "angle_rad": _number(wrong.angle),
        "time_s": _number(wrong.time),
        "first_s": _number(wrong.first),
    }


def _wrong_friction(wrong: WrongFriction) -> dict[str, object]:
    return {
        "between": [wrong.first, wrong.second],
        "asked": _number(wrong.requested),
        "had": _number(wrong.actual),
        "time_s": _number(wrong.time),
    }


def _passed(passed: PassedThrough) -> dict[str, object]:
    return {
        "brick": passed.brick,
        "through": passed.through,
        "time_s": _number(passed.time),
        "travel_m": _number(passed.travel),
    }


def _collapse(collapse: Collapse) -> dict[str, object]:
    return {
        "time_s": _number(collapse.time),
        "level": collapse.level,
        "step": collapse.step or None,
        "brick": collapse.brick,
        "gave_way": collapse.gave_way,
        "broke_at_level": collapse.broke,
    }


def _samples(ensemble: Ensemble) -> dict[str, object]:
    return {
        "drawn": ensemble.drawn,
        "planned": ensemble.planned,
        "seed": ensemble.seed,
        "stood": ensemble.stood,
        "fell_at_level": {str(level): count for level, count in ensemble.fell.items()},
        "undecided": ensemble.undecided,
        "no_place": ensemble.unfit,
        "ways": dict(ensemble.ways),
        "cpu_time_s": _number(ensemble.cpu_time),
    }


def _early_end(early: EarlyEndSummary) -> dict[str, object]:
    return {"time_s": early.time, "planned_s": early.planned, "actions_left_out": early.actions}


def _why(why: FailureCause) -> dict[str, object]:
    return {
        "cause": why.cause or None,
        "moving": list(why.moving),
        "bearing_rad": _number(why.bearing),
        "overhang_m": _number(why.overhang),
        "action_before": why.before or None,
        "moved_first": why.first or None,
        "see": why.see or None,
    }


def _cost(cost: Cost) -> dict[str, object]:
    return {
        "wall_time_s": _number(cost.wall_time),
        "simulated_time_s": _number(cost.simulated_time),
        "steps": cost.steps,
        "judgements": cost.judgements,
        "proofs": dict(cost.proofs),
        "one_by_one": cost.one_by_one,
        "update_median_s": _number(cost.updates.median) if cost.updates else None,
        "update_worst_s": _number(cost.updates.worst) if cost.updates else None,
    }


def _outcome(outcome: ClaimOutcome) -> dict[str, object]:
    return {
        "name": outcome.name,
        "expected": outcome.expected,
        "measured": outcome.measured,
        "margin": _number(outcome.margin),
        "margin_unit": outcome.unit,
        "passed": outcome.passed,
        "numbers": [
            {"value": number.value, "least": number.least, "most": number.most, "unit": number.unit}
            for number in outcome.numbers
        ],
        "span": _span(outcome.span),
    }


def _golden(golden: GoldenResult) -> dict[str, object]:
    return {
        "status": golden.status.value,
        "file": golden.file,
        "note": golden.note,
        "differences": [
            {
                "subject": difference.subject,
                "quantity": difference.quantity,
                "expected": difference.expected,
                "got": difference.got,
                "tolerance": difference.tolerance,
                "expected_number": _number(difference.numbers[0]),
                "got_number": _number(difference.numbers[1]),
                "unit": difference.unit,
            }
            for difference in golden.differences
        ],
    }
