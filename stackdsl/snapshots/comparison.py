"""A snapshot against what a golden file holds: every observation that left its tolerance, by name and with its unit."""

from collections.abc import Iterator, Mapping
from typing import TypeAlias, TypeGuard

from stackdsl.outcome import GoldenDifference
from stackdsl.snapshots.snapshot import (
    COLLAPSE_TIME,
    HEIGHT,
    MARGIN,
    PLACING_TIME,
    POSITION,
    SHARE,
    UNCLEAR,
    Quantity,
    Snapshot,
    document,
)

ABSENT = "none"
NUMERICAL_NOISE = 1e-9  # of a difference of two rounded decimals, so that a tolerance includes its limit
LARGEST = 1e300  # of a number that is compared as one

Differences: TypeAlias = Iterator[GoldenDifference]
Object: TypeAlias = Mapping[str, object]  # of JSON


class MalformedSnapshotError(ValueError):
    """A golden file holds JSON, yet no snapshot; the message says where."""


def compare(expected: Object, got: Snapshot) -> tuple[GoldenDifference, ...]:
    """The differences of a snapshot from the JSON value of a golden file. Raises MalformedSnapshotError."""
    return compare_documents(expected, document(got))


def compare_documents(expected: Object, got: Object) -> tuple[GoldenDifference, ...]:
    """The same for two JSON values."""
    return (
        *_structure(expected, got),
        *_events(_by_bricks(expected), _by_bricks(got)),
        *_bricks(_object(expected, "bricks"), _object(got, "bricks")),
    )


def _structure(expected: Object, got: Object) -> Differences:
    for key in ("scenario", "variant", "system"):
        yield from _value("snapshot", key, expected.get(key), got.get(key))
    yield from _value("structure", "verdict", expected.get("verdict"), got.get("verdict"))
    was, now = _object(expected, "collapse"), _object(got, "collapse")
    yield from _value("structure", "collapse level", was.get("level"), now.get("level"))
    yield from _value("structure", "collapse time", was.get("time_s"), now.get("time_s"), COLLAPSE_TIME)
    yield from _value("structure", "gave way", was.get("gave_way"), now.get("gave_way"))
    yield from _value("structure", "height", expected.get("height_mm"), got.get("height_mm"), HEIGHT)
    yield from _value("structure", "levels standing", expected.get("levels_standing"), got.get("levels_standing"))


def _by_bricks(whole: Object) -> dict[tuple[str, ...], tuple[str, Object]]:
    """Events by the bricks placed, so that one more event does not shift all later ones; each with its label."""
    events: dict[tuple[str, ...], tuple[str, Object]] = {}
    for number, event in enumerate(_array(whole, "events"), start=1):
        if not isinstance(event, Mapping):
            raise MalformedSnapshotError(f"event {number} is not an object")
        bricks = tuple(sorted(_object(event, "placed")))
        if bricks in events:
            raise MalformedSnapshotError(f"event {number} places the bricks of an earlier one again")
        events[bricks] = (f"event {number} ({_shown(event.get('time_s'), PLACING_TIME)})", event)
    return events


def _events(
    expected: Mapping[tuple[str, ...], tuple[str, Object]], got: Mapping[tuple[str, ...], tuple[str, Object]]
) -> Differences:
    for bricks in [*expected, *(bricks for bricks in got if bricks not in expected)]:
        label, _ = expected.get(bricks) or got[bricks]
        if bricks in expected and bricks in got:
            yield from _event(label, expected[bricks][1], got[bricks][1])
        else:
            names = ", ".join(bricks)
            shown = (names, ABSENT) if bricks in expected else (ABSENT, names)
            yield GoldenDifference(label, "placed", *shown, tolerance="exact")


