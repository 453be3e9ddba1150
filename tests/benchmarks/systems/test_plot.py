"""Speed against error as a picture: zeros in a band of their own, the same bytes every time."""

import pytest

from benchmarks.systems.plot import drawn, floor_of
from benchmarks.systems.points import points_of
from benchmarks.systems.scoring import scores_of
from tests.benchmarks.systems.runs import FELL, SHOULD_STAND, run


@pytest.mark.parametrize(
    ("errors", "floor_at"), [([0.02, 3.0], 0.01), ([0.0, 0.01], 0.001), ([0.0], 0.1), ([5e-300], 1e-9), ([70.0], 1.0)]
)
def test_zero_errors_lie_in_a_band_below_all_others(errors: list[float], floor_at: float) -> None:
    assert floor_of(errors) == pytest.approx(floor_at)
    assert all(error > floor_of(errors) for error in errors if error > 1e-9)


def test_the_plot_is_the_same_whenever_it_is_drawn() -> None:
    runs = [run(), run(FELL, system="stock"), run(system="exact", largest_shift=0.0)]
    points = points_of(scores_of(runs, {"tower": SHOULD_STAND}))
    assert drawn(points) == drawn(points)
    assert b"Pareto front" in drawn(points)
