"""What exact statics costs, and how far each answer is off. Run it with `python -m benchmarks.statics`.

Medians over repeats. Machines differ and are shared: compare a figure with those of the same run.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import pi
from statistics import mean, median
from time import perf_counter

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.plank_structures import LENGTH, THICKNESS, WIDTH, four_stack, plank_at, stepped_columns, wall
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Stability, Tolerances
from stability.statics.margins.acceleration import acceleration
from stability.statics.proof import check_forces
from tests.stability.statics.independent import independent_verdict
from tests.stability.statics.random_piles import FRICTION, pile_of

MANY = 10_000  # planks
NARROW = 0.06  # [m] spacing at which the ends of the planks of a four-stack reach beyond the level below
PILES, PILE = 30, 30
MILLISECOND, MICROSECOND = 1e3, 1e6


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table."""

    what: str
    cost: str
    target: str
    error: str


def main() -> None:
    """Measure, and print the table."""
    table = Table("what", "cost", "to be at most", "error")
    console = Console()
    for measure in MEASURES:
        for row in measure():
            table.add_row(row.what, row.cost, row.target, row.error)
            console.print(f"{row.what}: {row.cost} ({row.error})", style="dim", soft_wrap=True)
    console.print(table)


def one_more() -> Iterable[Row]:
    """One more plank on a proven four-stack, proven by its load core, and not."""
    tower = four_stack(MANY)
    yield _one_more("by load core", tower, plank_at("more", (0.0, 0.04), MANY // 2 + 1), "50 µs")
    # Across the ends of the two topmost planks, its centre 6 mm beyond what these rest on: their own weight holds it.
    top_is_turned = (MANY // 2) % 2 == 0
    at = (0.0, 0.048) if top_is_turned else (0.048, 0.0)
    more = plank_at("more", at, MANY // 2 + 1, yaw=0.0 if top_is_turned else 0.5 * pi)
    yield _one_more("that others' weight must hold", four_stack(MANY, NARROW), more, "1 ms")


def _one_more(how: str, tower: Sequence[Placed], more: Placed, target: str) -> Row:
    assembly = Assembly(friction=FRICTION)
    assembly.add_all(tower)
    seconds = []
    for _ in range(51):
        started = perf_counter()
        verdict = assembly.add(more.brick, more.pose)
        seconds.append(perf_counter() - started)
        assert verdict.stability is Stability.STABLE
        stage = assembly.stage("more")
        assembly.remove(["more"])
    assembly.add(more.brick, more.pose)
    what = f"one more plank on {MANY}, {how} [{stage}]"
    return Row(what, f"{median(seconds) * MICROSECOND:.0f} µs", target, residual(assembly))


def building() -> Iterable[Row]:
    """Ten thousand planks, one by one, each judged."""
    for name, planks in (("four-stack", four_stack(MANY)), ("wall", wall(MANY, across=100))):
        seconds, assembly = [], Assembly()
        for _ in range(3):
            assembly = Assembly(friction=FRICTION)
            started = perf_counter()
            verdicts = [assembly.add(each.brick, each.pose).stability for each in planks]
            seconds.append(perf_counter() - started)
            assert set(verdicts) == {Stability.STABLE}
        yield Row(f"{name} of {MANY}, brick by brick", f"{median(seconds):.2f} s", "2 s", residual(assembly))


def random_placements() -> Iterable[Row]:
    """Random piles, one plank at a time; what falls is taken away. Every verdict is checked."""
    seconds: list[float] = []
    wrong = undecided = unknown = 0
    for number in range(PILES):
        assembly = Assembly(friction=FRICTION)
        for each in pile_of(np.random.default_rng([3, number]), PILE, care=0.7, askew=0.5):
            started = perf_counter()
            verdict = assembly.add(each.brick, each.pose)
            seconds.append(perf_counter() - started)
            checked = independent_verdict(assembly.bricks.values(), FRICTION)
            undecided += verdict.stability is Stability.UNDECIDED
            unknown += checked is None
            wrong += checked is not None and verdict.stability not in (checked, Stability.UNDECIDED)
            while verdict.stability is not Stability.STABLE:
                verdict = assembly.remove(verdict.moving)
    error = f"{wrong} wrong, {undecided} undecided of {len(seconds)}; {unknown} the check cannot tell"
    for name, value, target in (
        ("mean", mean(seconds), "0.5 ms"),
        ("median", median(seconds), ""),
        ("99 %", float(np.quantile(seconds, 0.99)), "10 ms"),
    ):
        yield Row(f"random piles of {PILE}, a placement, {name}", f"{value * MILLISECOND:.3f} ms", target, error)


def cold() -> Iterable[Row]:
    """Everything set down together and judged, from nothing."""
    builders: dict[str, Callable[[int], list[Placed]]] = {
        "four-stack": four_stack,
        "wall": lambda count: wall(count, across=max(10, count // 100)),
        "stepped columns": stepped_columns,
    }
    for name, build in builders.items():
        for count, target in ((100, "10 ms"), (1000, "100 ms"), (MANY, "2 s")):
            planks, seconds, assembly = build(count), [], Assembly()
            for _ in range(9 if count < MANY else 3):
                assembly = Assembly(friction=FRICTION)
                started = perf_counter()
                verdict = assembly.add_all(planks)
                seconds.append(perf_counter() - started)
                assert verdict.stability is Stability.STABLE
            cost = f"{median(seconds) * MILLISECOND:.1f} ms"
            yield Row(f"cold verdict, {name} of {count}", cost, target, residual(assembly))


def worst_direction() -> Iterable[Row]:
    """The worst-direction acceleration of a four-stack of 100 planks within 1 %, against its closed form."""
    assembly = Assembly(friction=FRICTION)
    assembly.add_all(four_stack(100))
    problem, seconds, value = assembly.problem(), [], 0.0
    for _ in range(5):
        started = perf_counter()
        margin = acceleration(problem, tolerance=0.01)
        seconds.append(perf_counter() - started)
        value = 0.0 if margin is None else margin.value
    # All but the far plank of the lowest level tips about the outer edge of the near one, whose centre is W / 2 inside:
    # 98 planks, centre L / 2 inside and (2 + 50 - 1) / 2 levels up, and that one.
    inside = 98 * 0.5 * LENGTH + 0.5 * WIDTH
    up = (98 * 25.5 + 0.5) * THICKNESS
    error = f"{abs(value / (inside / up) - 1.0):.0e} of {inside / up:.4f} g"
    yield Row("worst-direction margin of 100 planks", f"{median(seconds) * MILLISECOND:.0f} ms", "300 ms", error)


def residual(assembly: Assembly) -> str:
    """The worst residual of the proof, relative to what a brick carries, by plain arithmetic."""
    forces = assembly.forces()
    if forces is None:
        return "no forces"
    check = check_forces(assembly.problem(), forces, Tolerances())
    return f"residual {check.residual:.0e}, proof {'holds' if check.holds else 'FAILS'}"


MEASURES = (one_more, building, random_placements, cold, worst_direction)

if __name__ == "__main__":
    main()
