"""Compares slopes of margins computed from duals with finite differences: agreement and cost.

Run: python -m benchmarks.slopes [--write]; a minute or two.
"""

from collections.abc import Callable, Mapping
from time import process_time
from typing import Final

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stackdsl.checking.cases import Case, cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.studies.sensitivities import MarginKind, Sensitivities, SlopeSource, sensitivities_of
from tests.stackdsl.studies.known_limits import HOUSE, LEANING, SEESAW, V

ALL: Final = 10**9
COLUMN: Final = "friction: 3\nlet: {step: 7 mm}\nbuild:\n  - column: {levels: 8, step: '${step}'}\n    every: 1 s\n"
SCENES: Final[Mapping[str, tuple[str, MarginKind]]] = {
    "stepped column of 8, acceleration": (COLUMN, MarginKind.ACCELERATION),
    "four-stack of 5 levels, acceleration": (
        "friction: 3\nbuild:\n  - four_stack: {levels: 5}\n",
        MarginKind.ACCELERATION,
    ),
    "beam on a block, acceleration": ("friction: 3" + SEESAW.replace("LOAD", "10"), MarginKind.ACCELERATION),
    "ladder, friction": (LEANING.replace("WALL", "0.3"), MarginKind.FRICTION),
    "inverted V, friction": (V, MarginKind.FRICTION),
    "card house under three planks, friction": (HOUSE, MarginKind.FRICTION),
}


def case_of(text: str) -> Case:
    """Return a compiled scene."""
    cases, mistakes = cases_of(parse(f"scenario: slopes\n{text}", "slopes.yaml"))
    assert not mistakes, mistakes
    return cases[0]


def held(text: str, of: MarginKind) -> Row:
    """Return the comparison of all slopes of one scene."""
    case = case_of(text)
    duals, of_duals = _timed(lambda: sensitivities_of(case, "slopes", of, checked=0))
    checked, of_both = _timed(lambda: sensitivities_of(case, "slopes", of, checked=ALL))
    known = {each.what for each in duals.effects if each.source is SlopeSource.DUALS}
    found = [each for each in checked.effects if each.what in known]
    count = len(checked.effects)
    return {
        "numbers": count,
        "matter": sum(each.counts for each in checked.effects),
        "agree": sum(each.source is SlopeSource.CHECKED for each in found),
        "contradicted": sum(each.source is not SlopeSource.CHECKED for each in found),
        "without_duals": count - len(known),
        "kinks": sum(each.has_kink for each in checked.effects),
        "duals_ms": 1000.0 * of_duals / count,
        "differences_ms": 1000.0 * (of_both - of_duals) / count,
    }


def _timed(asked: Callable[[], Sensitivities]) -> tuple[Sensitivities, float]:
    began = process_time()
    found = asked()
    return found, process_time() - began


def main() -> None:
    """Compare and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    console = Console(stderr=True)
    rows = {name: held(*scene) for name, scene in track(SCENES.items(), "slopes", console=console, transient=True)}
    table = Table("scene", *next(iter(rows.values())))
    for name, row in rows.items():
        table.add_row(name, *(f"{each:.3g}" if isinstance(each, float) else str(each) for each in row.values()))
    Console(width=160).print(table)
    if write:
        record("slopes", "python -m benchmarks.slopes --write", {"scenes": rows})


if __name__ == "__main__":
    main()
