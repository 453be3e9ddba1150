"""A brick that is placed needs room: where a dropped brick comes to lie is not known when a scenario is written."""

from stability.separation import boxes_apart
from stackdsl.playing.watch import Watch
from stackdsl.timeline import Placement

# [m] a brick that is placed may lie this deep in one that was dropped: engines let bricks sink and creep by as much.
MOST_OVERLAP = 1e-3


class BlockedPlacementError(RuntimeError):
    """A brick is to be placed where another one is by now."""


def keep_clear(placement: Placement, watch: Watch) -> None:
    """Raise the error if a brick has no room; one that is slid in may also be in the way of what gave a little."""
    anywhere = placement.inserted or watch.hit or placement.thrown
    others = [watch.bricks[name] for name in watch.present] if anywhere else watch.dropped
    for other in others:
        apart = boxes_apart(placement.brick.size, placement.pose, other.placement.brick.size, other.last)
        if apart.gap < -MOST_OVERLAP:
            message = f"brick '{placement.brick.id}' cannot be placed at {placement.time:g} s:"
            where = f"'{other.placement.brick.id}' has moved there"
            raise BlockedPlacementError(f"{message} {where} ({-1000.0 * apart.gap:.3g} mm of overlap)")
