"""Measures cost and error of exact statics. Run it with `python -m benchmarks.statics`.

Times are medians over repeats of processor time, which depends least on other processes. Machines differ: compare a
figure with others of the same run.
"""

import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import inf, pi
from os import times
from statistics import mean, median
from subprocess import run
from time import process_time

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.figures.data import Row
from benchmarks.figures.pages import ROOT
from benchmarks.figures.recording import parser, record
from benchmarks.plank_structures import LENGTH, THICKNESS, WIDTH, four_stack, plank_at, stepped_columns, wall
from stability.analysis.acceleration_margin import acceleration
from stability.problem import Placed, Stability, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.proof import check_forces
from tests.stability.statics.independent import independent_verdict
from tests.stability.statics.random_piles import FRICTION, pile_of

MANY = 10_000  # planks
NARROW = 0.06  # [m] spacing at which the ends of the planks of a four-stack extend beyond the level below
PILES, PILE = 30, 30
MILLISECOND, MICROSECOND = 1e3, 1e6


@dataclass(frozen=True, slots=True)
class Line:
    """One line of the table."""

    what: str
    seconds: float
    target: float  # [s] upper limit of the time; infinite without one
    error: float  # residual of the checked forces, relative to the load of a brick; or as `of` states
    of: str = "residual"

    @property
    def values(self) -> Row:
        """Return the values as data."""
        return {"cost_ms": MILLISECOND * self.seconds, "error": self.error, "error_of": self.of}


