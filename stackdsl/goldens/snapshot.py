"""Trace -> snapshot: the observations that a golden file locks, with their precision."""

import sys
from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from itertools import takewhile
from math import atan2, degrees, hypot, inf, isfinite, isnan
from typing import TypeAlias

from stability.contact_law import Friction, GivenFriction, Rule, as_friction
from stability.geometry.box import Box
from stability.geometry.placed_shape import bounds_W, top_W
from stability.model import BodyId, ConvexShape, Pose, Vec3
from stability.problem import Stage
from stackdsl.results import GoldenDifference
from stackdsl.timeline import Action, Arrival, FixedWorld, Placement, PushAction
from stackdsl.trace import (
    ACTIONS,
    COLLAPSE_SHARE_OF_SMALLEST_SIDE,
    COLLAPSE_TILT,
    JOINING,
    NO_PART,
    STAND,
    BrickState,
    BrickTrack,
    Collapse,
    Edge,
    Ensemble,
    Event,
    EventKind,
    Trace,
)

# The observations that a golden file locks, and the tolerance of each kind of number.
#
# They are readable facts that a small disturbance does not change: a collapse is chaotic once it is under way, and a
# bare engine creeps. An observation that is not clear-cut is written as `unclear`, which equals anything, or left out.


FORMAT = 1  # of the file; raise it whenever an older file can no longer be compared
UNCLEAR = "unclear"  # too close to a limit to be certain; equal to any value


class MalformedSnapshotError(ValueError):
    """A golden file contains JSON that is not a valid snapshot. The message has the place."""


Number: TypeAlias = float | str  # text where a number is unclear or not finite: JSON has no infinity


@dataclass(frozen=True, slots=True)
class Quantity:
    """A kind of number, with its written precision and the tolerance of a comparison."""

    unit: str
    digits: int  # decimals written; ten times finer than the tolerance for results, so that rounding never decides
    tolerance: float  # in `unit`


POSITION = Quantity("mm", 2, 0.5)  # half the moulding tolerance of a brick
HEIGHT = Quantity("mm", 2, 0.5)  # as POSITION: it is the top of one brick
MARGIN = Quantity("mm", 2, 0.2)  # finer than POSITION: it follows from contact corners, which agree within 0.1 mm
SHARE = Quantity("", 3, 0.02)  # effect of 0.5 mm on a lever of 24 mm, a plank's width
COLLAPSE_TIME = Quantity("s", 3, 0.05)  # solvers differ by up to 0.02 s in the time of a visible fall
PLACING_TIME = Quantity("s", 3, 0.005)  # one step of the coarsest engine, 1/240 s
# Input of the author is compared to the last written digit, which rounding may change.
PLACE = Quantity("mm", 2, 0.01)
TURN = Quantity("deg", 3, 0.001)
SIZE = Quantity("mm", 4, 0.0001)
VOLUME = Quantity("mm3", 3, 0.001)
MASS = Quantity("g", 5, 0.00001)
GRAVITY = Quantity("m/s2", 6, 0.000001)
FRICTION = Quantity("", 6, 0.000001)
NORMAL = Quantity("", 6, 0.000001)
VELOCITY = Quantity("mm/s", 3, 0.001)
IMPULSE = Quantity("mN*s", 6, 0.000001)


@dataclass(frozen=True, slots=True)
class Identity:
    """The identity of a run."""

    scenario: str
    variant: str  # such as `step=10mm,thesis`
    system: str

    @property
    def case(self) -> str:
        """Return the name of the case: the scenario, then the variant in brackets."""
        return f"{self.scenario}[{self.variant}]"


@dataclass(frozen=True, slots=True)
class FirstCollapse:
    """The collapse; fields that are None are not locked."""

    level: int
    time_s: Number | None
    gave_way: BodyId | None


@dataclass(frozen=True, slots=True)
class RecordedBrick:
    """A placed brick, with the bricks that carried it once it had been judged."""

    at_mm: tuple[Number, ...]  # centre of mass in W
    turn_deg: tuple[Number, ...]  # from body axes to W: axis times angle
    size_mm: tuple[Number, ...]  # of the box around it, along its own axes
    mass_g: Number
    rests_on: Mapping[BodyId, Number] | None  # shares; None without a model that computes them
    centre_of_mass_mm: tuple[Number, ...] | None = None  # from the middle of the box around it; None if it is a box
    volume_mm3: Number | None = None  # None for a box
    velocity_mm_s: tuple[Number, ...] | None = None  # in W, of a thrown brick; None for others


