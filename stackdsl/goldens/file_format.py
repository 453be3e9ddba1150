"""The format and names of golden files: snapshot <-> JSON, canonical text, allowed keys."""

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias, TypeGuard

from stackdsl.goldens.snapshot import (
    FORMAT,
    UNCLEAR,
    FinalBrick,
    FirstCollapse,
    FixedPlane,
    GoldenScene,
    Identity,
    MalformedSnapshotError,
    Placing,
    Pushing,
    RecordedBrick,
    Removing,
    Samples,
    Snapshot,
)
from stackdsl.trace import NO_PART, BrickState

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


# Snapshot -> JSON values, and the canonical text of a golden file.


SCALARS = (str, float, int)
ENCODER = json.JSONEncoder(ensure_ascii=True, allow_nan=False)  # made once, as it is used for every brick


def document(snapshot: Snapshot) -> dict[str, object]:
    """Return a snapshot as plain JSON values, without fields that are not locked."""
    return {"format": FORMAT, **_plain(snapshot.identity), **_plain(snapshot, without=("identity",))}


def _plain(record: "DataclassInstance", without: Sequence[str] = ()) -> dict[str, object]:
    named = [(name, getattr(record, name)) for name in _names(type(record)) if name not in without]
    return {name: _plain_value(value) for name, value in named if value is not None}


@cache
def _names(kind: "type[DataclassInstance]") -> tuple[str, ...]:
    return tuple(field.name for field in fields(kind) if field.compare)


def _plain_value(value: object) -> object:
    if isinstance(value, SCALARS):
        return value
    if isinstance(value, tuple):
        return [_plain_value(item) for item in value]
    if isinstance(value, Mapping):
        return {key: _plain_value(item) for key, item in value.items()}
    return _plain(value) if is_dataclass(value) and not isinstance(value, type) else value


def canonical_text(snapshot: Snapshot) -> str:
    """Return the ASCII text of a golden file, with one line for each brick and event so that a diff is readable."""
    rest = _plain(snapshot, without=("identity", "events", "bricks"))
    head = {"format": FORMAT, **_plain(snapshot.identity), **rest}
    lines = [f"  {_json(key)}: {_json(value)}" for key, value in head.items()]
    events = [_event_text(_plain(event)) for event in snapshot.events]
    bricks = [f"    {_json(brick)}: {_json(_plain(final))}" for brick, final in snapshot.bricks.items()]
    lines.append('  "events": ' + _block("[]", events, "  "))
    lines.append('  "bricks": ' + _block("{}", bricks, "  "))
    return _block("{}", lines, "") + "\n"


def _event_text(event: Mapping[str, object]) -> str:
    """Return the text of an event, with a line for each brick that it places."""
    if not isinstance(placed := event.get("placed"), Mapping):
        return f"    {_json(event)}"
    head = {key: value for key, value in event.items() if key != "placed"}
    bricks = [f"      {_json(brick)}: {_json(detail)}" for brick, detail in placed.items()]
    return f'    {_json(head)[:-1]}, "placed": ' + _block("{}", bricks, "    ") + "}"


def _block(brackets: str, lines: Sequence[str], indent: str) -> str:
    """Return lines within brackets, or empty brackets."""
    return f"{brackets[0]}\n" + ",\n".join(lines) + f"\n{indent}{brackets[1]}" if lines else brackets


def _json(value: object) -> str:
    return ENCODER.encode(value)


# Allowed keys of a golden file: an unknown or misspelt key would not be compared.


WHOLE = {"format", *(field.name for field in fields(Identity)), *(field.name for field in fields(Snapshot))}


def check_keys(whole: Mapping[str, object]) -> None:
    """Raise MalformedSnapshotError if the JSON value of a golden file holds a key that no snapshot has."""
    _check("the file", whole, WHOLE - {"identity"})
    world = whole.get("world")
    _check("the world", world, _field_names(GoldenScene))
    _check_each(_values(_at(world, "planes")), _field_names(FixedPlane))
    _check("the collapse", whole.get("collapse"), _field_names(FirstCollapse))
    _check("the samples", whole.get("samples"), _field_names(Samples))
    _check_each(_values(whole.get("bricks")), _field_names(FinalBrick))
    events = whole.get("events")
    for event in events if isinstance(events, list) else ():
        _check("an event", event, _field_names(Placing) | _field_names(Removing) | _field_names(Pushing))
        _check_each(_values(_at(event, "placed")), _field_names(RecordedBrick))


