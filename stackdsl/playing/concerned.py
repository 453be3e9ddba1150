"""Which bricks something is done with, where each is as that is done."""

from collections.abc import Mapping

from stability.model import BodyId
from stability.statics.facts import Placed
from stackdsl.playing.watch import Watched
from stackdsl.timeline import Hold, LetGo, Moment, Move, Push, Removal, Shake


def concerned(moment: Moment, present: Mapping[BodyId, Watched]) -> list[Placed]:
    """The bricks that come at a moment, or are pushed, shaken, pulled out or in a hand, of those that are there."""
    match moment:
        case Removal() | Hold() | LetGo():
            names = moment.bricks
        case Push() | Move():
            names = (moment.brick,)
        case Shake():
            names = tuple(name for name, watched in present.items() if not watched.removed)
        case _:
            return [Placed(placement.brick, placement.came or placement.pose) for placement in moment]
    return [Placed(present[name].placement.brick, present[name].last) for name in names]
