"""Measures accuracy and cost of the limits of `stackdsl find`, on scenes with known limits.

Run: python -m benchmarks.find [--write]; half a minute.
"""

from time import process_time

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stackdsl.studies.find_limit import LimitRequest, Want, find_in
from tests.stackdsl.studies.known_limits import KNOWN, Known


def found(known: Known) -> Row:
    """Return the relative error of the worse side of a limit, and its cost."""
    case, truth = known.case(), known.limit()
    began = process_time()
    finding = find_in(case, "known", LimitRequest(known.want, known.name))
    taken = process_time() - began
    assert finding.stands is not None
    assert finding.beyond is not None
    whole = known.want is Want.MOST
    sides = [finding.stands] if whole else [finding.stands, finding.beyond]
    return {
        "asked": f"{known.want} {known.name}",
        "closed_form": known.source,
        "truth": f"{truth:.10g}",
        "stands": f"{finding.stands:.10g}",  # enough digits to distinguish both sides
        "beyond": f"{finding.beyond:.10g}",
        "error": max(abs(side / truth - 1.0) for side in sides),
        "how": "program" if finding.by_program else "halving",
        "verdicts": finding.verdicts,
        "ms": 1000.0 * taken,
    }


def main() -> None:
    """Measure and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    console = Console(stderr=True)
    rows = {name: found(known) for name, known in track(KNOWN.items(), "limits", console=console, transient=True)}
    table = Table("scene", *next(iter(rows.values())))
    for name, row in rows.items():
        table.add_row(name, *(f"{each:.9g}" if isinstance(each, float) else str(each) for each in row.values()))
    Console(width=200).print(table)
    if write:
        whole: Row = {
            "scenes": len(rows),
            "worst_error": max(float(row["error"] or 0.0) for row in rows.values()),
            "worst_ms": max(float(row["ms"] or 0.0) for row in rows.values()),
        }
        record("find", "python -m benchmarks.find --write", {"scenes": rows, "all": {"all": whole}})


if __name__ == "__main__":
    main()
