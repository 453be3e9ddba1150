"""The report of a check as one page: a table of all cases, failures first, each with its picture and its replay.

The table is plain HTML, which needs no script; a small one filters it. Names and texts are escaped, and the policy of
the page lets nothing run but that script.
"""

from collections.abc import Iterator, Mapping
from html import escape
from importlib.resources import files
from typing import Final

from stackdsl.outcome import UNCHECKED, Outcome, Report, VariantResult
from stackdsl.report.outcome_text import outcome_text, significant, unchecked_text
from stackdsl.report.text import closing_line
from stackdsl.shown_text import harmless
from stackdsl.viewing.check_report.charts import charts
from stackdsl.viewing.check_report.shown_case import ShownCase
from stackdsl.viewing.replay.replay_page import policy_of

COLUMNS: Final = ("", "case", "verdict", "expectations", "golden file", "speed, error")


def index_page(report: Report, shown: Mapping[str, ShownCase], unseen: Mapping[str, str]) -> str:
    """The page; `shown` and `unseen` say by the name of a case what there is to look at, or why there is nothing."""
    script, style = script_and_style()
    policy = policy_of((script,), (style,))
    found = sorted(report.results, key=lambda result: (result.conclusion == "passed", result.conclusion == UNCHECKED))
    head = "".join(f"<th>{name}</th>" for name in COLUMNS)
    rows = "\n".join(_row(result, shown.get(result.name), unseen.get(result.name, "")) for result in found)
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(closing_line(report))}</title><style>{style}</style></head><body>",
        f"<h1>{escape(closing_line(report))}</h1>",
        *(f'<p class="failed">{escape(str(d.span))}: {escape(d.message)}</p>' for d in report.diagnostics),
        charts(report.results),
        '<p class="filter" hidden>',
        '<input type="search" id="search" placeholder="words of a case" aria-label="filter">',
        '<label><input type="checkbox" id="only"> only what did not pass</label></p>',
        f'<table id="cases"><thead><tr>{head}</tr></thead><tbody>',
        rows,
        "</tbody></table>",
        f"<script>{script}</script></body></html>",
    ]
    return harmless("\n".join(lines))


def _row(result: VariantResult, shown: ShownCase | None, unseen: str) -> str:
    passed = result.conclusion == "passed"
    name = escape(result.name)
    if shown is not None:
        name = f'<a href="{escape(shown.replay)}">{name}</a>'
    about = "" if shown is not None else f"<br>no replay: {escape(unseen)}" if unseen else ""
    cells = (
        shown.picture if shown is not None else "",
        f"{name}<br>{escape(result.file)}{about}",
        f'<span class="{_style(result)}">{escape(result.conclusion)}</span><br>{_verdict(result)}',
        _outcomes(result),
        _golden(result),
        "<br>".join(map(escape, _measures(result))),
    )
    return f'<tr data-passed="{"yes" if passed else "no"}">' + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _style(result: VariantResult) -> str:
    if result.conclusion == UNCHECKED and not result.must_claim:
        return UNCHECKED
    return "passed" if result.conclusion == "passed" else "failed"


def _verdict(result: VariantResult) -> str:
    fell = f"{result.verdict} at level {result.collapse.level}" if result.collapse is not None else result.verdict
    return escape("; ".join(filter(None, [fell, result.message, *(f"warning: {odd}" for odd in result.warnings)])))


def _outcomes(result: VariantResult) -> str:
    if not result.outcomes:
        return escape(unchecked_text(result)) if result.unchecked else ""
    told = "".join(f"<li>{_outcome(outcome)}</li>" for outcome in result.outcomes)
    count = f"{result.met} of {len(result.outcomes)} hold"
    return f"<details{' open' if not result.passed else ''}><summary>{count}</summary><ul>{told}</ul></details>"


def _outcome(outcome: Outcome) -> str:
    text = f"{outcome.span}: {outcome_text(outcome)}"
    return escape(text) if outcome.passed else f'<span class="failed">{escape(text)}</span>'


def _golden(result: VariantResult) -> str:
    golden = result.golden
    if golden is None:
        return ""
    listed = "".join(
        f"<li>{escape(f'{d.subject} {d.quantity}: expected {d.expected}, got {d.got}')}</li>"
        for d in golden.differences
    )
    return escape(golden.status.value) + (f"<ul>{listed}</ul>" if listed else "")


def _measures(result: VariantResult) -> Iterator[str]:
    if result.cost is not None:
        yield f"{significant(result.cost.wall_time)} s for {significant(result.cost.simulated_time)} s"
    if result.verdict:
        yield f"drift {significant(1000.0 * result.drift)} mm"
    if result.truths:
        yield "as known from outside" if result.truth_agrees else "other than known from outside"


def script_and_style() -> tuple[str, str]:
    """What every such page is made of."""
    return _packaged("report.js"), _packaged("report.css")


def _packaged(name: str) -> str:
    return files("stackdsl.viewing.check_report").joinpath(name).read_text(encoding="utf-8")
