"""The page of a bench: paces in times of exact, and a picture where there is one."""

from dataclasses import replace

from stackdsl.bench.conduct import Bench
from stackdsl.bench.page import bench_page
from stackdsl.bench.points import points_of
from stackdsl.bench.scoring import scores_of
from tests.stackdsl.bench.runs import SHOULD_STAND, run


def test_the_page_tells_paces_in_times_of_exact() -> None:
    runs = [replace(run(system="exact"), wall_time=0.01), run()]  # 4 s in 0.01 s, and in 2 s
    scores = tuple(scores_of(runs, {"tower": SHOULD_STAND}))
    found = Bench(scores, tuple(points_of(scores)), {"tower": SHOULD_STAND}, {}, wanted=2, interrupted=False)
    page = bench_page(found, drawn=True)
    assert "### tower: stands, truth" in page
    exact, tuned = (line.split(" | ") for line in page.splitlines()[-2:])
    assert exact[-1].startswith("1 ")
    assert tuned[-1].startswith("200 ")


def test_the_page_shows_the_picture_only_where_there_is_one() -> None:
    nothing = Bench((), (), {}, {}, wanted=1, interrupted=False)
    assert "speed-against-error.svg" in bench_page(nothing, drawn=True)
    assert "speed-against-error.svg" not in bench_page(nothing, drawn=False)
