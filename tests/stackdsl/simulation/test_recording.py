"""A recording has the pose of every brick at any time of a run, and does not change the run."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stability.model import BodyState, Pose
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.recording import Recorder, Recording
from stackdsl.simulation.runner import play
from stackdsl.trace import Trace
from tests.engines_at_hand import WITH_RIGID
from tests.planks import plank
from tests.scenes import timeline_of

G = 9.81  # [m/s2]
THICKNESS = 0.0078  # of a KAPLA plank [m]
COLUMN = "- column: {levels: 6, step: 30 mm}\n  every: 1 s"
FALL = "expect: [{collapses: any}]"


def recorded(build: str, rest: str, system: str = "exact") -> tuple[Trace, Recording]:
    recorder = Recorder()
    trace = play(timeline_of(build, rest), system_named(system), recorder=recorder)
    return trace, recorder.recording()


def timeless(trace: Trace) -> Trace:
    cost = replace(trace.cost, wall_time=0.0)
    statics = replace(trace.statics, seconds=0.0) if trace.statics else None
    return replace(trace, cost=cost, statics=statics)


@pytest.mark.parametrize("system", ["exact", pytest.param("thesis", marks=pytest.mark.slow), "tuned", *WITH_RIGID])
def test_every_engine_is_recorded_from_where_bricks_came_to_where_they_ended(system: str) -> None:
    trace, recording = recorded(COLUMN, FALL, system)
    first, last = recording.at(0.0), recording.at(trace.cost.simulated_time)
    assert trace.collapse is not None
    for number, name in enumerate(recording.names):
        track = trace.tracks[name]
        assert recording.track(name).positions[0] == pytest.approx(track.placed.position_W)
        assert last.positions[number] == pytest.approx(track.final.position_W, abs=1e-5)
        assert abs(last.orientations[number] @ track.final.orientation) == pytest.approx(1.0, abs=1e-6)
    assert np.isnan(first.positions[1:]).all()  # only the lowest plank has come by then
    assert not np.isnan(first.positions[0]).any()


def test_recording_changes_nothing_of_a_run() -> None:
    trace, _ = recorded(COLUMN, FALL)
    plain = play(timeline_of(COLUMN, FALL), system_named("exact"))
    assert timeless(trace) == timeless(plain)


def test_a_brick_at_rest_is_recorded_once() -> None:
    _, recording = recorded("- column: {levels: 5}\n  every: 1 s", "expect: [{stands: {for: 3 s}}]")
    assert [len(recording.track(name).times) for name in recording.names] == [1] * 5


def test_a_free_fall_without_engine_is_recorded_by_its_closed_form() -> None:
    trace, recording = recorded(
        "- column: {levels: 2}",
        "impacts: [{remove: {bricks: [L1.1]}, at: 1 s}]\nexpect: [{collapses: any}]",
    )
    assert trace.cost.steps == 0  # no engine took part
    (upper,) = [number for number, name in enumerate(recording.names) if name == "L2.1"]
    for time in (0.0031, 0.0152, 0.0277):  # it lands a while later, after the thickness of a plank
        fallen = 1.5 * THICKNESS - recording.at(1.0 + time).positions[upper][2]
        assert fallen == pytest.approx(0.5 * G * time**2, abs=1e-6)


def test_a_removed_brick_has_no_recorded_pose() -> None:
    _, recording = recorded(
        "- column: {levels: 2}", "impacts: [{remove: {bricks: [L2.1]}, at: 1 s}]\nexpect: [{stands: all}]"
    )
    upper = recording.names.index("L2.1")
    assert not np.isnan(recording.at(0.999).positions[upper]).any()
    assert np.isnan(recording.at(1.0).positions[upper]).all()


def swinging(most_keys: int, looks: int) -> Recording:
    """A plank that swings to and fro by 10 mm once a second, looked at a hundred times a second."""
    recorder = Recorder(most_keys)
    recorder.add(0.0, plank("a"), BodyState(Pose((0.0, 0.0, 0.0))))
    for look in range(1, looks + 1):
        time = 0.01 * look
        speed = 0.01 * 2.0 * np.pi * np.cos(2.0 * np.pi * time)
        recorder.see(time, {"a": BodyState(Pose((swing(time), 0.0, 0.0)), (speed, 0.0, 0.0))})
    return recorder.recording()


def swing(time: float) -> float:
    return float(0.01 * np.sin(2.0 * np.pi * time))


@pytest.mark.parametrize(("most", "off"), [(100_000, 1e-6), (20_000, 1e-4)])
def test_a_long_run_takes_bounded_memory_and_is_still_followed(most: int, off: float) -> None:
    # Poses of what swings by A with w, up to t = 0.04 s apart: a straight line is off by up to A (w t)^2 / 8 = 0.08 mm.
    recording = swinging(most, 45_000)
    assert len(recording.keys) <= most + 20_000  # those that came last are as they came
    for time in (0.333, 7.777, 123.456, 239.987):
        assert recording.at(time).positions[0][0] == pytest.approx(swing(time), abs=off)


def test_creep_is_recorded() -> None:
    recorder = Recorder()
    recorder.add(0.0, plank("a"), BodyState(Pose((0.0, 0.0, 0.0))))
    for look in range(1, 50_001):  # a micrometre in ten looks, so that no look by itself sees any
        recorder.see(0.01 * look, {"a": BodyState(Pose((1e-7 * look, 0.0, 0.0)))})
    recording = recorder.recording()
    for time in (1.0, 77.7, 300.0, 499.9):
        assert recording.at(time).positions[0][0] == pytest.approx(1e-5 * time, abs=2e-5)


def test_a_recorded_motion_begins_when_rest_ends() -> None:
    recorder = Recorder()
    recorder.add(0.0, plank("a"), BodyState(Pose((0.0, 0.0, 0.0))))
    for look in range(1, 1001):
        recorder.see(0.01 * look, {"a": BodyState(Pose((0.0 if look <= 900 else 0.001 * (look - 900), 0.0, 0.0)))})
    recording = recorder.recording()
    assert recording.at(8.999).positions[0][0] == 0.0
    assert recording.at(9.005).positions[0][0] == pytest.approx(0.0005)


def test_a_file_holds_the_arrays_that_the_page_on_python_lists(tmp_path: Path) -> None:
    _, recording = recorded(COLUMN, FALL)
    recording.save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz", allow_pickle=False) as arrays:
        assert list(arrays["names"]) == list(recording.names)
        chosen = arrays["brick"] == 3
        track = recording.track(recording.names[3])
        assert (arrays["time"][chosen] == track.times).all()
        assert (arrays["position"][chosen] == track.positions).all()
        assert arrays["corners"][: arrays["corner_counts"][0]].max(axis=0) == pytest.approx([0.0588, 0.0117, 0.0039])


def test_a_brick_that_never_came_is_told() -> None:
    with pytest.raises(LookupError, match="no brick 'Z9' was placed in this run"):
        Recorder().recording().track("Z9")