@dataclass(frozen=True, slots=True)
class Placing:
    """Bricks set down at one time."""

    time_s: Number
    margin_mm: Number | None  # least tipping margin of the stack afterwards; None without a model that computes it
    placed: Mapping[BodyId, RecordedBrick]


@dataclass(frozen=True, slots=True)
class Removing:
    """Bricks pulled out at one time."""

    time_s: Number
    removed: tuple[BodyId, ...]


@dataclass(frozen=True, slots=True)
class Pushing:
    """Bricks pushed at one time."""

    time_s: Number
    pushed: tuple[BodyId, ...]
    impulses_mNs: Mapping[BodyId, tuple[Number, ...]] | None = None  # in W; None in files of earlier versions


@dataclass(frozen=True, slots=True)
class FinalBrick:
    """The final state of a brick; fields that are None are not locked."""

    level: int
    state: str  # a BrickState, or UNCLEAR
    at_mm: tuple[Number, ...] | None
    rests_on: Mapping[BodyId, Number] | None


@dataclass(frozen=True, slots=True)
class FixedPlane:
    """The ground or a wall."""

    at_mm: tuple[Number, ...]
    normal: tuple[Number, ...]
    friction: Number


@dataclass(frozen=True, slots=True)
class GoldenScene:
    """The fixed part of a scene, which tells snapshots of different scenes apart."""

    gravity: Number  # [m/s2]
    friction: Number
    planes: Mapping[BodyId, FixedPlane]
    rubbing: Mapping[str, Number | str] | None = None  # other friction than the usual one; None if there is none


