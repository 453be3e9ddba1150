"""Scenarios written in Python say what the same ones say in YAML."""

import csv
from pathlib import Path

import numpy as np
import pytest

from stackdsl.api import claims, impacts, layouts
from stackdsl.api.cases import ScenarioError
from stackdsl.api.run import NotMeasuredError, UncheckedWarning, play
from stackdsl.api.scenario import Scenario
from stackdsl.api.single_bricks import brick, bricks
from stackdsl.api.studies import margins
from stackdsl.api.written import Written
from stackdsl.checking.cases import cases_of
from stackdsl.checking.results import snapshot_of
from stackdsl.goldens.file_format import canonical_text
from stackdsl.goldens.golden import PendingStore
from stackdsl.language.yaml.source import parse
from stackdsl.results import GoldenStatus
from tests.engines_at_hand import needs_pybullet

YAML = """\
scenario: tapped-column
tags: [hard]
friction: 0.4
world: {gravity: 1.62 m/s2, walls: [{bearing: 0 deg, distance: 1 m}]}
build:
  - column: {levels: 4, step: 5 mm}
    every: 0.5 s
  - bricks:
      - {name: beam, at: [300 mm, 0 mm, 3.9 mm], rotate: [0 deg, 0 deg, 90 deg]}
    at: 4 s
impacts:
  - after: built + 1 s
    push: {brick: L4.1, impulse: [1 mN*s, 0 N*s, 0 N*s]}
expect:
  - stands: all
  - falls: {count: 0}
    system: exact
truth:
  - collapses: any
    source: a guess
"""


def column(levels: int = 4, step: str = "5 mm", **others: object) -> Scenario:
    return Scenario("column", build=[layouts.column(levels=levels, step=step)], **others)  # type: ignore[arg-type]


@pytest.fixture
def tapped() -> Scenario:
    """The same as in YAML."""
    return Scenario(
        "tapped-column",
        tags=["hard"],
        friction=0.4,
        world={"gravity": "1.62 m/s2", "walls": [{"bearing": "0 deg", "distance": "1 m"}]},
        build=[
            layouts.column(levels=4, step="5 mm", every="0.5 s"),
            bricks(
                [brick(name="beam", at=["300 mm", "0 mm", "3.9 mm"], rotate=["0 deg", "0 deg", "90 deg"])], when="4 s"
            ),
        ],
        impacts=[impacts.push(brick="L4.1", impulse=["1 mN*s", "0 N*s", "0 N*s"], after="built + 1 s")],
        expect=[claims.stands("all"), claims.falls(count=0, system="exact")],
        truth=[claims.collapses("any", source="a guess")],
    )


def test_yaml_and_python_give_the_same_golden_file(tapped: Scenario) -> None:
    (written,), _ = cases_of(parse(YAML, "tapped.yaml"))
    run, other = tapped.play(), play(written)
    assert canonical_text(snapshot_of(run.case, run.trace)) == canonical_text(snapshot_of(other.case, other.trace))
    assert [outcome.measured for outcome in run.outcomes] == [outcome.measured for outcome in other.outcomes]


def test_what_python_writes_as_yaml_is_the_same_scenario(tapped: Scenario) -> None:
    (again,), mistakes = cases_of(parse(tapped.to_yaml(), "again.yaml"))
    assert not mistakes
    (case,) = tapped.cases
    assert (again.scenario, again.timeline) == (case.scenario, case.timeline)


def test_a_column_stands_while_count_times_step_is_within_a_length() -> None:
    """The top n of planks of length L lean out by no more than L / 2: n steps of L / n, less one plank's own half."""
    limit = 117.6 / 10
    assert column(10, f"{0.99 * limit} mm").play().verdict == "stands"
    assert column(10, f"{1.01 * limit} mm").play().verdict == "collapses"


def test_a_claim_is_judged_with_its_margin() -> None:
    run = column().play()
    assert run.judge(claims.stands("all")).passed
    height = run.judge(claims.height("31.2 mm ± 0.1 mm"))  # four planks of 7.8 mm
    assert height.passed
    assert height.margin == pytest.approx(0.1, abs=1e-6)
    assert not run.judge(claims.height("31.4 mm ± 0.1 mm")).passed


