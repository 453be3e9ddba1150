"""The map of the house: every package, told by the first line of its docstring. <!-- rooms: stability --> shows it."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
ROOMS = re.compile(r"(<!-- rooms: (?P<package>[a-z]+) -->\n)(?:\|[^\n]*\n)*(<!-- end -->)")


def with_rooms(text: str) -> str:
    """A text, with the rooms of each package that it asks for as they are now."""
    return ROOMS.sub(lambda found: f"{found[1]}{rooms_table(found['package'])}{found[3]}", text)


def rooms_table(package: str) -> str:
    """All packages below one, as a table."""
    lines = [f"| `{name}/` | {told} |\n" for name, told in rooms(package)]
    return "| package | content |\n|---|---|\n" + "".join(lines)


def rooms(package: str) -> Iterator[tuple[str, str]]:
    """Each package below one, by path, and what it says of itself."""
    for path in sorted((ROOT / package).rglob("__init__.py")):
        if path.parent != ROOT / package:
            told = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
            yield (
                path.parent.relative_to(ROOT).as_posix(),
                " ".join(told.split("\n\n")[0].split()).replace("|", "&#124;"),
            )
