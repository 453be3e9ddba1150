"""The pages that hold figures, and their rendering in place."""

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from benchmarks.figures.data import load
from benchmarks.figures.markdown import rendered

ROOT = Path(__file__).parent.parent.parent
# What was measured on one day stays as it was then.
RECORDS = ("docs/design", "docs/measurements")


def pages() -> Iterator[Path]:
    """README, and every page of docs whose figures are to be those of today."""
    found = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return (path for path in found if path.exists() and not is_record(path))


def is_record(path: Path) -> bool:
    """Whether a page tells what was measured on one day, and is not measured again."""
    return any(path.is_relative_to(ROOT / folder) for folder in RECORDS)


def render() -> list[Path]:
    """Write every page anew whose figures have changed; which they were."""
    changed = []
    fresh = lru_cache(load)
    for path in pages():
        before = path.read_text(encoding="utf-8")
        after = rendered(before, fresh)
        if after != before:
            path.write_text(after, encoding="utf-8")
            changed.append(path)
    return changed
