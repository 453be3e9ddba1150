"""Snapshot -> JSON values, and the one text that a golden file may have."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from typing import TYPE_CHECKING

from stackdsl.snapshots.record import FORMAT, Snapshot

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


SCALARS = (str, float, int)
ENCODER = json.JSONEncoder(ensure_ascii=True, allow_nan=False)  # once, for it is called for every brick


def document(snapshot: Snapshot) -> dict[str, object]:
    """The snapshot as plain JSON values; what is not locked is left out."""
    return {"format": FORMAT, **_plain(snapshot.identity), **_plain(snapshot, without=("identity",))}


def _plain(record: "DataclassInstance", without: Sequence[str] = ()) -> dict[str, object]:
    named = [(name, getattr(record, name)) for name in _names(type(record)) if name not in without]
    return {name: _plain_value(value) for name, value in named if value is not None}


@cache
def _names(kind: "type[DataclassInstance]") -> tuple[str, ...]:
    return tuple(field.name for field in fields(kind))


def _plain_value(value: object) -> object:
    if isinstance(value, SCALARS):
        return value
    if isinstance(value, tuple):
        return [_plain_value(item) for item in value]
    if isinstance(value, Mapping):
        return {key: _plain_value(item) for key, item in value.items()}
    return _plain(value) if is_dataclass(value) and not isinstance(value, type) else value


def canonical_text(snapshot: Snapshot) -> str:
    """The text of a golden file: one line a brick and an event so that a diff reads well; ASCII."""
    rest = _plain(snapshot, without=("identity", "events", "bricks"))
    head = {"format": FORMAT, **_plain(snapshot.identity), **rest}
    lines = [f"  {_json(key)}: {_json(value)}" for key, value in head.items()]
    events = [event_text(_plain(event)) for event in snapshot.events]
    bricks = [f"    {_json(brick)}: {_json(_plain(final))}" for brick, final in snapshot.bricks.items()]
    lines.append('  "events": ' + block("[]", events, "  "))
    lines.append('  "bricks": ' + block("{}", bricks, "  "))
    return block("{}", lines, "") + "\n"


def event_text(event: Mapping[str, object]) -> str:
    """An event of a document, with a line for each brick that it places."""
    if not isinstance(placed := event.get("placed"), Mapping):
        return f"    {_json(event)}"
    head = {key: value for key, value in event.items() if key != "placed"}
    bricks = [f"      {_json(brick)}: {_json(detail)}" for brick, detail in placed.items()]
    return f'    {_json(head)[:-1]}, "placed": ' + block("{}", bricks, "    ") + "}"


def block(brackets: str, lines: Sequence[str], indent: str) -> str:
    """Lines within brackets, or brackets alone."""
    return f"{brackets[0]}\n" + ",\n".join(lines) + f"\n{indent}{brackets[1]}" if lines else brackets


def _json(value: object) -> str:
    return ENCODER.encode(value)
