"""Snapshot -> JSON values, and the one text that a golden file may have."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING

from stackdsl.snapshots.record import FORMAT, Placing, Snapshot

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


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
