"""Which keys a golden file may hold: one that nobody reads, or one misspelt, would be compared with nothing."""

from collections.abc import Iterable, Mapping
from dataclasses import fields

from stackdsl.snapshots.record import (
    FinalBrick,
    FirstCollapse,
    FixedPlane,
    Identity,
    MalformedSnapshotError,
    PlacedBrick,
    Placing,
    Pushing,
    Removing,
    Samples,
    Scene,
    Snapshot,
)

WHOLE = {"format", *(field.name for field in fields(Identity)), *(field.name for field in fields(Snapshot))}


def check_keys(whole: Mapping[str, object]) -> None:
    """Raise MalformedSnapshotError if the JSON value of a golden file holds a key that no snapshot has."""
    _check("the file", whole, WHOLE - {"identity"})
    world = whole.get("world")
    _check("the world", world, _names(Scene))
    _check_each(_values(_at(world, "planes")), _names(FixedPlane))
    _check("the collapse", whole.get("collapse"), _names(FirstCollapse))
    _check("the samples", whole.get("samples"), _names(Samples))
    _check_each(_values(whole.get("bricks")), _names(FinalBrick))
    events = whole.get("events")
    for event in events if isinstance(events, list) else ():
        _check("an event", event, _names(Placing) | _names(Removing) | _names(Pushing))
        _check_each(_values(_at(event, "placed")), _names(PlacedBrick))


def _names(*kinds: type) -> set[str]:
    return {field.name for kind in kinds for field in fields(kind)}


def _at(holder: object, key: str) -> object:
    return holder.get(key) if isinstance(holder, Mapping) else None


def _values(holder: object) -> Iterable[tuple[str, object]]:
    return holder.items() if isinstance(holder, Mapping) else ()


def _check_each(entries: Iterable[tuple[str, object]], known: set[str]) -> None:
    for name, entry in entries:
        _check(repr(name), entry, known)


def _check(what: str, entry: object, known: set[str]) -> None:
    if isinstance(entry, Mapping) and not entry.keys() <= known:
        raise MalformedSnapshotError(f"{what} has an unknown key {min(entry.keys() - known)!r}")
