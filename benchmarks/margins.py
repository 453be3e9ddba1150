"""Measures the cost of the margins of a four-stack of 100 planks: medians, and the gap between the bounds of each.

Run it with `python -m benchmarks.margins`; quote the ratios, since machines differ and are shared.
"""

from collections.abc import Callable
from statistics import median
from time import perf_counter

from rich.console import Console
from rich.table import Table

from stability.analysis.acceleration_margin import acceleration
from stability.analysis.margins import least_friction
from stability.analysis.placement_margin import placement
from tests.stability.analysis.margin_scenes import four_stack, upright_boxes

LEVELS = 50
RUNS = 5


def main() -> None:
    """Measure and print the table; write it on request."""
    problem = upright_boxes(four_stack(LEVELS))

    def shaken(tolerance: float) -> str:
        margin = acceleration(problem, tolerance)
        assert margin is not None
        return f"{margin.value:.7g} g, open {1.0 - margin.value / margin.upper:.1e}, {margin.headings} directions"

    asked: dict[str, Callable[[], str]] = {
        "acceleration within 1 %": lambda: shaken(1e-2),
        "acceleration within 1e-6": lambda: shaken(1e-6),
        "least friction": lambda: f"{least_friction(problem).factor:g}",
        "placement": lambda: f"{1000.0 * placement(problem).value:.4g} mm",
    }
    table = Table("margin of 100 planks", "value", "median s")
    for name, ask in asked.items():
        value, seconds = "", []
        for _ in range(RUNS):
            start = perf_counter()
            value = ask()
            seconds.append(perf_counter() - start)
        table.add_row(name, value, f"{median(seconds):.3f}")
    Console().print(table)


if __name__ == "__main__":
    main()
