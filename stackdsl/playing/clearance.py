"""A brick that is placed needs room: where others have moved to is not known when a scenario is written."""

from dataclasses import dataclass
from math import dist, inf

from stability.model import BodyId
from stability.shapes.apart import apart
from stackdsl.playing.watch import Watch, Watched
from stackdsl.timeline import Arrival, Placement
from stackdsl.wording import mm

# [m] a brick that is placed may lie this deep in one that was dropped: engines let bricks sink and creep by as much.
MOST_OVERLAP = 1e-3


@dataclass(frozen=True, slots=True)
class Blocked:
    """Why a run cannot go on: a brick is to be placed where another one is by now, or what moves takes too much."""

    brick: BodyId
    time: float  # [s]
    by: BodyId
    depth: float  # [m]
    thrown: bool = False  # whether the brick comes flying, or falls, rather than being set down
    refined: bool = False  # whether that is so only at half the step and twice the iterations
    pressed: BodyId | None = None  # the brick that the hand with the first has pressed into what does not give way
    too_much: str = ""  # what is more work than a run may take: the brick is one of those that move

    def in_words(self) -> str:
        """What cannot go on, and why."""
        if self.too_much:
            return self.too_much
        if self.pressed is not None:
            if self.pressed == self.by:
                behind = f"it is {mm(self.depth, 3)} behind, and what is in its way does not give way"
                return f"the hand cannot move brick '{self.brick}' on at {self.time:.3f} s: {behind}"
            into = f"'{self.pressed}' is pressed {mm(self.depth, 3)} into '{self.by}', which does not give way"
            return f"the hand cannot move brick '{self.brick}' on at {self.time:.3f} s: {into}"
        where = f"'{self.by}' has moved there ({mm(self.depth, 3)} of overlap)"
        return f"brick '{self.brick}' cannot be placed at {self.time:g} s: {where}"


class BlockedPlacementError(RuntimeError):
    """A brick is to be placed where another one is by now."""

    def __init__(self, blocked: Blocked) -> None:
        super().__init__(blocked.in_words())
        self.blocked = blocked


def keep_clear(placement: Placement, watch: Watch) -> None:
    """Raise the error if a brick has no room; one that is slid in may also be in the way of what gave a little."""
    anywhere = placement.arrival is Arrival.SLID_IN or watch.hit or placement.hits
    others = [watch.bricks[name] for name in watch.present] if anywhere else watch.dropped
    own = placement.brick.id
    inside = {other.placement.brick.id: _depth(placement, other) for other in others if other.placement.brick.id != own}
    inside = {name: depth for name, depth in inside.items() if depth > MOST_OVERLAP}
    # What tips or creeps without falling comes up from below: an engine pushes out of it what is not halfway inside.
    halfway = 0.5 * placement.brick.shape.least_thickness
    tipped = {name: _depth(placement, other) for name, other in watch.shifted.items() if name != own}
    inside |= {name: depth for name, depth in tipped.items() if depth > halfway}
    deepest = max(inside, key=inside.__getitem__, default=None)
    if deepest is not None:
        raise BlockedPlacementError(Blocked(own, placement.time, deepest, inside[deepest], placement.hits))


def _depth(placement: Placement, other: Watched) -> float:
    """How far the brick would be inside another one [m]."""
    brick, own = other.placement.brick, placement.brick.shape
    pose = placement.came or placement.pose
    if dist(pose.position_W, other.last.position_W) > own.bounding_radius + brick.shape.bounding_radius:
        return -inf
    return -apart(placement.brick.shape, pose, brick.shape, other.last).gap
