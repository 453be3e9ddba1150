"""Scenarios, runs and tables as notebooks show them: with their cause and replay, and never as markup."""

from stackdsl.api.claims import stands
from stackdsl.api.layouts import column
from stackdsl.api.run_table import Table
from stackdsl.api.scenario import Scenario
from tests.engines_at_hand import needs_pybullet


def leaning(levels: int) -> Scenario:
    build = [column(levels=levels, step="12 mm", every="1 s")]
    return Scenario("leaning", build=build, expect=[stands("all")])


def test_a_run_that_stands_shows_its_verdict_and_a_replay_that_reaches_nothing() -> None:
    html = leaning(9).play()._repr_html_()  # 9 x 12 mm is less than a plank, 117.6 mm
    assert ">passed</b> leaning[exact]" in html
    assert html.count('<iframe sandbox="allow-scripts" srcdoc="') == 1
    assert "<script" not in html  # the page is text of an attribute


@needs_pybullet
def test_a_run_that_fails_shows_expected_measured_and_why() -> None:
    run = leaning(12).play()
    html = run._repr_html_()
    assert '<td>expected</td><td style="text-align: left">stands: all</td>' in html
    assert "L2.1 to L10.1 (9 bricks) tip over L1.1" in html
    assert "failed: stands: expected all, measured the structure collapsed at level 10" in repr(run)


def test_a_scenario_with_a_mistake_shows_it() -> None:
    html = Scenario("<script>", build=[column(levels=0)])._repr_html_()
    assert "SD1" in html
    assert "<script" not in html


def test_cells_of_a_table_are_never_markup() -> None:
    html = Table([{"name": "<b>", "x": 0.5}])._repr_html_()
    assert "<td>&lt;b&gt;</td><td>0.5</td>" in html
