"""Trace -> snapshot: of all that happened, what is worth locking and clear enough to be locked."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import takewhile
from math import atan2, degrees, hypot, inf, isfinite, isnan

from stability.friction_law import law_of
from stability.model import BodyId, ConvexShape, Pose, Vec3
from stability.shapes.box import Box
from stability.shapes.in_pose import top_W
from stability.statics.facts import Stage
from stackdsl.snapshots.record import (
    COLLAPSE_TIME,
    FRICTION,
    GRAVITY,
    HEIGHT,
    MARGIN,
    MASS,
    NORMAL,
    PLACING_TIME,
    POSITION,
    SHARE,
    SIZE,
    TURN,
    UNCLEAR,
    VOLUME,
    FinalBrick,
    FirstCollapse,
    FixedPlane,
    Identity,
    Number,
    PlacedBrick,
    Placing,
    Pushing,
    Quantity,
    Removing,
    Scene,
    Snapshot,
)
from stackdsl.snapshots.rubbing import rubbing_of
from stackdsl.timeline import World
from stackdsl.trace import (
    ACTIONS,
    COLLAPSE_SHARE_OF_SMALLEST_SIDE,
    COLLAPSE_TILT,
    NO_PART,
    STAND,
    BrickState,
    BrickTrack,
    Collapse,
    Edge,
    Event,
    EventKind,
    Trace,
)

CLEAR_CUT = 3.0  # times beyond, or below, the threshold of a collapse; other engines lie within 30 % of each other
STANDING = frozenset(state.value for state in STAND)
UNMOVED = 1e-6  # [m] of one that a hit did not reach, or that went back to where it was
HALF_TURN = 1e-9  # cosine of half an angle below which a turn counts as half a turn


def take(trace: Trace, world: World, identity: Identity, stamp: Mapping[str, str], modelled: bool) -> Snapshot:
    """The snapshot of a run; `modelled` where positions and shares come from a model, not from a bare engine."""
    states = {brick: _state(track, trace.collapse, modelled) for brick, track in trace.tracks.items()}
    # What has fallen may lean on what stands, or not, by a hair: where debris comes to lie is not locked.
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
        events=tuple(_events(trace, modelled)),
        bricks={
            brick: _final(track, states[brick], None if disturbed else carried[brick])
            if _lies_still(states[brick], trace.collapse, modelled)
            else FinalBrick(track.level, states[brick], at_mm=None, rests_on=None)
            for brick, track in sorted(trace.tracks.items(), key=lambda item: (item[1].level, item[0]))
        },
    )


def _rounded(value: float, quantity: Quantity) -> Number:
    # Adding zero turns -0.0 into 0.0.
    return round(value, quantity.digits) + 0.0 if isfinite(value) else str(value)


def _in_mm(position_W: Vec3, quantity: Quantity) -> tuple[Number, ...]:
    return tuple(_rounded(1000.0 * value, quantity) for value in position_W)


def scene_of(world: World) -> Scene:
    """What does not move."""
    return Scene(
        gravity=_rounded(world.gravity, GRAVITY),
        friction=_rounded(law_of(world.friction).usual, FRICTION),
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
    """The turn of a body as axis times angle [deg], the same for the same turn."""
    x, y, z, w = pose.orientation
    # Half a turn one way is half a turn the other way: then the first component that counts is positive.
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
    # Of several ways to fall, as the two sides of what is symmetric, a program finds any one.
    any_way = statics is not None and statics.stage is not Stage.TIPPING
    return FirstCollapse(
        collapse.level, _rounded(collapse.time, COLLAPSE_TIME), UNCLEAR if any_way else collapse.gave_way
    )


def _departure(track: BrickTrack) -> float:
    """How far a brick left its place, in thresholds of a collapse."""
    lost = track.shift if track.sunk is None else track.sunk
    return max(_in_limits(lost, track), track.tilt / COLLAPSE_TILT)


def _in_limits(length: float, track: BrickTrack) -> float:
    return length / (COLLAPSE_SHARE_OF_SMALLEST_SIDE * track.brick.shape.least_thickness)


def _is_moved(track: BrickTrack) -> bool:
    """Whether a hit moved it: by how much is chaotic."""
    return track.sunk is not None and track.shift > UNMOVED


def _state(track: BrickTrack, collapse: Collapse | None, modelled: bool) -> str:
    """The state of a brick where a small disturbance does not change it, else UNCLEAR."""
    if modelled and ((collapse is None and not _is_moved(track)) or track.state is BrickState.UNPLACED):
        return track.state.value
    match track.state:
        case BrickState.REMOVED | BrickState.THROWN:
            clear = True
        case BrickState.UNPLACED:
            # Within the level itself it is a matter of moments which brick was still set down.
            clear = collapse is not None and track.level > collapse.level
        case BrickState.FALLEN:
            clear = _departure(track) > CLEAR_CUT
        case BrickState.DISPLACED:
            clear = _departure(track) < 1.0 / CLEAR_CUT and _in_limits(track.shift, track) > CLEAR_CUT
        case _:
            clear = max(_departure(track), _in_limits(track.shift, track)) < 1.0 / CLEAR_CUT
    return track.state.value if clear else UNCLEAR


def _lies_still(state: str, collapse: Collapse | None, modelled: bool) -> bool:
    """Whether the final place of a brick can be locked: debris may nudge whatever is not held fixed."""
    return modelled and (state in STANDING if collapse is None else state == BrickState.FROZEN)


def _height(tracks: Mapping[BodyId, BrickTrack], states: Mapping[BodyId, str]) -> Number:
    """The highest corner of what stands; UNCLEAR if it hangs on a brick that is."""
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
    """How many levels, from the first on, hold nothing but bricks in an allowed state."""
    return sum(1 for _ in takewhile(lambda level: allowed.issuperset(levels[level]), sorted(levels)))


def _supports(edges: Iterable[Edge]) -> defaultdict[BodyId, dict[BodyId, float]]:
    """Who carries each brick, and which share; two contacts with one body count together."""
    supports: defaultdict[BodyId, dict[BodyId, float]] = defaultdict(dict)
    for edge in edges:
        supports[edge.upper][edge.lower] = supports[edge.upper].get(edge.lower, 0.0) + edge.share
    return supports


def _carries(edge: Edge, trace: Trace, states: Mapping[BodyId, str]) -> bool:
    """Whether the lower brick has not fallen, nor may have where nobody can tell what it carries."""
    if edge.lower not in trace.tracks:
        return True
    may_have_fallen = isnan(edge.share) and states[edge.lower] == UNCLEAR
    return trace.tracks[edge.lower].state is not BrickState.FALLEN and not may_have_fallen


def _shares(carried: Mapping[BodyId, float]) -> dict[BodyId, Number]:
    return {lower: UNCLEAR if isnan(share) else _rounded(share, SHARE) for lower, share in sorted(carried.items())}


def _events(trace: Trace, modelled: bool) -> Iterator[Placing | Removing | Pushing]:
    """Placings, save those that a bare engine's luck in when it falls may take away, removals and pushes."""
    actions = [event for event in trace.events if event.kind in ACTIONS]
    falls = trace.collapse.time if trace.collapse is not None else inf
    safe = [action for action in actions if action.time <= falls]
    # What a model says of the placing that brought the stack down, it says of the stump and the debris.
    safe = safe if trace.collapse is None else safe[:-1]
    for number, event in enumerate(actions):
        told = modelled and number < len(safe)
        if event.kind is EventKind.REMOVED:
            yield Removing(_rounded(event.time, PLACING_TIME), tuple(sorted(event.bricks)))
        elif event.kind is EventKind.PUSHED:
            yield Pushing(_rounded(event.time, PLACING_TIME), tuple(sorted(event.bricks)))
        elif event.kind in (EventKind.SHAKEN, EventKind.TAKEN, EventKind.LET_GO):
            continue  # the scenario says how the ground and hands move
        elif modelled or _is_below(event, trace):
            yield Placing(
                time_s=_rounded(event.time, PLACING_TIME),
                margin_mm=_rounded(1000.0 * event.margin, MARGIN) if told and event.margin is not None else None,
                placed={brick: _placed(brick, trace, told) for brick in sorted(event.bricks)},
            )


