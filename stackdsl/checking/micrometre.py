"""Runs of a case a micrometre to either side, which tell whether a micrometre decides its result."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from stability.geometry.vectors import add, scale
from stability.model import Vec3
from stackdsl.results import Change, changes, observations
from stackdsl.timeline import Action, Placement, PushAction, Timeline
from stackdsl.trace import Trace

MICROMETRE: Final[Vec3] = (0.6e-6, 0.48e-6, 0.64e-6)  # [m] along no axis of a scene, as many are symmetric
DECIDED: Final = ("verdict", "fallen", "drift of what stands")


@dataclass(frozen=True, slots=True)
class Nearby:
    """A run, and what it and the runs a micrometre to either side observed."""

    trace: Trace
    changes: tuple[Change, ...]


def either_side(timeline: Timeline) -> tuple[Timeline, ...]:
    """Return the timeline with all hits and pushes a micrometre to either side.

    Without any, the bricks that are placed last are moved, horizontally.
    """
    return _moved(timeline, 1.0), _moved(timeline, -1.0)


def _moved(timeline: Timeline, way: float) -> Timeline:
    by = scale(way, MICROMETRE)
    if any(_strikes(action) for action in timeline.actions):
        return replace(timeline, actions=tuple(_aside(a, by) if _strikes(a) else a for a in timeline.actions))
    x, y, _ = by
    last = timeline.built
    actions = (
        _aside(action, (x, y, 0.0)) if isinstance(action, Placement) and action.time == last else action
        for action in timeline.actions
    )
    return replace(timeline, actions=tuple(actions))


def _strikes(action: Action) -> bool:
    return isinstance(action, PushAction) or (isinstance(action, Placement) and action.hits)


def _aside(action: Action, by: Vec3) -> Action:
    if isinstance(action, Placement):
        return replace(action, pose=replace(action.pose, position_W=add(action.pose.position_W, by)))
    if isinstance(action, PushAction):
        return replace(action, offset_W=add(action.offset_W, by))
    return action


def compared(trace: Trace, beside: Sequence[Trace]) -> Nearby:
    """Compare a run with those beside it."""
    seen = [{name: observations(one)[name] for name in DECIDED} for one in (trace, *beside)]
    return Nearby(trace, tuple(change for after in seen[1:] for change in changes(seen[0], after)))
