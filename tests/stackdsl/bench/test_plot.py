"""Speed against error as a picture: zeros in a band of their own, the same bytes every time."""

import pytest

from stackdsl.bench.plot import PlotMissingError, drawn, floor_of, shown_at
from stackdsl.bench.points import points_of
from stackdsl.bench.scoring import scores_of
from tests.stackdsl.bench.runs import FELL, SHOULD_STAND, run


@pytest.mark.parametrize(
    ("errors", "floor_at"), [([0.02, 3.0], 0.01), ([0.0, 0.01], 0.001), ([0.0], 0.1), ([5e-300], 1e-9), ([70.0], 1.0)]
)
def test_zero_errors_lie_in_a_band_below_all_others(errors: list[float], floor_at: float) -> None:
    assert floor_of(errors) == pytest.approx(floor_at)
    assert shown_at(0.0, floor_of(errors)) < floor_of(errors)
    assert all(shown_at(error, floor_of(errors)) == error for error in errors if error > 1e-9)


def test_a_plot_is_drawn_or_it_is_told_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    with pytest.raises(PlotMissingError, match=r"pip install 'stackdsl\[bench\]'"):
        drawn(points_of(scores_of([run()], {"tower": SHOULD_STAND})))


def test_the_plot_is_the_same_whenever_it_is_drawn() -> None:
    pytest.importorskip("matplotlib")
    runs = [run(), run(FELL, system="stock"), run(system="exact", largest_shift=0.0)]
    points = points_of(scores_of(runs, {"tower": SHOULD_STAND}))
    one, other = drawn(points), drawn(points)
    assert one == other
    assert [*one] == ["speed-against-error.png", "speed-against-error.svg"]
    assert one["speed-against-error.png"].startswith(b"\x89PNG")
