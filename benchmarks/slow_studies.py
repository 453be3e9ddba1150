"""Measures the studies that solve most: sensitivities, shifts, margins of a large wall, and its run by the thesis.

Each study runs once, in a process of its own. Times are processor times of the study alone; memory is the peak of the
process. The peer is one linear program by HiGHS: whether a wall of 10 x 10 stands.

Run: python -m benchmarks.slow_studies [--write]
"""

from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from math import inf
from multiprocessing import get_context
from resource import RUSAGE_SELF, getrusage
from time import process_time
from typing import Final, TypeAlias
from unittest.mock import patch

from rich.console import Console
from rich.table import Table

from benchmarks.equilibrium_programs import UprightBox, answer
from benchmarks.figures.recording import parser, record
from stability.analysis.acceleration_margin import acceleration
from stability.analysis.piling import Piling
from stability.analysis.placement_margin import placement
from stability.analysis.repair import Shifting
from stability.geometry.box import as_box
from stability.problem import Problem
from stackdsl.api.run import play
from stackdsl.checking.cases import Case, cases_of
from stackdsl.judging.proofs import piling_of, proofs_of
from stackdsl.language.yaml.source import parse
from stackdsl.studies.sensitivities import MarginKind, sensitivities_of

Measured: TypeAlias = dict[str, float]

WALL: Final = "wall: {levels: 40, bricks: 40}"
LENGTH, WIDTH, THICKNESS = 117.6, 23.4, 7.8  # [mm] of a KAPLA plank
LEVELS, STEP = 28, 6.0  # of the column, and [mm] from plank to plank
PEER: Final = "peer: one verdict on a wall of 10 x 10 by HiGHS"
KEYS: Final = ("bricks", "seconds", "times_peer", "peak_mb", "result", "error_percent")


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__).parse_args()
    rows: dict[str, Measured] = {}
    for name, study in STUDIES.items():
        with ProcessPoolExecutor(1, get_context("spawn")) as alone:
            rows[name] = alone.submit(study).result()
    rows = {name: {**row, "times_peer": row["seconds"] / rows[PEER]["seconds"]} for name, row in rows.items()}
    table = Table("study", *KEYS)
    for name, row in rows.items():
        table.add_row(name, *(f"{row[key]:.4g}" for key in KEYS))
    Console().print(table)
    if arguments.write:
        record("slow-studies", "python -m benchmarks.slow_studies --write", {"studies": rows})


def sensitivities_of_a_wall() -> Measured:
    """Measure the sensitivities of the acceleration margin of 120 planks.

    A plank of the upper levels that moves across moves the centre of mass, by whose height the margin divides.
    """
    case = _case("wall: {levels: 12, bricks: 10}", "exact")
    bricks = proofs_of(case.timeline).assembly.bricks
    mass = {name: placed.brick.mass for name, placed in bricks.items()}
    height = sum(mass[name] * 1e3 * placed.pose.position_W[2] for name, placed in bricks.items()) / sum(mass.values())
    slope = max(mass.values()) / sum(mass.values()) / height

    def study() -> float:
        found = sensitivities_of(case, "wall", MarginKind.ACCELERATION)
        return next(-each.more for each in found.effects if each.what == "y of L6.5" and each.more is not None)

    return _measured(study, len(bricks), slope)


def shift_of_a_column() -> Measured:
    """Measure the least shift of each plank of a column that falls; compare that of plank 20.

    The planks above the first one are too far out by their mean shift less half a plank.
    """
    case = _case(f"column: {{levels: {LEVELS}, step: {STEP} mm}}", "exact")
    piling = piling_of(case.timeline)
    missing = STEP * LEVELS / 2.0 - LENGTH / 2.0
    return _measured(lambda: _shift(piling), LEVELS, missing * (LEVELS - 1) / (LEVELS - 19))


def _shift(piling: Piling) -> float:
    shifting = Shifting(piling)
    fall = piling.first_fall()
    assert fall is not None
    found = {each: shifting.least(each, {}) for each in shifting.candidates(*fall)}
    least = found["L20.1"]
    assert least is not None
    return 1e3 * least.too_little


def acceleration_of_the_wall() -> Measured:
    """Measure the acceleration margin; the wall tips as a whole at its width over its height."""
    problem = _problem(_case(WALL, "exact"))

    def study() -> float:
        margin = acceleration(problem)
        assert margin is not None
        return margin.value

    return _measured(study, len(problem.bricks), WIDTH / (40 * THICKNESS))


def placement_of_the_wall() -> Measured:
    """Measure the placement margin [mm]; the error is the difference from the program of all bricks, for 20 x 20."""
    problem, smaller = (_problem(_case(each, "exact")) for each in (WALL, WALL.replace("40", "20")))
    folded = placement(smaller).value
    row = _measured(lambda: 1e3 * placement(problem).value, len(problem.bricks), 1.0)
    with patch("stability.analysis.placement_margin.LARGE", inf):
        whole = placement(smaller).value
    return {**row, "error_percent": 100.0 * abs(folded / whole - 1.0)}


def thesis_of_the_wall() -> Measured:
    """Measure a run of the wall by the published method; the result is the number of frozen bricks."""
    case = _case(WALL, "thesis")
    bricks = len(case.timeline.placements)
    return _measured(lambda: sum(row["state"] == "frozen" for row in play(case).table()), bricks, bricks)


def peer() -> Measured:
    """Measure one linear program of a smaller wall, which stands: 1."""
    problem = _problem(_case(WALL.replace("40", "10"), "exact"))
    boxes = []
    for placed in problem.bricks.values():
        box = as_box(placed.brick.shape, "the peer")
        boxes.append(UprightBox(placed.pose.position_W, box.size, placed.brick.mass))
    return _measured(lambda: float(answer(boxes, 0.5) is True), len(boxes), 1.0)


def _measured(study: Callable[[], float], bricks: int, known: float) -> Measured:
    began = process_time()
    result = study()
    seconds = process_time() - began
    error = 100.0 * abs(result / known - 1.0)
    peak = getrusage(RUSAGE_SELF).ru_maxrss / 1024.0
    return {"bricks": bricks, "seconds": seconds, "peak_mb": peak, "result": result, "error_percent": error}


def _case(build: str, system: str) -> Case:
    text = f"scenario: study\nfriction: 0.5\nsystems: [{system}]\nbuild:\n  - {build}\n"
    cases, mistakes = cases_of(parse(text, "study.yaml"))
    assert not mistakes, mistakes
    return cases[0]


def _problem(case: Case) -> Problem:
    return proofs_of(case.timeline).assembly.problem()


STUDIES: Final[Mapping[str, Callable[[], Measured]]] = {
    "sensitivities of a wall of 12 levels": sensitivities_of_a_wall,
    "least shifts in a falling column": shift_of_a_column,
    "acceleration margin of the wall": acceleration_of_the_wall,
    "placement margin of the wall": placement_of_the_wall,
    "run of the wall on `thesis`": thesis_of_the_wall,
    PEER: peer,
}


if __name__ == "__main__":
    main()
