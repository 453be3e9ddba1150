"""What became of every brick of a timeline, whether it was placed or not."""

from collections.abc import Set
from dataclasses import replace

from stability.model import BodyId
from stackdsl.playing.together import Tells
from stackdsl.playing.watch import Watch
from stackdsl.timeline import Placement, Timeline
from stackdsl.trace import BrickState, BrickTrack


def tracks_of(
    timeline: Timeline, watch: Watch, extension: Tells | None, unproven: bool, collapsed: bool
) -> dict[BodyId, BrickTrack]:
    """The track of each, in the order of the timeline.

    `unproven`: what is not frozen was not played, as only a proof was asked for, and there was none that it stands.
    """
    giving_way = _giving_way(extension) if extension is not None and not collapsed else set()
    found = {}
    for placement in timeline.placements:
        name = placement.brick.id
        if name not in watch.bricks:
            found[name] = _unplaced(placement)
            continue
        frozen = extension is not None and extension.is_frozen(name)
        track = watch.bricks[name].track(frozen)
        if unproven and not frozen:
            track = replace(track, state=BrickState.UNWATCHED)
        elif track.state is BrickState.STANDING and name in giving_way:
            track = replace(track, state=BrickState.UNSETTLED)
        found[name] = track
    return found


def _giving_way(extension: Tells) -> Set[BodyId]:
    """What is proven to fall where nothing was seen to: in weak gravity the run may end before."""
    verdict = extension.verdict()
    return set() if verdict is None or verdict.motion is None else verdict.motion.velocity.keys() & extension.awake()


def _unplaced(placement: Placement) -> BrickTrack:
    pose = placement.pose
    return BrickTrack(placement.brick, placement.level, BrickState.UNPLACED, pose, pose, pose, shift=0.0, tilt=0.0)
