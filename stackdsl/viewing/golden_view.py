"""View of a golden file beside the run that was compared with it.

A golden file contains the placements of bricks and the final poses of those that stood, but no motion. So each brick is
shown at its placement until the collapse, and then at its final pose, if the file has one. A fallen brick without a
final pose stays at its placement, in the colour of fallen bricks. Marked differences are those of the comparison, by
its tolerances.
"""

import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from math import inf, isfinite, radians
from pathlib import Path
from typing import Any, TypeAlias

from stability.geometry.box import Box
from stability.geometry.vectors import about, norm, scale
from stability.model import BodyId, BodyState, Brick, Plane, Pose, Vec3
from stackdsl.diagnostics import Span
from stackdsl.disk import read_file
from stackdsl.goldens.file_format import directory_of
from stackdsl.goldens.snapshot import friction_from
from stackdsl.project_file import confined
from stackdsl.report.golden_differences import STATE, STATES
from stackdsl.results import GoldenDifference, GoldenResult
from stackdsl.simulation.recording import Recorder, Recording
from stackdsl.timeline import Arrival, FixedWorld, Placement, Timeline
from stackdsl.trace import BrickState, BrickTrack, Event, EventKind, Trace
from stackdsl.viewing.run_view import RunView, ShownProofs

Json: TypeAlias = Mapping[str, Any]

LONGEST = 64_000_000  # [bytes] largest file to view


def golden_view(golden: GoldenResult, now: RunView) -> RunView | None:
    """Return the view of a golden file, for the run compared with it; None if the file cannot be shown.

    A golden file may be edited by hand, so any content is possible.
    """
    try:
        confined(file := Path(golden.file))  # again, as this may be a new process
        text = read_file(file, LONGEST + 1, directory_of(file)).decode()
        if len(text) > LONGEST:
            return None
        return _view(json.loads(text), golden, text, now)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def _view(content: Json, golden: GoldenResult, text: str, now: RunView) -> RunView:
    planned = {placement.brick.id: placement for placement in now.timeline.placements}
    placements = tuple(_placements(content, planned))
    if len({placement.brick.id for placement in placements}) < len(placements):
        raise ValueError("a brick is placed twice")
    timeline = Timeline(_world(content["world"]), placements, hold=0.0)
    collapse = content.get("collapse") or {}
    fell = _number(collapse.get("time_s"), now.trace.collapse.time if now.trace.collapse is not None else inf)
    tracks = {placement.brick.id: _track(placement, content["bricks"], fell) for placement in placements}
    events = tuple(_events(content, collapse, fell))
    end = max([now.trace.cost.simulated_time, *(event.time for event in events)])
    trace = Trace(events, tracks, (), None, replace(now.trace.cost, simulated_time=end), {})
    return RunView(
        f"{now.name}, golden file",
        now.system,
        f"Placements and final poses of the bricks in {golden.file}, without their motion.",
        timeline,
        trace,
        _recorded(placements, tracks, content, fell),
        replace(now.result, outcomes=()),
        ShownProofs((), None),
        {placement.brick.id: _place(golden.file, text, placement.brick.id) for placement in placements},
        _verdict(content, collapse),
        _marks(golden.differences),
    )


def _verdict(content: Json, collapse: Json) -> str:
    verdict = f"{content['verdict']} at level {collapse['level']}" if collapse else content["verdict"]
    return f"{verdict}; a golden file locks end states and stores no motion"


def _marks(differences: Iterable[GoldenDifference]) -> Mapping[str, tuple[str, ...]]:
    """Return the differences in words, by brick or other subject."""
    marks: defaultdict[str, tuple[str, ...]] = defaultdict(tuple)
    for each in differences:
        expected, got = (
            STATES.get(text, text) if each.quantity == STATE else text for text in (each.expected, each.got)
        )
        marks[each.subject] += (f"{each.quantity}: {expected} in the golden file, {got} in this run",)
    return marks


def _placements(content: Json, planned: Mapping[BodyId, Placement]) -> Iterator[Placement]:
    """Yield the placements of all bricks.

    A brick that is no box has the shape of the brick of that name in the run. One that the run throws or drops is no
    part of the structure here either, so that the picture does not reach to the start of its flight.
    """
    for event in content["events"]:
        for name, placed in event.get("placed", {}).items():
            own = planned.get(name)
            brick = own.brick if own is not None else None
            if "size_mm" in placed and (brick is None or isinstance(brick.shape, Box)):
                brick = Brick(name, Box(_sides(placed["size_mm"])), _finite(placed["mass_g"]) / 1000.0)
            if brick is not None:
                level = content["bricks"].get(name, {}).get("level", 0)
                pose = Pose(_metres(placed["at_mm"]), _orientation(placed["turn_deg"]))
                arrival = own.arrival if own is not None and own.hits else Arrival.SET_DOWN
                yield Placement(_finite(event["time_s"]), brick, int(level), pose, arrival)


