"""What of a scenario takes place after a collapse: what hits the structure, or takes bricks out, but no building."""

from collections.abc import Container
from dataclasses import replace

from stability.model import BodyId
from stackdsl.timeline import HoldAction, LetGo, Moment, MoveAction, PushAction, Removal, ShakeAction, time_of_arrival


def after_collapse(moment: Moment, present: Container[BodyId]) -> Moment | None:
    """The part of it that still takes place with the bricks that are there; None if none does."""
    match moment:
        case Removal() | HoldAction() | LetGo():
            there = tuple(brick for brick in moment.bricks if brick in present)
            return replace(moment, bricks=there) if there else None
        case PushAction() | MoveAction():
            return moment if moment.brick in present else None
        case ShakeAction():
            return moment
        case _:
            return tuple(placement for placement in moment if placement.hits) or None


def time_of(moment: Moment) -> float:
    """When it is [s]."""
    return moment[0].time if isinstance(moment, tuple) else moment.time


def last_arrival(moment: Moment) -> float:
    """When the last of it reaches the structure [s]."""
    return max(time_of_arrival(action) for action in (moment if isinstance(moment, tuple) else (moment,)))
