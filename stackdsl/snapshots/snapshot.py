"""What a golden file locks of a run, and its canonical text.

Facts that a person can read, and that a small disturbance does not change: a collapse is chaotic once it is under way,
and a bare engine creeps. What is not clear-cut is written as `unclear`, which compares equal to anything, or left out.
"""

import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from itertools import takewhile
from math import isfinite
from typing import TYPE_CHECKING, TypeAlias

from stability.geometry import box_corners
from stability.model import BodyId, Pose
from stackdsl.trace import (
    COLLAPSE_SHARE_OF_SMALLEST_SIDE,
    COLLAPSE_TILT,
    BrickState,
    BrickTrack,
    Collapse,
    Edge,
    Event,
    EventKind,
    Trace,
)

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

FORMAT = 1  # of the file; raise it whenever an older file can no longer be compared
UNCLEAR = "unclear"  # too close to call; equal to anything
CLEAR_CUT = 3.0  # times beyond, or below, the threshold of a collapse; other engines lie within 30 % of each other
STANDING = frozenset({BrickState.FROZEN.value, BrickState.STANDING.value})

Number: TypeAlias = float | str  # text where a number is unclear or not finite: JSON has no infinity


@dataclass(frozen=True, slots=True)
class Quantity:
    """A kind of number: how it is written, and how far it may move until it counts as different."""

    unit: str
    digits: int  # decimals written; at least ten times finer than the tolerance, so rounding never decides
    tolerance: float  # in `unit`


POSITION = Quantity("mm", 2, 0.5)  # the gap that still counts as touching, half the moulding tolerance of a brick
HEIGHT = Quantity("mm", 2, 0.5)  # as POSITION: it is the top of one brick
MARGIN = Quantity("mm", 2, 0.2)  # finer than POSITION: contact corners, which it is made of, agree within 0.1 mm
SHARE = Quantity("", 3, 0.02)  # what 0.5 mm does on a lever of 24 mm, a plank's width
COLLAPSE_TIME = Quantity("s", 3, 0.05)  # solvers differ by up to 0.02 s in when a tower has visibly begun to fall
PLACING_TIME = Quantity("s", 3, 0.005)  # one step of the coarsest engine, 1/240 s


@dataclass(frozen=True, slots=True)
class Identity:
    """Which run it is."""

    scenario: str
    variant: str  # such as `step=10mm,thesis`
    system: str


@dataclass(frozen=True, slots=True)
class FirstCollapse:
    """The collapse; what is None is not locked."""

    level: int
    time_s: Number | None
    gave_way: BodyId | None


@dataclass(frozen=True, slots=True)
class PlacedBrick:
    """Where a brick was set down, and who carried it once it had been judged."""

    at_mm: tuple[Number, ...]  # centre in W
    rests_on: Mapping[BodyId, Number] | None  # shares; None where no model tells


@dataclass(frozen=True, slots=True)
class Placing:
    """Bricks set down at one time."""

    time_s: Number
    margin_mm: Number | None  # least tipping margin of the stack afterwards; None where no model tells
    placed: Mapping[BodyId, PlacedBrick]


@dataclass(frozen=True, slots=True)
class FinalBrick:
    """How a brick ended; what is None is not locked."""

    level: int
    state: str  # a BrickState, or UNCLEAR
    at_mm: tuple[Number, ...] | None
    rests_on: Mapping[BodyId, Number] | None


@dataclass(frozen=True, slots=True)
class Snapshot:
    """All that is locked of one run; what is None is not locked."""

    identity: Identity
    stamp: Mapping[str, str]  # versions of what made it
    verdict: str
    collapse: FirstCollapse | None
    height_mm: Number | None  # of what stands
    levels_standing: Number | None  # counted from the first, as long as every brick of a level stands
    events: tuple[Placing, ...]
    bricks: Mapping[BodyId, FinalBrick]  # by level, then name


def take(trace: Trace, identity: Identity, stamp: Mapping[str, str], proven: bool) -> Snapshot:
    """The snapshot of a run; `proven` where positions and shares come from a model, not from a bare engine."""
    states = {brick: _state(track, trace.collapse, proven) for brick, track in trace.tracks.items()}
    carried = _supports(trace.edges)
    return Snapshot(
        identity=identity,
        stamp=dict(sorted(stamp.items())),
        verdict="stands" if trace.collapse is None else "collapses",
        collapse=_first_collapse(trace.collapse, proven),
        height_mm=_height(trace.tracks, states) if proven else None,
        levels_standing=_levels_standing(trace.tracks, states) if proven else None,
        events=tuple(_placings(trace, proven)),
        bricks={
            brick: _final(track, states[brick], carried[brick], _lies_still(states[brick], trace.collapse, proven))
            for brick, track in sorted(trace.tracks.items(), key=lambda item: (item[1].level, item[0]))
        },
    )


def _rounded(value: float, quantity: Quantity) -> Number:
    # Adding zero turns -0.0 into 0.0.
    return round(value, quantity.digits) + 0.0 if isfinite(value) else str(value)


def _in_mm(pose: Pose) -> tuple[Number, ...]:
    return tuple(_rounded(1000.0 * value, POSITION) for value in pose.position_W)