def _track(placement: Placement, bricks: Json, fell: float) -> BrickTrack:
    final = bricks.get(placement.brick.id, {})
    state = final.get("state")
    brick_state = BrickState(state) if state in set(BrickState) else BrickState.UNWATCHED
    left = fell if brick_state is BrickState.FALLEN and fell < inf else None
    at = placement.pose if not _has_position(final) else replace(placement.pose, position_W=_metres(final["at_mm"]))
    start = placement.pose
    return BrickTrack(
        placement.brick, placement.level, brick_state, start, start, at, shift=0.0, tilt=0.0, left_at=left
    )


def _events(content: Json, collapse: Json, fell: float) -> Iterator[Event]:
    for event in content["events"]:
        time = _finite(event["time_s"])
        for key, kind in (("placed", EventKind.PLACED), ("removed", EventKind.REMOVED), ("pushed", EventKind.PUSHED)):
            if names := tuple(map(str, event.get(key, ()))):
                yield Event(time, kind, names)
                held = tuple(
                    name for name in names if content["bricks"].get(name, {}).get("state") == BrickState.FROZEN
                )
                if kind is EventKind.PLACED and held:
                    yield Event(time, EventKind.FROZEN, held)
    if collapse and fell < inf:
        yield Event(fell, EventKind.COLLAPSED, (), f"a brick has fallen at level {collapse['level']}")


def _recorded(
    placements: Iterable[Placement], tracks: Mapping[BodyId, BrickTrack], content: Json, fell: float
) -> Recording:
    recorder = Recorder()
    moved = {}
    for placement in placements:
        name = placement.brick.id
        recorder.add(placement.time, placement.brick, BodyState(placement.pose))
        if tracks[name].final != placement.pose:
            moved[name] = BodyState(placement.pose), BodyState(tracks[name].final)
    last = max((placement.time for placement in placements), default=0.0)
    when = max(fell if fell < inf else last, last)
    recorder.see(when, {name: before for name, (before, _) in moved.items()})
    recorder.see(when + 1e-3, {name: after for name, (_, after) in moved.items()})
    for event in content["events"]:
        recorder.remove(_finite(event["time_s"]), map(str, event.get("removed", ())))
    return recorder.recording()


def _world(content: Json) -> FixedWorld:
    planes = tuple(
        Plane(name, _metres(plane["at_mm"]), _vector(plane["normal"]), _finite(plane["friction"]))
        for name, plane in content["planes"].items()
    )
    return FixedWorld(
        _finite(content["gravity"]), friction_from(_finite(content["friction"]), content.get("rubbing")), planes
    )


def _place(file: str, text: str, name: BodyId) -> Span:
    """Return the position of the first entry of a brick in a golden file."""
    start = text.find(f'"{name}": {{')
    return Span(file, text.count("\n", 0, max(start, 0)) + 1, 1, 1)


def _has_position(final: Json) -> bool:
    at = final.get("at_mm")
    return isinstance(at, list) and all(isinstance(value, int | float) for value in at)


def _number(value: object, otherwise: float) -> float:
    return _finite(value) if isinstance(value, int | float) else otherwise


def _finite(value: object) -> float:
    if not isinstance(value, int | float) or not isfinite(value):
        raise TypeError(f"{value} is not a finite number")
    return float(value)


def _sides(size_mm: object) -> Vec3:
    sides = _metres(size_mm)
    if min(sides) <= 0.0:
        raise ValueError("a side is not greater than zero")
    return sides


def _metres(values: object) -> Vec3:
    return scale(0.001, _vector(values))


def _vector(values: object) -> Vec3:
    if not isinstance(values, list):
        raise TypeError("it is not a list")
    x, y, z = map(_finite, values)
    return x, y, z


def _orientation(turn_deg: object) -> tuple[float, float, float, float]:
    turn = _vector(turn_deg)
    angle = norm(turn)
    return about(scale(1.0 / angle, turn), radians(angle)) if angle > 0.0 else (0.0, 0.0, 0.0, 1.0)
