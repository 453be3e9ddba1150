"""What happened in a run, as plain data: events, measurements, proof margins, counts of samples."""

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from enum import StrEnum
from math import atan2, hypot, inf
from typing import TypeAlias

from stability.analysis.weakest import Weakest
from stability.engines.protocol import WrongFriction
from stability.model import BodyId, Brick, Pose
from stability.problem import Motion, Verdict
from stackdsl.timeline import Action, FixedWorld, Removal

# Margins of a proof, as far as they were computed.


@dataclass(frozen=True, slots=True)
class VerdictMargins:
    """What a proof survives: each None where nobody asked for it, or where nothing is proven to stand."""

    acceleration: float | None = None  # the least horizontal acceleration that brings it down, by bearing [g]
    bearing: float | None = None  # of that acceleration, from +x towards +y [rad]
    tilt: float | None = None  # the least tilt of the whole that brings it down [rad]
    friction: float | None = None  # the least Coulomb coefficient of the roughest contact, all in proportion
    roughest: float | None = None  # what that contact has
    placement: float | None = None  # how far every brick may be placed beside where it is [m]
    joint: tuple[BodyId, BodyId] | None = None  # the contact that limits `placement`, lower body first
    guaranteed: bool | None = None  # whether rest is the only thing that can happen, rather than one that can
    certainty: str = ""  # why, in words; empty where normal forces alone balance everything
    squeezed: bool | None = None  # whether the others count on contacts that may be pressed together, or may not
    weakest: Weakest | None = None  # the mechanism that opens first under the least acceleration


# The trace of a run: plain data for judge, snapshot and report.


# A brick that had come to rest has left its place beyond these (DESIGN, "collapse"). Its centre sank, or, as long as
# nothing has hit the structure, shifted by more than this share of its smallest side (docs/design/hits.md).
COLLAPSE_SHARE_OF_SMALLEST_SIDE = 0.5
COLLAPSE_TILT = 0.2617993877991494  # [rad], 15 deg


class EventKind(StrEnum):
    """What can happen to bricks."""

    PLACED = "placed"
    FROZEN = "frozen"
    WOKEN = "woken"
    REMOVED = "removed"
    PUSHED = "pushed"
    SHAKEN = "shaken"  # the ground, which is no brick
    TAKEN = "taken"  # by a hand, which moves it or holds it
    LET_GO = "let go"  # by a hand that has moved or held it
    COLLAPSED = "collapsed"


