"""Comparison of a snapshot with a golden file: each observation outside its tolerance, by name and with its unit."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TypeAlias

from stability.name_order import in_order
from stackdsl.goldens.file_format import (
    IsValue,
    check_keys,
    document,
    is_count,
    is_excused,
    is_name_or_none,
    is_number,
    is_undecided_state,
)
from stackdsl.goldens.snapshot import (
    COLLAPSE_TIME,
    FRICTION,
    GRAVITY,
    HEIGHT,
    IMPULSE,
    MARGIN,
    MASS,
    NORMAL,
    PLACE,
    PLACING_TIME,
    POSITION,
    SHARE,
    SIZE,
    TURN,
    UNCLEAR,
    VELOCITY,
    VOLUME,
    MalformedSnapshotError,
    Quantity,
    Snapshot,
    differing_samples,
)
from stackdsl.results import FallenCounts, GoldenDifference, Unclear
from stackdsl.trace import BrickState

ABSENT = "none"
PROVEN_OR_NOT = (BrickState.FROZEN.value, BrickState.STANDING.value)  # no set: a file may contain unhashable values
NUMERICAL_NOISE = 1e-9  # of a difference of two rounded decimals, so that a tolerance includes its limit

Differences: TypeAlias = Iterator[GoldenDifference]
Object: TypeAlias = Mapping[str, object]  # of JSON


def compare(expected: Object, got: Snapshot) -> tuple[GoldenDifference, ...]:
    """Return the differences of a snapshot from the JSON value of a golden file. Raises MalformedSnapshotError."""
    return compare_documents(expected, document(got))


def compare_documents(expected: Object, got: Object, *, other_engine: bool = False) -> tuple[GoldenDifference, ...]:
    """Compare two JSON values; for different engines, only values determined by the author and by statics."""
    check_keys(expected)
    decided = (
        *_decided(expected, got),
        *_done("pulled out at", _times(expected, "removed"), _times(got, "removed")),
        *_done("pushed at", _times(expected, "pushed"), _times(got, "pushed")),
        *_impulses(expected, got),
    )
    if other_engine:
        return decided
    return (
        *decided,
        *differing_samples(expected, got),
        *_moved(expected, got),
        *_placings(_by_brick(expected), _by_brick(got)),
        *_bricks(_object(expected, "bricks"), _object(got, "bricks"), bool(_object(expected, "collapse"))),
    )


UNLOCKED = {"height_mm": "the height", "levels_standing": "the number of standing levels"}
NO_PLACE = [state.value for state in (BrickState.REMOVED, BrickState.UNPLACED, BrickState.UNWATCHED)]


def unclear_in(*documents: Object) -> Unclear:
    """Return what is unclear in at least one of the JSON values, so that it is not compared."""
    bricks = [_object(each, "bricks") for each in documents]
    names = in_order({name for each in bricks for name in each})
    states, places = [], []
    for name in names:
        entries = [_object(each, name) for each in bricks if name in each]
        seen = [entry.get("state") for entry in entries]
        if UNCLEAR in seen:
            states.append(name)
        elif any(state != seen[0] for state in seen):
            continue  # this difference is told, and two places in different states are not the same observation
        if not all(state in NO_PLACE for state in seen) and any(_is_open(entry.get("at_mm")) for entry in entries):
            places.append(name)
    others = [text for key, text in UNLOCKED.items() if any(each.get(key) == UNCLEAR for each in documents)]
    if any(_object(each, "collapse").get("gave_way") == UNCLEAR for each in documents):
        others.append("the brick that gave way")
    return Unclear(tuple(states), tuple(places), tuple(others), tuple(names))


def fallen_in(expected: Object, got: Object) -> FallenCounts:
    """Return the numbers of bricks that certainly fell, and of those whose state is unclear, in two JSON values."""
    was, now = (_object(whole, "collapse").get("time_s") for whole in (expected, got))
    shifted = is_number(was) and is_number(now) and was != now and _same(was, now, COLLAPSE_TIME)
    first = f"{_shown(was, COLLAPSE_TIME)} -> {_shown(now, COLLAPSE_TIME)}" if shifted else ""
    return FallenCounts(*_fallen(expected), *_fallen(got), first)


def _fallen(whole: Object) -> tuple[int, int]:
    bricks = _object(whole, "bricks")
    states = [_object(bricks, name).get("state") for name in bricks]
    # Without a collapse no brick fell, so a state is unclear for another reason.
    return states.count(BrickState.FALLEN), states.count(UNCLEAR) if _object(whole, "collapse") else 0


def _is_open(place: object) -> bool:
    """Return whether a place is not locked, or not in every direction."""
    return not isinstance(place, list | tuple) or UNCLEAR in place


def _decided(expected: Object, got: Object) -> Differences:
    """Yield the differences that do not depend on an engine."""
    for key in ("scenario", "variant", "system"):
        yield from _value("snapshot", key, expected.get(key), got.get(key))
    yield from _world(_object(expected, "world"), _object(got, "world"))
    yield from _value("structure", "verdict", expected.get("verdict"), got.get("verdict"))
    yield from _value("structure", "statics", expected.get("statics"), got.get("statics"))
    was, now = _object(expected, "collapse"), _object(got, "collapse")
    yield from _value("structure", "collapse level", was.get("level"), now.get("level"))


def _moved(expected: Object, got: Object) -> Differences:
    """Yield the differences of the whole structure in motion."""
    was, now = _object(expected, "collapse"), _object(got, "collapse")
    yield from _value("structure", "collapse time", was.get("time_s"), now.get("time_s"), COLLAPSE_TIME)
    yield from _value("structure", "gave way", was.get("gave_way"), now.get("gave_way"), unclear=is_name_or_none)
    heights = expected.get("height_mm"), got.get("height_mm")
    yield from _value("structure", "height", *heights, HEIGHT, unclear=is_number)
    levels = expected.get("levels_standing"), got.get("levels_standing")
    yield from _value("structure", "levels standing", *levels, unclear=is_count)


def _world(expected: Object, got: Object) -> Differences:
    yield from _value("world", "gravity", expected.get("gravity"), got.get("gravity"), GRAVITY)
    yield from _value("world", "friction", expected.get("friction"), got.get("friction"), FRICTION)
    was, now = _object(expected, "rubbing"), _object(got, "rubbing")
    for key in sorted({*was, *now}):
        yield from _value("world", f"friction, {key}", was.get(key), now.get(key), FRICTION)
    was, now = _object(expected, "planes"), _object(got, "planes")
    for plane in sorted({*was, *now}):
        if plane in was and plane in now:
            before, after = _object(was, plane), _object(now, plane)
            yield from _value(plane, "friction", before.get("friction"), after.get("friction"), FRICTION)
            yield from _vector(plane, "", (before, after), "at_mm", PLACE)
            yield from _vector(plane, " of the normal", (before, after), "normal", NORMAL)
        else:
            yield GoldenDifference(plane, "plane", *_presence(plane in was), tolerance="exact")


def _presence(before: bool) -> tuple[str, str]:
    return ("present", ABSENT) if before else (ABSENT, "present")


@dataclass(frozen=True, slots=True)
class _Placing:
    """The event in which a brick is placed."""

    number: int
    event: Object

    @property
    def time(self) -> object:
        return self.event.get("time_s")

    @property
    def shown_time(self) -> str:
        return _shown(self.time, PLACING_TIME)

    def detail(self, brick: str) -> Object:
        return _object(_object(self.event, "placed"), brick)


def _by_brick(whole: Object) -> dict[str, _Placing]:
    """Return the placing event of each brick, so that an additional event does not shift all later ones."""
    placings: dict[str, _Placing] = {}
    for number, event in enumerate(_array(whole, "events"), start=1):
        if not isinstance(event, dict):
            raise MalformedSnapshotError(f"event {number} is not a JSON object")
        bricks = sorted(_object(event, "placed"))
        if not bricks and ("removed" in event or "pushed" in event):
            continue
        if not bricks:
            raise MalformedSnapshotError(f"event {number} places no brick")
        for brick in bricks:
            if brick in placings:
                first = placings[brick].number
                raise MalformedSnapshotError(f"event {number} places {brick!r}, which event {first} placed already")
            placings[brick] = _Placing(number, event)
    return placings


def _placings(expected: Mapping[str, _Placing], got: Mapping[str, _Placing]) -> Differences:
    compared: set[tuple[int, int]] = set()  # pairs of events
    for brick in [*expected, *(brick for brick in got if brick not in expected)]:
        was, now = expected.get(brick), got.get(brick)
        if was is None or now is None:
            times = [placing.shown_time if placing is not None else ABSENT for placing in (was, now)]
            yield GoldenDifference(brick, "placed at", times[0], times[1], tolerance="exact")
            continue
        yield from _value(brick, "placed at", was.time, now.time, PLACING_TIME)
        if (was.number, now.number) not in compared:
            compared.add((was.number, now.number))
            label = f"event {was.number} ({was.shown_time})"
            yield from _value(label, "margin", was.event.get("margin_mm"), now.event.get("margin_mm"), MARGIN)
        yield from _make(brick, was.detail(brick), now.detail(brick))
        yield from _vector(brick, " when placed", (was.detail(brick), now.detail(brick)), "at_mm", PLACE)
        yield from _carriers(brick, " when placed", was.detail(brick), now.detail(brick))


def _times(whole: Object, what: str) -> dict[str, list[object]]:
    """Return the times of actions on each brick."""
    times = defaultdict[str, list[object]](list)
    for event in (event for event in _array(whole, "events") if isinstance(event, dict)):
        for brick in _array(event, what):
            times[str(brick)].append(event.get("time_s"))
    return times


def _done(what: str, expected: Mapping[str, list[object]], got: Mapping[str, list[object]]) -> Differences:
    for brick in [*expected, *(brick for brick in got if brick not in expected)]:
        for was, now in zip_longest(expected.get(brick, ()), got.get(brick, ())):
            yield from _value(brick, what, was, now, PLACING_TIME)


def _impulses(expected: Object, got: Object) -> Differences:
    """Compare the impulses of pushes; files of earlier versions have none."""
    pushes = zip(*(_pushes(whole) for whole in (expected, got)), strict=False)
    for was, now in pushes:
        for brick in was:
            yield from _vector(brick, " impulse of the push", (was, now), brick, IMPULSE)


def _pushes(whole: Object) -> list[Object]:
    return [
        _object(event, "impulses_mNs")
        for event in _array(whole, "events")
        if isinstance(event, dict) and "pushed" in event
    ]


def _bricks(expected: Object, got: Object, fell: bool) -> Differences:
    for brick in [*expected, *(brick for brick in got if brick not in expected)]:
        if brick in expected and brick in got:
            yield from _brick(brick, _object(expected, brick), _object(got, brick), fell)
        else:
            yield GoldenDifference(brick, "brick", *_presence(brick in expected), tolerance="exact")


def _brick(brick: str, expected: Object, got: Object, fell: bool) -> Differences:
    was, now = expected.get("state"), got.get("state")
    yield from _value(brick, "level", expected.get("level"), got.get("level"))
    # Whether the rest of a collapse is proven by the end depends on the time when the last piece comes to rest.
    if not (fell and was in PROVEN_OR_NOT and now in PROVEN_OR_NOT):
        yield from _value(brick, "state", was, now, unclear=is_undecided_state)
    # The final place and supports of a brick are compared only if both runs agree on its final state.
    if was == now != UNCLEAR:
        yield from _place(brick, expected, got, unclear=is_number)


def _make(brick: str, expected: Object, got: Object) -> Differences:
    """Compare the author's input for a brick except its place."""
    yield from _vector(brick, " of the turn", (expected, got), "turn_deg", TURN)
    yield from _vector(brick, " size", (expected, got), "size_mm", SIZE)
    if "volume_mm3" in {*expected, *got}:  # the size of a box determines its volume
        yield from _vector(brick, " centre of mass", (expected, got), "centre_of_mass_mm", SIZE)
        yield from _value(brick, "volume", expected.get("volume_mm3"), got.get("volume_mm3"), VOLUME)
    if "velocity_mm_s" in expected:  # files of earlier versions have none
        yield from _vector(brick, " velocity when thrown", (expected, got), "velocity_mm_s", VELOCITY)
    yield from _value(brick, "mass", expected.get("mass_g"), got.get("mass_g"), MASS)