@pytest.mark.parametrize(
    ("claim", "value"), [(claims.stands("all"), None), (claims.margin(placement=">= 1 mm"), pytest.approx(2.4))]
)
def test_a_claim_judged_later_has_the_margin_that_it_has_in_expect(claim: Written, value: float | None) -> None:
    limit = 117.6 / 9  # [mm]
    later = column(9, "12 mm").play().judge(claim)
    (before,) = column(9, "12 mm", expect=[claim]).play().outcomes
    assert (later.measured, later.margin, later.unit) == (before.measured, before.margin, before.unit)
    assert later.value == value
    assert 0.0 < later.margin < 9 * (limit - 12.0)


@pytest.mark.parametrize(
    ("claim", "lacks"),
    [
        (claims.sway(amplitude="<= 0.1 mm"), "sway"),
        (claims.stands(levels=4, for_="9 s"), "9 s after the last action"),
    ],
)
def test_a_claim_of_what_was_not_measured_is_refused(claim: Written, lacks: str) -> None:
    with pytest.raises(NotMeasuredError, match=lacks):
        column().play().judge(claim)


def test_a_mistake_is_told_with_its_line_of_python() -> None:
    with pytest.raises(ScenarioError) as told:
        column(step="5").cases  # noqa: B018 -- it raises
    (found,) = told.value.diagnostics
    assert found.code == "SD105"
    assert Path(found.span.file).name == Path(__file__).name
    assert "layouts.column(levels=levels, step=step)" in found.span.excerpt


def test_values_of_other_types_are_refused_where_they_are_written() -> None:
    with pytest.raises(TypeError, match="not object"):
        column(let={"x": object()})
    assert column(friction=np.float64(0.4)).cases[0].scenario.friction == 0.4


def test_a_case_of_several_is_named() -> None:
    scenario = Scenario("stacks", matrix={"n": [2, 3]}, build=[with_levels("${n}")])
    assert len(scenario.play("n=3").trace.tracks) == 3
    with pytest.raises(LookupError, match="there are 2 cases: n=2,exact, n=3,exact; name one"):
        scenario.play()
    assert [len(run.trace.tracks) for run in scenario.play_all()] == [2, 3]


def with_levels(levels: object) -> Written:
    return layouts.column(levels=levels)  # type: ignore[arg-type, unused-ignore]  # an expression


def test_arrays_and_tables_have_an_entry_a_brick() -> None:
    run = column().play()
    arrays = run.arrays()
    np.testing.assert_allclose(arrays["final"][:, 0], [0.0, 0.005, 0.010, 0.015], atol=1e-9)
    np.testing.assert_allclose(arrays["final"][:, 2], 0.0078 * (np.arange(4) + 0.5), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(arrays["final"][:, 3:], axis=1), 1.0)
    assert [row["name"] for row in run.table()] == list(arrays["name"]) == ["L1.1", "L2.1", "L3.1", "L4.1"]
    assert {row["event"] for row in run.events()} >= {"placed", "frozen"}


