"""Pages with figures, and their rendering in place."""

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from benchmarks.figures.data import load
from benchmarks.figures.markdown import rendered

ROOT = Path(__file__).parent.parent.parent
# Measurements of a certain day, which are not updated.
RECORDS = ("docs/design", "docs/measurements")


def pages() -> Iterator[Path]:
    """Yield README and every page of docs with current figures."""
    found = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return (path for path in found if path.exists() and not is_record(path))


def is_record(path: Path) -> bool:
    """Return whether a page records the measurements of a certain day, without updates."""
    return any(path.is_relative_to(ROOT / folder) for folder in RECORDS)


def render() -> list[Path]:
    """Render every page with changed figures; return these pages."""
    changed = []
    fresh = lru_cache(load)
    for path in pages():
        before = path.read_text(encoding="utf-8")
        after = rendered(before, fresh)
        if after != before:
            path.write_text(after, encoding="utf-8")
            changed.append(path)
    return changed
