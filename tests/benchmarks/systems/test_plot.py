"""Speed against error as a picture: zeros in a band of their own, the same bytes every time."""

import pytest

from benchmarks.figures.data import load
from benchmarks.figures.pages import ROOT
from benchmarks.systems.bench import Bench
from benchmarks.systems.measured import NAME, PICTURE, data_of
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


def test_the_picture_shows_the_stored_points_of_each_system() -> None:
    runs = [run(), run(FELL, system="stock"), run(system="exact", largest_shift=0.0)]
    scores = tuple(scores_of(runs, {"tower": SHOULD_STAND}))
    rows = data_of(Bench(scores, tuple(points_of(scores)), {"tower": SHOULD_STAND}, {}, 4, interrupted=False))[0].tables
    picture = drawn(rows["points"])
    assert picture == drawn(rows["points"])
    assert all(f">{name}</text>".encode() in picture for name in ("tuned", "stock", "exact", "Pareto front"))
    assert b"prefers-color-scheme:dark" in picture


def test_the_picture_of_the_docs_is_drawn_from_the_stored_points() -> None:
    assert (ROOT / "docs" / PICTURE).read_bytes() == drawn(load(NAME).tables["points"])
