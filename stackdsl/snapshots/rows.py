"""What a document in full says of one brick, and the mark of that: for files that hold very many bricks in short."""

from base64 import b64encode
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from hashlib import sha256
from typing import Final, TypeAlias

from stackdsl.snapshots.canonical import ENCODER
from stackdsl.snapshots.record import POSITION, MalformedSnapshotError
from stackdsl.snapshots.unclear import is_number

MARK: Final = 3  # [characters of six bits] of a brick; another one has the same by one chance in 260,000
ALIKE: Final = 0.2  # of a tolerance: what numbers that are written as one may differ by

Object: TypeAlias = Mapping[str, object]  # of JSON


class Row:
    """All that a document in full says of one brick."""

    def __init__(self, name: str, final: Object, event: Object | None) -> None:
        self.name, self.final, self.event = name, final, event
        self.placed = object_at(object_at(event or {}, "placed"), name)

    @property
    def is_ordinary(self) -> bool:
        """Whether it was placed, and either ended there or its end is not locked."""
        return bool(self.placed) and (self.end is None or are_alike(self.end, self.placed["at_mm"], POSITION.tolerance))

    @property
    def end(self) -> object:
        return self.final.get("at_mm")

    @cached_property
    def digest(self) -> bytes:
        """A hash of what has no tolerance."""
        made = [self.placed.get(key) for key in ("at_mm", "turn_deg", "size_mm", "mass_g")]
        carriers = [sorted(object_at(each, "rests_on")) for each in (self.placed, self.final)]
        decided = [self.name, (self.event or {}).get("time_s"), *made, self.final.get("level"), *carriers]
        return sha256(ENCODER.encode(decided).encode()).digest()

    @property
    def mark(self) -> str:
        """The beginning of it."""
        return b64encode(self.digest, b"-_")[:MARK].decode()


def rows_of(full: Object) -> dict[str, Row]:
    """All bricks of a document in full."""
    placings = [event for event in array_at(full, "events") if isinstance(event, dict)]
    events = {name: event for event in placings for name in object_at(event, "placed")}
    bricks = object_at(full, "bricks")
    return {name: Row(name, object_at(bricks, name), events.get(name)) for name in bricks}


def events_with(full: Object, wanted: Callable[[str], bool]) -> Iterator[Object]:
    """The events, with the placings of some bricks only."""
    for event in array_at(full, "events"):
        placed = object_at(event, "placed") if isinstance(event, Mapping) else {}
        kept = {name: detail for name, detail in placed.items() if wanted(name)}
        if isinstance(event, Mapping) and (kept or not placed):
            yield {**event, "placed": kept} if placed else event


def are_alike(one: object, other: object, tolerance: float) -> bool:
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(are_alike(*pair, tolerance) for pair in zip(one, other, strict=True))
    if is_number(one) and is_number(other):
        return abs(one - other) <= ALIKE * tolerance
    return type(one) is type(other) and one == other


def object_at(holder: object, key: str) -> Object:
    value = holder.get(key, {}) if isinstance(holder, Mapping) else {}
    if not isinstance(value, Mapping):
        raise MalformedSnapshotError(f"{key!r} is not an object")
    return value


def array_at(holder: object, key: str) -> list[object]:
    value = holder.get(key, []) if isinstance(holder, Mapping) else []
    if not isinstance(value, list):
        raise MalformedSnapshotError(f"{key!r} is not an array")
    return value
