"""What became of every brick of a timeline, whether it was placed or not."""

from collections.abc import Mapping
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
        found[name] = track
    if extension is None or collapsed or all(track.state is not BrickState.STANDING for track in found.values()):
        return found
    return found | _unsettled(found, extension.giving_way())


def _unsettled(tracks: Mapping[BodyId, BrickTrack], giving_way: Mapping[BodyId, str]) -> dict[BodyId, BrickTrack]:
    """What is proven to fall where nothing was seen to: some falls take longer than a run."""
    return {
        name: replace(tracks[name], state=BrickState.UNSETTLED, gives_way=reason)
        for name, reason in giving_way.items()
        if tracks[name].state is BrickState.STANDING
    }


def _unplaced(placement: Placement) -> BrickTrack:
    pose = placement.pose
    return BrickTrack(placement.brick, placement.level, BrickState.UNPLACED, pose, pose, pose, shift=0.0, tilt=0.0)
