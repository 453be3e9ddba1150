"""Trace of a run, as plain data: events, measurements, proof margins, counts of samples."""

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import atan2, degrees, dist, hypot, inf
from typing import Final, TypeAlias

from stability.analysis.weakest import Apart, Weakest
from stability.engines.protocol import EngineSettings, WrongFriction
from stability.geometry.vectors import lean_between
from stability.model import BodyId, Brick, Pose
from stability.name_order import MOST_NAMES, in_order, names_text
from stability.problem import Crushing, Motion, PlacementLimit, Verdict
from stability.statics.assembly import Assembly
from stackdsl.timeline import AccelerationTest, Action, FixedWorld, Removal
from stackdsl.wording import broke_text, how_many, level_text, mm

# Margins of a proof.


ALL_LOADS: Final = "load on all bricks"


USED_STRENGTH: Final = "used_strength"  # the margin


def load_on(lower: BodyId, upper: BodyId = "") -> str:
    """Return the name of the margin that is the load on a body, or the part of it by one brick."""
    return f"load on {lower} by {upper}" if upper else f"load on {lower}"


def is_load(margin: str) -> bool:
    """Return whether a margin is a load on bodies."""
    return margin.startswith("load on ")


@dataclass(frozen=True, slots=True)
class CarriedRange:
    """Proven range of the normal force on a body."""

    lower: BodyId
    upper: BodyId  # the brick that lies on it; "" for all that do
    least: float  # [N]
    greatest: float  # [N]; inf if none is proven
    area: float  # of the contacts of faces [m2]


@dataclass(frozen=True, slots=True, kw_only=True)
class VerdictMargins:
    """Margins of a proof. Each is None if no claim needs it, or if no structure is proven to stand."""

    acceleration: float | None = None  # least horizontal acceleration, over all bearings, that brings it down [g]
    apart: Apart | None = None  # the same without friction between side faces; None where that is equal
    bearing: float | None = None  # of that acceleration, from +x towards +y [rad]
    tilt: float | None = None  # least tilt of the whole scene that brings it down [rad]
    friction: float | None = None  # least Coulomb coefficient of the roughest contact, with all others in proportion
    roughest: float | None = None  # actual coefficient of that contact
    placement: float | None = None  # error in the position of every brick under which it still stands [m]
    joints: tuple[PlacementLimit, ...] = ()  # the contacts that limit `placement` equally
    guaranteed: bool | None = None  # whether rest is the only possible outcome
    certainty: str = ""  # reason for `guaranteed`; empty where normal forces alone balance everything
    squeezed: bool | None = None  # whether the margins rely on contacts whose pressure statics does not determine
    weakest: Weakest | None = None  # the mechanism that opens first under the least acceleration
    load_factor: float | None = None  # multiple of its own weight, or of its loads, that it bears; inf for any
    loaded: bool = False  # whether `load_factor` is that of the loads, beside the weight
    settlement: float | None = None  # multiple of the written movement of supports that it survives; inf for any
    yields: str = ""  # what gives way first above that load factor; empty if nothing does
    used_strength: float | None = None  # share of the strengths of all bricks that all possible forces need
    carried: tuple[CarriedRange, ...] = ()  # the requested loads on bodies


@dataclass(frozen=True, slots=True)
class PulseMotion:
    """Horizontal displacements of the corners of all bricks by a pulse, relative to the ground."""

    height: float  # of the structure [m]
    largest: float  # at any time [m]
    permanent: float  # largest at the end [m]
    lowest: float  # largest of the corners in the lowest 200 mm [m]
    fallen: tuple[BodyId, ...]
    is_moving: bool  # whether bricks still move at the end


@dataclass(frozen=True, slots=True)
class AccelerationResult:
    """The result of a test of the finished structure."""

    test: AccelerationTest
    survived: float  # acceleration that is proven to be borne for any time, as a multiple of gravity; inf for any
    fails: float  # acceleration that is proven not to be borne; inf if none is
    gives_way: str  # first mechanism, in words; empty if none is proven
    motion: PulseMotion | None = None  # None if no pulse was simulated


# Trace of one run: plain data for judge, snapshot and report.


# A brick that came to rest has left its place beyond these limits (DESIGN, "collapse"). Its centre has sunk, or, before
# the first hit, shifted by more than this share of its smallest side (docs/design/hits.md).
COLLAPSE_SHARE_OF_SMALLEST_SIDE = 0.5
COLLAPSE_TILT = 0.2617993877991494  # [rad], 15 deg


