"""The report as a table of comma-separated values, a row a case: what a study of parameters is plotted from.

A variable is a column in units of the SI; one that is a word stays as written. Units stand at the end of the names.
A file whose name a spreadsheet would take for a formula, or GitHub for a workflow command, is told from the folder on:
`./=1+1.yaml`.
"""

import csv
from io import StringIO

from stackdsl.outcome import Report, VariantResult
from stackdsl.report.quantity_text import quantity_of

FIXED = ("file", "scenario", "variant", "system", "conclusion", "verdict", "collapse_level", "collapse_s", "drift_m")
FORMULA = ("=", "+", "-", "@")  # as formulas begin in spreadsheets
COMMAND = "::"  # as commands begin in the log of a workflow, which row by row may be shown there
COSTS = ("expectations", "met", "least_margin", "least_margin_unit", "golden", "wall_s", "simulated_s", "steps")


def report_csv(report: Report) -> str:
    """A header and the rows; lines end as RFC 4180 says."""
    variables = list(dict.fromkeys(name for result in report.results for name, _ in result.parameters))
    out = StringIO()
    writer = csv.writer(out)
    writer.writerow([*FIXED, *COSTS, *(f"variable_{name}" for name in variables)])
    for result in report.results:
        chosen = {name: _number_or_word(written) for name, written in result.parameters}
        writer.writerow([*_fixed(result), *_costs(result), *(chosen.get(name, "") for name in variables)])
    return out.getvalue()


def _number_or_word(written: str) -> object:
    value = quantity_of(written)
    return written if value["si"] is None else value["si"]


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
    golden = result.golden.status.value if result.golden else ""
    cost = result.cost
    costs = [cost.wall_time, cost.simulated_time, cost.steps] if cost is not None else ["", "", ""]
    return [len(result.outcomes), result.met, *margin, golden, *costs]
