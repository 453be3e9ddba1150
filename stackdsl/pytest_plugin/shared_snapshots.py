"""Golden files for tests in Python, through syrupy: the same files, comparison and bytes as in `stackdsl check`.

Files without a test are neither reported nor removed; `stackdsl check` reports obsolete files.
"""

import json
import os
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import ClassVar

from syrupy.assertion import SnapshotAssertion
from syrupy.data import SnapshotCollection, SnapshotCollections
from syrupy.extensions.json import JSONSnapshotExtension
from syrupy.location import PyTestLocation
from syrupy.types import PropertyFilter, PropertyMatcher, SerializableData, SerializedData, SnapshotIndex

from stackdsl.goldens.file_format import canonical_text, directory_of, golden_name
from stackdsl.goldens.golden import content_of, judge_text, refuse_in_ci, write_golden
from stackdsl.goldens.snapshot import Identity, Snapshot
from stackdsl.pytest_plugin.golden_directory import golden_directory
from stackdsl.pytest_plugin.scenario_warnings import ENGINE_INDEPENDENT, OtherEngineWarning
from stackdsl.results import GoldenStatus

Golden = Callable[[Identity], SnapshotAssertion]


class GoldenExtension(JSONSnapshotExtension):
    """Stores snapshots in the golden files of `stackdsl check`; the index of an assertion is the file name."""

    keeper: ClassVar[str] = ""  # owner that written files name, see `stackdsl.goldens.golden`

    def serialize(
        self,
        data: SerializableData,
        *,
        exclude: PropertyFilter | None = None,
        include: PropertyFilter | None = None,
        matcher: PropertyMatcher | None = None,
    ) -> SerializedData:
        if not isinstance(data, Snapshot):
            raise TypeError(f"a golden file needs a Snapshot of stackdsl, not {type(data).__name__}")
        return canonical_text(replace(data, kept_by=self.keeper or None))

    def matches(self, *, serialized_data: SerializableData, snapshot_data: SerializableData) -> bool:
        result = judge_text("", snapshot_data, json.loads(serialized_data))
        if result.status is GoldenStatus.OTHER_ENGINE:
            warnings.warn(OtherEngineWarning(f"{ENGINE_INDEPENDENT}: {result.note}"), stacklevel=2)
        return result.status in (GoldenStatus.SAME, GoldenStatus.OTHER_ENGINE)

    def diff_lines(self, serialized_data: SerializedData, snapshot_data: SerializedData) -> Iterator[str]:
        """Yield one line per difference, instead of the line-by-line diff of syrupy."""
        if not snapshot_data:
            yield "there is no golden file; write it with: pytest --snapshot-update"
            return
        result = judge_text("", str(snapshot_data), json.loads(serialized_data))
        yield from filter(None, [result.note])
        for each in result.differences:
            values = f"expected {each.expected}, got {each.got} (tolerance {each.tolerance})"
            yield f"{each.subject}: {each.quantity}: {values}"

    def discover_snapshots(
        self, *, test_location: PyTestLocation, ignore_extensions: list[str] | None = None
    ) -> SnapshotCollections:
        """Return none, so that syrupy neither reports nor deletes golden files that this session does not read."""
        return SnapshotCollections()

    @classmethod
    def dirname(cls, *, test_location: PyTestLocation) -> str:
        return str(golden_directory(test_location.item.config, test_location.item.path))

    @classmethod
    def get_location(cls, *, test_location: PyTestLocation, index: SnapshotIndex) -> str:
        return str(Path(cls.dirname(test_location=test_location)) / str(index))

    @classmethod
    def matches_test_location(cls, *, test_location: PyTestLocation, snapshot_location: str) -> bool:
        return True

    def read_snapshot_data_from_location(
        self, *, snapshot_location: str, snapshot_name: str, session_id: str
    ) -> SerializableData | None:
        # Invalid UTF-8 is also invalid JSON, which is reported as unreadable.
        content = content_of(snapshot_location)
        if isinstance(content, bytes):
            return content.decode("utf-8", "replace")
        return None if content.status is GoldenStatus.MISSING else content.note

    @classmethod
    def write_snapshot_collection(
        cls, *, snapshot_collection: SnapshotCollection, name_order: dict[str, int] | None = None
    ) -> None:
        refuse_in_ci(os.environ)
        for snapshot in snapshot_collection:
            file = Path(snapshot_collection.location)
            write_golden(file, str(snapshot.data), directory_of(file))


@cache
def _kept_by(keeper: str) -> type[GoldenExtension]:
    """Return an extension that writes this owner into files; it is a class, since syrupy creates the instances."""
    return type("GoldenExtension", (GoldenExtension,), {"keeper": keeper})


def compare_with_golden(snapshot: SnapshotAssertion, directory: Path, keeper: str) -> Golden:
    """Return a function from an identity to the assertion on its golden file.

    `keeper` is the owner that a written file names.
    """

    def golden(identity: Identity) -> SnapshotAssertion:
        return snapshot.use_extension(_kept_by(keeper))(name=golden_name(identity))

    return golden
