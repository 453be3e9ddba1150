"""All reports name the same weakest brick, with the same acceleration and words."""

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from textwrap import dedent

import pytest

from stability.analysis.margins import margins
from stackdsl.checking.cases import Case, cases_of, gather
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.judging.proofs import margins_of, proofs_of, survival_of
from stackdsl.language.yaml.source import parse
from stackdsl.report.statics import Extent, explanation_text
from stackdsl.report.studies import survival_lines, survival_table
from stackdsl.simulation.recording import Recorder
from stackdsl.viewing.live import margined, played, preview
from stackdsl.viewing.replay.page import payload_of
from stackdsl.viewing.run_view import view_of

PALLET = """
    brick: {size: [300 mm, 200 mm, 250 mm], density: 300 kg/m3}
    friction: 0.9
    build:
      - repeat: {level: 1 .. 3, row: 0 .. 1, place: 0 .. 1}
        bricks:
          - {name: "c${level}${row}${place}", at: ["${place * 300 mm}", "${row * 200 mm}", "${(level - 1/2) * 250 mm}"]}
"""
TWO_PALLETS = """
    build:
      - {column: {levels: 7, origin: [0 mm, 500 mm, 0 mm]}, name: b}
      - {column: {levels: 7}, name: a}
"""
# A block of height h on a footing of width b, as all of these are, tips from b / h on, and slides from its friction on.
# What each begins with has many like it: whichever way it slides, either long side, each of several stacks.
SCENES: Mapping[str, tuple[str | Path, str, float | None]] = {
    "leaning column": ("    build: [{column: {levels: 4, step: 28 mm}}]", "L2.1", 2.8 / 11.7),
    "square stack that slides any way": ("    build: [{four_stack: {levels: 4}}]", "L1.1", 0.5),
    "two stacks alike": (TWO_PALLETS, "a.L1.1", 23.4 / (7 * 7.8)),
    "pallet": (PALLET, "c100", None),
    "order-within": (Path("scenarios/loads/pallet-sim.yaml"), "box-1", 0.4),
    "cartons-of-a-table": (Path("scenarios/loads/table.yaml"), "c1", 120.0 * 37.6 / (8.4 * 900.0 + 6.2 * 1600.0)),
}
DAILY = ("leaning column", "order-within")


@pytest.fixture(autouse=True)
def no_manners(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests are no workers, and would stay behind others for good."""
    monkeypatch.setattr("os.nice", lambda more: more)


def case_of(text: str) -> Case:
    (case,), mistakes = cases_of(parse(f"scenario: scene\n{dedent(text)}\n", "scene.yaml"))
    assert mistakes == []
    return case


def case_in(file: Path, name: str) -> Case:
    (case,) = [case for case in gather([file]).cases if case.scenario.scenario == name]
    return case


def weakest_in(lines: Iterable[str]) -> str:
    (found,) = [line.strip() for line in lines if "weakest" in line]
    return found


@pytest.mark.parametrize(
    "name", [*DAILY, *(pytest.param(name, marks=pytest.mark.slow) for name in SCENES if name not in DAILY)]
)
def test_all_that_name_the_weakest_spot_name_the_same(name: str) -> None:
    scene, brick, acceleration = SCENES[name]
    case = case_in(scene, name) if isinstance(scene, Path) else case_of(scene)
    explained = weakest_in(explanation_text([case], Extent(margins=True)).splitlines())
    assert explained.startswith("weakest: above ")  # then come all bricks that begin to move
    on_live_page = margined(case)
    assert on_live_page.weakest is not None
    assert (on_live_page.weakest["brick"], on_live_page.weakest["text"]) == (brick, explained)
    assert weakest_in(on_live_page.lines) == explained

    assembly = proofs_of(case.timeline).assembly
    survival = survival_of(assembly, 24, 0.01)
    assert survival is not None
    *_, gives_way = re.split(r" {2,}", list(survival_lines("scene", survival))[3].strip())
    assert explained.endswith(gives_way)
    (of_json,) = survival_table([("scene", survival)]).details
    assert of_json["weakest"]["brick"] == brick
    assert min(row["survives_g"] for row in of_json["bearings"]) >= of_json["survives_g"]
    along = next(row for row in of_json["bearings"] if row["bearing_deg"] == of_json["weakest"]["bearing_deg"])
    assert along["gives_way"] == of_json["weakest"]["gives_way"]

    of_api = margins(assembly.problem(), gravity=assembly.gravity)
    assert of_api is not None
    assert of_api.weakest is not None
    assert of_api.weakest.brick == brick
    if acceleration is not None:
        assert of_api.weakest.acceleration == pytest.approx(acceleration, rel=3e-6)

    recorder = Recorder()
    trace = play_case(case.timeline, "exact", recorder=recorder)
    of_page = payload_of(view_of(case, trace, recorder.recording(), judged(case, trace)))["weakest"]
    assert of_page["text"] == explained
    of_claims = margins_of(trace, ("acceleration",)).weakest
    assert of_claims is not None
    assert (of_claims.brick, of_claims.gives_way) == (brick, of_api.weakest.gives_way)
    told = (of_claims.acceleration, of_json["survives_g"], of_page["survives_g"], of_api.weakest.acceleration)
    assert len({f"{each:.5g}" for each in told}) == 1


def test_all_that_tell_of_one_fall_tell_the_same_motion() -> None:
    #   Planks 4 to 8 would tip over the third by themselves, 1.2 mm beyond its end; all above the first begin to tip
    #   over that, 21.2 mm beyond.
    case = case_of("build: [{column: {levels: 8, step: 20 mm}}]")
    falls = "L2.1 to L8.1 (7 bricks) tip over L1.1"
    assert json.loads(preview(case))["fall"]["reason"] == falls
    run = json.loads(played(case).json)
    assert run["fall"]["reason"] == falls
    assert len(run["fall"]["bricks"]) == 7
    assert [event["reason"] for event in run["events"] if event["kind"] == "woken"] == [falls]
    lines = margined(case).lines
    assert f"statics: UNSTABLE: {falls}; the engine simulates the rest" in lines
    assert "direction: towards +x, its weight 21.2 mm beyond the edge" in lines
    assert not any("L4.1, L5.1, L6.1, L7.1, L8.1 tip over" in line.replace(falls, "") for line in lines)
