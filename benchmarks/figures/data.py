"""Results of a benchmark, as JSON in docs/data: rows of raw values, with the command, the date and the versions.

A key ends with the unit of its values (`drift_mm`), unless they are counts, ratios or words. Of the machine only the
number of cores is stored, since seconds mean nothing on another one: the texts quote ratios.
"""

import json
import os
import platform
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from math import isfinite
from pathlib import Path
from typing import TypeAlias

FOLDER = Path(__file__).parent.parent.parent / "docs" / "data"
PACKAGES = ("stackdsl", "clarabel", "numpy", "pybullet", "scipy", "mujoco", "sapien", "compas_cra", "compas_lmgc90")
DIGITS = 5  # stored significant digits: more than any text shows

Value: TypeAlias = float | int | str | bool | None  # None if there is nothing to measure
Row: TypeAlias = Mapping[str, Value]
Rows: TypeAlias = Mapping[str, Row]  # by name, in the order of measuring


@dataclass(frozen=True, slots=True)
class Data:
    """One file: tables by name."""

    name: str
    command: str  # that repeats the measurement
    tables: Mapping[str, Rows]
    day: str = ""  # of the measurement, as 2026-01-31
    versions: Mapping[str, str] = field(default_factory=dict)
    cores: int | None = None

    def value(self, table: str, row: str, key: str) -> Value:
        """Return one value. Raises KeyError with the existing keys."""
        try:
            return self.tables[table][row][key]
        except KeyError as error:
            where = f"{self.name}/{table}/{row}/{key}"
            raise KeyError(f"{where}: there is no {error} in docs/data/{self.name}.json") from error


def versions(distributions: Iterable[str] = ()) -> dict[str, str]:
    """Return the versions of Python, and of all installed distributions of PACKAGES and the given ones."""
    found = {"python": platform.python_version()}
    for name in (*PACKAGES, *distributions):
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def measured_now(name: str, command: str, tables: Mapping[str, Rows]) -> Data:
    """Return data measured on this machine now."""
    return Data(name, command, tables, datetime.now(UTC).date().isoformat(), versions(), os.cpu_count())


def file_of(name: str, folder: Path = FOLDER) -> Path:
    """Return the path of a benchmark's data."""
    return folder / f"{name}.json"


def save(data: Data, folder: Path = FOLDER) -> Path:
    """Write data with one row per line, so that a diff shows the changed rows."""
    folder.mkdir(parents=True, exist_ok=True)
    path = file_of(data.name, folder)
    path.write_text(_text(data), encoding="utf-8")
    return path


def _text(data: Data) -> str:
    head = {"command": data.command, "measured": data.day, "cores": data.cores, "versions": dict(data.versions)}
    lines = [f" {json.dumps(key)}: {json.dumps(value)}," for key, value in head.items()]
    tables = [_table_text(name, rows) for name, rows in data.tables.items()]
    return "\n".join(["{", *lines, ' "tables": {', ",\n".join(tables), " }", "}"]) + "\n"


def _table_text(name: str, rows: Rows) -> str:
    lines = [f"   {_json(row)}: {_json(_rounded(values))}" for row, values in rows.items()]
    return f"  {json.dumps(name)}: {{\n" + ",\n".join(lines) + "\n  }"


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


def _rounded(values: Row) -> Row:
    return {key: _rounded_value(value) for key, value in values.items()}


def _rounded_value(value: Value) -> Value:
    if not isinstance(value, float):
        return value
    return float(f"{value:.{DIGITS}g}") if isfinite(value) else None


def load(name: str, folder: Path = FOLDER) -> Data:
    """Return the latest data of a benchmark."""
    read = json.loads(file_of(name, folder).read_text(encoding="utf-8"))
    return Data(name, read["command"], read["tables"], read["measured"], read["versions"], read["cores"])
