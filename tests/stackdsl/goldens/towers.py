"""Runs for tests of snapshots: a tower of three planks as the runner would tell of it, and its snapshot."""

from stability.geometry.box import Box
from stability.model import Brick, Plane, Pose, Vec3
from stackdsl.goldens.snapshot import Identity, Snapshot, take
from stackdsl.timeline import FixedWorld
from stackdsl.trace import BrickState, BrickTrack, Collapse, Cost, Edge, Event, EventKind, Trace

PLANK: Vec3 = (0.120, 0.024, 0.008)
THRESHOLD = 0.004  # [m] half of the plank's smallest side: a collapse begins beyond this shift
IDENTITY = Identity("tower", "thesis", "thesis")
STAMP = {"stackdsl": "0.1.0", "pybullet": "3.2.7", "python": "3.11"}
FALL = Collapse(time=2.5, level=3, brick="L2.1", gave_way="L1.1")


def track(name: str, level: int, state: BrickState = BrickState.FROZEN, shift: float = 0.0) -> BrickTrack:
    """A plank that lies on the one below, centred on the z axis."""
    place = Pose((0.0, 0.0, 0.008 * level - 0.004))
    return BrickTrack(Brick(name, Box(PLANK), 0.0119), level, state, place, place, place, shift, tilt=0.0)


#   |--L3.1--|
#   |--L2.1--|
#   |--L1.1--|
#   =========  ground
def tower(*changed: BrickTrack, collapse: Collapse | None = None) -> Trace:
    """Three levels of one plank, a second apart; the first rests on the ground with all its weight, and so on."""
    tracks = {name: track(name, level) for level, name in enumerate(("L1.1", "L2.1", "L3.1"), start=1)}
    tracks |= {one.brick.id: one for one in changed}
    below = {"L1.1": "ground", "L2.1": "L1.1", "L3.1": "L2.1"}
    edges = {name: Edge(name, lower, 1.0) for name, lower in below.items()}
    placed = [name for name in below if tracks[name].state is not BrickState.UNPLACED]
    return Trace(
        events=tuple(Event(float(i), EventKind.PLACED, (name,), margin=0.012) for i, name in enumerate(placed)),
        tracks=tracks,
        edges=tuple(edge for name, edge in edges.items() if tracks[name].state is BrickState.FROZEN),
        collapse=collapse,
        cost=Cost(wall_time=1.0, simulated_time=5.0, steps=100, judgements=3),
        edges_when_placed={name: (edges[name],) for name in placed},
    )


WORLD = FixedWorld(9.81, 0.5, (Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.4),))


def taken(trace: Trace, modelled: bool = True) -> Snapshot:
    return take(trace, WORLD, IDENTITY, STAMP, modelled)


def states(snapshot: Snapshot) -> dict[str, str]:
    return {name: brick.state for name, brick in snapshot.bricks.items()}
