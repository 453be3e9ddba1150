"""Assessors of statics in a bench: what they are asked, what they do not take, and how that is told."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt

import pytest
from click.testing import CliRunner

from benchmarks.systems.answers import Answer, Source
from benchmarks.systems.assessment import MOVES, Assessment, Scene, assessed, contacts_in, refusal
from benchmarks.systems.bench import Bench, bench, jobs_of
from benchmarks.systems.compas import ASSESSORS, EDGES, FRICTIONS, Compas, Programme
from benchmarks.systems.entrants import ENTRANTS, NO_STEPS, Entrant, Judge
from benchmarks.systems.lmgc90 import Lmgc90
from benchmarks.systems.points import points_of
from benchmarks.systems.run_record import NOT_TAKEN, Record
from benchmarks.systems.scoring import scores_of
from benchmarks.systems.table import bench_text
from benchmarks.systems.timing import Played
from stability.engines.protocol import Package
from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Contact, Placed
from stackdsl.checking.cases import Case
from stackdsl.cli.main import app
from stackdsl.supervising.processes import OnWait, PoolResult
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus, WorkerStart
from stackdsl.timeline import Timeline
from tests.scenes import compiled, scene, timeline_of

LENGTH = 0.1176  # of a plank [m]
HERE = Package("sys", "")
NEEDS_COMPAS = pytest.mark.skipif(not ASSESSORS["cra"].package.installed, reason="compas_cra is not installed")
STEPPED = "- column: {levels: 4, step: 40 mm}\n  every: 1 s"  # floor(117.6 / 40) = 2 stand
DROPPED = "- column: {levels: 1}\n- bricks: [{at: [0 mm, 0 mm, 40 mm], drop: true}]\n  after: built + 1 s"


@dataclass(frozen=True)
class Ruler:
    """Knows columns alone: N planks, each a step further out, stand while N d <= L."""

    share: float = 1.0  # of the length that it allows; below 1 it is too strict
    name: str = "ruler"
    package: Package = HERE
    asked: list[int] = field(default_factory=list)  # how many bricks there were each time

    def refusal(self, contacts: Sequence[Contact]) -> str:
        return "it has planks on planks only" if any(len(contact.points_W) < 4 for contact in contacts) else ""

    def load(self) -> None:
        pass

    def stands(self, scene: Scene) -> bool:
        self.asked.append(len(scene.bricks))
        along = [placed.pose.position_W[0] for placed in scene.bricks]
        step = (max(along) - min(along)) / max(1, len(along) - 1)
        return len(along) * step <= self.share * LENGTH


def case_of(build: str, rest: str = "expect:\n  - stands: all\n") -> Case:
    cases, mistakes = compiled(scene(build, rest))
    assert mistakes == []
    return cases[0]


# --- what is asked ----------------------------------------------------------------------------------------------------


def test_an_assessor_is_asked_after_every_placement_until_it_says_that_it_falls() -> None:
    ruler = Ruler()
    assessment = assessed(timeline_of(STEPPED), ruler)
    assert (assessment.level, assessment.time) == (3, 2.0)
    assert ruler.asked == [1, 2, 3]
    assert (assessment.cost.judgements, assessment.cost.steps, assessment.cost.simulated_time) == (3, 0, 2.0)


def test_what_stands_is_followed_to_the_end() -> None:
    timeline = timeline_of("- column: {levels: 4, step: 20 mm}\n  every: 1 s")
    assessment = assessed(timeline, Ruler())
    assert assessment.level is None
    assert assessment.cost.simulated_time == timeline.end


def test_what_is_set_down_together_is_asked_of_together() -> None:
    ruler = Ruler()
    assert assessed(timeline_of("- column: {levels: 4, step: 20 mm}"), ruler).level is None
    assert ruler.asked == [4]


def test_an_assessor_judges_again_after_a_removal() -> None:
    ruler = Ruler()
    pulled = "impacts:\n  - after: built + 1 s\n    remove: {brick: L3.1}\n"
    assert assessed(timeline_of("- column: {levels: 3}", pulled), ruler).level is None
    assert ruler.asked == [3, 2]


def test_an_assessor_gives_verdict_and_level_and_no_motion() -> None:
    seen = assessed(timeline_of(STEPPED), Ruler()).observations
    assert {name: value for name, value in seen.items() if value is not None} == {
        "verdict": "collapses",
        "collapse level": 3.0,
    }


def test_a_fall_that_statics_disprove_is_called_so() -> None:
    timeline = timeline_of(STEPPED)
    strict, right = Judge(Ruler(share=0.5)), Judge(Ruler())
    told = strict.checked(strict.play(timeline, NO_STEPS), timeline)
    assert isinstance(told, Assessment)
    assert told.level == 2
    assert told.numerical == "statics prove that it stands"
    assert right.checked(right.play(timeline, NO_STEPS), timeline).numerical == ""


# --- what is not taken ------------------------------------------------------------------------------------------------

REFUSED: dict[str, tuple[str, str, str]] = {
    "what is dropped": (DROPPED, "", MOVES),
    "what is pushed": (
        "- column: {levels: 2}",
        "impacts:\n  - after: built + 1 s\n    push: {brick: L2.1, impulse: [0.01 N*s, 0 N*s, 0 N*s]}\n",
        MOVES,
    ),
    "an edge": ("- card_house: {levels: 1, angle: 70 deg}", "", EDGES),
    "a ground of other friction": ("- column: {levels: 2}", "world: {ground: {friction: 0.2}}\n", FRICTIONS),
}
TAKEN = {
    "one plank on a ground of other friction": ("- column: {levels: 1}", "world: {ground: {friction: 0.2}}\n"),
    "a slope": ("- column: {levels: 2}", "world: {tilt: 5 deg}\n"),
    "a stack": ("- four_stack: {levels: 3}", ""),
}


@pytest.mark.parametrize(("build", "rest", "why"), REFUSED.values(), ids=REFUSED)
def test_cases_that_compas_does_not_take_are_known_beforehand(build: str, rest: str, why: str) -> None:
    assert refusal(timeline_of(build, rest), Compas(Programme.CRA)) == why


@pytest.mark.parametrize(("build", "rest"), TAKEN.values(), ids=TAKEN)
def test_faces_that_share_one_friction_are_taken(build: str, rest: str) -> None:
    assert refusal(timeline_of(build, rest), Compas(Programme.RBE)) == ""


def test_contacts_are_those_of_all_that_is_ever_placed() -> None:
    assert len(contacts_in(timeline_of(STEPPED))) == 4


# --- in a bench -------------------------------------------------------------------------------------------------------


def on_the_spot(entrants: Mapping[str, Entrant]) -> Callable[..., PoolResult]:
    """A pool that plays in this process."""

    def supervised(
        tasks: Sequence[Task], workers: int, on_done: Callable[..., None], on_wait: OnWait, start: WorkerStart
    ) -> PoolResult:
        results = []
        for index, task in enumerate(tasks):
            timeline, name, factor = task.arguments
            assert isinstance(timeline, Timeline)
            assert isinstance(factor, float)
            entrant = entrants[str(name)]
            told = entrant.checked(entrant.play(timeline, factor), timeline)
            results.append(TaskResult(TaskStatus.DONE, Played(told, 0.5, None, 2**20)))
            on_done(index, results[-1])
        return PoolResult(tuple(results), interrupted=False)

    return supervised


@pytest.fixture
def benched(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Bench]:
    """A bench of a ruler, and of exact statics."""

    def bench_of(*builds: str, share: float = 1.0) -> Bench:
        entrants: Mapping[str, Entrant] = {**ENTRANTS, "ruler": Judge(Ruler(share))}
        monkeypatch.setattr("benchmarks.systems.entrants.ENTRANTS", entrants)
        monkeypatch.setattr("benchmarks.systems.bench.run_supervised", on_the_spot(entrants))
        cases = [case_of(build) for build in builds]
        named = [
            replace(case, scenario=case.scenario.model_copy(update={"scenario": f"case-{number}"}))
            for number, case in enumerate(cases)
        ]
        return bench(jobs_of(named, ["ruler", "exact"], [1.0, 0.5]))

    return bench_of


def test_an_assessor_has_one_row_whatever_the_time_steps(benched: Callable[..., Bench]) -> None:
    found = benched("- column: {levels: 2}")
    assert [(score.record.system, score.record.factor) for score in found.scores] == [
        ("ruler", NO_STEPS),
        ("exact", 1.0),
        ("exact", 0.5),
    ]
    assert [point.name for point in found.points] == ["ruler, no steps", "exact, step x 1", "exact, step / 2"]


def test_an_assessor_is_right_or_wrong_and_off_by_levels_but_does_not_creep(benched: Callable[..., Bench]) -> None:
    (right, *_), (wrong, *_) = benched(STEPPED).scores, benched(STEPPED, share=0.5).scores
    assert (right.wrong, right.levels) == (False, 0.0)
    assert (right.creep, right.mm, right.deg, right.seconds, right.energy) == (None,) * 5
    assert (wrong.verdict, wrong.wrong, wrong.levels) == ("numerical-collapse", True, 1.0)


def test_what_is_not_taken_is_neither_right_nor_wrong_and_is_told_with_the_reason(
    benched: Callable[..., Bench],
) -> None:
    found = benched("- column: {levels: 2}", DROPPED)
    refused = next(score for score in found.scores if not score.record.taken)
    assert (refused.record.case, refused.record.status, refused.wrong) == ("case-1", NOT_TAKEN, None)
    ruler = found.points[0]
    assert (ruler.runs, ruler.done, ruler.known, ruler.wrong_verdicts) == (2, 1, 1, 0)
    text = bench_text(found)
    assert f"ruler (1): {MOVES}: case-1" in text
    assert "Did not finish" not in text
    assert "5 of 6 runs done, 1 not taken, 0 wrong verdicts" in text.splitlines()[-1]


def run(case: str, system: str, wall_time: float, factor: float = 1.0, status: str = "done") -> Record:
    seen = assessed(timeline_of("- column: {levels: 1}"), Ruler()).observations
    return Record(
        case=case,
        system=system,
        factor=factor,
        status=status,
        observations=seen if status == "done" else None,
        wall_time=wall_time,
        simulated_time=1.0,
    )


def test_an_assessor_that_skips_a_case_has_no_pace_but_a_ratio() -> None:
    runs = [
        run("easy", "exact", 0.01),
        run("dear", "exact", 1.0),
        run("easy", "cra", 0.4, NO_STEPS),
        run("dear", "cra", 0.0, NO_STEPS, NOT_TAKEN),
    ]
    exact, cra = points_of(scores_of(runs, dict.fromkeys(("easy", "dear"), Answer(True, Source.TRUTH))))
    assert exact.pace == pytest.approx(sqrt(0.01 * 1.0))
    assert cra.pace is None
    assert cra.times_exact == pytest.approx(40.0)


@pytest.mark.parametrize("command", ["check", "run", "explain"])
def test_the_command_line_knows_no_assessors(command: str) -> None:
    done = CliRunner().invoke(app, [command, "scene.yaml", "--system", "cra"])
    assert done.exit_code != 0
    assert "unknown system 'cra'" in done.output


# --- compas_cra itself ------------------------------------------------------------------------------------------------

PROGRAMMES = pytest.mark.parametrize("assessor", ASSESSORS.values(), ids=ASSESSORS)


@NEEDS_COMPAS
@PROGRAMMES
def test_compas_lets_a_stepped_column_fall_with_the_first_plank_beyond_l_by_d(assessor: Compas) -> None:
    assessor.load()
    assert assessed(timeline_of(STEPPED), assessor).level == 3


@NEEDS_COMPAS
@PROGRAMMES
@pytest.mark.parametrize(("tilt", "stands"), [("26 deg", True), ("27 deg", False)])  # atan 0.5 = 26.57 deg
def test_compas_lets_a_plank_slide_beyond_the_angle_of_friction(assessor: Compas, tilt: str, stands: bool) -> None:
    timeline = timeline_of("- column: {levels: 1}", f"friction: 0.5\nworld: {{tilt: {tilt}}}\n")
    assert (assessed(timeline, assessor).level is None) is stands


@NEEDS_COMPAS
@PROGRAMMES
@pytest.mark.parametrize(("mass", "stands"), [(0.99 * 2.0 / 3.0, True), (1.01 * 2.0 / 3.0, False)])
def test_compas_weighs_each_brick_by_its_own_mass(assessor: Compas, mass: float, stands: bool) -> None:
    # The centre of the beam is 30 mm beyond the edge of the plinth, that of the load of 1 kg on it 20 mm within: it
    # tips when 30 mm times the mass of the beam exceeds 20 mm kg.
    plinth = Placed(Brick("plinth", Box((0.1, 0.1, 0.02)), 1.0), Pose((0.0, 0.0, 0.01)))
    beam = Placed(Brick("beam", Box((0.12, 0.02, 0.01)), mass), Pose((0.08, 0.0, 0.025)))
    load = Placed(Brick("load", Box((0.02, 0.02, 0.01)), 1.0), Pose((0.03, 0.0, 0.035)))
    planes = timeline_of("- column: {levels: 1}").world.planes
    assert assessor.stands(Scene((plinth, beam, load), planes, 0.5)) is stands


# --- LMGC90 itself ----------------------------------------------------------------------------------------------------

NEEDS_LMGC90 = pytest.mark.skipif(not Lmgc90().package.installed, reason="compas_lmgc90 is not installed")


@NEEDS_LMGC90
def test_lmgc90_lets_a_stepped_column_fall_with_the_first_plank_beyond_l_by_d() -> None:
    assert assessed(timeline_of(STEPPED), Lmgc90()).level == 3


@NEEDS_LMGC90
@pytest.mark.parametrize(("tilt", "stands"), [("25 deg", True), ("28 deg", False)])  # atan 0.5 = 26.57 deg
def test_lmgc90_lets_a_plank_slide_beyond_the_angle_of_friction(tilt: str, stands: bool) -> None:
    timeline = timeline_of("- column: {levels: 1}", f"friction: 0.5\nworld: {{tilt: {tilt}}}\n")
    assert (assessed(timeline, Lmgc90()).level is None) is stands


def test_a_missing_lmgc90_names_the_command_that_installs_it() -> None:
    assert ENTRANTS["lmgc90"].package.remedy == "pip install --no-deps compas_lmgc90==0.1.11"