@needs_pybullet
def test_a_brick_that_was_never_placed_has_no_place(tmp_path: Path) -> None:
    run = Scenario(
        "fallen", build=[layouts.column(levels=12, step="12 mm", every="1 s")], expect=[claims.stands("all")]
    ).play()
    top = run.table(full=True)[-1]
    assert top["state"] == "unplaced"
    assert {top[name] for name in ("x_mm", "y_mm", "z_mm", "shift_mm", "tilt_deg", "qw")} == {None}
    assert np.isnan(run.arrays()["final"][-1]).all()
    assert np.isfinite(run.arrays()["final"][0]).all()
    assert np.nanmax(run.table().column("z_mm")) < 12 * 7.8  # a tower of all planks
    run.table().to_csv(tmp_path / "bricks.csv")
    with (tmp_path / "bricks.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows[-1]["z_mm"] == ""
    assert float(rows[0]["z_mm"]) == pytest.approx(3.9, abs=0.005)  # the fall presses it down by 1 um


@needs_pybullet
def test_a_height_after_a_collapse_says_so_and_is_a_number() -> None:
    run = Scenario("fallen", build=[layouts.column(levels=12, step="12 mm", every="1 s")]).play()
    height = run.judge(claims.height(">= 1 mm"))
    assert height.measured.endswith(" mm, after a collapse at level 10")
    assert height.value == pytest.approx(float(height.measured.split()[0]), abs=0.01)
    assert column().play().judge(claims.height(">= 1 mm")).measured == "31.2 mm"
    assert run.judge(claims.stands("all")).value is None


@needs_pybullet
def test_a_brick_that_leans_on_fallen_ones_adds_no_height() -> None:
    # L3.1 shifts by less than half its thickness, so that it counts as standing, but the plank below has fallen
    run = Scenario("leaning", build=[layouts.column(levels=5, step="36 mm", every="1 s")]).play()
    states = {row["name"]: row["state"] for row in run.table()}
    assert (states["L2.1"], states["L3.1"]) == ("fallen", "frozen")
    assert run.judge(claims.height(">= 1 mm")).measured == "7.8 mm, after a collapse at level 4"  # the lowest plank


def test_the_cause_of_a_run_is_told_in_the_words_of_the_report() -> None:
    fallen = Scenario("fallen", brick="kapla", build=[layouts.column(levels=10, step="12 mm", every="1 s")])
    cause = fallen.play().cause
    assert str(cause) == cause.why == margins(fallen).why
    assert cause.why.endswith("tip over L1.1, towards +x, its weight 1.2 mm beyond the edge")
    with pytest.raises(AttributeError, match="did you mean 'overhang'"):
        getattr(cause, "overhangs")  # noqa: B009 -- type checkers know that there is none


def test_the_cause_of_a_missed_margin_is_what_limits_it() -> None:
    run = Scenario("leaning", brick="kapla", build=[layouts.column(levels=9, step="12 mm")]).play()
    assert run.judge(claims.margin(placement=">= 3 mm")).why.endswith("placement error: L2.1 on L1.1, towards +x")
    assert run.judge(claims.margin(tilt=">= 20 deg")).why.startswith("weakest: above ")


def test_a_golden_file_is_that_of_the_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)
    run = column().play()
    assert not run.golden(tmp_path / "golden")
    assert run.golden(tmp_path / "golden", update=True).status is GoldenStatus.WRITTEN
    assert run.golden(tmp_path / "golden")
    moved = column(step="8 mm").play().golden(tmp_path / "golden")
    assert not moved
    assert "x when placed of L2.1 5.00 mm -> 8.00 mm" in repr(moved)
    waiting = PendingStore(tmp_path / ".stackdsl")
    assert [pending.file for pending in waiting.all()] == [""]
    assert column().play().golden(tmp_path / "golden")
    assert not list(waiting.all())


def test_a_run_that_fails_is_accepted_only_on_request(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)
    run = column(10, "14 mm", expect=[claims.stands("all")]).play()
    refused = run.golden(tmp_path, update=True)
    assert not refused
    assert "stands: expected all" in refused.note
    assert not list(tmp_path.iterdir())
    assert run.golden(tmp_path, update=True, accept_failing=True)
    assert run.golden(tmp_path, update=True)  # nothing is to be accepted


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_data_frame_is_the_table(library: str) -> None:
    pytest.importorskip(library)
    run = column().play()
    frame = getattr(run, f"to_{library}")()
    assert list(frame["name"]) == ["L1.1", "L2.1", "L3.1", "L4.1"]


def test_a_claim_is_held_against_a_run_of_one_of_several_cases() -> None:
    tower = Scenario(
        "varied",
        cases=[{"name": "low", "count": 2}, {"name": "high", "count": 4}],
        let={"top": "${count * 7.8 mm}"},
        build=[layouts.column(levels="${count}")],  # type: ignore[arg-type, unused-ignore]  # an expression
        expect=[claims.height("${top} ± 0.1 mm")],
    )
    runs = tower.play_all()
    assert [run.passed for run in runs] == [True, True]
    assert [run.judge(claims.height("31.2 mm ± 0.1 mm")).passed for run in runs] == [False, True]


def test_a_brick_may_come_from_a_file_beside_the_calling_one() -> None:
    stone = {"file": "../../../scenarios/solids/stone.obj", "unit": "cm", "density": "2600 kg/m3"}
    built = [bricks([brick(name="cut", brick=stone, on="ground")])]
    run = Scenario("stone", build=built, expect=[claims.stands("all")]).play()
    assert [outcome.passed for outcome in run.outcomes] == [True]


def test_a_claim_that_fails_is_false_and_a_run_without_claims_is_told_to_be_unchecked() -> None:
    falls = layouts.column(levels=10, step="14 mm")
    run = Scenario("claimed", build=[falls], expect=[claims.stands("all")]).play()
    assert not run.judge(claims.stands("all"))
    assert run.judge(claims.collapses("any"))
    assert "why: L2.1 to L10.1 (9 bricks) tip over L1.1" in repr(run)
    with pytest.warns(UncheckedWarning, match=r"bare\[exact\] has no expectations, so nothing is checked"):
        assert Scenario("bare", build=[falls]).play().passed is None
    with pytest.warns(UncheckedWarning):
        assert not Scenario("bare", build=[falls]).play()