def _field_names(*kinds: type) -> set[str]:
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


# Unclear observations, which are too close to a limit to be certain, and their possible values.
#
# An unclear observation agrees with any value that a run can have there. Any other value is an editing mistake.


LARGEST = 1e300  # largest magnitude that is compared as a number

IsValue: TypeAlias = Callable[[object], bool]  # whether a JSON value is one that an observation may have


def is_excused(expected: object, got: object, unclear: IsValue | None) -> bool:
    """Return whether one value is unclear and the other is a possible value of that observation."""
    if unclear is None or UNCLEAR not in (expected, got):
        return False
    return unclear(got if expected == UNCLEAR else expected)


def is_undecided_state(value: object) -> bool:
    return isinstance(value, str) and value in {state.value for state in BrickState} - NO_PART


def is_name_or_none(value: object) -> bool:
    return value is None or isinstance(value, str)


def is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < LARGEST


def is_number(value: object) -> TypeGuard[float]:
    # The bound keeps out NaN, infinities, and integers too large to become floats.
    return isinstance(value, int | float) and not isinstance(value, bool) and -LARGEST < value < LARGEST


# Names of golden files, such as `tower/step-10mm.exact.json`, which shells, git and Windows accept unchanged.
#
# The identity can be read back from a name. A name from which it cannot, such as one with capitals, which some file
# systems do not distinguish, gets a digest; so does a name that ends as if it had one. So no two identities share a
# file, and a name does not depend on the other variants.


LONGEST_PART: Final = 60  # characters of each part of a name: disks that encrypt take 143
DIGEST: Final = 10  # hexadecimal digits, where a name is not unique
ENDS_IN_DIGEST: Final = re.compile(rf".*-[0-9a-f]{{{DIGEST}}}")
DEVICES: Final = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?")  # reserved names of Windows
GOLDEN_NAME: Final = re.compile(r"(?:[a-z0-9][a-z0-9._-]*\.)?(?:exact|thesis|tuned|stock|modified)\.json")
_CHOICE: Final = re.compile(r"([a-z][a-z0-9_]*)-(.*?)(?:_(?=[a-z][a-z0-9_]*-)|$)")


@cache
def golden_name(identity: Identity) -> str:
    """Return the name of the golden file of an identity, relative to the directory of golden files."""
    chosen = identity.variant.removesuffix(identity.system).removesuffix(",")
    parts = [_variant(chosen)] if chosen else []
    parts += [_plain_name(identity.system)] if identity.system else []
    return f"{_plain_name(identity.scenario)}/{'.'.join(parts) or _with_digest('', '')}.json"


def directory_of(file: Path) -> Path:
    """Return the directory of golden files that contains a file of this name."""
    return file.parent.parent


def _variant(chosen: str) -> str:
    slug = chosen.replace("/", "-per-").replace("%", "pct").replace("=", "-").replace(",", "_")
    choices = [f"{name}={_value(value)}" for name, value in _CHOICE.findall(slug)]
    return slug if ",".join(choices) == chosen and _is_plain(slug) else _with_digest(slug, chosen)


def _value(slug: str) -> str:
    return re.sub(r"(?<=[0-9])pct$", "%", slug.replace("-per-", "/"))


def _plain_name(name: str) -> str:
    return name if _is_plain(name) and "." not in name else _with_digest(name, name)


def _is_plain(slug: str) -> bool:
    plain = re.fullmatch(r"[a-z0-9](?:[a-z0-9._-]*[a-z0-9])?", slug) is not None
    taken = DEVICES.fullmatch(slug) or ENDS_IN_DIGEST.fullmatch(slug)
    return plain and len(slug) <= LONGEST_PART and not taken


def _with_digest(slug: str, meant: str) -> str:
    digest = sha256(_bytes(meant)).hexdigest()[:DIGEST]
    kept = re.sub(r"[^a-z0-9]+", "-", slug.casefold())[: LONGEST_PART - DIGEST - 1].strip("-")
    return f"{kept or 'x'}-{digest}"


def _bytes(text: str) -> bytes:
    return text.encode("utf-8", errors="surrogatepass")