def _first_collapse(collapse: Collapse | None, proven: bool) -> FirstCollapse | None:
    if collapse is None:
        return None
    if not proven:
        return FirstCollapse(collapse.level, time_s=None, gave_way=None)
    return FirstCollapse(collapse.level, _rounded(collapse.time, COLLAPSE_TIME), collapse.gave_way)


def _departure(track: BrickTrack) -> float:
    """How far a brick left its place, in thresholds of a collapse."""
    shift_limit = COLLAPSE_SHARE_OF_SMALLEST_SIDE * min(track.brick.size)
    return max(track.shift / shift_limit, track.tilt / COLLAPSE_TILT)


def _state(track: BrickTrack, collapse: Collapse | None, proven: bool) -> str:
    """The state of a brick where a small disturbance does not change it, else UNCLEAR."""
    if proven and (collapse is None or track.state is BrickState.UNPLACED):
        return track.state.value
    match track.state:
        case BrickState.UNPLACED:
            # Within the level itself it is a matter of moments which brick was still set down.
            clear = collapse is not None and track.level > collapse.level
        case BrickState.FALLEN:
            clear = _departure(track) > CLEAR_CUT
        case _:
            clear = _departure(track) < 1.0 / CLEAR_CUT
    return track.state.value if clear else UNCLEAR


def _lies_still(state: str, collapse: Collapse | None, proven: bool) -> bool:
    """Whether the final place of a brick can be locked: debris may nudge whatever is not held fixed."""
    return proven and (state in STANDING if collapse is None else state == BrickState.FROZEN)


def _height(tracks: Mapping[BodyId, BrickTrack], states: Mapping[BodyId, str]) -> Number:
    """The highest corner of what stands; UNCLEAR if it hangs on a brick that is."""
    tops = {brick: max(corner[2] for corner in box_corners(t.brick.size, t.final)) for brick, t in tracks.items()}
    surely = 1000.0 * max((tops[brick] for brick, state in states.items() if state in STANDING), default=0.0)
    perhaps = 1000.0 * max((tops[brick] for brick, state in states.items() if state == UNCLEAR), default=0.0)
    return UNCLEAR if perhaps > surely + HEIGHT.tolerance else _rounded(surely, HEIGHT)


def _levels_standing(tracks: Mapping[BodyId, BrickTrack], states: Mapping[BodyId, str]) -> Number:
    levels = defaultdict[int, list[str]](list)
    for brick, track in tracks.items():
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


def _shares(carried: Mapping[BodyId, float]) -> dict[BodyId, Number]:
    return {lower: _rounded(share, SHARE) for lower, share in sorted(carried.items())}


def _placings(trace: Trace, proven: bool) -> Iterator[Placing]:
    """The placings, save those that a bare engine's luck in when it falls may take away."""
    placings = [event for event in trace.events if event.kind is EventKind.PLACED]
    for event in placings:
        # What a model says of the placing that brought the stack down, it says of the stump and the debris.
        told = proven and (trace.collapse is None or event is not placings[-1])
        if proven or _is_below(event, trace):
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
    return PlacedBrick(
        at_mm=_in_mm(trace.tracks[brick].placed),
        rests_on=_shares(_supports(edges)[brick]) if edges is not None else None,
    )


def _final(track: BrickTrack, state: str, carried: Mapping[BodyId, float], lies_still: bool) -> FinalBrick:
    return FinalBrick(
        level=track.level,
        state=state,
        at_mm=_in_mm(track.final) if lies_still else None,
        rests_on=_shares(carried) if lies_still else None,
    )


def document(snapshot: Snapshot) -> dict[str, object]:
    """The snapshot as plain JSON values; what is not locked is left out."""
    return {"format": FORMAT, **_plain(snapshot.identity), **_plain(snapshot, without=("identity",))}


def _plain(record: "DataclassInstance", without: Sequence[str] = ()) -> dict[str, object]:
    named = ((field.name, getattr(record, field.name)) for field in fields(record) if field.name not in without)
    return {name: _plain_value(value) for name, value in named if value is not None}


def _plain_value(value: object) -> object:
    if isinstance(value, Mapping):
        return {key: _plain_value(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [_plain_value(item) for item in value]
    return _plain(value) if is_dataclass(value) and not isinstance(value, type) else value


def canonical_text(snapshot: Snapshot) -> str:
    """The text of a golden file: one line a brick and an event so that a diff reads well; ASCII."""
    head = document(snapshot)
    del head["events"], head["bricks"]
    lines = [f"  {_json(key)}: {_json(value)}" for key, value in head.items()]
    events = [_event_text(placing) for placing in snapshot.events]
    bricks = [f"    {_json(brick)}: {_json(_plain(final))}" for brick, final in snapshot.bricks.items()]
    lines.append('  "events": ' + _block("[]", events, "  "))
    lines.append('  "bricks": ' + _block("{}", bricks, "  "))
    return _block("{}", lines, "") + "\n"


def _event_text(placing: Placing) -> str:
    head = {key: value for key, value in _plain(placing).items() if key != "placed"}
    bricks = [f"      {_json(brick)}: {_json(_plain(placed))}" for brick, placed in placing.placed.items()]
    return f'    {_json(head)[:-1]}, "placed": ' + _block("{}", bricks, "    ") + "}"


def _block(brackets: str, lines: Sequence[str], indent: str) -> str:
    return f"{brackets[0]}\n" + ",\n".join(lines) + f"\n{indent}{brackets[1]}" if lines else brackets


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=True, allow_nan=False)
