"""Systems on other engines: where they can be named, and that the extension works on them unchanged."""

import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from stackdsl.checking.selection import Selection
from stackdsl.cli.main import app
from stackdsl.judging.judge import judge
from stackdsl.language import value_types
from stackdsl.simulation.known_systems import missing, system_named
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import PEERS, SYSTEMS
from stackdsl.trace import EventKind, Trace
from tests.engines_at_hand import needs_pybullet
from tests.scenes import compiled, mistakes_of, scene, timeline_of

FOUR_STACK = "- four_stack: {levels: 5}\n  every: 1 s"
LATE = """
    - column: {levels: 2}
    - bricks: [{name: late, at: [0 mm, 0 mm, 40 mm], drop: true}]
      after: built + 0.5 s
"""
NEEDS_MUJOCO = pytest.mark.skipif(bool(missing(["mujoco"])), reason="mujoco is not installed")


@pytest.fixture
def written(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(scene(FOUR_STACK, "expect: [stands: all]\n"), encoding="utf-8")
    return path


@pytest.fixture
def without_mujoco(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stability.engines.protocol.find_spec", lambda name: None if name == "mujoco" else sys)


def mujoco_exact(build: str, rest: str = "") -> Trace:
    return play(timeline_of(build, rest), system_named("mujoco-exact"))


def test_no_peer_has_the_name_of_a_system_of_the_language() -> None:
    assert not PEERS.keys() & SYSTEMS.keys()


def test_a_scenario_can_name_every_system_of_ours() -> None:
    assert tuple(SYSTEMS) == value_types.SYSTEMS


def test_a_scenario_cannot_name_a_peer() -> None:
    (mistake,) = mistakes_of(FOUR_STACK, "systems: [mujoco]\nexpect: [stands: all]\n")
    assert mistake.code == "SD104"


def test_a_peer_is_played_wherever_it_is_asked_for_and_nowhere_else() -> None:
    cases, _ = compiled(scene(FOUR_STACK, "systems: [exact, tuned]\nexpect: [stands: all]\n"))
    assert [case.system for case in Selection().of(cases)] == ["exact", "tuned"]
    assert [case.system for case in Selection(("mujoco", "tuned")).of(cases)] == ["tuned", "mujoco"]
    assert [case.name for case in Selection(("mujoco-stiff",)).of(cases)] == ["scene[mujoco-stiff]"]
    assert Selection(("mujoco-stiff",), keyword="other").of(cases) == []


def test_a_peer_that_proves_nothing_is_not_asked_for_proofs_nor_for_what_others_are_expected_to_do() -> None:
    asked = "expect: [verdict: stable, stands: all, {stands: all, system: exact}]\n"
    (case,), _ = compiled(scene("- column: {levels: 2}", asked))
    trace = play(case.timeline, system_named("exact"))

    def judged(system: str) -> list[str]:
        return [outcome.name for outcome in judge(trace, case.scenario, case.variant, case.source, system)]

    assert judged("exact") == ["verdict", "stands", "stands"]
    assert judged("mujoco-exact") == ["verdict", "stands"]
    assert judged("mujoco") == ["stands"]


@pytest.mark.usefixtures("without_mujoco")
@pytest.mark.parametrize("command", ["check", "run", "explain"])
def test_without_its_package_a_peer_says_what_to_install(written: Path, command: str) -> None:
    done = CliRunner().invoke(app, [command, str(written), "--system", "mujoco-exact"])
    assert done.exit_code != 0
    assert "'mujoco-exact' needs mujoco, which is not installed; try: pip install 'stackdsl[mujoco]'" in done.output


@needs_pybullet
@pytest.mark.usefixtures("without_mujoco")
def test_nobody_else_needs_the_package(written: Path) -> None:
    done = CliRunner().invoke(app, ["run", str(written), "--system", "exact"])
    assert done.exit_code == 0, done.output


@NEEDS_MUJOCO
def test_a_peer_has_no_golden_file(written: Path, tmp_path: Path) -> None:
    golden = tmp_path / "golden"
    done = CliRunner().invoke(app, ["check", str(written), "--system", "mujoco", "--golden", str(golden)])
    assert done.exit_code == 0, done.output
    assert not golden.exists()


@NEEDS_MUJOCO
def test_a_four_stack_on_mujoco_is_proven_and_needs_no_step() -> None:
    trace = mujoco_exact(FOUR_STACK)
    assert trace.cost.steps == 0
    assert sum(trace.cost.proofs.values()) == 10
    assert trace.drift == 0.0


@NEEDS_MUJOCO
def test_a_stepped_column_on_mujoco_falls_with_the_first_plank_beyond_l_by_d() -> None:
    #   L = 117.6 mm, d = 12 mm: nine stand, the tenth is too many.
    trace = mujoco_exact("- column: {levels: 14, step: 12 mm}\n  every: 1 s")
    assert trace.collapse is not None
    assert trace.collapse.level == 10
    assert trace.cost.steps > 0


@NEEDS_MUJOCO
def test_a_hit_on_mujoco_moves_what_it_reaches_while_the_levels_above_ride_along() -> None:
    trace = mujoco_exact(
        "- four_stack: {levels: 9}",
        """
        impacts:
          - after: built + 0.5 s
            throw: {brick: kapla, at: level 3, from: {bearing: 90 deg, distance: 10 mm}, speed: 1 m/s}
        """,
    )
    assert trace.collapse is None
    woken = {brick for event in trace.events if event.kind is EventKind.WOKEN for brick in event.bricks}
    assert {"L3.2", "L9.1", "L9.2"} <= woken  # bearing 90 deg: the hit comes from the far side
    assert 0 < trace.cost.one_by_one < len(woken)
    assert trace.drift > 1e-3
    assert trace.tracks["L1.1"].shift == 0.0


@NEEDS_MUJOCO
def test_what_lands_on_a_stack_on_mujoco_is_frozen_with_a_proof() -> None:
    trace = mujoco_exact(LATE)
    frozen = [brick for event in trace.events if event.kind is EventKind.FROZEN for brick in event.bricks]
    assert "late" in frozen
    assert trace.collapse is None
