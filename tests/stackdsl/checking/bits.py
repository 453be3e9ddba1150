"""All that a timeline or a trace tells, to the last bit, and what the golden file of a run would be."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import TypeAlias

from stackdsl.checking.cases import Case, gather
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import snapshot_of
from stackdsl.goldens.file_format import canonical_text
from stackdsl.judging.judge import stop_condition_of
from stackdsl.timeline import Timeline
from stackdsl.trace import Trace

Bits: TypeAlias = Mapping[str, str]  # values by where they are, such as `.tracks[shot].final.position_W[2]`
WALL_TIMES = (
    ".cost.wall_time",
    ".cost.updates.median",
    ".cost.updates.worst",
    ".statics.seconds",
    ".disproof.seconds",
)  # all in a trace that no physics decides


def bits_of(value: Trace | Timeline) -> dict[str, str]:
    """Every part of it but wall times, numbers by their bits; the order of mappings counts as well."""
    return {place: text for place, text in _told(value, "") if place not in WALL_TIMES}


def _told(value: object, place: str) -> Iterator[tuple[str, str]]:
    if is_dataclass(value):
        for field in fields(value):
            yield from _told(getattr(value, field.name), f"{place}.{field.name}")
    elif isinstance(value, Mapping):
        yield f"{place} has", repr(list(value))
        for key, inner in value.items():
            yield from _told(inner, f"{place}[{key}]")
    elif isinstance(value, tuple):
        yield f"{place} has", str(len(value))
        for index, inner in enumerate(value):
            yield from _told(inner, f"{place}[{index}]")
    else:
        yield place, value.hex() if isinstance(value, float) else repr(value)


def with_golden(case: Case, trace: Trace) -> dict[str, str]:
    """The bits of a trace, and the text of its golden file."""
    return bits_of(trace) | {"golden": canonical_text(snapshot_of(case, trace))}


def played(cases: Iterable[Case]) -> Iterator[tuple[str, Bits]]:
    """One after the other in this process: the name of each, and its bits."""
    for case in cases:
        yield (
            case.name,
            with_golden(case, play_case(case.timeline, case.system, stop_condition_of(case.scenario, case.system))),
        )


def compiled_under(folder: Path) -> dict[str, Bits]:
    """All that is to happen in the cases of a folder, as they are read and compiled here."""
    return {case.name: bits_of(case.timeline) for case in gather([folder]).cases}


def differences(one: Bits, other: Bits) -> dict[str, tuple[str | None, str | None]]:
    """Where two runs differ, and how."""
    places = [*one, *(place for place in other if place not in one)]
    return {place: (one.get(place), other.get(place)) for place in places if one.get(place) != other.get(place)}