class EventKind(StrEnum):
    """Kind of an event."""

    PLACED = "placed"
    FROZEN = "frozen"
    WOKEN = "woken"
    HIT = "hit"  # a thrown or dropped brick first touches another body
    REMOVED = "removed"
    JOINED = "joined"
    SET = "set"  # mortar or glue that holds from now on
    CUT = "cut"  # joints
    LOADED = "loaded"  # a load begins
    PUSHED = "pushed"
    SHAKEN = "shaken"  # the ground, without bricks
    TAKEN = "taken"  # a hand begins to move or hold a brick
    LET_GO = "let go"  # a hand releases a brick
    COLLAPSED = "collapsed"
    CRUSHED = "crushed"  # a brick; the motion that follows is not modelled
    OPENED = "opened"  # joints that did not bear their loads; the bricks of all


JOINING = frozenset({EventKind.JOINED, EventKind.SET, EventKind.CUT})  # changes of joints
# Events that are actions of the scenario; all others are consequences.
ACTIONS = frozenset(EventKind) - {
    EventKind.FROZEN,
    EventKind.WOKEN,
    EventKind.HIT,
    EventKind.COLLAPSED,
    EventKind.CRUSHED,
    EventKind.OPENED,
}


@dataclass(frozen=True, slots=True)
class Event:
    """An event of bricks at one time."""

    time: float  # [s]
    kind: EventKind
    bricks: tuple[BodyId, ...]
    reason: str = ""
    margin: float | None = None  # least tipping margin of the stack after it [m]; None if the model has none
    riding: tuple[BodyId, ...] = field(default=(), compare=False)  # bricks that now move with others as one rigid body
    flying: tuple[BodyId, ...] = field(default=(), compare=False)  # placed bricks that are thrown or dropped
    # Frozen bricks that had fallen, or were thrown or dropped: they lie at rest, but do not stand in their places.
    lying: tuple[BodyId, ...] = field(default=(), compare=False)

    @property
    def parts(self) -> "tuple[Event, ...]":
        """Return the event as two: of bricks in their places, and of those that fly or lie; as it is without both."""
        away = self.flying or self.lying
        resting = tuple(brick for brick in self.bricks if brick not in away)
        if not away or not resting:
            return (self,)
        return replace(self, bricks=resting, flying=(), lying=()), replace(self, bricks=away)


@dataclass(frozen=True, slots=True)
class Edge:
    """The upper brick is carried by the lower body through a contact."""

    upper: BodyId
    lower: BodyId
    # Share of the load of the upper brick, with its own weight, that the lower body carries; NaN where the support is
    # statically indeterminate.
    share: float


NOT_MODELLED: Final = "the motion after crushing is not modelled"


class BrickState(StrEnum):
    """State of a brick at the end of a run."""

    FROZEN = "frozen"  # stands, held fixed by the stability extension
    STANDING = "standing"  # stands, simulated by the engine
    DISPLACED = "displaced"  # stands, upright and at its height, but shifted by a hit
    FALLEN = "fallen"  # moved, sank or tilted beyond the limits above
    THROWN = "thrown"  # thrown or dropped by an impact; not part of the structure
    UNSETTLED = "unsettled"  # dropped, or proven to fall, and still moving
    REMOVED = "removed"  # pulled out
    UNPLACED = "unplaced"  # the structure fell before it was placed
    UNWATCHED = "unwatched"  # not proven to stand, and not simulated, since no claim needs it


STAND = frozenset({BrickState.FROZEN, BrickState.STANDING, BrickState.DISPLACED})
NO_PART = frozenset({BrickState.REMOVED, BrickState.THROWN})  # not part of the structure: claims ignore these


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
    tilt: float  # largest rotation out of `rest` afterwards [rad]
    left_at: float | None = None  # when it left its place [s]
    sunk: float | None = None  # largest depth below `rest` after the first hit [m], in place of `shift` for a collapse
    frozen: bool = False  # whether it is held fixed at the end, by any proof
    gives_way: str = ""  # reason why it is proven not to stand, if it has not left its place yet

    @property
    def end_shift(self) -> float:
        """Distance of its final centre from `rest` [m]."""
        return dist(self.final.position_W, self.rest.position_W)

    @property
    def end_tilt(self) -> float:
        """Angle between its final vertical axis and that of `rest` [rad]."""
        return lean_between(self.rest, self.final)

    @property
    def fell_by(self) -> str:
        """Return by how much a fallen brick left its place, in words; empty for others."""
        if self.state is not BrickState.FALLEN:
            return ""
        limit = COLLAPSE_SHARE_OF_SMALLEST_SIDE * self.brick.shape.least_thickness
        way, word = (self.shift, "moved") if self.sunk is None else (self.sunk, "sank")
        beyond = [f"{word} by {mm(way, 3)}"] if way > limit else []
        beyond += [f"tilted by {degrees(self.tilt):.3g} deg"] if self.tilt > COLLAPSE_TILT else []
        return ", ".join(beyond)

    @property
    def stands_again(self) -> bool:
        """Return true if the brick fell by the rule for hits, but ends within the limits of a fall, proven to stand."""
        limit = COLLAPSE_SHARE_OF_SMALLEST_SIDE * self.brick.shape.least_thickness
        within = self.rest.position_W[2] - self.final.position_W[2] <= limit and self.end_tilt <= COLLAPSE_TILT
        return self.state is BrickState.FALLEN and self.sunk is not None and self.frozen and within


