"""A layout, a claim and an impact of somebody else go all the way, from the file to the snapshot; nobody lists them."""

import json
import pickle
from collections.abc import Iterator
from pathlib import Path

import jsonschema
import pytest
import yaml

from stackdsl.checking.cases import Case, GatheredCases, gather
from stackdsl.checking.check import CheckConfig, check
from stackdsl.language.claims.claim_kind import CLAIMS, ClaimKind, claim
from stackdsl.language.json_schema import json_schema, keys_at, schema_text
from stackdsl.language.schema import models
from stackdsl.report.check_text import report_text
from stackdsl.report.formats import report_json
from stackdsl.report.statics import explanation_text
from stackdsl.results import VariantResult
from stackdsl.timeline import PushAction
from tests.scenes import compiled
from tests.stackdsl.own_kinds.kinds_of_a_stranger import Shake, StairsParams, Tilts, registered

SCENARIO = """\
scenario: shaken-stairs
build:
  - stairs: {steps: 3}
    every: 1 s
impacts:
  - after: built + 1 s
    shake: {level: 3, impulse: [20 mN*s, 0 mN*s, 0 mN*s]}
systems: [exact, tuned]
expect:
  - tilts: {brick: L1.1, by: < 0.1 deg}
  - tilts: {brick: L3.1, by: < 30 deg}
  - stands: {bricks: [L1.1]}
truth:
  - tilts: {brick: L1.1, by: < 0.1 deg}
    source: nothing touches the first column
"""


@pytest.fixture(autouse=True)
def own_kinds() -> Iterator[None]:
    with registered():
        yield


def gathered(folder: Path, text: str = SCENARIO) -> GatheredCases:
    file = folder / "shaken-stairs.yaml"
    file.write_text(text, encoding="utf-8")
    return gather([file])


def told(old: str, new: str) -> str:
    """The one mistake of the scenario after a change, with its remedy."""
    assert SCENARIO.count(old) == 1
    _, (mistake,) = compiled(SCENARIO.replace(old, new))
    line = SCENARIO[: SCENARIO.index(old)].count("\n") + 1
    assert mistake.span.line == line, mistake
    return f"{mistake.code} {mistake.message}; {mistake.hint}"


def test_editors_know_them() -> None:
    assert {"levels", "steps"} & set(keys_at(("build", 0, "stairs"))) == {"steps"}
    assert keys_at(("impacts", 0, "shake")) == ("level", "impulse")
    assert keys_at(("expect", 0, "tilts")) == keys_at(("truth", 0, "tilts")) == ("brick", "by")
    jsonschema.Draft202012Validator(json_schema()).validate(yaml.safe_load(SCENARIO))


@pytest.mark.parametrize(
    ("old", "new", "mistake"),
    [
        ("steps: 3", "steps: 3, colour: 2", "SD101 unknown key 'colour'; remove it; the keys here are origin"),
        ("steps: 3", "steps: 0", "SD104 0 is below the minimum of 1"),
        ("steps: 3", "steps: 500", "SD206 the layout has 125250 bricks"),
        ("brick: L3.1, by", "brick: L9.1, by", "SD204 there is no brick 'L9.1'; the highest level is 3 (L3.1"),
        ("impulse: [20 mN*s", "impulse: [20 mm", "SD106 'mm' is not a unit of an impulse"),
        ("impulse: [20 mN*s", "impulse: [20 N*s", "SD104 the push accelerates brick 'L3.1' to 1673 m/s"),
        ("shake: {level: 3", "shake: {level: 4", "SD205 no brick of level 4 stands by then; begin later"),
        (
            "  - stands: {bricks: [L1.1]}",
            "  - tilts: {brick: L3.1, by: '> 40 deg'}",
            "SD104 this claim and `tilts` at 11:5 contradict each other on exact, tuned",
        ),
    ],
)
def test_their_mistakes_are_told_in_their_place(old: str, new: str, mistake: str) -> None:
    assert told(old, new).startswith(mistake)


