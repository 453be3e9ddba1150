"""Selects the actions that still take place after a collapse: impacts and removals, but no building."""

from collections.abc import Container
from dataclasses import replace

from stability.model import BodyId
from stackdsl.timeline import (
    HoldAction,
    JointsAction,
    LoadsAction,
    Moment,
    MoveAction,
    PushAction,
    ReleaseAction,
    Removal,
    ShakeAction,
    time_of_arrival,
)


def after_collapse(moment: Moment, present: Container[BodyId]) -> Moment | None:
    """Return the part of a moment that still takes place, with the bricks that are present; None if none does."""
    match moment:
        case Removal() | HoldAction() | ReleaseAction():
            bricks = tuple(brick for brick in moment.bricks if brick in present)
            return replace(moment, bricks=bricks) if bricks else None
        case PushAction() | MoveAction():
            return moment if moment.brick in present else None
        case ShakeAction():
            return moment
        case JointsAction() | LoadsAction():
            return None
        case _:
            return tuple(placement for placement in moment if placement.hits) or None


def time_of(moment: Moment) -> float:
    """Return the time of a moment [s]."""
    return moment[0].time if isinstance(moment, tuple) else moment.time


def last_arrival(moment: Moment) -> float:
    """Return the time at which the last brick of a moment reaches the structure [s]."""
    return max(time_of_arrival(action) for action in (moment if isinstance(moment, tuple) else (moment,)))
