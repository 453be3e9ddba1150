"""Counts wrong verdicts of the published model on a thousand random piles, by exact statics.

Run it with `python -m benchmarks.thesis_against_exact`. The piles are those of the tests, whose independent check
contradicts no verdict of exact statics.
"""

from collections import Counter

from rich.console import Console
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.problem import Stability
from stability.statics.assembly import Assembly
from tests.stability.statics.independent import independent_verdict
from tests.stability.statics.published_model import published_model_says_stable
from tests.stability.statics.random_piles import FRICTION, random_piles

PILES = 1000


def main() -> None:
    """Judge and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    table: Counter[tuple[bool, Stability]] = Counter()
    contradicted = 0
    for pile in random_piles(PILES):
        stability = Assembly(friction=FRICTION).add_all(pile).stability
        table[published_model_says_stable(pile), stability] += 1
        contradicted += {stability, independent_verdict(pile, FRICTION)} == {"stable", "unstable"}
    printed = Table("thesis", *(f"exact: {stability}" for stability in Stability))
    for says, name in ((True, "stable"), (False, "unstable")):
        printed.add_row(name, *(str(table[says, stability]) for stability in Stability))
    Console().print(printed)
    Console().print(f"verdicts of exact statics that the independent check contradicts: {contradicted}")
    if write:
        rows: dict[str, Row] = {
            name: {str(stability): table[says, stability] for stability in Stability}
            for says, name in ((True, "stable"), (False, "unstable"))
        }
        rows["all"] = {
            "piles": PILES,
            "contradicted": contradicted,
            "stands_and_denied_percent": 100.0 * table[False, Stability.STABLE] / _truly(table, Stability.STABLE),
        }
        record("thesis-against-exact", "python -m benchmarks.thesis_against_exact --write", {"piles": rows})


def _truly(table: Counter[tuple[bool, Stability]], stability: Stability) -> int:
    return table[True, stability] + table[False, stability]


if __name__ == "__main__":
    main()
