"""What became of every brick of a timeline, whether it was placed or not."""

from collections.abc import Callable, Container
from dataclasses import replace

from stability.model import BodyId
from stackdsl.playing.watch import Watch
from stackdsl.timeline import Placement, Timeline
from stackdsl.trace import BrickState, BrickTrack


def tracks_of(
    timeline: Timeline, watch: Watch, is_frozen: Callable[[BodyId], bool], unproven: bool, giving_way: Container[BodyId]
) -> dict[BodyId, BrickTrack]:
    """The track of each, in the order of the timeline.

    `unproven`: what is not frozen was not played, as only a proof was asked for, and there was none that it stands.
    `giving_way`: what is proven to fall, and was still on its way when the run ended.
    """
    found = {}
    for placement in timeline.placements:
        name = placement.brick.id
        if name not in watch.bricks:
            found[name] = _unplaced(placement)
            continue
        frozen = is_frozen(name)
        track = watch.bricks[name].track(frozen)
        if unproven and not frozen:
            track = replace(track, state=BrickState.UNWATCHED)
        elif track.state is BrickState.STANDING and name in giving_way:
            track = replace(track, state=BrickState.UNSETTLED)
        found[name] = track
    return found


def _unplaced(placement: Placement) -> BrickTrack:
    pose = placement.pose
    return BrickTrack(placement.brick, placement.level, BrickState.UNPLACED, pose, pose, pose, shift=0.0, tilt=0.0)
