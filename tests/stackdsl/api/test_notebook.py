"""Results as notebooks show them: in the words of the reports, with their cause and replay, and never as markup."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Protocol, cast

import pytest

from stability import Assembly, Box, Brick, Pose, margins
from stackdsl.api.cases import loads
from stackdsl.api.claims import drift, stands
from stackdsl.api.fragility import fragility
from stackdsl.api.layouts import column
from stackdsl.api.run_table import Table
from stackdsl.api.scenario import Scenario
from stackdsl.api.studies import find, sensitivities, survive
from stackdsl.api.studies import margins as margins_of_case
from stackdsl.api.sweep import sweep
from stackdsl.goldens.golden import ELSEWHERE, keeper_in
from tests.engines_at_hand import needs_pybullet


class Shown(Protocol):
    def _repr_mimebundle_(self) -> dict[str, str]: ...


def html_of(value: Shown) -> str:
    return value._repr_mimebundle_()["text/html"]


def text_of(value: Shown) -> str:
    return value._repr_mimebundle_()["text/plain"]


def leaning(levels: int) -> Scenario:
    build = [column(levels=levels, step="12 mm", every="1 s")]
    return Scenario("leaning", build=build, expect=[stands("all"), drift("<= 1 mm")])


def test_a_run_that_stands_shows_its_verdict_and_a_replay_that_reaches_nothing() -> None:
    html = html_of(leaning(9).play())  # 9 x 12 mm is less than a plank, 117.6 mm
    assert "✓ passed</span> <b>leaning[exact]</b>" in html
    assert html.count('<iframe sandbox="allow-scripts" srcdoc="') == 1
    assert "<script" not in html  # the page is text of an attribute


@needs_pybullet
def test_a_run_that_fails_shows_expected_measured_and_why() -> None:
    run = leaning(12).play()
    lines = text_of(run).splitlines()
    assert lines[0] == "✗ failed  leaning[exact]"
    assert [line.split()[0] for line in lines[1:]] == ["expected", "measured", "also", "why", "after", "first"]
    html = html_of(run)
    assert "L2.1 to L10.1 (9 bricks) tip over L1.1" in html
    assert ".band h1, .band .image" in html  # the replay hides its headline, since the notebook has it above
    assert "failed: stands: expected all, measured the structure collapsed at level 10" in repr(run)


def test_a_terminal_that_shows_no_html_makes_no_replay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stackdsl.api.notebook._replay", lambda case, trace: pytest.fail("a replay was made"))
    assert [*leaning(3).play()._repr_mimebundle_({"text/plain"})] == ["text/plain"]


@needs_pybullet
def test_a_run_without_expectations_shows_first_whether_it_stands() -> None:
    upright = text_of(Scenario("bare", build=[column(levels=3)]).play()).splitlines()
    assert upright[1:] == ["  result  stands", "  note    no expectations, so nothing is checked"]
    fallen = text_of(Scenario("bare", build=[column(levels=12, step="12 mm", every="1 s")]).play())
    assert "result  collapses at level 10" in fallen
    assert "why     L2.1 to L10.1 (9 bricks) tip over L1.1" in fallen


def test_the_cause_of_a_run_shows_itself_without_a_command() -> None:
    text = text_of(leaning(9).play().cause)
    assert text.startswith("cause\n  why    statics prove that it stands")
    assert "stackdsl explain" not in text


def test_margins_of_a_case_show_themselves_and_are_numbers() -> None:
    found = margins_of_case(leaning(9))
    assert text_of(found).startswith("\u2713 stable  leaning[exact]\n  survives  a horizontal acceleration of ")
    # Nine planks, each 12 mm further: the upper eight tip at 4.8 mm over 31.2 mm, the whole of 9 at 10.8 over 35.1.
    assert "0.153 g (worst direction: 0 deg)" in text_of(found)
    assert "a tilt of 8.74 deg" in text_of(found)  # atan(4.8 / 31.2)
    assert "friction down to 0" in text_of(found)
    assert "  weakest   above 0.153 g towards 0 deg (+x), L2.1 to L9.1 (8 bricks) tip over L1.1" in text_of(found)
    assert "  limit     limiting contact of the placement error: L2.1 on L1.1, towards +x" in text_of(found)
    assert str(found) == text_of(found)
    assert repr(found).startswith("<\u2713 stable leaning[exact]: a horizontal acceleration of 0.153 g ")
    # the centre of 8 planks is 54 mm beyond that of the lowest, and half a plank is 58.8 mm
    assert found.placement is not None
    assert 0.0 < found.placement < 0.0588 - 0.054
    fallen = margins_of_case(leaning(12))
    assert (fallen.placement, fallen.acceleration, fallen.verdict) == (None, None, "unstable")
    assert "tip over L1.1" in text_of(fallen)


def test_a_run_that_took_long_says_how_to_write_its_replay_as_a_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stackdsl.api.notebook.LONGEST", 0.0)
    html = html_of(leaning(3).play())
    assert "computing the run took" in html
    assert "scenario.to_yaml()" in html  # it is in no file yet
    assert "stackdsl run scenario.yaml -k &#x27;leaning[exact]&#x27; --html run.html" in html


def test_each_claim_of_a_run_shows_expected_and_measured() -> None:
    run = leaning(9).play()
    text = "✓ passed  drift\n  expected  <= 1 mm\n  measured  0 mm (L1.1) (margin 1 mm)"
    assert text_of(run.outcomes[1]) == text
    assert text_of(run.outcomes).endswith(text)
    assert "✗ failed</span> <b>drift</b>" in html_of(run.judge(drift("> 5 mm")))


def test_studies_show_the_lines_of_their_commands(tmp_path: Path) -> None:
    (case,) = leaning(12).cases
    found = text_of(find(case, largest="step"))
    assert found.startswith("leaning[exact]: largest step 9.799 mm stands, 9.801 mm falls")  # 117.6 mm / 12
    assert "  falls      L2.1 to L12.1 (11 bricks) tip over L1.1" in found
    assert "if 1 % more" in html_of(sensitivities(leaning(3)))
    assert "leaning[exact] survives 0.499 g in every direction" in html_of(survive(leaning(3)))  # friction is 0.5
    shaky = [column(levels=5, step="20 mm", jitter={"position": "4 mm"})]
    scenario = Scenario("shaky", build=shaky, samples=20, seed=1, expect=[stands(share=">= 50 %")])
    (swept,) = sweep(scenario.cases, tmp_path / "rows.jsonl", workers=1)
    assert "shaky[exact]: 20 of 20 samples, seed 1: " in html_of(swept)
    assert "share that stands: " in html_of(swept)
    assert "of 20 stand" in text_of(scenario.draw())
    assert "shaky[exact]: half of the samples fall at jitter" in html_of(fragility(scenario, "jitter", workers=1))


def test_a_verdict_and_margins_of_statics_show_themselves() -> None:
    design = Assembly()
    design.add(Brick("low", Box((0.1, 0.1, 0.2)), 1.0), Pose((0.0, 0.0, 0.1)))
    assert text_of(design.verdict()) == "✓ stable  statics\n  proof  load core"
    found = margins(design.problem())
    assert found is not None
    # half the base over the height of the centre: 50 mm / 100 mm
    assert "survives  a horizontal acceleration of 0.5 g" in text_of(found)
    assert "any placement error of every brick" in text_of(found)  # on the ground it may stand anywhere
    design.add(Brick("<b>high\x1b[31m", Box((0.1, 0.1, 0.2)), 1.0), Pose((0.06, 0.0, 0.3)))
    assert "✗ unstable</span> <b>statics</b>" in html_of(design.verdict())
    assert "&lt;b&gt;high" in html_of(design.verdict())
    assert "<b>high" not in html_of(design.verdict())
    assert "\x1b" not in text_of(design.verdict())


def test_a_scenario_shows_its_yaml_with_its_cases_or_its_mistakes() -> None:
    assert text_of(leaning(3)).startswith("leaning\n  1 case  leaning[exact]\nscenario: leaning\n")
    html = html_of(Scenario("<script>", build=[column(levels=0)]))
    assert "✗ invalid" in html
    assert "SD1" in html
    assert "<script" not in html


def test_a_case_shows_its_values_and_its_yaml_and_says_how_to_see_it() -> None:
    text = "scenario: a\nlet: {step: 12 mm}\nbuild: [{column: {levels: 3, step: '${step}'}}]"
    case = loads(text, step="5 mm")[0]
    shown = text_of(case)
    assert shown.startswith("a[step=5mm,exact]\n  step      5 mm\n  system    exact\n  bricks    3\n")
    assert "    step: ${step}" in shown
    assert [f"<title>{name}</title>" in html_of(case) for name in ("L1.1", "L3.1", "L4.1")] == [True, True, False]
    with pytest.raises(
        AttributeError, match=r"no attribute 'show'; .* write `play\(case\)` as the last line of a cell"
    ):
        case.show()  # type: ignore[attr-defined]


def test_a_place_in_a_notebook_is_its_cell(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    names = SimpleNamespace(format_code_name=lambda name: ("Cell", "In[3]") if name == __file__ else None)
    shell = SimpleNamespace(get_ipython=lambda: SimpleNamespace(compile=names))
    monkeypatch.setitem(sys.modules, "IPython", cast("ModuleType", shell))
    (tmp_path / "scenarios").mkdir()
    monkeypatch.chdir(tmp_path / "scenarios")  # a notebook may be among the scenarios
    monkeypatch.delenv("CI", raising=False)
    scenario = leaning(3)
    assert scenario.play().case.source.file == "In[3]"
    # a cell is no scenario of the project that a check would miss
    scenario.play().golden(tmp_path / "golden", update=True)
    assert keeper_in((tmp_path / "golden" / "leaning" / "exact.json").read_bytes()) == ELSEWHERE


def test_cells_of_a_table_are_never_markup() -> None:
    html = html_of(Table([{"name": "<b>", "x": 0.5}]))
    assert ">&lt;b&gt;</td>" in html
    assert ">0.5</td>" in html


def test_a_long_table_shows_its_first_and_last_rows() -> None:
    table = Table([{"n": number} for number in range(1000)])
    html = html_of(table)
    assert html.count("<tr>") == 1 + 60 + 1  # names, rows, and the gap
    assert ">29</td></tr><tr><td" in html
    assert ">969</td>" not in html
    assert "940 of 1000 rows are left out in the middle" in text_of(table)
