"""What happened when a timeline was played: plain data that the judge, the snapshot and the report read."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from stability.model import BodyId, Brick, Pose
from stability.statics.facts import Verdict as StaticsVerdict
from stackdsl.timeline import World

# A brick that had come to rest has left its place beyond these (DESIGN, "collapse").
COLLAPSE_SHARE_OF_SMALLEST_SIDE = 0.5  # its centre sank or shifted by more than this share of its smallest side
COLLAPSE_TILT = 0.2617993877991494  # [rad], 15 deg


class EventKind(StrEnum):
    """What can happen to bricks."""

    PLACED = "placed"
    FROZEN = "frozen"
    WOKEN = "woken"
    REMOVED = "removed"
    PUSHED = "pushed"
    COLLAPSED = "collapsed"


ACTIONS = frozenset(
    {EventKind.PLACED, EventKind.REMOVED, EventKind.PUSHED}
)  # what the scenario does; all else comes of it


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened to bricks at one time."""

    time: float  # [s]
    kind: EventKind
    bricks: tuple[BodyId, ...]
    reason: str = ""
    margin: float | None = None  # least tipping margin of the stack after it [m]; None where no model computes one


@dataclass(frozen=True, slots=True)
class Edge:
    """The upper brick is carried by the lower body through a contact."""

    upper: BodyId
    lower: BodyId
    # Part of what the upper brick carries, itself included, that goes to the lower body; no number where several bodies
    # could take it and nothing says which does.
    share: float


class BrickState(StrEnum):
    """How a brick ended."""

    FROZEN = "frozen"  # stands, held fixed by the extension
    STANDING = "standing"  # stands in the hands of the engine
    FALLEN = "fallen"  # left its place
    UNSETTLED = "unsettled"  # dropped, and still not at rest
    REMOVED = "removed"  # pulled out
    UNPLACED = "unplaced"  # the structure fell before its turn
    UNWATCHED = "unwatched"  # not proven to stand, and nothing was asked that an engine would have to show


@dataclass(frozen=True, slots=True)
class BrickTrack:
    """One brick from its placement to the end."""

    brick: Brick
    level: int
    state: BrickState
    placed: Pose
    rest: Pose  # where it came to rest; where it was placed if it was set down at rest
    final: Pose
    shift: float  # largest distance of its centre from `rest` afterwards, over the whole run [m]
    tilt: float  # largest turn of its axes out of `rest` afterwards [rad]
    left_at: float | None = None  # when it was seen to have left its place [s]


@dataclass(frozen=True, slots=True)
class Collapse:
    """The first time that a brick which had come to rest left its place."""

    time: float  # [s]
    level: int  # level under construction
    brick: BodyId  # the brick that left first
    gave_way: BodyId | None = None  # the brick whose support test failed, where a model names it


@dataclass(frozen=True, slots=True)
class Cost:
    """What a run took."""

    wall_time: float  # [s]
    simulated_time: float  # of the scenario's clock [s]
    steps: int  # engine steps
    judgements: int  # passes of the stability extension
    proofs: Mapping[str, int] = field(default_factory=dict)  # how many times bricks were proven to stand, by stage


@dataclass(frozen=True, slots=True)
class Margins:
    """What a proof survives: each None where nobody asked for it, or where nothing is proven to stand."""

    acceleration: float | None = None  # the least horizontal acceleration that brings it down, by bearing [g]
    bearing: float | None = None  # of that acceleration, from +x towards +y [rad]
    tilt: float | None = None  # the least tilt of the whole that brings it down [rad]
    friction: float | None = None  # the least Coulomb coefficient, of every contact, with which it stands
    placement: float | None = None  # how far every brick may be placed beside where it is [m]


class Verdict(StrEnum):
    """What came of the structure as a whole."""

    STANDS = "stands"
    COLLAPSES = "collapses"
    UNSETTLED = "unsettled"  # nothing left its place, but something dropped has not come to rest yet
    UNWATCHED = "unwatched"  # judged, and not played: nothing was asked that an engine would have to show


@dataclass(frozen=True, slots=True)
class Trace:
    """A whole run."""

    events: tuple[Event, ...]
    tracks: Mapping[BodyId, BrickTrack]  # in order of placement
    edges: tuple[Edge, ...]  # who rests on whom at the end, among bricks that stand; by upper, then lower
    collapse: Collapse | None
    cost: Cost
    # Who carried each brick once it had been judged or had settled, at the next placement; for snapshots.
    edges_when_placed: Mapping[BodyId, tuple[Edge, ...]]
    world: World | None = None  # what did not move
    # What was proven when bricks were last set down or pulled out; None where nothing proves.
    statics: StaticsVerdict | None = None
    margins: Margins = Margins()  # of what stands at the end, as far as somebody asked

    @property
    def last_action(self) -> float:
        """When a brick was last placed or pulled out [s]."""
        return max((event.time for event in self.events if event.kind in ACTIONS), default=0.0)

    @property
    def verdict(self) -> Verdict:
        """What came of the structure as a whole."""
        if self.collapse is not None:
            return Verdict.COLLAPSES
        states = {track.state for track in self.tracks.values()}
        if BrickState.UNWATCHED in states:
            return Verdict.UNWATCHED
        return Verdict.UNSETTLED if BrickState.UNSETTLED in states else Verdict.STANDS

    @property
    def drift(self) -> float:
        """Largest shift of any placed brick after it came to rest, of those that are not pulled out [m]."""
        remaining = (track for track in self.tracks.values() if track.state is not BrickState.REMOVED)
        return max((track.shift for track in remaining), default=0.0)