@dataclass(frozen=True, slots=True)
class Collapse:
    """The first time that a brick which came to rest left its place."""

    time: float  # [s]
    level: int  # level under construction
    brick: BodyId  # the brick that left first
    gave_way: BodyId | None = None  # the brick whose support test failed, if the model names it
    step: str = ""  # of the build, such as `step 5`, if several steps build that level
    broke: int | None = None  # level of the brick that gave way, if the last action placed no brick
    by: str = field(default="", compare=False)  # motion of `brick` until `time`, such as `sunk 4.1 mm`
    # If the build was finished before: bricks that fell by the end of the run, and the size of the structure.
    fallen: tuple[BodyId, ...] = field(default=(), compare=False)
    bricks: int = field(default=0, compare=False)
    crushing: Crushing | None = None  # cause of a collapse whose motion is not modelled

    @property
    def text(self) -> str:
        """Return where and when it fell; of a finished structure, how many bricks fell, and which if they are few."""
        if self.crushing is not None:
            where = f"at {level_text(self.level, self.step)}"
            return f"crushes {where} after {self.time:.3f} s: {self.crushing.text}"
        broke = broke_text(self.broke, self.gave_way)
        if not self.fallen:
            return f"collapses at {level_text(self.level, self.step)} after {self.time:.3f} s{broke}"
        fell, at = f"{len(self.fallen)} of {how_many(self.bricks, 'brick')} fell after the build", f"{self.time:.3f} s"
        if len(self.fallen) == 1:
            return f"{fell}: {self.brick} at {at}{broke}"
        named = f": {names_text(in_order(self.fallen))}" if len(self.fallen) <= MOST_NAMES else ""
        return f"{fell}{named}, first {self.brick} at {at}{broke}"


@dataclass(frozen=True, slots=True)
class Updates:
    """Durations of single updates of the stability extension, which delay an interactive simulation."""

    median: float  # [s]
    worst: float  # [s]


@dataclass(frozen=True, slots=True)
class Cost:
    """Cost of a run."""

    wall_time: float  # [s]
    simulated_time: float  # of the scenario's clock [s]
    steps: int  # engine steps
    judgements: int  # passes of the stability extension
    proofs: Mapping[str, int] = field(default_factory=dict)  # number of proofs that bricks stand, by stage
    one_by_one: int = 0  # most bricks that the engine moved individually at a time, neither frozen nor as one body
    updates: Updates | None = field(default=None, compare=False)  # None without a stability extension


@dataclass(frozen=True, slots=True)
class Energy:
    """Kinetic and potential energy of all bricks, thrown ones included, from the last action on."""

    start: float  # just after the action, with the energy that it brings in [J]
    risen: float  # largest rise of the energy of the bricks that moved since [J]
    # Energy of these bricks just after the action, with potential energy 0 at the ground, and work done on them [J].
    of_what_moved: float
    gained_before: float = 0.0  # largest gain between any two earlier actions, as a share like `gain`
    most_gain: float = EngineSettings.most_gain  # larger gains are errors of the engine

    @property
    def gain(self) -> float:
        """Return the rise, as a share of the kinetic and potential energy of the bricks that moved."""
        return self.risen / self.of_what_moved if self.of_what_moved > 0.0 else (inf if self.risen > 0.0 else 0.0)

    @property
    def added(self) -> float:
        """Return the share of energy that the engine added between two actions; 0 if it is within its accuracy."""
        gain = max(self.gain, self.gained_before)
        return gain if gain > self.most_gain else 0.0