def main() -> None:
    """Measure and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    table = Table("what", "cost", "to be at most", "error")
    console, lines = Console(), []
    for measure in MEASURES:
        for line in measure():
            lines.append(line)
            target = "" if line.target == inf else _duration(line.target)
            table.add_row(line.what, _duration(line.seconds), target, f"{line.error:.0e} {line.of}")
            console.print(f"{line.what}: {_duration(line.seconds)}", style="dim", soft_wrap=True)
    console.print(table)
    if write:
        rows = {line.what: line.values for line in lines}
        record("statics", "python -m benchmarks.statics --write", {"costs": rows})


def _duration(seconds: float) -> str:
    if seconds < 1e-3:  # noqa: PLR2004 -- [s] a millisecond
        return f"{seconds * MICROSECOND:.0f} µs"
    return f"{seconds * MILLISECOND:.3g} ms" if seconds < 1.0 else f"{seconds:.2f} s"


def one_more() -> Iterable[Line]:
    """Add one more plank to a proven four-stack: one that its load core proves, and one that it does not."""
    tower = four_stack(MANY)
    yield _one_more("by load core", tower, plank_at("more", (0.0, 0.04), MANY // 2 + 1), 50e-6)
    # Across the ends of the two topmost planks, its centre 6 mm beyond their support: their own weight holds it.
    top_is_turned = (MANY // 2) % 2 == 0
    at = (0.0, 0.048) if top_is_turned else (0.048, 0.0)
    more = plank_at("more", at, MANY // 2 + 1, yaw=0.0 if top_is_turned else 0.5 * pi)
    yield _one_more("held by the weight of others", four_stack(MANY, NARROW), more, 1e-3)


def _one_more(how: str, tower: Sequence[Placed], more: Placed, target: float) -> Line:
    assembly = Assembly(friction=FRICTION)
    assembly.add_all(tower)
    seconds = []
    for _ in range(51):
        started = process_time()
        verdict = assembly.add(more.brick, more.pose)
        seconds.append(process_time() - started)
        assert verdict.stability is Stability.STABLE
        assembly.remove(["more"])
    assembly.add(more.brick, more.pose)
    return Line(f"one more plank on {MANY}, {how}", median(seconds), target, residual(assembly))


def building() -> Iterable[Line]:
    """Add ten thousand planks one by one, each with a verdict."""
    for name, planks in (("four-stack", four_stack(MANY)), ("wall", wall(MANY, across=100))):
        seconds, assembly = [], Assembly()
        for _ in range(3):
            assembly = Assembly(friction=FRICTION)
            started = process_time()
            verdicts = [assembly.add(each.brick, each.pose).stability for each in planks]
            seconds.append(process_time() - started)
            assert set(verdicts) == {Stability.STABLE}
        yield Line(f"{name} of {MANY}, brick by brick", median(seconds), 2.0, residual(assembly))


def random_placements() -> Iterable[Line]:
    """Add planks of random piles one by one; falling bricks are removed. Every verdict is checked."""
    seconds: list[float] = []
    wrong = undecided = unknown = 0
    for number in range(PILES):
        assembly = Assembly(friction=FRICTION)
        for each in pile_of(np.random.default_rng([3, number]), PILE, care=0.7, askew=0.5):
            started = process_time()
            verdict = assembly.add(each.brick, each.pose)
            seconds.append(process_time() - started)
            checked = independent_verdict(assembly.bricks.values(), FRICTION)
            undecided += verdict.stability is Stability.UNDECIDED
            unknown += checked is None
            wrong += checked is not None and verdict.stability not in (checked, Stability.UNDECIDED)
            while verdict.stability is not Stability.STABLE:
                verdict = assembly.remove(verdict.moving)
    of = f"wrong, {undecided} undecided of {len(seconds)}; the check could not judge {unknown}"
    for name, value, target in (
        ("mean", mean(seconds), 0.5e-3),
        ("median", median(seconds), inf),
        ("99 %", float(np.quantile(seconds, 0.99)), 10e-3),
    ):
        yield Line(f"random piles of {PILE}, one placement, {name}", value, target, wrong, of)


def cold() -> Iterable[Line]:
    """Judge bricks that are placed together, without caches."""
    builders: dict[str, Callable[[int], list[Placed]]] = {
        "four-stack": four_stack,
        "wall": lambda count: wall(count, across=max(10, count // 100)),
        "stepped columns": stepped_columns,
    }
    for name, build in builders.items():
        for count, target in ((100, 10e-3), (1000, 100e-3), (MANY, 2.0)):
            planks, seconds, assembly = build(count), [], Assembly()
            for _ in range(9 if count < MANY else 3):
                assembly = Assembly(friction=FRICTION)
                started = process_time()
                verdict = assembly.add_all(planks)
                seconds.append(process_time() - started)
                assert verdict.stability is Stability.STABLE
            yield Line(f"cold verdict, {name} of {count}", median(seconds), target, residual(assembly))


def worst_direction() -> Iterable[Line]:
    """Compare the acceleration of a four-stack of 100 planks in the worst direction with its closed form."""
    assembly = Assembly(friction=FRICTION)
    assembly.add_all(four_stack(100))
    problem, seconds, value = assembly.problem(), [], 0.0
    for _ in range(5):
        started = process_time()
        margin = acceleration(problem, tolerance=0.01)
        seconds.append(process_time() - started)
        value = 0.0 if margin is None else margin.value
    # All bricks except the far plank of the lowest level tip about the outer edge of the near one, whose centre is W /
    # 2 inside: 98 planks, centre L / 2 inside and (2 + 50 - 1) / 2 levels up, and that plank.
    inside = 98 * 0.5 * LENGTH + 0.5 * WIDTH
    up = (98 * 25.5 + 0.5) * THICKNESS
    off = abs(value / (inside / up) - 1.0)
    yield Line("worst-direction margin of 100 planks", median(seconds), 0.3, off, f"of {inside / up:.4f} g")


def checked_record() -> Iterable[Line]:
    """Measure `stackdsl check` of the record tower, with and without the start of Python."""
    whole, started = [], []
    for _ in range(3):
        whole.append(_command("check", "scenarios/record-tower.yaml"))
        started.append(_command("--version"))
    yield Line("check of the record tower, including the start of Python", median(whole), inf, 0.0, "drift")
    yield Line("check of the record tower", median(whole) - median(started), inf, 0.0, "drift")


def _command(*arguments: str) -> float:
    """Return the processor time of the command, which must not fail [s]."""
    before = _of_children()
    run([sys.executable, "-m", "stackdsl", *arguments], cwd=ROOT, check=True, capture_output=True)
    return _of_children() - before


def _of_children() -> float:
    spent = times()
    return spent.children_user + spent.children_system


def residual(assembly: Assembly) -> float:
    """Return the largest residual of the proof, relative to the load of the brick, by plain arithmetic."""
    forces = assembly.forces()
    assert forces is not None
    check = check_forces(assembly.problem(), forces, Tolerances())
    assert check.holds
    return check.residual


MEASURES = (one_more, building, random_placements, cold, worst_direction, checked_record)

if __name__ == "__main__":
    main()
