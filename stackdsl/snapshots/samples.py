"""Counts of samples -> snapshot, and how two such differ."""

from collections.abc import Iterator, Mapping

from stackdsl.ensemble import Ensemble
from stackdsl.outcome import GoldenDifference
from stackdsl.snapshots.record import Identity, MalformedSnapshotError, Samples, Snapshot
from stackdsl.snapshots.snapshot import scene_of
from stackdsl.timeline import World

VERDICT = "samples"  # in place of that of one run
COUNTS = ("seed", "drawn", "stood", "undecided", "unfit")
ABSENT = "none"


def snapshot_of_samples(ensemble: Ensemble, world: World, identity: Identity, stamp: Mapping[str, str]) -> Snapshot:
    """What is locked of many samples: how many there are, and what became of them."""
    fell = {str(level): count for level, count in sorted(ensemble.fell.items())}
    counts = (ensemble.seed, ensemble.drawn, ensemble.stood, fell, ensemble.undecided, ensemble.unfit)
    return Snapshot(
        identity=identity,
        stamp=dict(sorted(stamp.items())),
        world=scene_of(world),
        verdict=VERDICT,
        statics=None,
        collapse=None,
        height_mm=None,
        levels_standing=None,
        events=(),
        bricks={},
        samples=Samples(*counts),
    )


def differing_samples(expected: Mapping[str, object], got: Mapping[str, object]) -> Iterator[GoldenDifference]:
    """The counts of two documents that are not the same."""
    was, now = _object(expected, "samples"), _object(got, "samples")
    for key in COUNTS:
        yield from _differing(key, was.get(key), now.get(key))
    before, after = _object(was, "fell"), _object(now, "fell")
    for level in sorted({*before, *after}, key=lambda level: (len(level), level)):
        yield from _differing(f"fell at level {level}", before.get(level), after.get(level))


def _differing(what: str, expected: object, got: object) -> Iterator[GoldenDifference]:
    if expected != got or isinstance(expected, bool):
        was, now = (ABSENT if value is None else str(value) for value in (expected, got))
        yield GoldenDifference("samples", what, was, now, tolerance="exact")


def _object(holder: Mapping[str, object], key: str) -> Mapping[str, object]:
    value = holder.get(key, {})
    if not isinstance(value, dict):
        raise MalformedSnapshotError(f"{key!r} is not an object")
    return value
