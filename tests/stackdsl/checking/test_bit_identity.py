"""The same scenario gives the same bits: in any order, any process, any number of workers, whatever ran before.

Every way in which bricks come to move is played, on every system: engines differ in what they keep from one world to
the next, and PyBullet keeps `contactBreakingThreshold` for the whole process.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from textwrap import dedent

import pytest

from stability.stabilizers.known_motion import FallingParts
from stackdsl.checking import check as checking
from stackdsl.checking.cases import Case, GatheredCases, gather
from stackdsl.checking.check import CheckConfig, check
from stackdsl.checking.play_case import play_case
from stackdsl.goldens.file_format import golden_name
from stackdsl.supervising.processes import OnDone, OnWait, PoolResult, run_supervised
from stackdsl.supervising.worker import Task, WorkerStart
from stackdsl.trace import Event, EventKind, Trace
from tests.paths import ROOT
from tests.stackdsl.checking.bits import Bits, bits_of, compiled_under, differences, played, with_golden

# What takes long is worked out once for all tests here, which so stay in one process.
pytestmark = pytest.mark.xdist_group("bits")

LIMIT = 120.0  # [s] for what takes one
HASHES = "20"  # PYTHONHASHSEED of other processes
# What comes as it is goes first: after it, others tell PyBullet what would show if it were not told again.
SYSTEMS = "systems: [stock, thesis, exact, tuned]"
SCENES: Mapping[str, str] = {
    # Two planks turn about the end of the lowest as one body, and land.
    "collapse": """
        build:
          - column: {levels: 3, step: 44 mm}
            every: 0.02 s
        expect: [{collapses: any}]
        """,
    "hit": """
        build:
          - four_stack: {levels: 4}
        impacts:
          - after: built + 0.05 s
            throw: {at: L3.2, from: {bearing: 90 deg, distance: 10 mm}, speed: 4 m/s, name: shot}
        expect: [{stands: {for: 0.3 s}}]
        """,
    "drop": """
        build:
          - four_stack: {levels: 2}
        impacts:
          - after: built + 0.05 s
            drop: {brick: kapla, onto: L2.1, height: 60 mm, rotate: [0 deg, 20 deg, 10 deg], name: dropped}
        expect:
          - stands: {for: 0.3 s}
          - margin: {acceleration: "> 0", tilt: "> 0 deg", friction: "< 1"}
            system: exact
        """,
    "push-and-pull": """
        build:
          - four_stack: {levels: 5}
        impacts:
          - after: built + 0.05 s
            push: {brick: L5.1, impulse: [0.004 N*s, 0.003 N*s, 0 N*s]}
          - after: impact 1 + 0.2 s
            remove: {brick: L2.1}
        expect: [{stands: {for: 0.1 s}}]
        """,
    # It needs 0.149, and slips; the published model would hold it with 0.134.
    "v-slips": """
        friction: 0.12
        let:
          angle: 70 deg
          out: ${(117.6 mm * cos(angle) + 7.8 mm * sin(angle)) / 2}
          up: ${(117.6 mm * sin(angle) + 7.8 mm * cos(angle)) / 2}
        build:
          - bricks:
              - {name: left, at: ["${0 mm - out}", 0 mm, "${up}"], rotate: [0 deg, "${0 deg - angle}", 0 deg]}
              - {name: right, at: ["${out}", 0 mm, "${up}"], rotate: [0 deg, "${angle}", 0 deg]}
        expect: [{stands: {for: 0.3 s}}]
        """,
    "ladder-slips": """
        world:
          ground: {friction: 0.15}
          walls: [{bearing: 0 deg, distance: "${117.6 mm * cos(angle)}", friction: 0}]
        let:
          angle: 60 deg
          across: ${(117.6 mm * cos(angle) - 7.8 mm * sin(angle)) / 2}
          up: ${(117.6 mm * sin(angle) + 7.8 mm * cos(angle)) / 2}
        build:
          - bricks: [{name: ladder, at: ["${across}", 0 mm, "${up}"], rotate: [0 deg, "${0 deg - angle}", 0 deg]}]
        expect: [{collapses: any}]
        """,
}


QUICK = ("v-slips", "collapse", "drop")


def written(folder: Path, names: Mapping[str, str]) -> Path:
    """Scenes in a folder, one file each, under these names."""
    folder.mkdir()
    for scene, name in names.items():
        head = f"scenario: {scene}\nbrick: kapla\n{SYSTEMS}\n"
        (folder / f"{name}.yaml").write_text(head + dedent(SCENES[scene]), encoding="utf-8")
    return folder


@pytest.fixture(
    scope="module", params=[QUICK, pytest.param(tuple(SCENES), marks=pytest.mark.slow)], ids=["quick", "all"]
)
def chosen(request: pytest.FixtureRequest) -> tuple[str, ...]:
    names: tuple[str, ...] = request.param
    return names


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory, chosen: tuple[str, ...]) -> Path:
    return written(tmp_path_factory.mktemp("bits") / "scenes", {scene: scene for scene in chosen})


@pytest.fixture(scope="module")
def cases(scenes: Path) -> tuple[Case, ...]:
    gathered = gather([scenes])
    assert gathered.diagnostics == ()
    return gathered.cases


@pytest.fixture(scope="module")
def bits(cases: tuple[Case, ...]) -> dict[str, Bits]:
    """Of each case, as it comes out here at first."""
    return dict(played(cases))


def assert_same(found: Mapping[str, Bits], bits: Mapping[str, Bits]) -> None:
    assert {name: some for name in found if (some := differences(bits[name], found[name]))} == {}


def test_all_that_a_run_tells_is_compared(cases: tuple[Case, ...]) -> None:
    trace = play_case(cases[0].timeline, cases[0].system)
    slower = replace(trace, cost=replace(trace.cost, wall_time=99.0))
    a_step_more = replace(trace, cost=replace(trace.cost, steps=trace.cost.steps + 1))
    assert differences(bits_of(trace), bits_of(slower)) == {}
    assert list(differences(bits_of(trace), bits_of(a_step_more))) == [".cost.steps"]
    other_zero = replace(trace, last_arrival=-0.0)
    assert list(differences(bits_of(trace), bits_of(other_zero))) == [".last_arrival"]


def test_the_scenes_show_what_they_are_to(bits: Mapping[str, Bits]) -> None:
    fell = {name for name, told in bits.items() if ".collapse" not in told}
    assert {name for name in bits if name.startswith(("collapse", "v-slips", "ladder-slips"))} <= fell
    assert all(int(told[".cost.steps"]) > 50 for told in bits.values())  # some slip as statics say, to their middle


def test_two_planks_of_the_collapse_fall_as_one(cases: tuple[Case, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    as_one: list[int] = []

    def noted(parts: FallingParts, steps: int, driven: bool = False) -> int:
        as_one.append(advance(parts, steps, driven))
        return as_one[-1]

    advance = FallingParts.advance
    monkeypatch.setattr(FallingParts, "advance", noted)
    (case,) = (case for case in cases if case.name == "collapse[exact]")
    play_case(case.timeline, case.system)
    assert sum(as_one) > 50  # time steps


@pytest.mark.slow
def test_a_run_repeats_in_any_order_in_one_process(cases: tuple[Case, ...], bits: Mapping[str, Bits]) -> None:
    # The last one is played twice in a row, all others after something else than before.
    assert_same(dict(played(reversed(cases))), bits)


def test_a_run_that_was_interrupted_leaves_nothing(cases: tuple[Case, ...], bits: Mapping[str, Bits]) -> None:
    chosen = [case for case in cases if case.scenario.scenario in {"collapse", "hit"}]
    for case in chosen:
        with pytest.raises(KeyboardInterrupt):
            play_case(case.timeline, case.system, on_event=interrupt)
    again = [case for case in cases if case.scenario.scenario in {"drop", "v-slips"}]
    assert_same(dict(played(again)), bits)


def interrupt(event: Event) -> None:
    """As a key pressed in the middle of a fall would."""
    if event.kind in (EventKind.COLLAPSED, EventKind.WOKEN):
        raise KeyboardInterrupt


def test_a_process_with_other_hashes_compiles_the_same(
    scenes: Path, cases: tuple[Case, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONHASHSEED", HASHES)
    (result,) = run_supervised([Task(compiled_under, (scenes,), LIMIT)], 1, start=WorkerStart.NEW).results
    assert result.value == {case.name: bits_of(case.timeline) for case in cases}


@pytest.mark.parametrize("workers", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_a_check_gives_the_same_with_any_workers_and_hashes_and_whatever_files_are_called(
    workers: int, tmp_path: Path, chosen: tuple[str, ...], bits: Mapping[str, Bits], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CI", raising=False)
    monkeypatch.setenv("PYTHONHASHSEED", HASHES)
    names = {scene: f"{place * (-1) ** workers % 7}-{scene}" for place, scene in enumerate(chosen, 1)}
    cases = gather([written(tmp_path / "scenarios", names)]).cases
    assert [case.name for case in cases] != list(bits), "the files should be found in another order"
    terms = CheckConfig(tmp_path / "golden", update=True, accept_failing=True, workers=workers)
    traces = checked(cases, terms, monkeypatch)
    assert_same({case.name: with_golden(case, trace) for case, trace in zip(cases, traces, strict=True)}, bits)
    golden = tmp_path / "golden"
    goldens = {file.relative_to(golden).as_posix(): file.read_text(encoding="ascii") for file in golden.rglob("*.json")}
    assert goldens == {golden_name(case.identity): bits[case.name]["golden"] for case in cases}


def checked(cases: Sequence[Case], terms: CheckConfig, monkeypatch: pytest.MonkeyPatch) -> list[Trace]:
    """Check these cases, which writes their golden files; the traces that its workers handed back."""
    pools: list[PoolResult] = []

    def overheard(tasks: Sequence[Task], workers: int, on_done: OnDone, on_wait: OnWait) -> PoolResult:
        # A copy of this process would have its hashes.
        pools.append(run_supervised(tasks, workers, on_done, on_wait, WorkerStart.NEW))
        return pools[0]

    monkeypatch.setattr(checking, "run_supervised", overheard)
    check(GatheredCases(tuple(cases), ()), cases, whole_set=False, config=terms)
    return [result.value for result in pools[0].results if isinstance(result.value, Trace)]


@pytest.mark.slow
def test_all_scenarios_give_the_same_bits_forward_and_backward() -> None:
    cases = [case for case in gather([ROOT / "scenarios"]).cases if "long" not in case.scenario.tags]
    forward = dict(played(cases))
    assert_same(dict(played(reversed(cases))), forward)
