"""The report as a page of Markdown: the summary of a step of continuous integration, or a comment."""

from collections.abc import Iterator, Sequence

from stackdsl.outcome import Report, VariantResult
from stackdsl.report.outcome_text import significant
from stackdsl.report.text import closing_line
from stackdsl.report.worst_first import findings

MOST_ROWS = 200  # of each table; a page of a megabyte is shown by nobody
SPECIAL = str.maketrans({character: f"\\{character}" for character in "\\`*_{}[]<>#|~"})


def report_markdown(report: Report) -> str:
    """Sums, then what failed, worst first, then all cases, folded away."""
    return "\n".join([f"**{_plain(closing_line(report))}**", "", *_failed(report), *_cases(report.results)])


def _failed(report: Report) -> Iterator[str]:
    found = findings(report)
    if found:
        yield from ("| where | what | |", "|---|---|---|")
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
            golden = result.golden.status.value if result.golden else "-"
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
    """Text that means nothing else in Markdown, on one line."""
    return " ".join(text.split()).translate(SPECIAL)
