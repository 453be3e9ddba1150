"""Golden files in pytest, through syrupy: the same files, comparison and bytes as those of `stackdsl check`.

Not registered by itself: a conftest.py says `pytest_plugins = ["stackdsl.pytest_plugin"]`, a test says
`assert snapshot == golden(snapshot.identity)`, and `pytest --snapshot-update` writes. The ini option `golden_directory`
names the directory. Files that belong to no test are left alone: `stackdsl check` knows which are obsolete.
"""

import json
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion
from syrupy.data import SnapshotCollection, SnapshotCollections
from syrupy.extensions.json import JSONSnapshotExtension
from syrupy.location import PyTestLocation
from syrupy.types import PropertyFilter, PropertyMatcher, SerializableData, SerializedData, SnapshotIndex

from stackdsl.outcome import GoldenStatus
from stackdsl.snapshots.canonical import canonical_text
from stackdsl.snapshots.golden import golden_name, judge_text, refuse_in_ci, write_golden
from stackdsl.snapshots.record import Identity, Snapshot

Golden = Callable[[Identity], SnapshotAssertion]


class OtherEngineWarning(UserWarning):
    """A golden file was made with another engine than this run, so that not all of it could be compared."""


class GoldenExtension(JSONSnapshotExtension):
    """Keeps snapshots of stackdsl where and how `stackdsl check` does; the index of an assertion is its file name."""

    def serialize(
        self,
        data: SerializableData,
        *,
        exclude: PropertyFilter | None = None,
        include: PropertyFilter | None = None,
        matcher: PropertyMatcher | None = None,
    ) -> SerializedData:
        if not isinstance(data, Snapshot):
            raise TypeError(f"a golden file holds a stackdsl Snapshot, not a {type(data).__name__}")
        return canonical_text(data)

    def matches(self, *, serialized_data: SerializableData, snapshot_data: SerializableData) -> bool:
        result = judge_text("", snapshot_data, json.loads(serialized_data))
        if result.status is GoldenStatus.OTHER_ENGINE:
            warnings.warn(OtherEngineWarning(f"compared in what no engine decides: {result.note}"), stacklevel=2)
        return result.status in (GoldenStatus.SAME, GoldenStatus.OTHER_ENGINE)

    def diff_lines(self, serialized_data: SerializedData, snapshot_data: SerializedData) -> Iterator[str]:
        """One line a difference, instead of syrupy's line-by-line diff."""
        if not snapshot_data:
            yield "write it with: pytest --snapshot-update"
            return
        result = judge_text("", str(snapshot_data), json.loads(serialized_data))
        yield from filter(None, [result.note])
        for one in result.differences:
            yield f"{one.subject}: {one.quantity}: expected {one.expected}, got {one.got} (tolerance {one.tolerance})"

    def discover_snapshots(
        self, *, test_location: PyTestLocation, ignore_extensions: list[str] | None = None
    ) -> SnapshotCollections:
        """None: a golden file that this session does not read is not for it to report, let alone to delete."""
        return SnapshotCollections()

    @classmethod
    def dirname(cls, *, test_location: PyTestLocation) -> str:
        config = test_location.item.config
        return str(config.rootpath / config.getini("golden_directory"))

    @classmethod
    def get_location(cls, *, test_location: PyTestLocation, index: SnapshotIndex) -> str:
        return str(Path(cls.dirname(test_location=test_location)) / str(index))

    @classmethod
    def matches_test_location(cls, *, test_location: PyTestLocation, snapshot_location: str) -> bool:
        return True

    def read_snapshot_data_from_location(
        self, *, snapshot_location: str, snapshot_name: str, session_id: str
    ) -> SerializableData | None:
        # Whatever cannot be decoded makes no JSON either, and is then told as unreadable.
        with suppress(FileNotFoundError):
            return Path(snapshot_location).read_text(encoding="utf-8", errors="replace")
        return None

    @classmethod
    def write_snapshot_collection(
        cls, *, snapshot_collection: SnapshotCollection, name_order: dict[str, int] | None = None
    ) -> None:
        refuse_in_ci(os.environ)
        for snapshot in snapshot_collection:
            write_golden(Path(snapshot_collection.location), str(snapshot.data))


def pytest_addoption(parser: pytest.Parser) -> None:
    """Where golden files are."""
    parser.addini("golden_directory", "directory of golden files, relative to the root directory", default="golden")


@pytest.fixture
def golden(snapshot: SnapshotAssertion) -> Golden:
    """Gives what a snapshot of an identity is compared with; the module's docstring shows a test."""
    return lambda identity: snapshot.use_extension(GoldenExtension)(name=golden_name(identity))