def _place(brick: str, expected: Object, got: Object, unclear: IsValue | None = None) -> Differences:
    yield from _vector(brick, "", (expected, got), "at_mm", POSITION, unclear)
    yield from _carriers(brick, "", expected, got)


def _carriers(brick: str, when: str, expected: Object, got: Object) -> Differences:
    yield from _supports(brick, when, _object(expected, "rests_on"), _object(got, "rests_on"))


def _supports(brick: str, when: str, expected: Object, got: Object) -> Differences:
    for lower in sorted({*expected, *got}):
        if lower in expected and lower in got:
            shares = expected[lower], got[lower]
            yield from _value(brick, f"share on {lower}{when}", *shares, SHARE, unclear=is_number)
        else:
            held = f"{lower} (share {_shown(expected.get(lower, got.get(lower)), SHARE)})"
            shown = (held, ABSENT) if lower in expected else (ABSENT, held)
            yield GoldenDifference(brick, f"rests on{when}", *shown, tolerance="exact")


def _value(  # noqa: PLR0913, PLR0917 -- both sides, their names and their kind
    subject: str,
    name: str,
    expected: object,
    got: object,
    quantity: Quantity | None = None,
    unclear: IsValue | None = None,
) -> Sequence[GoldenDifference]:
    """Return the difference of two values, if any; `unclear` tests the possible values of an unclear observation."""
    if _same(expected, got, quantity) or is_excused(expected, got, unclear):
        return ()
    tolerance = f"± {quantity.tolerance:g} {quantity.unit}".rstrip() if quantity is not None else "exact"
    texts = _shown(expected, quantity), _shown(got, quantity)
    numbers = expected if is_number(expected) else None, got if is_number(got) else None
    return (GoldenDifference(subject, name, *texts, tolerance, numbers, quantity.unit if quantity is not None else ""),)


