"""Tests of a finished structure on accelerated ground: what statics proves, and the displacements by a pulse.

A pulse rises within `RISE` to its acceleration, stays there for `HELD`, and falls to zero in the time of its rise. The
ground then moves uniformly, which is rest for the structure; braking is not part of the test.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from math import cos, sin

import numpy as np

from stability.analysis.bearings import along_bearing
from stability.dynamics.ground_motion import GroundMotion, TabulatedCourse
from stability.geometry.rows import Array
from stability.model import BodyId
from stability.problem import Stability
from stability.statics.fall_description import described
from stackdsl.judging.proofs import frozen_assembly
from stackdsl.simulation.recording import Recording, Track
from stackdsl.timeline import AccelerationTest, ShakeAction, Timeline
from stackdsl.trace import NO_PART, AccelerationResult, BrickState, PulseMotion, Trace

RISE = 0.05  # [s] longest rise that EUMOS 40509 permits
HELD = 0.3  # [s] shortest duration of the full acceleration
SETTLING = 3.0  # [s] simulated after the pulse
LOWEST = 0.2  # [m] height of the lowest part of a load


def proven_tests(trace: Trace, tests: Collection[AccelerationTest]) -> Sequence[AccelerationResult] | None:
    """Return what statics proves about each test; None if the whole structure is not proven to stand at rest."""
    standing = [track for track in trace.tracks.values() if track.state not in NO_PART]
    assembly = frozen_assembly(trace) if standing and all(track.frozen for track in standing) else None
    if assembly is None or assembly.verdict().stability is not Stability.STABLE:
        return None
    problem = assembly.problem()
    if problem.is_brittle:
        return ()
    results = []
    for test in tests:
        found = along_bearing(problem, test.bearing, assembly.gravity)
        if found is None:
            return None
        why = "" if found.motion is None else described(problem, found.motion)
        results.append(AccelerationResult(test, found.value, found.upper, why))
    return results


def with_pulse(timeline: Timeline, test: AccelerationTest) -> tuple[Timeline, float]:
    """Return a timeline with the pulse of a test after all its actions, and the time at which the pulse begins [s]."""
    begins, most = timeline.end, test.acceleration * timeline.world.gravity
    course = TabulatedCourse(((0.0, 0.0), (RISE, most), (RISE + HELD, most), (2.0 * RISE + HELD, 0.0)))
    # The ground accelerates against the pull on the bricks; rounded to digits on which all processors agree.
    direction_W = (0.0 - round(cos(test.bearing), 15), 0.0 - round(sin(test.bearing), 15), 0.0)
    shake = ShakeAction(begins, GroundMotion(course, direction_W, begins))
    shaken = replace(
        timeline,
        actions=(*timeline.actions, shake),
        hold=max(timeline.hold, SETTLING),
        watched=True,
        margins=(),
        reported_margins=(),
        measures=(),
        closely=False,
        tests=(),
    )
    return shaken, begins


def pulse_motion(trace: Trace, recording: Recording, begins: float) -> PulseMotion:
    """Return the horizontal displacements of the corners of all bricks since a time [s], relative to the ground."""
    names = [name for name, track in trace.tracks.items() if track.state not in NO_PART]
    starts = recording.at(begins)
    places = {name: number for number, name in enumerate(recording.names)}
    corners = {name: np.array(trace.tracks[name].brick.shape.corners) for name in names}
    first = {
        name: _placed(corners[name], starts.positions[places[name]][None], starts.orientations[places[name]][None])[0]
        for name in names
    }
    bottom = min(float(each[:, 2].min()) for each in first.values())
    height = max(float(each[:, 2].max()) for each in first.values()) - bottom
    largest = permanent = lowest = 0.0
    for name in names:
        ways = _ways(recording.track(name), corners[name], first[name], begins)
        largest, permanent = max(largest, float(ways.max())), max(permanent, float(ways[-1].max()))
        low = first[name][:, 2] <= bottom + LOWEST
        lowest = max(lowest, float(ways[:, low].max())) if low.any() else lowest
    fallen = tuple(name for name in names if trace.tracks[name].state is BrickState.FALLEN)
    return PulseMotion(height, largest, permanent, lowest, fallen, is_moving=_is_moving(trace, names))


def _is_moving(trace: Trace, names: Collection[BodyId]) -> bool:
    return bool(set(trace.moving).intersection(names))


def _ways(track: Track, corners: Array, first: Array, begins: float) -> Array:
    """Return the horizontal displacement of each corner (rows, corners) from a time on, with the latest row [m]."""
    later = track.times >= begins
    later[-1] = True
    moved = _placed(corners, track.positions[later], track.orientations[later]) - first
    return np.hypot(moved[..., 0], moved[..., 1])


def _placed(corners: Array, positions: Array, orientations: Array) -> Array:
    """Return the corners (rows, corners, 3) of a brick at poses, with orientations as x, y, z, w."""
    axis, part = orientations[:, None, :3], orientations[:, None, 3:]
    across = np.cross(axis, corners[None])
    return positions[:, None] + corners[None] + 2.0 * (part * across + np.cross(axis, across))
