"""The pages of README and docs, and the blocks of code that stand in them."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from tests.paths import ROOT

BLOCK = re.compile(r"(?:<!-- (?P<mark>(?:(?!-->).)*?)\s*-->\n)?```(?P<language>\w+)\n(?P<text>.*?)```", re.DOTALL)
HAS_PYBULLET = find_spec("pybullet") is not None
NO_PYBULLET = "it shows what PyBullet does, which has no wheel for this Python"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


@dataclass(frozen=True, slots=True)
class Block:
    """A block of code, and what the comment right before it says of it."""

    page: Path
    number: int  # of the block in its page
    language: str
    text: str
    mark: str

    @property
    def name(self) -> str:
        """For the list of tests."""
        return f"{self.page.relative_to(ROOT)}:{self.number}"

    def marked(self, word: str) -> str | None:
        """What the comment says after a word and a colon; None if it does not begin with that."""
        return self.mark.removeprefix(f"{word}:").strip() if self.mark.startswith(f"{word}:") else None


def blocks(page: Path) -> Iterator[Block]:
    """In the order in which they stand."""
    for number, found in enumerate(BLOCK.finditer(page.read_text(encoding="utf-8")), start=1):
        yield Block(page, number, found["language"], found["text"], (found["mark"] or "").strip())


def all_blocks(language: str) -> list[Block]:
    """Those of all pages in a language."""
    return [block for page in PAGES for block in blocks(page) if block.language == language]
