"""One point for every system and step: speed, the largest errors, and which points nobody beats."""

from dataclasses import replace

import pytest

from benchmarks.systems.points import fronts_of, pareto_front, points_of
from benchmarks.systems.scoring import scores_of
from benchmarks.systems.table import point_rows
from tests.benchmarks.systems.runs import FELL, SHOULD_STAND, run


@pytest.mark.parametrize(
    ("points", "front"),
    [
        ([(1.0, 1.0)], [0]),
        ([(1.0, 3.0), (2.0, 2.0), (3.0, 1.0)], [0, 1, 2]),
        ([(3.0, 1.0), (1.0, 3.0), (2.0, 3.5), (2.5, 2.5)], [1, 3, 0]),
        ([(1.0, 0.0), (2.0, 0.0)], [0]),  # the same error for less
        ([(1.0, 2.0), (1.0, 1.0)], [1]),  # less error for the same
        ([(1.0, 1.0), (1.0, 1.0)], [0, 1]),  # neither beats its equal
        ([], []),
    ],
)
def test_the_pareto_front_is_what_nobody_beats(points: list[tuple[float, float]], front: list[int]) -> None:
    assert pareto_front(points) == front


def test_a_point_counts_wrong_verdicts_and_tells_the_largest_errors() -> None:
    runs = [replace(run(), case=case) for case in ("a", "b")] + [replace(run(FELL), case="c")]
    (point,) = points_of(scores_of(runs, dict.fromkeys("abc", SHOULD_STAND)))
    assert (point.runs, point.done, point.known, point.wrong_verdicts) == (3, 3, 3, 1)
    assert point.errors["wrong"] == pytest.approx(100.0 / 3.0)
    assert point.errors["creep"] == 200.0
    assert point.errors["deg"] is None
    assert point.pace == pytest.approx(0.5)  # 2 s for 4 s
    assert point.wall_time == 6.0


def test_a_point_tells_the_usual_update_and_the_worst_of_all() -> None:
    updates = {"a": (0.001, 0.5), "b": (0.002, 0.1), "c": (0.009, 0.2), "d": (None, None)}
    runs = [replace(run(), case=case, update_median=one, update_worst=most) for case, (one, most) in updates.items()]
    (point,) = points_of(scores_of(runs, dict.fromkeys("abcd")))
    assert (point.update_median, point.update_worst) == (0.002, 0.5)
    (row,) = point_rows([point])
    assert (row["update ms"], row["worst ms"]) == ("2", "500")
    (none,) = points_of(scores_of([run()], {"tower": None}))
    assert (none.update_median, none.update_worst) == (None, None)
    assert point_rows([none])[0]["worst ms"] == "-"


def test_paces_are_of_the_cases_that_all_have_done() -> None:
    # The other system never finished the dear case, and must not look fast for it.
    dear = replace(run(), case="dear", wall_time=400.0)
    stopped = replace(run(system="stock"), case="dear", observations=None, status="timed out")
    points = points_of(scores_of([run(), dear, run(system="stock"), stopped], dict.fromkeys(("tower", "dear"))))
    assert [point.pace for point in points] == [pytest.approx(0.5), pytest.approx(0.5)]
    assert [point.done for point in points] == [2, 1]


def test_points_go_from_coarse_to_fine() -> None:
    points = points_of(scores_of([run(factor=factor) for factor in (0.5, 2.0, 1.0)], {"tower": SHOULD_STAND}))
    assert [point.name for point in points] == ["tuned, step x 2", "tuned, step x 1", "tuned, step / 2"]


def test_only_what_is_measured_has_a_front() -> None:
    points = points_of(scores_of([run()], {"tower": SHOULD_STAND}))
    assert list(fronts_of(points)) == ["wrong", "levels", "creep"]