def _event(label: str, expected: Object, got: Object) -> Differences:
    yield from _value(label, "time", expected.get("time_s"), got.get("time_s"), PLACING_TIME)
    yield from _value(label, "margin", expected.get("margin_mm"), got.get("margin_mm"), MARGIN)
    was, now = _object(expected, "placed"), _object(got, "placed")
    for brick in sorted(was):
        yield from _place(brick, " when placed", _object(was, brick), _object(now, brick))


def _bricks(expected: Object, got: Object) -> Differences:
    for brick in [*expected, *(brick for brick in got if brick not in expected)]:
        if brick in expected and brick in got:
            yield from _brick(brick, _object(expected, brick), _object(got, brick))
        else:
            shown = ("present", ABSENT) if brick in expected else (ABSENT, "present")
            yield GoldenDifference(brick, "brick", *shown, tolerance="exact")


def _brick(brick: str, expected: Object, got: Object) -> Differences:
    was, now = expected.get("state"), got.get("state")
    yield from _value(brick, "level", expected.get("level"), got.get("level"))
    yield from _value(brick, "state", was, now)
    # Where and on what a brick ended says something new only if both runs agree on how it ended.
    if was == now != UNCLEAR:
        yield from _place(brick, "", expected, got)


def _place(brick: str, when: str, expected: Object, got: Object) -> Differences:
    was, now = _position(brick, expected), _position(brick, got)
    for axis in "xyz":
        yield from _value(brick, axis + when, was.get(axis), now.get(axis), POSITION)
    yield from _supports(brick, when, _object(expected, "rests_on"), _object(got, "rests_on"))


def _supports(brick: str, when: str, expected: Object, got: Object) -> Differences:
    for lower in sorted({*expected, *got}):
        if lower in expected and lower in got:
            yield from _value(brick, f"share on {lower}{when}", expected[lower], got[lower], SHARE)
        else:
            held = f"{lower} (share {_shown(expected.get(lower, got.get(lower)), SHARE)})"
            shown = (held, ABSENT) if lower in expected else (ABSENT, held)
            yield GoldenDifference(brick, f"rests on{when}", *shown, tolerance="exact")


def _value(subject: str, name: str, expected: object, got: object, quantity: Quantity | None = None) -> Differences:
    if not _same(expected, got, quantity):
        tolerance = f"± {quantity.tolerance:g} {quantity.unit}".rstrip() if quantity is not None else "exact"
        yield GoldenDifference(subject, name, _shown(expected, quantity), _shown(got, quantity), tolerance)


def _same(expected: object, got: object, quantity: Quantity | None) -> bool:
    if UNCLEAR in (expected, got):
        return True
    if quantity is not None and _is_number(expected) and _is_number(got):
        return abs(expected - got) <= quantity.tolerance + NUMERICAL_NOISE
    # JSON's `true` is not its 1, though Python's is.
    return expected == got and isinstance(expected, bool) is isinstance(got, bool)


def _is_number(value: object) -> TypeGuard[float]:
    # The bound keeps out NaN, infinities, and integers too large to become floats.
    return isinstance(value, int | float) and not isinstance(value, bool) and -LARGEST < value < LARGEST


def _shown(value: object, quantity: Quantity | None) -> str:
    if value is None:
        return ABSENT
    if quantity is not None and _is_number(value):
        return f"{value:.{quantity.digits}f} {quantity.unit}".rstrip()
    return str(value)


def _position(brick: str, holder: Object) -> Mapping[str, object]:
    values = _array(holder, "at_mm")
    if len(values) not in (0, 3):
        raise MalformedSnapshotError(f"at_mm of {brick} is not three numbers")
    return dict(zip("xyz", values, strict=False))


def _object(holder: Object, key: str) -> Object:
    value = holder.get(key, {})
    if not isinstance(value, Mapping):
        raise MalformedSnapshotError(f"{key!r} is not an object")
    return value


def _array(holder: Object, key: str) -> list[object]:
    value = holder.get(key, [])
    if not isinstance(value, list):
        raise MalformedSnapshotError(f"{key!r} is not an array")
    return value