def _same(expected: object, got: object, quantity: Quantity | None) -> bool:
    if type(expected) is type(got) and expected == got:  # the usual case
        return True
    if quantity is not None and is_number(expected) and is_number(got):
        return abs(expected - got) <= quantity.tolerance + NUMERICAL_NOISE
    # JSON's `true` is not its 1, though Python's is.
    return expected == got and isinstance(expected, bool) is isinstance(got, bool)


def _shown(value: object, quantity: Quantity | None) -> str:
    if quantity is not None and is_number(value):
        return f"{value:.{quantity.digits}f} {quantity.unit}".rstrip()
    return ABSENT if value is None else str(value)


def _vector(  # noqa: PLR0913, PLR0917 -- as `_value`
    subject: str,
    what: str,
    holders: tuple[Object, Object],
    key: str,
    quantity: Quantity,
    unclear: IsValue | None = None,
) -> Differences:
    was, now = (_components(subject, key, holder) for holder in holders)
    for axis in "xyz":
        yield from _value(subject, axis + what, was.get(axis), now.get(axis), quantity, unclear)


def _components(subject: str, key: str, holder: Object) -> Mapping[str, object]:
    values = _array(holder, key)
    if len(values) not in (0, 3):
        raise MalformedSnapshotError(f"{key} of {subject} must have three numbers")
    return dict(zip("xyz", values, strict=False))


def _object(holder: Object, key: str) -> Object:
    value = holder.get(key, {})
    if not isinstance(value, dict):
        raise MalformedSnapshotError(f"{key!r} is not a JSON object")
    return value


def _array(holder: Object, key: str) -> list[object]:
    value = holder.get(key, [])
    if not isinstance(value, list):
        raise MalformedSnapshotError(f"{key!r} is not a JSON array")
    return value