@dataclass(frozen=True, slots=True)
class Onset:
    """Onset of a proven fall: pose of each brick before, and when the first brick has turned by 5 deg."""

    motion: Motion  # of the proof
    poses: Mapping[BodyId, tuple[Pose, Pose]]
    about: tuple[BodyId, ...]  # standing bodies that a moving brick touches without slipping


@dataclass(frozen=True, slots=True)
class Landing:
    """The moment of highest speed of the fallen bricks, just before the ground stops them."""

    time: float  # [s]
    shift: tuple[float, float]  # horizontal, of their common centre of mass, relative to its place at rest [m]
    over: bool = True  # whether they have slowed down so far that no faster moment can follow

    @property
    def reach(self) -> float:
        """Return the horizontal distance [m]."""
        return hypot(*self.shift)

    @property
    def bearing(self) -> float:
        """Return the direction, from +x towards +y [rad]."""
        return atan2(self.shift[1], self.shift[0])


@dataclass(frozen=True, slots=True)
class Sway:
    """The largest swing of a brick that came to rest, before any brick left its place."""

    amplitude: float  # to either side [m]
    frequency: float  # [Hz]
    brick: BodyId
    time: float  # of the observation [s]


@dataclass(frozen=True, slots=True)
class Penetration:
    """The deepest overlap of two bodies."""

    depth: float  # [m]
    brick: BodyId
    other: BodyId  # a brick, the ground or a wall
    time: float  # of the observation [s]


@dataclass(frozen=True, slots=True)
class WrongEdges:
    """Loaded edge-edge contacts of bricks for which the engine used a wrong normal."""

    contacts: int  # pairs of bricks
    upper: BodyId  # of the pair with the largest error
    lower: BodyId
    angle: float  # between its normal and the true one [rad]
    time: float  # of that observation [s]
    first: float  # time of the first observation of any pair [s]


@dataclass(frozen=True, slots=True)
class PassedThrough:
    """A thrown brick that passed through another, since the time step of the engine was too long for its speed."""

    brick: BodyId
    through: BodyId
    time: float  # of the observation [s]
    travel: float  # distance since the observation before [m]


@dataclass(frozen=True, slots=True)
class EarlyEnd:
    """The early end of a run that had collapsed, when all claims were decided."""

    time: float  # [s]
    planned: float  # regular end of the run [s]
    undone: tuple[Action, ...] = ()  # remaining actions


NUMERICAL_COLLAPSE = "numerical-collapse"  # in place of a verdict: only the solver caused the collapse
UNRELIABLE = "unreliable"  # in place of a verdict: the engine added energy before any brick fell


class RunVerdict(StrEnum):
    """Outcome of the whole structure."""

    STANDS = "stands"
    COLLAPSES = "collapses"
    UNSETTLED = "unsettled"  # no brick has left its place, but a dropped or unstable brick is still moving
    UNWATCHED = "unwatched"  # judged by statics without a simulation, since no claim needs one


