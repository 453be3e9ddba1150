"""Speed against error: what is known, how far off a run is, which points nobody beats, how it goes on after a stop."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path

import pytest

from stackdsl.bench import conduct
from stackdsl.bench.answers import Answer, Source, answer_of
from stackdsl.bench.conduct import Bench, Job, Plan, bench, jobs_of, versions
from stackdsl.bench.journal import Journal
from stackdsl.bench.measuring import ENOUGH, MOST_RUNS, enough
from stackdsl.bench.page import bench_page
from stackdsl.bench.plot import PlotMissingError, draw, floor_of, shown_at
from stackdsl.bench.points import fronts_of, pareto_front, points_of
from stackdsl.bench.record import MalformedRecordError, Record, TruthHeld, line_of, record_of
from stackdsl.bench.scoring import LOOKS_APART, numerical_reason, reference_of, scores_of
from stackdsl.bench.summary import bench_json
from stackdsl.bench.table import bench_text
from stackdsl.gathering import Case
from stackdsl.observations import KINDS, Seen
from stackdsl.outcome import RunStatus
from stackdsl.playing.runner import play
from stackdsl.playing.systems import SYSTEMS
from stackdsl.pool import PoolResult, Task, TaskResult, TaskStatus, run_supervised
from tests.scenes import compiled, scene

STOOD: dict[str, Seen] = {
    **dict.fromkeys(KINDS),
    "verdict": "stands",
    "fallen": (),
    "drift": 0.25,
    "largest tilt": 0.0,
    "height": 39.0,
    "energy gain": 0.5,
    "shift before": 0.125,
}
FELL: dict[str, Seen] = {
    **STOOD,
    "verdict": "collapses",
    "collapse level": 3.0,
    "collapse time": 2.1,
    "first to leave": "L3.1",
    "fallen": ("L2.1", "L3.1"),
    "drift": 200.0,
    "reach": 80.0,
    "bearing": 179.0,
}
RECORD = Record(
    id="0123",
    case="tower",
    file="tower.yaml",
    system="tuned",
    factor=1.0,
    settings={"time_step": 0.001, "friction_anchor": True, "most_travel": None},
    versions={"python": "3.11"},
    status="done",
    levels=5,
    observations=STOOD,
    wall_time=2.0,
    runs=1,
    simulated_time=4.0,
    steps=4000,
    peak_memory=2**20,
)
SHOULD_STAND = Answer(stands=True, source=Source.TRUTH, undisturbed=True)
SHOULD_FALL = Answer(stands=False, source=Source.TRUTH, least=3.0, most=3.0)


def run(seen: Mapping[str, Seen] = STOOD, system: str = "tuned", factor: float = 1.0, **more: Seen) -> Record:
    seen = dict(seen) | {name.replace("_", " "): value for name, value in more.items()}
    return replace(RECORD, id=f"{system} {factor}", system=system, factor=factor, observations=seen)


def case_of(build: str, rest: str = "expect:\n  - stands: all\n") -> Case:
    cases, mistakes = compiled(scene(build, rest))
    assert mistakes == []
    return cases[0]


# --- what is known ----------------------------------------------------------------------------------------------------

ANSWERS = {
    "statics prove that it stands": ("- column: {levels: 3}", "", Answer(True, Source.STATICS, undisturbed=True)),
    # Planks stepped by 40 mm: the first too many is number floor(117.6 / 40) + 1 = 3.
    "statics name the level": (
        "- column: {levels: 4, step: 40 mm}\n  every: 1 s",
        "",
        Answer(False, Source.STATICS, 3.0, 3.0, undisturbed=True),
    ),
    "truth comes first": (
        "- column: {levels: 3}",
        "truth:\n  - collapses: {at: level 2 ± 1}\n    source: a test\n",
        Answer(False, Source.TRUTH, 1.0, 3.0, undisturbed=True),
    ),
    "nobody knows where what is dropped lands": (
        "- column: {levels: 1}\n- bricks: [{at: [0 mm, 0 mm, 40 mm], drop: true}]\n  after: built + 1 s",
        "",
        None,
    ),
}


@pytest.mark.parametrize(("build", "rest", "known"), ANSWERS.values(), ids=ANSWERS)
def test_an_answer_comes_from_truth_or_from_statics(build: str, rest: str, known: Answer | None) -> None:
    case = case_of(build, "expect:\n  - stands: all\n" + rest)
    assert answer_of(case.scenario, case.timeline) == known


@pytest.mark.parametrize(
    ("answer", "fell_at", "off"),
    [
        (Answer(True, Source.TRUTH), None, 0.0),
        (Answer(True, Source.TRUTH), 7.0, 19.0),  # 6 of 25 levels held
        (Answer(False, Source.TRUTH, 8.0, 10.0), 9.0, 0.0),
        (Answer(False, Source.TRUTH, 8.0, 10.0), 12.0, 2.0),
        (Answer(False, Source.TRUTH, 8.0, 10.0), 4.0, 4.0),
        (Answer(False, Source.TRUTH, 8.0, 10.0), None, 16.0),  # as if it fell at the 26th
        (Answer(False, Source.TRUTH), 4.0, 0.0),  # where it falls is not known
        (Answer(False, Source.TRUTH, 8.0, inf), 6.0, 2.0),
    ],
)
def test_an_error_in_levels_is_the_distance_from_what_is_true(answer: Answer, fell_at: float, off: float) -> None:
    assert answer.levels_off(fell_at, 25) == off


# --- how far a run is from it -----------------------------------------------------------------------------------------


def test_creep_is_the_largest_shift_of_what_should_stand_whether_it_falls_or_not() -> None:
    stood, fell = scores_of([run(), run(FELL, factor=2.0)], {"tower": SHOULD_STAND})
    assert (stood.wrong, stood.creep, stood.levels, stood.energy) == (False, 0.25, 0.0, 0.5)
    assert (fell.wrong, fell.creep, fell.levels) == (True, 200.0, 3.0)


def test_creep_of_what_should_fall_is_what_moved_before_the_brick_came_with_which_it_does() -> None:
    known = replace(SHOULD_FALL, undisturbed=True)
    assert scores_of([run(FELL, shift_before=0.125)], {"tower": known})[0].creep == 0.125
    assert scores_of([run(FELL)], {"tower": SHOULD_FALL})[0].creep is None  # it was hit


def test_what_falls_before_it_should_is_wrong_though_it_should_fall() -> None:
    early = replace(run(FELL), numerical="statics prove that it stands")
    assert [score.wrong for score in scores_of([run(FELL), early], {"tower": SHOULD_FALL})] == [False, True]


def test_truths_tell_lengths_of_runs_with_the_right_verdict_alone() -> None:
    truths = (TruthHeld("height", "mm", 0.5, False), TruthHeld("rests_on", "", None, True))
    right, wrong = (replace(run(seen), truths=truths) for seen in (STOOD, FELL))
    assert scores_of([right], {"tower": SHOULD_STAND})[0].mm == 0.5
    assert scores_of([wrong], {"tower": SHOULD_STAND})[0].mm is None


def test_the_converged_reference_is_what_the_two_finest_runs_of_a_bare_engine_agree_on() -> None:
    finest, finer = run(FELL, factor=0.25), run(FELL, factor=0.5, collapse_time=2.11, reach=120.0)
    reference = reference_of([run(FELL, factor=1.0, collapse_level=5.0), finer, finest], SHOULD_FALL)
    assert reference is not None
    assert (reference.system, reference.factor) == ("tuned", 0.25)
    assert reference.observations["collapse time"] == 2.1
    assert "reach" not in reference.observations  # 80 mm and 120 mm do not agree


@pytest.mark.parametrize(
    "records",
    [
        [run(FELL, factor=0.25), run(STOOD, factor=0.5)],  # they do not agree
        [run(FELL, factor=0.25)],  # there is one only
        [run(STOOD, factor=0.25), run(STOOD, factor=0.5)],  # they agree on what is not true
        [run(FELL, system="exact", factor=0.25), run(FELL, system="exact", factor=0.5)],  # no bare engine
        [run(FELL, factor=0.25), replace(run(factor=0.5), observations=None)],  # one is not done
    ],
)
def test_there_is_no_reference_without_convergence(records: Sequence[Record]) -> None:
    assert reference_of(records, SHOULD_FALL) is None


def test_the_moving_part_is_held_against_the_reference() -> None:
    fine = [run(FELL, factor=0.25), run(FELL, factor=0.5)]
    own = run(FELL, system="exact", collapse_time=2.13, reach=76.0, bearing=-178.0)
    score = scores_of([*fine, own], {"tower": SHOULD_FALL})[2]
    assert score.seconds == pytest.approx(0.03 - LOOKS_APART)
    assert score.mm == pytest.approx(4.0)
    assert score.deg == pytest.approx(3.0)  # across the half turn
    assert scores_of(fine, {"tower": SHOULD_FALL})[0].mm is None  # the reference has no distance from itself


def test_a_time_that_is_known_is_better_than_that_of_a_reference() -> None:
    known = replace(SHOULD_FALL, earliest=2.5, latest=2.6)
    records = [run(FELL, factor=0.5), run(FELL, factor=0.25), run(FELL, "exact", collapse_time=2.55)]
    seconds = [score.seconds for score in scores_of(records, {"tower": known})]
    assert seconds == [pytest.approx(0.4), pytest.approx(0.4), 0.0]


def test_runs_that_see_a_fall_at_times_more_than_a_look_apart_have_not_converged() -> None:
    fine, coarse, own = run(FELL, factor=0.25), run(FELL, factor=0.5, collapse_time=2.08), run(FELL, "exact")
    assert scores_of([fine, coarse, own], {"tower": SHOULD_FALL})[2].seconds is None
    coarse = run(FELL, factor=0.5, collapse_time=2.09)
    assert scores_of([fine, coarse, own], {"tower": SHOULD_FALL})[2].seconds == 0.0


def test_what_nobody_knows_is_known_from_converged_runs() -> None:
    fine = [run(factor=0.25), run(factor=0.5), run(system="exact", height=41.0), run(FELL, system="stock")]
    scores = scores_of(fine, {"tower": None})
    assert [score.known for score in scores] == [Source.CONVERGED] * 4
    assert [score.wrong for score in scores] == [False, False, False, True]
    assert scores[2].mm == pytest.approx(2.0)
    assert scores[2].creep is None  # a shift is none of creep where something lands


def test_nothing_is_right_or_wrong_where_nothing_is_known() -> None:
    assert scores_of([run()], {"tower": None})[0].wrong is None


def test_a_collapse_that_the_next_finer_step_lets_stand_is_numerical() -> None:
    coarse, fine = scores_of([run(FELL, factor=2.0), run(factor=1.0)], {"tower": None})
    assert (coarse.verdict, fine.verdict) == ("numerical-collapse", "stands")
    assert "finer time step than step x 2" in numerical_reason(coarse)


def test_a_collapse_that_is_true_is_not_numerical_however_wrong_a_finer_run_is() -> None:
    coarse, fine = scores_of([run(FELL, factor=2.0), run(factor=1.0)], {"tower": SHOULD_FALL})
    assert (coarse.verdict, coarse.wrong, fine.wrong) == ("collapses", False, True)


# --- points and fronts ------------------------------------------------------------------------------------------------


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


# --- measuring --------------------------------------------------------------------------------------------------------


def test_what_takes_no_time_is_measured_several_times() -> None:
    assert enough(2.0 * ENOUGH, iter([])) == [2.0 * ENOUGH]
    assert enough(0.4 * ENOUGH, iter([0.4 * ENOUGH, 0.4 * ENOUGH, 9.0])) == [0.4 * ENOUGH] * 3
    assert len(enough(1e-6, iter([1e-6] * 100))) == MOST_RUNS


@pytest.mark.parametrize(("fresh", "processes"), [(True, 3), (False, 1)])
def test_each_measurement_has_a_process_of_its_own(fresh: bool, processes: int) -> None:
    pool = run_supervised([Task(os.getpid, (), 60.0)] * 3, 1, fresh=fresh)
    assert len({result.value for result in pool.results}) == processes


# --- the journal ------------------------------------------------------------------------------------------------------


def test_a_record_survives_its_line() -> None:
    record = replace(run(FELL), truths=(TruthHeld("height", "mm", None, False),), message="x\ny")
    assert record_of(line_of(record)) == record
    assert "\n" not in line_of(record)


@pytest.mark.parametrize("line", ["", "{", "[]", "{}", line_of(RECORD)[:-20], line_of(RECORD).replace('"case"', '"c"')])
def test_a_line_that_is_no_record_is_told(line: str) -> None:
    with pytest.raises(MalformedRecordError):
        record_of(line)


def test_a_journal_goes_on_with_what_is_done_and_wanted(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "out")
    journal.begin()
    done, unwanted = run(), run(factor=2.0)
    failed = replace(run(factor=4.0), observations=None, status="timed out")
    for record in (done, unwanted, failed):
        journal.add(record)
    with journal.path.open("a", encoding="utf-8") as file:
        file.write(line_of(run(factor=8.0))[:50])  # the power went
    assert journal.go_on({done.id, failed.id, "tuned 8.0"}) == [done]
    assert journal.path.read_text(encoding="utf-8") == line_of(done) + "\n"


def test_runs_that_were_put_aside_are_found_when_they_are_wanted_again(tmp_path: Path) -> None:
    journal, both = Journal(tmp_path), {run().id, run(factor=2.0).id}
    for record in (run(), run(factor=2.0)):
        journal.add(record)
    assert journal.go_on({run().id}) == [run()]
    assert journal.go_on({run().id}) == [run()]
    assert journal.aside.read_text(encoding="utf-8") == line_of(run(factor=2.0)) + "\n"
    assert {record.id for record in journal.go_on(both)} == both
    assert not journal.aside.exists()


def test_a_bench_that_begins_anew_keeps_the_last_one(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    for record in (run(), run(factor=2.0)):
        journal.begin()
        journal.add(record)
    assert (tmp_path / "runs.jsonl.old").read_text(encoding="utf-8") == line_of(run()) + "\n"
    assert journal.go_on({"tuned 2.0"}) == [run(factor=2.0)]


# --- the whole, without an engine -------------------------------------------------------------------------------------


def jobs() -> list[Job]:
    return jobs_of([case_of("- column: {levels: 1}")], ["exact", "tuned"], [1.0, 0.5])


def doing(only: int, asked: list[Task]) -> Callable[..., PoolResult]:
    """A pool that is interrupted after so many tasks."""

    def supervised(tasks: Sequence[Task], workers: int, on_done: Callable[..., None], fresh: bool) -> PoolResult:
        asked.extend(tasks)
        results = [TaskResult(TaskStatus.CRASHED, message="for want of an engine")] * len(tasks)
        for index, result in enumerate(results[:only]):
            on_done(index, result)
        return PoolResult(tuple(results), interrupted=only < len(tasks))

    return supervised


@pytest.mark.parametrize(
    ("rest", "followed"),
    [
        ("truth:\n  - {collapses: {at: level 3}, source: closed form}\n", False),
        ("truth:\n  - {falls: {count: 2}, source: closed form}\n", True),
    ],
)
def test_a_collapse_is_followed_by_every_system_only_if_it_is_known_what_becomes_of_it(
    rest: str, followed: bool
) -> None:
    case = case_of("- column: {levels: 3, step: 45 mm}\n  every: 1 s", rest)
    for system in ("exact", "stock"):
        (job,) = jobs_of([case], [system], [1.0])
        trace = play(job.case.timeline, SYSTEMS[system])
        assert trace.collapse is not None
        assert (trace.cost.simulated_time > trace.collapse.time + 0.5) is followed


def test_what_is_hit_is_played_to_its_end_whatever_is_known() -> None:
    hit = "impacts:\n  - push: {brick: L1.1, impulse: [0.01 N*s, 0 N*s, 0 N*s]}\n"
    case = case_of("- column: {levels: 3}", hit + "expect:\n  - stands: all\n")
    assert jobs_of([case], ["exact"], [1.0])[0].case.timeline.aftermath


def test_every_case_is_played_on_every_system_at_every_step_whatever_its_scenario_names() -> None:
    assert [(job.name, job.system, job.factor) for job in jobs()] == [
        ("scene", "exact", 1.0),
        ("scene", "exact", 0.5),
        ("scene", "tuned", 1.0),
        ("scene", "tuned", 0.5),
    ]
    assert len({job.id for job in jobs()}) == 4
    assert [job.id for job in jobs()] == [job.id for job in jobs()]
    changed = jobs_of([case_of("- column: {levels: 2}")], ["exact"], [1.0])
    assert changed[0].id not in {job.id for job in jobs()}


def test_a_bench_that_was_interrupted_goes_on_with_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = Plan(Journal(tmp_path), resume=False, workers=1, time_limit=1.0)
    done = replace(RECORD, id=jobs()[0].id, case="scene", system="exact", versions=versions())
    stale = replace(done, id=jobs()[1].id, versions={"python": "2.7"})
    asked: list[Task] = []
    monkeypatch.setattr(conduct, "run_supervised", doing(1, asked))
    first = bench(jobs(), plan)
    assert (first.interrupted, len(first.scores), len(asked)) == (True, 1, 2)  # the first step of both systems
    for record in (done, stale):  # as if these had been played
        plan.journal.add(record)
    asked.clear()
    monkeypatch.setattr(conduct, "run_supervised", doing(4, asked))
    second = bench(jobs(), replace(plan, resume=True))
    assert [task.arguments[1:] for task in asked] == [("tuned", 1.0), ("exact", 0.5), ("tuned", 0.5)]
    assert [score.record.status for score in second.scores] == ["done"] + [RunStatus.CRASHED] * 3
    assert not second.interrupted


def test_what_takes_no_step_is_played_at_one_step_length(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = Plan(Journal(tmp_path), resume=True, workers=1, time_limit=1.0)
    proven = replace(RECORD, id=jobs()[0].id, case="scene", system="exact", versions=versions(), steps=0)
    plan.journal.add(proven)
    asked: list[Task] = []
    monkeypatch.setattr(conduct, "run_supervised", doing(4, asked))
    found = bench(jobs(), plan)
    assert [task.arguments[1:] for task in asked] == [("tuned", 1.0), ("tuned", 0.5)]
    copied = found.scores[1].record
    assert (copied.system, copied.factor, copied.wall_time) == ("exact", 0.5, proven.wall_time)
    assert copied.message == "no step is taken: as with step x 1"
    assert copied.settings["time_step"] == jobs()[1].settings["time_step"]


def test_what_did_not_finish_is_told_in_every_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conduct, "run_supervised", doing(1, []))
    found = bench(jobs(), Plan(Journal(tmp_path), resume=False, workers=1, time_limit=1.0))
    text = bench_text(found)
    assert "scene on exact, step x 1: crashed: for want of an engine" in text
    assert "0 of 4 runs done" in text
    assert "interrupted, go on with --resume" in text.splitlines()[-1]
    assert '"interrupted": true' in bench_json(found)
    assert "0 of 4 runs done" in bench_page(found, drawn=False)


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


# --- the plot ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("errors", "floor_at"), [([0.02, 3.0], 0.01), ([0.0, 0.01], 0.001), ([0.0], 0.1), ([5e-300], 1e-9), ([70.0], 1.0)]
)
def test_zero_errors_lie_in_a_band_below_all_others(errors: list[float], floor_at: float) -> None:
    assert floor_of(errors) == pytest.approx(floor_at)
    assert shown_at(0.0, floor_of(errors)) < floor_of(errors)
    assert all(shown_at(error, floor_of(errors)) == error for error in errors if error > 1e-9)


def test_a_plot_is_drawn_or_it_is_told_what_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    with pytest.raises(PlotMissingError, match=r"pip install 'stackdsl\[bench\]'"):
        draw(points_of(scores_of([run()], {"tower": SHOULD_STAND})), tmp_path)


def test_the_plot_is_the_same_whenever_it_is_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    runs = [run(), run(FELL, system="stock"), run(system="exact", largest_shift=0.0)]
    points = points_of(scores_of(runs, {"tower": SHOULD_STAND}))
    drawn = []
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        drawn.append([path.read_bytes() for path in draw(points, tmp_path / name)])
    assert drawn[0] == drawn[1]
    assert len(drawn[0]) == 2
