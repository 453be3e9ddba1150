"""Scenarios that are made of what cannot be read here, and that say so: `skip: {reason: ..., without: mujoco}`."""

from dataclasses import replace
from typing import Final, get_args

from stackdsl.language.marks import Package, is_installed
from stackdsl.reading.source import Plain, Source

_TOLD: Final = ("scenario", "description", "tags", "systems", "let", "matrix", "cases", "exclude", "skip")
_ANYTHING: Final[dict[str, Plain]] = {"brick": "kapla", "build": [{"column": {"levels": 1}}]}


def told_only(source: Source) -> Source | None:
    """What can be told of a scenario that is not played without a package which is not here; None of all others.

    What it builds is left out, since reading that may take the package.
    """
    skip = source.values.get("skip")
    package = skip.get("without") if isinstance(skip, dict) else None
    if not isinstance(package, str) or package not in get_args(Package) or is_installed(package):
        return None
    values: dict[str, Plain] = {key: source.values[key] for key in _TOLD if key in source.values}
    return replace(source, values=values | _ANYTHING)