def _is_below(event: Event, trace: Trace) -> bool:
    """Whether all that was placed belongs to levels that were complete when the collapse began, if one did."""
    collapse = trace.collapse
    return collapse is None or all(trace.tracks[brick].level < collapse.level for brick in event.bricks)


def _placed(brick: BodyId, trace: Trace, told: bool) -> PlacedBrick:
    edges = trace.edges_when_placed.get(brick) if told else None
    track = trace.tracks[brick]
    shape = track.brick.shape
    size, centre = _around(shape)
    boxed = isinstance(shape, Box)
    return PlacedBrick(
        at_mm=_in_mm(track.placed.position_W, POSITION),
        turn_deg=_turn(track.placed),
        size_mm=_in_mm(size, SIZE),
        mass_g=_rounded(1000.0 * track.brick.mass, MASS),
        rests_on=_shares(_supports(edges)[brick]) if edges is not None else None,
        centre_of_mass_mm=None if boxed else _in_mm(centre, SIZE),
        volume_mm3=None if boxed else _rounded(1e9 * shape.volume, VOLUME),
    )


def _around(shape: ConvexShape) -> tuple[Vec3, Vec3]:
    """The sides of the box around a shape, along its own axes, and its centre of mass seen from the middle of that."""
    if isinstance(shape, Box):
        return shape.size, (0.0, 0.0, 0.0)
    lows, highs = zip(*((min(along), max(along)) for along in zip(*shape.corners, strict=True)), strict=True)
    (ax, ay, az), (bx, by, bz) = lows, highs
    return (bx - ax, by - ay, bz - az), (-0.5 * (ax + bx), -0.5 * (ay + by), -0.5 * (az + bz))


def _final(track: BrickTrack, state: str, carried: Mapping[BodyId, float] | None) -> FinalBrick:
    """One that stands still; where those are that a hit has moved, and who carries whom then, is not locked."""
    at_mm = (UNCLEAR,) * 3 if _is_moved(track) else _in_mm(track.final.position_W, POSITION)
    return FinalBrick(track.level, state, at_mm, _shares(carried) if carried is not None else None)