@dataclass(frozen=True, slots=True)
class Trace:
    """Record of a whole run."""

    events: tuple[Event, ...]
    tracks: Mapping[BodyId, BrickTrack]  # in order of placement
    edges: tuple[Edge, ...]  # supports of the standing bricks at the end; by upper, then lower
    collapse: Collapse | None
    cost: Cost
    # Supports of each brick after it was judged or had settled, taken at the next placement; for snapshots.
    edges_when_placed: Mapping[BodyId, tuple[Edge, ...]]
    world: FixedWorld | None = None
    last_arrival: float = 0.0  # actual or expected time at which the last hit reached its target [s]
    statics: Verdict | None = None  # after the last placement or removal; None on a system without proofs
    margins: VerdictMargins = VerdictMargins()
    # Of the finished structure, if claims need them; None if it is not proven to stand.
    tests: tuple[AccelerationResult, ...] | None = None
    energy: Energy | None = None  # None before the first action
    onset: Onset | None = None  # None without a proven fall that was simulated, or if no claim needs it
    landing: Landing | None = None  # None if no brick fell, or if no claim needs it
    sway: Sway | None = None  # None if no brick sways, or if no claim needs it
    penetration: Penetration | None = None  # None if no brick was placed, or if no claim needs it
    wrong_edges: WrongEdges | None = None  # None if no contact with a wrong normal was observed
    wrong_friction: WrongFriction | None = None  # largest error in the friction of the engine; None if it was right
    passed_through: PassedThrough | None = None  # the first; None if no thrown brick passed through another
    shift_before: float = 0.0  # largest shift of a brick at the last placement, or the last before a collapse [m]
    moving: tuple[BodyId, ...] = ()  # bricks that were moving when the run ended, with thrown ones
    rocking: tuple[BodyId, ...] = ()  # of these, the fallen and thrown ones that stayed in place for the last second
    early_end: EarlyEnd | None = None  # None if the run went on to its regular end
    disproof: Verdict | None = None  # proof that the fallen bricks had to fall, on a system without proofs
    numerical: str = ""  # evidence that the solver, not physics, caused the collapse; empty if there is none
    unknown_loads: frozenset[BodyId] = frozenset()  # standing bricks on which the engine reported no contact force
    # Of the frozen bricks at the end, in the process of the run; None where several islands have their own.
    assembly: Assembly | None = field(default=None, compare=False, repr=False)
    # The run up to the moment when the engine had added a notable share of energy; None if it never did.
    before_fault: "Trace | None" = None

    @property
    def crushing(self) -> Crushing | None:
        """Return the brick that crushed, and ended the run; None if none did."""
        return None if self.collapse is None else self.collapse.crushing

    @property
    def energy_gained(self) -> float:
        """Return the share of energy that the engine added; 0 if it is within its accuracy."""
        return self.energy.added if self.energy is not None else 0.0

    @property
    def unreliable(self) -> bool:
        """Return whether the engine had added a notable share of energy before any brick fell.

        The verdict is then unreliable. A collapse before that is certain; the motion after it is not.
        """
        return self.before_fault is not None and self.before_fault.collapse is None

    @property
    def undone(self) -> tuple[Action, ...]:
        """Return the actions that remained when the run ended."""
        return self.early_end.undone if self.early_end is not None else ()

    @property
    def pending_removals(self) -> Set[BodyId]:
        """Return the bricks that were still to be pulled out when the run ended.

        They count as removed, so that an early end does not change the result.
        """
        return {brick for action in self.undone if isinstance(action, Removal) for brick in action.bricks}

    @property
    def last_action(self) -> float:
        """Return the time of the last action on a brick [s]."""
        return max((event.time for event in self.events if event.kind in ACTIONS), default=0.0)

    @property
    def verdict(self) -> RunVerdict:
        """Return the outcome of the whole structure."""
        if self.collapse is not None:
            return RunVerdict.COLLAPSES
        states = {track.state for track in self.tracks.values()}
        if BrickState.UNWATCHED in states:
            return RunVerdict.UNWATCHED
        return RunVerdict.UNSETTLED if BrickState.UNSETTLED in states else RunVerdict.STANDS

    @property
    def reported_verdict(self) -> str:
        """Return the verdict for reports, which marks a numerical collapse and an unreliable run."""
        return NUMERICAL_COLLAPSE if self.numerical else UNRELIABLE if self.unreliable else self.verdict.value

    @property
    def unsettled(self) -> Sequence[BrickTrack]:
        """Return the bricks that have neither come to rest nor left their place, in order of placement."""
        return [track for track in self.tracks.values() if track.state is BrickState.UNSETTLED]

    @property
    def drift(self) -> float:
        """Return the largest shift of any brick of the structure after it came to rest, with fallen bricks [m]."""
        remaining = (track for track in self.tracks.values() if track.state not in NO_PART)
        return max((track.shift for track in remaining), default=0.0)


# A measured number with its limits, for machine-readable reports.


@dataclass(frozen=True, slots=True)
class Measure:
    """A number and its lower and upper limit; None for no limit."""

    value: float
    least: float | None
    most: float | None
    unit: str  # as in reports: mm, deg, %, s; `levels` and `bricks` for counts


# Counts of the samples of one case: plain data for judge, snapshot and report.


OnDrawn: TypeAlias = Callable[[str, int, int], None]  # progress callback: name of the case, samples drawn, planned


def ignore_progress(name: str, drawn: int, planned: int) -> None:
    """Ignore progress."""


@dataclass(frozen=True, slots=True)
class Ensemble:
    """Counts of the judged samples by their outcome."""

    drawn: int
    planned: int  # largest number of samples
    seed: int
    stood: int
    fell: Mapping[int, int]  # by the level under construction
    undecided: int = 0  # neither proven to stand nor to fall
    unfit: int = 0  # without room for a brick, due to the errors of others
    ways: Mapping[str, int] = field(default_factory=dict)  # number of samples by the method that decided them
    cpu_time: float = field(default=0.0, compare=False)  # [s], of all processes together

    @property
    def unknown(self) -> int:
        """Return the number of samples without a verdict."""
        return self.undecided + self.unfit

    @property
    def summary(self) -> str:
        """Return the result in words."""
        return f"{self.stood} of {self.drawn} stand"