# What the scenario does; all else comes of it.
ACTIONS = frozenset(EventKind) - {EventKind.FROZEN, EventKind.WOKEN, EventKind.COLLAPSED}


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened to bricks at one time."""

    time: float  # [s]
    kind: EventKind
    bricks: tuple[BodyId, ...]
    reason: str = ""
    margin: float | None = None  # least tipping margin of the stack after it [m]; None where no model computes one
    riding: tuple[BodyId, ...] = field(default=(), compare=False)  # bricks that move as rigid bodies on others from now


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
    DISPLACED = "displaced"  # stands, upright and at its height, where a hit has shifted it to
    FALLEN = "fallen"  # left its place
    THROWN = "thrown"  # came flying; no part of the structure, wherever it ended
    UNSETTLED = "unsettled"  # dropped, or proven to fall, and still on its way
    REMOVED = "removed"  # pulled out
    UNPLACED = "unplaced"  # the structure fell before its turn
    UNWATCHED = "unwatched"  # not proven to stand, and nothing was asked that an engine would have to show


STAND = frozenset({BrickState.FROZEN, BrickState.STANDING, BrickState.DISPLACED})
NO_PART = frozenset({BrickState.REMOVED, BrickState.THROWN})  # of the structure: nothing is claimed of these


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
    sunk: float | None = None  # the same below `rest`, from the first hit on [m]: only this, or a tilt, collapses then
    frozen: bool = False  # whether it is held fixed at the end, with whatever proof
    gives_way: str = ""  # why it is proven not to stand where it is, though it has not left its place yet


@dataclass(frozen=True, slots=True)
class Collapse:
    """The first time that a brick which had come to rest left its place."""

    time: float  # [s]
    level: int  # level under construction
    brick: BodyId  # the brick that left first
    gave_way: BodyId | None = None  # the brick whose support test failed, where a model names it
    step: str = ""  # of the build, such as `step 5`, where several build that level
    broke: int | None = None  # level of what gave way, where the last that was done set nothing down


@dataclass(frozen=True, slots=True)
class Updates:
    """What single updates of the extension took, each a wait for whoever moves bricks by hand."""

    median: float  # [s]
    worst: float  # [s]


@dataclass(frozen=True, slots=True)
class Cost:
    """What a run took."""

    wall_time: float  # [s]
    simulated_time: float  # of the scenario's clock [s]
    steps: int  # engine steps
    judgements: int  # passes of the stability extension
    proofs: Mapping[str, int] = field(default_factory=dict)  # how many times bricks were proven to stand, by stage
    one_by_one: int = 0  # most bricks at a time that the engine moved one by one, rather than held or moved as one body
    updates: Updates | None = field(default=None, compare=False)  # None where no extension was asked


NOTABLE_GAIN = 0.01  # of the energy of what moves: nothing in a scene adds any, so more of it than this is a fault


@dataclass(frozen=True, slots=True)
class Energy:
    """Kinetic and potential energy of all bricks, thrown ones included, from the last action on."""

    start: float  # just after it, with what it brought in [J]
    risen: float  # how much more the bricks that moved since ever had of it [J]
    of_what_moved: float  # that these had just after it, heights as distances from the ground, and got from outside [J]
    gained_before: float = 0.0  # the largest gain between any two earlier actions, as a share like `gain`

    @property
    def gain(self) -> float:
        """How much it rose, as a share of the motion and the distance from the ground of what moved."""
        return self.risen / self.of_what_moved if self.of_what_moved > 0.0 else (inf if self.risen > 0.0 else 0.0)


@dataclass(frozen=True, slots=True)
class Onset:
    """How what statics proved to fall began to: each brick where it was, and when the first had turned by 5 deg."""

    motion: Motion  # that the proof names
    poses: Mapping[BodyId, tuple[Pose, Pose]]
    about: tuple[BodyId, ...]  # what stands still where something that moves touches it and does not slip


@dataclass(frozen=True, slots=True)
class Landing:
    """When what had left its place was fastest: the moment before the ground takes it."""

    time: float  # [s]
    shift: tuple[float, float]  # of the common centre of mass of what fell, sideways from where it had been at rest [m]
    over: bool = True  # whether what fell has come to move so little that no faster moment will follow

    @property
    def reach(self) -> float:
        """How far sideways [m]."""
        return hypot(*self.shift)

    @property
    def bearing(self) -> float:
        """Which way, from +x towards +y [rad]."""
        return atan2(self.shift[1], self.shift[0])


@dataclass(frozen=True, slots=True)
class Sway:
    """The largest swing to and fro of a brick that had come to rest, before anything left its place."""

    amplitude: float  # to either side [m]
    frequency: float  # [Hz]
    brick: BodyId
    time: float  # when it was seen [s]


@dataclass(frozen=True, slots=True)
class Penetration:
    """The deepest that two bodies were in each other."""

    depth: float  # [m]
    brick: BodyId
    other: BodyId  # a brick, the ground or a wall
    time: float  # when it was seen [s]


@dataclass(frozen=True, slots=True)
class WrongEdges:
    """Bricks that touched edge on edge, under load, and that the engine pushed apart along a wrong normal."""

    contacts: int  # pairs of bricks
    upper: BodyId  # of the pair whose normal was most wrong
    lower: BodyId
    angle: float  # between its normal and the true one [rad]
    time: float  # when that was seen [s]
    first: float  # when any of them was first seen [s]


@dataclass(frozen=True, slots=True)
class Passed:
    """A thrown brick that passed through another, as its engine stepped too coarsely for its speed."""

    brick: BodyId
    through: BodyId
    time: float  # when that was seen [s]
    travel: float  # how far it had come since it was looked at before [m]


@dataclass(frozen=True, slots=True)
class EarlyEnd:
    """Why a run ended before its time: it had collapsed, and all that is asked of it was known."""

    time: float  # [s]
    planned: float  # until when it would have gone on [s]
    undone: tuple[Action, ...] = ()  # what would still have been done


NUMERICAL_COLLAPSE = "numerical-collapse"  # in place of a verdict: it fell, and nothing but the solver made it
UNRELIABLE = "unreliable"  # in place of a verdict: the engine had added energy before anything fell


class RunVerdict(StrEnum):
    """What came of the structure as a whole."""

    STANDS = "stands"
    COLLAPSES = "collapses"
    UNSETTLED = "unsettled"  # nothing left its place yet, but something was dropped or gives way, and is on its way
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
    world: FixedWorld | None = None  # what did not move
    last_arrival: float = 0.0  # when the last hit met what it was aimed at, or was to [s]
    statics: Verdict | None = None  # when bricks were last set down or pulled out; None where nothing proves
    margins: VerdictMargins = VerdictMargins()
    energy: Energy | None = None  # None before anything was done
    onset: Onset | None = None  # None where nothing was proven to fall, or fell so, or nobody asked
    landing: Landing | None = None  # None where nothing fell, or nobody asked
    sway: Sway | None = None  # None where nothing sways, or nobody asked
    penetration: Penetration | None = None  # None where nothing was placed, or nobody asked
    wrong_edges: WrongEdges | None = None  # None where no contact was seen to have a wrong normal
    wrong_friction: WrongFriction | None = None  # the worst that an engine has had; None where it had what was asked
    passed_through: Passed | None = None  # the first; None where no thrown brick passed through another
    shift_before: float = 0.0  # largest of any brick when one was last set down before a collapse, or at all [m]
    moving: tuple[BodyId, ...] = ()  # what was not at rest when the run ended, thrown bricks included
    early_end: EarlyEnd | None = None  # None where it went on for as long as it was to
    disproof: Verdict | None = None  # that what fell had to, on a system that proves nothing
    numerical: str = ""  # why the collapse is the solver's and none of physics; empty where nothing says so
    # The run so far when the engine was first seen to have added a notable share of energy; None where it never was.
    before_fault: "Trace | None" = None

    @property
    def energy_gained(self) -> float:
        """The share of energy that an engine has added by itself; 0 where that is no more than a watch may miss."""
        gain = max(self.energy.gain, self.energy.gained_before) if self.energy is not None else 0.0
        return gain if gain > NOTABLE_GAIN else 0.0

    @property
    def unreliable(self) -> bool:
        """Whether the engine had added a notable share of energy before anything fell, so that the verdict is its own.

        A collapse before that is not in doubt; what comes of it is.
        """
        return self.before_fault is not None and self.before_fault.collapse is None

    @property
    def undone(self) -> tuple[Action, ...]:
        """What was still to be done when the run ended."""
        return self.early_end.undone if self.early_end is not None else ()

    @property
    def gone(self) -> Set[BodyId]:
        """What was still to be pulled out then: it counts as pulled out, so that ending early makes no difference."""
        return {brick for action in self.undone if isinstance(action, Removal) for brick in action.bricks}

    @property
    def last_action(self) -> float:
        """When a brick was last placed, pulled out, thrown or pushed [s]."""
        return max((event.time for event in self.events if event.kind in ACTIONS), default=0.0)

    @property
    def verdict(self) -> RunVerdict:
        """What came of the structure as a whole."""
        if self.collapse is not None:
            return RunVerdict.COLLAPSES
        states = {track.state for track in self.tracks.values()}
        if BrickState.UNWATCHED in states:
            return RunVerdict.UNWATCHED
        return RunVerdict.UNSETTLED if BrickState.UNSETTLED in states else RunVerdict.STANDS

    @property
    def reported_verdict(self) -> str:
        """The verdict as people are told it: one that is none of physics, or in doubt, is called so."""
        return NUMERICAL_COLLAPSE if self.numerical else UNRELIABLE if self.unreliable else self.verdict.value

    @property
    def unsettled(self) -> Sequence[BrickTrack]:
        """What has neither come to rest nor left its place: dropped, or proven to fall, in order of placement."""
        return [track for track in self.tracks.values() if track.state is BrickState.UNSETTLED]

    @property
    def drift(self) -> float:
        """Largest shift of any brick of the structure after it came to rest, those that fell included [m]."""
        remaining = (track for track in self.tracks.values() if track.state not in NO_PART)
        return max((track.shift for track in remaining), default=0.0)


# A number that was measured, beside what was expected of it, for programs to go on with.


@dataclass(frozen=True, slots=True)
class Measure:
    """One number, in its unit, and between which it was to be; None where there is no such limit."""

    value: float
    least: float | None
    most: float | None
    unit: str  # as people are told: mm, deg, %, s; `levels` and `bricks` of counts


# Counts of the samples of one case: plain data for judge, snapshot and report.


OnDrawn: TypeAlias = Callable[[str, int, int], None]  # told of a case: its name, samples drawn, and how many may be


def untold(name: str, drawn: int, planned: int) -> None:
    """Nobody is told."""


@dataclass(frozen=True, slots=True)
class Ensemble:
    """The samples that were judged, from the first on, and what became of them."""

    drawn: int
    planned: int  # how many may be drawn at most
    seed: int
    stood: int
    fell: Mapping[int, int]  # by the level under construction
    undecided: int = 0  # of which statics proves neither
    unfit: int = 0  # of which hands found no place for a brick beside others
    ways: Mapping[str, int] = field(default_factory=dict)  # how many samples each way decided
    cpu_time: float = field(default=0.0, compare=False)  # [s], of all processes together

    @property
    def unknown(self) -> int:
        """The samples that may have gone either way."""
        return self.undecided + self.unfit

    @property
    def summary(self) -> str:
        """What became of most of them, in words."""
        return f"{self.stood} of {self.drawn} stand"