@dataclass(frozen=True, slots=True)
class Samples:
    """Counts of the outcomes of samples; exact, as the seed determines the samples."""

    seed: int
    drawn: int
    stood: int
    fell: Mapping[str, int]  # by level
    undecided: int
    unfit: int


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The locked observations of one run; fields that are None are not locked."""

    identity: Identity
    stamp: Mapping[str, str]  # versions of the software that made it
    world: GoldenScene
    verdict: str
    statics: str | None  # verdict when bricks were last set down; None on systems without proofs
    collapse: FirstCollapse | None
    height_mm: Number | None  # of the standing bricks
    levels_standing: Number | None  # counted from the first, as long as every brick of a level stands
    events: tuple[Placing | Removing | Pushing, ...]
    bricks: Mapping[BodyId, FinalBrick]  # by level, then name
    kept_by: str | None = None  # owner, see `stackdsl.goldens.golden`; never compared
    samples: Samples | None = None  # None for a single run
    missed: tuple[str, ...] = field(default=(), compare=False)  # failed expectations of the run; not locked
    fallen: int | None = field(default=None, compare=False)  # bricks that fell; not locked, as the number is chaotic
    slid: frozenset[BodyId] = field(default=frozenset(), compare=False)  # unclear, but far from a fall; not locked

    @property
    def placings(self) -> tuple[Placing, ...]:
        """Return the events in which bricks were set down."""
        return tuple(event for event in self.events if isinstance(event, Placing))


# Friction other than the usual coefficient, to and from the form in golden files: one value per key, sorted.


RULE, OWN, PAIR, KIND = "rule", "own ", "pair ", "kind "


def rubbing_of(friction: GivenFriction) -> Mapping[str, Number | str] | None:
    """Return the entries besides the usual coefficient; None if there are none."""
    if not isinstance(friction, Friction):
        return None
    told: dict[str, Number | str] = {KIND + brick: kind for brick, kind in friction.kinds.items()}
    told |= {OWN + name: round(own, FRICTION.digits) for name, own in friction.own.items()}
    told |= {
        PAIR + "/".join(sorted(pair)): round(between, FRICTION.digits) for pair, between in friction.between.items()
    }
    return {RULE: str(friction.rule), **dict(sorted(told.items()))}


def friction_from(usual: float, entries: object) -> GivenFriction:
    """Return the friction of a scene from its entries. Raises ValueError if they are invalid."""
    if not isinstance(entries, Mapping):
        return usual
    own: dict[str, float] = {}
    between: dict[tuple[str, str], float] = {}
    kinds: dict[str, str] = {}
    for key, value in entries.items():
        if key.startswith(OWN):
            own[key.removeprefix(OWN)] = float(value)
        elif key.startswith(KIND):
            kinds[key.removeprefix(KIND)] = str(value)
        elif key.startswith(PAIR):
            one, other = key.removeprefix(PAIR).split("/")
            between[one, other] = float(value)
    return Friction(usual, own, between, kinds, Rule(entries.get(RULE, Rule.LOWER)))


# Trace -> snapshot: the observations that are relevant and clear enough to be locked.


CLEAR_CUT = 3.0  # factor beyond or below the threshold of a collapse; engines differ by up to 30 %
STANDING = frozenset(state.value for state in STAND)
UNMOVED = 1e-6  # [m] largest shift of a brick that a hit did not move, or that returned
HALF_TURN = 1e-9  # cosine of half an angle below which a turn counts as half a turn


def take(  # noqa: PLR0913, PLR0917 -- all that a snapshot says
    trace: Trace,
    world: FixedWorld,
    identity: Identity,
    stamp: Mapping[str, str],
    modelled: bool,
    actions: Sequence[Action] = (),
) -> Snapshot:
    """Return the snapshot of a run; `modelled` if positions and shares come from a model, not from a bare engine.

    The velocities of throws and the impulses of pushes come from `actions`.
    """
    states = {brick: _state(track, trace.collapse, modelled) for brick, track in trace.tracks.items()}
    # Debris is not locked: whether it leans on standing bricks can depend on rounding.
    carried = _supports(edge for edge in trace.edges if _carries(edge, trace, states))
    disturbed = any(_is_moved(track) for track in trace.tracks.values())
    return Snapshot(
        identity=identity,
        stamp=dict(sorted(stamp.items())),
        world=scene_of(world),
        verdict=trace.verdict.value,
        statics=trace.statics.stability.value if trace.statics is not None else None,
        collapse=_first_collapse(trace, modelled),
        height_mm=_height(trace.tracks, states) if modelled else None,
        levels_standing=_levels_standing(trace.tracks, states) if modelled else None,
        events=tuple(_events(trace, modelled, actions)),
        bricks={
            brick: _final(track, states[brick], None if disturbed else carried[brick])
            if _lies_still(states[brick], trace.collapse, modelled)
            else FinalBrick(track.level, states[brick], at_mm=None, rests_on=None)
            for brick, track in sorted(trace.tracks.items(), key=lambda item: (item[1].level, item[0]))
        },
        fallen=sum(track.state is BrickState.FALLEN for track in trace.tracks.values()),
        slid=frozenset(
            brick for brick, track in trace.tracks.items() if states[brick] == UNCLEAR and _only_slid(track)
        ),
    )


def _rounded(value: float, quantity: Quantity) -> Number:
    # Adding zero turns -0.0 into 0.0.
    return round(value, quantity.digits) + 0.0 if isfinite(value) else str(value)


def _in_mm(position_W: Vec3, quantity: Quantity) -> tuple[Number, ...]:
    """Return a vector in thousandths: metres in mm, metres a second in mm/s, newton seconds in mN*s."""
    return tuple(_rounded(1000.0 * value, quantity) for value in position_W)


def scene_of(world: FixedWorld) -> GoldenScene:
    """Return the fixed part of a scene."""
    return GoldenScene(
        gravity=_rounded(world.gravity, GRAVITY),
        friction=_rounded(as_friction(world.friction).usual, FRICTION),
        rubbing=rubbing_of(world.friction),
        planes={
            plane.id: FixedPlane(
                at_mm=_in_mm(plane.point_W, POSITION),
                normal=tuple(_rounded(value, NORMAL) for value in plane.normal_W),
                friction=_rounded(plane.friction, FRICTION),
            )
            for plane in world.planes
        },
    )


def _turn(pose: Pose) -> tuple[Number, ...]:
    """Return a turn as axis times angle [deg], unique for each turn."""
    x, y, z, w = pose.orientation
    # A half turn has two axes; the one whose first nonzero component is positive is used.
    leading = w if abs(w) > HALF_TURN else next((value for value in (x, y, z) if abs(value) > HALF_TURN), 1.0)
    sign = 1.0 if leading > 0.0 else -1.0
    sine = hypot(x, y, z)
    angle = degrees(2.0 * atan2(sine, sign * w))
    return tuple(_rounded(sign * value / sine * angle if sine > 0.0 else 0.0, TURN) for value in (x, y, z))


def _first_collapse(trace: Trace, modelled: bool) -> FirstCollapse | None:
    collapse, statics = trace.collapse, trace.statics
    if collapse is None:
        return None
    if not modelled:
        return FirstCollapse(collapse.level, time_s=None, gave_way=None)
    # Of several mechanisms, such as the two sides of a symmetric structure, a program finds any one.
    any_way = statics is not None and statics.stage is not Stage.TIPPING and collapse.crushing is None
    return FirstCollapse(
        collapse.level, _rounded(collapse.time, COLLAPSE_TIME), UNCLEAR if any_way else collapse.gave_way
    )


def _departure(track: BrickTrack) -> float:
    """Return how far a brick left its place, in thresholds of a collapse."""
    lost = track.shift if track.sunk is None else track.sunk
    return max(_in_limits(lost, track), track.tilt / COLLAPSE_TILT)


def _in_limits(length: float, track: BrickTrack) -> float:
    return length / (COLLAPSE_SHARE_OF_SMALLEST_SIDE * track.brick.shape.least_thickness)


def _is_moved(track: BrickTrack) -> bool:
    """Return whether a hit moved a brick; the distance is chaotic."""
    return track.sunk is not None and track.shift > UNMOVED


def _state(track: BrickTrack, collapse: Collapse | None, modelled: bool) -> str:
    """Return the state of a brick, or UNCLEAR if a small disturbance may change it."""
    if modelled and ((collapse is None and not _is_moved(track)) or track.state is BrickState.UNPLACED):
        return track.state.value
    match track.state:
        case BrickState.REMOVED | BrickState.THROWN:
            clear = True
        case BrickState.UNPLACED:
            # Within this level, which brick was still set down depends on fractions of a second.
            clear = collapse is not None and track.level > collapse.level
        case BrickState.FALLEN:
            clear = _departure(track) > CLEAR_CUT
        case BrickState.DISPLACED:
            clear = _departure(track) < 1.0 / CLEAR_CUT and _in_limits(track.shift, track) > CLEAR_CUT
        case _:
            clear = max(_departure(track), _in_limits(track.shift, track)) < 1.0 / CLEAR_CUT
    return track.state.value if clear else UNCLEAR


def unclear_falls(trace: Trace, modelled: bool) -> frozenset[BodyId]:
    """Return the bricks of which a small disturbance may change whether they fall."""
    states = {brick: _state(track, trace.collapse, modelled) for brick, track in trace.tracks.items()}
    return frozenset(
        brick for brick, state in states.items() if state == UNCLEAR and not _only_slid(trace.tracks[brick])
    )


def _only_slid(track: BrickTrack) -> bool:
    """Return whether a brick is far from a fall, so that its state is unclear only between standing and displaced."""
    return track.state in STAND and _departure(track) < 1.0 / CLEAR_CUT


def _lies_still(state: str, collapse: Collapse | None, modelled: bool) -> bool:
    """Return whether the final place of a brick can be locked; debris may shift bricks that are not held fixed."""
    return modelled and (state in STANDING if collapse is None else state == BrickState.FROZEN)


def _height(tracks: Mapping[BodyId, BrickTrack], states: Mapping[BodyId, str]) -> Number:
    """Return the highest corner of the standing bricks; UNCLEAR if an unclear brick may have it."""
    tops = {brick: top_W(track.brick.shape, track.final) for brick, track in tracks.items()}
    surely = 1000.0 * max((tops[brick] for brick, state in states.items() if state in STANDING), default=0.0)
    perhaps = 1000.0 * max((tops[brick] for brick, state in states.items() if state == UNCLEAR), default=0.0)
    return UNCLEAR if perhaps > surely + HEIGHT.tolerance else _rounded(surely, HEIGHT)


def _levels_standing(tracks: Mapping[BodyId, BrickTrack], states: Mapping[BodyId, str]) -> Number:
    levels = defaultdict[int, list[str]](list)
    for brick, track in tracks.items():
        if track.state not in NO_PART:
            levels[track.level].append(states[brick])
    surely = _unbroken(levels, STANDING)
    perhaps = _unbroken(levels, STANDING | {UNCLEAR})
    return surely if surely == perhaps else UNCLEAR


def _unbroken(levels: Mapping[int, Sequence[str]], allowed: frozenset[str]) -> int:
    """Return the number of levels, from the first on, with bricks in allowed states only."""
    return sum(1 for _ in takewhile(lambda level: allowed.issuperset(levels[level]), sorted(levels)))


def _supports(edges: Iterable[Edge]) -> defaultdict[BodyId, dict[BodyId, float]]:
    """Return the supports of each brick with their shares; contacts with one body are added up."""
    supports: defaultdict[BodyId, dict[BodyId, float]] = defaultdict(dict)
    for edge in edges:
        supports[edge.upper][edge.lower] = supports[edge.upper].get(edge.lower, 0.0) + edge.share
    return supports


def _carries(edge: Edge, trace: Trace, states: Mapping[BodyId, str]) -> bool:
    """Return whether the lower brick has certainly not fallen, so that its load can be locked."""
    if edge.lower not in trace.tracks:
        return True
    may_have_fallen = isnan(edge.share) and states[edge.lower] == UNCLEAR
    return trace.tracks[edge.lower].state is not BrickState.FALLEN and not may_have_fallen


def _shares(carried: Mapping[BodyId, float]) -> dict[BodyId, Number]:
    return {lower: UNCLEAR if isnan(share) else _rounded(share, SHARE) for lower, share in sorted(carried.items())}


def _events(trace: Trace, modelled: bool, written: Sequence[Action]) -> Iterator[Placing | Removing | Pushing]:
    """Yield placements, removals and pushes.

    On a bare engine the time of a fall varies, so placements that depend on it are omitted.
    """
    thrown = {each.brick.id: each for each in written if isinstance(each, Placement) and each.arrival is Arrival.THROWN}
    pushes = defaultdict[BodyId, deque[Vec3]](deque)
    for push in sorted((each for each in written if isinstance(each, PushAction)), key=lambda each: each.time):
        pushes[push.brick].append(push.impulse_W)
    actions = [event for event in trace.events if event.kind in ACTIONS]
    falls = trace.collapse.time if trace.collapse is not None else inf
    safe = [action for action in actions if action.time <= falls]
    # After a collapse a model describes the remaining stump and the debris, which is not locked.
    safe = safe if trace.collapse is None else safe[:-1]
    for number, event in enumerate(actions):
        told = modelled and number < len(safe)
        if event.kind is EventKind.REMOVED:
            yield Removing(_rounded(event.time, PLACING_TIME), tuple(sorted(event.bricks)))
        elif event.kind is EventKind.PUSHED:
            impulses = {
                brick: _in_mm(pushes[brick].popleft(), IMPULSE) for brick in sorted(event.bricks) if pushes[brick]
            }
            yield Pushing(_rounded(event.time, PLACING_TIME), tuple(sorted(event.bricks)), impulses or None)
        elif event.kind in (EventKind.SHAKEN, EventKind.LOADED, EventKind.TAKEN, EventKind.LET_GO, *JOINING):
            continue  # joints, loads, and the motion of the ground and of hands, are input
        elif modelled or _is_below(event, trace):
            yield Placing(
                time_s=_rounded(event.time, PLACING_TIME),
                margin_mm=_rounded(1000.0 * event.margin, MARGIN) if told and event.margin is not None else None,
                placed={brick: _placed(brick, trace, told, thrown.get(brick)) for brick in sorted(event.bricks)},
            )


def _is_below(event: Event, trace: Trace) -> bool:
    """Return whether all placed bricks belong to levels that were complete when a collapse began."""
    collapse = trace.collapse
    return collapse is None or all(trace.tracks[brick].level < collapse.level for brick in event.bricks)


def _placed(brick: BodyId, trace: Trace, told: bool, thrown: Placement | None) -> RecordedBrick:
    edges = trace.edges_when_placed.get(brick) if told else None
    track = trace.tracks[brick]
    shape = track.brick.shape
    size, centre = _around(shape)
    boxed = isinstance(shape, Box)
    return RecordedBrick(
        at_mm=_in_mm(track.placed.position_W, POSITION),
        turn_deg=_turn(track.placed),
        size_mm=_in_mm(size, SIZE),
        mass_g=_rounded(1000.0 * track.brick.mass, MASS),
        rests_on=_shares(_supports(edges)[brick]) if edges is not None else None,
        centre_of_mass_mm=None if boxed else _in_mm(centre, SIZE),
        volume_mm3=None if boxed else _rounded(1e9 * shape.volume, VOLUME),
        velocity_mm_s=None if thrown is None else _in_mm(thrown.velocity_W, VELOCITY),
    )


def _around(shape: ConvexShape) -> tuple[Vec3, Vec3]:
    """Return the sides of the bounding box of a shape along its axes, and the centre of mass from its middle."""
    if isinstance(shape, Box):
        return shape.size, (0.0, 0.0, 0.0)
    (ax, ay, az), (bx, by, bz) = bounds_W(shape, Pose((0.0, 0.0, 0.0)))
    return (bx - ax, by - ay, bz - az), (-0.5 * (ax + bx), -0.5 * (ay + by), -0.5 * (az + bz))


def _final(track: BrickTrack, state: str, carried: Mapping[BodyId, float] | None) -> FinalBrick:
    """Return a brick at rest; the place of a brick that a hit moved, and its supports, are not locked."""
    at_mm = (UNCLEAR,) * 3 if _is_moved(track) else _in_mm(track.final.position_W, POSITION)
    return FinalBrick(track.level, state, at_mm, _shares(carried) if carried is not None else None)


# Counts of samples -> snapshot, and the differences of two such snapshots.


VERDICT = "samples"  # in place of that of one run
COUNTS = ("seed", "drawn", "stood", "undecided", "unfit")
ABSENT = "none"


def snapshot_of_samples(
    ensemble: Ensemble, world: FixedWorld, identity: Identity, stamp: Mapping[str, str]
) -> Snapshot:
    """Return the snapshot of samples: their number and the counts of their outcomes."""
    fell = {str(level): count for level, count in sorted(ensemble.fell.items())}
    counts = (ensemble.seed, ensemble.drawn, ensemble.stood, fell, ensemble.undecided, ensemble.unfit)
    return Snapshot(
        identity=identity,
        stamp=dict(sorted(stamp.items())),
        world=scene_of(world),
        verdict=VERDICT,
        statics=None,
        collapse=None,
        height_mm=None,
        levels_standing=None,
        events=(),
        bricks={},
        samples=Samples(*counts),
    )


def differing_samples(expected: Mapping[str, object], got: Mapping[str, object]) -> Iterator[GoldenDifference]:
    """Yield the counts in which two documents differ."""
    was, now = _object(expected, "samples"), _object(got, "samples")
    for key in COUNTS:
        yield from _differing(key, was.get(key), now.get(key))
    before, after = _object(was, "fell"), _object(now, "fell")
    for level in sorted({*before, *after}, key=lambda level: (len(level), level)):
        yield from _differing(f"fell at level {level}", before.get(level), after.get(level))


def _differing(what: str, expected: object, got: object) -> Iterator[GoldenDifference]:
    if expected != got or isinstance(expected, bool):
        was, now = (ABSENT if value is None else str(value) for value in (expected, got))
        yield GoldenDifference("samples", what, was, now, tolerance="exact")


def _object(holder: Mapping[str, object], key: str) -> Mapping[str, object]:
    value = holder.get(key, {})
    if not isinstance(value, dict):
        raise MalformedSnapshotError(f"{key!r} is not a JSON object")
    return value


# Stamp of a snapshot: versions, whose change is only noted, and the engine, whose change limits the comparison.


STAMPED = ("stackdsl",)  # distributions, besides the engine, whose versions may change a snapshot
ENGINES = ("mujoco", "numba", "pybullet")  # distributions; numba compiles the engine of this project


def current_stamp(engine: str, steps: int) -> dict[str, str]:
    """Return the versions for the snapshot of a run in which an engine took `steps` steps.

    A run without steps was decided by statics, so no engine is named.
    """
    named = (*STAMPED, engine) if steps else STAMPED
    return {"python": f"{sys.version_info.major}.{sys.version_info.minor}"} | {
        name: found for name in named if (found := _version(name))
    }


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return ""


def made_by_other_engine(expected: object, got: object) -> bool:
    """Return whether two stamps name different engines, whose runs differ after the first step."""
    was, now = (_engines(stamp) for stamp in (expected, got))
    return bool(was and now and was != now)


def _engines(stamp: object) -> set[str]:
    return set(ENGINES) & _as_mapping(stamp).keys()


def stamp_note(expected: object, got: object) -> str:
    """Return a note on the versions that differ from those in use; empty if none does.

    A run without steps names no engine, which is no change of versions.
    """
    was, now = _as_mapping(expected), _as_mapping(got)
    both = _engines(was) and _engines(now)
    names = sorted({*was, *now} if both else {*was, *now} - {*ENGINES})
    changed = [name for name in names if was.get(name) != now.get(name)]
    made = ", ".join(f"{name} {was.get(name, 'none')} (now {now.get(name, 'none')})" for name in changed)
    return f"made with {made}" if made else ""


def _as_mapping(stamp: object) -> Mapping[str, object]:
    return stamp if isinstance(stamp, Mapping) else {}
