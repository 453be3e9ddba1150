"""The report as workflow commands of GitHub, which shows them beside the lines of the files.

It shows ten of a step and drops the others without a word, so the worst come first, and the tenth says what is left.
"""

from stackdsl.outcome import Report
from stackdsl.report.text import closing_line
from stackdsl.report.worst_first import Finding, Rank, findings

MOST_SHOWN = 10  # annotations of one kind that a step shows


def report_github(report: Report) -> str:
    """One line a finding, and one of sums that is only in the log."""
    found = findings(report)
    shown = found if len(found) <= MOST_SHOWN else found[: MOST_SHOWN - 1]
    lines = [_command(finding) for finding in shown]
    if len(found) > len(shown):
        rest = found[len(shown) :]
        lines.append(f"::error title=stackdsl::and {len(rest)} more, which the log names")
        lines += [_remark(finding) for finding in rest]
    return "\n".join([*lines, closing_line(report)]) + "\n"


def _command(finding: Finding) -> str:
    place = f"file={_value(finding.file)},line={finding.line},col={finding.column}"
    command = "warning" if finding.rank is Rank.WARNED else "error"
    return f"::{command} {place},title={_value(finding.title)}::{_data(finding.text)}"


def _remark(finding: Finding) -> str:
    """A line of the log, and no command, whatever texts of authors are in it."""
    told = f"{finding.file}:{finding.line}:{finding.column}: {finding.title}: {finding.text}"
    return f"- {' '.join(told.split())}"


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _value(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