def test_a_brick_that_is_pulled_out_has_no_tilt() -> None:
    changed = SCENARIO.replace("systems:", "  - {after: impact 1 + 1 s, remove: {brick: L1.1}}\nsystems:")
    _, mistakes = compiled(changed.replace("  - stands: {bricks: [L1.1]}\n", ""))
    assert {(each.code, each.span.line) for each in mistakes} == {("SD204", 11), ("SD204", 14)}


def test_the_timeline_has_a_push_of_every_brick_of_the_level(tmp_path: Path) -> None:
    for case in gathered(tmp_path).cases:
        pushes = [action for action in case.timeline.actions if isinstance(action, PushAction)]
        assert [(push.brick, push.time, push.impulse_W) for push in pushes] == [("L3.1", 6.0, (0.02, 0.0, 0.0))]
        assert len(case.timeline.placements) == 6


def test_own_kinds_are_played_judged_reported_and_locked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)  # CI writes no golden
    gathering = gathered(tmp_path)
    assert gathering.diagnostics == ()
    terms = CheckConfig(tmp_path / "golden", update=True)
    report = check(gathering, gathering.cases, whole_set=True, config=terms)
    assert [result.system for result in report.results] == ["exact", "tuned"]
    assert [outcome.name for outcome in report.results[0].outcomes] == ["tilts", "tilts", "stands"]
    assert all(passed(result) for result in report.results)
    assert "shaken-stairs" in report_text(report)
    assert '"name": "tilts"' in report_json(report)
    (locked,) = [json.loads(file.read_text(encoding="utf-8")) for file in (tmp_path / "golden").rglob("*exact*")]
    assert "L3.1" in json.dumps(locked)
    again = check(gathering, gathering.cases, whole_set=True, config=CheckConfig(terms.golden))
    assert not any(result.golden_failed for result in again.results)


def passed(result: VariantResult) -> bool:
    return all(outcome.passed for outcome in (*result.outcomes, *result.truths))


def test_own_kinds_are_explained(tmp_path: Path) -> None:
    cases = gathered(tmp_path).cases
    assert "pushed by (20 0 0) mN*s" in explanation_text(cases)


def test_a_case_with_them_may_be_sent_to_another_process(tmp_path: Path) -> None:
    case = gathered(tmp_path).cases[0]
    sent: Case = pickle.loads(pickle.dumps(case))
    assert sent == case
    assert type(sent.scenario) is models().Scenario


def test_the_models_are_made_once_for_the_kinds_there_are() -> None:
    known = models()
    assert isinstance(known.Impact.model_validate({"shake": {"level": 1, "impulse": ["0 N*s"] * 3}}).content, Shake)
    assert known is models()


class TestAfterwards:
    """Without the fixture's kinds."""

    @pytest.fixture(autouse=True)
    def own_kinds(self) -> None:
        return

    def test_the_schema_is_as_before(self) -> None:
        before = schema_text()
        with registered():
            assert "stairs" in schema_text()
        assert "stairs" not in before
        assert schema_text() == before

    def test_the_scenario_is_none(self) -> None:
        _, mistakes = compiled(SCENARIO)
        assert [mistake.message for mistake in mistakes][:2] == ["unknown key 'stairs'", "unknown key 'shake'"]


def test_two_kinds_cannot_have_one_key() -> None:
    with pytest.raises(ValueError, match="the claim 'tilts' is registered already"):
        claim("tilts", "again")(Tilts)


def test_a_claim_that_cannot_be_judged_is_none() -> None:
    class Unjudged(ClaimKind):
        pass

    with pytest.raises(TypeError, match="the class of the claim 'unjudged' does not implement `judge`"):
        claim("unjudged", "nothing")(Unjudged)  # type: ignore[type-abstract]
    assert "unjudged" not in CLAIMS


def test_a_layout_goes_on_until_it_falls() -> None:
    step = models().BuildStep.model_validate({"stairs": {}, "every": "1 s", "until": "collapse"})
    assert step.layout is not None
    assert isinstance(step.layout[1], StairsParams)
    assert step.layout[1].steps == 100
