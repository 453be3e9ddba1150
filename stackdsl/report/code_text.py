"""What a code of a diagnostic means, as `diagnostics.md` says it: meaning, an example that gives it, and the remedy."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Final

CODE: Final = re.compile(r"SD\d{3}")

_ENTRY = re.compile(r"^## (?P<code>SD\d{3}): (?P<title>.+)\n(?P<body>(?:(?!^## ).*\n)*)", re.MULTILINE)
_EXAMPLE = re.compile(r"(?:<!-- .*? -->\n)?```yaml\n(?P<text>.*?)```\n", re.DOTALL)
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
_INDENT = "    "


@dataclass(frozen=True, slots=True)
class Entry:
    """What the page says of one code."""

    code: str
    title: str
    body: str  # Markdown

    @property
    def example(self) -> str | None:
        """A scenario that gives it; None where no short one does."""
        found = _EXAMPLE.search(self.body)
        return found["text"] if found else None


def entries() -> Mapping[str, Entry]:
    """All codes of the page, in its order."""
    page = files("stackdsl").joinpath("diagnostics.md").read_text(encoding="utf-8")
    return {found["code"]: Entry(found["code"], found["title"], found["body"].strip()) for found in _each(page)}


def _each(page: str) -> Iterator[re.Match[str]]:
    return _ENTRY.finditer(page if page.endswith("\n") else f"{page}\n")


def code_text(entry: Entry) -> str:
    """An entry for a terminal: without the marks of Markdown, and with its example set in."""
    plain = _EXAMPLE.sub(lambda found: _set_in(found["text"]), entry.body)
    plain = _LINK.sub(r"\1", plain).replace("**", "")
    return f"{entry.code}: {entry.title}\n\n{plain}\n"


def _set_in(text: str) -> str:
    return "".join(f"{_INDENT}{line}\n" if line else "\n" for line in text.splitlines())
